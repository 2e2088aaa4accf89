/* SPDX-License-Identifier: MIT */
#include <voxshell/hardware.h>
#include <voxshell/voxshell.h>

#include <stdio.h>

int main(int argc, char **argv)
{
    vxs_asset asset;
    vxs_asset_issue issue;
    if (argc != 2 || vxs_asset_open(argv[1], NULL, &asset, &issue) != VXS_OK) return 1;
    vxs_voxmap map;
    if (vxs_voxmap_open(&asset, &map) != VXS_OK) return 1;
    printf("%u.%u voxel %.17g m, hvlink: %d\n", (unsigned)(vxs_version() >> 16),
           (unsigned)(vxs_version() >> 8 & 255), map.voxel, vxs_hardware_kind_named("hvlink") != NULL);
    vxs_asset_close(&asset);
    return 0;
}
