/* SPDX-License-Identifier: MIT
 *
 * The brake before contact: the formula over a plane, nothing beyond its reach, no jump between two walls,
 * never energy, the same bits however contact is culled, and relative to a static that moves.
 */
#include "servo_bench.h"
#include "servo_state.h"

static const double voxel = 0.001;

static double above_floor(const void *shape, const double p[3])
{
    (void)shape;
    return p[1];
}

/* Between y = 0 and y = the gap. */
static double in_slot(const void *shape, const double p[3])
{
    return fmin(p[1], *(const double *)shape - p[1]);
}

static void prepare(servo_bench *b, built_distance *distance, const void *shape, int64_t high)
{
    const int64_t low[3] = {-24, -6, -24}, top[3] = {24, high, 24};
    bench_prepare(b);
    built_free(&b->map_bytes);
    b->map_bytes = build_field_map(voxel, low, top, distance, shape, 7);
    b->map = open_voxmap(&b->map_bytes);
    b->servo_config.coupling.kind = VXS_COUPLING_NONE;
    b->servo_config.max_force = b->servo_config.max_torque = 1e9;
    vxs_effect *e = bench_effect(b, VXS_EFFECT_PROXIMITY);
    e->as.proximity.damping = 4;
    e->as.proximity.reach = 0.005;
}

static uint32_t tick_at(servo_bench *b, const vxs_pose *pose, vxs_servo_trace *row)
{
    b->state.state = VXS_DEVICE_ARMED;
    b->state.pose = *pose;
    b->state.sequence++;
    b->state.time_ns += 1000000;
    return vxs_servo_tick(b->servo, &b->state, &b->command, row);
}

static vxs_wrench felt(const vxs_servo_trace *row)
{
    vxs_wrench field = row->output;
    for (int i = 0; i < 3; i++) {
        field.force[i] -= row->collision.force[i];
        field.torque[i] -= row->collision.torque[i];
    }
    return field;
}

/* A ball comes down on a plane, and goes up again; it slides, which is no approach. */
static void check_formula(void)
{
    servo_bench b;
    vxs_servo_trace row;
    vxs_pose pose = vxs_pose_identity();
    prepare(&b, above_floor, NULL, 20);
    b.servo_config.grip.position[0] = 0.02; /* held 20 mm beside the middle */
    bench_open(&b);
    /* The shell's lowest point, as stored. */
    double lowest = 0;
    for (uint32_t n = 0; n < b.shell.point_count; n++)
        if ((double)b.shell.y[n] < lowest) lowest = (double)b.shell.y[n];
    const double steps[] = {-2e-5, -1e-4, 3e-5, -5e-5};
    double height = 0.0172;
    int braked = 0;
    pose.position[0] = -0.02;
    for (int k = 0; k < 3000; k++) {
        double step = steps[k / 200 % 4], gap = height + lowest;
        if (k == 0) step = 0;
        if (height + step < 0.01005 || height + step > 0.0175) step = 0;
        height += step;
        gap = height + lowest;
        pose.position[1] = height;
        pose.position[2] = 1e-6 * k;
        CHECK_INT(tick_at(&b, &pose, &row) & VXS_SERVO_FAULT, 0);
        double share = fmax(0, 1 - fabs(gap) / 0.005),
               wanted = step < 0 ? 4 * share * share * (-step / 0.001) : 0;
        const vxs_wrench force = felt(&row);
        CHECK_NEAR(force.force[1], wanted, 2e-3 * wanted + 1e-12); /* distances come in steps of h / 256 */
        CHECK_NEAR(force.force[0], 0, 1e-3 * wanted + 1e-12);
        CHECK_NEAR(force.torque[2], 0.02 * wanted, 0.02 * 0.05 * wanted + 1e-12);
        if (gap > 0.00501) CHECK(force.force[1] == 0 && row.output.force[1] == 0);
        braked += wanted > 0;
    }
    CHECK(braked > 300);
    bench_close(&b);
}

static double next_random(uint32_t *state)
{
    *state ^= *state << 13, *state ^= *state >> 17, *state ^= *state << 5;
    return *state / 4294967296.0 - 0.5;
}

