/* SPDX-License-Identifier: MIT
 *
 * The tick's side of every device. rt-safe.
 */
#include "voxshell/device.h"

#include <math.h>

void vxs_device_exchange(vxs_device *device, const vxs_device_command *command, vxs_device_state *state,
                         vxs_device_report *report)
{
    device->ops->exchange(device->self, command, state, report);
}

double vxs_device_command_share(const vxs_device_command *command, int64_t now_ns)
{
    if (now_ns >= command->expires_ns) return 0;
    if (now_ns <= command->hold_ns) return 1;
    return (double)(command->expires_ns - now_ns) / (double)(command->expires_ns - command->hold_ns);
}

double vxs_device_clamp_factor(const double v[3], double limit)
{
    double length = sqrt((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
    return limit > 0 && length > limit ? limit / length : 1;
}
