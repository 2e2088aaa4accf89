/* SPDX-License-Identifier: MIT
 *
 * hvlink's frames and payloads: formats/hvlink.md. No libc.
 */
#include "voxshell/hvlink.h"

enum { SYNC_0 = 0xA5, SYNC_1 = 0x5A, HEAD = 10, TAIL = 4 };
enum { TAG_NAME = 1, TAG_SERIAL = 2 };
enum { CAPS_FIXED = 28, STATE_FIXED = 12, COMMAND_FIXED = 4 };

static void put16(uint8_t *at, uint32_t value)
{
    at[0] = (uint8_t)value;
    at[1] = (uint8_t)(value >> 8);
}

static void put32(uint8_t *at, uint32_t value)
{
    put16(at, value);
    put16(at + 2, value >> 16);
}

static uint16_t get16(const uint8_t *at)
{
    return (uint16_t)(at[0] | at[1] << 8);
}

static uint32_t get32(const uint8_t *at)
{
    return get16(at) | (uint32_t)get16(at + 2) << 16;
}

static void put_float(uint8_t *at, float value)
{
    union {
        float value;
        uint32_t bits;
    } both = {.value = value};
    put32(at, both.bits);
}

static float get_float(const uint8_t *at)
{
    union {
        uint32_t bits;
        float value;
    } both = {.bits = get32(at)};
    return both.value;
}

/* Half a byte a step: a table of 64 bytes is little enough for any microcontroller. */
uint32_t vxs_hvlink_crc(const uint8_t *bytes, size_t size)
{
    static const uint32_t table[16] = {0x00000000u, 0x105EC76Fu, 0x20BD8EDEu, 0x30E349B1u,
                                       0x417B1DBCu, 0x5125DAD3u, 0x61C69362u, 0x7198540Du,
                                       0x82F63B78u, 0x92A8FC17u, 0xA24BB5A6u, 0xB21572C9u,
                                       0xC38D26C4u, 0xD3D3E1ABu, 0xE330A81Au, 0xF36E6F75u};
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t n = 0; n < size; n++) {
        crc ^= bytes[n];
        crc = crc >> 4 ^ table[crc & 15];
        crc = crc >> 4 ^ table[crc & 15];
    }
    return ~crc;
}

size_t vxs_hvlink_encode(const vxs_hvlink_frame *frame, uint8_t *bytes, size_t most)
{
    size_t size = frame->size;
    if (size > VXS_HVLINK_MAX_PAYLOAD || most < HEAD + size + TAIL) return 0;
    bytes[0] = SYNC_0;
    bytes[1] = SYNC_1;
    bytes[2] = frame->size;
    bytes[3] = frame->type;
    put16(bytes + 4, frame->sequence);
    put32(bytes + 6, frame->time_us);
    for (size_t n = 0; n < size; n++) bytes[HEAD + n] = frame->payload[n];
    put32(bytes + HEAD + size, vxs_hvlink_crc(bytes + 2, HEAD - 2 + size));
    return HEAD + size + TAIL;
}

/* Nothing to drop is the rule, at each byte that arrives. */
static void drop(vxs_hvlink_stream *stream, uint32_t count)
{
    if (count == 0) return;
    stream->count = (uint16_t)(stream->count - count);
    for (uint32_t n = 0; n < stream->count; n++) stream->bytes[n] = stream->bytes[n + count];
}

/* Drops what cannot begin a frame. Returns the size of the frame that bytes begin with, 0 while it is not
 * known. */
static uint32_t synchronise(vxs_hvlink_stream *stream)
{
    const uint8_t *bytes = stream->bytes;
    uint32_t junk = 0;
    for (; junk < stream->count; junk++) {
        uint32_t left = stream->count - junk;
        if (bytes[junk] == SYNC_0 && (left < 2 || bytes[junk + 1] == SYNC_1) &&
            (left < 3 || bytes[junk + 2] <= VXS_HVLINK_MAX_PAYLOAD))
            break;
    }
    stream->dropped += junk;
    drop(stream, junk);
    return stream->count < 3 ? 0 : HEAD + TAIL + (uint32_t)bytes[2];
}

/* A stream that nobody takes frames from: the newest bytes stay. */
void vxs_hvlink_put(vxs_hvlink_stream *stream, uint8_t byte)
{
    if (stream->count >= VXS_HVLINK_MAX_FRAME) {
        stream->dropped++;
        stream->count = VXS_HVLINK_MAX_FRAME;
        drop(stream, 1);
    }
    stream->bytes[stream->count++] = byte;
}

