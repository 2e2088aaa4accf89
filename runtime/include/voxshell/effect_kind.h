/* SPDX-License-Identifier: MIT
 *
 * effect_kind.h - a kind of effect (effect.h), for whoever writes one: voxshell's are rows of a table, a
 * program's own is given to the config, with the shared library as with the archive:
 *
 *     static const vxs_effect_kind lab_magnet = {
 *         .struct_size = sizeof(vxs_effect_kind), .tick_size = sizeof(vxs_tick), .name = "lab-magnet",
 *         .size = sizeof(magnet), .constants = constants, .constant_count = 5, .set_up = set_up, .run = run};
 *     vxs_effect_own(&lab_magnet, &effects[n]);           (then its constants; then it is one of the list)
 *
 * samples/own_effect is a whole one. The kind is borrowed until the servo's last tick.
 *
 * Threads: check, fits, extra, compliance, stiffness, set_up and attach run where vxs_servo_init() is called,
 * and may take their time. reset, run, add and pose run in the tick, in the thread that calls it: they may not
 * block, allocate, lock, log, call the system or a transcendental function; sqrt, fabs, memcpy and the rt-safe
 * functions of these headers are what they may call. What an effect keeps from tick to tick is in `self`.
 *
 * What comes after an own effect holds whatever it does: passivity and slew where the config lists them,
 * clamp, soft-start; a number that is not finite latches FAULT.
 *
 * Promised: within a major version fields are only added, at the end, so that a source goes on compiling. The
 * two sizes say which headers it was compiled with: a library of another layout refuses it (VXS_CONFIG).
 */
#ifndef VOXSHELL_EFFECT_KIND_H
#define VOXSHELL_EFFECT_KIND_H

#include "voxshell/servo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How a static moves: what of it is at `origin` with `velocity`, the rest turns about that. Scene's frame. */
typedef struct vxs_twist {
    double origin[3];   /* [m] */
    double velocity[3]; /* [m/s] */
    double spin[3];     /* [rad/s] */
} vxs_twist;

/* The statics while some move, as many as the servo has. */
typedef struct vxs_moving {
    vxs_twist *twists; /* by static */
    vxs_wrench *parts; /* of contact.wrench, by static */
    uint32_t count;    /* of both */
} vxs_moving;

/* What stages hand on, from the first to the last. SI. Voxshell's own stages write more of it; an own effect
 * writes wrench, field and has_field (vxs_tick_add_field()) and flags, and reads the rest. */
typedef struct vxs_tick {
    const vxs_device_state *state; /* finite; device frame */
    double elapsed;                /* since the tick before [s], at least a sample */
    vxs_pose tip;                  /* the device's tip in the scene */
    vxs_pose body;                 /* where the tip of the object is: contact was evaluated there */
    uint32_t evaluation;           /* of contact in this tick, from 0 on */
    uint32_t has_body;          /* the object is a body with a mass of its own, not where the hand has it */
    const vxs_moving *moving;   /* NULL: nothing does */
    vxs_contact_result contact; /* from the stage contact on */
    vxs_wrench output;          /* from the stage coupling on; scene's frame */
    /* On the hand. Up to the stage coupling at the object and in the scene's frame, after it at the tip and
     * in the device's. */
    vxs_wrench wrench;
    vxs_wrench field;       /* as wrench up to the stage coupling, but passes it by: vxs_tick_add_to_hand() */
    uint32_t has_field;     /* not 0: field is to be added */
    const vxs_wrench *last; /* commanded by the tick before */
    double share;  /* 0 .. 1 of it that the device still rendered when this tick came: 1 unless it was late */
    double gain;   /* for the trace: of the ramp, 0 .. 1 */
    double energy; /* for the trace [J] */
    double damping;    /* for the trace [N s/m] */
    uint32_t is_armed; /* not 0: the device is, and was heard of */
    uint32_t flags; /* VXS_SERVO_*. OFF, START_IN_CONTACT or FAULT ends the list: zero wrench, and all stages
                       are reset */
} vxs_tick;

