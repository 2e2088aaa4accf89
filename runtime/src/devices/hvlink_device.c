/* SPDX-License-Identifier: MIT
 *
 * hvlink's device end: what a microcontroller runs. No libc.
 */
#include "voxshell/hvlink.h"

enum { SILENCE_US = 100000, FAULT_SOFTWARE = 4, FAULT_WATCHDOG = 3, LARGEST = 0x7F800000 };

/* The exponent of a number that is not finite is all ones. */
static int is_finite(float value)
{
    union {
        float value;
        uint32_t bits;
    } both = {.value = value};
    return (both.bits & LARGEST) != LARGEST;
}

void vxs_hvlink_device_init(vxs_hvlink_device *device, const vxs_hvlink_caps *caps)
{
    *device = (vxs_hvlink_device){.caps = *caps, .state = VXS_HVLINK_READY};
    device->caps.major = VXS_HVLINK_MAJOR;
    device->caps.minor = VXS_HVLINK_MINOR;
}

void vxs_hvlink_device_fail(vxs_hvlink_device *device, uint8_t fault)
{
    device->state = VXS_HVLINK_FAULTED;
    device->fault = fault;
    device->has_command = 0;
}

static size_t send(vxs_hvlink_device *device, vxs_hvlink_frame *frame, uint32_t now_us, uint8_t *bytes)
{
    frame->sequence = device->sequence++;
    frame->time_us = now_us;
    return vxs_hvlink_encode(frame, bytes, VXS_HVLINK_MAX_FRAME);
}

/* Only the present session arms, and from READY only: DISARM comes first after a fault. */
static void arm(vxs_hvlink_device *device, const vxs_hvlink_frame *frame, uint32_t now_us)
{
    uint32_t session;
    if (!vxs_hvlink_unpack_arm(frame, &session) || session != device->caps.session ||
        device->state != VXS_HVLINK_READY)
        return;
    device->state = VXS_HVLINK_ARMED;
    device->has_command = 0;
    device->command_us = now_us;
}

static void disarm(vxs_hvlink_device *device)
{
    if (device->state == VXS_HVLINK_UNCALIBRATED) return;
    device->state = VXS_HVLINK_READY;
    device->fault = 0;
    device->has_command = 0;
}

static void obey(vxs_hvlink_device *device, const vxs_hvlink_frame *frame, uint32_t now_us)
{
    vxs_hvlink_command command;
    if (device->state != VXS_HVLINK_ARMED || !vxs_hvlink_unpack_command(frame, &command) ||
        command.count != device->caps.actuated)
        return;
    for (uint32_t n = 0; n < command.count; n++) {
        if (!is_finite(command.value[n])) {
            vxs_hvlink_device_fail(device, FAULT_SOFTWARE);
            return;
        }
    }
    /* Late and doubled frames come with a number that is not ahead. */
    if (device->has_command && (int16_t)(uint16_t)(frame->sequence - device->command_sequence) <= 0) return;
    if (command.ttl_ms > device->caps.ttl_ms) command.ttl_ms = device->caps.ttl_ms;
    device->command = command;
    device->command_sequence = frame->sequence;
    device->command_us = now_us;
    device->has_command = 1;
}

size_t vxs_hvlink_device_receive(vxs_hvlink_device *device, uint8_t byte, uint32_t now_us, uint8_t *reply)
{
    vxs_hvlink_frame frame;
    size_t size = 0;
    vxs_hvlink_put(&device->stream, byte);
    while (vxs_hvlink_take(&device->stream, &frame)) {
        switch (frame.type) {
        case VXS_HVLINK_HELLO:
            vxs_hvlink_pack_caps(&device->caps, &frame);
            size = send(device, &frame, now_us, reply);
            break;
        case VXS_HVLINK_PING:
            frame.type = VXS_HVLINK_PONG;
            size = send(device, &frame, now_us, reply);
            break;
        case VXS_HVLINK_ARM:
            arm(device, &frame, now_us);
            break;
        case VXS_HVLINK_DISARM:
            disarm(device);
            break;
        case VXS_HVLINK_CMD:
            obey(device, &frame, now_us);
            break;
        default:
            break;
        }
    }
    return size;
}

void vxs_hvlink_device_output(vxs_hvlink_device *device, uint32_t now_us, float *value)
{
    uint32_t age = now_us - device->command_us;
    if (device->state == VXS_HVLINK_ARMED && age > SILENCE_US) vxs_hvlink_device_fail(device, FAULT_WATCHDOG);
    int is_on =
        device->state == VXS_HVLINK_ARMED && device->has_command && age < 1000u * device->command.ttl_ms;
    for (uint32_t n = 0; n < device->caps.actuated && n < VXS_HVLINK_VALUES; n++)
        value[n] = is_on ? device->command.value[n] : 0;
}

size_t vxs_hvlink_device_state(vxs_hvlink_device *device, const float *value, const float *velocity,
                               uint32_t buttons, uint32_t now_us, uint8_t *bytes)
{
    uint32_t age_ms = (now_us - device->command_us) / 1000;
    vxs_hvlink_state state = {.state = device->state,
                              .fault = device->fault,
                              .count = device->caps.sensed,
                              .has_velocity = velocity != NULL,
                              .buttons = buttons,
                              .command_sequence = device->command_sequence,
                              .command_age_ms = (uint16_t)(age_ms < 65535 ? age_ms : 65535)};
    for (uint32_t n = 0; n < state.count && n < VXS_HVLINK_VALUES; n++) {
        state.value[n] = value[n];
        state.velocity[n] = velocity ? velocity[n] : 0;
    }
    vxs_hvlink_frame frame;
    vxs_hvlink_pack_state(&state, &frame);
    return send(device, &frame, now_us, bytes);
}
