/* SPDX-License-Identifier: MIT
 *
 * trace.h - rows from the servo thread to another one, without a lock: one writer, one reader.
 */
#ifndef VOXSHELL_TRACE_H
#define VOXSHELL_TRACE_H

#include "voxshell/servo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Object: a ring in the caller's memory. */
typedef struct vxs_trace vxs_trace;

/* Bytes for a ring of `rows` rows, a power of two; 0 if it is none. Thread: any, rt-safe. */
VXS_API size_t vxs_trace_memory(uint32_t rows);

/* VXS_OK; VXS_PARAM (rows); VXS_BUFFER (too small, or not a multiple of 64).
 * Thread: any, set-up. */
VXS_API vxs_result vxs_trace_init(void *memory, size_t size, uint32_t rows, vxs_trace **out);

/* Puts a row; a full ring drops it and counts. Thread: the writer, rt-safe. */
VXS_API void vxs_trace_push(vxs_trace *trace, const vxs_servo_trace *row);

/* Takes up to max rows, oldest first; returns how many. Thread: the reader, rt-safe. */
VXS_API size_t vxs_trace_drain(vxs_trace *trace, vxs_servo_trace *rows, size_t max);

/* Rows dropped so far. Thread: any, rt-safe. */
VXS_API uint64_t vxs_trace_dropped(const vxs_trace *trace);

#ifdef __cplusplus
}
#endif
#endif
