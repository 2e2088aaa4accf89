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

/* Sums and differences of such times cannot overflow. */
static int is_time(int64_t time_ns)
{
    return time_ns >= 0 && time_ns < INT64_MAX / 4;
}

/* Missed ticks and a silent link: what the device still rendered, and whether it counts as lost. */
static void watch_clock(vxs_servo *servo, int64_t now_ns, vxs_tick *tick)
{
    const vxs_device_state *state = tick->state;
    uint32_t flags = 0;
    if (servo->has_last) {
        const int64_t passed = now_ns - servo->last_time_ns;
        if (passed > servo->sample_ns + servo->sample_ns / 2) flags |= VXS_SERVO_MISSED;
        if (passed > servo->sample_ns) tick->elapsed = (double)passed * 1e-9;
        tick->share = vxs_device_command_share(&servo->command, now_ns);
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
    tick->is_armed = state->state == VXS_DEVICE_ARMED && !(flags & VXS_SERVO_DEVICE_LOST);
    tick->flags |= flags;
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

static void run_steps(vxs_servo *servo, vxs_tick *tick)
{
    const vxsi_step *end = servo->steps + servo->step_count;
    if (!servo->is_live) {
        for (const vxsi_step *step = servo->steps; step < end; step++)
            if (step->reset) step->reset(step->self, &tick->tip);
    }
    for (const vxsi_step *step = servo->steps; step < end && !(tick->flags & VXSI_TICK_ENDS); step++)
        if (step->run) step->run(step->self, tick);
}

static void write_trace(const vxs_servo *servo, const vxs_tick *tick, vxs_servo_trace *trace)
{
    const vxs_contact_result *contact = &tick->contact;
    memset(trace, 0, sizeof *trace);
    trace->tick = servo->tick;
    trace->time_ns = tick->state->time_ns;
    trace->pose = tick->state->pose;
    trace->body = tick->body;
    trace->collision = contact->wrench;
    trace->output = tick->output;
    trace->command = servo->command.wrench;
    trace->depth = contact->depth;
    trace->gain = tick->gain;
    trace->energy = tick->energy;
    trace->damping = tick->damping;
    trace->points = contact->points;
    trace->deep_points = contact->deep_points;
    trace->patches = contact->patches;
    trace->level = contact->level;
    trace->probed = contact->probed;
    trace->flags = tick->flags;
}

uint32_t vxs_servo_tick(vxs_servo *servo, const vxs_device_state *state, vxs_device_command *command,
                        vxs_servo_trace *trace)
{
    vxs_tick tick = {.state = state,
                     .elapsed = servo->config.coupling.sample_time,
                     .moving = servo->moving,
                     .has_body = servo->has_body,
                     .last = &servo->command.wrench,
                     .share = 1,
                     .gain = 1};
    int64_t now_ns = is_time(state->time_ns) ? state->time_ns : servo->last_time_ns;
    watch_clock(servo, now_ns, &tick);
    if (!is_time(state->time_ns) || !scene_pose(servo, state, &tick.tip)) servo->has_fault = 1;
    if (!servo->has_fault) {
        if (servo->was_armed && is_teleport(servo, state, now_ns)) {
            servo->is_live = 0;
            tick.flags |= VXS_SERVO_TELEPORT;
        }
        servo->last_pose = state->pose;
        servo->last_pose_ns = now_ns;
        run_steps(servo, &tick);
        if (tick.flags & VXS_SERVO_FAULT || !is_finite(tick.wrench.force) || !is_finite(tick.wrench.torque))
            servo->has_fault = 1;
    }
    if (servo->has_fault) tick.flags |= VXS_SERVO_FAULT;
    servo->is_live = !(tick.flags & VXSI_TICK_ENDS);
    servo->was_armed = tick.is_armed && !servo->has_fault;
    if (!servo->is_live) {
        memset(&tick.wrench, 0, sizeof tick.wrench);
        tick.gain = 0;
    }
    servo->command.wrench = tick.wrench;
    servo->command.sequence = servo->tick;
    servo->command.hold_ns = now_ns + servo->hold_ns;
    servo->command.expires_ns = servo->command.hold_ns + servo->decay_ns;
    *command = servo->command;
    if (trace) write_trace(servo, &tick, trace);
    servo->tick++;
    return tick.flags;
}

void vxs_servo_clear(vxs_servo *servo)
{
    servo->has_fault = 0;
    servo->is_live = servo->was_armed = 0;
}
