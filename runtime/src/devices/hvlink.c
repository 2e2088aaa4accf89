/* SPDX-License-Identifier: MIT
 *
 * hvlink's host end: formats/hvlink.md. Not verified on hardware.
 */
#include "voxshell/hvlink.h"
#include "link.h"

#include <stdio.h>

enum { HELLOS = 10, MOST_ARMS = 200, LATE = 16 };

typedef struct hvlink_host {
    vxs_hvlink_stream stream;
    vxs_hvlink_caps caps;
    uint16_t sequence, last_sequence;
    uint32_t has_caps, has_state;
    uint32_t arming;    /* that the device was told of */
    uint32_t was_armed; /* it said so since then */
    uint32_t arms;      /* sent since then */
    uint8_t said;       /* VXS_HVLINK_READY ... */
} hvlink_host;
_Static_assert(sizeof(hvlink_host) <= VXSI_LINK_MEMORY, "a driver's memory");

static hvlink_host *host_of(vxsi_link *link)
{
    return (hvlink_host *)(void *)link->driver_memory;
}

static size_t seal(vxsi_link *link, vxs_hvlink_frame *frame, uint8_t *bytes)
{
    frame->sequence = host_of(link)->sequence++;
    frame->time_us = (uint32_t)(link->now(link->user) / 1000);
    return vxs_hvlink_encode(frame, bytes, VXSI_WIRE_MOST);
}

static int is_caps(vxsi_link *link, const uint8_t *bytes, size_t size)
{
    hvlink_host *host = host_of(link);
    vxs_hvlink_frame frame;
    for (size_t n = 0; n < size; n++) {
        vxs_hvlink_put(&host->stream, bytes[n]);
        while (vxs_hvlink_take(&host->stream, &frame))
            host->has_caps |= vxs_hvlink_unpack_caps(&frame, &host->caps);
    }
    return host->has_caps;
}

/* Values in the order x y z; 7 sensed have the orientation, 6 actuated the torque. */
static vxs_result fill_caps(vxsi_link *link)
{
    const vxs_hvlink_caps *from = &host_of(link)->caps;
    vxs_device_caps *caps = &link->device.caps;
    if (from->major != VXS_HVLINK_MAJOR || from->space != VXS_HVLINK_TASK) return VXS_UNSUPPORTED;
    if ((from->sensed > 3 && from->sensed != 7) || (from->actuated > 3 && from->actuated != 6))
        return VXS_UNSUPPORTED;
    if (!(from->peak_force >= 0 && from->peak_force < 1e4f) ||
        !(from->peak_torque >= 0 && from->peak_torque < 1e4f))
        return VXS_PROTOCOL;
    if (from->actuated > 0 && !(from->peak_force > 0)) return VXS_PROTOCOL;
    snprintf(caps->name, sizeof caps->name, "hvlink %s", from->name);
    caps->dof_sensed = from->sensed == 7 ? 63 : (1u << from->sensed) - 1;
    caps->dof_actuated = (1u << from->actuated) - 1;
    caps->peak_force = (double)from->peak_force;
    caps->peak_torque = (double)from->peak_torque;
    caps->resolution = (double)from->resolution;
    caps->rate_hz = from->rate_hz;
    caps->has_watchdog = 1;
    return VXS_OK;
}

static vxs_result begin(vxsi_link *link)
{
    vxs_hvlink_frame frame;
    uint8_t bytes[VXSI_WIRE_MOST];
    vxs_result result = VXS_TIMEOUT;
    for (int n = 0; n < HELLOS && result == VXS_TIMEOUT; n++) {
        vxs_hvlink_pack_hello(&frame);
        result = vxsi_link_ask(link, bytes, seal(link, &frame, bytes), is_caps, 100000000);
        if (result == VXS_BUSY) result = VXS_TIMEOUT;
    }
    return result == VXS_OK ? fill_caps(link) : result;
}

static void show(const hvlink_host *host, const vxs_hvlink_state *said, vxs_device_state *state)
{
    for (uint32_t n = 0; n < 3 && n < said->count; n++) {
        state->pose.position[n] = (double)said->value[n];
        if (said->has_velocity) state->velocity[n] = (double)said->velocity[n];
    }
    for (uint32_t n = 3; n < 7 && host->caps.sensed == 7; n++)
        state->pose.orientation[n - 3] = (double)said->value[n];
    state->velocity_source = said->has_velocity ? VXS_DEVICE_VELOCITY_MEASURED : VXS_DEVICE_VELOCITY_NONE;
    state->buttons = said->buttons;
}

