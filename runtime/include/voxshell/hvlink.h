/* SPDX-License-Identifier: MIT
 *
 * hvlink.h - the open wire protocol for devices that people build: both ends, for host and microcontroller.
 *
 * formats/hvlink.md is the specification. This header, result.h and src/devices/hvlink_protocol.c are all
 * that a host needs, with hvlink_device.c all that a device needs: no libc, no allocation, no floating-point
 * library.
 *
 * The device lets go by itself: motors are zero once the command's ttl has passed, and it is armed only by an
 * ARM that names its present session, so that neither a replug nor a new start arms it.
 *
 * Not verified on hardware. Everything here: Thread: one at a time, rt-safe.
 */
#ifndef VOXSHELL_HVLINK_H
#define VOXSHELL_HVLINK_H

#include "voxshell/result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sizes [bytes]. */
enum {
    VXS_HVLINK_MAJOR = 1,         /* version of the protocol: another one is refused, */
    VXS_HVLINK_MINOR = 0,         /* another one of these is not */
    VXS_HVLINK_MAX_PAYLOAD = 240, /* of a frame */
    VXS_HVLINK_OVERHEAD = 14,     /* what a frame is besides its payload */
    VXS_HVLINK_MAX_FRAME = VXS_HVLINK_MAX_PAYLOAD + VXS_HVLINK_OVERHEAD, /* both */
    VXS_HVLINK_VALUES = 8, /* numbers of a STATE or CMD at most */
    VXS_HVLINK_TEXT = 32   /* name and serial, with the zero that ends them */
};

/* Types of frames; the host's are below 0x80. */
enum {
    VXS_HVLINK_HELLO = 0x01,  /* who are you? answered by CAPS */
    VXS_HVLINK_ARM = 0x02,    /* with the session of CAPS: force may flow */
    VXS_HVLINK_DISARM = 0x03, /* force off; ends a fault */
    VXS_HVLINK_CMD = 0x04,    /* what the motors are to do, and for how long */
    VXS_HVLINK_PING = 0x05,   /* answered by PONG */
    VXS_HVLINK_CAPS = 0x81,   /* what the device is */
    VXS_HVLINK_STATE = 0x82,  /* what it measured */
    VXS_HVLINK_FAULT = 0x83,  /* that it gave up, and why */
    VXS_HVLINK_PONG = 0x85    /* the PING's payload back */
};

/* Of a STATE. Faults have the numbers of VXS_DEVICE_FAULT_* (device.h). */
enum { VXS_HVLINK_UNCALIBRATED = 0, VXS_HVLINK_READY = 1, VXS_HVLINK_ARMED = 2, VXS_HVLINK_FAULTED = 3 };

/* What values mean. TASK: position [m], then w x y z where turns are sensed; force [N], then torque [N m].
 * JOINTS: joint angles [rad], joint torques [N m]. */
enum { VXS_HVLINK_TASK = 0, VXS_HVLINK_JOINTS = 1 };

/* A frame as it goes over the wire. */
typedef struct vxs_hvlink_frame {
    uint8_t type;                            /* VXS_HVLINK_HELLO ... */
    uint8_t size;                            /* of the payload [bytes] */
    uint16_t sequence;                       /* the sender's, one more each frame; wraps */
    uint32_t time_us;                        /* the sender's clock; wraps */
    uint8_t payload[VXS_HVLINK_MAX_PAYLOAD]; /* as its type says */
} vxs_hvlink_frame;

/* Payload of CAPS. */
typedef struct vxs_hvlink_caps {
    uint16_t major, minor; /* version that the device speaks */
    uint32_t session;      /* new at each start of the device */
    uint8_t space;         /* VXS_HVLINK_TASK ... */
    uint8_t sensed;        /* values in a STATE */
    uint8_t actuated;      /* values in a CMD */
    uint8_t reserved;
    uint16_t rate_hz;                                    /* STATEs a second */
    uint16_t ttl_ms;                                     /* the longest that the device takes */
    float peak_force, peak_torque;                       /* [N] or of a joint [N m]; [N m]; 0: not known */
    float resolution;                                    /* [m] or [rad]; 0: not known */
    char name[VXS_HVLINK_TEXT], serial[VXS_HVLINK_TEXT]; /* for people; end with a zero */
} vxs_hvlink_caps;

/* Payload of STATE. */
typedef struct vxs_hvlink_state {
    uint8_t state, fault;      /* VXS_HVLINK_READY ..., VXS_DEVICE_FAULT_* */
    uint8_t count;             /* of values */
    uint8_t has_velocity;      /* 1: velocity holds count numbers, per second */
    uint32_t buttons;          /* bit n: number n is down */
    uint16_t command_sequence; /* of the last CMD that was taken */
    uint16_t command_age_ms;   /* how long ago that was */
    float value[VXS_HVLINK_VALUES], velocity[VXS_HVLINK_VALUES]; /* [m] or [rad], and per second, by space */
} vxs_hvlink_state;

