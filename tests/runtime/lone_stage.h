/* SPDX-License-Identifier: MIT
 *
 * lone_stage.h - one stage of the tick on its own, for tests: what it makes of poses and wrenches that are
 * made up. A sample is 1 ms; the shell's middle is at (0, 0, 0) and its radius 10 mm. Change the config
 * between lone_prepare() and lone_open().
 */
#ifndef VXS_TEST_LONE_STAGE_H
#define VXS_TEST_LONE_STAGE_H

#include "check.h"
#include "servo_stage.h"

typedef struct lone_stage {
    const vxs_effect_kind *stage;
    double memory[1024];
    vxs_pointshell shell;
    vxs_servo_config config;
    vxs_effect effect;
    vxs_device_state state;
    vxs_wrench last; /* what the tick before made */
    vxs_tick tick;
} lone_stage;

static inline vxs_effect *lone_prepare(lone_stage *l, uint32_t kind)
{
    memset(l, 0, sizeof *l);
    l->shell.radius = 0.01;
    vxs_servo_config_default(&l->config);
    l->config.shell = &l->shell;
    l->config.coupling.sample_time = 0.001;
    CHECK_INT(vxs_effect_default(kind, &l->effect), VXS_OK);
    return &l->effect;
}

static inline void lone_open(lone_stage *l)
{
    vxs_pose identity = vxs_pose_identity();
    l->stage = vxsi_stage_of(l->effect.kind);
    CHECK(l->stage && l->stage->size <= sizeof l->memory);
    CHECK_INT(vxs_effect_check(&l->effect), VXS_OK);
    memset(l->memory, 0, sizeof l->memory);
    l->stage->set_up(l->memory, &l->effect, &l->config);
    if (l->stage->reset) l->stage->reset(l->memory, &identity);
}

/* A tick with the device and the object at `pose` and a wrench of contact: to change before lone_run(). */
static inline vxs_tick *lone_tick(lone_stage *l, const vxs_pose *pose, const vxs_wrench *wrench)
{
    memset(&l->tick, 0, sizeof l->tick);
    l->state.pose = l->tick.tip = l->tick.body = *pose;
    l->tick.state = &l->state;
    l->tick.last = &l->last;
    l->tick.elapsed = l->config.coupling.sample_time;
    l->tick.share = 1;
    if (wrench) l->tick.wrench = *wrench;
    return &l->tick;
}

static inline void lone_run(lone_stage *l)
{
    (l->stage->add ? l->stage->add : l->stage->run)(l->memory, &l->tick);
    l->last = l->tick.wrench;
}

/* The orientation of a turn about a unit axis. */
static inline void lone_turn(double orientation[4], const double axis[3], double angle)
{
    orientation[0] = cos(angle / 2);
    for (int i = 0; i < 3; i++) orientation[1 + i] = sin(angle / 2) * axis[i];
}

#endif
