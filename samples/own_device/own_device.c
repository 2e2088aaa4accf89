/* SPDX-License-Identifier: MIT
 *
 * A laboratory's own device as a backend in one file: a slider with one motor, on a made-up board. From "the
 * backend" to "its use" is all that one has to write. Usage: own_device SCENE.plan
 */
#define _POSIX_C_SOURCE 199309L /* nanosleep */

#include "../scene.h"

#include "voxshell/servo_thread.h"

#include <math.h>
#include <time.h>

/* --- the board, as its vendor's library would have it: counts in, motor units out, never blocks --- */

typedef struct board {
    double x, speed, hand; /* a carriage of 300 g that somebody holds, 500 N/m */
    double units;          /* at the motor */
} board;

static const double metres_per_count = 20e-6, units_per_newton = 128;

static int board_read(board *b, int *count)
{
    const double mass = 0.3, spring = 500, damper = 10, step = 1e-4;
    for (int n = 0; n < 10; n++) { /* a millisecond passes */
        b->speed +=
            step / mass * (b->units / units_per_newton + spring * (b->hand - b->x) - damper * b->speed);
        b->x += step * b->speed;
    }
    *count = (int)floor(b->x / metres_per_count + 0.5);
    return 1;
}

/* --- the backend --- */

typedef struct slider {
    vxs_device device; /* what the caller gets */
    board *board;
    uint32_t state, fault;
    uint64_t sequence;
    int64_t time_ns;
    double last;
    vxs_device_command command; /* the newest */
} slider;

static vxs_result arm(void *self)
{
    slider *s = self;
    if (s->state == VXS_DEVICE_GONE) return VXS_LOST;
    if (s->state != VXS_DEVICE_READY && s->state != VXS_DEVICE_ARMED) return VXS_STATE;
    memset(&s->command, 0, sizeof s->command); /* nothing that was commanded before acts after */
    s->state = VXS_DEVICE_ARMED;
    return VXS_OK;
}

static vxs_result disarm(void *self)
{
    slider *s = self;
    if (s->state == VXS_DEVICE_GONE) return VXS_LOST;
    s->board->units = 0;
    s->state = VXS_DEVICE_READY;
    s->fault = VXS_DEVICE_FAULT_NONE;
    return VXS_OK;
}

static void close_slider(void *self)
{
    slider *s = self;
    s->board->units = 0; /* whatever happens, the last word is zero */
    s->state = VXS_DEVICE_CLOSED;
}

/* Zero, unless all is well: ARMED, the command's time not over, a finite number; and never more than the
 * peak. */
static void push(slider *s, vxs_device_report *report)
{
    double force = s->command.wrench.force[0], peak = s->device.caps.peak_force;
    memset(report, 0, sizeof *report);
    s->board->units = 0;
    if (s->state != VXS_DEVICE_ARMED) return;
    if (!isfinite(force)) {
        s->state = VXS_DEVICE_FAULT;
        s->fault = VXS_DEVICE_FAULT_SOFTWARE;
        report->flags = VXS_DEVICE_REFUSED;
        return;
    }
    double share = vxs_device_command_share(&s->command, s->time_ns);
    if (share < 1) report->flags |= share > 0 ? VXS_DEVICE_DECAYING : VXS_DEVICE_EXPIRED;
    if (fabs(force) > peak) report->flags |= VXS_DEVICE_CLAMPED;
    if (s->command.wrench.force[1] != 0 || s->command.wrench.force[2] != 0)
        report->flags |= VXS_DEVICE_INCOMPLETE;
    report->rendered.force[0] = fmax(-peak, fmin(peak, force)) * share;
    s->board->units = report->rendered.force[0] * units_per_newton;
}

