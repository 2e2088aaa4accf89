/* SPDX-License-Identifier: MIT
 *
 * Walls around the tip: the formula, nothing inside, continuous, never energy; and where a hand that leans on
 * one comes to rest.
 */
#include "lone_stage.h"
#include "servo_bench.h"

static const double low[3] = {-0.02, 0, -0.03}, high[3] = {0.03, 0.05, 0.01};

static void open_box(lone_stage *l, double stiffness, double damping)
{
    vxs_effect *e = lone_prepare(l, VXS_EFFECT_WORKSPACE);
    memcpy(e->as.workspace.low, low, sizeof low);
    memcpy(e->as.workspace.high, high, sizeof high);
    e->as.workspace.stiffness = stiffness;
    e->as.workspace.damping = damping;
    lone_open(l);
}

static double next_random(uint32_t *state)
{
    *state ^= *state << 13, *state ^= *state >> 17, *state ^= *state << 5;
    return *state / 4294967296.0 - 0.5;
}

/* A walk in and out of all sides: the formula, and the damper only takes. */
static void check_walk(void)
{
    lone_stage l;
    const double stiffness = 800, damping = 3;
    open_box(&l, stiffness, damping);
    vxs_pose pose = vxs_pose_identity(), last = pose;
    uint32_t random = 7;
    int outside = 0, corners = 0, cut = 0;
    for (int k = 0; k < 200000; k++) {
        last = pose;
        for (int i = 0; i < 3; i++)
            pose.position[i] = 0.9995 * pose.position[i] + 0.003 * next_random(&random);
        lone_tick(&l, &pose, NULL);
        lone_run(&l);
        int sides = 0;
        double elastic = 0, work = 0;
        for (int i = 0; i < 3; i++) {
            double x = pose.position[i], v = (x - last.position[i]) / 0.001, wanted = 0;
            double d = x < low[i] ? low[i] - x : x > high[i] ? x - high[i] : 0, sign = x < low[i] ? 1 : -1;
            if (k == 0) v = 0;
            if (d > 0) {
                sides++;
                double force = stiffness * d - damping * sign * v * (d < 0.001 ? d / 0.001 : 1);
                cut += force < 0;
                wanted = sign * (force > 0 ? force : 0);
                elastic = sign * stiffness * d;
                work += (wanted - elastic) * v;
            }
            CHECK_NEAR(l.tick.field.force[i], wanted, 1e-9);
            CHECK(l.tick.field.torque[i] == 0);
        }
        CHECK(work <= 1e-12);
        CHECK_INT(l.tick.has_field, sides > 0);
        outside += sides > 0;
        corners += sides > 1;
    }
    CHECK(outside > 10000 && corners > 100 && cut > 100);
}

/* No jump where it begins, however fast. */
static void check_continuous(void)
{
    lone_stage l;
    for (int out = -1; out <= 1; out += 2) {
        open_box(&l, 800, 50);
        vxs_pose pose = vxs_pose_identity();
        pose.position[0] = high[0] + 1e-9 - out * 1e-3;
        lone_tick(&l, &pose, NULL);
        lone_run(&l);
        pose.position[0] = high[0] + 1e-9; /* at 1 m/s */
        lone_tick(&l, &pose, NULL);
        lone_run(&l);
        CHECK(l.tick.field.force[0] <= 0 && l.tick.field.force[0] > -1e-4);
    }
}

/* A hand wants 10 mm beyond: k_hand (10 mm - d) = k d, whatever the coupling, in the device's frame. */
static void check_rest(void)
{
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_QUASI_STATIC; kind++) {
        servo_bench b;
        vxs_servo_trace row;
        bench_prepare(&b);
        b.servo_config.coupling.kind = kind;
        b.servo_config.mount.position[1] = 0.2;
        b.device_config.profile.friction = b.device_config.profile.resolution = 0;
        vxs_effect *e = bench_effect(&b, VXS_EFFECT_WORKSPACE);
        e->as.workspace.high[1] = 0.25; /* the device's 0.05 */
        e->as.workspace.stiffness = 700;
        bench_open(&b);
        CHECK_INT(vxs_device_arm(b.device), VXS_OK);
        double highest = 0, force = 0;
        for (int k = 0; k < 4000; k++) {
            double target = 0.012 + 0.048 * (k < 1000 ? k / 1000.0 : 1);
            CHECK_INT(bench_tick(&b, target, &row) & VXS_SERVO_FAULT, 0);
            if (row.pose.position[1] <= 0.05 && kind != VXS_COUPLING_SPRING_DAMPER)
                CHECK(row.command.force[1] == 0);
            highest = fmax(highest, row.pose.position[1]);
            force = row.command.force[1];
        }
        const double hand = b.device_config.arm.stiffness, depth = hand * 0.01 / (hand + 700);
        CHECK_NEAR(row.pose.position[1], 0.05 + depth, 1e-6);
        CHECK_NEAR(force, -700 * depth, 1e-3);
        CHECK(highest < 0.05 + 1.1 * depth);
        CHECK_NEAR(row.command.force[0], 0, 1e-12);
        bench_close(&b);
    }
}

int main(void)
{
    check_walk();
    check_continuous();
    check_rest();
    lone_stage l;
    vxs_effect *e = lone_prepare(&l, VXS_EFFECT_WORKSPACE);
    e->as.workspace.low[1] = e->as.workspace.high[1];
    CHECK_INT(vxs_effect_check(e), VXS_PARAM);
    return 0;
}
