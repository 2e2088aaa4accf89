/* SPDX-License-Identifier: MIT
 *
 * voxmap.h - what a .voxmap file holds (formats/voxmap.md): the static scene as cells
 * of state free, surface or interior, and optional channels.
 *
 * Three levels, all dense and directly indexed, so that a look-up is three loads:
 *   ROOT  one u32 per chunk of 64^3 cells in the box      -> chunk, or a uniform state
 *   CHNK  512 u32 per chunk, one per brick of 8^3 cells   -> brick, or a uniform state
 *   BRIK  128 bytes per brick, two bits per cell (vxs_voxmap_brick_state)
 * A u32 entry below VXS_VOXMAP_ENTRY_FIRST is a uniform state (0 free, 2 interior);
 * otherwise entry - VXS_VOXMAP_ENTRY_FIRST is the index of a chunk or a brick.
 */
#ifndef VOXSHELL_FORMAT_VOXMAP_H
#define VOXSHELL_FORMAT_VOXMAP_H

#include "voxshell/format/container.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    VXS_VOXMAP_VERSION_MAJOR = 1,       /* of the format */
    VXS_VOXMAP_VERSION_MINOR = 0,       /* of the format */
    VXS_VOXMAP_BRICK_CELLS = 8,         /* per axis */
    VXS_VOXMAP_CHUNK_BRICKS = 8,        /* per axis */
    VXS_VOXMAP_CHUNK_CELLS = 64,        /* per axis */
    VXS_VOXMAP_CHUNK_ENTRIES = 512,     /* bricks of a chunk */
    VXS_VOXMAP_BRICK_WORDS = 16,        /* u64 per brick of state bits */
    VXS_VOXMAP_ENTRY_FIRST = 4,         /* entries below are uniform states */
    VXS_VOXMAP_MAX_CELLS = 1 << 20,     /* per axis of the box (M204) */
    VXS_VOXMAP_MAX_ROOT = 1 << 24,      /* root entries (M205) */
    VXS_VOXMAP_MAX_BRICKS = 1 << 28,    /* M206 */
    VXS_VOXMAP_MAX_LAYERS = 126,        /* layer_count; layer_count + 1 means beyond (M401) */
    VXS_VOXMAP_CLEARANCE_BLOCKS = 4096, /* blocks of 4 x 4 x 4 cells in a chunk, one clearance each */
    VXS_VOXMAP_CLEARANCE_BEYOND = 127,  /* half cells: as far as a block's clearance says anything (M502) */
    VXS_VOXMAP_CLEARANCE_LEAST = 96,    /* cells: a chunk's clearance is at least, */
    VXS_VOXMAP_CLEARANCE_MOST = 4096,   /* and at most that (M503) */
    VXS_VOXMAP_PLANE_REACH = 8,         /* cells: how far around a brick's centre its plane is one */
    VXS_VOXMAP_PLANE_STEP = 16,         /* of a plane's offset, in cells times its normal's length */
    VXS_VOXMAP_PLANE_NORMAL = 127       /* the largest component of a plane's normal (M504) */
};

/* Every cell index of the box is in [-VXS_VOXMAP_MAX_INDEX, VXS_VOXMAP_MAX_INDEX) (M202). */
#define VXS_VOXMAP_MAX_INDEX (INT64_C(1) << 44)

/* The state of a cell, two bits. 3 is never written (M305). */
enum { VXS_CELL_FREE = 0, VXS_CELL_SURFACE = 1, VXS_CELL_INTERIOR = 2 };

#define VXS_VOXMAP_SECTION_GRID VXS_SECTION_ID('G', 'R', 'I', 'D') /* 1 x vxs_voxmap_grid */
#define VXS_VOXMAP_SECTION_ROOT VXS_SECTION_ID('R', 'O', 'O', 'T') /* u32 */
#define VXS_VOXMAP_SECTION_CHNK VXS_SECTION_ID('C', 'H', 'N', 'K') /* u32[512] */
#define VXS_VOXMAP_SECTION_BRIK VXS_SECTION_ID('B', 'R', 'I', 'K') /* u64[16] */
/* Optional channels, parallel to BRIK: one element per brick. A map with channels also
 * materialises the bricks of the channel's band (their cells may all be free). */
#define VXS_VOXMAP_SECTION_LAYR VXS_SECTION_ID('L', 'A', 'Y', 'R') /* i8[512]; 0 surface, > 0 free */
#define VXS_VOXMAP_SECTION_DIST VXS_SECTION_ID('D', 'I', 'S', 'T') /* i16[512]; x distance_step */
/* Optional trio that lets a reader pass over points without looking at their cells. The index has an
 * entry per root entry: uniform with all chunks around (0 free, 2 interior), or VXS_VOXMAP_ENTRY_FIRST +
 * element of CLRV. There a block's value v says: the ball of |v| / 2 cells around the block's centre holds
 * free cells only (v > 0), or interior ones only (v < 0); 0 says nothing. CLRC says the same of the ball of
 * |v| cells around the chunk's centre, where the index is uniform. */
