/* SPDX-License-Identifier: MIT
 *
 * servo_thread.h - the servo on the wall clock: an absolute-time loop of exchange and tick.
 *
 * Wakes at start + n period on CLOCK_MONOTONIC, so a late wake-up does not shift the next. After
 * an overrun of whole periods the missed ones are counted and skipped, never caught up.
 * Real-time scheduling and locked memory are asked for and, where not allowed, done without:
 * the status says so; memory stays locked until the program ends. Time runs as the device says (a simulated
 * device's is virtual: one sample per exchange). Zero and VXS_SERVO_FAULT while a guarded asset has lost
 * bytes (asset.h, vxs_asset_guard()).
 */
#ifndef VOXSHELL_SERVO_THREAD_H
#define VOXSHELL_SERVO_THREAD_H

#include "voxshell/device.h"
#include "voxshell/live.h"
#include "voxshell/servo.h"
#include "voxshell/trace.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Of a histogram. */
enum { VXS_SERVO_THREAD_BINS = 32 };

/* Config. All pointers are borrowed until vxs_servo_thread_stop(). */
typedef struct vxs_servo_thread_config {
    uint32_t struct_size;
    uint32_t lock_memory; /* not 0: mlockall; default 1 */
    int32_t priority;     /* SCHED_FIFO 1 .. 99, 0: leave the scheduler alone; default 80 */
    int32_t cpu;          /* pin to this one, -1: no; default -1. Linux */
    double rate_hz;       /* 100 .. 10000; default 1000 */
    uint64_t max_ticks;   /* stop after so many; 0: run on */
    vxs_device *device;   /* whose exchanges these are */
    vxs_servo *servo;     /* whose ticks */
    vxs_trace *trace;     /* may be NULL */
    vxs_live *live;       /* shows each row to other processes; may be NULL */
    /* Called in the servo thread before each exchange, NULL: none. Must be rt-safe. */
    void (*on_tick)(void *user, uint64_t tick);
    void *user; /* what on_tick is given */
} vxs_servo_thread_config;

/* Bin 0: below 1 us; bin n: 2^(n-1) up to 2^n us; the last bin: all above. */
typedef struct vxs_servo_thread_histogram {
    uint64_t bins[VXS_SERVO_THREAD_BINS]; /* how often */
    uint64_t max_ns;                      /* the longest [ns] */
} vxs_servo_thread_histogram;

/* A snapshot; counters may be a tick apart. */
typedef struct vxs_servo_thread_status {
    uint32_t running;                    /* 0 after max_ticks or stop */
    uint32_t is_realtime;                /* SCHED_FIFO was granted */
    uint32_t is_locked;                  /* memory is locked */
    uint32_t is_pinned;                  /* the processor was granted */
    const char *scheduling_text;         /* "SCHED_FIFO", or why not and what helps; static */
    const char *memory_text;             /* the same for memory */
    uint64_t ticks;                      /* done so far */
    uint64_t missed;                     /* periods skipped */
    uint32_t last_flags;                 /* of the last tick */
    uint32_t seen_flags;                 /* of all ticks, or-ed */
    vxs_servo_thread_histogram lateness; /* wake-up after its time */
    vxs_servo_thread_histogram work;     /* exchange and tick */
} vxs_servo_thread_status;

/* Object. */
typedef struct vxs_servo_thread vxs_servo_thread;

/* All but device and servo. Thread: any, rt-safe. */
VXS_API void vxs_servo_thread_config_default(vxs_servo_thread_config *config);

/* Bytes for vxs_servo_thread_start(). Thread: any, rt-safe. */
VXS_API size_t vxs_servo_thread_memory(void);

/* Starts the thread; memory (any multiple of 64) must stay until vxs_servo_thread_stop() returns.
 * From here on only the thread may touch device and servo. VXS_OK; VXS_CONFIG; VXS_PARAM;
 * VXS_BUFFER; VXS_NO_THREAD; VXS_UNGUARDED (vxs_servo_may_drive()). Thread: any, set-up. */
VXS_API vxs_result vxs_servo_thread_start(void *memory, size_t size, const vxs_servo_thread_config *config,
                                          vxs_servo_thread **out);

/* Copies the counters without stopping anything. Thread: any, rt-safe. */
VXS_API void vxs_servo_thread_get(const vxs_servo_thread *thread, vxs_servo_thread_status *status);

/* Asks the thread to end after its tick; does not wait. Thread: any, also a signal handler. */
VXS_API void vxs_servo_thread_request_stop(vxs_servo_thread *thread);

/* Asks and waits; a last exchange sends zero. Then memory, device and servo are the caller's
 * again. Call once. Thread: any other, set-up. */
VXS_API void vxs_servo_thread_stop(vxs_servo_thread *thread);

#ifdef __cplusplus
}
#endif
#endif
