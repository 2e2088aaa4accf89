/* SPDX-License-Identifier: MIT
 *
 * mean and sum of contact_kernel.h in four lanes: included once per instruction set, with VXSI_TARGET and
 * VXSI_NAME() defined.
 */
#include "contact_lanes.h"

VXSI_TARGET static void VXSI_NAME(mean)(const vxsi_hits *hits, const vxsi_span *span, int only_deep,
                                        double sum[3], double *count)
{
    const v4d zero = {0, 0, 0, 0}, one = {1, 1, 1, 1};
    v4d x = zero, y = zero, z = zero, number = zero;
    for (uint32_t n = span->first; n < span->last; n += 4) {
        v4l lanes = {-1, -1, -1, -1};
        if (!ALL_LANES(span, n)) lanes = LANES_OF(span, n);
        if (only_deep) lanes &= LOAD_F(hits->depth, n) > zero;
        x += KEEP(lanes, LOAD_F(hits->nx, n));
        y += KEEP(lanes, LOAD_F(hits->ny, n));
        z += KEEP(lanes, LOAD_F(hits->nz, n));
        number += KEEP(lanes, one);
    }
    sum[0] = ADD_LANES(x);
    sum[1] = ADD_LANES(y);
    sum[2] = ADD_LANES(z);
    *count = ADD_LANES(number);
}

static void VXSI_NAME(store_depth)(vxsi_total *total, const v4d *depth)
{
    for (int lane = 0; lane < 4; lane++) {
        if ((*depth)[lane] > total->depth) total->depth = (*depth)[lane];
    }
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
    const v4d zero = {0, 0, 0, 0};
    v4d weight = zero, mx = zero, my = zero, mz = zero, deepest = zero;
    for (uint32_t n = span->first; n < span->last; n += 4) {
        v4d x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
        v4d center =
            ((hx * LOAD_I(hits->i, n) + hy * LOAD_I(hits->j, n)) + hz * LOAD_I(hits->k, n)) + constant;
        v4d depth = center - ((nx * x + ny * y) + nz * z);
        v4l lanes = depth > zero;
        if (!ALL_LANES(span, n)) lanes &= LANES_OF(span, n);
        depth = KEEP(lanes, depth);
        deepest = SELECT(depth > deepest, depth, deepest);
        v4d w = depth;
        if (span->has_area) w = KEEP(lanes, depth * LOAD_F(hits->area, n));
        weight += w;
        mx += KEEP(lanes, w * x);
        my += KEEP(lanes, w * y);
        mz += KEEP(lanes, w * z);
    }
    total->weight = ADD_LANES(weight);
    total->moment[0] = ADD_LANES(mx);
    total->moment[1] = ADD_LANES(my);
    total->moment[2] = ADD_LANES(mz);
    total->depth = 0;
    VXSI_NAME(store_depth)(total, &deepest);
}

/* d = (C - t) . N - x . n with N = R n of each point. */
VXSI_TARGET static inline __attribute__((always_inline)) void
VXSI_NAME(depth_under)(const vxsi_hits *hits, const vxsi_span *span, uint32_t n, v4d *depth)
{
    const double *r = span->rotation, *t = span->offset, h = span->voxel;
    const double tx = 0.5 * h - t[0], ty = 0.5 * h - t[1], tz = 0.5 * h - t[2];
    v4d x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
    v4d nx = LOAD_F(hits->nx, n), ny = LOAD_F(hits->ny, n), nz = LOAD_F(hits->nz, n);
    v4d cx = h * LOAD_I(hits->i, n) + tx, cy = h * LOAD_I(hits->j, n) + ty, cz = h * LOAD_I(hits->k, n) + tz;
    v4d center = (cx * ((r[0] * nx + r[1] * ny) + r[2] * nz) + cy * ((r[3] * nx + r[4] * ny) + r[5] * nz)) +
                 cz * ((r[6] * nx + r[7] * ny) + r[8] * nz);
    *depth = center - ((nx * x + ny * y) + nz * z);
}

VXSI_TARGET static void VXSI_NAME(set_planes)(vxsi_hits *hits, const vxsi_span *span, int only_deeper)
{
    for (uint32_t n = span->first; n < span->last; n += 4) {
        v4d depth;
        VXSI_NAME(depth_under)(hits, span, n, &depth);
        if (only_deeper) {
            v4d given = LOAD_F(hits->depth, n);
            depth = SELECT(given > depth, given, depth);
        }
        if (!ALL_LANES(span, n)) depth = SELECT(LANES_OF(span, n), depth, LOAD_F(hits->depth, n));
        STORE_F(hits->depth, n, depth);
    }
}

VXSI_TARGET static inline __attribute__((always_inline)) void
VXSI_NAME(sum_each)(const vxsi_hits *hits, const vxsi_span *span, const double reference[3], int is_given,
                    vxsi_total *total)
{
    const double ox = reference[0], oy = reference[1], oz = reference[2];
    const v4d zero = {0, 0, 0, 0};
    v4d fx = zero, fy = zero, fz = zero, mx = zero, my = zero, mz = zero, deepest = zero;
    for (uint32_t n = span->first; n < span->last; n += 4) {
        v4d x = LOAD_F(hits->x, n), y = LOAD_F(hits->y, n), z = LOAD_F(hits->z, n);
        v4d nx = LOAD_F(hits->nx, n), ny = LOAD_F(hits->ny, n), nz = LOAD_F(hits->nz, n), depth;
        if (is_given)
            depth = LOAD_F(hits->depth, n);
        else
            VXSI_NAME(depth_under)(hits, span, n, &depth);
        v4l lanes = depth > zero;
        if (!ALL_LANES(span, n)) lanes &= LANES_OF(span, n);
        depth = KEEP(lanes, depth);
        deepest = SELECT(depth > deepest, depth, deepest);
        v4d w = depth;
        if (span->has_area) w = KEEP(lanes, depth * LOAD_F(hits->area, n));
        nx = KEEP(lanes, w * nx);
        ny = KEEP(lanes, w * ny);
        nz = KEEP(lanes, w * nz);
        fx += nx;
        fy += ny;
        fz += nz;
        mx += KEEP(lanes, (y - oy) * nz - (z - oz) * ny);
        my += KEEP(lanes, (z - oz) * nx - (x - ox) * nz);
        mz += KEEP(lanes, (x - ox) * ny - (y - oy) * nx);
    }
    total->force[0] = ADD_LANES(fx);
    total->force[1] = ADD_LANES(fy);
    total->force[2] = ADD_LANES(fz);
    total->moment[0] = ADD_LANES(mx);
    total->moment[1] = ADD_LANES(my);
    total->moment[2] = ADD_LANES(mz);
    total->depth = 0;
    VXSI_NAME(store_depth)(total, &deepest);
}

VXSI_TARGET static void VXSI_NAME(sum_own)(const vxsi_hits *hits, const vxsi_span *span,
                                           const double reference[3], vxsi_total *total)
{
    VXSI_NAME(sum_each)(hits, span, reference, 0, total);
}

VXSI_TARGET static void VXSI_NAME(sum_given)(const vxsi_hits *hits, const vxsi_span *span,
                                             const double reference[3], vxsi_total *total)
{
    VXSI_NAME(sum_each)(hits, span, reference, 1, total);
}
