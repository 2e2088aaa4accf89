/* SPDX-License-Identifier: MIT
 *
 * The recorder's thread: the operating system's part of a trace. Set-up code: no tick comes here.
 */
#define _GNU_SOURCE 1 /* nanosleep */

#include "voxshell/recorder.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { ALIGNMENT = 64, ROWS = 64, PAUSE_NS = 10000000 };

struct vxs_recorder {
    vxs_trace *trace;
    FILE *file;
    pthread_t thread;
    atomic_uint stop;
    uint64_t rows;
    uint32_t has_failed;
    vxs_servo_trace buffer[ROWS];
};

size_t vxs_recorder_memory(void)
{
    return (sizeof(vxs_recorder) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static void drain(vxs_recorder *r)
{
    for (size_t count; (count = vxs_trace_drain(r->trace, r->buffer, ROWS)) > 0;) {
        size_t written = r->has_failed ? 0 : fwrite(r->buffer, sizeof *r->buffer, count, r->file);
        r->rows += written;
        if (written != count) r->has_failed = 1; /* and the ring is emptied all the same */
    }
}

static void *run(void *argument)
{
    vxs_recorder *r = argument;
    const struct timespec pause = {.tv_nsec = PAUSE_NS};
    while (!atomic_load_explicit(&r->stop, memory_order_acquire)) {
        drain(r);
        nanosleep(&pause, NULL);
    }
    drain(r);
    return NULL;
}

vxs_result vxs_recorder_start(void *memory, size_t size, const char *path, vxs_trace *trace,
                              vxs_recorder **out)
{
    if (!memory || !path || !trace || !out) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_recorder_memory()) return VXS_BUFFER;
    vxs_recorder *r = memory;
    memset(r, 0, sizeof *r);
    r->trace = trace;
    r->file = fopen(path, "wb");
    if (!r->file) return errno == EACCES || errno == EPERM ? VXS_ACCESS : VXS_IO;
    const uint32_t about[2] = {sizeof(vxs_servo_trace), 0};
    if (fwrite("VXSREC01", 1, 8, r->file) != 8 || fwrite(about, sizeof about, 1, r->file) != 1)
        r->has_failed = 1;
    if (pthread_create(&r->thread, NULL, run, r) != 0) {
        fclose(r->file);
        remove(path);
        return VXS_NO_THREAD;
    }
    *out = r;
    return VXS_OK;
}

vxs_result vxs_recorder_stop(vxs_recorder *r, uint64_t *rows)
{
    atomic_store_explicit(&r->stop, 1, memory_order_release);
    pthread_join(r->thread, NULL);
    if (fclose(r->file) != 0) r->has_failed = 1;
    if (rows) *rows = r->rows;
    return r->has_failed ? VXS_IO : VXS_OK;
}
