/* SPDX-License-Identifier: MIT
 *
 * pose.h - where a body is, and the force and torque on it. Plain values, SI.
 */
#ifndef VOXSHELL_POSE_H
#define VOXSHELL_POSE_H

#include "voxshell/result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A rigid motion: x -> R x + position. The quaternion (w, x, y, z) need not be of length 1, it
 * is normalised where it is used; q and -q are the same pose. */
typedef struct vxs_pose {
    double position[3];    /* [m] */
    double orientation[4]; /* w x y z */
} vxs_pose;

/* Torque about the reference point of the body that it acts on. */
typedef struct vxs_wrench {
    double force[3];  /* [N] */
    double torque[3]; /* [N m] */
} vxs_wrench;

static inline vxs_pose vxs_pose_identity(void)
{
    vxs_pose pose = {{0, 0, 0}, {1, 0, 0, 0}};
    return pose;
}

/* The rotation matrix, row by row, of pose->orientation normalised.
 * Returns 1; 0 (rotation untouched) if any number of the pose is not finite or the quaternion
 * is shorter than 1e-6. Thread: any, rt-safe. */
VXS_API int vxs_pose_rotation(const vxs_pose *pose, double rotation[9]);

/* out = outer o inner: first inner, then outer. The orientation comes out normalised. Returns 1;
 * 0 (out untouched) for a bad pose, as above. out may be one of the inputs.
 * Thread: any, rt-safe. */
VXS_API int vxs_pose_compose(const vxs_pose *outer, const vxs_pose *inner, vxs_pose *out);

/* The turn from one orientation to another (unit quaternions), the short way round: along its axis, of length
 * 2 sin(angle / 2), which is the angle to within 1e-4 of it up to 0.05 rad. Thread: any, rt-safe. */
VXS_API void vxs_pose_turn(const double from[4], const double to[4], double turn[3]);

#ifdef __cplusplus
}
#endif
#endif
