/* SPDX-License-Identifier: MIT
 *
 * voxmap.h - look up the static scene: state of a cell, cell of a point.
 *
 * Source: METHOD section 1 (paper section 2); bytes: formats/voxmap.md. Cell (i,j,k) is the
 * half-open box [h i, h (i+1)) x ... of the map's frame [m]. Relative cells count from
 * origin_cell, so that they are small and never negative inside the box. A look-up costs
 * three loads, whatever the number of parts or triangles.
 */
#ifndef VOXSHELL_VOXMAP_H
#define VOXSHELL_VOXMAP_H

#include "voxshell/asset.h"
#include "voxshell/format/voxmap.h"

#ifdef __cplusplus
extern "C" {
#endif

/* View: borrowed from the asset, valid until vxs_asset_close(). Plain; copy it freely. */
typedef struct vxs_voxmap {
    double voxel;                    /* edge h of a cell [m] */
    int64_t origin_cell[3];          /* absolute cell of the box's min corner */
    uint32_t cells[3];               /* extent of the box [cells] */
    uint32_t root_dims[3];           /* extent of the box [chunks of 64 cells] */
    const uint32_t *root;            /* one entry per chunk */
    const uint32_t *chunks;          /* 512 entries per chunk */
    const uint64_t *bricks;          /* 16 words per brick, two bits a cell */
    const int8_t *layers;            /* 512 per brick, or NULL without the channel */
    const int16_t *distances;        /* 512 per brick, or NULL without the channel */
    const uint32_t *clearance_index; /* one entry per chunk of the box, or NULL: nothing can be culled */
    const int8_t *clearance;         /* 4096 per entry from VXS_VOXMAP_ENTRY_FIRST on; half cells */
    const int32_t *clearance_chunks; /* one per chunk of the box; cells */
    const vxs_voxmap_plane *planes;  /* 512 per chunk, one per brick, or NULL */
    uint64_t chunk_count, brick_count, clearance_count; /* elements of chunks, bricks, clearance */
    uint64_t surface_cells, interior_cells;             /* how many there are */
    int64_t bbox_min[3], bbox_max[3]; /* absolute cells, max inclusive: surface and interior */
    uint32_t layer_count;             /* 0 without the channel */
    uint32_t flags;                   /* VXS_VOXMAP_FLAG_* */
    double distance_step;             /* [m] per unit of distances */
    double distance_band;             /* largest |distance| that the channel holds [m] */
    double distance_error;            /* of a stored distance, at most [m] */
} vxs_voxmap;

/* The view of an open asset. Returns VXS_OK; VXS_PARAM for NULL or a closed asset; VXS_KIND
 * for an asset of another kind. Thread: any, set-up (but does no work that blocks). */
VXS_API vxs_result vxs_voxmap_open(const vxs_asset *asset, vxs_voxmap *out);

/* The absolute cell that contains the point p [m, map frame]. Returns 1; 0 (and cell
 * untouched) for a point that is not finite or beyond +-2^62 cells. Thread: any, rt-safe. */
VXS_API int vxs_voxmap_cell_of(const vxs_voxmap *map, const double p[3], int64_t cell[3]);

/* The entry that decides a relative cell: a uniform state (below VXS_VOXMAP_ENTRY_FIRST), or
 * VXS_VOXMAP_ENTRY_FIRST + index of its brick. The cell must be inside the box.
 * Thread: any, rt-safe. */
static inline uint32_t vxs_voxmap_entry(const vxs_voxmap *map, uint32_t ci, uint32_t cj, uint32_t ck)
{
    uint32_t entry = map->root[vxs_voxmap_root_index(map->root_dims, ci, cj, ck)];
    if (entry < VXS_VOXMAP_ENTRY_FIRST) return entry;
    return map->chunks[(size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES +
                       vxs_voxmap_chunk_slot(ci, cj, ck)];
}

/* VXS_CELL_FREE, _SURFACE or _INTERIOR of a relative cell; outside the box all is free.
 * Thread: any, rt-safe. */
static inline uint32_t vxs_voxmap_state(const vxs_voxmap *map, uint32_t ci, uint32_t cj, uint32_t ck)
{
    if (ci >= map->cells[0] || cj >= map->cells[1] || ck >= map->cells[2]) return VXS_CELL_FREE;
    uint32_t entry = vxs_voxmap_entry(map, ci, cj, ck);
    if (entry < VXS_VOXMAP_ENTRY_FIRST) return entry;
    uint32_t cell = vxs_voxmap_brick_cell(ci, cj, ck);
    uint64_t word =
        map->bricks[(size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_BRICK_WORDS + (cell >> 5)];
    return (uint32_t)(word >> ((cell & 31u) << 1)) & 3u;
}

/* The clearance at a relative cell: the radius [cells] of a ball that holds free cells only (> 0), or,
 * negative, interior ones only; 0 says nothing. It is around the centre of the aligned cube of *size cells
 * an edge that holds the cell: a block (4) near a surface, a chunk (64) far from it. The cell must be inside
 * the box, and the map must have a clearance. Thread: any, rt-safe. */
static inline float vxs_voxmap_clearance(const vxs_voxmap *map, uint32_t ci, uint32_t cj, uint32_t ck,
                                         uint32_t *size)
{
    uint64_t chunk = vxs_voxmap_root_index(map->root_dims, ci, cj, ck);
    uint32_t entry = map->clearance_index[chunk];
    *size = entry < VXS_VOXMAP_ENTRY_FIRST ? VXS_VOXMAP_CHUNK_CELLS : 4;
    if (entry < VXS_VOXMAP_ENTRY_FIRST) return (float)map->clearance_chunks[chunk];
    return 0.5f *
           (float)map->clearance[(size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CLEARANCE_BLOCKS +
                                 vxs_voxmap_clearance_block(ci, cj, ck)];
}

/* vxs_voxmap_state() of an absolute cell. Thread: any, rt-safe. */
static inline uint32_t vxs_voxmap_state_at(const vxs_voxmap *map, int64_t i, int64_t j, int64_t k)
{
    uint64_t ci = (uint64_t)i - (uint64_t)map->origin_cell[0];
    uint64_t cj = (uint64_t)j - (uint64_t)map->origin_cell[1];
    uint64_t ck = (uint64_t)k - (uint64_t)map->origin_cell[2];
    if (ci >= map->cells[0] || cj >= map->cells[1] || ck >= map->cells[2]) return VXS_CELL_FREE;
    return vxs_voxmap_state(map, (uint32_t)ci, (uint32_t)cj, (uint32_t)ck);
}

#ifdef __cplusplus
}
#endif
#endif
