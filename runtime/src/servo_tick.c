/* SPDX-License-Identifier: MIT
 *
 * One tick of the servo. rt-safe: pure arithmetic on what it is given.
 */
#include "servo_state.h"

#include <math.h>
#include <string.h>

static const double quarter_turn = 0.5; /* cos^2 of half the angle */

static int is_finite(const double v[3])
{
    return isfinite(fabs(v[0]) + fabs(v[1]) + fabs(v[2]));
}

/* The tip in the scene: mount o (scale position, orientation). Returns 0 if not finite. */
static int scene_pose(const vxs_servo *servo, const vxs_device_state *state, vxs_pose *tip)
{
    if (!is_finite(state->velocity) || !is_finite(state->angular_velocity)) return 0;
    vxs_pose scaled = state->pose;
    for (int axis = 0; axis < 3; axis++) scaled.position[axis] *= servo->config.scale;
    return vxs_pose_compose(&servo->config.mount, &scaled, tip);
}

static void to_device_frame(const vxs_servo *servo, const double v[3], double out[3])
{
    const double *r = servo->mount;
    for (int i = 0; i < 3; i++) out[i] = (r[i] * v[0] + r[3 + i] * v[1]) + r[6 + i] * v[2];
}

/* Sums and differences of such times cannot overflow. */
static int is_time(int64_t time_ns)
{
    return time_ns >= 0 && time_ns < INT64_MAX / 4;
}

/* Missed ticks and a silent link: what they cost in gain, and whether the device counts as lost. */
static uint32_t watch_clock(vxs_servo *servo, const vxs_device_state *state, int64_t now_ns)
{
    uint32_t flags = 0;
    if (servo->has_last) {
        if (now_ns - servo->last_time_ns > servo->sample_ns + servo->sample_ns / 2) flags |= VXS_SERVO_MISSED;
        /* What the hand felt when this tick came late is where the ramp goes on. */
        servo->gain *= vxs_device_command_share(&servo->command, now_ns);
    }
    if (servo->has_last && state->sequence == servo->last_sequence) {
        flags |= VXS_SERVO_DEVICE_STALE;
        if (now_ns - servo->last_news_ns > servo->hold_ns + servo->decay_ns) flags |= VXS_SERVO_DEVICE_LOST;
    } else {
        servo->last_news_ns = now_ns;
    }
    if (state->state == VXS_DEVICE_FAULT || state->state == VXS_DEVICE_GONE) flags |= VXS_SERVO_DEVICE_LOST;
    servo->has_last = 1;
    servo->last_sequence = state->sequence;
    servo->last_time_ns = now_ns;
    return flags;
}

/* No hand does that: the device was re-homed, or its tracking found it elsewhere. */
static int is_teleport(const vxs_servo *servo, const vxs_device_state *state, int64_t now_ns)
{
    double square = 0, cosine = 0, length = 0, last_length = 0;
    double most = servo->config.max_speed * ((double)(now_ns - servo->last_pose_ns) * 1e-9);
    for (int axis = 0; axis < 3; axis++) {
        double way = state->pose.position[axis] - servo->last_pose.position[axis];
        square += way * way;
    }
    for (int i = 0; i < 4; i++) {
        double a = state->pose.orientation[i], b = servo->last_pose.orientation[i];
        cosine += a * b;
        length += a * a;
        last_length += b * b;
    }
    return square > most * most || cosine * cosine < quarter_turn * (length * last_length);
}

static void rest(vxs_servo *servo, const vxs_pose *tip)
{
    servo->gain = 0;
    memset(&servo->shaped, 0, sizeof servo->shaped);
    if (tip) vxs_coupling_reset(servo->coupling, tip);
}

/* Moves *last towards wanted by at most `most`. Returns whether that was less than the way. */
static int slew(double last[3], const double wanted[3], double most)
{
    double way[3] = {wanted[0] - last[0], wanted[1] - last[1], wanted[2] - last[2]};
    double factor = vxs_device_clamp_factor(way, most);
    for (int axis = 0; axis < 3; axis++)
        last[axis] = factor < 1 ? last[axis] + factor * way[axis] : wanted[axis];
    return factor < 1;
}

static int clamp(double v[3], double limit)
{
    double factor = vxs_device_clamp_factor(v, limit);
    for (int axis = 0; axis < 3; axis++) v[axis] *= factor;
    return factor < 1;
}

static uint32_t shape(vxs_servo *servo, const vxs_wrench *output)
{
    const vxs_servo_config *config = &servo->config;
    vxs_wrench wanted;
    to_device_frame(servo, output->force, wanted.force);
    to_device_frame(servo, output->torque, wanted.torque);
    uint32_t flags = 0;
    double most = config->max_slew * config->coupling.sample_time;
    if (slew(servo->shaped.force, wanted.force, most)) flags |= VXS_SERVO_SLEWED;
    if (slew(servo->shaped.torque, wanted.torque, most * config->max_torque / config->max_force))
        flags |= VXS_SERVO_SLEWED;
    if (clamp(servo->shaped.force, config->max_force)) flags |= VXS_SERVO_SATURATED;
    if (clamp(servo->shaped.torque, config->max_torque)) flags |= VXS_SERVO_SATURATED;
    double step = config->ramp_time > 0 ? config->coupling.sample_time / config->ramp_time : 1;
    servo->gain = servo->gain + step < 1 ? servo->gain + step : 1;
    if (servo->gain < 1) flags |= VXS_SERVO_RAMPING;
    for (int axis = 0; axis < 3; axis++) {
        servo->command.wrench.force[axis] = servo->shaped.force[axis] * servo->gain;
        servo->command.wrench.torque[axis] = servo->shaped.torque[axis] * servo->gain;
    }
    return flags;
}

