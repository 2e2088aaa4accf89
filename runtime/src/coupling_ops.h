/* SPDX-License-Identifier: MIT
 *
 * coupling_ops.h - private: what a kind of coupling is. One file a kind, and one line in the
 * table of coupling_setup.c.
 */
#ifndef VXSI_COUPLING_OPS_H
#define VXSI_COUPLING_OPS_H

#include "voxshell/coupling.h"

/* All rt-safe: no call may block, allocate or fail. */
typedef struct vxsi_coupling_ops {
    /* At rest with the device at this pose. */
    void (*reset)(vxs_coupling *coupling, const vxs_pose *device);
    /* Where contact is evaluated. Optional: NULL means at the device. */
    void (*pose)(const vxs_coupling *coupling, vxs_pose *object);
    /* One sample. */
    void (*step)(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out);
} vxsi_coupling_ops;

/* Two trapezoidal integrators a step apart; a1 = 1/(1 + g (g + 2d)), a2 = g a1, a3 = g a2, with
 * g = w0 T/2, or tan(w0 T/2) pre-warped. */
typedef struct vxsi_pt2 {
    double gain, a1, a2, a3;
    double state[6][2];
} vxsi_pt2;

typedef struct vxsi_spring_damper {
    double stiffness, viscosity, mass, radius, sample_time;
    vxs_pose object, device; /* device: of the sample before */
    double velocity[3], angular_velocity[3];
} vxsi_spring_damper;

struct vxs_coupling {
    const vxsi_coupling_ops *ops;
    union {
        vxsi_pt2 pt2;
        vxsi_spring_damper spring_damper;
    } as;
};

extern const vxsi_coupling_ops vxsi_coupling_none;
extern const vxsi_coupling_ops vxsi_coupling_pt2;
extern const vxsi_coupling_ops vxsi_coupling_spring_damper;

#endif
