/* SPDX-License-Identifier: MIT
 *
 * coupling.h - between the collision wrench and the device: the virtual coupling.
 *
 * Source: METHOD section 4 (paper section 5). A spring-damper-mass c x + r x' + m x'' read as a
 * PT2 element with the collision force as its input:
 *     H(s) = K w0^2 / (w0^2 + 2 d w0 s + s^2),  w0 = sqrt(c/m),  d = r / (2 sqrt(m c)),  K = 1/c
 * Tustin, s = (2/T) (z-1)/(z+1), gives
 *     y = b0 u + b1 u_1 + b2 u_2 - a1 y_1 - a2 y_2        (vxs_coupling_design)
 * The step runs the same transfer function as two trapezoidal integrators per axis: their gain at
 * rest is exactly K however slow the filter, and rounding cannot move the poles outside.
 */
#ifndef VOXSHELL_COUPLING_H
#define VOXSHELL_COUPLING_H

#include "voxshell/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Kinds.
 *   NONE           the collision wrench itself
 *   PT2            the paper's dynamic shaping filter, six axes
 *   SPRING_DAMPER  McNeely 1999: contact acts on a simulated body (mass, radius of gyration) that
 *                  hangs on the device by a spring and a damper; the device feels that spring
 *   QUASI_STATIC   contact acts on a massless body that hangs on the device by a spring; each tick finds
 *                  the pose where contact and spring balance, by Newton's steps, and the device feels the
 *                  spring: never stiffer than it, however stiff contact is. Each step is one evaluation of
 *                  contact (vxs_coupling_refine), and some 0.2 us for the solve
 *   OWN            config.own, a program's (coupling_kind.h, samples/own_filter)
 * A kind of voxshell's is one file and one line in the table of src/coupling_table.c (README). */
enum {
    VXS_COUPLING_NONE = 1,
    VXS_COUPLING_PT2 = 2,
    VXS_COUPLING_SPRING_DAMPER = 3,
    VXS_COUPLING_QUASI_STATIC = 4,
    VXS_COUPLING_OWN = 1000
};

#define VXS_COUPLING_MIN_HZ 0.05          /* VXS_FREQUENCY: below */
#define VXS_COUPLING_MAX_RATE 0.49        /* VXS_FREQUENCY: above so many times the sample rate */
#define VXS_COUPLING_MIN_DAMPING 1e-3     /* VXS_DAMPING: below */
#define VXS_COUPLING_MAX_DAMPING 1e3      /* VXS_DAMPING: above */
#define VXS_COUPLING_MIN_SAMPLE_TIME 1e-5 /* VXS_SAMPLE_TIME: below [s] */
#define VXS_COUPLING_MAX_SAMPLE_TIME 0.1  /* VXS_SAMPLE_TIME: above [s] */
#define VXS_COUPLING_MAX_EVALUATIONS 3    /* of contact in a tick, QUASI_STATIC */

/* Config. Fields of other kinds than `kind` are not looked at. */
typedef struct vxs_coupling_config {
    uint32_t struct_size;
    uint32_t kind;      /* VXS_COUPLING_*, default PT2 */
    double sample_time; /* T [s], default 0.001 */
    /* PT2 */
    double omega0;    /* w0 [rad/s], default 2 pi 5 Hz */
    double damping;   /* d [1], default 1; SPRING_DAMPER: the spring's zeta as well */
    double gain;      /* K [1], default 1 */
    uint32_t prewarp; /* not 0: Tustin exact at w0; default 0 */
    /* QUASI_STATIC */
    uint32_t evaluations; /* of contact in a tick at most: 1 .. VXS_COUPLING_MAX_EVALUATIONS (default) */
    /* SPRING_DAMPER and QUASI_STATIC */
    double stiffness; /* [N/m], default 1000; about an axis stiffness x radius^2 */
    double radius;    /* of gyration of the simulated body [m], default 0.02 */
    /* SPRING_DAMPER */
    double mass; /* [kg], default 0.05 */
    /* OWN */
    const struct vxs_coupling_kind *own; /* default NULL, as for all other kinds */
} vxs_coupling_config;

