/* SPDX-License-Identifier: MIT
 *
 * The stages of a tick in their order: one row each. Those without a kind (effect.h) are always there.
 */
#include "servo_stage.h"

#define TABLE                                                                                                \
    ROW(motion)                                                                                              \
    ROW(contact)                                                                                             \
    ROW(start_inside)                                                                                        \
    ROW(contact_damping)                                                                                     \
    ROW(friction)                                                                                            \
    ROW(gravity)                                                                                             \
    ROW(viscosity)                                                                                           \
    ROW(proximity)                                                                                           \
    ROW(workspace)                                                                                           \
    ROW(inertia)                                                                                             \
    ROW(torque)                                                                                              \
    ROW(coupling)                                                                                            \
    ROW(passivity)                                                                                           \
    ROW(slew)                                                                                                \
    ROW(clamp)                                                                                               \
    ROW(soft_start)

#define ROW(name) extern const vxs_effect_kind vxsi_stage_##name;
TABLE
#undef ROW

#define ROW(name) &vxsi_stage_##name,
const vxs_effect_kind *const vxsi_servo_table[] = {TABLE};
const uint32_t vxsi_servo_table_size = sizeof vxsi_servo_table / sizeof *vxsi_servo_table;

_Static_assert(sizeof vxsi_servo_table / sizeof *vxsi_servo_table <= VXSI_STAGE_MOST,
               "a servo holds them all");
