/* SPDX-License-Identifier: MIT
 *
 * The servo's guards, each against what it promises (effect.h); all of them together over 60 000 ticks, and
 * as many more as the argument says.
 */
#include "servo_bench.h"

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static double distance(const double a[3], const double b[3])
{
    const double way[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return length(way);
}

static void check_names(void)
{
    CHECK_TEXT(vxs_effect_kind_name(VXS_EFFECT_START_INSIDE), "start-inside");
    CHECK_TEXT(vxs_effect_kind_name(VXS_EFFECT_PASSIVITY), "passivity");
    CHECK_TEXT(vxs_effect_kind_name(VXS_EFFECT_SLEW), "slew");
    CHECK_TEXT(vxs_effect_kind_name(VXS_EFFECT_SOFT_START), "soft-start");
    for (uint32_t kind = 1; kind < 99; kind++) {
        const char *name = vxs_effect_kind_name(kind);
        if (name) CHECK_INT(vxs_effect_kind_named(name), kind);
    }
    CHECK(!vxs_effect_kind_name(0) && !vxs_effect_kind_name(99));
    CHECK_INT(vxs_effect_kind_named("contact"), 0); /* a stage, but not one to ask for */
    CHECK_INT(vxs_effect_kind_named(NULL), 0);
}

static void check_refusals(void)
{
    servo_bench b;
    vxs_servo *servo;
    bench_prepare(&b);
    bench_effect(&b, VXS_EFFECT_SLEW);
    bench_effect(&b, VXS_EFFECT_SOFT_START);
    bench_open(&b);
    size_t size = vxs_servo_memory(&b.servo_config);
    CHECK_INT(vxs_servo_init(b.servo_memory, size - 1, &b.servo_config, &servo), VXS_BUFFER);
    vxs_effect good = b.effects[0];
    b.effects[0].kind = VXS_EFFECT_SOFT_START; /* twice */
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    CHECK_INT(vxs_servo_memory(&b.servo_config), 0);
    b.effects[0].kind = 77;
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    b.effects[0] = good;
    b.effects[0].struct_size = 0;
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_CONFIG);
    b.effects[0] = good;
    b.effects[0].as.slew.force = NAN;
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    b.effects[0] = good;
    b.effects[1].as.soft_start.time = -1;
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    b.servo_config.effect_count = 1000;
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    b.servo_config.effect_count = 1;
    b.servo_config.effects = NULL;
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    CHECK_INT(vxs_effect_default(77, &good), VXS_PARAM);
    bench_close(&b);
}

