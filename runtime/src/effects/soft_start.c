/* SPDX-License-Identifier: MIT
 *
 * The ramp: a gain that grows from 0 at arming, and goes on after missed ticks from what the hand still felt.
 */
#include "../servo_stage.h"

typedef struct soft_start {
    double step; /* a tick */
    double gain;
} soft_start;

static const vxs_effect_constant constants[] = {{"time", "s", 0.5, 0, 3600}};

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    double time = effect->as.soft_start.time;
    ((soft_start *)self)->step = time > 0 ? config->coupling.sample_time / time : 1;
}

static void reset(void *self, const vxs_pose *tip)
{
    (void)tip;
    ((soft_start *)self)->gain = 0;
}

static void run(void *self, vxs_tick *tick)
{
    soft_start *s = self;
    double gain = s->gain * tick->share + s->step;
    s->gain = gain < 1 ? gain : 1;
    if (s->gain < 1) tick->flags |= VXS_SERVO_RAMPING;
    for (int axis = 0; axis < 3; axis++) {
        tick->wrench.force[axis] *= s->gain;
        tick->wrench.torque[axis] *= s->gain;
    }
    tick->gain = s->gain;
}

extern const vxs_effect_kind vxsi_stage_soft_start;
const vxs_effect_kind vxsi_stage_soft_start = {.effect = VXS_EFFECT_SOFT_START,
                                               .is_guard = 1,
                                               .name = "soft-start",
                                               .reads = "the ticks since arming",
                                               .size = sizeof(soft_start),
                                               .constants = constants,
                                               .constant_count = sizeof constants / sizeof *constants,
                                               .set_up = set_up,
                                               .reset = reset,
                                               .run = run};
