/* SPDX-License-Identifier: MIT
 *
 * replay_model.h - private: the replay device's memory.
 */
#ifndef VXSI_REPLAY_MODEL_H
#define VXSI_REPLAY_MODEL_H

#include "voxshell/replay.h"

typedef struct vxsi_replay {
    vxs_device device;
    vxs_replay_config config;
    uint32_t state, fault;
    uint64_t sequence;
    int64_t time_ns, sample_ns;
    size_t at; /* row that was passed last */
    double last[3];
} vxsi_replay;

void vxsi_replay_exchange(void *self, const vxs_device_command *command, vxs_device_state *state,
                          vxs_device_report *report);

#endif