/* The table of constants is what C's names say, and each range is kept. */
static void check_constants(void)
{
    vxs_effect e;
    CHECK_INT(vxs_effect_default(VXS_EFFECT_PASSIVITY, &e), VXS_OK);
    const double *const passivity[] = {&e.as.passivity.most_damping, &e.as.passivity.least_speed,
                                       &e.as.passivity.radius, &e.as.passivity.delay};
    for (int n = 0; n < 4; n++) CHECK(passivity[n] == &e.as.constants[n]);
    CHECK(&e.as.slew.force == &e.as.constants[0] && &e.as.slew.torque == &e.as.constants[1]);
    CHECK(&e.as.soft_start.time == &e.as.constants[0]);
    CHECK(&e.as.contact_damping.most == &e.as.constants[1] && &e.as.viscosity.turning == &e.as.constants[1]);
    CHECK(&e.as.gravity.com[0] == &e.as.constants[1] && &e.as.gravity.acceleration[2] == &e.as.constants[6]);
    CHECK(&e.as.workspace.high[2] == &e.as.constants[5] && &e.as.workspace.damping == &e.as.constants[7]);
    int kinds = 0;
    for (uint32_t kind = 0; kind < 100; kind++) {
        uint32_t count = 99;
        const vxs_effect_constant *constants = vxs_effect_constants(kind, &count);
        if (vxs_effect_default(kind, &e) != VXS_OK) {
            CHECK(!constants && count == 0);
            continue;
        }
        kinds++;
        const vxs_effect_keyframe frame = {.pose = vxs_pose_identity()};
        vxs_effect with = e, without = e;
        with.keyframes = &frame;
        with.keyframe_count = 1;
        without.reserved = 1;
        CHECK_INT(vxs_effect_check(&with), kind == VXS_EFFECT_MOTION ? VXS_OK : VXS_PARAM);
        CHECK_INT(vxs_effect_check(&without), VXS_PARAM);
        if (kind == VXS_EFFECT_MOTION) e = with;
        CHECK(count <= VXS_EFFECT_MAX_CONSTANTS);
        CHECK_INT(vxs_effect_check(&e), VXS_OK);
        for (uint32_t n = 0; n < VXS_EFFECT_MAX_CONSTANTS; n++) {
            double least = n < count ? constants[n].least : 0, most = n < count ? constants[n].most : 0;
            CHECK(isfinite(least) && isfinite(most) && least <= most);
            CHECK(e.as.constants[n] == (n < count ? constants[n].standard : 0));
            const double bad[] = {nextafter(least, -INFINITY), nextafter(most, INFINITY), NAN};
            for (int b = 0; b < 3; b++) {
                vxs_effect wrong = e;
                wrong.as.constants[n] = bad[b];
                CHECK_INT(vxs_effect_check(&wrong), VXS_PARAM);
            }
        }
    }
    CHECK(kinds >= 4);
}

/* A stiff wall beside the tip, so that force and torque jump. */
static void prepare_jumps(servo_bench *b)
{
    bench_prepare(b);
    b->servo_config.coupling.kind = VXS_COUPLING_NONE;
    b->servo_config.contact.stiffness = 2e9;
    b->servo_config.grip.position[0] = 0.003;
    b->servo_config.max_force = 2;
    b->servo_config.max_torque = 0.004;
}

/* Slew: no change above the rate, and exactly the rate while the way is longer; force and torque each. */
static void check_slew(void)
{
    servo_bench b;
    vxs_servo_trace row;
    prepare_jumps(&b);
    vxs_effect *slew = bench_effect(&b, VXS_EFFECT_SLEW);
    slew->as.slew.force = 50; /* 0.05 N a tick */
    slew->as.slew.torque = 0.1;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    vxs_wrench last = {{0, 0, 0}, {0, 0, 0}};
    int slewed = 0, exact = 0;
    for (int k = 0; k < 3000; k++) {
        uint32_t flags = bench_tick(&b, k < 10 ? 0.012 : 0.0085, &row);
        double force = distance(row.command.force, last.force),
               torque = distance(row.command.torque, last.torque);
        CHECK(force <= 0.05 + 1e-12 && torque <= 1e-4 + 1e-15);
        if (flags & VXS_SERVO_SLEWED && !(flags & VXS_SERVO_SATURATED)) {
            slewed++;
            exact += fabs(force - 0.05) < 1e-12 || fabs(torque - 1e-4) < 1e-15;
        }
        if (!(flags & VXS_SERVO_SLEWED) && !(flags & VXS_SERVO_SATURATED))
            CHECK_NEAR(distance(row.command.force, row.output.force), 0, 1e-12);
        last = row.command;
    }
    CHECK(slewed > 20 && exact == slewed);
    bench_close(&b);

    /* By default: from zero to the clamp in 4 ms, and not beyond it: it does not wind up. */
    prepare_jumps(&b);
    bench_effect(&b, VXS_EFFECT_SLEW);
    b.servo_config.contact.stiffness = 1e12;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    int first = 0, last_on = 0;
    double before = 0;
    for (int k = 0; k < 3000 && !last_on; k++) {
        bench_tick(&b, k < 10 ? 0.012 : 0.0085, &row);
        if (!first && row.points > 0 && length(row.output.force) > 4) first = k;
        if (first && k < first + 4) CHECK_NEAR(length(row.command.force), 0.5 * (k - first + 1), 1e-3);
        if (before > 2 - 1e-9 && length(row.output.force) == 0) { /* let go: down again as fast */
            CHECK_NEAR(length(row.command.force), 1.5, 1e-9);
            last_on = k;
        }
        before = length(row.command.force);
    }
    CHECK(last_on > 0);
    bench_close(&b);
}

