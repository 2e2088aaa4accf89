/* SPDX-License-Identifier: MIT
 *
 * No force until the object was free once. It has no constants.
 */
#include "../servo_stage.h"

typedef struct start_inside {
    uint32_t was_free; /* since the reset */
} start_inside;

static void reset(void *self, const vxs_pose *tip)
{
    (void)tip;
    ((start_inside *)self)->was_free = 0;
}

static void run(void *self, vxs_tick *tick)
{
    start_inside *s = self;
    if (s->was_free) return;
    if (tick->contact.points > 0 || tick->contact.deep_points > 0)
        tick->flags |= VXS_SERVO_START_IN_CONTACT;
    else
        s->was_free = 1;
}

extern const vxs_effect_kind vxsi_stage_start_inside;
const vxs_effect_kind vxsi_stage_start_inside = {.effect = VXS_EFFECT_START_INSIDE,
                                                 .is_guard = 1,
                                                 .name = "start-inside",
                                                 .reads = "whether anything touches",
                                                 .size = sizeof(start_inside),
                                                 .reset = reset,
                                                 .run = run};
