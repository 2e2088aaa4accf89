/* SPDX-License-Identifier: MIT
 *
 * A program's own coupling and effect, as others get them wrong: structs that are not filled in, places in the list that
 * there are not, numbers that are none. What is refused is refused by name; what only shows in a tick ends in zero force.
 */
#include "servo_bench.h"
#include "voxshell/coupling_kind.h"
#include "voxshell/effect_kind.h"

static double added, rendered; /* what the effect adds to the hand [N]; what the coupling makes of contact */
static int has_run;

static void add_force(void *self, vxs_tick *tick)
{
    (void)self;
    const vxs_wrench more = {{0, 0, added}, {0, 0, 0}};
    has_run++;
    vxs_tick_add_to_hand(tick, &more);
}

static void pose_nowhere(const void *self, const vxs_pose *tip, vxs_pose *body)
{
    (void)self;
    *body = *tip;
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    (void)coupling, (void)device;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < 3; i++) out->force[i] = contact->force[i] * rendered;
}

/* Behind the coupling: what the hand gets is there, at the tip and in the device's frame. */
static void halve(void *self, vxs_tick *tick)
{
    (void)self;
    for (int i = 0; i < 3; i++) tick->wrench.force[i] /= 2, tick->wrench.torque[i] /= 2;
}

static const vxs_effect_constant one_constant = {"strength", "N", 1, 0, 2};
static const vxs_effect_kind good_effect = {
    .struct_size = sizeof good_effect, .tick_size = sizeof(vxs_tick), .name = "lab-push", .run = add_force};
static const vxs_effect_kind behind = {.struct_size = sizeof behind,
                                       .tick_size = sizeof(vxs_tick),
                                       .name = "lab-half",
                                       .before = "passivity",
                                       .run = halve};
static const vxs_coupling_kind good_coupling = {.struct_size = sizeof good_coupling,
                                                .coupling_size = sizeof(vxs_coupling),
                                                .name = "lab-gain",
                                                .step = step};

static void check_effect(void)
{
    vxs_effect effect;
    vxs_effect_kind kind;
    /* Refused as it is made, and as it is changed behind an effect's back. */
#define EFFECT(expected, change)                                                                             \
    do {                                                                                                     \
        kind = good_effect;                                                                                  \
        CHECK_INT(vxs_effect_own(&kind, &effect), VXS_OK);                                                   \
        CHECK_INT(vxs_effect_check(&effect), VXS_OK);                                                        \
        change;                                                                                              \
        CHECK_INT(vxs_effect_check(&effect), expected);                                                      \
        CHECK_INT(vxs_effect_own(&kind, &effect), expected);                                                 \
    } while (0)
    CHECK_INT(vxs_effect_own(NULL, &effect), VXS_PARAM);
    CHECK_INT(vxs_effect_own(&good_effect, NULL), VXS_PARAM);
    EFFECT(VXS_CONFIG, kind.struct_size--);
    EFFECT(VXS_CONFIG, kind.tick_size++);
    EFFECT(VXS_PARAM, kind.name = NULL);
    EFFECT(VXS_PARAM, kind.run = NULL);
    EFFECT(VXS_OK, (kind.run = NULL, kind.add = add_force));
    EFFECT(VXS_PARAM, kind.pose = pose_nowhere); /* with nothing said of its compliance */
    EFFECT(VXS_PARAM, kind.constant_count = VXS_EFFECT_MAX_CONSTANTS + 1);
    EFFECT(VXS_PARAM, kind.constant_count = 1);
    EFFECT(VXS_PARAM, kind.before = "lunch");
    vxs_servo_stage stage;
    int is_over = 0;
    for (uint32_t n = 0; vxs_servo_stage_at(n, &stage) == VXS_OK; n++) {
        /* From contact's stage up to the one that follows the coupling; the rest is the guards' own. */
        EFFECT(is_over ? VXS_PARAM : VXS_OK, kind.before = stage.name);
        is_over |= n > 0 && strcmp(stage.name, "passivity") == 0;
    }
    CHECK(is_over);
    kind = good_effect;
    kind.constants = &one_constant;
    kind.constant_count = 1;
    CHECK(vxs_effect_own(&kind, &effect) == VXS_OK && effect.as.constants[0] == 1);
    effect.as.constants[0] = 3;
    CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
    effect.as.constants[0] = 2;
    CHECK_INT(vxs_effect_check(&effect), VXS_OK);
    effect.kind = VXS_EFFECT_TORQUE; /* it is both, so neither */
    CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
    CHECK(!vxs_effect_is_guard(VXS_EFFECT_OWN) && vxs_effect_is_guard(VXS_EFFECT_SOFT_START) &&
          !vxs_effect_is_guard(VXS_EFFECT_GRAVITY) && !vxs_effect_is_guard(1000));
}

