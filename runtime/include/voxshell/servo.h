/* SPDX-License-Identifier: MIT
 *
 * servo.h - the loop: device state in, device command out, once a sample.
 *
 * vxs_servo_tick() is pure: no clock, no system call, no allocation; virtual or real time is the
 * caller's choice. One tick:
 *     pose -> contact -> coupling -> clamp (one common factor) -> command
 * with the effects that the config lists between them (effect.h), each where its nature puts it.
 * vxs_servo_thread runs device exchange and tick on the wall clock (servo_thread.h).
 *
 * What a hand can rely on:
 *   - force is zero until the device is ARMED;
 *   - no force above max_force, no torque above max_torque; their directions are kept;
 *   - a number that is not finite, from the device or from a computation: FAULT, zero force, latched
 *     until vxs_servo_clear();
 *   - a stalled loop or link: the command decays to zero within decay_time (10 ms) of its deadline;
 *   - a device in FAULT or GONE gets zero;
 *   - nothing is remembered across an arming, a fault or a teleport (max_speed): coupling and effects begin
 *     from rest.
 * And unless the config lists other effects than the default ones:
 *   - force ramps up over 0.5 s from arming on, and after a stall from what the hand felt last (soft-start);
 *   - armed inside or touching the scene: zero and VXS_SERVO_START_IN_CONTACT until it was free once
 *     (start-inside).
 * A device with motors is not driven without these two: vxs_servo_may_drive(), which vxs_servo_thread_start()
 * asks. Who owns the loop asks it before arming.
 *
 *     vxs_servo_config config;
 *     vxs_servo_config_default(&config);
 *     vxs_contact_static statics = {&map, NULL};
 *     config.statics = &statics;
 *     config.static_count = 1;
 *     config.shell = &shell;
 *     config.max_force = device->caps.peak_force;
 *     void *memory = aligned_alloc(64, vxs_servo_memory(&config));
 *     vxs_servo_init(memory, vxs_servo_memory(&config), &config, &servo);
 *     if (vxs_servo_may_drive(servo, &device->caps) != VXS_OK) return;
 *     vxs_device_arm(device);
 *     for (;;) {
 *         vxs_device_exchange(device, &command, &state, NULL);
 *         vxs_servo_tick(servo, &state, &command, NULL);
 *     }
 */
#ifndef VOXSHELL_SERVO_H
#define VOXSHELL_SERVO_H

#include "voxshell/contact.h"
#include "voxshell/coupling.h"
#include "voxshell/device.h"
#include "voxshell/effect.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Flags of a tick. The low byte is the contact's (VXS_CONTACT_*). */
enum {
    VXS_SERVO_CONTACT_FLAGS = 0xFF,       /* mask of the contact's */
    VXS_SERVO_OFF = 1 << 8,               /* the device is not ARMED: zero force */
    VXS_SERVO_RAMPING = 1 << 9,           /* the gain is still below 1 */
    VXS_SERVO_START_IN_CONTACT = 1 << 10, /* zero force until the object was free once */
    VXS_SERVO_SLEWED = 1 << 11,           /* the slew limit acted */
    VXS_SERVO_SATURATED = 1 << 12,        /* the clamp acted */
    VXS_SERVO_DEVICE_STALE = 1 << 13,     /* no new measurement since the last tick */
    VXS_SERVO_MISSED = 1 << 14,           /* ticks were missed before this one */
    VXS_SERVO_DEVICE_LOST = 1 << 15,      /* in FAULT, GONE, or stale past hold and decay: zero force */
    VXS_SERVO_FAULT = 1 << 16,            /* latched zero force until vxs_servo_clear() */
    VXS_SERVO_TELEPORT = 1 << 17, /* moved faster than max_speed, or turned over 90 degrees: as just armed */
    VXS_SERVO_DAMPED = 1 << 18    /* the passivity controller acted */
};

/* Config. statics, their maps and shell are borrowed until the servo's last tick. */
typedef struct vxs_servo_config {
    uint32_t struct_size;
    uint32_t static_count;             /* of statics, 1 .. VXS_CONTACT_MAX_STATICS */
    const vxs_contact_static *statics; /* the static scene; poses may change between ticks */
    const vxs_pointshell *shell;       /* the dynamic object */
    vxs_pose mount;                    /* device frame -> scene frame; default identity */
    vxs_pose grip; /* shell -> device tip, scene metres; default identity. Torque is about the tip:
                      contact.reference is set from it */
    double scale;  /* scene metres per device metre [1], > 0; default 1 */
    vxs_contact_config contact;   /* law, field, stiffness */
    vxs_coupling_config coupling; /* its sample_time is the tick's T */
    double max_force;             /* [N] > 0; default 3 */
    double max_torque;            /* [N m] > 0; default 0.2 */
    double max_speed;             /* of the device [m/s] > 0; beyond it is no motion; default 20 */
    const vxs_effect *
        effects; /* effect_count, each kind once, 16 own ones at most, in any order; copied by vxs_servo_init().
                                     Default: start-inside, torque and soft-start as they are by default */
    uint32_t effect_count; /* of effects */
    uint32_t reserved;
    double hold_time;  /* [s] >= 0 a command is full; 0 (default): two samples */
    double decay_time; /* [s] > 0 from there to zero; default 0.01 */
} vxs_servo_config;

