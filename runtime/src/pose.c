/* SPDX-License-Identifier: MIT */
#include "voxshell/pose.h"

#include <math.h>
#include <string.h>

static int unit_quaternion(const vxs_pose *pose, double q[4])
{
    for (int axis = 0; axis < 3; axis++) {
        if (!isfinite(pose->position[axis])) return 0;
    }
    const double *o = pose->orientation;
    double length = sqrt(((o[0] * o[0] + o[1] * o[1]) + o[2] * o[2]) + o[3] * o[3]);
    if (!(length >= 1e-6 && isfinite(length))) return 0;
    for (int i = 0; i < 4; i++) q[i] = o[i] / length;
    return 1;
}

static void to_matrix(const double q[4], double r[9])
{
    double w = q[0], x = q[1], y = q[2], z = q[3];
    r[0] = 1 - 2 * (y * y + z * z);
    r[1] = 2 * (x * y - w * z);
    r[2] = 2 * (x * z + w * y);
    r[3] = 2 * (x * y + w * z);
    r[4] = 1 - 2 * (x * x + z * z);
    r[5] = 2 * (y * z - w * x);
    r[6] = 2 * (x * z - w * y);
    r[7] = 2 * (y * z + w * x);
    r[8] = 1 - 2 * (x * x + y * y);
}

int vxs_pose_rotation(const vxs_pose *pose, double rotation[9])
{
    double q[4];
    if (!unit_quaternion(pose, q)) return 0;
    to_matrix(q, rotation);
    return 1;
}

int vxs_pose_compose(const vxs_pose *outer, const vxs_pose *inner, vxs_pose *out)
{
    double a[4], b[4], r[9];
    if (!unit_quaternion(outer, a) || !unit_quaternion(inner, b)) return 0;
    to_matrix(a, r);
    vxs_pose composed;
    for (int i = 0; i < 3; i++) {
        composed.position[i] = ((r[3 * i] * inner->position[0] + r[3 * i + 1] * inner->position[1]) +
                                r[3 * i + 2] * inner->position[2]) +
                               outer->position[i];
    }
    composed.orientation[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    composed.orientation[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    composed.orientation[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    composed.orientation[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    memcpy(out, &composed, sizeof composed);
    return 1;
}

void vxs_pose_turn(const double from[4], const double to[4], double turn[3])
{
    double w = ((to[0] * from[0] + to[1] * from[1]) + to[2] * from[2]) + to[3] * from[3];
    double sign = w < 0 ? -2 : 2;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        turn[i] = sign * (((to[1 + i] * from[0] - to[0] * from[1 + i]) - to[1 + j] * from[1 + k]) +
                          to[1 + k] * from[1 + j]);
    }
}
