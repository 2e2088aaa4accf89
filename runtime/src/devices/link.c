/* SPDX-License-Identifier: MIT
 *
 * A link's two threads: the servo's exchange, and the I/O thread's turn. Neither allocates, locks or logs.
 */
#include "link.h"

#include <math.h>

enum { HELD_AFTER = 3, FAULT_AFTER = 20, PACKETS_A_TURN = 16 };
static const int64_t ramp_ns = 500000000, fresh_ns = 10000000, silence_ns = 100000000, reply_ns = 5000000;
static const double jump = 0.005; /* [m] that noise or a late packet may make */

int vxsi_link_is_finite(const double v[3])
{
    return isfinite(fabs(v[0]) + fabs(v[1]) + fabs(v[2]));
}

static void add(atomic_uint_least64_t *counter)
{
    atomic_fetch_add_explicit(counter, 1, memory_order_relaxed);
}

/* The cause first: whoever sees the state finds it. GONE is for ever. */
void vxsi_link_fail(vxsi_link *link, uint32_t fault)
{
    uint32_t state = atomic_load(&link->state);
    while (state == VXS_DEVICE_ARMED || state == VXS_DEVICE_READY || state == VXS_DEVICE_UNCALIBRATED) {
        atomic_store(&link->fault, fault);
        if (atomic_compare_exchange_weak(&link->state, &state, VXS_DEVICE_FAULT)) return;
    }
}

static int lose(vxsi_link *link)
{
    atomic_store(&link->fault, VXS_DEVICE_FAULT_USB);
    atomic_store(&link->state, VXS_DEVICE_GONE);
    return 0;
}

void vxsi_link_exchange(void *self, const vxs_device_command *command, vxs_device_state *state,
                        vxs_device_report *report)
{
    vxsi_link *link = self;
    uint32_t refused = 0;
    if (command) {
        if (vxsi_link_is_finite(command->wrench.force) && vxsi_link_is_finite(command->wrench.torque)) {
            vxsi_mailbox_put(&link->command, command, sizeof *command);
        } else {
            refused = VXS_DEVICE_REFUSED;
            vxsi_link_fail(link, VXS_DEVICE_FAULT_SOFTWARE);
        }
    }
    vxsi_mailbox_get(&link->news, &link->seen, sizeof link->seen);
    int64_t now = link->now(link->user), measured = link->seen.state.time_ns;
    *state = link->seen.state;
    state->link_age = now > measured ? (double)(now - measured) * 1e-9 : 0;
    state->time_ns = now;
    state->state = atomic_load(&link->state);
    state->fault = state->state == VXS_DEVICE_FAULT || state->state == VXS_DEVICE_GONE
                       ? atomic_load(&link->fault)
                       : VXS_DEVICE_FAULT_NONE;
    if (!report) return;
    *report = link->seen.report;
    if (state->state != VXS_DEVICE_ARMED) memset(&report->rendered, 0, sizeof report->rendered);
    report->flags |= refused;
}

/* A measurement that no hand made is not shown. */
static void judge(vxsi_link *link, vxs_device_state *state, int64_t now)
{
    const vxs_device_state *before = &link->measured;
    double way = 0, turn = 0;
    for (int n = 0; n < 4; n++) turn += fabs(state->pose.orientation[n]);
    if (!vxsi_link_is_finite(state->pose.position) || !isfinite(turn) ||
        !vxsi_link_is_finite(state->velocity) || !vxsi_link_is_finite(state->angular_velocity)) {
        vxsi_link_fail(link, VXS_DEVICE_FAULT_SOFTWARE);
        return;
    }
    double passed = (double)(now - link->last_news_ns) * 1e-9;
    for (int n = 0; n < 3; n++) {
        double d = state->pose.position[n] - before->pose.position[n];
        way += d * d;
    }
    if (link->sequence > 0 && before->state != VXS_DEVICE_UNCALIBRATED &&
        sqrt(way) > jump + link->config.max_speed * passed) {
        add(&link->malformed);
        vxsi_link_fail(link, VXS_DEVICE_FAULT_VELOCITY);
    }
    if (state->velocity_source != VXS_DEVICE_VELOCITY_MEASURED) {
        state->velocity_source = VXS_DEVICE_VELOCITY_ESTIMATED;
        for (int n = 0; n < 3; n++)
            state->velocity[n] = link->sequence > 0 && passed > 0
                                     ? (state->pose.position[n] - before->pose.position[n]) / passed
                                     : 0;
    }
    link->measured = *state;
    link->measured.sequence = ++link->sequence;
    link->measured.time_ns = now;
    link->last_news_ns = now;
    link->bad_in_a_row = 0;
    link->is_waiting = 0;
    add(&link->measured_count);
}

/* What the device says of itself: it may lose its calibration, its nerve, or its arming, but never gain the
 * latter. */
static void heed(vxsi_link *link, const vxs_device_state *said)
{
    uint32_t state = atomic_load(&link->state), next;
    if (said->state == VXS_DEVICE_FAULT) vxsi_link_fail(link, said->fault);
    if (said->state != VXS_DEVICE_READY && said->state != VXS_DEVICE_UNCALIBRATED) return;
    if (state == VXS_DEVICE_ARMED && said->state == VXS_DEVICE_UNCALIBRATED)
        vxsi_link_fail(link, VXS_DEVICE_FAULT_PROTOCOL);
    next = said->state;
    if (state != next && (state == VXS_DEVICE_READY || state == VXS_DEVICE_UNCALIBRATED))
        atomic_compare_exchange_strong(&link->state, &state, next);
}

