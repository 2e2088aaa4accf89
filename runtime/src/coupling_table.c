/* SPDX-License-Identifier: MIT
 *
 * The table of couplings: one line a kind.
 */
#include "coupling_table.h"

extern const vxs_coupling_kind vxsi_coupling_none, vxsi_coupling_pt2, vxsi_coupling_spring_damper,
    vxsi_coupling_quasi_static;

const vxs_coupling_kind *const vxsi_coupling_kinds[] = {
    &vxsi_coupling_none, &vxsi_coupling_pt2, &vxsi_coupling_spring_damper, &vxsi_coupling_quasi_static, NULL,
};
