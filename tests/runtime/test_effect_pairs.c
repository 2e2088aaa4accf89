/* SPDX-License-Identifier: MIT
 *
 * Each effect of the table by itself and each pair of them, in a closed loop: a hand that wanders into a
 * floor and out of it, turning. Nothing before arming; always finite and within the clamp, and what comes
 * before the clamp and the tip's way within bounds; the same bits twice. The argument says how many ticks
 * (600).
 */
#include "servo_bench.h"

static const double most_force = 20,
                    most_torque = 0.2; /* [N], [N m] before the clamp, of what stands below */
static const double farthest = 0.015;  /* [m] from where the hand wants the tip */

static double floor_distance(const void *shape, const double p[3])
{
    (void)shape;
    return p[1];
}

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static double next_random(uint32_t *state)
{
    *state ^= *state << 13, *state ^= *state >> 17, *state ^= *state << 5;
    return *state / 4294967296.0 - 0.5;
}

/* Constants at which each of them acts in this bench. */
static void add_effect(servo_bench *b, uint32_t kind)
{
    static vxs_effect_keyframe frames[3];
    vxs_effect *e = bench_effect(b, kind);
    switch (kind) {
    case VXS_EFFECT_PASSIVITY:
        e->as.passivity.radius = 0.03;
        break;
    case VXS_EFFECT_FRICTION:
        e->as.friction.stiffness = 500;
        e->as.friction.damping = 0.3;
        break;
    case VXS_EFFECT_GRAVITY:
        e->as.gravity.com[0] = 0.005;
        break;
    case VXS_EFFECT_INERTIA:
        e->as.inertia.mass = 0.2;
        for (int i = 0; i < 3; i++) e->as.inertia.inertia[i] = 8e-5;
        break;
    case VXS_EFFECT_VISCOSITY:
        e->as.viscosity.turning = 1e-4;
        break;
    case VXS_EFFECT_WORKSPACE:
        e->as.workspace.high[1] = 0.0115;
        e->as.workspace.low[0] = -0.001;
        break;
    case VXS_EFFECT_MOTION:
        for (int n = 0; n < 3; n++) frames[n] = (vxs_effect_keyframe){0.1 * n, vxs_pose_identity(), 0, 0};
        frames[1].pose = (vxs_pose){{0.001, 0.0005, 0}, {1, 0, 0.01, 0.01}};
        e->keyframes = frames;
        e->keyframe_count = 3;
        e->as.motion.loop = 1;
        break;
    default:
        break;
    }
}

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t size)
{
    const uint8_t *byte = bytes;
    for (size_t n = 0; n < size; n++) hash = (hash ^ byte[n]) * 1099511628211u; /* FNV-1a */
    return hash;
}

typedef struct worst {
    double force, torque, away;
    long contacts;
} worst;

static void check_row(const servo_bench *b, const vxs_servo_trace *row, const double target[3], worst *w)
{
    const vxs_wrench *command = &row->command, *output = &row->output;
    for (int i = 0; i < 3; i++) {
        CHECK(isfinite(command->force[i]) && isfinite(command->torque[i]));
        CHECK(isfinite(output->force[i]) && isfinite(output->torque[i]));
    }
    CHECK(!(row->flags & VXS_SERVO_FAULT) && isfinite(row->energy) && isfinite(row->damping));
    CHECK(length(command->force) <= b->servo_config.max_force * (1 + 1e-12));
    CHECK(length(command->torque) <= b->servo_config.max_torque * (1 + 1e-12));
    const double way[3] = {row->pose.position[0] - target[0], row->pose.position[1] - target[1],
                           row->pose.position[2] - target[2]};
    w->force = fmax(w->force, length(output->force));
    w->torque = fmax(w->torque, length(output->torque));
    w->away = fmax(w->away, length(way));
    w->contacts += row->points > 0;
}

static uint64_t wander(uint32_t kind, uint32_t other, int ticks, worst *w)
{
    const int64_t low[3] = {-24, -6, -24}, high[3] = {24, 20, 24};
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    built_free(&b.map_bytes);
    b.map_bytes = build_field_map(0.001, low, high, floor_distance, NULL, 6);
    b.map = open_voxmap(&b.map_bytes);
    b.servo_config.contact.law = VXS_CONTACT_PATCH;
    b.servo_config.contact.field = VXS_CONTACT_DISTANCE;
    b.servo_config.contact.stiffness = 2e7;
    b.servo_config.coupling.omega0 *= 10;
    add_effect(&b, kind);
    if (other != kind) add_effect(&b, other);
    bench_open(&b);
    double target[3] = {0, 0.012, 0}, orientation[4] = {1, 0, 0, 0};
    uint64_t hash = 14695981039346656037u;
    uint32_t random = 4711;
    for (int k = 0; k < ticks; k++) {
        for (int i = 0; i < 3; i++) {
            target[i] += 2e-4 * next_random(&random);
            orientation[1 + i] = 0.99 * orientation[1 + i] + 0.01 * next_random(&random);
        }
        target[0] *= 0.99, target[2] *= 0.99;
        if (k > 20) target[1] += 0.02 * ((k % 200 < 120 ? 0.0085 : 0.0125) - target[1]);
        if (k == 20) CHECK_INT(vxs_device_arm(b.device), VXS_OK);
        vxs_simulated_hand(b.device, target, orientation);
        vxs_device_exchange(b.device, &b.command, &b.state, NULL);
        vxs_servo_tick(b.servo, &b.state, &b.command, &row);
        if (k < 20)
            for (int i = 0; i < 3; i++) CHECK(row.command.force[i] == 0 && row.command.torque[i] == 0);
        check_row(&b, &row, target, w);
        hash = hash_bytes(hash, &row, sizeof row);
    }
    bench_close(&b);
    return hash;
}

int main(int count, char **arguments)
{
    const int ticks = count > 1 ? atoi(arguments[1]) : (int)check_length(600, 150);
    int pairs = 0;
    worst all = {0, 0, 0, 0};
    for (uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; n++) {
        const uint32_t last = n + (uint32_t)check_length(1000, 1);
        for (uint32_t m = n, other; m <= last && (other = vxs_effect_kind_at(m)) != 0; m++) {
            worst w = {0, 0, 0, 0};
            uint64_t once = wander(kind, other, ticks, &w),
                     again = check_length(1, 0) ? wander(kind, other, ticks, &w) : once;
            if (once != again || w.contacts < ticks / 4 || w.force > most_force || w.torque > most_torque ||
                w.away > farthest)
                CHECK_FAIL("%s and %s: %g N, %g N m, %g m away, %ld ticks in contact%s",
                           vxs_effect_kind_name(kind), vxs_effect_kind_name(other), w.force, w.torque, w.away,
                           w.contacts, once == again ? "" : ", and not the same twice");
            all.force = fmax(all.force, w.force);
            all.torque = fmax(all.torque, w.torque);
            all.away = fmax(all.away, w.away);
            pairs++;
        }
    }
    printf("%d effects and pairs of them, %d ticks each: at most %.1f N, %.3f N m before the clamp, "
           "%.1f mm "
           "from where the hand wants the tip\n",
           pairs, ticks, all.force, all.torque, 1e3 * all.away);
    CHECK(pairs >= check_length(13 * 14 / 2, 13 + 12));
    return 0;
}
