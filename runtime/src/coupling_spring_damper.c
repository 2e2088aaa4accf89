/* SPDX-License-Identifier: MIT
 *
 * McNeely's coupling: a simulated body hangs on the device. The spring and the damper are
 * integrated by the implicit Euler rule, which is stable for any stiffness, mass and sample
 * time; the contact force enters explicitly. The turning spring has stiffness k r^2 and inertia
 * m r^2, so that both motions have one natural frequency. rt-safe.
 */
#include "coupling_body.h"

typedef struct spring_damper {
    double stiffness, viscosity, mass, radius;
    vxs_pose object, device; /* device: of the sample before */
    double velocity[3], angular_velocity[3];
} spring_damper;
VXS_COUPLING_FITS(spring_damper);

static vxs_result check(const vxs_coupling_config *config)
{
    if (!vxsi_is_positive(config->stiffness) || !vxsi_is_positive(config->mass) ||
        !vxsi_is_positive(config->radius))
        return VXS_IMPEDANCE;
    return vxsi_coupling_check_damping(config);
}

static void set_up(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    spring_damper *s = (spring_damper *)coupling->state;
    s->stiffness = config->stiffness;
    s->mass = config->mass;
    s->radius = config->radius;
    s->viscosity = 2 * config->damping * sqrt(config->stiffness * config->mass);
}

static void reset(vxs_coupling *coupling, const vxs_pose *device)
{
    spring_damper *s = (spring_damper *)coupling->state;
    vxsi_unit_pose(device, &s->object);
    s->device = s->object;
    memset(s->velocity, 0, sizeof s->velocity);
    memset(s->angular_velocity, 0, sizeof s->angular_velocity);
}

static void pose(const vxs_coupling *coupling, const vxs_pose *device, vxs_pose *object)
{
    (void)device;
    *object = ((const spring_damper *)coupling->state)->object;
}

/* Velocity at the end of a sample of t seconds; stretch and rate: from the body to the device. */
static double next_velocity(const spring_damper *s, double t, double velocity, double stretch,
                            double device_velocity, double push, double inertia_scale)
{
    double m = s->mass;
    double drive = (s->stiffness * stretch + s->viscosity * device_velocity) + push / inertia_scale;
    return vxs_without_denormals((velocity + t / m * drive) /
                                 (1 + t / m * (s->viscosity + t * s->stiffness)));
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    spring_damper *s = (spring_damper *)coupling->state;
    vxs_pose now;
    vxsi_unit_pose(device, &now);
    double t = coupling->sample_time, square = s->radius * s->radius;
    double turn[3], device_turn[3], object_turn[3];
    vxs_pose_turn(s->object.orientation, now.orientation, turn);
    vxs_pose_turn(s->device.orientation, now.orientation, device_turn);
    for (int i = 0; i < 3; i++) {
        double stretch = now.position[i] - s->object.position[i];
        double device_velocity = (now.position[i] - s->device.position[i]) / t;
        s->velocity[i] = next_velocity(s, t, s->velocity[i], stretch, device_velocity, contact->force[i], 1);
        s->object.position[i] = vxs_without_denormals(s->object.position[i] + t * s->velocity[i]);
        out->force[i] = s->stiffness * (s->object.position[i] - now.position[i]) +
                        s->viscosity * (s->velocity[i] - device_velocity);
        double device_rate = device_turn[i] / t;
        s->angular_velocity[i] =
            next_velocity(s, t, s->angular_velocity[i], turn[i], device_rate, contact->torque[i], square);
        object_turn[i] = t * s->angular_velocity[i];
        out->torque[i] = square * (s->stiffness * (object_turn[i] - turn[i]) +
                                   s->viscosity * (s->angular_velocity[i] - device_rate));
    }
    vxsi_turn(s->object.orientation, object_turn);
    s->device = now;
}

const vxs_coupling_kind vxsi_coupling_spring_damper = {.kind = VXS_COUPLING_SPRING_DAMPER,
                                                       .name = "spring-damper",
                                                       .has_body = 1,
                                                       .check = check,
                                                       .set_up = set_up,
                                                       .reset = reset,
                                                       .pose = pose,
                                                       .step = step};
