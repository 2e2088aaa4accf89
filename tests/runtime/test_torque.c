/* SPDX-License-Identifier: MIT
 *
 * Torque where it is asked for and only there: without it the command's torque is 0 and every force the same
 * to the last bit, for each coupling.
 */
#include "servo_bench.h"

static void check_coupling(uint32_t kind)
{
    servo_bench b[2];
    vxs_servo_trace row[2];
    for (int n = 0; n < 2; n++) {
        bench_prepare(&b[n]);
        b[n].servo_config.coupling.kind = kind;
        b[n].servo_config.coupling.omega0 *= 10;
        b[n].servo_config.grip.position[0] = 0.01; /* contact turns the hand */
        b[n].servo_config.mount.orientation[2] = 0.2;
        b[n].servo_config.max_force = 1;
        b[n].servo_config.max_torque = 0.004;
        b[n].has_no_torque = n == 0;
        bench_effect(&b[n], VXS_EFFECT_SOFT_START);
        bench_effect(&b[n], VXS_EFFECT_SLEW);
        bench_effect(&b[n], VXS_EFFECT_GRAVITY);
        bench_effect(&b[n], VXS_EFFECT_PASSIVITY)->as.passivity.radius = 0;
        bench_open(&b[n]);
    }
    int touched = 0, clamped = 0;
    for (int k = 0; k < 2000; k++) {
        for (int n = 0; n < 2; n++) {
            vxs_device_state *state = &b[n].state;
            state->state = VXS_DEVICE_ARMED;
            state->pose = vxs_pose_identity();
            state->pose.position[1] = 0.012 - 3e-6 * (k < 1000 ? k : 2000 - k);
            state->pose.orientation[3] = 1e-5 * k;
            state->sequence++;
            state->time_ns += 1000000;
            CHECK_INT(vxs_servo_tick(b[n].servo, state, &b[n].command, &row[n]) & VXS_SERVO_FAULT, 0);
        }
        double torque = 0, size = 0;
        for (int i = 0; i < 3; i++) {
            CHECK(row[0].command.torque[i] == 0 && row[0].output.torque[i] == 0);
            torque += fabs(row[1].command.torque[i]);
            size += row[1].command.torque[i] * row[1].command.torque[i];
        }
        CHECK(size <= 0.004 * 0.004 * (1 + 1e-12));
        CHECK(memcmp(row[0].command.force, row[1].command.force, sizeof row[0].command.force) == 0);
        CHECK(memcmp(row[0].output.force, row[1].output.force, sizeof row[0].output.force) == 0);
        CHECK(memcmp(&row[0].collision, &row[1].collision, sizeof row[0].collision) == 0);
        touched += row[0].points > 0 && torque > 0;
        clamped += size > 0.0039 * 0.0039;
    }
    CHECK(touched > 300 && clamped > 100);
    for (int n = 0; n < 2; n++) bench_close(&b[n]);
}

/* By default it is there; passivity's radius says nothing without it. */
static void check_default(void)
{
    vxs_servo_config config;
    vxs_servo_config_default(&config);
    int found = 0;
    for (uint32_t n = 0; n < config.effect_count; n++) found += config.effects[n].kind == VXS_EFFECT_TORQUE;
    CHECK_INT(found, 1);

    servo_bench b[2];
    vxs_servo_trace row[2];
    for (int n = 0; n < 2; n++) {
        bench_prepare(&b[n]);
        b[n].servo_config.coupling.kind = VXS_COUPLING_NONE;
        b[n].servo_config.contact.stiffness = 1.6e9;
        b[n].has_no_torque = 1;
        bench_effect(&b[n], VXS_EFFECT_PASSIVITY)->as.passivity.radius = n ? 0.03 : 0;
        bench_open(&b[n]);
        CHECK_INT(vxs_device_arm(b[n].device), VXS_OK);
    }
    int damped = 0;
    for (int k = 0; k < 3000; k++) {
        for (int n = 0; n < 2; n++) {
            const double target[3] = {0, k < 1000 ? 0.012 - 3e-6 * k : 0.009, 0},
                         turn[4] = {1, 0, 0, 1e-4 * k};
            vxs_simulated_hand(b[n].device, target, turn);
            vxs_device_exchange(b[n].device, &b[n].command, &b[n].state, NULL);
            damped +=
                (vxs_servo_tick(b[n].servo, &b[n].state, &b[n].command, &row[n]) & VXS_SERVO_DAMPED) != 0;
        }
        CHECK(memcmp(&row[0], &row[1], sizeof row[0]) == 0);
        for (int i = 0; i < 3; i++) CHECK(row[1].command.torque[i] == 0);
    }
    CHECK(damped > 10);
    for (int n = 0; n < 2; n++) bench_close(&b[n]);
}

int main(void)
{
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_QUASI_STATIC; kind++) check_coupling(kind);
    check_default();
    return 0;
}
