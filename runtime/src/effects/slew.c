/* SPDX-License-Identifier: MIT
 *
 * The slew limit: the wrench changes by at most a step a tick, along a straight line.
 */
#include "../servo_stage.h"

#include <string.h>

static const double full_time = 0.004; /* [s] from zero to the clamp, by default */

typedef struct slew {
    double force_step, torque_step; /* a tick */
    double max_force, max_torque;   /* of the clamp */
    vxs_wrench last;                /* within the clamp, so that the limit does not wind up beyond it */
} slew;

static const vxs_effect_constant constants[] = {{"force", "N/s", 0, 0, 1e12}, {"torque", "Nm/s", 0, 0, 1e12}};

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    slew *s = self;
    double force = effect->as.slew.force, torque = effect->as.slew.torque,
           sample_time = config->coupling.sample_time;
    s->force_step = sample_time * (force > 0 ? force : config->max_force / full_time);
    s->torque_step = sample_time * (torque > 0 ? torque : config->max_torque / full_time);
    s->max_force = config->max_force;
    s->max_torque = config->max_torque;
}

static void reset(void *self, const vxs_pose *tip)
{
    slew *s = self;
    (void)tip;
    memset(&s->last, 0, sizeof s->last);
}

/* Moves v from last towards v by at most `most`, keeps it within limit and as the next last. Returns whether
 * that was less than the way. */
static int follow(double last[3], double v[3], double most, double limit)
{
    double way[3] = {v[0] - last[0], v[1] - last[1], v[2] - last[2]};
    double factor = vxs_device_clamp_factor(way, most);
    if (factor < 1)
        for (int axis = 0; axis < 3; axis++) v[axis] = last[axis] + factor * way[axis];
    double inside = vxs_device_clamp_factor(v, limit);
    for (int axis = 0; axis < 3; axis++) last[axis] = v[axis] * inside;
    return factor < 1;
}

static void run(void *self, vxs_tick *tick)
{
    slew *s = self;
    if (follow(s->last.force, tick->wrench.force, s->force_step, s->max_force))
        tick->flags |= VXS_SERVO_SLEWED;
    if (follow(s->last.torque, tick->wrench.torque, s->torque_step, s->max_torque))
        tick->flags |= VXS_SERVO_SLEWED;
}

extern const vxs_effect_kind vxsi_stage_slew;
const vxs_effect_kind vxsi_stage_slew = {.effect = VXS_EFFECT_SLEW,
                                         .is_guard = 1,
                                         .name = "slew",
                                         .reads = "the command before",
                                         .size = sizeof(slew),
                                         .constants = constants,
                                         .constant_count = sizeof constants / sizeof *constants,
                                         .set_up = set_up,
                                         .reset = reset,
                                         .run = run};
