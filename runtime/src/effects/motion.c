/* SPDX-License-Identifier: MIT
 *
 * Statics that move as keyframes say.
 */
#include "../contact_state.h"
#include "../servo_state.h"

#include <math.h>
#include <string.h>

/* One static's way. */
typedef struct way {
    const vxs_effect_keyframe *frames;
    uint32_t count;
    uint32_t is_known; /* where it was in the tick before */
    vxs_pose pose;
} way;

/* After it: moving.count statics, their twists and parts, the ways. */
typedef struct motion {
    double sample_time, loop;
    double ticks; /* since the reset */
    vxs_moving moving;
    vxs_contact_static *statics; /* the servo's, with the poses of those that move */
    way *ways;
    uint32_t way_count;
} motion;

static const vxs_effect_constant constants[] = {{"loop", "", 0, 0, 1}};

static vxs_result check(const vxs_effect *effect)
{
    double rotation[9];
    if (effect->as.motion.loop != 0 && effect->as.motion.loop != 1) return VXS_PARAM;
    if (!effect->keyframes || effect->keyframe_count < 1 || effect->keyframe_count > VXS_EFFECT_MAX_KEYFRAMES)
        return VXS_PARAM;
    for (uint32_t n = 0; n < effect->keyframe_count; n++) {
        const vxs_effect_keyframe *frame = &effect->keyframes[n], *before = n ? frame - 1 : NULL;
        if (!(frame->time >= 0 && isfinite(frame->time)) || frame->reserved ||
            !vxs_pose_rotation(&frame->pose, rotation))
            return VXS_PARAM;
        if (before && (frame->static_index < before->static_index ||
                       (frame->static_index == before->static_index && !(frame->time > before->time))))
            return VXS_PARAM;
    }
    return VXS_OK;
}

static vxs_result fits(const vxs_effect *effect, const vxs_servo_config *config)
{
    return effect->keyframes[effect->keyframe_count - 1].static_index < config->static_count ? VXS_OK
                                                                                             : VXS_PARAM;
}

static uint32_t count_ways(const vxs_effect *effect)
{
    uint32_t count = 1;
    for (uint32_t n = 1; n < effect->keyframe_count; n++)
        count += effect->keyframes[n].static_index != effect->keyframes[n - 1].static_index;
    return count;
}

static size_t extra(const vxs_effect *effect, const vxs_servo_config *config)
{
    return config->static_count * (sizeof(vxs_contact_static) + sizeof(vxs_twist) + sizeof(vxs_wrench)) +
           count_ways(effect) * sizeof(way);
}

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    motion *m = self;
    const uint32_t count = config->static_count;
    m->sample_time = config->coupling.sample_time;
    m->loop = effect->as.motion.loop;
    m->moving.count = count;
    m->moving.twists = (vxs_twist *)(m + 1);
    m->moving.parts = (vxs_wrench *)(m->moving.twists + count);
    m->statics = (vxs_contact_static *)(m->moving.parts + count);
    m->ways = (way *)(m->statics + count);
    memcpy(m->statics, config->statics, count * sizeof *m->statics);
    for (uint32_t n = 0; n < effect->keyframe_count; n++) {
        const vxs_effect_keyframe *frame = &effect->keyframes[n];
        if (n == 0 || frame->static_index != frame[-1].static_index) {
            way *w = &m->ways[m->way_count++];
            w->frames = frame;
            w->pose = frame->pose;
            m->statics[frame->static_index].pose = &w->pose;
        }
        m->ways[m->way_count - 1].count++;
    }
}

static void attach(void *self, vxs_servo *servo)
{
    motion *m = self;
    servo->config.statics = m->statics;
    servo->contact->parts = m->moving.parts;
    servo->moving = &m->moving;
}

static void reset(void *self, const vxs_pose *tip)
{
    motion *m = self;
    (void)tip;
    m->ticks = 0;
    for (uint32_t n = 0; n < m->way_count; n++) m->ways[n].is_known = 0;
}

/* Between two poses, both of orientations of any length. */
static void between(const vxs_pose *from, const vxs_pose *to, double share, vxs_pose *out)
{
    const double *a = from->orientation, *b = to->orientation;
    double aa = 0, bb = 0, ab = 0, length = 0;
    for (int i = 0; i < 4; i++) {
        aa += a[i] * a[i];
        bb += b[i] * b[i];
        ab += a[i] * b[i];
    }
    const double of_a = (1 - share) / sqrt(aa), of_b = (ab < 0 ? -share : share) / sqrt(bb);
    for (int i = 0; i < 3; i++)
        out->position[i] = from->position[i] + share * (to->position[i] - from->position[i]);
    for (int i = 0; i < 4; i++) {
        out->orientation[i] = of_a * a[i] + of_b * b[i];
        length += out->orientation[i] * out->orientation[i];
    }
    for (int i = 0; i < 4; i++) out->orientation[i] /= sqrt(length);
}

/* The pose at a time. */
static void pose_at(const way *w, double time, int is_loop, vxs_pose *out)
{
    const vxs_effect_keyframe *f = w->frames;
    const double end = f[w->count - 1].time;
    if (is_loop && end > 0) time -= end * floor(time / end);
    uint32_t low = 0, high = w->count - 1; /* the last frame that is not after it is in low .. high */
    while (low < high) {
        uint32_t middle = high - (high - low) / 2;
        if (f[middle].time <= time)
            low = middle;
        else
            high = middle - 1;
    }
    double share = 0;
    const uint32_t next = low + 1 < w->count ? low + 1 : low;
    if (next > low && time > f[low].time) share = (time - f[low].time) / (f[next].time - f[low].time);
    between(&f[low].pose, &f[next].pose, share, out);
}

static void run(void *self, vxs_tick *tick)
{
    motion *m = self;
    const double time = m->ticks * m->sample_time;
    m->ticks += 1;
    for (uint32_t n = 0; n < m->way_count; n++) {
        way *w = &m->ways[n];
        vxs_twist *twist = &m->moving.twists[w->frames->static_index];
        const vxs_pose before = w->pose;
        pose_at(w, time, m->loop != 0, &w->pose);
        memset(twist, 0, sizeof *twist);
        memcpy(twist->origin, w->pose.position, sizeof twist->origin);
        if (w->is_known) {
            vxs_pose_turn(before.orientation, w->pose.orientation, twist->spin);
            for (int i = 0; i < 3; i++) {
                twist->velocity[i] = (w->pose.position[i] - before.position[i]) / tick->elapsed;
                twist->spin[i] /= tick->elapsed;
            }
        }
        w->is_known = 1;
    }
}

extern const vxs_effect_kind vxsi_stage_motion;
const vxs_effect_kind vxsi_stage_motion = {.effect = VXS_EFFECT_MOTION,
                                           .name = "motion",
                                           .reads =
                                               "the ticks since arming; keyframes of the statics that move",
                                           .changes = "contact",
                                           .size = sizeof(motion),
                                           .constants = constants,
                                           .constant_count = sizeof constants / sizeof *constants,
                                           .check = check,
                                           .fits = fits,
                                           .extra = extra,
                                           .has_keyframes = 1,
                                           .set_up = set_up,
                                           .attach = attach,
                                           .reset = reset,
                                           .run = run};
