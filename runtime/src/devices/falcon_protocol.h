/* SPDX-License-Identifier: MIT
 *
 * falcon_protocol.h - private: the Novint Falcon's bytes. Pure: no I/O, any bytes in are safe.
 *
 * Both ways a packet is '<', 14 characters, '>'; three signed 16-bit numbers at 1, 5 and 9, four characters
 * each, 'A' + nibble, lowest nibble first. Facts: libnifalcon f7c727aa (BSD). Not verified on hardware.
 */
#ifndef VXSI_FALCON_PROTOCOL_H
#define VXSI_FALCON_PROTOCOL_H

#include <stddef.h>
#include <stdint.h>

enum { VXSI_FALCON_PACKET = 16, VXSI_FTDI_STATUS = 2, VXSI_FTDI_PACKET = 64 };

/* Lamp and homing, as the device takes them. */
enum { VXSI_FALCON_HOMING = 1, VXSI_FALCON_GREEN = 2, VXSI_FALCON_BLUE = 4, VXSI_FALCON_RED = 8 };

/* Host to device. */
typedef struct vxsi_falcon_output {
    int16_t motor[3];
    uint8_t lamps; /* VXSI_FALCON_HOMING | ... */
} vxsi_falcon_output;

/* Device to host. */
typedef struct vxsi_falcon_input {
    int16_t encoder[3];
    uint8_t buttons; /* plus 1, forward 2, centre 4, minus 8 */
    uint8_t homed;   /* a bit an encoder: 7 when all are */
} vxsi_falcon_input;

void vxsi_falcon_encode_output(const vxsi_falcon_output *output, uint8_t bytes[VXSI_FALCON_PACKET]);
void vxsi_falcon_encode_input(const vxsi_falcon_input *input, uint8_t bytes[VXSI_FALCON_PACKET]);

/* Return 1; 0 for bytes that are no packet (nothing is written). */
int vxsi_falcon_decode_output(const uint8_t bytes[VXSI_FALCON_PACKET], vxsi_falcon_output *output);
int vxsi_falcon_decode_input(const uint8_t bytes[VXSI_FALCON_PACKET], vxsi_falcon_input *input);

/* Packets out of a stream of bytes, which may begin and break anywhere. */
typedef struct vxsi_falcon_stream {
    uint8_t bytes[VXSI_FALCON_PACKET];
    uint32_t count;
} vxsi_falcon_stream;

/* 1: bytes hold a whole frame, to decode; 0: more is needed; -1: something that was no frame is dropped. */
int vxsi_falcon_take(vxsi_falcon_stream *stream, uint8_t byte);

/* The FTDI chip begins each USB packet with two bytes of modem status: closes the gaps, in place, of a
 * transfer of packets of 64 bytes. Returns how many bytes are left. */
size_t vxsi_ftdi_strip(uint8_t *bytes, size_t size);

#endif