/* Every guard before it: what the clamp gives has the direction of what the slew limit gave, here nothing
 * less. */
static void check_clamp_direction(void)
{
    servo_bench b;
    vxs_servo_trace row;
    prepare_jumps(&b);
    b.servo_config.mount =
        (vxs_pose){{0.001, 0, 0.002}, {0.9, 0.1, 0.3, -0.2}}; /* the floor's push is oblique */
    b.servo_config.max_force = 0.3;
    vxs_effect *passivity = bench_effect(&b, VXS_EFFECT_PASSIVITY);
    passivity->as.passivity.least_speed = 1e9; /* observes only */
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    int saturated = 0;
    for (int k = 0; k < 4000; k++) {
        double share = k < 2000 ? k / 2000.0 : 1, target[3] = {0.004 * share, 0, 0};
        double down[3] = {0, 0.012 - 0.0035 * share, 0}; /* in the scene; back to the device by the mount */
        double r[9];
        vxs_pose_rotation(&b.servo_config.mount, r);
        for (int i = 0; i < 3; i++) down[i] -= b.servo_config.mount.position[i];
        for (int i = 0; i < 3; i++) target[i] = r[i] * down[0] + r[3 + i] * down[1] + r[6 + i] * down[2];
        vxs_simulated_hand(b.device, target, NULL);
        vxs_device_exchange(b.device, &b.command, &b.state, NULL);
        if (!(vxs_servo_tick(b.servo, &b.state, &b.command, &row) & VXS_SERVO_SATURATED)) continue;
        double size = length(row.output.force);
        if (size <= 0.3) continue; /* torque it was */
        saturated++;
        CHECK_NEAR(length(row.command.force), 0.3, 1e-12);
        for (int i = 0; i < 3; i++) { /* device frame: the mount's columns */
            double wanted = (r[i] * row.output.force[0] + r[3 + i] * row.output.force[1]) +
                            r[6 + i] * row.output.force[2];
            CHECK_NEAR(row.command.force[i], 0.3 * wanted / size, 1e-12);
        }
    }
    CHECK(saturated > 100);
    bench_close(&b);
}

/* Soft start: gain k T / time from arming on; after an overrun it goes on from the share that was rendered.
 */
static void check_ramp(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    bench_effect(&b, VXS_EFFECT_SOFT_START)->as.soft_start.time = 0.25;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    for (int k = 1; k <= 1000; k++) {
        uint32_t flags = bench_tick(&b, 0.009, &row);
        CHECK_NEAR(row.gain, fmin(1, k / 250.0), 1e-12);
        if (k < 249 || k > 251) CHECK_INT((flags & VXS_SERVO_RAMPING) != 0, k < 250);
        CHECK_NEAR(row.command.force[1], row.gain * row.output.force[1], 1e-12);
    }
    CHECK(row.command.force[1] > 0.1);
    /* A command is full for 2 samples and gone 10 ms later; this one comes after 1 + 6. */
    for (int k = 0; k < 7; k++) vxs_device_exchange(b.device, k ? NULL : &b.command, &b.state, NULL);
    CHECK(vxs_servo_tick(b.servo, &b.state, &b.command, &row) & VXS_SERVO_MISSED);
    for (int k = 1; k <= 200; k++) {
        CHECK_NEAR(row.gain, fmin(1, 0.5 + k / 250.0), 1e-12);
        bench_tick(&b, 0.009, &row);
    }
    for (int k = 0; k < 30; k++) vxs_device_exchange(b.device, k ? NULL : &b.command, &b.state, NULL);
    vxs_servo_tick(b.servo, &b.state, &b.command, &row);
    CHECK_NEAR(row.gain, 1 / 250.0, 1e-12); /* long enough to be gone: from nothing */
    bench_close(&b);

    /* Without it: all of it at once. */
    bench_prepare(&b);
    b.servo_config.effects = NULL;
    b.servo_config.effect_count = 0;
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    b.device_config.start.position[1] = 0.0092;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    CHECK_INT(bench_tick(&b, 0.0092, &row), 0);
    CHECK(row.gain == 1 && row.command.force[1] > 0.1 && row.command.force[1] == row.output.force[1]);
    bench_close(&b);
}

