/* SPDX-License-Identifier: MIT
 *
 * haply_protocol.h - private: the bytes of hAPI boards (Haply 2diy). Pure: no I/O, any bytes in are safe.
 *
 * No length, no checksum, no sequence number on the wire: a frame is known by its size alone, and the only
 * ways back into step are a pause or a reset. Facts: Haply-API-cpp c336a063. Not verified on hardware.
 */
#ifndef VXSI_HAPLY_PROTOCOL_H
#define VXSI_HAPLY_PROTOCOL_H

#include <stddef.h>
#include <stdint.h>

enum { VXSI_HAPLY_PORTS = 4, VXSI_HAPLY_FRAME = 64 };
enum { VXSI_HAPLY_CLOCKWISE = 0, VXSI_HAPLY_COUNTER = 1 };

/* What hangs on the ports 1 .. 4, lowest port first. */
typedef struct vxsi_haply_setup {
    uint8_t device;                       /* id that the host chooses */
    uint8_t motor_ports, encoder_ports;   /* a bit a port, bit 0: port 1 */
    uint8_t motor_turn[VXSI_HAPLY_PORTS]; /* VXSI_HAPLY_..., in the order of the ports that are used */
    uint8_t encoder_turn[VXSI_HAPLY_PORTS];
    float offset[VXSI_HAPLY_PORTS]; /* [degree] at the start */
    float counts[VXSI_HAPLY_PORTS]; /* a turn */
} vxsi_haply_setup;

/* How many ports of a mask are used. */
uint32_t vxsi_haply_ports(uint8_t mask);

/* Bytes written, at most VXSI_HAPLY_FRAME. */
size_t vxsi_haply_encode_reset(uint8_t device, uint8_t *bytes);
size_t vxsi_haply_encode_setup(const vxsi_haply_setup *setup, uint8_t *bytes);
/* torque: one a motor port that is used. The board answers with a state. */
size_t vxsi_haply_encode_torque(const vxsi_haply_setup *setup, const float *torque, uint8_t *bytes);
size_t vxsi_haply_encode_state(const vxsi_haply_setup *setup, const float *degrees, uint8_t *bytes);

/* Size of a state frame. */
size_t vxsi_haply_state_size(const vxsi_haply_setup *setup);

/* Angles [degree], one an encoder port that is used. Returns 1; 0 for a frame of another size or device
 * (nothing is written). What a board sends need not be finite. */
int vxsi_haply_decode_state(const vxsi_haply_setup *setup, const uint8_t *bytes, size_t size, float *degrees);

/* The board's end, for emulation: the frame's kind (0 reset, 1 setup, 2 torque), -1 for none. */
int vxsi_haply_decode(const uint8_t *bytes, size_t size, const vxsi_haply_setup *known,
                      vxsi_haply_setup *setup, float torque[VXSI_HAPLY_PORTS]);

#endif
