/* SPDX-License-Identifier: MIT
 *
 * The law `gradient` (METHOD section 3): depth and direction from the signed distance of cell centres,
 * interpolated linearly along each axis. In double, point after point. rt-safe.
 */
#include "contact_state.h"

#include <math.h>

/* A distance's slope is 1 but where it is clamped: below this it says nothing about a direction. */
static const double least_slope = 0.25;

/* Distance at a cell's centre in steps; beyond the band, and outside the box, it is clamped to it. */
static double steps_at(const vxs_voxmap *map, double beyond, int64_t i, int64_t j, int64_t k)
{
    if ((uint64_t)i >= map->cells[0] || (uint64_t)j >= map->cells[1] || (uint64_t)k >= map->cells[2])
        return beyond;
    uint32_t ci = (uint32_t)i, cj = (uint32_t)j, ck = (uint32_t)k, entry = vxs_voxmap_entry(map, ci, cj, ck);
    if (entry == VXS_CELL_FREE) return beyond;
    if (entry == VXS_CELL_INTERIOR) return -beyond;
    return map->distances[(size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * 512 + vxs_voxmap_brick_cell(ci, cj, ck)];
}

/* The eight distances around a place, i slowest. first: the cell of the lowest corner. */
static void corners_at(const vxs_voxmap *map, double beyond, const int64_t first[3], double value[8])
{
    int in_brick = 1;
    for (int axis = 0; axis < 3; axis++)
        in_brick &= (first[axis] & 7) != 7 && (uint64_t)first[axis] < map->cells[axis];
    if (in_brick) {
        uint32_t ci = (uint32_t)first[0], cj = (uint32_t)first[1], ck = (uint32_t)first[2],
                 entry = vxs_voxmap_entry(map, ci, cj, ck);
        if (entry >= VXS_VOXMAP_ENTRY_FIRST) {
            const int16_t *d = map->distances + (size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * 512 +
                               vxs_voxmap_brick_cell(ci, cj, ck);
            for (int n = 0; n < 8; n++) value[n] = d[(n >> 2) * 64 + (n >> 1 & 1) * 8 + (n & 1)];
            return;
        }
    }
    for (int n = 0; n < 8; n++)
        value[n] = steps_at(map, beyond, first[0] + (n >> 2), first[1] + (n >> 1 & 1), first[2] + (n & 1));
}

/* Interpolated along k at (i, j) = 00 01 10 11. */
static void edges_of(const double value[8], const double f[3], double edge[4])
{
    for (int n = 0; n < 4; n++) edge[n] = value[2 * n] + f[2] * (value[2 * n + 1] - value[2 * n]);
}

static double interpolate(const double edge[4], const double f[3])
{
    double low = edge[0] + f[1] * (edge[1] - edge[0]), high = edge[2] + f[1] * (edge[3] - edge[2]);
    return low + f[0] * (high - low);
}

/* In steps per cell. */
static void gradient_of(const double value[8], const double edge[4], const double f[3], double gradient[3])
{
    double slope[4];
    for (int n = 0; n < 4; n++) slope[n] = value[2 * n + 1] - value[2 * n];
    double low = edge[0] + f[1] * (edge[1] - edge[0]), high = edge[2] + f[1] * (edge[3] - edge[2]);
    double slope_low = slope[0] + f[1] * (slope[1] - slope[0]),
           slope_high = slope[2] + f[1] * (slope[3] - slope[2]);
    gradient[0] = high - low;
    gradient[1] = (edge[1] - edge[0]) + f[0] * ((edge[3] - edge[2]) - (edge[1] - edge[0]));
    gradient[2] = slope_low + f[0] * (slope_high - slope_low);
}

void vxsi_sum_gradient(const vxs_voxmap *map, const vxsi_hits *hits, const vxsi_span *span,
                       const double reference[3], vxsi_gradient_total *total)
{
    const double *r = span->rotation, h = span->voxel, steps_per_cell = h / map->distance_step;
    const double beyond = floor(map->distance_band / map->distance_step + 0.5);
    double m[9], b[3]; /* shell to cells, a cell's centre at whole numbers */
    for (int i = 0; i < 9; i++) m[i] = r[i] / h;
    for (int i = 0; i < 3; i++) b[i] = span->offset[i] / h - 0.5;
    for (uint32_t n = span->first; n < span->last; n++) {
        const double x[3] = {hits->x[n], hits->y[n], hits->z[n]};
        int64_t first[3];
        double f[3], value[8], edge[4], gradient[3];
        for (int i = 0; i < 3; i++) {
            double u = ((m[3 * i] * x[0] + m[3 * i + 1] * x[1]) + m[3 * i + 2] * x[2]) + b[i];
            int64_t cell = (int64_t)u; /* near the box: floor() without the call that it is before SSE 4.1 */
            first[i] = cell - (u < (double)cell);
            f[i] = u - (double)first[i];
        }
        corners_at(map, beyond, first, value);
        edges_of(value, f, edge);
        double depth = -interpolate(edge, f) * map->distance_step;
        if (!(depth > 0)) continue;
        gradient_of(value, edge, f, gradient);
        double square = (gradient[0] * gradient[0] + gradient[1] * gradient[1]) + gradient[2] * gradient[2];
        double length = sqrt(square);
        if (!(length >= least_slope * steps_per_cell)) {
            total->deep++;
            continue;
        }
        double normal[3], inverse = 1 / length, size = span->has_area ? depth * (double)hits->area[n] : depth;
        for (int i = 0; i < 3; i++)
            normal[i] = ((r[i] * gradient[0] + r[3 + i] * gradient[1]) + r[6 + i] * gradient[2]) * inverse;
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            total->normal[i] += normal[i];
            total->force[i] += size * normal[i];
            total->moment[i] +=
                size * ((x[j] - reference[j]) * normal[k] - (x[k] - reference[k]) * normal[j]);
        }
        total->points++;
        if (depth > total->depth) total->depth = depth;
    }
}
