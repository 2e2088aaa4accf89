/* SPDX-License-Identifier: MIT
 *
 * coupling_kind.h - a kind of coupling (coupling.h), for whoever writes one: voxshell's are rows of a table, a
 * program's own is given to the config, with the shared library as with the archive:
 *
 *     static const vxs_coupling_kind lab_lag = {
 *         .struct_size = sizeof(vxs_coupling_kind), .coupling_size = sizeof(vxs_coupling),
 *         .name = "lab-lag", .set_up = set_up, .reset = reset, .step = step};
 *     config.coupling.kind = VXS_COUPLING_OWN;
 *     config.coupling.own = &lab_lag;
 *
 * samples/own_filter is a whole one. The kind is borrowed until the coupling's last step.
 *
 * Threads: check and set_up run where vxs_coupling_init() (vxs_servo_init()) is called, and may take their
 * time. reset, pose, refine and step run in the tick, in the thread that calls it: they may not block,
 * allocate, lock, log, call the system or a transcendental function; sqrt, fabs, memcpy and the rt-safe
 * functions of these headers are what they may call. What they keep from tick to tick is in coupling->state,
 * not in statics: a program can have several couplings. SI, the scene's frame, torque about the tip.
 *
 * What comes after a coupling holds whatever it does: a number that is not finite, in or out, resets it and
 * gives zero force; guards, clamp and soft-start follow. Whether it is stable is its author's affair.
 *
 * Promised: within a major version fields are only added, at the end, so that a source goes on compiling. The
 * two sizes say which headers it was compiled with: a library of another layout refuses it (VXS_CONFIG).
 */
#ifndef VOXSHELL_COUPLING_KIND_H
#define VOXSHELL_COUPLING_KIND_H

#include "voxshell/coupling.h"

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/* State is doubles and nothing else, so that a test can look at every one of them: so many of them. */
enum { VXS_COUPLING_DOUBLES = 80 };

/* A kind. What is optional may be NULL. */
typedef struct vxs_coupling_kind {
    uint32_t struct_size;   /* sizeof(vxs_coupling_kind) */
    uint32_t coupling_size; /* sizeof(vxs_coupling) */
    uint32_t kind;          /* VXS_COUPLING_* of voxshell's; an own one is not looked at */
    uint32_t has_body;      /* not 0: contact is evaluated at a body with a mass of its own, which weight
                               and drag act on, too */
    const char *name;       /* for people: "lab-lag" */
    /* Its own numbers of the config: VXS_OK, or what cannot be represented. Struct size and sample time were
     * checked before. Optional. */
    vxs_result (*check)(const vxs_coupling_config *config);
    /* Constants from a checked config into state, which is all 0; omega0 is already pre-warped. Optional. */
    void (*set_up)(vxs_coupling *coupling, const vxs_coupling_config *config);
    /* At rest with the device at this pose. Optional. */
    void (*reset)(vxs_coupling *coupling, const vxs_pose *device);
    /* Where contact is evaluated. Optional: NULL means at the device. */
    void (*pose)(const vxs_coupling *coupling, const vxs_pose *device, vxs_pose *object);
    /* Moves the object by what contact said, wrench and depth [m]; not 0: evaluate there again. It has to end
     * by itself, by coupling->evaluations. Optional. */
    int (*refine)(vxs_coupling *coupling, const vxs_wrench *contact, double depth, const vxs_pose *device);
    /* One sample: what contact makes, in; what the device is to render, out, all of it written. Both are
     * finite, and the pose has an orientation. */
    void (*step)(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out);
} vxs_coupling_kind;

/* The object of coupling.h, as a kind sees it. It casts state to a struct of doubles of its own;
 * VXS_COUPLING_FITS checks that there is room. */
struct vxs_coupling {
    const vxs_coupling_kind *kind; /* whose functions these are */
    uint32_t evaluations;          /* of contact in this tick, so far */
    uint32_t most_evaluations;     /* that a kind allows itself; voxshell does not look at it */
    uint32_t has_torque;           /* 0: *out's torque is not asked for, and set to 0 after step */
    double depth;                  /* of the last of them [m] */
    double sample_time;            /* T [s] */
    double
        state[VXS_COUPLING_DOUBLES]; /* the kind's, whatever unit it gives them: [1]; all 0 before set_up */
};

#ifdef __cplusplus
/* Does not compile if `type` is larger than the state. */
#define VXS_COUPLING_FITS(type)                                                                              \
    static_assert(sizeof(type) <= VXS_COUPLING_DOUBLES * sizeof(double), #type " is too large")
#else
/* The same in C. */
#define VXS_COUPLING_FITS(type)                                                                              \
    _Static_assert(sizeof(type) <= VXS_COUPLING_DOUBLES * sizeof(double), #type " is too large")
#endif

/* For what dies away: 0 before it turns denormal, where arithmetic takes a hundred times as long.
 * Thread: any, rt-safe. */
static inline double vxs_without_denormals(double value)
{
    return fabs(value) < 1e-150 ? 0 : value;
}

#ifdef __cplusplus
}
#endif
#endif