static void exchange(void *self, const vxs_device_command *command, vxs_device_state *state,
                     vxs_device_report *report)
{
    slider *s = self;
    vxs_device_report ignored;
    int count;
    if (command) s->command = *command;
    push(s, report ? report : &ignored);
    memset(state, 0, sizeof *state);
    state->pose = vxs_pose_identity();
    state->pose.position[0] = s->last;
    if (!board_read(s->board, &count)) {
        s->state = VXS_DEVICE_GONE;
        s->fault = VXS_DEVICE_FAULT_USB;
    } else {
        s->time_ns += 1000000; /* a real one reads CLOCK_MONOTONIC when the counts arrive */
        s->sequence++;
        state->pose.position[0] = count * metres_per_count;
        state->velocity[0] = (state->pose.position[0] - s->last) * 1000;
        state->velocity_source = VXS_DEVICE_VELOCITY_ESTIMATED;
        s->last = state->pose.position[0];
    }
    state->sequence = s->sequence;
    state->time_ns = s->time_ns;
    state->state = s->state;
    state->fault = s->fault;
}

static const vxs_device_ops slider_ops = {
    .name = "slider", .arm = arm, .disarm = disarm, .close = close_slider, .exchange = exchange};

static vxs_device *open_slider(slider *s, board *b)
{
    memset(s, 0, sizeof *s);
    s->device.ops = &slider_ops;
    s->device.self = s;
    s->board = b;
    s->state = VXS_DEVICE_READY;
    vxs_device_caps *caps = &s->device.caps;
    snprintf(caps->name, sizeof caps->name, "slider");
    caps->dof_sensed = caps->dof_actuated = 1; /* x */
    caps->rate_hz = 1000;
    caps->peak_force = 6;
    caps->resolution = metres_per_count;
    caps->has_motors = 1; /* only a servo with start-inside and soft-start may drive it */
    return &s->device;
}

/* --- its use --- */

enum { ROWS = 4096 };

/* The hand goes 28 mm inwards from where the slider's middle is. */
static void move_hand(void *user, uint64_t tick)
{
    board *b = user;
    b->hand = tick < 800 ? 0 : tick < 1200 ? -0.028 * (double)(tick - 800) / 400 : -0.028;
}

int main(int count, char **arguments)
{
    scene bed;
    if (count != 2 || !scene_open(&bed, arguments[1])) {
        fprintf(stderr, "usage: own_device SCENE.plan\n");
        return 1;
    }
    bed.config.mount.position[0] = 0.075; /* the slider's middle is in front of the wall */
    bed.config.mount.position[1] = 0.04;
    vxs_servo *servo = scene_servo(&bed);
    if (!servo) return 1;

    board b = {0};
    slider s;
    vxs_device *device = open_slider(&s, &b);
    vxs_servo_thread_config loop;
    vxs_servo_thread_config_default(&loop);
    loop.device = device;
    loop.servo = servo;
    loop.max_ticks = 2500;
    loop.on_tick = move_hand;
    loop.user = &b;
    void *ring = scene_memory(vxs_trace_memory(ROWS)), *room = scene_memory(vxs_servo_thread_memory());
    vxs_servo_thread *thread;
    vxs_result result = vxs_device_arm(device);
    if (result == VXS_OK) result = vxs_trace_init(ring, vxs_trace_memory(ROWS), ROWS, &loop.trace);
    if (result == VXS_OK) result = vxs_servo_thread_start(room, vxs_servo_thread_memory(), &loop, &thread);
    if (result != VXS_OK) return !scene_refuses("thread", result);
    vxs_servo_thread_status status;
    vxs_servo_trace row;
    const struct timespec while_ago = {.tv_nsec = 20000000};
    memset(&row, 0, sizeof row);
    do {
        nanosleep(&while_ago, NULL);
        vxs_servo_thread_get(thread, &status);
        while (vxs_trace_drain(loop.trace, &row, 1) > 0) continue; /* the last is kept */
    } while (status.running);
    vxs_servo_thread_stop(thread); /* its last exchange sent zero */
    printf("slider at %.2f mm, hand at %.2f mm: the loop pushes with %.3f N, the hand with %.3f N\n",
           1e3 * b.x, 1e3 * b.hand, row.command.force[0], 500 * (b.x - b.hand));
    printf("%llu ticks, flags of the last %#x; motor at %.3f N after the end\n",
           (unsigned long long)status.ticks, (unsigned)status.last_flags, b.units / units_per_newton);
    vxs_device_close(device);
    free(ring);
    free(room);
    scene_close(&bed);
    return 0;
}