/* Contact, coupling and shaping at a pose that is finite. */
static uint32_t feel(vxs_servo *servo, const vxs_pose *tip, int is_armed, vxs_contact_result *contact,
                     vxs_wrench *output)
{
    if (!is_armed)
        servo->phase = VXSI_SERVO_IS_OFF;
    else if (servo->phase == VXSI_SERVO_IS_OFF)
        servo->phase = VXSI_SERVO_IS_BLOCKED;
    if (servo->phase != VXSI_SERVO_IS_LIVE) rest(servo, tip);

    uint32_t flags;
    do {
        vxs_pose body, object;
        vxs_coupling_pose(servo->coupling, tip, &body);
        if (!vxs_pose_compose(&body, &servo->config.grip, &object)) return VXS_SERVO_FAULT;
        flags = vxs_contact_evaluate(servo->contact, servo->config.statics, servo->config.static_count,
                                     &object, &servo->config.contact, contact);
        if (flags & VXS_CONTACT_INVALID) return flags | VXS_SERVO_FAULT;
    } while (servo->phase == VXSI_SERVO_IS_LIVE &&
             vxs_coupling_refine(servo->coupling, &contact->wrench, contact->depth, tip));
    if (!is_armed) return flags | VXS_SERVO_OFF;
    if (servo->phase == VXSI_SERVO_IS_BLOCKED) {
        if (contact->points > 0 || contact->deep_points > 0) return flags | VXS_SERVO_START_IN_CONTACT;
        servo->phase = VXSI_SERVO_IS_LIVE;
    }
    if (vxs_coupling_step(servo->coupling, &contact->wrench, tip, output) & VXS_COUPLING_INVALID)
        return flags | VXS_SERVO_FAULT;
    return flags | shape(servo, output);
}

uint32_t vxs_servo_tick(vxs_servo *servo, const vxs_device_state *state, vxs_device_command *command,
                        vxs_servo_trace *trace)
{
    vxs_contact_result contact;
    vxs_wrench output;
    vxs_pose tip;
    memset(&contact, 0, sizeof contact);
    memset(&output, 0, sizeof output);
    int64_t now_ns = is_time(state->time_ns) ? state->time_ns : servo->last_time_ns;
    uint32_t flags = watch_clock(servo, state, now_ns);
    memset(&servo->command, 0, sizeof servo->command);

    if (!is_time(state->time_ns) || !scene_pose(servo, state, &tip)) servo->has_fault = 1;
    if (!servo->has_fault) {
        int is_armed = state->state == VXS_DEVICE_ARMED && !(flags & VXS_SERVO_DEVICE_LOST);
        if (servo->phase != VXSI_SERVO_IS_OFF && is_teleport(servo, state, now_ns)) {
            servo->phase = VXSI_SERVO_IS_OFF;
            flags |= VXS_SERVO_TELEPORT;
        }
        servo->last_pose = state->pose;
        servo->last_pose_ns = now_ns;
        flags |= feel(servo, &tip, is_armed, &contact, &output);
        if (flags & VXS_SERVO_FAULT) servo->has_fault = 1;
    }
    if (!is_finite(servo->command.wrench.force) || !is_finite(servo->command.wrench.torque))
        servo->has_fault = 1;
    if (servo->has_fault) {
        flags |= VXS_SERVO_FAULT;
        servo->phase = VXSI_SERVO_IS_OFF;
        memset(&servo->command.wrench, 0, sizeof servo->command.wrench);
        rest(servo, NULL);
    }
    servo->command.sequence = servo->tick;
    servo->command.hold_ns = now_ns + servo->hold_ns;
    servo->command.expires_ns = servo->command.hold_ns + servo->decay_ns;
    *command = servo->command;
    if (trace) {
        memset(trace, 0, sizeof *trace);
        trace->tick = servo->tick;
        trace->time_ns = state->time_ns;
        trace->pose = state->pose;
        trace->collision = contact.wrench;
        trace->output = output;
        trace->command = servo->command.wrench;
        trace->depth = contact.depth;
        trace->gain = servo->gain;
        trace->points = contact.points;
        trace->deep_points = contact.deep_points;
        trace->patches = contact.patches;
        trace->level = contact.level;
        trace->probed = contact.probed;
        trace->flags = flags;
    }
    servo->tick++;
    return flags;
}

void vxs_servo_clear(vxs_servo *servo)
{
    servo->has_fault = 0;
    servo->phase = VXSI_SERVO_IS_OFF;
}
