/* SPDX-License-Identifier: MIT
 *
 * Torque on the hand. It is no stage of its own: coupling and clamp do their second half where it is asked
 * for.
 */
#include "../coupling_table.h"
#include "../servo_state.h"

static void attach(void *self, vxs_servo *servo)
{
    (void)self;
    servo->has_torque = servo->coupling->has_torque = 1;
}

extern const vxs_effect_kind vxsi_stage_torque;
const vxs_effect_kind vxsi_stage_torque = {.effect = VXS_EFFECT_TORQUE,
                                           .name = "torque",
                                           .reads = "torques",
                                           .changes = "coupling, clamp",
                                           .attach = attach};
