/* SPDX-License-Identifier: MIT
 *
 * servo_state.h - private: the servo's memory.
 */
#ifndef VXSI_SERVO_STATE_H
#define VXSI_SERVO_STATE_H

#include "servo_stage.h"

/* A stage of this servo's tick. */
typedef struct vxsi_step {
    void (*run)(void *self, vxs_tick *tick);
    void *self;
    void (*reset)(void *self, const vxs_pose *tip); /* may be NULL */
    uint32_t row;                                   /* of the table */
} vxsi_step;

/* What a stage does within the stage contact. */
typedef struct vxsi_adder {
    void (*add)(void *self, vxs_tick *tick);
    void *self;
    uint32_t row;
} vxsi_adder;

struct vxs_servo {
    vxs_servo_config config; /* without its list of effects */
    vxs_contact *contact;
    vxs_coupling *coupling;
    double mount[9]; /* rotation device -> scene */
    int64_t hold_ns, decay_ns, sample_ns;
    uint32_t is_live;   /* the tick before went through all steps */
    uint32_t was_armed; /* in the tick before */
    uint32_t has_fault;
    uint32_t has_last;
    uint32_t has_torque;
    uint32_t guards;          /* bit k: the list of effects has the kind k of those that motors want */
    uint32_t has_body;        /* the object: a stage or the coupling moves it, not the hand */
    const vxs_moving *moving; /* NULL: no static does */
    uint32_t step_count, adder_count;
    vxsi_step steps[VXSI_STAGE_MOST];
    vxsi_adder adders[VXSI_STAGE_MOST];
    void (*pose)(const void *self, const vxs_pose *tip, vxs_pose *body); /* NULL: the coupling's */
    void *pose_self;
    uint64_t tick;
    uint64_t last_sequence;
    int64_t last_time_ns, last_news_ns; /* of the last tick; of the last new measurement */
    vxs_pose last_pose;                 /* of the device, at */
    int64_t last_pose_ns;
    vxs_device_command command;
};

#endif
