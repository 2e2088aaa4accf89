/* SPDX-License-Identifier: MIT
 *
 * recorder.h - all rows of a servo to a file, by a thread of its own, which never delays a tick.
 *
 * The servo thread pushes rows into a ring (trace.h); the recorder's thread empties it a hundred times a
 * second. If the disk stalls for longer than the ring is, rows are dropped and counted, not waited for. The
 * file, little-endian: 8 bytes "VXSREC01", u32 size of a row, u32 0, then rows (vxs_servo_trace). replay.h
 * plays it back.
 */
#ifndef VOXSHELL_RECORDER_H
#define VOXSHELL_RECORDER_H

#include "voxshell/trace.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Object. */
typedef struct vxs_recorder vxs_recorder;

/* Bytes for vxs_recorder_start(). Thread: any, rt-safe. */
VXS_API size_t vxs_recorder_memory(void);

/* Makes the file (in place of one that is there) and starts the thread, which is the ring's one reader until
 * vxs_recorder_stop(); memory: any multiple of 64. VXS_OK; VXS_PARAM; VXS_BUFFER; VXS_IO; VXS_ACCESS;
 * VXS_NO_THREAD. Thread: any, set-up. */
VXS_API vxs_result vxs_recorder_start(void *memory, size_t size, const char *path, vxs_trace *trace,
                                      vxs_recorder **out);

/* Writes what is in the ring and ends. *rows (may be NULL): how many are in the file. VXS_OK; VXS_IO: the
 * disk refused some. Call once, after the servo's last tick. Thread: any other, set-up. */
VXS_API vxs_result vxs_recorder_stop(vxs_recorder *recorder, uint64_t *rows);

#ifdef __cplusplus
}
#endif
#endif
