/* SPDX-License-Identifier: MIT
 *
 * servo_stage.h - private: what a stage of the tick is. An effect is src/effects/NAME.c and one row of
 * servo_table.c; taking both away takes the effect away and nothing else. Its file is part of the tick:
 * nothing in it may block, allocate, lock, call the system or a transcendental function. A long set-up stands
 * in NAME_setup.c, which is not.
 */
#ifndef VXSI_SERVO_STAGE_H
#define VXSI_SERVO_STAGE_H

#include "voxshell/servo.h"

/* How a static moves: what of it is at `origin` with `velocity`, the rest turns about that. Scene's frame. */
typedef struct vxsi_twist {
    double origin[3], velocity[3], spin[3];
} vxsi_twist;

/* The statics while some move, as many as the servo has. */
typedef struct vxsi_moving {
    vxsi_twist *twists;
    vxs_wrench *parts; /* of contact.wrench, by static */
    uint32_t count;
} vxsi_moving;

/* What stages hand on, from the first to the last. */
typedef struct vxsi_tick {
    const vxs_device_state *state; /* finite; device frame */
    double elapsed;                /* since the tick before [s], at least a sample */
    vxs_pose tip;                  /* the device's tip in the scene */
    vxs_pose body;                 /* where the tip of the object is: contact was evaluated there */
    uint32_t evaluation;           /* of contact in this tick, from 0 on */
    uint32_t has_body;          /* the object is a body with a mass of its own, not where the hand has it */
    const vxsi_moving *moving;  /* NULL: nothing does */
    vxs_contact_result contact; /* from the stage contact on */
    vxs_wrench output;          /* from the stage coupling on; scene's frame */
    /* On the hand. Up to the stage coupling at the object and in the scene's frame, after it at the tip and
     * in the device's. */
    vxs_wrench wrench;
    vxs_wrench field; /* as wrench up to the stage coupling, but passes it by: vxsi_add_to_hand() */
    uint32_t has_field;
    const vxs_wrench *last; /* commanded by the tick before */
    double share; /* of it that the device still rendered when this tick came: 1 unless it was late */
    double gain, energy, damping; /* for the trace */
    uint32_t is_armed;
    uint32_t flags; /* one of VXSI_TICK_ENDS ends the list: zero wrench, and all stages are reset */
} vxsi_tick;

enum { VXSI_TICK_ENDS = VXS_SERVO_OFF | VXS_SERVO_START_IN_CONTACT | VXS_SERVO_FAULT };

typedef struct vxsi_stage {
    uint32_t effect; /* VXS_EFFECT_*; 0: always there, its self is the servo */
    uint32_t is_guard;
    const char *name;    /* as people write it */
    const char *reads;   /* for people: what it goes by */
    const char *changes; /* for people and who measures: other stages that do more or less for it */
    size_t size;         /* bytes of self */
    /* At set-up, of an effect; optional. check: beyond the constants' ranges. self is all 0 before set_up. */
    const vxs_effect_constant *constants;
    uint32_t constant_count;
    vxs_result (*check)(const vxs_effect *effect);
    /* What the rest of the servo must be for it; the effect itself is sound. Optional. */
    vxs_result (*fits)(const vxs_effect *effect, const vxs_servo_config *config);
    uint32_t has_keyframes;
    size_t (*extra)(const vxs_effect *effect, const vxs_servo_config *config); /* more bytes of self */
    /* Of a stage with a pose of its own: how much a stiffness at its tip moves it at most [1/kg], in the
     * measure of contact.h's most_stiffness. Of others: what they have of such a stiffness, damping / T
     * counted in, at
     * the shell's points. The servo refuses more than a body can be stepped with. Optional. */
    double (*compliance)(const vxs_effect *effect, const vxs_servo_config *config);
    double (*stiffness)(const vxs_effect *effect, const vxs_servo_config *config);
    /* config is the servo's, without effects. */
    void (*set_up)(void *self, const vxs_effect *effect, const vxs_servo_config *config);
    void (*attach)(void *self, vxs_servo *servo); /* after set_up, when all but effects is there */
    /* In the tick. reset: to rest with the device at the tip; optional. */
    void (*reset)(void *self, const vxs_pose *tip);
    void (*run)(void *self, vxsi_tick *tick); /* optional if there is add */
    /* After each evaluation of contact, of which a tick can have several: adds to the wrench what else acts
     * on the object at `body`. Each goes on from where the last tick ended, not from the evaluation before
     * it. Optional. */
    void (*add)(void *self, vxsi_tick *tick);
    /* In place of the coupling's: where the object is. Optional; one stage at most. */
    void (*pose)(const void *self, const vxs_pose *tip, vxs_pose *body);
} vxsi_stage;

/* In order of execution. */
extern const vxsi_stage *const vxsi_servo_table[];
extern const uint32_t vxsi_servo_table_size;

/* A body's stability: stiffness x compliance x T^2 is at most this, of contact (which contact-damping may
 * make stiffer) and of each effect. Kick and drift end at 4 of all together. */
#define VXSI_CONTACT_SHARE 0.25
#define VXSI_EFFECT_SHARE 1.0

enum { VXSI_STAGE_MOST = 32 };

/* The row of an effect, NULL for none such. */
const vxsi_stage *vxsi_stage_of(uint32_t effect);

static inline void vxsi_add(vxs_wrench *to, const vxs_wrench *more)
{
    for (int axis = 0; axis < 3; axis++) {
        to->force[axis] += more->force[axis];
        to->torque[axis] += more->torque[axis];
    }
}

/* On the hand, whatever the coupling. */
static inline void vxsi_add_to_hand(vxsi_tick *tick, const vxs_wrench *more)
{
    vxsi_add(&tick->field, more);
    tick->has_field = 1;
}

/* What acts on the object besides contact: on its body, or as it is on the hand. A filter that is there for
 * contact would only delay it, and drag that comes late does not damp. */
static inline void vxsi_add_field(vxsi_tick *tick, const vxs_wrench *more)
{
    if (tick->has_body)
        vxsi_add(&tick->wrench, more);
    else
        vxsi_add_to_hand(tick, more);
}

#endif
