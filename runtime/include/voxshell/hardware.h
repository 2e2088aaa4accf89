/* SPDX-License-Identifier: MIT
 *
 * hardware.h - devices that are hardware: which kinds there are, which of them is here, opening one.
 *
 * Library voxshell::devices, on top of the runtime. A kind is one file under src/devices/ and a row in a
 * table. What they share: an I/O thread owns the wire; the servo thread meets it at two mailboxes and never
 * waits. Motors get zero, unless ARMED, with a fresh measurement, and within a command's time; then the part
 * that the device can render, clamped with one common factor to a limit that grows from 0 to the device's
 * peak within 0.5 s of arming. A number that is not finite, a place that is out of reach of any hand, 20
 * packets against the protocol, 100 ms of silence, a clock that goes back: FAULT, force zero, until
 * vxs_device_disarm(). A device that is unplugged is GONE, and opened anew it is READY, never armed.
 *
 * None of these was tried on hardware by us: caps.verified is 0.
 *
 *     vxs_hardware_config config;
 *     vxs_hardware_config_default(&config);
 *     config.address = "/dev/ttyACM0";
 *     void *memory = aligned_alloc(64, vxs_hardware_memory());
 *     vxs_hardware_open(memory, vxs_hardware_memory(), vxs_hardware_kind_named("hvlink"), &config, &device);
 *     vxs_device_arm(device);
 */
#ifndef VOXSHELL_HARDWARE_H
#define VOXSHELL_HARDWARE_H

#include "voxshell/device.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How a device may hang on its host, or-ed. Without another word of the user's hidraw comes first, then
 * libusb. */
enum { VXS_HARDWARE_TTY = 1, VXS_HARDWARE_USB = 2, VXS_HARDWARE_HIDRAW = 4 };

/* A kind of hardware. View: static. */
typedef struct vxs_hardware_kind {
    const char *name;       /* "falcon", "haply", "hvlink", "spacemouse" */
    const char *summary;    /* for people */
    uint32_t wires;         /* that this build has: VXS_HARDWARE_TTY ... */
    uint32_t is_built;      /* 0: this build lacks it, lacks_text says what for */
    const char *lacks_text; /* what a build needs to have it; NULL where it is built */
} vxs_hardware_kind;

/* By number from 0 on, NULL at the end; by name, NULL for none such. Thread: any, rt-safe. */
VXS_API const vxs_hardware_kind *vxs_hardware_kind_at(uint32_t index);
VXS_API const vxs_hardware_kind *vxs_hardware_kind_named(const char *name);

/* A device that is here, and a way to it. */
typedef struct vxs_hardware_found {
    const vxs_hardware_kind *kind; /* that knows it */
    uint16_t vendor, product;      /* its VID and PID */
    uint32_t wire;                 /* VXS_HARDWARE_HIDRAW or VXS_HARDWARE_USB */
    vxs_result usable;             /* VXS_OK; VXS_ACCESS: no permission; VXS_BUSY: another program holds it */
    char node[32];                 /* "/dev/hidraw0", "/dev/bus/usb/001/002" */
} vxs_hardware_found;

/* Looks for devices that a kind knows by its VID:PID; returns how many ways to one there are (also beyond
 * `most`): each hidraw node, and each device on USB (in a build with libusb) that no hidraw node leads to. A
 * serial device's VID:PID is its builder's affair: none is known. Opens and closes each for a moment, to tell
 * whether it could. Thread: any, set-up. */
VXS_API uint32_t vxs_hardware_probe(vxs_hardware_found *found, uint32_t most);

/* Config. */
typedef struct vxs_hardware_config {
    uint32_t struct_size;
    uint32_t is_in_place; /* not 0: the user has put a device that cannot find its zero itself (haply) into
                             its starting pose; without it the device is UNCALIBRATED and will not be armed */
    const char *address;  /* a path, of a tty or a hidraw node; or "VVVV:PPPP" in hex: that device, by hidraw
                             or libusb (a serial device takes its tty's place); NULL: the first that the kind
                             knows */
    const char *firmware; /* falcon: a file of the user's; none is shipped. NULL: only a device that has it */
    double units_per_nm;  /* falcon: motor units a N m [1/(N m)], > 0; default 2300, the weak end of what is
                            reported */
    uint32_t haply_setup; /* haply: which board's motors and encoders, 2 or 3; default 2 */
    double haply_links[3]; /* haply [m]: the links at the motors, those at the tip, the motors' distance;
                              default 0.05, 0.07, 0.02 */
    double torque_gain;    /* haply: what is sent a N m [1], > 0; default 1: not calibrated */
    double rate_hz;        /* packets to the device, 100 .. 10000; default 1000 */
    double max_speed;      /* [m/s] a jump faster than that is none of a hand's: FAULT; default 20 */
    double linear_speed;   /* spacemouse [m/s] at full deflection; default 0.1 */
    double angular_speed;  /* spacemouse [rad/s]; default 1 */
} vxs_hardware_config;

/* Fills a config with the defaults that its members name. Thread: any, rt-safe. */
VXS_API void vxs_hardware_config_default(vxs_hardware_config *config);

/* Bytes for vxs_hardware_open(): enough for any kind. Thread: any, rt-safe. */
VXS_API size_t vxs_hardware_memory(void);

/* Opens in the caller's memory (any multiple of 64), which must stay until vxs_device_close(), and starts the
 * I/O thread. May take seconds (a handshake, firmware). The device is READY, UNCALIBRATED or NO_FIRMWARE.
 * VXS_OK; VXS_CONFIG; VXS_PARAM; VXS_BUFFER; VXS_UNSUPPORTED (not built, or a device that speaks another
 * version); VXS_NO_DEVICE; VXS_ACCESS; VXS_BUSY (another program holds it); VXS_TIMEOUT; VXS_PROTOCOL;
 * VXS_LOST; VXS_IO (the firmware's file); VXS_NO_THREAD. Thread: any, set-up. */
VXS_API vxs_result vxs_hardware_open(void *memory, size_t size, const vxs_hardware_kind *kind,
                                     const vxs_hardware_config *config, vxs_device **out);

/* What an open device's wire has been through. */
typedef struct vxs_hardware_counts {
    uint64_t sent, measured; /* packets */
    uint64_t malformed;      /* bytes or packets against the protocol, jumps */
    uint64_t late;           /* packets that the wire had no room for, replies that did not come */
} vxs_hardware_counts;

/* Only for a device of vxs_hardware_open(). Counters may be a packet apart. Thread: any, rt-safe. */
VXS_API void vxs_hardware_get(const vxs_device *device, vxs_hardware_counts *counts);

#ifdef __cplusplus
}
#endif
#endif
