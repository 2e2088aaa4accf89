/* SPDX-License-Identifier: MIT
 *
 * Any bytes as a Falcon's serial stream behind its FTDI chip: what decodes encodes to the same bytes. Where
 * its counts lead is fuzz_falcon_kinematics's.
 */
#include "devices/falcon_protocol.h"
#include "fuzz_target.h"

#include <string.h>

static void check_packet(const uint8_t bytes[VXSI_FALCON_PACKET])
{
    vxsi_falcon_input input;
    vxsi_falcon_output output;
    uint8_t again[VXSI_FALCON_PACKET];
    if (vxsi_falcon_decode_output(bytes, &output)) {
        vxsi_falcon_encode_output(&output, again);
        FUZZ_CHECK(memcmp(bytes, again, 14) == 0); /* byte 14 means nothing */
    }
    if (!vxsi_falcon_decode_input(bytes, &input)) return;
    vxsi_falcon_encode_input(&input, again);
    FUZZ_CHECK(memcmp(bytes, again, 14) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    uint8_t copy[1024];
    if (size > sizeof copy) return 0;
    memcpy(copy, bytes, size);
    size_t left = vxsi_ftdi_strip(copy, size);
    FUZZ_CHECK(left <= size);
    vxsi_falcon_stream stream = {.count = 0};
    for (size_t n = 0; n < left; n++) {
        if (vxsi_falcon_take(&stream, copy[n]) == 1) check_packet(stream.bytes);
        FUZZ_CHECK(stream.count < VXSI_FALCON_PACKET);
    }
    if (size >= VXSI_FALCON_PACKET) check_packet(bytes);
    return 0;
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    if (most < VXSI_FTDI_STATUS + VXSI_FALCON_PACKET) return 0;
    int16_t shift = (int16_t)(number * 37);
    vxsi_falcon_input input = {
        {shift, (int16_t)-shift, (int16_t)(100 - shift)}, (uint8_t)(number & 15), (uint8_t)(number & 7)};
    bytes[0] = 1;
    bytes[1] = 0x60;
    vxsi_falcon_encode_input(&input, bytes + VXSI_FTDI_STATUS);
    return VXSI_FTDI_STATUS + VXSI_FALCON_PACKET;
}
