/* SPDX-License-Identifier: MIT
 *
 * Any bytes as an hvlink stream, to the host and to the device: what is taken encodes to the same bytes, what
 * unpacks packs to the same payload, and a device's motors get numbers that are finite, of a command that was
 * sealed.
 */
#include "fuzz_target.h"
#include "voxshell/hvlink.h"

#include <math.h>
#include <string.h>

static void check_frame(const vxs_hvlink_frame *frame)
{
    vxs_hvlink_state state;
    vxs_hvlink_command command;
    vxs_hvlink_caps caps, caps_again;
    vxs_hvlink_frame again = *frame;
    uint8_t bytes[VXS_HVLINK_MAX_FRAME];
    FUZZ_CHECK(frame->size <= VXS_HVLINK_MAX_PAYLOAD);
    FUZZ_CHECK(vxs_hvlink_encode(frame, bytes, sizeof bytes) == (size_t)frame->size + VXS_HVLINK_OVERHEAD);
    if (vxs_hvlink_unpack_state(frame, &state)) vxs_hvlink_pack_state(&state, &again);
    if (vxs_hvlink_unpack_command(frame, &command)) vxs_hvlink_pack_command(&command, &again);
    FUZZ_CHECK(again.size == frame->size && memcmp(again.payload, frame->payload, frame->size) == 0);
    if (vxs_hvlink_unpack_caps(frame, &caps)) {
        FUZZ_CHECK(memchr(caps.name, 0, sizeof caps.name) && memchr(caps.serial, 0, sizeof caps.serial));
        vxs_hvlink_pack_caps(&caps, &again);
        FUZZ_CHECK(vxs_hvlink_unpack_caps(&again, &caps_again) && strcmp(caps.name, caps_again.name) == 0);
    }
}

/* Input: a byte of what to do, then bytes. With bit 7 the rest is sealed as a frame's payload, so that the
 * checksum is no wall. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static const vxs_hvlink_caps caps = {
        .session = 7, .sensed = 3, .actuated = 3, .rate_hz = 1000, .ttl_ms = 10};
    uint8_t sealed[VXS_HVLINK_MAX_FRAME], reply[VXS_HVLINK_MAX_FRAME];
    vxs_hvlink_frame frame;
    if (size > 2 && bytes[0] & 0x80 && size - 2 <= VXS_HVLINK_MAX_PAYLOAD) {
        frame = (vxs_hvlink_frame){.type = bytes[1], .size = (uint8_t)(size - 2), .sequence = 1};
        memcpy(frame.payload, bytes + 2, size - 2);
        size = vxs_hvlink_encode(&frame, sealed, sizeof sealed);
        bytes = sealed;
    }
    vxs_hvlink_stream stream = {.count = 0};
    vxs_hvlink_device device;
    vxs_hvlink_device_init(&device, &caps);
    vxs_hvlink_pack_arm(7, &frame);
    frame.sequence = 0;
    uint8_t arm[VXS_HVLINK_MAX_FRAME];
    size_t arm_size = vxs_hvlink_encode(&frame, arm, sizeof arm);
    for (size_t n = 0; n < arm_size; n++) vxs_hvlink_device_receive(&device, arm[n], 0, reply);
    FUZZ_CHECK(device.state == VXS_HVLINK_ARMED);
    uint32_t taken = 0;
    for (size_t n = 0; n < size; n++) {
        vxs_hvlink_put(&stream, bytes[n]);
        while (vxs_hvlink_take(&stream, &frame)) {
            taken += (uint32_t)frame.size + VXS_HVLINK_OVERHEAD;
            check_frame(&frame);
        }
        FUZZ_CHECK(vxs_hvlink_device_receive(&device, bytes[n], (uint32_t)n, reply) <= sizeof reply);
        float value[VXS_HVLINK_VALUES];
        vxs_hvlink_device_output(&device, (uint32_t)n, value);
        for (int i = 0; i < 3; i++) FUZZ_CHECK(isfinite(value[i]));
    }
    FUZZ_CHECK(taken + stream.dropped + stream.count == size);
    return 0;
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    vxs_hvlink_frame frame = {.sequence = (uint16_t)number};
    const vxs_hvlink_state state = {
        .state = 2, .count = (uint8_t)(1 + number % 8), .has_velocity = number >> 3 & 1, .value = {0.5f}};
    const vxs_hvlink_command command = {
        .ttl_ms = (uint16_t)(number + 1), .count = 3, .value = {1, 2, (float)number}};
    const vxs_hvlink_caps caps = {1, 0, 7, 0, 3, 3, 0, 1000, 10, 1, 2, 3, "knob", "7"};
    switch (number % 6) {
    case 0:
        vxs_hvlink_pack_state(&state, &frame);
        break;
    case 1:
        vxs_hvlink_pack_command(&command, &frame);
        break;
    case 2:
        vxs_hvlink_pack_caps(&caps, &frame);
        break;
    case 3:
        vxs_hvlink_pack_hello(&frame);
        break;
    case 4:
        vxs_hvlink_pack_arm(7, &frame);
        break;
    default:
        frame.type = VXS_HVLINK_DISARM;
        frame.size = 0;
    }
    if (number & 32) { /* to be sealed after it was changed */
        if (most < (size_t)frame.size + 2) return 0;
        bytes[0] = 0x80;
        bytes[1] = frame.type;
        memcpy(bytes + 2, frame.payload, frame.size);
        return (size_t)frame.size + 2;
    }
    return vxs_hvlink_encode(&frame, bytes, most);
}
