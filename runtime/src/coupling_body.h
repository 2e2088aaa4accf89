/* SPDX-License-Identifier: MIT
 *
 * coupling_body.h - private: small motions of a simulated body, for the couplings that have one.
 */
#ifndef VXSI_COUPLING_BODY_H
#define VXSI_COUPLING_BODY_H

#include "coupling_table.h"

/* q turned by the small vector `turn`; of length 1 again. */
static inline void vxsi_turn(double q[4], const double turn[3])
{
    const double *v = turn;
    double next[4];
    next[0] = q[0] - 0.5 * (v[0] * q[1] + v[1] * q[2] + v[2] * q[3]);
    next[1] = q[1] + 0.5 * (v[0] * q[0] + v[1] * q[3] - v[2] * q[2]);
    next[2] = q[2] + 0.5 * (v[1] * q[0] + v[2] * q[1] - v[0] * q[3]);
    next[3] = q[3] + 0.5 * (v[2] * q[0] + v[0] * q[2] - v[1] * q[1]);
    double length = sqrt(((next[0] * next[0] + next[1] * next[1]) + next[2] * next[2]) + next[3] * next[3]);
    for (int i = 0; i < 4; i++) q[i] = vxs_without_denormals(next[i] / length);
}

/* The pose with an orientation of length 1; identity for one that is none. */
static inline void vxsi_unit_pose(const vxs_pose *pose, vxs_pose *out)
{
    vxs_pose identity = vxs_pose_identity();
    if (!vxs_pose_compose(pose, &identity, out)) *out = identity;
    for (int i = 0; i < 3; i++) out->position[i] = vxs_without_denormals(out->position[i]);
    for (int i = 0; i < 4; i++) out->orientation[i] = vxs_without_denormals(out->orientation[i]);
}

#endif