int vxs_hvlink_take(vxs_hvlink_stream *stream, vxs_hvlink_frame *frame)
{
    for (;;) {
        uint32_t size = synchronise(stream);
        if (size == 0 || stream->count < size) return 0;
        const uint8_t *bytes = stream->bytes;
        if (get32(bytes + size - TAIL) != vxs_hvlink_crc(bytes + 2, size - TAIL - 2)) {
            stream->dropped++;
            drop(stream, 1);
            continue;
        }
        frame->size = bytes[2];
        frame->type = bytes[3];
        frame->sequence = get16(bytes + 4);
        frame->time_us = get32(bytes + 6);
        for (uint32_t n = 0; n < frame->size; n++) frame->payload[n] = bytes[HEAD + n];
        drop(stream, size);
        return 1;
    }
}

static void begin(vxs_hvlink_frame *frame, uint8_t type, uint32_t size)
{
    frame->type = type;
    frame->size = (uint8_t)size;
}

void vxs_hvlink_pack_hello(vxs_hvlink_frame *frame)
{
    begin(frame, VXS_HVLINK_HELLO, 4);
    put16(frame->payload, VXS_HVLINK_MAJOR);
    put16(frame->payload + 2, VXS_HVLINK_MINOR);
}

void vxs_hvlink_pack_arm(uint32_t session, vxs_hvlink_frame *frame)
{
    begin(frame, VXS_HVLINK_ARM, 4);
    put32(frame->payload, session);
}

int vxs_hvlink_unpack_arm(const vxs_hvlink_frame *frame, uint32_t *session)
{
    if (frame->type != VXS_HVLINK_ARM || frame->size != 4) return 0;
    *session = get32(frame->payload);
    return 1;
}

void vxs_hvlink_pack_fault(uint8_t fault, vxs_hvlink_frame *frame)
{
    begin(frame, VXS_HVLINK_FAULT, 1);
    frame->payload[0] = fault;
}

int vxs_hvlink_unpack_fault(const vxs_hvlink_frame *frame, uint8_t *fault)
{
    if (frame->type != VXS_HVLINK_FAULT || frame->size != 1) return 0;
    *fault = frame->payload[0];
    return 1;
}

static uint8_t *put_text(uint8_t *at, uint8_t tag, const char *text)
{
    uint8_t length = 0;
    while (length < VXS_HVLINK_TEXT - 1 && text[length]) length++;
    if (length == 0) return at;
    *at++ = tag;
    *at++ = length;
    for (uint8_t n = 0; n < length; n++) *at++ = (uint8_t)text[n];
    return at;
}

void vxs_hvlink_pack_caps(const vxs_hvlink_caps *caps, vxs_hvlink_frame *frame)
{
    uint8_t *at = frame->payload;
    put16(at, caps->major);
    put16(at + 2, caps->minor);
    put32(at + 4, caps->session);
    at[8] = caps->space;
    at[9] = caps->sensed;
    at[10] = caps->actuated;
    at[11] = 0;
    put16(at + 12, caps->rate_hz);
    put16(at + 14, caps->ttl_ms);
    put_float(at + 16, caps->peak_force);
    put_float(at + 20, caps->peak_torque);
    put_float(at + 24, caps->resolution);
    at = put_text(at + CAPS_FIXED, TAG_NAME, caps->name);
    at = put_text(at, TAG_SERIAL, caps->serial);
    begin(frame, VXS_HVLINK_CAPS, (uint32_t)(at - frame->payload));
}

static int get_text(const uint8_t *at, uint32_t length, char text[VXS_HVLINK_TEXT])
{
    if (length >= VXS_HVLINK_TEXT) return 0;
    for (uint32_t n = 0; n < VXS_HVLINK_TEXT - 1; n++) {
        char letter = n < length ? (char)at[n] : 0;
        text[n] = n >= length || (letter >= ' ' && letter <= '~') ? letter : '?';
    }
    text[VXS_HVLINK_TEXT - 1] = 0;
    return 1;
}