/* A kind. What is optional may be NULL. */
typedef struct vxs_effect_kind {
    uint32_t struct_size; /* sizeof(vxs_effect_kind) */
    uint32_t tick_size;   /* sizeof(vxs_tick) */
    uint32_t effect;   /* VXS_EFFECT_* of voxshell's, 0: a stage that is always there, its self is the servo;
                        an own one's is not looked at */
    uint32_t is_guard; /* not 0: it only takes away from what is felt */
    const char *name;  /* as people write it: "lab-magnet" */
    const char *reads; /* for people: what it goes by */
    const char *changes; /* for people and who measures: other stages that do more or less for it; optional */
    /* An own one: the name of the stage that it runs before (vxs_servo_stage_at()), "contact" to the one that
     * follows the coupling, "passivity". NULL: "inertia", the last that is at the object. */
    const char *before;
    size_t size;                          /* bytes of self */
    const vxs_effect_constant *constants; /* names, units, ranges, defaults; optional */
    uint32_t constant_count;              /* VXS_EFFECT_MAX_CONSTANTS at most */
    uint32_t has_keyframes;               /* not 0: it takes vxs_effect.keyframes */
    /* Beyond the constants' ranges: VXS_OK, or what is wrong. Optional. */
    vxs_result (*check)(const vxs_effect *effect);
    /* What the rest of the servo must be for it; the effect itself is sound. Optional. */
    vxs_result (*fits)(const vxs_effect *effect, const vxs_servo_config *config);
    /* More bytes of self, behind it, at a multiple of 16. Optional. */
    size_t (*extra)(const vxs_effect *effect, const vxs_servo_config *config);
    /* Of one with a pose of its own, which must have it: how much a stiffness at its tip moves it at most [1/kg],
     * in the measure of contact.h's most_stiffness. */
    double (*compliance)(const vxs_effect *effect, const vxs_servo_config *config);
    /* Of others: what they have of such a stiffness, damping / T counted in, at the shell's points [N/m]. The
     * servo refuses more than a body can be stepped with. Optional. */
    double (*stiffness)(const vxs_effect *effect, const vxs_servo_config *config);
    /* self is all 0 before; config is the servo's, without effects. Optional. */
    void (*set_up)(void *self, const vxs_effect *effect, const vxs_servo_config *config);
    /* After set_up: for voxshell's own stages, which know what a servo is made of. Optional. */
    void (*attach)(void *self, vxs_servo *servo);
    /* In the tick: to rest with the device at the tip. Optional. */
    void (*reset)(void *self, const vxs_pose *tip);
    /* In the tick, once, in its place of the list. Optional if there is add. */
    void (*run)(void *self, vxs_tick *tick);
    /* In the tick, after each evaluation of contact, of which there can be several: adds to the wrench what else
     * acts on the object at `body`. Each goes on from where the last tick ended, not from the evaluation
     * before it. Optional if there is run. */
    void (*add)(void *self, vxs_tick *tick);
    /* In the tick, in place of the coupling's: where the object is. Optional; one effect of a servo at most. */
    void (*pose)(const void *self, const vxs_pose *tip, vxs_pose *body);
} vxs_effect_kind;

/* An effect of an own kind, with its constants as they are by default. VXS_OK; VXS_PARAM (no name, neither run
 * nor add, too many constants); VXS_CONFIG (compiled with headers of another layout). Thread: any, rt-safe. */
VXS_API vxs_result vxs_effect_own(const vxs_effect_kind *kind, vxs_effect *effect);

/* Adds up. Thread: any, rt-safe. */
static inline void vxs_wrench_add(vxs_wrench *to, const vxs_wrench *more)
{
    for (int axis = 0; axis < 3; axis++) {
        to->force[axis] += more->force[axis];
        to->torque[axis] += more->torque[axis];
    }
}

/* On the hand, whatever the coupling. Before the stage coupling. Thread: the servo's, rt-safe. */
static inline void vxs_tick_add_to_hand(vxs_tick *tick, const vxs_wrench *more)
{
    vxs_wrench_add(&tick->field, more);
    tick->has_field = 1;
}

/* What acts on the object besides contact: on its body, or as it is on the hand. A filter that is there for
 * contact would only delay it, and drag that comes late does not damp. Before the stage coupling.
 * Thread: the servo's, rt-safe. */
static inline void vxs_tick_add_field(vxs_tick *tick, const vxs_wrench *more)
{
    if (tick->has_body)
        vxs_wrench_add(&tick->wrench, more);
    else
        vxs_tick_add_to_hand(tick, more);
}

#ifdef __cplusplus
}
#endif
#endif