/* A device that was armed and is no more let go by itself: a new start, its dead man's switch. It is not
 * armed again for that. */
static void judge(hvlink_host *host, const vxs_hvlink_state *said, vxs_device_state *state)
{
    static const uint32_t states[4] = {VXS_DEVICE_UNCALIBRATED, VXS_DEVICE_READY, VXS_DEVICE_ARMED,
                                       VXS_DEVICE_FAULT};
    state->state = states[said->state];
    state->fault =
        said->state == VXS_HVLINK_FAULTED
            ? (said->fault > 0 && said->fault <= VXS_DEVICE_FAULT_OVERRUN ? said->fault
                                                                          : VXS_DEVICE_FAULT_PROTOCOL)
            : VXS_DEVICE_FAULT_NONE;
    host->said = said->state;
    if (host->arming == 0) {
        if (said->state == VXS_HVLINK_FAULTED) state->state = VXS_DEVICE_READY; /* a DISARM is on its way */
        return;
    }
    if (said->state == VXS_HVLINK_ARMED) {
        host->was_armed = 1;
    } else if (!host->was_armed && host->arms <= MOST_ARMS) {
        state->state = VXS_DEVICE_READY; /* it will hear of it */
    } else if (said->state != VXS_HVLINK_FAULTED) {
        state->state = VXS_DEVICE_FAULT;
        state->fault = VXS_DEVICE_FAULT_DEADMAN;
    }
}

static uint32_t take(vxsi_link *link, const uint8_t *bytes, size_t size, vxs_device_state *state)
{
    hvlink_host *host = host_of(link);
    uint32_t found = 0, dropped = host->stream.dropped;
    vxs_hvlink_frame frame;
    vxs_hvlink_state said;
    for (size_t n = 0; n < size; n++) {
        vxs_hvlink_put(&host->stream, bytes[n]);
        while (vxs_hvlink_take(&host->stream, &frame)) {
            int is_state = vxs_hvlink_unpack_state(&frame, &said);
            if (frame.type == VXS_HVLINK_STATE && (!is_state || said.count != host->caps.sensed))
                found |= VXSI_LINK_MALFORMED;
            if (!is_state || said.count != host->caps.sensed) continue;
            /* Late and doubled ones are not news; far behind is a device that began anew. */
            int16_t ahead = (int16_t)(uint16_t)(frame.sequence - host->last_sequence);
            if (host->has_state && ahead <= 0 && ahead > -LATE) continue;
            host->has_state = 1;
            host->last_sequence = frame.sequence;
            show(host, &said, state);
            judge(host, &said, state);
            found |= VXSI_LINK_NEWS;
        }
    }
    return host->stream.dropped != dropped ? found | VXSI_LINK_MALFORMED : found;
}

static size_t make(vxsi_link *link, const vxs_wrench *wrench, uint32_t arming, uint8_t *bytes)
{
    hvlink_host *host = host_of(link);
    vxs_hvlink_frame frame;
    if (arming != host->arming) {
        host->arming = arming;
        host->was_armed = host->arms = 0;
    }
    if (arming == 0) {
        if (host->said != VXS_HVLINK_ARMED && host->said != VXS_HVLINK_FAULTED) return 0;
        frame.type = VXS_HVLINK_DISARM;
        frame.size = 0;
    } else if (!host->was_armed) {
        host->arms++;
        if (host->said == VXS_HVLINK_FAULTED) { /* of before: whoever arms wants that over */
            frame.type = VXS_HVLINK_DISARM;
            frame.size = 0;
        } else {
            vxs_hvlink_pack_arm(host->caps.session, &frame);
        }
    } else {
        vxs_hvlink_command command = {.ttl_ms = host->caps.ttl_ms < 10 ? host->caps.ttl_ms : 10,
                                      .count = host->caps.actuated};
        for (uint32_t n = 0; n < command.count; n++)
            command.value[n] = (float)(n < 3 ? wrench->force[n] : wrench->torque[n - 3]);
        vxs_hvlink_pack_command(&command, &frame);
    }
    return seal(link, &frame, bytes);
}

const vxsi_driver vxsi_hvlink_driver = {.name = "hvlink", .begin = begin, .take = take, .make = make};
