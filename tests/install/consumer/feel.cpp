// SPDX-License-Identifier: MIT
#include <voxshell/voxshell.h>

#include <iostream>

int main(int argc, char **argv)
{
    vxs_asset asset;
    if (argc != 2 || vxs_asset_open(argv[1], nullptr, &asset, nullptr) != VXS_OK) return 1;
    vxs_voxmap map;
    if (vxs_voxmap_open(&asset, &map) != VXS_OK) return 1;
    std::cout << (vxs_version() >> 16) << " voxel " << map.voxel << " m\n";
    vxs_asset_close(&asset);
}