int vxs_hvlink_unpack_caps(const vxs_hvlink_frame *frame, vxs_hvlink_caps *caps)
{
    const uint8_t *at = frame->payload;
    if (frame->type != VXS_HVLINK_CAPS || frame->size < CAPS_FIXED || frame->size > VXS_HVLINK_MAX_PAYLOAD)
        return 0;
    vxs_hvlink_caps out = {.major = get16(at),
                           .minor = get16(at + 2),
                           .session = get32(at + 4),
                           .space = at[8],
                           .sensed = at[9],
                           .actuated = at[10],
                           .rate_hz = get16(at + 12),
                           .ttl_ms = get16(at + 14),
                           .peak_force = get_float(at + 16),
                           .peak_torque = get_float(at + 20),
                           .resolution = get_float(at + 24)};
    if (out.space > VXS_HVLINK_JOINTS || out.sensed < 1 || out.sensed > VXS_HVLINK_VALUES ||
        out.actuated > VXS_HVLINK_VALUES || at[11] != 0 || out.rate_hz == 0 || out.ttl_ms == 0)
        return 0;
    for (uint32_t n = CAPS_FIXED; n < frame->size;) {
        if (n + 2 > frame->size || n + 2u + at[n + 1] > frame->size) return 0;
        char *text = at[n] == TAG_NAME ? out.name : at[n] == TAG_SERIAL ? out.serial : NULL;
        if (text && !get_text(at + n + 2, at[n + 1], text)) return 0;
        n += 2u + at[n + 1];
    }
    *caps = out;
    return 1;
}

static uint32_t count_of(uint8_t count)
{
    return count > VXS_HVLINK_VALUES ? VXS_HVLINK_VALUES : count;
}

void vxs_hvlink_pack_state(const vxs_hvlink_state *state, vxs_hvlink_frame *frame)
{
    uint8_t *at = frame->payload;
    uint32_t count = count_of(state->count);
    at[0] = state->state;
    at[1] = state->fault;
    at[2] = (uint8_t)count;
    at[3] = state->has_velocity ? 1 : 0;
    put32(at + 4, state->buttons);
    put16(at + 8, state->command_sequence);
    put16(at + 10, state->command_age_ms);
    at += STATE_FIXED;
    for (uint32_t n = 0; n < count; n++, at += 4) put_float(at, state->value[n]);
    for (uint32_t n = 0; n < count && state->has_velocity; n++, at += 4) put_float(at, state->velocity[n]);
    begin(frame, VXS_HVLINK_STATE, (uint32_t)(at - frame->payload));
}

int vxs_hvlink_unpack_state(const vxs_hvlink_frame *frame, vxs_hvlink_state *state)
{
    const uint8_t *at = frame->payload;
    if (frame->type != VXS_HVLINK_STATE || frame->size < STATE_FIXED) return 0;
    vxs_hvlink_state out = {.state = at[0],
                            .fault = at[1],
                            .count = at[2],
                            .has_velocity = at[3],
                            .buttons = get32(at + 4),
                            .command_sequence = get16(at + 8),
                            .command_age_ms = get16(at + 10)};
    if (out.state > VXS_HVLINK_FAULTED || out.count < 1 || out.count > VXS_HVLINK_VALUES ||
        out.has_velocity > 1 || frame->size != STATE_FIXED + 4u * out.count * (1u + out.has_velocity))
        return 0;
    at += STATE_FIXED;
    for (uint32_t n = 0; n < out.count; n++, at += 4) out.value[n] = get_float(at);
    for (uint32_t n = 0; n < out.count && out.has_velocity; n++, at += 4) out.velocity[n] = get_float(at);
    *state = out;
    return 1;
}

void vxs_hvlink_pack_command(const vxs_hvlink_command *command, vxs_hvlink_frame *frame)
{
    uint8_t *at = frame->payload;
    uint32_t count = count_of(command->count);
    put16(at, command->ttl_ms);
    at[2] = (uint8_t)count;
    at[3] = 0;
    at += COMMAND_FIXED;
    for (uint32_t n = 0; n < count; n++, at += 4) put_float(at, command->value[n]);
    begin(frame, VXS_HVLINK_CMD, (uint32_t)(at - frame->payload));
}

int vxs_hvlink_unpack_command(const vxs_hvlink_frame *frame, vxs_hvlink_command *command)
{
    const uint8_t *at = frame->payload;
    if (frame->type != VXS_HVLINK_CMD || frame->size < COMMAND_FIXED) return 0;
    vxs_hvlink_command out = {.ttl_ms = get16(at), .count = at[2]};
    if (out.ttl_ms == 0 || out.count > VXS_HVLINK_VALUES || at[3] != 0 ||
        frame->size != COMMAND_FIXED + 4u * out.count)
        return 0;
    for (uint32_t n = 0; n < out.count; n++) out.value[n] = get_float(at + COMMAND_FIXED + 4 * n);
    *command = out;
    return 1;
}
