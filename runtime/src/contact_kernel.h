/* SPDX-License-Identifier: MIT
 *
 * What the instruction sets of contact share: three steps, each the same to the last bit in every
 * kernel. cull and clear: which bounding spheres and discs meet nothing. probe: which points are in which
 * cells, in float32 (contact.h says how it is rounded). sample, mean and sum: over the points found, in
 * double, in eight interleaved sums (hit n goes to sum n mod 8) that are added as ((0 + 1) + (2 + 3)) + ((4 +
 * 5) + (6 + 7)).
 */
#ifndef VXSI_CONTACT_KERNEL_H
#define VXSI_CONTACT_KERNEL_H

#include "voxshell/contact.h"

/* The shell's motion in cells of a map's box, float32, and what rounding can cost. */
typedef struct vxsi_motion {
    float m[9], b[3];
    float scale;  /* cells per metre, rounded up */
    float margin; /* [cells] bounds the rounding of any u of the shell, and more */
} vxsi_motion;

/* What the probe does with a point that is not in a free cell. */
enum {
    VXSI_TAKE_AREA = 1,     /* keep areas too */
    VXSI_TAKE_INTERIOR = 2, /* points in interior cells are hits; else they are only counted */
    VXSI_TAKE_NORMAL = 4
};

/* The chunk that the last points were in, in which the next ones mostly are too. */
typedef struct vxsi_chunk {
    uint32_t at[3]; /* its first cell */
    uint32_t entry; /* of the map's root */
} vxsi_chunk;

/* The 2 x 2 x 2 chunks around them, for a kernel to whom the way through the root is a long one. */
typedef struct vxsi_cube {
    int32_t at[3];     /* its first cell, of a chunk that may lie outside the box */
    uint32_t entry[8]; /* the state of a chunk that is uniform; else 2^31 + where its entries begin */
} vxsi_cube;
enum { VXSI_NOWHERE = INT32_MIN / 2 }; /* cube.at[0]: far from every cell (below 2^20) and from INT32_MIN */

/* Points found, structure of arrays, in point order. Each array has room for capacity +
 * VXSI_LANES. */
typedef struct vxsi_hits {
    float *x, *y, *z, *nx, *ny, *nz, *area; /* shell frame; the last four only if taken */
    int32_t *i, *j, *k;                     /* cell relative to the box */
    float *depth;       /* [m] by a channel of the map, below 0 outside; only if sampled */
    uint8_t *direction; /* which of the patches' cells of directions, only if split */
    uint32_t capacity, count;
    uint32_t deep_count; /* points in interior cells that are no hits */
    uint32_t overflow;   /* not 0: a hit found no room */
    uint32_t take;
    vxsi_chunk chunk;          /* of the map at hand; at no cell when it changes, */
    vxsi_cube cube;            /* as is this */
    const uint8_t (*order)[8]; /* order[m]: the places of m's set bits, for kernels of eight lanes */
} vxsi_hits;

/* Bounding spheres in the shell's frame [m]; arrays have VXSI_LANES more. */
typedef struct vxsi_spheres {
    float *x, *y, *z, *radius;
    uint32_t count;
} vxsi_spheres;

/* Flat cylinders around runs of VXSI_QUARTER points in the shell's frame [m]; arrays have VXSI_LANES more. */
typedef struct vxsi_discs {
    float *x, *y, *z, *nx, *ny, *nz, *radius, *half; /* centre, axis, radius, half the thickness */
    uint32_t count;
} vxsi_discs;

enum {
    VXSI_QUARTER = 16, /* points: a quarter of a cluster */
    VXSI_BATCH = 64,
    VXSI_LANES = 16 /* of the widest kernel: arrays have room for so many more elements */
};

/* Up to VXSI_LANES things next to each other: first + n for each bit n that is set. */
typedef struct vxsi_block {
    uint32_t first, which;
} vxsi_block;

/* What is known of up to 64 spheres; bit n and slack[n] belong to sphere first + n. */
typedef struct vxsi_verdict {
    uint64_t is_free;        /* meets free cells only, */
    uint64_t is_deep;        /* or interior cells only; neither: look */
    float slack[VXSI_BATCH]; /* by how much [cells] the sphere could grow and that would stay so */
} vxsi_verdict;

