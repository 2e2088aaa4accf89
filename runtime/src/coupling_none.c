/* SPDX-License-Identifier: MIT
 *
 * No coupling: the device feels the collision wrench. rt-safe.
 */
#include "coupling_table.h"

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    (void)coupling;
    (void)device;
    *out = *contact;
}

const vxs_coupling_kind vxsi_coupling_none = {.kind = VXS_COUPLING_NONE, .name = "none", .step = step};
