/* SPDX-License-Identifier: MIT
 *
 * servo_stage.h - private: the stages of a tick (effect_kind.h) that are voxshell's. An effect is
 * src/effects/NAME.c and one row of servo_table.c; taking both away takes the effect away and nothing else. Its
 * file is part of the tick. A long set-up stands in NAME_setup.c, which is not.
 */
#ifndef VXSI_SERVO_STAGE_H
#define VXSI_SERVO_STAGE_H

#include "voxshell/effect_kind.h"

/* Flags that end the list. */
enum { VXSI_TICK_ENDS = VXS_SERVO_OFF | VXS_SERVO_START_IN_CONTACT | VXS_SERVO_FAULT };

/* In order of execution. */
extern const vxs_effect_kind *const vxsi_servo_table[];
extern const uint32_t vxsi_servo_table_size;

/* A body's stability: stiffness x compliance x T^2 is at most this, of contact (which contact-damping may
 * make stiffer) and of each effect. Kick and drift end at 4 of all together. */
#define VXSI_CONTACT_SHARE 0.25
#define VXSI_EFFECT_SHARE 1.0

enum { VXSI_STAGE_MOST = 32 };

/* The row of an effect, NULL for none such. */
const vxs_effect_kind *vxsi_stage_of(uint32_t effect);

/* The row of an effect, or its own kind. NULL: there is none. */
const vxs_effect_kind *vxsi_effect_kind_of(const vxs_effect *effect);

/* The row that an own kind runs before; the table's size: none that it may. */
uint32_t vxsi_own_place(const vxs_effect_kind *kind);

#endif
