/* SPDX-License-Identifier: MIT */
#include "voxshell/pointshell.h"

#include <string.h>

static const void *bytes_of(const vxs_asset *asset, uint32_t id)
{
    return asset->data + vxs_asset_section(asset, id)->offset;
}

vxs_result vxs_pointshell_open(const vxs_asset *asset, vxs_pointshell *out)
{
    if (!asset || !out || !asset->data) return VXS_PARAM;
    if (asset->kind != VXS_ASSET_POINTSHELL) return VXS_KIND;
    const vxs_container_section *area = vxs_asset_section(asset, VXS_POINTSHELL_SECTION_AREA);
    const vxs_pointshell_info *info = bytes_of(asset, VXS_POINTSHELL_SECTION_SHEL);
    *out = (vxs_pointshell){
        .voxel = info->voxel,
        .kind = info->kind,
        .point_count = info->point_count,
        .padded_count = info->padded_count,
        .cluster_count = info->cluster_count,
        .x = bytes_of(asset, VXS_POINTSHELL_SECTION_POSX),
        .y = bytes_of(asset, VXS_POINTSHELL_SECTION_POSY),
        .z = bytes_of(asset, VXS_POINTSHELL_SECTION_POSZ),
        .nx = bytes_of(asset, VXS_POINTSHELL_SECTION_NRMX),
        .ny = bytes_of(asset, VXS_POINTSHELL_SECTION_NRMY),
        .nz = bytes_of(asset, VXS_POINTSHELL_SECTION_NRMZ),
        .area = area ? (const float *)(const void *)(asset->data + area->offset) : NULL,
        .clusters = bytes_of(asset, VXS_POINTSHELL_SECTION_CLUS),
        .radius = info->radius,
        .total_area = info->area,
        .gap_max = info->gap_max,
        .surface_error = info->surface_error,
    };
    memcpy(out->center, info->center, sizeof out->center);
    return VXS_OK;
}