/* Payload of CMD. */
typedef struct vxs_hvlink_command {
    uint16_t ttl_ms; /* 1 .. caps.ttl_ms: zero from then on */
    uint8_t count;   /* of values */
    uint8_t reserved;
    float value[VXS_HVLINK_VALUES]; /* [N], [N m] */
} vxs_hvlink_command;

/* CRC-32C (Castagnoli) of some bytes, as a frame ends with. */
VXS_API uint32_t vxs_hvlink_crc(const uint8_t *bytes, size_t size);

/* Bytes of a frame, at most VXS_HVLINK_MAX_FRAME; 0 if `most` is too little. */
VXS_API size_t vxs_hvlink_encode(const vxs_hvlink_frame *frame, uint8_t *bytes, size_t most);

/* Frames out of a stream of bytes, which may begin and break anywhere: zero it, put bytes, take frames until
 * there is none. */
typedef struct vxs_hvlink_stream {
    uint8_t bytes[VXS_HVLINK_MAX_FRAME]; /* that wait */
    uint16_t count;                      /* of them */
    uint16_t reserved;
    uint32_t dropped; /* bytes that belonged to no frame; wraps */
} vxs_hvlink_stream;

/* A byte of the wire; a full buffer drops its oldest, and counts it. */
VXS_API void vxs_hvlink_put(vxs_hvlink_stream *stream, uint8_t byte);
/* Takes the next whole frame out of the stream: 1 and the frame; 0: more bytes are needed. */
VXS_API int vxs_hvlink_take(vxs_hvlink_stream *stream, vxs_hvlink_frame *frame);

/* Payloads. pack_ fills type, size and payload. unpack_ returns 1; 0 for a frame of another type or a payload
 * that breaks the specification (nothing is written). Numbers need not be finite: whoever acts on them looks.
 */
VXS_API void vxs_hvlink_pack_hello(vxs_hvlink_frame *frame);
VXS_API void vxs_hvlink_pack_arm(uint32_t session, vxs_hvlink_frame *frame);
VXS_API void vxs_hvlink_pack_caps(const vxs_hvlink_caps *caps, vxs_hvlink_frame *frame);
VXS_API void vxs_hvlink_pack_state(const vxs_hvlink_state *state, vxs_hvlink_frame *frame);
VXS_API void vxs_hvlink_pack_command(const vxs_hvlink_command *command, vxs_hvlink_frame *frame);
VXS_API void vxs_hvlink_pack_fault(uint8_t fault, vxs_hvlink_frame *frame);
VXS_API int vxs_hvlink_unpack_fault(const vxs_hvlink_frame *frame, uint8_t *fault);
VXS_API int vxs_hvlink_unpack_arm(const vxs_hvlink_frame *frame, uint32_t *session);
VXS_API int vxs_hvlink_unpack_caps(const vxs_hvlink_frame *frame, vxs_hvlink_caps *caps);
VXS_API int vxs_hvlink_unpack_state(const vxs_hvlink_frame *frame, vxs_hvlink_state *state);
VXS_API int vxs_hvlink_unpack_command(const vxs_hvlink_frame *frame, vxs_hvlink_command *command);

/* The device's end. Put each byte that arrives, call vxs_hvlink_device_output() before each write to the
 * motors, send a STATE once a sample. */
typedef struct vxs_hvlink_device {
    vxs_hvlink_caps caps;       /* what it is */
    vxs_hvlink_stream stream;   /* what came of the host */
    vxs_hvlink_command command; /* the newest that was taken */
    uint8_t state, fault;       /* VXS_HVLINK_READY ... */
    uint8_t has_command;        /* not 0: there was one since it was armed */
    uint8_t reserved;
    uint16_t sequence, command_sequence; /* of its next frame; of that command */
    uint32_t command_us;                 /* when that came, its clock */
} vxs_hvlink_device;

/* caps are copied; state begins as READY (UNCALIBRATED: set it, and READY once homed). */
VXS_API void vxs_hvlink_device_init(vxs_hvlink_device *device, const vxs_hvlink_caps *caps);

/* A byte from the host. Returns the size of what is to be sent back, 0 for nothing; reply has room for
 * VXS_HVLINK_MAX_FRAME. */
VXS_API size_t vxs_hvlink_device_receive(vxs_hvlink_device *device, uint8_t byte, uint32_t now_us,
                                         uint8_t *reply);

/* What the motors are to do now: caps.actuated numbers; all zero unless armed and within the command's ttl. A
 * device that heard no command for 100 ms disarms. */
VXS_API void vxs_hvlink_device_output(vxs_hvlink_device *device, uint32_t now_us, float *value);

/* The device itself found something wrong: motors off until the host arms anew. */
VXS_API void vxs_hvlink_device_fail(vxs_hvlink_device *device, uint8_t fault);

/* A STATE of caps.sensed values, velocity may be NULL; returns its size. bytes: VXS_HVLINK_MAX_FRAME. */
VXS_API size_t vxs_hvlink_device_state(vxs_hvlink_device *device, const float *value, const float *velocity,
                                       uint32_t buttons, uint32_t now_us, uint8_t *bytes);

#ifdef __cplusplus
}
#endif
#endif
