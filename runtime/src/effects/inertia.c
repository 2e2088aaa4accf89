/* SPDX-License-Identifier: MIT
 *
 * The object as a rigid body. Between kicks by what acts on it, it turns by Simo and Wong's energy and
 * momentum conserving rule ("Unconditionally stable algorithms for rigid body dynamics that exactly preserve
 * energy and momentum", Int. J. Numerical Methods in Engineering 31, 1991): the implicit midpoint of Euler's
 * equations and Cayley's turn. Kick, then drift (symplectic Euler) for what acts from outside; the spring to
 * the device is implicit.
 */
#include "inertia.h"

#include <math.h>
#include <string.h>

/* A body turns at most so far in a tick [rad], where Newton's steps surely end. */
static const double most_turn = 1;
enum { NEWTON_STEPS = 8 };
static const double solved = 1e-15;

static double without_denormals(double value)
{
    return fabs(value) < 1e-150 ? 0 : value;
}

void vxsi_inertia_reset(void *self, const vxs_pose *tip)
{
    vxsi_inertia *b = self;
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, arm[3];
    b->tip = b->last = *tip;
    vxs_pose_rotation(tip, r);
    vxsi_rotate(r, b->arm, arm);
    for (int i = 0; i < 3; i++) {
        b->position[i] = tip->position[i] - arm[i];
        b->velocity[i] = b->spin[i] = 0;
    }
}

void vxsi_inertia_pose(const void *self, const vxs_pose *tip, vxs_pose *body)
{
    (void)tip;
    *body = ((const vxsi_inertia *)self)->tip;
}

/* The turn in the middle of a tick: tensor w + T/2 w x tensor w = momentum. */
static void turn_in_middle(const vxsi_inertia *b, const double momentum[3], double w[3])
{
    const double half = b->sample_time / 2;
    for (int step = 0; step < NEWTON_STEPS; step++) {
        double spin[3], gyro[3], rest[3], slope[9], inverse[9], way[3];
        vxsi_rotate(b->tensor, w, spin);
        vxsi_cross(w, spin, gyro);
        for (int i = 0; i < 3; i++) rest[i] = momentum[i] - spin[i] - half * gyro[i];
        /* of w x tensor w: w x tensor . - (tensor w) x . */
        for (int i = 0; i < 3; i++) {
            const double axis[3] = {i == 0, i == 1, i == 2},
                         column[3] = {b->tensor[i], b->tensor[3 + i], b->tensor[6 + i]};
            double left[3], right[3];
            vxsi_cross(w, column, left);
            vxsi_cross(axis, spin, right);
            for (int row = 0; row < 3; row++)
                slope[3 * row + i] = column[row] + half * (left[row] + right[row]);
        }
        vxsi_invert(slope, inverse);
        vxsi_rotate(inverse, rest, way);
        for (int i = 0; i < 3; i++) w[i] += way[i];
        if (vxsi_dot(way, way) <= solved * solved * vxsi_dot(w, w)) return;
    }
}

/* A tick without anything from outside. */
static void drift(vxsi_inertia *b)
{
    const double t = b->sample_time, *q = b->tip.orientation;
    double size = sqrt(vxsi_dot(b->spin, b->spin)), momentum[3], w[3], r[9], arm[3];
    if (size * t > most_turn)
        for (int i = 0; i < 3; i++) b->spin[i] *= most_turn / (size * t);
    vxsi_rotate(b->tensor, b->spin, momentum);
    memcpy(w, b->spin, sizeof w);
    turn_in_middle(b, momentum, w);
    vxs_pose by = {{0, 0, 0}, {1, t / 2 * w[0], t / 2 * w[1], t / 2 * w[2]}},
             next = {{0, 0, 0}, {q[0], q[1], q[2], q[3]}};
    vxs_pose_compose(&next, &by, &next);
    vxs_pose_rotation(&next, r);
    vxsi_rotate(r, b->arm, arm);
    for (int i = 0; i < 3; i++) {
        b->spin[i] = without_denormals(2 * w[i] - b->spin[i]);
        b->position[i] = without_denormals(b->position[i] + t * b->velocity[i]);
        next.position[i] = b->position[i] + arm[i];
    }
    b->tip = next;
}

/* What acts from outside, and the spring as it will be at the tick's end. Leaves the spring's wrench on the
 * device in *wrench. */
static void kick(vxsi_inertia *b, vxs_tick *tick)
{
    vxs_wrench *wrench = &tick->wrench;
    const double t = b->sample_time, c = b->damping + t * b->stiffness;
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, arm[3], pull[3], twist[3], rate[3], free[3], push[3],
           torque[3], turned[3], momentum[3];
    vxs_pose_rotation(&b->tip, r);
    vxsi_rotate(r, b->arm, arm);
    vxs_pose_turn(b->tip.orientation, tick->tip.orientation, twist);
    vxs_pose_turn(b->last.orientation, tick->tip.orientation, rate);
    for (int i = 0; i < 3; i++) {
        pull[i] = b->stiffness * (tick->tip.position[i] - b->tip.position[i]) +
                  b->damping * ((tick->tip.position[i] - b->last.position[i]) / tick->elapsed);
        twist[i] = b->square * (b->stiffness * twist[i] + b->damping * (rate[i] / tick->elapsed));
        free[i] = (b->mass * b->velocity[i] + t * (wrench->force[i] + pull[i])) / (b->mass + b->drag);
        push[i] = t * (wrench->force[i] + pull[i]) - b->drag * free[i];
    }
    vxsi_cross(arm, push, torque);
    for (int i = 0; i < 3; i++) torque[i] += t * (wrench->torque[i] + twist[i]);
    vxsi_rotate_back(r, torque, turned);
    vxsi_rotate(b->tensor, b->spin, momentum);
    for (int i = 0; i < 3; i++) momentum[i] += turned[i];
    vxsi_rotate(b->inverse, momentum, b->spin);
    double turn[3], swing[3];
    vxsi_rotate(r, b->spin, turn);
    vxsi_cross(arm, turn, swing);
    for (int i = 0; i < 3; i++) {
        b->velocity[i] = without_denormals(free[i] + (1 - b->kept) * swing[i]);
        b->spin[i] = without_denormals(b->spin[i]);
        wrench->force[i] = c * (b->velocity[i] - swing[i]) - pull[i];
        wrench->torque[i] = b->square * c * turn[i] - twist[i];
    }
    b->last = tick->tip;
}

void vxsi_inertia_run(void *self, vxs_tick *tick)
{
    kick(self, tick);
    drift(self);
}
