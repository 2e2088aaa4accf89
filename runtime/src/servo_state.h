/* SPDX-License-Identifier: MIT
 *
 * servo_state.h - private: the servo's memory.
 */
#ifndef VXSI_SERVO_STATE_H
#define VXSI_SERVO_STATE_H

#include "voxshell/servo.h"

/* OFF: the device is not armed. BLOCKED: armed, but not free yet. LIVE: forces flow. */
enum { VXSI_SERVO_IS_OFF, VXSI_SERVO_IS_BLOCKED, VXSI_SERVO_IS_LIVE };

struct vxs_servo {
    vxs_servo_config config; /* defaults resolved */
    vxs_contact *contact;
    vxs_coupling *coupling;
    double mount[9]; /* rotation device -> scene */
    int64_t hold_ns, decay_ns, sample_ns;
    uint32_t phase; /* VXSI_SERVO_IS_* */
    uint32_t has_fault;
    uint32_t has_last;
    uint64_t tick;
    uint64_t last_sequence;
    int64_t last_time_ns, last_news_ns; /* of the last tick; of the last new measurement */
    vxs_pose last_pose;                 /* of the device, at */
    int64_t last_pose_ns;
    double gain;       /* of the ramp */
    vxs_wrench shaped; /* last after slew and clamp, device frame */
    vxs_device_command command;
};

#endif