static int hear(vxsi_link *link, int64_t wait_ns)
{
    uint8_t bytes[VXSI_WIRE_MOST];
    for (int n = 0; n < PACKETS_A_TURN; n++) {
        int32_t count = link->wire.ops->receive(link->wire.self, bytes, sizeof bytes, n == 0 ? wait_ns : 0);
        if (count < 0) return lose(link);
        if (count == 0) return 1;
        vxs_device_state state = link->measured;
        uint32_t found = link->driver->take(link, bytes, (size_t)count, &state);
        if (found & VXSI_LINK_MALFORMED) {
            add(&link->malformed);
            if (++link->bad_in_a_row >= FAULT_AFTER) vxsi_link_fail(link, VXS_DEVICE_FAULT_PROTOCOL);
        }
        if (found & VXSI_LINK_NEWS) {
            judge(link, &state, link->now(link->user));
            heed(link, &state);
        }
    }
    return 1;
}

/* The part of a wrench that the device has motors for. */
static uint32_t leave_out(uint32_t dof, vxs_wrench *wrench)
{
    uint32_t flags = 0;
    for (int n = 0; n < 6; n++) {
        double *value = n < 3 ? &wrench->force[n] : &wrench->torque[n - 3];
        if (dof >> n & 1) continue;
        if (*value != 0) flags = VXS_DEVICE_INCOMPLETE;
        *value = 0;
    }
    return flags;
}

/* The gate: nothing reaches a motor but through here. */
static void gate(vxsi_link *link, int64_t now, vxs_device_report *out)
{
    vxs_device_command command;
    memset(out, 0, sizeof *out);
    int64_t armed = atomic_load(&link->armed_ns);
    if (atomic_load(&link->state) != VXS_DEVICE_ARMED) return;
    if (!vxsi_mailbox_get(&link->command, &command, sizeof command)) return;
    if (link->bad_in_a_row >= HELD_AFTER ||
        (!link->driver->may_be_silent && now - link->last_news_ns > fresh_ns)) {
        out->flags = VXS_DEVICE_EXPIRED;
        return;
    }
    double share = vxs_device_command_share(&command, now);
    if (share < 1) out->flags |= share > 0 ? VXS_DEVICE_DECAYING : VXS_DEVICE_EXPIRED;
    const vxs_device_caps *caps = &link->device.caps;
    vxs_wrench wrench = command.wrench;
    out->flags |= leave_out(caps->dof_actuated, &wrench);
    double ramp = now - armed < ramp_ns ? (double)(now - armed) / (double)ramp_ns : 1;
    if (!(ramp > 0)) return;
    double force = vxs_device_clamp_factor(wrench.force, ramp * caps->peak_force);
    double torque = vxs_device_clamp_factor(wrench.torque, ramp * caps->peak_torque);
    if (force < 1 || torque < 1) out->flags |= VXS_DEVICE_CLAMPED;
    for (int n = 0; n < 3; n++) {
        out->rendered.force[n] = wrench.force[n] * force * share;
        out->rendered.torque[n] = wrench.torque[n] * torque * share;
    }
}

static int speak(vxsi_link *link, int64_t now, vxs_device_report *report)
{
    uint8_t bytes[VXSI_WIRE_MOST];
    uint32_t is_armed = atomic_load(&link->state) == VXS_DEVICE_ARMED;
    gate(link, now, report);
    size_t size =
        link->driver->make(link, &report->rendered, is_armed ? atomic_load(&link->arming) : 0, bytes);
    link->last_send_ns = now;
    if (size == 0) return 1;
    vxs_result result = link->wire.ops->send(link->wire.self, bytes, size);
    if (result == VXS_OK) {
        link->is_waiting = link->driver->answers;
        add(&link->sent);
    } else if (result == VXS_BUSY) {
        add(&link->late);
    } else {
        return lose(link);
    }
    return 1;
}

static int is_zero(const vxs_wrench *wrench)
{
    static const vxs_wrench zero = {{0, 0, 0}, {0, 0, 0}};
    return memcmp(wrench, &zero, sizeof zero) == 0;
}

/* Letting go waits for nobody. A tenth of a period early is on time: the next turn would be late. */
static int is_due(const vxsi_link *link, int64_t now)
{
    if (!is_zero(&link->report.rendered) && atomic_load(&link->state) != VXS_DEVICE_ARMED) return 1;
    int64_t passed = now - link->last_send_ns;
    return !link->is_waiting && (passed < 0 || passed >= link->period_ns - link->period_ns / 10);
}

int vxsi_link_step(vxsi_link *link, int64_t wait_ns)
{
    vxsi_link_news news;
    if (atomic_load(&link->state) == VXS_DEVICE_GONE) return 0;
    uint64_t sequence = link->sequence;
    memset(&news.report, 0, sizeof news.report);
    int is_here = hear(link, wait_ns), has_spoken = 0;
    int64_t now = link->now(link->user);
    if (is_here) {
        if (now < link->last_step_ns) vxsi_link_fail(link, VXS_DEVICE_FAULT_SOFTWARE);
        if (!link->driver->may_be_silent && now - link->last_news_ns > silence_ns &&
            atomic_load(&link->state) == VXS_DEVICE_ARMED)
            vxsi_link_fail(link, VXS_DEVICE_FAULT_WATCHDOG);
        link->last_step_ns = now;
        if (link->is_waiting && now - link->last_send_ns > reply_ns) {
            link->is_waiting = 0;
            add(&link->late);
        }
        if (is_due(link, now)) {
            is_here = speak(link, now, &news.report);
            has_spoken = 1;
        }
    }
    if (has_spoken || sequence != link->sequence || !is_here) {
        if (!has_spoken) news.report = link->report;
        link->report = news.report;
        news.state = link->measured;
        vxsi_mailbox_put(&link->news, &news, sizeof news);
    }
    return is_here;
}
