/* SPDX-License-Identifier: MIT
 *
 * simulated.h - the device that needs no hardware: a felt mass with friction, held by an arm.
 *
 * Model, per exchange one sample T in fixed substeps, implicit in all that damps:
 *     (m_device + m_arm) x'' = F - b_device x' - friction - b_arm (x' - x_hand') - k_arm (x - x_hand)
 * F is the command of delay_samples samples ago, clamped to the device's peak by one common
 * factor. The position is read through an encoder: rounded to the nearest step. Time is virtual:
 * each exchange advances it by T, whatever the wall clock does. Double arithmetic, square roots
 * and nothing else: the same trace on any machine.
 *
 * With `noise` a number of normal distribution is added to each axis before the encoder (twelve even ones,
 * summed). With `loss` the link drops out: the measurement stays what it was (sequence, too), and the command
 * before goes on and decays.
 *
 * Force limits, stiffness and resolution of the profiles are recommended values published with
 * CHAI3D; mass, friction and viscosity are assumptions (caps.assumed).
 *
 *     vxs_simulated_config config;
 *     vxs_simulated_config_default(&config, vxs_simulated_profile_named("phantom-premium-1.5"));
 *     vxs_simulated_open(memory, sizeof memory, &config, &device);
 *     vxs_device_arm(device);
 *     for (...) {
 *         vxs_simulated_hand(device, target, NULL);
 *         vxs_device_exchange(device, &command, &state, NULL);
 *         vxs_servo_tick(servo, &state, &command, &row);
 *     }
 */
#ifndef VOXSHELL_SIMULATED_H
#define VOXSHELL_SIMULATED_H

#include "voxshell/device.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A device's tip. View: static. */
typedef struct vxs_simulated_profile {
    const char *name;                    /* "phantom-premium-1.5" */
    double peak_force, continuous_force; /* [N] */
    double peak_torque;                  /* [N m], 0: turns are sensed, not actuated */
    double max_stiffness;                /* [N/m] */
    double max_damping;                  /* [N s/m] */
    double resolution;                   /* [m] */
    double mass, friction, viscosity;    /* [kg], [N], [N s/m]: assumed */
    double rate_hz;                      /* nominal [Hz] */
} vxs_simulated_profile;

/* Who holds it. All assumed. View: static. */
typedef struct vxs_simulated_arm {
    const char *name; /* "free" (nobody), "pen" (light grip), "hand", "arm" */
    double mass;      /* [kg], added to the device's */
    double viscosity; /* to the hand's target [N s/m] */
    double stiffness; /* to the hand's target [N/m] */
} vxs_simulated_arm;

/* By name; NULL for none such. By number from 0 on; NULL at the end. Thread: any, rt-safe. */
VXS_API const vxs_simulated_profile *vxs_simulated_profile_named(const char *name);
VXS_API const vxs_simulated_profile *vxs_simulated_profile_at(uint32_t index);
VXS_API const vxs_simulated_arm *vxs_simulated_arm_named(const char *name);
VXS_API const vxs_simulated_arm *vxs_simulated_arm_at(uint32_t index);

/* Config. */
typedef struct vxs_simulated_config {
    uint32_t struct_size;
    uint32_t delay_samples; /* 1 .. 64: a command acts so many samples after its exchange; default 1 */
    uint32_t substeps;      /* 1 .. 1000 per sample; default 16 */
    uint32_t reserved;
    vxs_simulated_profile profile; /* copied */
    vxs_simulated_arm arm;         /* copied; default "hand" */
    double sample_time;            /* T [s], 1e-5 .. 0.1; default 1 / profile.rate_hz */
    vxs_pose start;                /* of device and hand, at rest; default identity */
    double noise;     /* [m] >= 0: standard deviation of what each axis is measured with; default 0 */
    double loss;      /* 0 .. 0.9: share of samples in which neither side hears the other; default 0 */
    double loss_time; /* [s] 0 .. 10: how long each such drop-out lasts; 0 (default): one sample */
    uint64_t seed;    /* of noise and loss: the same numbers, the same trace on any machine; default 1 */
} vxs_simulated_config;

/* Fills all from a profile; NULL takes "phantom-premium-1.5". Thread: any, rt-safe. */
VXS_API void vxs_simulated_config_default(vxs_simulated_config *config, const vxs_simulated_profile *profile);

/* Bytes for vxs_simulated_open(). Thread: any, rt-safe. */
VXS_API size_t vxs_simulated_memory(void);

/* Opens in the caller's memory (any multiple of 16), which must stay until vxs_device_close().
 * The device is READY. VXS_OK; VXS_CONFIG; VXS_PARAM; VXS_BUFFER. Thread: any, set-up. */
VXS_API vxs_result vxs_simulated_open(void *memory, size_t size, const vxs_simulated_config *config,
                                      vxs_device **out);

/* Where the hand wants to be at the end of the next sample [m], and how it holds the device
 * (w x y z, NULL: as before; the device turns with the hand at once). The hand moves there
 * evenly. Numbers that are not finite are not taken. Only for a simulated device.
 * Thread: the one that exchanges, rt-safe. */
VXS_API void vxs_simulated_hand(vxs_device *device, const double position[3], const double *orientation);

/* Where the tip really is, before the encoder [m], and how fast [m/s]; either may be NULL.
 * Thread: the one that exchanges, rt-safe. */
VXS_API void vxs_simulated_truth(const vxs_device *device, double position[3], double velocity[3]);

/* For tests of what stands above: the next exchange gives a pose that is not finite
 * (VXS_DEVICE_FAULT_SOFTWARE), or the device is GONE for good (VXS_DEVICE_FAULT_USB).
 * Thread: the one that exchanges, rt-safe. */
VXS_API void vxs_simulated_break(vxs_device *device, uint32_t fault);

#ifdef __cplusplus
}
#endif
#endif
