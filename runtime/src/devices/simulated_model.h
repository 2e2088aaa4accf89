/* SPDX-License-Identifier: MIT
 *
 * simulated_model.h - private: the simulated device's memory.
 */
#ifndef VXSI_SIMULATED_MODEL_H
#define VXSI_SIMULATED_MODEL_H

#include "voxshell/simulated.h"

enum { VXSI_SIMULATED_MAX_DELAY = 64 };

typedef struct vxsi_simulated {
    vxs_device device;
    vxs_simulated_config config;
    uint32_t broken;
    int64_t sample_ns;
    double position[3], velocity[3]; /* of the tip, true */
    vxs_device_state heard;          /* the last measurement that got through */
    double hand[3], target[3];       /* where the hand is, and will be after the next sample */
    double orientation[4];
    vxs_device_command command;                       /* the last one taken */
    vxs_device_report line[VXSI_SIMULATED_MAX_DELAY]; /* wrenches on their way, a ring */
    uint32_t line_at;
    uint64_t random;
    uint32_t lost_left;  /* samples to go of a drop-out */
    uint32_t lost_each;  /* of each */
    uint32_t lost_below; /* that a draw of 32 bits begins one */
} vxsi_simulated;

void vxsi_simulated_exchange(void *self, const vxs_device_command *command, vxs_device_state *state,
                             vxs_device_report *report);

/* What the encoder shows at a true position. */
double vxsi_simulated_encode(const vxsi_simulated *simulated, double position);

#endif
