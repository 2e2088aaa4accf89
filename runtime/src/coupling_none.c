/* SPDX-License-Identifier: MIT
 *
 * No coupling: the device feels the collision wrench. rt-safe.
 */
#include "coupling_ops.h"

static void reset(vxs_coupling *coupling, const vxs_pose *device)
{
    (void)coupling;
    (void)device;
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    (void)coupling;
    (void)device;
    *out = *contact;
}

const vxsi_coupling_ops vxsi_coupling_none = {.reset = reset, .step = step};
