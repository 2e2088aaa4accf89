/* SPDX-License-Identifier: MIT
 *
 * object_motion.h - private: how fast the object moves, measured from one tick's pose to the next; for the
 * effects that ask.
 */
#ifndef VXSI_OBJECT_MOTION_H
#define VXSI_OBJECT_MOTION_H

#include "../servo_stage.h"
#include "../vector.h"

/* Of the middle of the shell's bounding sphere. */
typedef struct vxsi_object_motion {
    double center[3];                       /* from the object's tip, in its frame */
    double at[3], orientation[4];           /* at the end of the tick before; no orientation: not known */
    double next_at[3], next_orientation[4]; /* in this tick */
    double arm[3];                          /* from the tip to the middle, scene's frame */
    double velocity[3], spin[3];            /* [m/s], [rad/s], scene's frame; 0 in the first tick */
} vxsi_object_motion;

/* The velocity of a static where its matter is at a point. */
void vxsi_twist_at(const vxs_twist *twist, const double point[3], double velocity[3]);

void vxsi_motion_set_up(vxsi_object_motion *m, const vxs_servo_config *config);
void vxsi_motion_reset(vxsi_object_motion *m);

/* The object has come to tick->body, an orientation of length 1; once an evaluation. */
void vxsi_motion_follow(vxsi_object_motion *m, const vxs_tick *tick);

/* A force that acts at the middle, and a torque, as a wrench about the tip. */
void vxsi_at_middle(const vxsi_object_motion *m, vxs_wrench *wrench);

#endif
