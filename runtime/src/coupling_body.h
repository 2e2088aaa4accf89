/* SPDX-License-Identifier: MIT
 *
 * coupling_body.h - private: small motions of a simulated body, for the couplings that have one.
 */
#ifndef VXSI_COUPLING_BODY_H
#define VXSI_COUPLING_BODY_H

#include "coupling_kind.h"

/* The turn from q to the unit quaternion of `to`, as a vector of length 2 sin(angle / 2). */
static inline void vxsi_turn_between(const double q[4], const double to[4], double turn[3])
{
    double w = ((to[0] * q[0] + to[1] * q[1]) + to[2] * q[2]) + to[3] * q[3];
    double sign = w < 0 ? -2 : 2;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        turn[i] =
            sign * (((to[1 + i] * q[0] - to[0] * q[1 + i]) - to[1 + j] * q[1 + k]) + to[1 + k] * q[1 + j]);
    }
}

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
    for (int i = 0; i < 4; i++) q[i] = vxsi_without_denormals(next[i] / length);
}

/* The pose with an orientation of length 1; identity for one that is none. */
static inline void vxsi_unit_pose(const vxs_pose *pose, vxs_pose *out)
{
    vxs_pose identity = vxs_pose_identity();
    if (!vxs_pose_compose(pose, &identity, out)) *out = identity;
    for (int i = 0; i < 3; i++) out->position[i] = vxsi_without_denormals(out->position[i]);
    for (int i = 0; i < 4; i++) out->orientation[i] = vxsi_without_denormals(out->orientation[i]);
}

#endif