/* Any motion between two walls: no energy; twice and without culling the same bits. */
static void check_passive(void)
{
    const double slot = 0.023;
    servo_bench b[2];
    vxs_servo_trace row[2];
    vxs_pose pose = vxs_pose_identity(), last;
    for (int n = 0; n < 2; n++) {
        prepare(&b[n], in_slot, &slot, 29);
        bench_open(&b[n]);
    }
    CHECK_INT(vxs_contact_cull(b[1].servo->contact, VXS_CONTACT_BRUTE), VXS_OK);
    uint32_t random = 3;
    int braked = 0;
    double worst = 0;
    pose.position[1] = 0.0115;
    const long ticks = check_length(10000, 1000);
    for (long k = 0; k < ticks; k++) {
        last = pose;
        for (int i = 0; i < 3; i++) pose.position[i] += 2e-4 * next_random(&random);
        for (int i = 0; i < 4; i++) pose.orientation[i] += 0.01 * next_random(&random);
        pose.position[0] *= 0.99, pose.position[2] *= 0.99,
            pose.position[1] += 0.01 * (0.0115 - pose.position[1]);
        const vxs_pose identity = vxs_pose_identity();
        CHECK(vxs_pose_compose(&pose, &identity, &pose));
        for (int n = 0; n < 2; n++) CHECK_INT(tick_at(&b[n], &pose, &row[n]) & VXS_SERVO_FAULT, 0);
        CHECK(memcmp(&row[0].output, &row[1].output, sizeof row[0].output) == 0);
        const vxs_wrench force = felt(&row[0]);
        double turn[3], work = 0;
        vxs_pose_turn(last.orientation, pose.orientation, turn);
        for (int i = 0; i < 3; i++)
            work += force.force[i] * (pose.position[i] - last.position[i]) + force.torque[i] * turn[i];
        worst = fmax(worst, work);
        braked += work < 0;
    }
    CHECK(worst <= 1e-15 && braked > ticks / 2);
    for (int n = 0; n < 2; n++) bench_close(&b[n]);
}

/* Up through the slot's middle at an even 50 mm/s in small steps, the nearer wall changing: no jump. */
static void check_continuous(void)
{
    const double slot = 0.023, step = 1e-6;
    servo_bench b;
    vxs_servo_trace row;
    prepare(&b, in_slot, &slot, 29);
    b.servo_config.coupling.sample_time = 2e-5;
    bench_open(&b);
    vxs_pose pose = vxs_pose_identity();
    double before = 0, largest = 0, at_middle = 1, near = 0;
    for (int k = 0; k < 2800; k++) {
        pose.position[1] = 0.0101 + k * step;
        b.state.time_ns += 20000 - 1000000;
        CHECK_INT(tick_at(&b, &pose, &row) & VXS_SERVO_FAULT, 0);
        double force = felt(&row).force[1];
        CHECK(force <= 0 && force >= -4 * 0.05 * 1.01); /* back down, from the upper wall */
        if (k > 1) largest = fmax(largest, fabs(force - before));
        if (fabs(pose.position[1] - slot / 2) < step) at_middle = force;
        near = fmin(near, force);
        before = force;
    }
    /* From 0 to 0.2 N over some mm: nearly even. */
    printf("slot: %.3g N in the middle, %.3g N near the wall, at most %.2g N from one um to the next\n",
           at_middle, near, largest);
    CHECK(largest < 1e-3 && near < -0.15);
    bench_close(&b);
}

/* The floor comes up to a ball at rest: as if the ball came down. */
static void check_moving(void)
{
    vxs_pose pose = vxs_pose_identity(), up = pose;
    up.position[1] = 0.05;
    const vxs_effect_keyframe frames[] = {{.pose = pose}, {.time = 1, .pose = up}};
    servo_bench b[2];
    vxs_servo_trace row[2];
    for (int n = 0; n < 2; n++) {
        prepare(&b[n], above_floor, NULL, 20);
        if (n) {
            vxs_effect *e = bench_effect(&b[n], VXS_EFFECT_MOTION);
            e->keyframes = frames;
            e->keyframe_count = 2;
        }
        bench_open(&b[n]);
    }
    int braked = 0;
    for (int k = 0; k < 80; k++) {
        for (int n = 0; n < 2; n++) {
            pose.position[1] = 0.014 - (n ? 0 : 5e-5 * k);
            CHECK_INT(tick_at(&b[n], &pose, &row[n]) & VXS_SERVO_FAULT, 0);
        }
        double force = felt(&row[0]).force[1];
        CHECK_NEAR(felt(&row[1]).force[1], force, 1e-6);
        braked += force > 0.01;
    }
    CHECK(braked > 50);
    for (int n = 0; n < 2; n++) bench_close(&b[n]);
}

static void check_refusals(void)
{
    servo_bench b;
    bench_prepare(&b); /* a map without distances */
    bench_effect(&b, VXS_EFFECT_PROXIMITY);
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_CHANNEL);
    built_free(&b.map_bytes);
    built_free(&b.shell_bytes);
    prepare(&b, above_floor, NULL, 20);
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_OK);
    b.effects[0].as.proximity.reach = 0.0071; /* the band is 7 mm */
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_CHANNEL);
    built_free(&b.map_bytes);
    built_free(&b.shell_bytes);
}

int main(void)
{
    check_formula();
    check_passive();
    check_continuous();
    check_moving();
    check_refusals();
    return 0;
}