/* The biquad of a PT2. */
typedef struct vxs_coupling_coefficients {
    double b0, b1, b2, a1, a2; /* as at the head of this file [1] */
} vxs_coupling_coefficients;

/* Flags of a step. */
enum { VXS_COUPLING_INVALID = 1 << 0 }; /* not finite: zero wrench, and the state was reset */

/* Object. One thread at a time. */
typedef struct vxs_coupling vxs_coupling;

/* Fills a config with the defaults that its members name. Thread: any, rt-safe. */
VXS_API void vxs_coupling_config_default(vxs_coupling_config *config);

/* Sets w0, d and K of a PT2 from stiffness c [N/m], damping r [N s/m] and mass m [kg];
 * K = 1/c with physical_gain not 0, else K = 1. Returns VXS_OK; VXS_PARAM; VXS_IMPEDANCE (config
 * untouched). Thread: any, set-up. */
VXS_API vxs_result vxs_coupling_from_impedance(vxs_coupling_config *config, double stiffness, double damping,
                                               double mass, int physical_gain);

/* VXS_OK; VXS_CONFIG; VXS_PARAM (unknown kind, evaluations; an own kind without name or step, or beside
 * another number than OWN); what an own kind's check says; by name, what cannot be represented:
 * VXS_SAMPLE_TIME, VXS_FREQUENCY, VXS_DAMPING, VXS_GAIN; VXS_IMPEDANCE (stiffness, mass, radius).
 * Thread: any, set-up. */
VXS_API vxs_result vxs_coupling_config_check(const vxs_coupling_config *config);

/* The biquad of a PT2 config. Returns as vxs_coupling_config_check(); VXS_UNSUPPORTED for another
 * kind. Thread: any, set-up. */
VXS_API vxs_result vxs_coupling_design(const vxs_coupling_config *config, vxs_coupling_coefficients *out);

/* Name of a kind ("none", "pt2", "spring-damper", "quasi-static"), NULL for none such; and back, 0 for none
 * such. Ownership: static. Thread: any, rt-safe. */
VXS_API const char *vxs_coupling_kind_name(uint32_t kind);
VXS_API uint32_t vxs_coupling_kind_named(const char *name);

/* Bytes for vxs_coupling_init(), of any kind. Thread: any, rt-safe. */
VXS_API size_t vxs_coupling_memory(void);

/* Makes a coupling at rest in the caller's memory (any multiple of 16). Nothing to close.
 * Returns as vxs_coupling_config_check(), and VXS_BUFFER. Thread: any, set-up. */
VXS_API vxs_result vxs_coupling_init(void *memory, size_t size, const vxs_coupling_config *config,
                                     vxs_coupling **out);

/* At rest with the device at this pose: no force, no memory. Thread: the coupling's, rt-safe. */
VXS_API void vxs_coupling_reset(vxs_coupling *coupling, const vxs_pose *device);

/* Where to evaluate contact: at the device, or at the simulated body.
 * Thread: the coupling's, rt-safe. */
VXS_API void vxs_coupling_pose(const vxs_coupling *coupling, const vxs_pose *device, vxs_pose *object);

/* Between an evaluation of contact and the step: wrench and depth [m] that were found at vxs_coupling_pose().
 * Not 0: the body has moved, evaluate contact at vxs_coupling_pose() once more and ask again; 0: go on with
 * the step. Ends after the config's evaluations at the latest. Only QUASI_STATIC ever asks for more.
 * Thread: the coupling's, rt-safe. */
VXS_API int vxs_coupling_refine(vxs_coupling *coupling, const vxs_wrench *contact, double depth,
                                const vxs_pose *device);

/* One sample: contact wrench at vxs_coupling_pose() in, wrench for the device out. Values below
 * 1e-150 count as 0, so that a state that dies away never turns denormal. A number that is not
 * finite, in or out, resets the coupling: *out is zero and VXS_COUPLING_INVALID is returned.
 * Thread: the coupling's, rt-safe. */
VXS_API uint32_t vxs_coupling_step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device,
                                   vxs_wrench *out);

#ifdef __cplusplus
}
#endif
#endif
