/* SPDX-License-Identifier: MIT */
#include "voxshell/voxshell.h"

/* The build's version and the header's are one. */
_Static_assert(VXS_VERSION_MAJOR == VXSI_BUILD_MAJOR && VXS_VERSION_MINOR == VXSI_BUILD_MINOR &&
                   VXS_VERSION_PATCH == VXSI_BUILD_PATCH,
               "voxshell.h and CMakeLists.txt name different versions");

uint32_t vxs_version(void)
{
    return VXS_VERSION_MAJOR << 16 | VXS_VERSION_MINOR << 8 | VXS_VERSION_PATCH;
}
