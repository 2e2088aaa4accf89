/* SPDX-License-Identifier: MIT
 *
 * A link's set-up: opening, arming, its I/O thread, the end.
 */
#define _GNU_SOURCE 1 /* clock_gettime, pthread_setschedparam under -std=c11 */

#include "link.h"

#include <sched.h>
#include <time.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

enum { IO_PRIORITY = 85, LAST_WORDS = 3 };

static int64_t monotonic(void *user)
{
    struct timespec time;
    (void)user;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

/* Nothing that was commanded before acts after; and only a device that is heard is armed. */
static vxs_result arm(void *self)
{
    vxsi_link *link = self;
    uint32_t state = atomic_load(&link->state);
    if (state == VXS_DEVICE_GONE) return VXS_LOST;
    if (state == VXS_DEVICE_ARMED) return VXS_OK;
    if (state != VXS_DEVICE_READY) return VXS_STATE;
    vxs_device_command none;
    memset(&none, 0, sizeof none);
    vxsi_mailbox_put(&link->command, &none, sizeof none);
    atomic_store(&link->armed_ns, link->now(link->user));
    atomic_fetch_add(&link->arming, 1);
    if (atomic_compare_exchange_strong(&link->state, &state, VXS_DEVICE_ARMED)) return VXS_OK;
    return state == VXS_DEVICE_GONE ? VXS_LOST : VXS_STATE;
}

static vxs_result disarm(void *self)
{
    vxsi_link *link = self;
    uint32_t state = atomic_load(&link->state);
    for (;;) {
        if (state == VXS_DEVICE_GONE) return VXS_LOST;
        if (state != VXS_DEVICE_ARMED && state != VXS_DEVICE_FAULT)
            return state == VXS_DEVICE_READY ? VXS_OK : VXS_STATE;
        uint32_t next = link->start == VXS_DEVICE_READY ? VXS_DEVICE_READY : VXS_DEVICE_UNCALIBRATED;
        if (atomic_compare_exchange_weak(&link->state, &state, next)) return VXS_OK;
    }
}

/* Zero goes out until the wire has taken it, as often as it takes. */
static void close_link(void *self)
{
    vxsi_link *link = self;
    if (link->has_thread) {
        atomic_store(&link->stop, 1);
        pthread_join(link->thread, NULL);
        link->has_thread = 0;
    }
    const vxs_wrench zero = {{0, 0, 0}, {0, 0, 0}};
    uint8_t bytes[VXSI_WIRE_MOST];
    for (int n = 0; n < LAST_WORDS && atomic_load(&link->state) != VXS_DEVICE_GONE; n++) {
        size_t size = link->driver->make(link, &zero, 0, bytes);
        vxs_result result = size ? link->wire.ops->send(link->wire.self, bytes, size) : VXS_OK;
        if (result == VXS_LOST || size == 0) break;
        link->wire.ops->receive(link->wire.self, bytes, sizeof bytes, 2000000);
    }
    link->wire.ops->close(link->wire.self);
    atomic_store(&link->state, VXS_DEVICE_CLOSED);
}

static const vxs_device_ops ops = {
    .name = "link", .arm = arm, .disarm = disarm, .close = close_link, .exchange = vxsi_link_exchange};

vxs_result vxsi_link_ask(vxsi_link *link, const uint8_t *bytes, size_t size,
                         int (*done)(vxsi_link *link, const uint8_t *bytes, size_t size), int64_t wait_ns)
{
    uint8_t got[VXSI_WIRE_MOST];
    int64_t end = link->now(link->user) + wait_ns;
    vxs_result result = link->wire.ops->send(link->wire.self, bytes, size);
    while (result == VXS_BUSY && link->now(link->user) < end) { /* what was said before is still on its way */
        int32_t count = link->wire.ops->receive(link->wire.self, got, sizeof got, 1000000);
        result = count < 0 ? (vxs_result)count : link->wire.ops->send(link->wire.self, bytes, size);
    }
    if (result != VXS_OK) return result;
    for (int64_t left = wait_ns; left > 0; left = end - link->now(link->user)) {
        int32_t count =
            link->wire.ops->receive(link->wire.self, got, sizeof got, left < 5000000 ? left : 5000000);
        if (count < 0) return (vxs_result)count;
        if (count > 0 && done(link, got, (size_t)count)) return VXS_OK;
    }
    return VXS_TIMEOUT;
}

vxs_result vxsi_link_open(vxsi_link *link, const vxsi_driver *driver, const vxs_hardware_config *config,
                          const vxsi_wire *wire)
{
    int64_t (*now)(void *) = link->now;
    void *user = link->user;
    memset(link, 0, sizeof *link);
    link->now = now ? now : monotonic;
    link->user = user;
    link->device.ops = &ops;
    link->device.self = link;
    link->driver = driver;
    link->config = *config;
    link->wire = *wire;
    link->period_ns = (int64_t)(1e9 / config->rate_hz + 0.5);
    link->measured.pose = link->seen.state.pose = vxs_pose_identity();
    link->device.caps.rate_hz = config->rate_hz;
    link->start = VXS_DEVICE_READY;
    vxs_result result = driver->begin(link);
    if (result != VXS_OK) {
        wire->ops->close(wire->self);
        return result;
    }
    link->device.caps.has_motors = link->device.caps.dof_actuated != 0;
    link->last_step_ns = link->last_news_ns = link->now(link->user);
    atomic_store(&link->state, link->start);
    return VXS_OK;
}

static void *run(void *argument)
{
    vxsi_link *link = argument;
    struct sched_param parameter = {.sched_priority = IO_PRIORITY};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter); /* where allowed */
#ifdef __linux__
    prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
#endif
    while (!atomic_load_explicit(&link->stop, memory_order_relaxed)) {
        int64_t due = link->last_send_ns + link->period_ns - link->now(link->user);
        int64_t wait = due < 0 ? 0 : due < link->period_ns ? due : link->period_ns;
        if (link->is_waiting) wait = link->period_ns;
        if (!vxsi_link_step(link, wait)) break;
    }
    return NULL;
}

vxs_result vxsi_link_run(vxsi_link *link)
{
    link->has_thread = 1;
    if (pthread_create(&link->thread, NULL, run, link) == 0) return VXS_OK;
    link->has_thread = 0;
    close_link(link);
    return VXS_NO_THREAD;
}
