/* SPDX-License-Identifier: MIT
 *
 * Set-up side of every device: arming and the end.
 */
#include "voxshell/device.h"

vxs_result vxs_device_arm(vxs_device *device)
{
    return device ? device->ops->arm(device->self) : VXS_PARAM;
}

vxs_result vxs_device_disarm(vxs_device *device)
{
    return device ? device->ops->disarm(device->self) : VXS_PARAM;
}

void vxs_device_close(vxs_device *device)
{
    if (device) device->ops->close(device->self);
}
