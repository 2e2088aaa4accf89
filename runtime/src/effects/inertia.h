/* SPDX-License-Identifier: MIT
 *
 * inertia.h - private: the body of the effect inertia, whose set-up and tick stand in files of their own.
 */
#ifndef VXSI_INERTIA_H
#define VXSI_INERTIA_H

#include "../servo_stage.h"
#include "../vector.h"

/* Of the body's frame, that of the object's tip; arm is from the centre of mass to the tip. */
typedef struct vxsi_inertia {
    double sample_time, mass, tensor[9], arm[3];
    double stiffness, damping, square;        /* k, b, radius^2 */
    double drag, kept;                        /* of the implicit spring: T c and m / (m + T c), c = b + T k */
    double inverse[9];                        /* of the tensor with the spring */
    double most_stiffness;                    /* of contact [N/m] */
    double position[3], velocity[3], spin[3]; /* of the centre of mass, scene; of turning, body */
    vxs_pose tip;                             /* of the object */
    vxs_pose last;                            /* of the device, in the tick before */
} vxsi_inertia;

/* By cofactors; returns the determinant. */
static inline double vxsi_invert(const double m[9], double out[9])
{
    double columns[3][3], c[3][3];
    for (int i = 0; i < 9; i++) columns[i % 3][i / 3] = m[i];
    for (int i = 0; i < 3; i++) vxsi_cross(columns[(i + 1) % 3], columns[(i + 2) % 3], c[i]);
    double determinant = vxsi_dot(columns[0], c[0]);
    for (int i = 0; i < 9; i++) out[i] = c[i / 3][i % 3] / determinant;
    return determinant;
}

void vxsi_inertia_reset(void *self, const vxs_pose *tip);
void vxsi_inertia_run(void *self, vxs_tick *tick);
void vxsi_inertia_pose(const void *self, const vxs_pose *tip, vxs_pose *body);

#endif
