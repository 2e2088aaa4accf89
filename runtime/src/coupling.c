/* SPDX-License-Identifier: MIT
 *
 * The tick's side of every coupling: guards against what is not finite. rt-safe.
 */
#include "coupling_table.h"

static int is_finite(const vxs_wrench *wrench)
{
    double sum = 0;
    for (int axis = 0; axis < 3; axis++) sum += fabs(wrench->force[axis]) + fabs(wrench->torque[axis]);
    return isfinite(sum);
}

void vxs_coupling_reset(vxs_coupling *coupling, const vxs_pose *device)
{
    coupling->evaluations = 0;
    coupling->depth = 0;
    if (coupling->kind->reset) coupling->kind->reset(coupling, device);
}

void vxs_coupling_pose(const vxs_coupling *coupling, const vxs_pose *device, vxs_pose *object)
{
    if (coupling->kind->pose)
        coupling->kind->pose(coupling, device, object);
    else
        *object = *device;
}

int vxs_coupling_refine(vxs_coupling *coupling, const vxs_wrench *contact, double depth,
                        const vxs_pose *device)
{
    double rotation[9];
    if (!coupling->kind->refine || !is_finite(contact) || !vxs_pose_rotation(device, rotation)) return 0;
    coupling->evaluations++;
    coupling->depth = depth > 0 && isfinite(depth) ? vxs_without_denormals(depth) : 0;
    return coupling->kind->refine(coupling, contact, coupling->depth, device);
}

uint32_t vxs_coupling_step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device,
                           vxs_wrench *out)
{
    double rotation[9];
    if (is_finite(contact) && vxs_pose_rotation(device, rotation)) {
        coupling->kind->step(coupling, contact, device, out);
        if (!coupling->has_torque) memset(out->torque, 0, sizeof out->torque);
        coupling->evaluations = 0;
        coupling->depth = 0;
        if (is_finite(out)) return 0;
    }
    vxs_coupling_reset(coupling, device);
    memset(out, 0, sizeof *out);
    return VXS_COUPLING_INVALID;
}
