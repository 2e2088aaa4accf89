/* SPDX-License-Identifier: MIT */
#include "falcon_protocol.h"

#include <string.h>

enum { FIRST = '<', LAST = '>', ZERO = 'A', NUMBERS_END = 13 };

static void put(int16_t value, uint8_t *bytes)
{
    for (int n = 0; n < 4; n++) bytes[n] = (uint8_t)(ZERO + ((uint16_t)value >> 4 * n & 15));
}

/* A byte is a nibble only below 'A' + 16; the lamps' and buttons' byte is checked by its reader. */
static int get(const uint8_t *bytes, int16_t *value)
{
    uint32_t bits = 0;
    for (int n = 0; n < 4; n++) {
        uint32_t nibble = (uint32_t)bytes[n] - ZERO;
        if (nibble > 15) return 0;
        bits |= nibble << 4 * n;
    }
    *value = (int16_t)(bits >= 0x8000u ? (int32_t)bits - 0x10000 : (int32_t)bits);
    return 1;
}

static void encode(const int16_t numbers[3], uint32_t extra, uint8_t bytes[VXSI_FALCON_PACKET])
{
    bytes[0] = FIRST;
    for (int n = 0; n < 3; n++) put(numbers[n], bytes + 1 + 4 * n);
    bytes[13] = (uint8_t)(ZERO + extra);
    bytes[14] = ZERO;
    bytes[15] = LAST;
}

static int decode(const uint8_t bytes[VXSI_FALCON_PACKET], int16_t numbers[3], uint32_t *extra, uint32_t most)
{
    if (bytes[0] != FIRST || bytes[15] != LAST) return 0;
    for (int n = 0; n < 3; n++)
        if (!get(bytes + 1 + 4 * n, &numbers[n])) return 0;
    *extra = (uint32_t)bytes[NUMBERS_END] - ZERO;
    return *extra <= most;
}

void vxsi_falcon_encode_output(const vxsi_falcon_output *output, uint8_t bytes[VXSI_FALCON_PACKET])
{
    encode(output->motor, output->lamps & 15u, bytes);
}

void vxsi_falcon_encode_input(const vxsi_falcon_input *input, uint8_t bytes[VXSI_FALCON_PACKET])
{
    encode(input->encoder, (input->buttons & 15u) | (input->homed & 7u) << 4, bytes);
}

int vxsi_falcon_decode_output(const uint8_t bytes[VXSI_FALCON_PACKET], vxsi_falcon_output *output)
{
    vxsi_falcon_output out;
    uint32_t extra;
    if (!decode(bytes, out.motor, &extra, 15)) return 0;
    out.lamps = (uint8_t)extra;
    *output = out;
    return 1;
}

int vxsi_falcon_decode_input(const uint8_t bytes[VXSI_FALCON_PACKET], vxsi_falcon_input *input)
{
    vxsi_falcon_input in;
    uint32_t extra;
    if (!decode(bytes, in.encoder, &extra, 127)) return 0;
    in.buttons = extra & 15;
    in.homed = (uint8_t)(extra >> 4);
    *input = in;
    return 1;
}

/* No byte within a frame but the first is '<' (0x3C lies below 'A'): one is always a new beginning. */
int vxsi_falcon_take(vxsi_falcon_stream *stream, uint8_t byte)
{
    int dropped = 0;
    if (byte == FIRST) {
        dropped = stream->count > 0;
        stream->count = 0;
    } else if (stream->count == 0) {
        return -1;
    }
    stream->bytes[stream->count++] = byte;
    if (stream->count < VXSI_FALCON_PACKET) return dropped ? -1 : 0;
    stream->count = 0;
    return byte == LAST ? 1 : -1;
}

size_t vxsi_ftdi_strip(uint8_t *bytes, size_t size)
{
    size_t left = 0;
    for (size_t at = 0; at < size; at += VXSI_FTDI_PACKET) {
        size_t count = size - at < VXSI_FTDI_PACKET ? size - at : VXSI_FTDI_PACKET;
        if (count <= VXSI_FTDI_STATUS) continue;
        memmove(bytes + left, bytes + at + VXSI_FTDI_STATUS, count - VXSI_FTDI_STATUS);
        left += count - VXSI_FTDI_STATUS;
    }
    return left;
}
