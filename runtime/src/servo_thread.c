/* SPDX-License-Identifier: MIT
 *
 * The servo on the wall clock. The operating system's part: set-up code, but for run().
 */
#define _GNU_SOURCE 1 /* pthread_setaffinity_np */

#include "voxshell/servo_thread.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

enum { ALIGNMENT = 64 };

typedef struct histogram {
    atomic_uint_least64_t bins[VXS_SERVO_THREAD_BINS];
    atomic_uint_least64_t max_ns;
} histogram;

struct vxs_servo_thread {
    vxs_servo_thread_config config;
    pthread_t thread;
    int64_t period_ns;
    atomic_uint stop;
    atomic_uint running, is_realtime, is_locked, is_pinned; /* written by the thread at its start */
    _Atomic(const char *) scheduling_text;
    _Atomic(const char *) memory_text;
    alignas(ALIGNMENT) atomic_uint_least64_t ticks;
    atomic_uint_least64_t missed;
    atomic_uint last_flags, seen_flags;
    histogram lateness, work;
};

void vxs_servo_thread_config_default(vxs_servo_thread_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->lock_memory = 1;
    config->priority = 80;
    config->cpu = -1;
    config->rate_hz = 1000;
}

size_t vxs_servo_thread_memory(void)
{
    return sizeof(vxs_servo_thread);
}

static int64_t now_ns(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

static void sleep_until(int64_t time_ns)
{
    struct timespec time = {.tv_sec = (time_t)(time_ns / 1000000000),
                            .tv_nsec = (long)(time_ns % 1000000000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, NULL) == EINTR) {
    }
}

/* One writer: no read-modify-write is needed. */
static void add(atomic_uint_least64_t *counter, uint64_t more)
{
    uint64_t before = atomic_load_explicit(counter, memory_order_relaxed);
    atomic_store_explicit(counter, before + more, memory_order_relaxed);
}

static void note(histogram *h, int64_t ns)
{
    uint64_t time = ns > 0 ? (uint64_t)ns : 0;
    uint32_t bin = 0;
    for (uint64_t us = time / 1000; us > 0 && bin < VXS_SERVO_THREAD_BINS - 1; us >>= 1) bin++;
    add(&h->bins[bin], 1);
    if (time > atomic_load_explicit(&h->max_ns, memory_order_relaxed))
        atomic_store_explicit(&h->max_ns, time, memory_order_relaxed);
}

static void ask_for_scheduling(vxs_servo_thread *t)
{
    int priority = t->config.priority;
    const char *text = "default scheduler, as configured";
    if (priority > 0) {
        struct sched_param parameter = {.sched_priority = priority};
        if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter) == 0) {
            atomic_store(&t->is_realtime, 1);
            text = "SCHED_FIFO";
        } else {
            text = "default scheduler: SCHED_FIFO is not allowed (raise rtprio in limits.conf, or grant "
                   "CAP_SYS_NICE)";
        }
    }
    atomic_store(&t->scheduling_text, text);
#ifdef __linux__
    prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL); /* wake on time also without SCHED_FIFO */
    cpu_set_t set;
    CPU_ZERO(&set);
    if (t->config.cpu >= 0 && t->config.cpu < CPU_SETSIZE) {
        CPU_SET((size_t)t->config.cpu, &set);
        if (pthread_setaffinity_np(pthread_self(), sizeof set, &set) == 0) atomic_store(&t->is_pinned, 1);
    }
#endif
}

/* What is mapped now: locking the future too would make later allocations fail at the limit. */
static void ask_for_memory(vxs_servo_thread *t)
{
    const char *text = "not locked, as configured";
    if (t->config.lock_memory) {
        if (mlockall(MCL_CURRENT) == 0) {
            atomic_store(&t->is_locked, 1);
            text = "locked";
        } else {
            text = "not locked: over the limit (raise memlock in limits.conf, or grant CAP_IPC_LOCK)";
        }
    }
    atomic_store(&t->memory_text, text);
}

