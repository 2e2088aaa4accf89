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

static uint64_t random_bits(vxsi_simulated *s)
{
    s->random ^= s->random << 13;
    s->random ^= s->random >> 7;
    return s->random ^= s->random << 17;
}

/* Twelve even numbers of 0 .. 65535, summed, have a deviation of 65536 but for their last bits. */
static double noise_of(vxsi_simulated *s)
{
    int sum = -6 * 65535;
    if (!(s->config.noise > 0)) return 0;
    for (int n = 0; n < 12; n++) sum += (int)(random_bits(s) >> 48);
    return sum * 0x1p-16 * s->config.noise;
}

/* A drop-out begins as often as set-up reckoned. */
static int is_lost(vxsi_simulated *s)
{
    if (s->lost_left == 0 && (uint32_t)(random_bits(s) >> 32) < s->lost_below) s->lost_left = s->lost_each;
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
    if (s->heard.state != VXS_DEVICE_ARMED) return;
    if (!is_finite(wanted->force) || !is_finite(wanted->torque)) {
        out->flags = VXS_DEVICE_REFUSED;
        s->heard.state = VXS_DEVICE_FAULT;
        s->heard.fault = VXS_DEVICE_FAULT_SOFTWARE;
        return;
    }
    double share = vxs_device_command_share(&s->command, s->heard.time_ns);
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

/* What was measured last stays, where nothing is heard. */
static void measure(vxsi_simulated *s, int lost, vxs_device_state *state)
{
    vxs_device_state *heard = &s->heard;
    double span = s->config.sample_time + heard->link_age;
    heard->link_age = span;
    if (!lost) {
        for (int axis = 0; axis < 3; axis++) {
            double shown = vxsi_simulated_encode(s, s->position[axis] + noise_of(s));
            heard->velocity[axis] = (shown - heard->pose.position[axis]) / span;
            heard->pose.position[axis] = shown;
        }
        memcpy(heard->pose.orientation, s->orientation, sizeof s->orientation);
        heard->sequence++;
        heard->link_age = 0;
    }
    *state = *heard;
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
    if (s->broken == VXS_DEVICE_FAULT_USB) {
        s->heard.state = VXS_DEVICE_GONE;
        s->heard.fault = VXS_DEVICE_FAULT_USB;
    }

    /* The slot of delay_samples ago is read before the newest takes its place. */
    vxs_device_report *slot = &s->line[s->line_at], acting = *slot;
    render(s, slot);
    s->line_at = (s->line_at + 1) % s->config.delay_samples;
    if (s->heard.state != VXS_DEVICE_ARMED) memset(&acting.rendered, 0, sizeof acting.rendered);
    acting.flags = slot->flags;
    if (report) *report = acting;

    move(s, acting.rendered.force);
    s->heard.time_ns += s->sample_ns;
    measure(s, lost || s->heard.state == VXS_DEVICE_GONE, state);
}

void vxs_simulated_hand(vxs_device *device, const double position[3], const double *orientation)
{
    vxsi_simulated *s = device->self;
    if (position && is_finite(position)) memcpy(s->target, position, sizeof s->target);
    double rotation[9];
    if (!orientation) return;
    const vxs_pose pose = {.orientation = {orientation[0], orientation[1], orientation[2], orientation[3]}};
    if (vxs_pose_rotation(&pose, rotation)) memcpy(s->orientation, orientation, sizeof s->orientation);
}
