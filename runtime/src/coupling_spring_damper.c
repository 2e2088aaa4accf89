/* SPDX-License-Identifier: MIT
 *
 * McNeely's coupling: a simulated body hangs on the device. The spring and the damper are
 * integrated by the implicit Euler rule, which is stable for any stiffness, mass and sample
 * time; the contact force enters explicitly. The turning spring has stiffness k r^2 and inertia
 * m r^2, so that both motions have one natural frequency. rt-safe.
 */
#include "coupling_ops.h"

#include <math.h>
#include <string.h>

/* The turn from q to the unit quaternion of `to`, as a vector of length 2 sin(angle / 2). */
static void turn_between(const double q[4], const double to[4], double turn[3])
{
    double w = ((to[0] * q[0] + to[1] * q[1]) + to[2] * q[2]) + to[3] * q[3];
    double sign = w < 0 ? -2 : 2;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        turn[i] =
            sign * (((to[1 + i] * q[0] - to[0] * q[1 + i]) - to[1 + j] * q[1 + k]) + to[1 + k] * q[1 + j]);
    }
}

static void advance_orientation(double q[4], const double angular_velocity[3], double time)
{
    const double *v = angular_velocity;
    double half = 0.5 * time, next[4];
    next[0] = q[0] - half * (v[0] * q[1] + v[1] * q[2] + v[2] * q[3]);
    next[1] = q[1] + half * (v[0] * q[0] + v[1] * q[3] - v[2] * q[2]);
    next[2] = q[2] + half * (v[1] * q[0] + v[2] * q[1] - v[0] * q[3]);
    next[3] = q[3] + half * (v[2] * q[0] + v[0] * q[2] - v[1] * q[1]);
    double length = sqrt(((next[0] * next[0] + next[1] * next[1]) + next[2] * next[2]) + next[3] * next[3]);
    for (int i = 0; i < 4; i++) q[i] = next[i] / length;
}

static void unit_pose(const vxs_pose *pose, vxs_pose *out)
{
    vxs_pose identity = vxs_pose_identity();
    if (!vxs_pose_compose(pose, &identity, out)) *out = identity;
}

static void reset(vxs_coupling *coupling, const vxs_pose *device)
{
    vxsi_spring_damper *s = &coupling->as.spring_damper;
    unit_pose(device, &s->object);
    s->device = s->object;
    memset(s->velocity, 0, sizeof s->velocity);
    memset(s->angular_velocity, 0, sizeof s->angular_velocity);
}

static void pose(const vxs_coupling *coupling, vxs_pose *object)
{
    *object = coupling->as.spring_damper.object;
}

/* Velocity at the end of the sample; stretch and rate: from the body to the device. */
static double next_velocity(const vxsi_spring_damper *s, double velocity, double stretch,
                            double device_velocity, double push, double inertia_scale)
{
    double t = s->sample_time, m = s->mass;
    double drive = (s->stiffness * stretch + s->viscosity * device_velocity) + push / inertia_scale;
    return (velocity + t / m * drive) / (1 + t / m * (s->viscosity + t * s->stiffness));
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    vxsi_spring_damper *s = &coupling->as.spring_damper;
    vxs_pose now;
    unit_pose(device, &now);
    double t = s->sample_time, square = s->radius * s->radius;
    double turn[3], device_turn[3];
    turn_between(s->object.orientation, now.orientation, turn);
    turn_between(s->device.orientation, now.orientation, device_turn);
    for (int i = 0; i < 3; i++) {
        double stretch = now.position[i] - s->object.position[i];
        double device_velocity = (now.position[i] - s->device.position[i]) / t;
        s->velocity[i] = next_velocity(s, s->velocity[i], stretch, device_velocity, contact->force[i], 1);
        s->object.position[i] += t * s->velocity[i];
        out->force[i] = s->stiffness * (s->object.position[i] - now.position[i]) +
                        s->viscosity * (s->velocity[i] - device_velocity);
        double device_rate = device_turn[i] / t;
        s->angular_velocity[i] =
            next_velocity(s, s->angular_velocity[i], turn[i], device_rate, contact->torque[i], square);
        out->torque[i] = square * (s->stiffness * (t * s->angular_velocity[i] - turn[i]) +
                                   s->viscosity * (s->angular_velocity[i] - device_rate));
    }
    advance_orientation(s->object.orientation, s->angular_velocity, t);
    s->device = now;
}

const vxsi_coupling_ops vxsi_coupling_spring_damper = {.reset = reset, .pose = pose, .step = step};
