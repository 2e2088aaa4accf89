/* SPDX-License-Identifier: MIT
 *
 * What the effects that look at the object's velocity share.
 */
#include "object_motion.h"

#include <string.h>

void vxsi_twist_at(const vxs_twist *twist, const double point[3], double velocity[3])
{
    const double arm[3] = {point[0] - twist->origin[0], point[1] - twist->origin[1],
                           point[2] - twist->origin[2]};
    vxsi_cross(twist->spin, arm, velocity);
    for (int i = 0; i < 3; i++) velocity[i] += twist->velocity[i];
}

void vxsi_motion_set_up(vxsi_object_motion *m, const vxs_servo_config *config)
{
    vxs_pose center = vxs_pose_identity();
    memcpy(center.position, config->shell->center, sizeof center.position);
    vxs_pose_compose(&config->grip, &center, &center);
    memcpy(m->center, center.position, sizeof m->center);
}

void vxsi_motion_reset(vxsi_object_motion *m)
{
    memset(m->next_orientation, 0, sizeof m->next_orientation);
}

void vxsi_motion_follow(vxsi_object_motion *m, const vxs_tick *tick)
{
    const double *q = m->orientation;
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (tick->evaluation == 0) {
        memcpy(m->at, m->next_at, sizeof m->at);
        memcpy(m->orientation, m->next_orientation, sizeof m->orientation);
    }
    const int is_known = q[0] != 0 || q[1] != 0 || q[2] != 0 || q[3] != 0;
    vxs_pose_rotation(&tick->body, r);
    memset(m->spin, 0, sizeof m->spin);
    if (is_known) vxs_pose_turn(q, tick->body.orientation, m->spin);
    for (int i = 0; i < 3; i++) {
        m->arm[i] = vxsi_dot(r + 3 * i, m->center);
        m->next_at[i] = tick->body.position[i] + m->arm[i];
        m->velocity[i] = is_known ? (m->next_at[i] - m->at[i]) / tick->elapsed : 0;
        m->spin[i] /= tick->elapsed;
    }
    memcpy(m->next_orientation, tick->body.orientation, sizeof m->next_orientation);
}

void vxsi_at_middle(const vxsi_object_motion *m, vxs_wrench *wrench)
{
    double torque[3];
    vxsi_cross(m->arm, wrench->force, torque);
    for (int i = 0; i < 3; i++) wrench->torque[i] += torque[i];
}
