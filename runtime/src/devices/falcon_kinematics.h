/* SPDX-License-Identifier: MIT
 *
 * falcon_kinematics.h - private: the Novint Falcon's geometry, three legs of a parallelogram each.
 *
 * Device frame: x right, y up, z towards the user, metres; the workspace is around z = 0.12 m.
 * Stamper 1997, re-derived; lengths from libnifalcon. Pure arithmetic.
 */
#ifndef VXSI_FALCON_KINEMATICS_H
#define VXSI_FALCON_KINEMATICS_H

#include <stdint.h>

/* The shoulder's angle [rad] at an encoder's count, and back to the nearest count. */
double vxsi_falcon_angle(int16_t count);
int16_t vxsi_falcon_count(double angle);

/* A leg's angles at the tip's place. Returns 1; 0 where a leg does not reach (nothing is written). jacobian
 * may be NULL; row n is d angle[n] / d place [rad/m]. */
int vxsi_falcon_inverse(const double place[3], double angle[3], double jacobian[9]);

/* The tip's place from the angles. *place holds a guess, of which the result does not depend beyond rounding:
 * Newton's steps go on until the angles agree within 1e-12 rad. Returns 1; 0 where no place within the
 * workspace has these angles (place untouched). */
int vxsi_falcon_forward(const double angle[3], double place[3]);

/* The torque at the shoulders [N m] that is a force at the tip [N]: J^-T force. Returns 0 at a singular pose.
 */
int vxsi_falcon_torque(const double jacobian[9], const double force[3], double torque[3]);

#endif
