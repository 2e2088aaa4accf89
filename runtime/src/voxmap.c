/* SPDX-License-Identifier: MIT */
#include "voxshell/voxmap.h"

#include <math.h>
#include <string.h>

static const void *bytes_of(const vxs_asset *asset, uint32_t id, uint64_t *count)
{
    const vxs_container_section *section = vxs_asset_section(asset, id);
    if (count) *count = section ? section->count : 0;
    return section ? asset->data + section->offset : NULL;
}

vxs_result vxs_voxmap_open(const vxs_asset *asset, vxs_voxmap *out)
{
    if (!asset || !out || !asset->data) return VXS_PARAM;
    if (asset->kind != VXS_ASSET_VOXMAP) return VXS_KIND;
    const vxs_voxmap_grid *grid = bytes_of(asset, VXS_VOXMAP_SECTION_GRID, NULL);
    memset(out, 0, sizeof *out);
    out->voxel = grid->voxel;
    for (int axis = 0; axis < 3; axis++) {
        out->origin_cell[axis] = grid->origin_cell[axis];
        out->root_dims[axis] = grid->root_dims[axis];
        out->cells[axis] = grid->root_dims[axis] * VXS_VOXMAP_CHUNK_CELLS;
        out->bbox_min[axis] = grid->bbox_min[axis];
        out->bbox_max[axis] = grid->bbox_max[axis];
    }
    out->root = bytes_of(asset, VXS_VOXMAP_SECTION_ROOT, NULL);
    out->chunks = bytes_of(asset, VXS_VOXMAP_SECTION_CHNK, &out->chunk_count);
    out->bricks = bytes_of(asset, VXS_VOXMAP_SECTION_BRIK, &out->brick_count);
    out->layers = bytes_of(asset, VXS_VOXMAP_SECTION_LAYR, NULL);
    out->distances = bytes_of(asset, VXS_VOXMAP_SECTION_DIST, NULL);
    out->clearance_index = bytes_of(asset, VXS_VOXMAP_SECTION_CLRX, NULL);
    out->clearance = bytes_of(asset, VXS_VOXMAP_SECTION_CLRV, &out->clearance_count);
    out->clearance_chunks = bytes_of(asset, VXS_VOXMAP_SECTION_CLRC, NULL);
    out->planes = bytes_of(asset, VXS_VOXMAP_SECTION_CLRP, NULL);
    out->surface_cells = grid->surface_cells;
    out->interior_cells = grid->interior_cells;
    out->layer_count = grid->layer_count;
    out->flags = grid->flags;
    out->distance_step = grid->distance_step;
    out->distance_band = grid->distance_band;
    out->distance_error = grid->distance_error;
    return VXS_OK;
}

int vxs_voxmap_cell_of(const vxs_voxmap *map, const double p[3], int64_t cell[3])
{
    const double limit = 4611686018427387904.0; /* 2^62 */
    int64_t found[3];
    for (int axis = 0; axis < 3; axis++) {
        double u = floor(p[axis] / map->voxel);
        if (!(u >= -limit && u <= limit)) return 0;
        found[axis] = (int64_t)u;
    }
    memcpy(cell, found, sizeof found);
    return 1;
}