#define VXS_VOXMAP_SECTION_CLRX VXS_SECTION_ID('C', 'L', 'R', 'X') /* u32 */
#define VXS_VOXMAP_SECTION_CLRV VXS_SECTION_ID('C', 'L', 'R', 'V') /* i8[4096] */
#define VXS_VOXMAP_SECTION_CLRC VXS_SECTION_ID('C', 'L', 'R', 'C') /* i32 */
/* Optional, with that trio, parallel to CHNK: for each brick of a chunk a plane with all its cells that are
 * not free on the far side. Of the points x within VXS_VOXMAP_PLANE_REACH cells of the brick's centre c,
 * those with n . (x - c) < VXS_VOXMAP_PLANE_STEP s are in free cells [cells]. */
#define VXS_VOXMAP_SECTION_CLRP VXS_SECTION_ID('C', 'L', 'R', 'P') /* vxs_voxmap_plane[512] */

/* One of CLRP. */
typedef struct vxs_voxmap_plane {
    int8_t normal[3]; /* n, of any length */
    int8_t offset;    /* s; n = 0 with s = 0: all is free, with s = -1: says nothing */
} vxs_voxmap_plane;

/* Where the box is, and what is in it. */
typedef struct vxs_voxmap_grid {
    double voxel;            /* edge h of a cell [m], finite, > 0 */
    int64_t origin_cell[3];  /* cell of the box's min corner; multiple of 64 */
    uint32_t root_dims[3];   /* the box in chunks, >= 1 */
    uint32_t layer_count;    /* L of the layer channel, 0 without it */
    uint64_t surface_cells;  /* how many there are */
    uint64_t interior_cells; /* how many there are */
    int64_t bbox_min[3];     /* cells: tight box of the surface and interior cells, */
    int64_t bbox_max[3];     /* max inclusive */
    double distance_step;    /* [m] per unit of DIST, 0 without it */
    double distance_band;    /* [m] |distance| the channel represents, 0 without it */
    double distance_error;   /* [m] largest error of a stored distance */
    uint32_t flags;          /* VXS_VOXMAP_FLAG_* */
    uint32_t reserved;       /* 0 */
    uint8_t pad[48];         /* 0 */
} vxs_voxmap_grid;

enum {
    VXS_VOXMAP_FLAG_CLOSED = 1,  /* the source mesh had no boundary edge */
    VXS_VOXMAP_FLAG_UNSIGNED = 2 /* DIST carries no sign: an open part */
};

VXS_STATIC_ASSERT(sizeof(vxs_voxmap_plane) == 4, "plane is 4 bytes");
VXS_STATIC_ASSERT(sizeof(vxs_voxmap_grid) == 192, "grid is 192 bytes");
VXS_STATIC_ASSERT(offsetof(vxs_voxmap_grid, origin_cell) == 8, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_voxmap_grid, root_dims) == 32, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_voxmap_grid, surface_cells) == 48, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_voxmap_grid, bbox_min) == 64, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_voxmap_grid, distance_step) == 112, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_voxmap_grid, flags) == 136, "layout");

/* Index arithmetic, the same for writer, reader and kernels. Axis order i, j, k; k runs
 * fastest. ci, cj, ck: cell relative to origin_cell, not negative. */
static inline uint64_t vxs_voxmap_root_index(const uint32_t dims[3], uint32_t ci, uint32_t cj, uint32_t ck)
{
    return ((uint64_t)(ci >> 6) * dims[1] + (cj >> 6)) * dims[2] + (ck >> 6);
}
static inline uint32_t vxs_voxmap_chunk_slot(uint32_t ci, uint32_t cj, uint32_t ck)
{
    return ((ci >> 3) & 7u) << 6 | ((cj >> 3) & 7u) << 3 | ((ck >> 3) & 7u);
}
static inline uint32_t vxs_voxmap_clearance_block(uint32_t ci, uint32_t cj, uint32_t ck)
{
    return ((ci >> 2) & 15u) << 8 | ((cj >> 2) & 15u) << 4 | ((ck >> 2) & 15u);
}
static inline uint32_t vxs_voxmap_brick_cell(uint32_t ci, uint32_t cj, uint32_t ck)
{
    return (ci & 7u) << 6 | (cj & 7u) << 3 | (ck & 7u);
}
/* State (VXS_CELL_*) of cell `cell` (vxs_voxmap_brick_cell) of the brick with these 16 words. */
static inline uint32_t vxs_voxmap_brick_state(const uint64_t *words, uint32_t cell)
{
    return (uint32_t)(words[cell >> 5] >> ((cell & 31u) << 1)) & 3u;
}

#ifdef __cplusplus
}
#endif
#endif
