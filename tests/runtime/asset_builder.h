/* SPDX-License-Identifier: MIT
 *
 * asset_builder.h - valid .voxmap and .pointshell bytes from analytic shapes, made from the
 * specs alone (no code of tools or runtime), and ways to damage them.
 */
#ifndef VXS_TEST_ASSET_BUILDER_H
#define VXS_TEST_ASSET_BUILDER_H

#include "voxshell/voxshell.h"

/* Bytes of a file on the heap, 64-byte aligned and of exactly that size. */
typedef struct built_asset {
    uint8_t *data;
    size_t size;
} built_asset;

void built_free(built_asset *asset);

/* A copy of the first `size` bytes, aligned, in a block of exactly that size. */
built_asset built_prefix(const built_asset *asset, size_t size);

/* Makes all checksums right again after a change. Sections that leave the file are passed over. */
void built_seal(built_asset *asset);

/* The file's table entry and bytes of a section; stops the test if it is not there. */
vxs_container_section *built_entry(const built_asset *asset, uint32_t id);
void *built_bytes(const built_asset *asset, uint32_t id);

/* Channels of a map. */
enum { BUILT_PLAIN = 0, BUILT_LAYERS = 1, BUILT_DISTANCES = 2 };

/* State of an absolute cell. */
typedef uint32_t built_cells(const void *shape, int64_t i, int64_t j, int64_t k);

/* A map of the cells low .. high (inclusive); outside them all is free. */
built_asset build_voxmap(double voxel, const int64_t low[3], const int64_t high[3], built_cells *cells,
                         const void *shape, int channels);

/* A map with both channels from a signed distance (> 0 outside) of the points [m]: surface cells are those
 * that its tangent plane meets, rings are counted from them, and distances reach as far. reach: 1 .. 7 cells;
 * low and high must hold all cells but free ones. */
typedef double built_distance(const void *shape, const double point[3]);
built_asset build_field_map(double voxel, const int64_t low[3], const int64_t high[3],
                            built_distance *distance, const void *shape, int reach);

/* Shapes. A ball: surface cells meet its surface, interior cells lie within. */
typedef struct built_ball {
    double voxel, center[3], radius;
} built_ball;
built_asset build_ball_map(const built_ball *ball, int channels);

/* Solid below: cells j < layer are interior, j == layer surface, for |i|, |k| <= reach and
 * layer - depth <= j. */
typedef struct built_floor {
    int64_t layer, reach, depth;
} built_floor;
built_asset build_floor_map(double voxel, const built_floor *shape, int channels);

/* Surface cells at k == low and k == high, free between: a slot for opposed normals. */
typedef struct built_slot {
    int64_t low, high, reach;
} built_slot;
built_asset build_slot_map(double voxel, const built_slot *slot);

typedef struct built_point {
    float position[3], normal[3], area;
} built_point;
built_asset build_pointshell(double voxel, const built_point *points, uint32_t count);

/* `count` points spread over a ball by a spiral, normals inwards, equal areas. */
built_asset build_ball_shell(double voxel, double radius, uint32_t count);

/* A box of these half edges about the origin: on each face count[a] x count[b] points amid as many
 * rectangles, normals inwards. */
built_asset build_block_shell(double voxel, const double half[3], const int count[3]);

/* Opens the bytes; stops the test if they are refused. */
vxs_voxmap open_voxmap(const built_asset *asset);
vxs_pointshell open_pointshell(const built_asset *asset);

#endif