/* Start inside: zero and the flag until it has left, also after the device was let go of in contact. */
static void check_start_inside(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    b.device_config.start.position[1] = 0.0092;
    bench_effect(&b, VXS_EFFECT_START_INSIDE);
    bench_open(&b);
    for (int round = 0; round < 2; round++) {
        CHECK_INT(vxs_device_arm(b.device), VXS_OK);
        int has_left = 0;
        for (int k = 0; k < 2000; k++) {
            double height = k < 300 ? 0.0092 : k < 600 ? 0.012 : 0.0092;
            uint32_t flags = bench_tick(&b, height, &row);
            has_left |= row.points == 0 && row.deep_points == 0;
            CHECK_INT((flags & VXS_SERVO_START_IN_CONTACT) != 0, !has_left);
            if (!has_left)
                CHECK(row.gain == 0 && length(row.command.force) == 0 && length(row.output.force) == 0);
        }
        CHECK(has_left && row.command.force[1] > 0.05);
        CHECK_INT(vxs_device_disarm(b.device), VXS_OK);
        bench_tick(&b, 0.0092, &row);
    }
    bench_close(&b);
}

/* Where the tip swings in the last 0.3 s of 8 [m], pressed by a light grip onto a wall far stiffer than the
 * loop of delay and hold carries; no friction, no encoder. */
static double swing(int has_passivity, double *least_energy, int *damped)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    b.servo_config.contact.stiffness = 1.6e9;
    b.device_config.arm = *vxs_simulated_arm_named("pen");
    b.device_config.profile.friction = b.device_config.profile.resolution = 0;
    bench_effect(&b, VXS_EFFECT_START_INSIDE);
    if (has_passivity) bench_effect(&b, VXS_EFFECT_PASSIVITY);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    double low = 1, high = -1;
    *least_energy = 0;
    *damped = 0;
    for (int k = 0; k < 8000; k++) {
        *damped += (bench_tick(&b, k < 1000 ? 0.012 - 3e-6 * k : 0.009, &row) & VXS_SERVO_DAMPED) != 0;
        *least_energy = fmin(*least_energy, row.energy);
        double tip[3];
        vxs_simulated_truth(b.device, tip, NULL);
        if (k >= 7700) low = fmin(low, tip[1]), high = fmax(high, tip[1]);
    }
    bench_close(&b);
    return high - low;
}

static void check_settles(void)
{
    double least;
    int damped;
    double without = swing(0, &least, &damped);
    CHECK(without > 0.005 && least == 0 && damped == 0);
    double with = swing(1, &least, &damped);
    printf("light grip on a stiff wall: swings %.2f mm, with passivity %.3f mm; E at least %.2g J\n",
           1e3 * without, 1e3 * with, least);
    CHECK(with < 6e-5 && damped > 100); /* two steps of the encoder that it would have */
    CHECK(least > -2e-4);
}

/* The hand of a drunkard: a walk of steps from a small generator, in and out of contact, turning too. */
static uint32_t next_random(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    return *state ^= *state << 5;
}

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t size)
{
    const uint8_t *byte = bytes;
    for (size_t n = 0; n < size; n++) hash = (hash ^ byte[n]) * 1099511628211u; /* FNV-1a */
    return hash;
}