/* One row of a trace. Frame: the device's for pose and command, the scene's for the others. */
typedef struct vxs_servo_trace {
    uint64_t tick;        /* from 0 on */
    int64_t time_ns;      /* the device's */
    vxs_pose pose;        /* of the device */
    vxs_pose body;        /* that contact was evaluated with: the device's tip, or what the coupling hangs on
                             it; all 0 in a tick without contact's stage */
    vxs_wrench collision; /* of the contact */
    vxs_wrench output;    /* of the coupling, before what follows it */
    vxs_wrench command;   /* as commanded */
    double depth;         /* [m] */
    double gain;          /* of the ramp, 0 .. 1; 0 while the force is off, 1 without soft-start */
    double energy;        /* passivity: taken from the hand since it was armed [J]; else 0 */
    double damping;       /* passivity: injected in this tick [N s/m]; else 0 */
    uint32_t points;      /* colliding */
    uint32_t deep_points; /* as of vxs_contact_result */
    uint32_t patches;     /* as of vxs_contact_result */
    uint32_t level;       /* coarsest level of detail */
    uint32_t probed;      /* points that were looked at */
    uint32_t flags;       /* VXS_SERVO_* | VXS_CONTACT_* */
} vxs_servo_trace;

/* Object. One thread at a time. */
typedef struct vxs_servo vxs_servo;

/* All but map and shell. Thread: any, rt-safe. */
VXS_API void vxs_servo_config_default(vxs_servo_config *config);

/* VXS_OK; VXS_CONFIG; VXS_PARAM; as vxs_contact_config_check(), vxs_coupling_config_check() and
 * vxs_effect_check().
 * Thread: any, set-up. */
VXS_API vxs_result vxs_servo_config_check(const vxs_servo_config *config);

/* Bytes for vxs_servo_init(); 0 without map or shell. Thread: any, rt-safe. */
VXS_API size_t vxs_servo_memory(const vxs_servo_config *config);

/* Makes a servo in the caller's memory (any multiple of 16), at rest. Nothing to close.
 * Returns as vxs_servo_config_check(), and VXS_BUFFER. Thread: any, set-up. */
VXS_API vxs_result vxs_servo_init(void *memory, size_t size, const vxs_servo_config *config, vxs_servo **out);

/* Whether a device may be given what this servo commands: VXS_OK; VXS_UNGUARDED, it has motors
 * (caps->has_motors) and the config listed effects without start-inside or without soft-start; VXS_PARAM.
 * Thread: any, rt-safe. */
VXS_API vxs_result vxs_servo_may_drive(const vxs_servo *servo, const vxs_device_caps *caps);

/* One sample. *command is always written, also in FAULT. trace may be NULL. Returns flags.
 * Thread: the servo's, rt-safe. */
VXS_API uint32_t vxs_servo_tick(vxs_servo *servo, const vxs_device_state *state, vxs_device_command *command,
                                vxs_servo_trace *trace);

/* A stage that a tick can have, for people. All texts are static. */
typedef struct vxs_servo_stage {
    const char *name;    /* "contact", "soft-start" */
    const char *reads;   /* what it goes by */
    const char *changes; /* the other stages in which it makes for more or less work, or NULL: none */
    uint32_t effect;     /* the kind that puts it there; 0: it is always there */
    uint32_t reserved;
} vxs_servo_stage;

/* From number 0 on in order of execution. VXS_OK; VXS_PARAM: there are not so many. Thread: any, rt-safe. */
VXS_API vxs_result vxs_servo_stage_at(uint32_t number, vxs_servo_stage *stage);

/* For whoever measures: told before and after each stage of each tick, by its number (vxs_servo_stage_at()).
 * What an effect does within another stage is told within that one, as often as it is done. An own effect's
 * number is that of all stages plus its place in the config's list. */
typedef struct vxs_servo_watch {
    void (*before)(void *user, uint32_t stage); /* it begins */
    void (*after)(void *user, uint32_t stage);  /* it has ended */
    void *user;                                 /* what both are given */
} vxs_servo_watch;

/* Bytes for vxs_servo_watch_stages(). Thread: any, rt-safe. */
VXS_API size_t vxs_servo_watch_memory(void);

/* From now on the servo tells *watch, which is copied; its wrenches stay the same. The servo's list of stages
 * is changed for it, in the caller's memory (any multiple of 16; lives as long as the servo): one that is not
 * watched takes not one instruction more for it. Once for each servo: there is no way back. Returns VXS_OK;
 * VXS_PARAM; VXS_BUFFER. Thread: the servo's, set-up. */
VXS_API vxs_result vxs_servo_watch_stages(vxs_servo *servo, void *memory, size_t size,
                                          const vxs_servo_watch *watch);

/* Ends a FAULT: the next tick starts as if the device had just been armed.
 * Thread: the servo's, rt-safe. */
VXS_API void vxs_servo_clear(vxs_servo *servo);

#ifdef __cplusplus
}
#endif
#endif