static void check_coupling(void)
{
    vxs_coupling_config config;
    vxs_coupling_kind kind;
    vxs_coupling_config_default(&config);
    config.kind = VXS_COUPLING_OWN;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_PARAM); /* but which? */
    config.own = &kind;
#define OWN_COUPLING(expected, change)                                                                       \
    do {                                                                                                     \
        kind = good_coupling;                                                                                \
        change;                                                                                              \
        CHECK_INT(vxs_coupling_config_check(&config), expected);                                             \
    } while (0)
    OWN_COUPLING(VXS_OK, (void)0);
    OWN_COUPLING(VXS_CONFIG, kind.struct_size++);
    OWN_COUPLING(VXS_CONFIG, kind.coupling_size--);
    OWN_COUPLING(VXS_PARAM, kind.name = NULL);
    OWN_COUPLING(VXS_PARAM, kind.step = NULL);
    OWN_COUPLING(VXS_PARAM, config.kind = VXS_COUPLING_PT2); /* it is both, so neither */
}

/* In the loop: what they make is felt; a number that is none ends in zero force until it is cleared. */
static void check_loop(void)
{
    const double bad[] = {NAN, INFINITY, -INFINITY};
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.servo_config.coupling.kind = VXS_COUPLING_OWN;
    b.servo_config.coupling.own = &good_coupling;
    CHECK_INT(vxs_effect_own(&good_effect, bench_effect(&b, VXS_EFFECT_TORQUE)), VXS_OK);
    b.has_no_torque = 1;
    added = rendered = 0;
    bench_open(&b);
    bench_start(&b);
    b.state.pose.position[1] = 0.009;
    bench_follow(&b, &row);
    CHECK(row.points > 0 && row.collision.force[1] > 0);
    CHECK(has_run == 1 && row.command.force[1] == 0 && row.command.force[2] == 0);
    added = 0.25;
    rendered = 1e-3;
    bench_follow(&b, &row);
    CHECK_NEAR(row.command.force[1], 1e-3 * row.collision.force[1], 1e-12);
    CHECK_NEAR(row.command.force[2], 0.25 + 1e-3 * row.collision.force[2], 1e-12);
    for (int n = 0; n < 6; n++) {
        *(n < 3 ? &added : &rendered) = bad[n % 3];
        b.state.sequence++;
        b.state.time_ns += 1000000;
        CHECK(vxs_servo_tick(b.servo, &b.state, &b.command, &row) & VXS_SERVO_FAULT);
        for (int i = 0; i < 3; i++) CHECK(b.command.wrench.force[i] == 0 && b.command.wrench.torque[i] == 0);
        added = 0.25;
        rendered = 1e-3;
        CHECK(vxs_servo_tick(b.servo, &b.state, &b.command, &row) & VXS_SERVO_FAULT); /* it stays */
        CHECK(b.command.wrench.force[2] == 0);
        vxs_servo_clear(b.servo);
        bench_follow(&b, &row);
        CHECK(fabs(row.command.force[2]) > 0.2);
    }
    bench_close(&b);
}

/* An effect that runs behind the coupling takes half of what each coupling makes, of all that is at the object too. */
static void check_behind_the_coupling(uint32_t kind)
{
    vxs_servo_trace rows[2];
    for (int with = 0; with < 2; with++) {
        servo_bench b;
        bench_prepare(&b);
        b.servo_config.coupling.kind = kind;
        if (with) CHECK_INT(vxs_effect_own(&behind, bench_effect(&b, VXS_EFFECT_TORQUE)), VXS_OK);
        CHECK_INT(vxs_effect_own(&good_effect, bench_effect(&b, VXS_EFFECT_TORQUE)), VXS_OK);
        b.has_no_torque = 1;
        added = 0.25;
        bench_open(&b);
        bench_start(&b);
        b.state.pose.position[1] = 0.009;
        for (int n = 0; n < 20; n++) bench_follow(&b, &rows[with]);
        bench_close(&b);
    }
    CHECK(fabs(rows[0].command.force[1]) > 0.05 && rows[0].command.force[2] >= 0.2);
    for (int i = 0; i < 3; i++) {
        CHECK(rows[1].collision.force[i] == rows[0].collision.force[i]);
        CHECK(rows[1].command.force[i] == rows[0].command.force[i] / 2);
    }
}

int main(void)
{
    check_effect();
    check_coupling();
    check_loop();
    check_behind_the_coupling(VXS_COUPLING_NONE);
    check_behind_the_coupling(VXS_COUPLING_PT2);
    check_behind_the_coupling(VXS_COUPLING_QUASI_STATIC);
    return 0;
}
