/* SPDX-License-Identifier: MIT
 *
 * link.h - private: what all devices on a wire share: states, the gate before the motors, the two mailboxes.
 *
 * A driver knows a device's bytes and geometry and nothing else. vxsi_link_step() is one turn of the I/O
 * thread: what arrived, what is wrong, what goes out; a test calls it on virtual time.
 */
#ifndef VXSI_LINK_H
#define VXSI_LINK_H

#include "mailbox.h"
#include "voxshell/hardware.h"
#include "wire.h"

#include <pthread.h>
#include <stdalign.h>

/* What a driver makes of bytes, or-ed. */
enum { VXSI_LINK_NEWS = 1, VXSI_LINK_MALFORMED = 2 };

typedef struct vxsi_link vxsi_link;

typedef struct vxsi_driver {
    const char *name;
    /* set-up; may block. Gets the device talking, fills caps and link->start. Any vxs_result of opening. */
    vxs_result (*begin)(vxsi_link *link);
    /* Bytes from the wire. With VXSI_LINK_NEWS *state has pose, buttons, velocity where the device measures
     * it (velocity_source), state: READY, UNCALIBRATED, ARMED where the device itself has such a state, or
     * FAULT with its fault. *state comes as it was the last time. Never blocks. */
    uint32_t (*take)(vxsi_link *link, const uint8_t *bytes, size_t size, vxs_device_state *state);
    /* The next packet for the device; 0: none. arming: grows by one at each vxs_device_arm(), 0 while not
     * armed. The wrench is what the motors are to do. Never blocks. */
    size_t (*make)(vxsi_link *link, const vxs_wrench *wrench, uint32_t arming, uint8_t *bytes);
    /* set-up; NULL: calibration is the device's own affair. */
    uint32_t answers;       /* the device answers each packet: one on its way at a time */
    uint32_t may_be_silent; /* it speaks only when moved */
} vxsi_driver;

enum { VXSI_LINK_MEMORY = 1024 }; /* of a driver */

/* From the I/O thread to the servo's. */
typedef struct vxsi_link_news {
    vxs_device_state state;
    vxs_device_report report;
} vxsi_link_news;

struct vxsi_link {
    vxs_device device;
    const vxsi_driver *driver;
    vxs_hardware_config config;
    vxsi_wire wire;
    int64_t (*now)(void *user); /* the clock: CLOCK_MONOTONIC but in tests */
    void *user;
    uint32_t start; /* VXS_DEVICE_READY, ... : state after begin */
    int64_t period_ns;

    atomic_uint state, fault;
    atomic_uint arming; /* grows by one at each arm() */
    atomic_int_least64_t armed_ns;
    vxsi_mailbox command, news;

    /* the servo thread's */
    alignas(64) vxsi_link_news seen;

    /* the I/O thread's */
    alignas(64) vxs_device_state measured;
    uint64_t sequence;
    int64_t last_step_ns, last_news_ns, last_send_ns;
    uint32_t is_waiting, bad_in_a_row;
    vxs_device_report report; /* of the last packet */
    uint8_t driver_memory[VXSI_LINK_MEMORY];
    atomic_uint_least64_t sent, measured_count, malformed, late;

    atomic_uint stop;
    uint32_t has_thread;
    pthread_t thread;
};

/* Makes a link of a wire that is open, up to the device's first words: READY, UNCALIBRATED or NO_FIRMWARE,
 * without a thread. link->now and ->user may be set before; NULL: the monotonic clock. On failure the wire is
 * closed. */
vxs_result vxsi_link_open(vxsi_link *link, const vxsi_driver *driver, const vxs_hardware_config *config,
                          const vxsi_wire *wire);

/* Its I/O thread; without one somebody calls vxsi_link_step(). */
vxs_result vxsi_link_run(vxsi_link *link);

/* One turn: waits for bytes at most wait_ns. Returns 0 once the device is gone. */
int vxsi_link_step(vxsi_link *link, int64_t wait_ns);

void vxsi_link_exchange(void *self, const vxs_device_command *command, vxs_device_state *state,
                        vxs_device_report *report);

/* ARMED, READY, UNCALIBRATED -> FAULT. */
void vxsi_link_fail(vxsi_link *link, uint32_t fault);
int vxsi_link_is_finite(const double v[3]);

/* For begin: sends, then waits for bytes until done() says so; VXS_TIMEOUT after wait_ns. */
vxs_result vxsi_link_ask(vxsi_link *link, const uint8_t *bytes, size_t size,
                         int (*done)(vxsi_link *link, const uint8_t *bytes, size_t size), int64_t wait_ns);

extern const vxsi_driver vxsi_falcon_driver, vxsi_haply_driver, vxsi_spacemouse_driver, vxsi_hvlink_driver;

#endif
