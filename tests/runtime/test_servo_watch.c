/* SPDX-License-Identifier: MIT
 *
 * A servo that is watched: the same commands to the last bit as one that is not, each stage told once a tick
 * in the table's order, what adds to contact within contact, and as often as contact is evaluated.
 */
#include "servo_bench.h"

enum { MOST = 32, TICKS = 2000 };

typedef struct seen {
    uint32_t order[MOST], begun[MOST], count, depth, open[MOST], within[MOST];
    int is_wrong;
} seen;

static void before(void *user, uint32_t stage)
{
    seen *s = user;
    if (s->depth == 0) {
        s->order[s->count++] = stage;
    } else {
        s->within[stage] = s->open[s->depth - 1] + 1;
        s->begun[stage]++;
    }
    s->open[s->depth++] = stage;
}

static void after(void *user, uint32_t stage)
{
    seen *s = user;
    s->is_wrong |= s->depth == 0 || s->open[s->depth - 1] != stage;
    s->depth--;
}

static uint32_t stage_named(const char *name)
{
    vxs_servo_stage stage;
    for (uint32_t n = 0; vxs_servo_stage_at(n, &stage) == VXS_OK; n++)
        if (strcmp(name, stage.name) == 0) return n;
    CHECK(!"such a stage");
    return 0;
}

static void check_coupling(uint32_t kind, uint32_t most_evaluations)
{
    static const uint32_t effects[] = {VXS_EFFECT_SOFT_START, VXS_EFFECT_START_INSIDE,    VXS_EFFECT_TORQUE,
                                       VXS_EFFECT_GRAVITY,    VXS_EFFECT_CONTACT_DAMPING, VXS_EFFECT_FRICTION,
                                       VXS_EFFECT_SLEW,       VXS_EFFECT_PASSIVITY};
    enum { EFFECTS = sizeof effects / sizeof *effects };
    servo_bench b[2];
    seen s = {0};
    const vxs_servo_watch watch = {before, after, &s};
    for (int n = 0; n < 2; n++) {
        bench_prepare(&b[n]);
        b[n].servo_config.coupling.kind = kind;
        b[n].servo_config.coupling.stiffness = 500;
        b[n].servo_config.coupling.radius = 0.01;
        for (int k = 0; k < EFFECTS; k++) bench_effect(&b[n], effects[k]);
        bench_open(&b[n]);
        bench_start(&b[n]);
    }
    void *memory = aligned_alloc(64, (vxs_servo_watch_memory() + 63) / 64 * 64);
    CHECK_INT(vxs_servo_watch_stages(b[1].servo, memory, vxs_servo_watch_memory() - 1, &watch), VXS_BUFFER);
    CHECK_INT(vxs_servo_watch_stages(b[1].servo, (char *)memory + 8, vxs_servo_watch_memory(), &watch),
              VXS_BUFFER);
    CHECK_INT(vxs_servo_watch_stages(NULL, memory, vxs_servo_watch_memory(), &watch), VXS_PARAM);
    CHECK_INT(vxs_servo_watch_stages(b[1].servo, memory, vxs_servo_watch_memory(), NULL), VXS_PARAM);
    CHECK_INT(vxs_servo_watch_stages(b[1].servo, memory, vxs_servo_watch_memory(), &watch), VXS_OK);

    const uint32_t contact = stage_named("contact"), friction = stage_named("friction");
    uint32_t most = 0, touched = 0;
    for (int k = 0; k < TICKS; k++) {
        vxs_servo_trace rows[2];
        memset(&s, 0, sizeof s);
        for (int n = 0; n < 2; n++) {
            b[n].state.pose.position[0] = 2e-6 * k;
            b[n].state.pose.position[1] = 0.012 - 3e-6 * (k < TICKS / 2 ? k : TICKS - k);
            bench_follow(&b[n], &rows[n]);
        }
        CHECK(memcmp(&b[0].command, &b[1].command, sizeof b[0].command) == 0);
        CHECK(memcmp(&rows[0], &rows[1], sizeof rows[0]) == 0);
        CHECK(!s.is_wrong && s.depth == 0);
        CHECK_INT(s.count, EFFECTS + 3);
        for (uint32_t n = 1; n < s.count; n++) CHECK(s.order[n] > s.order[n - 1]);
        for (uint32_t n = 0; n < MOST; n++) CHECK(!s.within[n] || s.within[n] == contact + 1);
        CHECK(s.begun[friction] >= 1 && s.begun[friction] <= most_evaluations);
        if (s.begun[friction] > most) most = s.begun[friction];
        touched += rows[1].points > 0;
    }
    CHECK(touched > 300);
    CHECK((most > 1) == (most_evaluations > 1));
    for (int n = 0; n < 2; n++) bench_close(&b[n]);
    free(memory);
}

int main(void)
{
    check_coupling(VXS_COUPLING_PT2, 1);
    check_coupling(VXS_COUPLING_QUASI_STATIC, VXS_COUPLING_MAX_EVALUATIONS);
    return 0;
}
