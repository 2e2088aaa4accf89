/* SPDX-License-Identifier: MIT
 *
 * The simulated device's sample: delay line, motion, encoder. rt-safe.
 *
 * A substep solves for the velocity at its end: spring, dampers and Coulomb friction are taken
 * there (for friction that is its proximal map: it can stop the tip, never turn it round), so no
 * profile and no arm makes the model itself unstable.
 */
#include "simulated_model.h"

#include <math.h>
#include <string.h>

double vxsi_simulated_encode(const vxsi_simulated *simulated, double position)
{
    double step = simulated->config.profile.resolution;
    return step > 0 ? floor(position / step + 0.5) * step : position;
}

/* Even in 0 .. 1. */
static double even(vxsi_simulated *s)
{
    s->random ^= s->random << 13;
    s->random ^= s->random >> 7;
    s->random ^= s->random << 17;
    return (double)(s->random >> 11) * 0x1p-53;
}

static double noise_of(vxsi_simulated *s)
{
    double sum = -6;
    if (!(s->config.noise > 0)) return 0;
    for (int n = 0; n < 12; n++) sum += even(s);
    return sum * s->config.noise;
}

/* Drop-outs begin so often that their share of all time is the loss. */
static int is_lost(vxsi_simulated *s)
{
    double loss = s->config.loss;
    if (!(loss > 0)) return 0;
    if (s->lost_left == 0 && even(s) < loss / ((1 - loss) * s->lost_each + loss)) s->lost_left = s->lost_each;
    if (s->lost_left == 0) return 0;
    s->lost_left--;
    return 1;
}

static int is_finite(const double v[3])
{
    return isfinite(fabs(v[0]) + fabs(v[1]) + fabs(v[2]));
}

/* What the motors are told: decayed, and clamped to what they have. */
static void render(vxsi_simulated *s, vxs_device_report *out)
{
    memset(out, 0, sizeof *out);
    const vxs_wrench *wanted = &s->command.wrench;
    if (s->state != VXS_DEVICE_ARMED) return;
    if (!is_finite(wanted->force) || !is_finite(wanted->torque)) {
        out->flags = VXS_DEVICE_REFUSED;
        s->state = VXS_DEVICE_FAULT;
        s->fault = VXS_DEVICE_FAULT_SOFTWARE;
        return;
    }
    double share = vxs_device_command_share(&s->command, s->time_ns);
    if (share < 1) out->flags |= share > 0 ? VXS_DEVICE_DECAYING : VXS_DEVICE_EXPIRED;
    const vxs_simulated_profile *profile = &s->config.profile;
    double force_factor = vxs_device_clamp_factor(wanted->force, profile->peak_force);
    double torque_factor = vxs_device_clamp_factor(wanted->torque, profile->peak_torque);
    if (!(profile->peak_torque > 0)) {
        torque_factor = 0;
        if (wanted->torque[0] != 0 || wanted->torque[1] != 0 || wanted->torque[2] != 0)
            out->flags |= VXS_DEVICE_INCOMPLETE;
    } else if (torque_factor < 1) {
        out->flags |= VXS_DEVICE_CLAMPED;
    }
    if (force_factor < 1) out->flags |= VXS_DEVICE_CLAMPED;
    for (int axis = 0; axis < 3; axis++) {
        out->rendered.force[axis] = wanted->force[axis] * force_factor * share;
        out->rendered.torque[axis] = wanted->torque[axis] * torque_factor * share;
    }
}

static void move(vxsi_simulated *s, const double force[3])
{
    const vxs_simulated_profile *profile = &s->config.profile;
    const vxs_simulated_arm *arm = &s->config.arm;
    uint32_t steps = s->config.substeps;
    double step = s->config.sample_time / steps, mobility = step / (profile->mass + arm->mass);
    double drag = 1 + mobility * (profile->viscosity + arm->viscosity + step * arm->stiffness);
    double stop = mobility * profile->friction / drag;
    for (uint32_t n = 1; n <= steps; n++) {
        double speed = 0;
        for (int axis = 0; axis < 3; axis++) {
            double way = s->target[axis] - s->hand[axis];
            double hand = s->hand[axis] + way * n / steps;
            double push = force[axis] + arm->stiffness * (hand - s->position[axis]) +
                          arm->viscosity * (way / s->config.sample_time);
            s->velocity[axis] = (s->velocity[axis] + mobility * push) / drag;
            speed += s->velocity[axis] * s->velocity[axis];
        }
        speed = sqrt(speed);
        double left = speed > stop ? 1 - stop / speed : 0;
        for (int axis = 0; axis < 3; axis++) {
            s->velocity[axis] *= left;
            s->position[axis] += step * s->velocity[axis];
        }
    }
    memcpy(s->hand, s->target, sizeof s->hand);
}

