/* SPDX-License-Identifier: MIT
 *
 * sample of contact_kernel.h in VXSI_DOUBLES lanes: the same operations in the same order as
 * contact_channel.c and no fused multiply-add, so the same bits. Included once per instruction set, with
 * VXSI_TARGET, VXSI_NAME(), VXSI_SQRT(v) and VXSI_TO_INT(v) (truncated) defined.
 */
#include "contact_channel.h"
#include "contact_lanes.h"

VXSI_TARGET static uint32_t VXSI_NAME(sample)(const vxs_voxmap *map, int is_layers, int is_steepest,
                                              const vxsi_span *span, vxsi_hits *hits)
{
    const vxsi_channel channel = vxsi_channel_of(map, is_layers, span);
    const double *r = span->rotation, *m = channel.m, beyond = channel.beyond;
    const vd zero = {0}, one = zero + 1;
    vd deep = zero;
    for (uint32_t n = span->first; n < span->last; n += VXSI_DOUBLES) {
        const vl exists = LANES_OF(span, n);
        const vd x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
        vd f[3];
        vi corner[3];
#pragma GCC unroll 3
        for (int i = 0; i < 3; i++) {
            vd u = KEEP(exists, ((m[3 * i] * x + m[3 * i + 1] * y) + m[3 * i + 2] * z) + channel.b[i]);
            const vi cell = VXSI_TO_INT(u); /* near the box: floor() where u is not below it */
            const vd whole =
                SELECT(u < VXSI_TO_DOUBLE(cell), VXSI_TO_DOUBLE(cell) - one, VXSI_TO_DOUBLE(cell));
            corner[i] = VXSI_TO_INT(whole);
            f[i] = u - whole;
        }
        vu pairs[4];
        VXSI_NAME(pairs)(&channel, corner, pairs);
        vd low[4], slope[4], edge[4];
#pragma GCC unroll 4
        for (int e = 0; e < 4; e++) {
            low[e] = VXSI_TO_DOUBLE((vi)(pairs[e] << 16) >> 16);
            slope[e] = VXSI_TO_DOUBLE((vi)pairs[e] >> 16) - low[e];
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
            const vd inverse = one / VXSI_SQRT(SELECT(is_steep, square, one));
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
    double count = 0;
    for (int lane = 0; lane < VXSI_DOUBLES; lane++) count += deep[lane];
    return (uint32_t)count;
}