static uint64_t walk(const uint32_t *kinds, int count, long ticks)
{
    servo_bench b;
    vxs_servo_trace row;
    prepare_jumps(&b);
    b.servo_config.coupling.kind = VXS_COUPLING_PT2;
    b.servo_config.coupling.omega0 *= 4;
    for (int n = 0; n < count; n++) {
        vxs_effect *effect = bench_effect(&b, kinds[n]);
        if (kinds[n] == VXS_EFFECT_PASSIVITY) effect->as.passivity.radius = 0.03;
    }
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    uint64_t hash = 14695981039346656037u;
    uint32_t random = 12345, flags = 0;
    double target[3] = {0, 0.012, 0}, orientation[4] = {1, 0, 0, 0};
    for (long k = 0; k < ticks; k++) {
        for (int i = 0; i < 3; i++) {
            target[i] += ((double)(next_random(&random) >> 16) - 32767.5) * 1e-9;
            orientation[1 + i] += ((double)(next_random(&random) >> 16) - 32767.5) * 1e-7;
        }
        target[0] *= 0.9999, target[2] *= 0.9999, target[1] += (0.0095 - target[1]) * 1e-3;
        for (int i = 1; i < 4; i++) orientation[i] *= 0.999;
        if (k % 50021 == 0) CHECK_INT(vxs_device_disarm(b.device), VXS_OK);
        if (k % 50021 == 20) CHECK_INT(vxs_device_arm(b.device), VXS_OK);
        vxs_simulated_hand(b.device, target, orientation);
        vxs_device_exchange(b.device, &b.command, &b.state, NULL);
        if (k % 30011 == 0) /* an overrun */
            for (int n = 0; n < 9; n++) vxs_device_exchange(b.device, NULL, &b.state, NULL);
        flags |= vxs_servo_tick(b.servo, &b.state, &b.command, &row);
        CHECK(length(row.command.force) <= 2 + 1e-12 && length(row.command.torque) <= 0.004 + 1e-12);
        CHECK(row.gain >= 0 && row.gain <= 1 && row.damping >= 0 && row.damping <= 5);
        CHECK(isfinite(row.energy) && fabs(row.energy) < 10);
        hash = hash_bytes(hash, &row, sizeof row);
    }
    CHECK(!(flags & VXS_SERVO_FAULT) && flags & VXS_SERVO_MISSED && flags & VXS_SERVO_SATURATED);
    if (count == 4)
        CHECK(flags & VXS_SERVO_DAMPED && flags & VXS_SERVO_SLEWED && flags & VXS_SERVO_START_IN_CONTACT);
    bench_close(&b);
    return hash;
}

/* The order is the tick's, not the list's. */
static void check_order_and_length(long longest)
{
    const uint32_t one_way[] = {VXS_EFFECT_START_INSIDE, VXS_EFFECT_PASSIVITY, VXS_EFFECT_SLEW,
                                VXS_EFFECT_SOFT_START},
                   other_way[] = {VXS_EFFECT_SOFT_START, VXS_EFFECT_SLEW, VXS_EFFECT_PASSIVITY,
                                  VXS_EFFECT_START_INSIDE};
    const long ticks = check_length(60000, 50100); /* at 50041 it is armed in contact */
    const uint64_t all = walk(one_way, 4, ticks);
    CHECK(walk(other_way, 4, ticks) == all);
    for (int skipped = (int)check_length(0, 4); skipped < 4; skipped++) {
        uint32_t three[3];
        for (int n = 0, m = 0; n < 4; n++)
            if (n != skipped) three[m++] = one_way[n];
        CHECK(walk(three, 3, ticks) != all);
    }
    if (longest > 0) walk(one_way, 4, longest);
}

int main(int count, char **arguments)
{
    check_names();
    check_constants();
    check_refusals();
    check_slew();
    check_clamp_direction();
    check_ramp();
    check_start_inside();
    check_settles();
    check_order_and_length(count > 1 ? atol(arguments[1]) : 0);
    return 0;
}
