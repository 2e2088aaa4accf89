/* SPDX-License-Identifier: MIT
 *
 * calibration.h - what a device's newton weighs: it holds its tip in the air, a known mass is hung on it, and
 * by how much more it then commands tells how many commanded newtons a true one takes.
 *
 * Library voxshell::devices. The tip is held by a spring and a damper whose target goes up and down a little
 * at an even speed: friction pulls one way on the way up and the other on the way down, so a whole period's
 * mean is without it, and the grip's own weight is in the mean before. No clock, no system call: the caller
 * exchanges with an ARMED device once a sample and gives each state to vxs_calibration_tick().
 *
 * What came of it is `scale`. A Falcon's units_per_nm and a Haply's torque_gain (hardware.h) are to be
 * multiplied by it; the firmware of an hvlink device is to give scale times as much.
 */
#ifndef VOXSHELL_CALIBRATION_H
#define VOXSHELL_CALIBRATION_H

#include "voxshell/device.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Config. */
typedef struct vxs_calibration_config {
    uint32_t struct_size;
    uint32_t reserved;
    double mass;        /* [kg] > 0, that is hung on the tip; no default */
    double down[3];     /* where its weight pulls, device frame, length 1; default (0, -1, 0) */
    double gravity;     /* [m/s^2] > 0; default 9.81 */
    double sample_time; /* [s] 1e-4 .. 0.01; default 0.001 */
    double stiffness;   /* [N/m] > 0, of what holds the tip; default 400 */
    double damping;     /* [N s/m] >= 0; default 2 */
    double way;         /* [m] > 0, up and down from where the tip is; default 0.01 */
    double period;      /* [s] 0.2 .. 60; default 2 */
    double patience;    /* [s] > 0, for the empty tip, and from there to DONE; default 60 */
    double max_force;   /* [N] > 0; default 6 */
    double max_speed;   /* [m/s] > 0: faster, and it lets go; default 1 */
} vxs_calibration_config;

/* Phases. */
enum {
    VXS_CALIBRATION_EMPTY = 0,     /* measures the grip's own weight: do not touch it */
    VXS_CALIBRATION_HANG = 1,      /* waits for the mass to be hung */
    VXS_CALIBRATION_LOADED = 2,    /* measures with it: do not touch it */
    VXS_CALIBRATION_DONE = 3,      /* zero force from here on */
    VXS_CALIBRATION_IMPATIENT = 4, /* ended: nothing was hung, it never rests, or friction holds the tip */
    VXS_CALIBRATION_LET_GO = 5,    /* ended: the device was not ARMED, or faster than max_speed */
    VXS_CALIBRATION_TOO_HEAVY = 6  /* ended: held with all of max_force */
};

/* How far it is. */
typedef struct vxs_calibration_result {
    uint32_t phase;       /* VXS_CALIBRATION_... */
    uint32_t periods;     /* measured so far */
    double empty, loaded; /* [N] commanded upwards, means of whole periods */
    double spread;        /* [N] between the last two periods */
    double scale;         /* commanded newtons a true one [1]; 0 until DONE */
} vxs_calibration_result;

/* Object. */
typedef struct vxs_calibration vxs_calibration;

/* All but the mass. Thread: any, rt-safe. */
VXS_API void vxs_calibration_config_default(vxs_calibration_config *config);

/* Bytes for vxs_calibration_init(). Thread: any, rt-safe. */
VXS_API size_t vxs_calibration_memory(void);

/* In the caller's memory (any multiple of 16). VXS_OK; VXS_CONFIG; VXS_PARAM; VXS_BUFFER. Thread: any,
 * set-up. */
VXS_API vxs_result vxs_calibration_init(void *memory, size_t size, const vxs_calibration_config *config,
                                        vxs_calibration **out);

/* One sample: *command is always written, zero once it ended. Returns the phase. Thread: the loop's, rt-safe.
 */
VXS_API uint32_t vxs_calibration_tick(vxs_calibration *calibration, const vxs_device_state *state,
                                      vxs_device_command *command);

/* Thread: the loop's, rt-safe. */
VXS_API void vxs_calibration_get(const vxs_calibration *calibration, vxs_calibration_result *result);

#ifdef __cplusplus
}
#endif
#endif
