/* SPDX-License-Identifier: MIT
 *
 * Stages that tell when they begin and end: each gets another one around it. Not part of the tick.
 */
#include "servo_state.h"

typedef struct watched {
    void (*work)(void *self, vxs_tick *tick);
    void (*reset)(void *self, const vxs_pose *tip); /* may be NULL */
    void *self;
    const vxs_servo_watch *watch;
    uint32_t row;
} watched;

typedef struct watching {
    vxs_servo_watch watch;
    watched steps[VXSI_STAGE_MOST], adders[VXSI_STAGE_MOST];
} watching;

enum { ALIGNMENT = 16 };

static void work_watched(void *self, vxs_tick *tick)
{
    const watched *stage = self;
    stage->watch->before(stage->watch->user, stage->row);
    stage->work(stage->self, tick);
    stage->watch->after(stage->watch->user, stage->row);
}

static void reset_watched(void *self, const vxs_pose *tip)
{
    const watched *stage = self;
    stage->reset(stage->self, tip);
}

/* Of a stage that only adds to another one: told all the same, so that what telling takes can be seen. */
static void no_work(void *self, vxs_tick *tick)
{
    (void)self;
    (void)tick;
}

size_t vxs_servo_watch_memory(void)
{
    return sizeof(watching);
}

vxs_result vxs_servo_watch_stages(vxs_servo *servo, void *memory, size_t size, const vxs_servo_watch *watch)
{
    if (!servo || !memory || !watch || !watch->before || !watch->after) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < sizeof(watching)) return VXS_BUFFER;
    watching *w = memory;
    w->watch = *watch;
    for (uint32_t n = 0; n < servo->step_count; n++) {
        vxsi_step *step = &servo->steps[n];
        w->steps[n] =
            (watched){step->run ? step->run : no_work, step->reset, step->self, &w->watch, step->row};
        step->run = work_watched;
        step->reset = step->reset ? reset_watched : NULL;
        step->self = &w->steps[n];
    }
    for (uint32_t n = 0; n < servo->adder_count; n++) {
        vxsi_adder *adder = &servo->adders[n];
        w->adders[n] = (watched){adder->add, NULL, adder->self, &w->watch, adder->row};
        adder->add = work_watched;
        adder->self = &w->adders[n];
    }
    return VXS_OK;
}
