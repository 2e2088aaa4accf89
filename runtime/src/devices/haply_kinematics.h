/* SPDX-License-Identifier: MIT
 *
 * haply_kinematics.h - private: a pantograph, two motors a base apart, two links each. Pure arithmetic.
 *
 * Plane of the mechanism, metres: motor 1 at the origin, motor 2 at (base, 0), the tip on the positive side
 * of y.
 */
#ifndef VXSI_HAPLY_KINEMATICS_H
#define VXSI_HAPLY_KINEMATICS_H

typedef struct vxsi_pantograph {
    double near_link, far_link, base; /* [m] */
} vxsi_pantograph;

/* The tip from the motors' angles [rad]; jacobian (may be NULL): d place / d angle, row by row. Returns 1; 0
 * where the far links do not meet or lie in one line (nothing is written). */
int vxsi_pantograph_forward(const vxsi_pantograph *shape, const double angle[2], double place[2],
                            double jacobian[4]);

/* The angles of a place, elbows outside. Returns 1; 0 out of reach. */
int vxsi_pantograph_inverse(const vxsi_pantograph *shape, const double place[2], double angle[2]);

#endif
