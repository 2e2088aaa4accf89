/* SPDX-License-Identifier: MIT
 *
 * replay.h - a device that moves as it once did, or as a script says; what it is told to render is not felt.
 *
 * Library voxshell::devices. One sample an exchange, time is virtual; between two rows the position goes evenly, the orientation is the
 * earlier row's. Past the last row it stays there. Armed and disarmed like any device, so that a servo runs
 * on it as it ran on the one that was recorded.
 */
#ifndef VOXSHELL_REPLAY_H
#define VOXSHELL_REPLAY_H

#include "voxshell/device.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where it is at a time. */
typedef struct vxs_replay_row {
    double time;      /* [s], growing from row to row */
    vxs_pose pose;    /* of the tip, device frame */
    uint32_t buttons; /* bit n: number n is down */
    uint32_t reserved;
} vxs_replay_row;

/* Config. rows are borrowed until vxs_device_close(). */
typedef struct vxs_replay_config {
    uint32_t struct_size;
    uint32_t reserved;
    const vxs_replay_row *rows;
    size_t row_count;   /* 1 or more */
    double sample_time; /* [s] 1e-5 .. 0.1; default 0.001 */
} vxs_replay_config;

/* All but the rows. Thread: any, rt-safe. */
VXS_API void vxs_replay_config_default(vxs_replay_config *config);

/* Bytes for vxs_replay_open(). Thread: any, rt-safe. */
VXS_API size_t vxs_replay_memory(void);

/* Opens in the caller's memory (any multiple of 16), READY. VXS_OK; VXS_CONFIG; VXS_PARAM (also: a number
 * that is not finite or beyond 1e9, times that do not grow); VXS_BUFFER. Thread: any, set-up. */
VXS_API vxs_result vxs_replay_open(void *memory, size_t size, const vxs_replay_config *config,
                                   vxs_device **out);

/* Rows out of a file's bytes: a recording of recorder.h (binary), or text, a line of names and lines of
 * numbers with commas between. Names: t_s, device_x_m, device_y_m, device_z_m (or x_m, y_m, z_m), device_qw
 * .. device_qz (or qw .. qz) and buttons; others are passed over; all but time and position may be missing.
 * *count: how many there are, also beyond `most` (rows may be NULL then). VXS_OK; VXS_PARAM; VXS_CORRUPT (a
 * field that is no finite number, or is missing; *line, may be NULL, says which, 0 in a recording);
 * VXS_VERSION (a recording of other rows); VXS_TRUNCATED. Thread: any, set-up. */
VXS_API vxs_result vxs_replay_parse(const void *bytes, size_t size, vxs_replay_row *rows, size_t most,
                                    size_t *count, size_t *line);

#ifdef __cplusplus
}
#endif
#endif
