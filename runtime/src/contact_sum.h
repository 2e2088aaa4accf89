/* SPDX-License-Identifier: MIT
 *
 * mean and sum of contact_kernel.h: included once per instruction set, with VXSI_TARGET and VXSI_NAME()
 * defined, and VXSI_DOUBLES if there are
 * not four lanes.
 */
#include "contact_lanes.h"

/* The eight sums, in some vectors: vector v of hits n .. n + 7 begins at hit n + VXSI_DOUBLES v. */
enum { SUMS = 8, VECTORS = SUMS / VXSI_DOUBLES };

VXSI_TARGET static double VXSI_NAME(add_sums)(const vd sums[VECTORS])
{
    double s[SUMS];
    memcpy(s, sums, sizeof s);
    return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

VXSI_TARGET static void VXSI_NAME(mean)(const vxsi_hits *hits, const vxsi_span *span, int only_deep,
                                        double sum[3], double *count)
{
    const vd zero = {0}, one = zero + 1;
    vd x[VECTORS] = {{0}}, y[VECTORS] = {{0}}, z[VECTORS] = {{0}}, number[VECTORS] = {{0}};
    for (uint32_t first = span->first; first < span->last; first += SUMS) {
#pragma GCC unroll 2
        for (uint32_t v = 0, n = first; v < VECTORS; v++, n += VXSI_DOUBLES) {
            vd nx = LOAD_F(hits->nx, n), ny = LOAD_F(hits->ny, n), nz = LOAD_F(hits->nz, n), counts = one;
            if (only_deep || !ALL_LANES(span, n)) {
                vl lanes = LANES_OF(span, n);
                if (only_deep) lanes &= LOAD_F(hits->depth, n) > zero;
                nx = KEEP(lanes, nx);
                ny = KEEP(lanes, ny);
                nz = KEEP(lanes, nz);
                counts = KEEP(lanes, one);
            }
            x[v] += nx;
            y[v] += ny;
            z[v] += nz;
            number[v] += counts;
        }
    }
    sum[0] = VXSI_NAME(add_sums)(x);
    sum[1] = VXSI_NAME(add_sums)(y);
    sum[2] = VXSI_NAME(add_sums)(z);
    *count = VXSI_NAME(add_sums)(number);
}

/* The largest lane. */
static double VXSI_NAME(largest)(const vd *v)
{
    double most = 0;
    for (int lane = 0; lane < VXSI_DOUBLES; lane++) most = (*v)[lane] > most ? (*v)[lane] : most;
    return most;
}

/* d = (C - p) . n = h cell . N + (h/2 (N0 + N1 + N2) - t . N) - x . n with N = R n. */
VXSI_TARGET static void VXSI_NAME(sum_common)(const vxsi_hits *hits, const vxsi_span *span,
                                              const double normal[3], vxsi_total *total)
{
    const double *r = span->rotation, *t = span->offset, h = span->voxel;
    double turned[3];
    for (int i = 0; i < 3; i++)
        turned[i] = (r[3 * i] * normal[0] + r[3 * i + 1] * normal[1]) + r[3 * i + 2] * normal[2];
    const double constant = 0.5 * h * ((turned[0] + turned[1]) + turned[2]) -
                            ((t[0] * turned[0] + t[1] * turned[1]) + t[2] * turned[2]);
    const double hx = h * turned[0], hy = h * turned[1], hz = h * turned[2];
    const double nx = normal[0], ny = normal[1], nz = normal[2];
    const vd zero = {0};
    vd weight[VECTORS] = {{0}}, mx[VECTORS] = {{0}}, my[VECTORS] = {{0}}, mz[VECTORS] = {{0}}, deepest = zero;
    for (uint32_t first = span->first; first < span->last; first += SUMS) {
#pragma GCC unroll 2
        for (uint32_t v = 0, n = first; v < VECTORS; v++, n += VXSI_DOUBLES) {
            vd x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
            vd center =
                ((hx * LOAD_I(hits->i, n) + hy * LOAD_I(hits->j, n)) + hz * LOAD_I(hits->k, n)) + constant;
            vd depth = VXSI_LARGER(center - ((nx * x + ny * y) + nz * z), zero);
            if (!ALL_LANES(span, n)) depth = KEEP(LANES_OF(span, n), depth);
            deepest = VXSI_LARGER(depth, deepest);
            const vd w = span->has_area ? depth * LOAD_F(hits->area, n) : depth;
            weight[v] += w;
            mx[v] += w * x;
            my[v] += w * y;
            mz[v] += w * z;
        }
    }
    total->weight = VXSI_NAME(add_sums)(weight);
    total->moment[0] = VXSI_NAME(add_sums)(mx);
    total->moment[1] = VXSI_NAME(add_sums)(my);
    total->moment[2] = VXSI_NAME(add_sums)(mz);
    total->depth = VXSI_NAME(largest)(&deepest);
}

/* d = (C - t) . N - x . n with N = R n of each point. */
VXSI_TARGET static inline __attribute__((always_inline)) void
VXSI_NAME(depth_under)(const vxsi_hits *hits, const vxsi_span *span, uint32_t n, vd *depth)
{
    const double *r = span->rotation, *t = span->offset, h = span->voxel;
    const double tx = 0.5 * h - t[0], ty = 0.5 * h - t[1], tz = 0.5 * h - t[2];
    vd x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
    vd nx = LOAD_F(hits->nx, n), ny = LOAD_F(hits->ny, n), nz = LOAD_F(hits->nz, n);
    vd cx = h * LOAD_I(hits->i, n) + tx, cy = h * LOAD_I(hits->j, n) + ty, cz = h * LOAD_I(hits->k, n) + tz;
    vd center = (cx * ((r[0] * nx + r[1] * ny) + r[2] * nz) + cy * ((r[3] * nx + r[4] * ny) + r[5] * nz)) +
                cz * ((r[6] * nx + r[7] * ny) + r[8] * nz);
    *depth = center - ((nx * x + ny * y) + nz * z);
}

VXSI_TARGET static void VXSI_NAME(set_planes)(vxsi_hits *hits, const vxsi_span *span, int only_deeper)
{
    for (uint32_t n = span->first; n < span->last; n += VXSI_DOUBLES) {
        vd depth;
        VXSI_NAME(depth_under)(hits, span, n, &depth);
        if (only_deeper) {
            vd given = LOAD_F(hits->depth, n);
            depth = SELECT(given > depth, given, depth);
        }
        if (!ALL_LANES(span, n)) depth = SELECT(LANES_OF(span, n), depth, LOAD_F(hits->depth, n));
        STORE_F(hits->depth, n, depth);
    }
}

VXSI_TARGET static void VXSI_NAME(sum_own)(const vxsi_hits *hits, const vxsi_span *span,
                                           const double reference[3], int is_given, vxsi_total *total)
{
    const double ox = reference[0], oy = reference[1], oz = reference[2];
    const vd zero = {0};
    vd fx[VECTORS] = {{0}}, fy[VECTORS] = {{0}}, fz[VECTORS] = {{0}}, mx[VECTORS] = {{0}},
       my[VECTORS] = {{0}}, mz[VECTORS] = {{0}}, deepest = zero;
    for (uint32_t first = span->first; first < span->last; first += SUMS) {
#pragma GCC unroll 2
        for (uint32_t v = 0, n = first; v < VECTORS; v++, n += VXSI_DOUBLES) {
            vd x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
            vd nx = LOAD_F(hits->nx, n), ny = LOAD_F(hits->ny, n), nz = LOAD_F(hits->nz, n), depth;
            if (is_given)
                depth = LOAD_F(hits->depth, n);
            else
                VXSI_NAME(depth_under)(hits, span, n, &depth);
            depth = VXSI_LARGER(depth, zero);
            if (!ALL_LANES(span, n)) depth = KEEP(LANES_OF(span, n), depth);
            deepest = VXSI_LARGER(depth, deepest);
            const vd w = span->has_area ? depth * LOAD_F(hits->area, n) : depth;
            nx *= w;
            ny *= w;
            nz *= w;
            fx[v] += nx;
            fy[v] += ny;
            fz[v] += nz;
            mx[v] += (y - oy) * nz - (z - oz) * ny;
            my[v] += (z - oz) * nx - (x - ox) * nz;
            mz[v] += (x - ox) * ny - (y - oy) * nx;
        }
    }
    total->force[0] = VXSI_NAME(add_sums)(fx);
    total->force[1] = VXSI_NAME(add_sums)(fy);
    total->force[2] = VXSI_NAME(add_sums)(fz);
    total->moment[0] = VXSI_NAME(add_sums)(mx);
    total->moment[1] = VXSI_NAME(add_sums)(my);
    total->moment[2] = VXSI_NAME(add_sums)(mz);
    total->depth = VXSI_NAME(largest)(&deepest);
}
