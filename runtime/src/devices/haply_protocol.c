/* SPDX-License-Identifier: MIT */
#include "haply_protocol.h"

#include <math.h>
#include <string.h>

enum { RESET = 0, SETUP = 1, TORQUE = 2 };

uint32_t vxsi_haply_ports(uint8_t mask)
{
    uint32_t count = 0;
    for (uint32_t bits = mask & 15u; bits; bits >>= 1) count += bits & 1;
    return count;
}

static uint8_t *put(uint8_t *at, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int n = 0; n < 4; n++) *at++ = (uint8_t)(bits >> 8 * n);
    return at;
}

static float get(const uint8_t *at)
{
    uint32_t bits = at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

size_t vxsi_haply_encode_reset(uint8_t device, uint8_t *bytes)
{
    bytes[0] = RESET;
    bytes[1] = device;
    return 2;
}

size_t vxsi_haply_encode_setup(const vxsi_haply_setup *setup, uint8_t *bytes)
{
    uint32_t motors = vxsi_haply_ports(setup->motor_ports), encoders = vxsi_haply_ports(setup->encoder_ports);
    uint8_t *at = bytes;
    *at++ = SETUP;
    *at++ = setup->device;
    *at++ = setup->motor_ports & 15;
    for (uint32_t n = 0; n < motors; n++) *at++ = setup->motor_turn[n];
    *at++ = setup->encoder_ports & 15;
    for (uint32_t n = 0; n < encoders; n++) *at++ = setup->encoder_turn[n];
    *at++ = 0; /* sensors */
    *at++ = 0; /* pulse-width outputs */
    for (uint32_t n = 0; n < encoders; n++) at = put(put(at, setup->offset[n]), setup->counts[n]);
    return (size_t)(at - bytes);
}

size_t vxsi_haply_encode_torque(const vxsi_haply_setup *setup, const float *torque, uint8_t *bytes)
{
    uint8_t *at = bytes;
    *at++ = TORQUE;
    *at++ = setup->device;
    for (uint32_t n = 0; n < vxsi_haply_ports(setup->motor_ports); n++) at = put(at, torque[n]);
    return (size_t)(at - bytes);
}

size_t vxsi_haply_encode_state(const vxsi_haply_setup *setup, const float *degrees, uint8_t *bytes)
{
    uint8_t *at = bytes;
    *at++ = setup->device;
    for (uint32_t n = 0; n < vxsi_haply_ports(setup->encoder_ports); n++) at = put(at, degrees[n]);
    return (size_t)(at - bytes);
}

size_t vxsi_haply_state_size(const vxsi_haply_setup *setup)
{
    return 1 + 4 * (size_t)vxsi_haply_ports(setup->encoder_ports);
}

int vxsi_haply_decode_state(const vxsi_haply_setup *setup, const uint8_t *bytes, size_t size, float *degrees)
{
    if (size != vxsi_haply_state_size(setup) || bytes[0] != setup->device) return 0;
    for (uint32_t n = 0; n < vxsi_haply_ports(setup->encoder_ports); n++) degrees[n] = get(bytes + 1 + 4 * n);
    return 1;
}

static int decode_setup(const uint8_t *bytes, size_t size, vxsi_haply_setup *setup)
{
    vxsi_haply_setup out;
    memset(&out, 0, sizeof out);
    size_t at = 1;
    out.device = bytes[at++];
    uint8_t *masks[2] = {&out.motor_ports, &out.encoder_ports},
            *turns[2] = {out.motor_turn, out.encoder_turn};
    for (int kind = 0; kind < 2; kind++) {
        if (at >= size || bytes[at] > 15) return 0;
        *masks[kind] = bytes[at++];
        for (uint32_t n = 0; n < vxsi_haply_ports(*masks[kind]); n++) {
            if (at >= size || bytes[at] > 1) return 0;
            turns[kind][n] = bytes[at++];
        }
    }
    uint32_t encoders = vxsi_haply_ports(out.encoder_ports);
    if (size != at + 2 + 8 * (size_t)encoders || bytes[at] != 0 || bytes[at + 1] != 0) return 0;
    at += 2;
    for (uint32_t n = 0; n < encoders; n++, at += 8) {
        out.offset[n] = get(bytes + at);
        out.counts[n] = get(bytes + at + 4);
        if (!isfinite(out.offset[n]) || !(out.counts[n] > 0)) return 0;
    }
    *setup = out;
    return 1;
}

int vxsi_haply_decode(const uint8_t *bytes, size_t size, const vxsi_haply_setup *known,
                      vxsi_haply_setup *setup, float torque[VXSI_HAPLY_PORTS])
{
    if (size < 2) return -1;
    if (bytes[0] == RESET) return size == 2 ? RESET : -1;
    if (bytes[0] == SETUP) return decode_setup(bytes, size, setup) ? SETUP : -1;
    uint32_t motors = vxsi_haply_ports(known->motor_ports);
    if (bytes[0] != TORQUE || bytes[1] != known->device || size != 2 + 4 * (size_t)motors) return -1;
    for (uint32_t n = 0; n < motors; n++) torque[n] = get(bytes + 2 + 4 * n);
    return TORQUE;
}