/* Judges spheres first .. first + 63, at least those in `wanted`; what it says of others may be nothing. */
typedef void vxsi_cull(const vxs_voxmap *map, const vxsi_spheres *spheres, uint32_t first, uint64_t wanted,
                       const vxsi_motion *motion, vxsi_verdict *verdict);

/* Lists in `looks` the points of those discs of `near` that do not meet free cells only, by the map's planes.
 * Returns how many blocks they are; writes up to VXSI_LANES more. */
typedef uint32_t vxsi_clear(const vxs_voxmap *map, const vxsi_discs *discs, const vxsi_motion *motion,
                            const vxsi_block *near, uint32_t count, vxsi_block *looks);

/* The points of discs first + n for each of the lowest `lanes` bits n of which. Returns how many blocks they
 * are. Without a branch: none would be foreseen. */
static inline uint32_t vxsi_list_points(uint32_t first, uint32_t which, uint32_t lanes, vxsi_block *looks)
{
    uint32_t count = 0;
    for (uint32_t n = 0; n < lanes; n++, which >>= 1) {
        looks[count] = (vxsi_block){(first + n) * VXSI_QUARTER, (1u << VXSI_QUARTER) - 1};
        count += which & 1;
    }
    return count;
}

/* Appends what the points of the blocks find. */
typedef void vxsi_probe(const vxs_voxmap *map, const vxs_pointshell *shell, const vxsi_motion *motion,
                        const vxsi_block *blocks, uint32_t count, vxsi_hits *hits);

/* Which hits, and where the map is to the shell: cell centre C = h (cell + 1/2), p = R x + t. */
typedef struct vxsi_span {
    uint32_t first, last;
    int has_area;
    double voxel, rotation[9], offset[3]; /* R, t [m]: shell to the box's corner */
} vxsi_span;

/* Fills hits.depth of the span from the map's layers or distances; is_steepest: and their normals, along the
 * gradient, with depth 0 where there is none. Returns how many are too deep for the channel to know how deep.
 * May write up to seven hits beyond the span's last: statics are sampled in order. */
typedef uint32_t vxsi_sample(const vxs_voxmap *map, int is_layers, int is_steepest, const vxsi_span *span,
                             vxsi_hits *hits);

/* Sum of the normals and number of the hits; only_deep: of those with hits.depth above 0. */
typedef void vxsi_mean(const vxsi_hits *hits, const vxsi_span *span, int only_deep, double sum[3],
                       double *count);

/* Of forces along one unit normal n (shell frame), or along each point's own: w = d (or d times area),
 *   common: weight = sum w, moment = sum w x;   own: force = sum w n, moment = sum w (x - o) x n.
 * d is the depth under the plane through the cell's centre; is_given: hits.depth. */
typedef struct vxsi_total {
    double weight, force[3], moment[3], depth;
} vxsi_total;
typedef void vxsi_sum_common(const vxsi_hits *hits, const vxsi_span *span, const double normal[3],
                             vxsi_total *total);
typedef void vxsi_sum_own(const vxsi_hits *hits, const vxsi_span *span, const double reference[3],
                          int is_given, vxsi_total *total);

/* Fills hits.depth with the depths under the planes of the cells along the hits' normals; only_deeper: where
 * they are larger than what is there. */
typedef void vxsi_set_planes(vxsi_hits *hits, const vxsi_span *span, int only_deeper);

typedef struct vxsi_kernel {
    vxsi_cull *cull;
    vxsi_clear *clear;
    vxsi_probe *probe;
    vxsi_sample *sample;
    vxsi_mean *mean;
    vxsi_sum_common *sum_common;
    vxsi_sum_own *sum_own;
    vxsi_set_planes *set_planes;
} vxsi_kernel;

extern const vxsi_kernel vxsi_kernel_scalar;
#if defined(__x86_64__)
extern const vxsi_kernel vxsi_kernel_avx2;
extern const vxsi_kernel vxsi_kernel_avx512;
#elif defined(__aarch64__)
extern const vxsi_kernel vxsi_kernel_neon;
#endif
vxsi_cull vxsi_cull_scalar;
vxsi_probe vxsi_probe_scalar;
vxsi_sample vxsi_sample_scalar;

#endif
