/* SPDX-License-Identifier: MIT
 *
 * The tick's side of every coupling: guards against what is not finite. rt-safe.
 */
#include "coupling_ops.h"

#include <math.h>
#include <string.h>

static int is_finite(const vxs_wrench *wrench)
{
    double sum = 0;
    for (int axis = 0; axis < 3; axis++) sum += fabs(wrench->force[axis]) + fabs(wrench->torque[axis]);
    return isfinite(sum);
}

void vxs_coupling_reset(vxs_coupling *coupling, const vxs_pose *device)
{
    coupling->ops->reset(coupling, device);
}

void vxs_coupling_pose(const vxs_coupling *coupling, const vxs_pose *device, vxs_pose *object)
{
    if (coupling->ops->pose)
        coupling->ops->pose(coupling, object);
    else
        *object = *device;
}

uint32_t vxs_coupling_step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device,
                           vxs_wrench *out)
{
    double rotation[9];
    if (is_finite(contact) && vxs_pose_rotation(device, rotation)) {
        coupling->ops->step(coupling, contact, device, out);
        if (is_finite(out)) return 0;
    }
    coupling->ops->reset(coupling, device);
    memset(out, 0, sizeof *out);
    return VXS_COUPLING_INVALID;
}