static void sample(vxs_servo_thread *t, uint64_t tick, vxs_device_command *command)
{
    const vxs_servo_thread_config *config = &t->config;
    vxs_device_state state;
    vxs_servo_trace row;
    if (config->on_tick) config->on_tick(config->user, tick);
    vxs_device_exchange(config->device, command, &state, NULL);
    uint32_t flags =
        vxs_servo_tick(config->servo, &state, command, config->trace || config->live ? &row : NULL);
    if (vxs_asset_lost()) { /* in this tick or before: what it read may have been zeros */
        flags |= VXS_SERVO_FAULT;
        memset(&command->wrench, 0, sizeof command->wrench);
        row.flags = flags;
        row.command = command->wrench;
    }
    if (config->trace) vxs_trace_push(config->trace, &row);
    if (config->live) vxs_live_put(config->live, &row);
    uint32_t seen = atomic_load_explicit(&t->seen_flags, memory_order_relaxed);
    atomic_store_explicit(&t->seen_flags, seen | flags, memory_order_relaxed);
    atomic_store_explicit(&t->last_flags, flags, memory_order_relaxed);
}

static void *run(void *argument)
{
    vxs_servo_thread *t = argument;
    ask_for_scheduling(t);
    ask_for_memory(t);
    vxs_device_command command;
    memset(&command, 0, sizeof command);
    int64_t next = now_ns() + t->period_ns;
    uint64_t max_ticks = t->config.max_ticks;
    for (uint64_t tick = 0;
         !atomic_load_explicit(&t->stop, memory_order_relaxed) && (!max_ticks || tick < max_ticks); tick++) {
        sleep_until(next);
        int64_t woken = now_ns();
        note(&t->lateness, woken - next);
        sample(t, tick, &command);
        int64_t done = now_ns();
        note(&t->work, done - woken);
        add(&t->ticks, 1);
        next += t->period_ns;
        if (done > next) {
            int64_t skipped = (done - next) / t->period_ns;
            add(&t->missed, (uint64_t)skipped);
            next += skipped * t->period_ns;
        }
    }
    vxs_device_state state;
    memset(&command, 0, sizeof command);
    vxs_device_exchange(t->config.device, &command, &state, NULL);
    atomic_store_explicit(&t->running, 0, memory_order_release);
    return NULL;
}

vxs_result vxs_servo_thread_start(void *memory, size_t size, const vxs_servo_thread_config *config,
                                  vxs_servo_thread **out)
{
    if (!config || !memory || !out) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    if (!config->device || !config->servo || !(config->rate_hz >= 100 && config->rate_hz <= 10000) ||
        config->priority < 0 || config->priority > 99)
        return VXS_PARAM;
    vxs_result result = vxs_servo_may_drive(config->servo, &config->device->caps);
    if (result != VXS_OK) return result;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_servo_thread_memory()) return VXS_BUFFER;
    vxs_servo_thread *t = memory;
    memset(t, 0, sizeof *t);
    t->config = *config;
    t->period_ns = (int64_t)(1e9 / config->rate_hz + 0.5);
    atomic_store(&t->running, 1);
    atomic_store(&t->scheduling_text, "starting");
    atomic_store(&t->memory_text, "starting");
    *out = t;
    if (pthread_create(&t->thread, NULL, run, t) == 0) return VXS_OK;
    *out = NULL;
    return VXS_NO_THREAD;
}

static void copy_histogram(const histogram *from, vxs_servo_thread_histogram *to)
{
    for (int n = 0; n < VXS_SERVO_THREAD_BINS; n++)
        to->bins[n] = atomic_load_explicit(&from->bins[n], memory_order_relaxed);
    to->max_ns = atomic_load_explicit(&from->max_ns, memory_order_relaxed);
}

void vxs_servo_thread_get(const vxs_servo_thread *t, vxs_servo_thread_status *status)
{
    status->running = atomic_load_explicit(&t->running, memory_order_acquire);
    status->is_realtime = atomic_load(&t->is_realtime);
    status->is_locked = atomic_load(&t->is_locked);
    status->is_pinned = atomic_load(&t->is_pinned);
    status->scheduling_text = atomic_load(&t->scheduling_text);
    status->memory_text = atomic_load(&t->memory_text);
    status->ticks = atomic_load_explicit(&t->ticks, memory_order_relaxed);
    status->missed = atomic_load_explicit(&t->missed, memory_order_relaxed);
    status->last_flags = atomic_load_explicit(&t->last_flags, memory_order_relaxed);
    status->seen_flags = atomic_load_explicit(&t->seen_flags, memory_order_relaxed);
    copy_histogram(&t->lateness, &status->lateness);
    copy_histogram(&t->work, &status->work);
}

void vxs_servo_thread_request_stop(vxs_servo_thread *t)
{
    atomic_store_explicit(&t->stop, 1, memory_order_relaxed);
}

void vxs_servo_thread_stop(vxs_servo_thread *t)
{
    vxs_servo_thread_request_stop(t);
    pthread_join(t->thread, NULL);
}
