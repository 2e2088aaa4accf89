/* SPDX-License-Identifier: MIT
 *
 * Weight against statics: force m g, torque arm x m g wherever the object is held and however it is turned;
 * and in the servo the same wrench whatever the coupling, in the device's frame.
 */
#include "lone_stage.h"
#include "servo_bench.h"

static void check_torque(void)
{
    static const double axis[3] = {2.0 / 3, -1.0 / 3, 2.0 / 3}, g[3] = {1, -9, 0.5},
                        com[3] = {0.01, 0.02, -0.03}, tip[3] = {-0.04, 0.005, 0.1};
    for (int n = 0; n <= 20; n++) {
        lone_stage l;
        vxs_effect *e = lone_prepare(&l, VXS_EFFECT_GRAVITY);
        e->as.gravity.mass = 0.3;
        memcpy(e->as.gravity.com, com, sizeof com);
        memcpy(e->as.gravity.acceleration, g, sizeof g);
        for (int i = 0; i < 3; i++) l.config.grip.position[i] = -tip[i];
        lone_open(&l);
        vxs_pose pose = {{0.5, -3, 7}, {1, 0, 0, 0}};
        const double angle = 0.3 * n, c = cos(angle), s = sin(angle);
        lone_turn(pose.orientation, axis, angle);
        lone_tick(&l, &pose, NULL);
        lone_run(&l);
        CHECK(l.tick.has_field);
        /* Rodrigues: arm c + (axis x arm) s + axis (axis . arm) (1 - c) */
        const double a[3] = {com[0] - tip[0], com[1] - tip[1], com[2] - tip[2]},
                     along = axis[0] * a[0] + axis[1] * a[1] + axis[2] * a[2];
        double arm[3];
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            arm[i] = a[i] * c + (axis[j] * a[k] - axis[k] * a[j]) * s + axis[i] * along * (1 - c);
        }
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            CHECK_NEAR(l.tick.field.force[i], 0.3 * g[i], 1e-15);
            CHECK_NEAR(l.tick.field.torque[i], 0.3 * (arm[j] * g[k] - arm[k] * g[j]), 1e-15);
            CHECK(l.tick.wrench.force[i] == 0 && l.tick.wrench.torque[i] == 0);
        }
    }
}

/* Above the floor, the device's frame turned: what is commanded is weight and nothing else. */
static void check_servo(void)
{
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_QUASI_STATIC; kind++) {
        servo_bench b;
        vxs_servo_trace row;
        bench_prepare(&b);
        b.servo_config.coupling.kind = kind;
        b.servo_config.coupling.omega0 *= 10;
        b.servo_config.coupling.radius = 1; /* spring-damper: the body hardly turns by it */
        b.device_config.profile.peak_torque = 0;
        b.servo_config.grip.position[2] = 0.05; /* held 50 mm away from the middle */
        b.servo_config.mount.orientation[0] = b.servo_config.mount.orientation[3] = sqrt(0.5); /* x to y */
        b.servo_config.mount.position[1] = 0.2;
        bench_effect(&b, VXS_EFFECT_GRAVITY)->as.gravity.mass = 0.2;
        bench_open(&b);
        CHECK(bench_tick(&b, 0.012, &row) & VXS_SERVO_OFF);
        CHECK(row.command.force[0] == 0 && row.command.torque[2] == 0); /* not armed */
        CHECK_INT(vxs_device_arm(b.device), VXS_OK);
        for (int k = 0; k < 2000; k++) CHECK_INT(bench_tick(&b, 0.012, &row) & VXS_SERVO_FAULT, 0);
        const double weight = 0.2 * 9.80665;
        CHECK_NEAR(row.output.force[1], -weight, 1e-6);
        CHECK_NEAR(row.command.force[0], -weight, 1e-6); /* the scene's y is the device's x */
        CHECK_NEAR(row.command.force[1], 0, 1e-6);
        CHECK_NEAR(row.output.torque[0], 0.05 * weight, 1e-6); /* z 50 mm cross -y */
        CHECK_NEAR(row.collision.force[1], 0, 0);
        bench_close(&b);
    }
}

int main(void)
{
    check_torque();
    check_servo();
    return 0;
}
