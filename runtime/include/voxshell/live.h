/* SPDX-License-Identifier: MIT
 *
 * live.h - what the servo does right now, for another process: the newest row, in shared memory.
 *
 * One writer, any number of readers, neither ever waits. The file (in /dev/shm, say) is mapped by both; its
 * layout, for readers in other languages, little-endian:
 *
 *     0    8 bytes  "VXSLIVE1"
 *     8    u32      size of a row: sizeof(vxs_servo_trace), fields as there, no gaps but what C leaves
 *     12   u32      process id of the writer
 *     64   u64      sequence: 0 empty, odd while a row is written; 2 more a row
 *     72   row      in words of 8 bytes
 *
 * To read: take the sequence (again while odd), copy the row, and take it again: if it changed, begin anew.
 *
 *     vxs_live live;
 *     vxs_live_create(&live, "/dev/shm/voxshell");     servo's side: config.live = &live
 *     vxs_live_open(&live, "/dev/shm/voxshell");       viewer's side
 *     if (vxs_live_get(&live, &row)) ...
 */
#ifndef VOXSHELL_LIVE_H
#define VOXSHELL_LIVE_H

#include "voxshell/servo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* View of a mapping. */
typedef struct vxs_live {
    void *memory;       /* the mapped file */
    size_t size;        /* of it [bytes] */
    uint32_t is_writer; /* not 0: of vxs_live_create() */
    char path[108];     /* the writer's, to take it away */
} vxs_live;

/* Makes the file, for its owner alone to write (0644), in place of one that is there already. VXS_OK;
 * VXS_PARAM; VXS_IO; VXS_ACCESS. Thread: any, set-up. */
VXS_API vxs_result vxs_live_create(vxs_live *live, const char *path);

/* Opens one to read. VXS_OK; VXS_PARAM; VXS_IO (none there); VXS_ACCESS; VXS_MAGIC; VXS_VERSION (another
 * row); VXS_TRUNCATED. Thread: any, set-up. */
VXS_API vxs_result vxs_live_open(vxs_live *live, const char *path);

/* The writer's also takes the file away; who has it mapped keeps the last row. Thread: any, set-up. */
VXS_API void vxs_live_close(vxs_live *live);

/* Shows a row. Thread: the servo's, rt-safe. */
VXS_API void vxs_live_put(vxs_live *live, const vxs_servo_trace *row);

/* The newest row. Returns its sequence; 0, row untouched: none yet, or the writer was at it eight times.
 * Thread: any, rt-safe. */
VXS_API uint64_t vxs_live_get(const vxs_live *live, vxs_servo_trace *row);

#ifdef __cplusplus
}
#endif
#endif
