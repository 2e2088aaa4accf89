/* SPDX-License-Identifier: MIT
 *
 * vxsi_sample on AVX2, four hits at a time: the same operations in the same order as contact_channel.c and no
 * fused multiply-add, so the same bits.
 */
#include "contact_channel.h"
#include "contact_lanes.h"

#if defined(__x86_64__)

#include <immintrin.h>

#define SQRT(v) ((vd)_mm256_sqrt_pd((__m256d)(v)))
#define TO_DOUBLE(v) ((vd)_mm256_cvtepi32_pd((__m128i)(v)))

__attribute__((target("avx2"))) uint32_t vxsi_sample_avx2(const vxs_voxmap *map, int is_layers,
                                                          int is_steepest, const vxsi_span *span,
                                                          vxsi_hits *hits)
{
    const vxsi_channel channel = vxsi_channel_of(map, is_layers, span);
    const double *r = span->rotation, *m = channel.m, beyond = channel.beyond;
    const vd zero = {0, 0, 0, 0}, one = {1, 1, 1, 1};
    vd deep = zero;
    for (uint32_t n = span->first; n < span->last; n += 4) {
        const vl exists = LANES_OF(span, n);
        const vd x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
        vd f[3];
        int32_t corner[3][4];
#pragma GCC unroll 3
        for (int i = 0; i < 3; i++) {
            vd u = KEEP(exists, ((m[3 * i] * x + m[3 * i + 1] * y) + m[3 * i + 2] * z) + channel.b[i]);
            vi cell = (vi)_mm256_cvttpd_epi32((__m256d)u); /* near the box: floor() where u is not below it */
            const vd whole = SELECT(u < TO_DOUBLE(cell), TO_DOUBLE(cell) - one, TO_DOUBLE(cell));
            cell = (vi)_mm256_cvttpd_epi32((__m256d)whole);
            f[i] = u - whole;
            memcpy(corner[i], &cell, sizeof cell);
        }
        uint32_t pairs[4][4];
#pragma GCC unroll 1
        for (int lane = 0; lane < 4; lane++)
            vxsi_channel_pairs(&channel, corner[0][lane], corner[1][lane], corner[2][lane], pairs[lane]);
        vd low[4], slope[4], edge[4];
#pragma GCC unroll 4
        for (int e = 0; e < 4; e++) {
            const vu both = {pairs[0][e], pairs[1][e], pairs[2][e], pairs[3][e]};
            low[e] = TO_DOUBLE((vi)(both << 16) >> 16);
            slope[e] = TO_DOUBLE((vi)both >> 16) - low[e];
            edge[e] = low[e] + f[2] * slope[e];
        }
        const vd at_low = edge[0] + f[1] * (edge[1] - edge[0]),
                 at_high = edge[2] + f[1] * (edge[3] - edge[2]);
        const vd inside = zero - (at_low + f[0] * (at_high - at_low)); /* in units */
        vd depth = inside * channel.step;
        vl is_deep = inside >= beyond;
        if (is_steepest) {
            const vd g0 = at_high - at_low,
                     g1 = (edge[1] - edge[0]) + f[0] * ((edge[3] - edge[2]) - (edge[1] - edge[0]));
            const vd slope_low = slope[0] + f[1] * (slope[1] - slope[0]),
                     slope_high = slope[2] + f[1] * (slope[3] - slope[2]);
            const vd g2 = slope_low + f[0] * (slope_high - slope_low);
            const vd square = (g0 * g0 + g1 * g1) + g2 * g2;
            const vl is_steep = square >= channel.least;
            const vd inverse = one / SQRT(SELECT(is_steep, square, one));
            STORE_F(hits->nx, n, ((r[0] * g0 + r[3] * g1) + r[6] * g2) * inverse);
            STORE_F(hits->ny, n, ((r[1] * g0 + r[4] * g1) + r[7] * g2) * inverse);
            STORE_F(hits->nz, n, ((r[2] * g0 + r[5] * g1) + r[8] * g2) * inverse);
            is_deep = (inside > zero) & ~is_steep;
            depth = KEEP(~is_deep, depth);
        } else if (is_layers) {
            /* The rings of a wall with normal N follow each other every h (|N0| + |N1| + |N2|). */
            const vd nx = LOAD_F(hits->nx, n), ny = LOAD_F(hits->ny, n), nz = LOAD_F(hits->nz, n);
            vd rings = zero;
#pragma GCC unroll 3
            for (int i = 0; i < 9; i += 3) rings += ABS((r[i] * nx + r[i + 1] * ny) + r[i + 2] * nz);
            depth *= rings;
        }
        STORE_F(hits->depth, n, depth);
        deep += KEEP(is_deep & exists, one);
    }
    return (uint32_t)((deep[0] + deep[1]) + (deep[2] + deep[3]));
}

#else
typedef int vxsi_no_channel_avx2; /* a translation unit is not empty */
#endif