static void measure(vxsi_simulated *s, vxs_device_state *state)
{
    memset(state, 0, sizeof *state);
    double span = s->config.sample_time * (s->passed + 1);
    s->sequence++;
    s->passed = 0;
    for (int axis = 0; axis < 3; axis++) {
        double shown = vxsi_simulated_encode(s, s->position[axis] + noise_of(s));
        state->pose.position[axis] = shown;
        state->velocity[axis] = (shown - s->measured[axis]) / span;
        s->measured[axis] = shown;
    }
    memcpy(state->pose.orientation, s->orientation, sizeof s->orientation);
    state->velocity_source = VXS_DEVICE_VELOCITY_ESTIMATED;
    if (s->broken == VXS_DEVICE_FAULT_SOFTWARE) {
        state->pose.position[0] = NAN;
        s->broken = VXS_DEVICE_FAULT_NONE;
    }
}

void vxsi_simulated_exchange(void *self, const vxs_device_command *command, vxs_device_state *state,
                             vxs_device_report *report)
{
    vxsi_simulated *s = self;
    int lost = is_lost(s);
    if (command && !lost) s->command = *command;
    if (s->broken == VXS_DEVICE_FAULT_USB) s->state = VXS_DEVICE_GONE;

    /* The slot of delay_samples ago is read before the newest takes its place. */
    vxs_device_report newest;
    render(s, &newest);
    vxs_device_report acting = s->line[s->line_at];
    s->line[s->line_at] = newest;
    s->line_at = (s->line_at + 1) % s->config.delay_samples;
    if (s->state != VXS_DEVICE_ARMED) memset(&acting.rendered, 0, sizeof acting.rendered);
    if (report) *report = (vxs_device_report){.rendered = acting.rendered, .flags = newest.flags};

    move(s, acting.rendered.force);
    s->time_ns += s->sample_ns;
    if (s->state == VXS_DEVICE_GONE) {
        memset(state, 0, sizeof *state);
        state->pose = vxs_pose_identity();
        memcpy(state->pose.position, s->measured, sizeof s->measured);
    } else if (lost) {
        *state = s->heard;
        state->link_age += s->config.sample_time;
        s->heard.link_age = state->link_age;
        s->passed++;
    } else {
        measure(s, state);
        s->heard = *state;
    }
    state->sequence = s->sequence;
    state->time_ns = s->time_ns;
    state->state = s->state;
    state->fault = s->state == VXS_DEVICE_GONE ? VXS_DEVICE_FAULT_USB : s->fault;
}

void vxs_simulated_hand(vxs_device *device, const double position[3], const double *orientation)
{
    vxsi_simulated *s = device->self;
    if (position && is_finite(position)) memcpy(s->target, position, sizeof s->target);
    double rotation[9];
    vxs_pose pose = vxs_pose_identity();
    if (!orientation) return;
    memcpy(pose.orientation, orientation, sizeof pose.orientation);
    if (vxs_pose_rotation(&pose, rotation)) memcpy(s->orientation, orientation, sizeof s->orientation);
}

void vxs_simulated_truth(const vxs_device *device, double position[3], double velocity[3])
{
    const vxsi_simulated *s = device->self;
    if (position) memcpy(position, s->position, sizeof s->position);
    if (velocity) memcpy(velocity, s->velocity, sizeof s->velocity);
}

void vxs_simulated_break(vxs_device *device, uint32_t fault)
{
    vxsi_simulated *s = device->self;
    s->broken = fault;
}
