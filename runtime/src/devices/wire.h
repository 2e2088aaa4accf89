/* SPDX-License-Identifier: MIT
 *
 * wire.h - private: what carries bytes to a device: a tty, a hidraw node, USB, or a test's emulated
 * device.
 */
#ifndef VXSI_WIRE_H
#define VXSI_WIRE_H

#include "voxshell/result.h"

enum { VXSI_WIRE_MOST = 512 };

typedef struct vxsi_wire_ops {
    const char *name;
    /* set-up; may block. A vendor's control request without data; NULL on a wire that has none. */
    vxs_result (*control)(void *self, uint8_t request, uint16_t value);
    /* Starts to send, never waits. VXS_OK; VXS_BUSY: what was sent before is still on its way; VXS_LOST. */
    vxs_result (*send)(void *self, const uint8_t *bytes, size_t size);
    /* What has arrived, one packet or some bytes; waits for it at most wait_ns. 0: nothing; negative: a
     * vxs_result, VXS_LOST for ever. most: VXSI_WIRE_MOST. */
    int32_t (*receive)(void *self, uint8_t *bytes, size_t most, int64_t wait_ns);
    /* set-up; waits 200 ms at most. */
    void (*close)(void *self);
} vxsi_wire_ops;

typedef struct vxsi_wire {
    const vxsi_wire_ops *ops;
    void *self;
} vxsi_wire;

/* What ops->receive is on a file: a tty, a hidraw node. */
int32_t vxsi_wire_read(int file, uint8_t *bytes, size_t most, int64_t wait_ns);

/* A tty as raw bytes, for this process alone. VXS_OK; VXS_NO_DEVICE; VXS_ACCESS; VXS_BUSY; VXS_IO. */
typedef struct vxsi_tty {
    int file;
} vxsi_tty;
vxs_result vxsi_tty_open(vxsi_tty *tty, const char *path, vxsi_wire *wire);

/* A HID device's reports as the kernel has them, one a read; the kernel's own driver keeps the device, and
 * other programs may read it, too. Results as of vxsi_tty_open(). */
typedef struct vxsi_hidraw {
    int file;
} vxsi_hidraw;
vxs_result vxsi_hidraw_open(vxsi_hidraw *hidraw, const char *path, vxsi_wire *wire);

/* Nodes of devices that is_known(), with what came of opening each. Returns how many. */
typedef struct vxsi_hidraw_seen {
    uint16_t vendor, product;
    char path[32]; /* "/dev/hidraw0" */
    vxs_result usable;
} vxsi_hidraw_seen;
uint32_t vxsi_hidraw_list(int (*is_known)(uint16_t vendor, uint16_t product), vxsi_hidraw_seen *seen,
                          uint32_t most);

/* USB: an interface, its IN endpoint and its OUT endpoint (0: none); or with is_serial a CDC-ACM device, whose
 * descriptors say which. Memory for vxsi_usb_open() is a vxsi_usb. */
typedef struct vxsi_usb_match {
    uint16_t vendor, product;
    uint8_t interface, in, out;
    uint8_t is_interrupt; /* else bulk */
    uint8_t is_serial;
} vxsi_usb_match;
typedef struct vxsi_usb vxsi_usb;
size_t vxsi_usb_memory(void);
vxs_result vxsi_usb_open(vxsi_usb *usb, const vxsi_usb_match *match, vxsi_wire *wire);

/* Whether a device that is_known() is there, one call each: VXS_OK, VXS_ACCESS, VXS_BUSY. Returns how many.
 */
typedef struct vxsi_usb_seen {
    uint16_t vendor, product;
    uint32_t bus, number;
    vxs_result usable;
} vxsi_usb_seen;
uint32_t vxsi_usb_list(int (*is_known)(uint16_t vendor, uint16_t product), vxsi_usb_seen *seen,
                       uint32_t most);

#endif
