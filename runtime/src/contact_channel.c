/* SPDX-License-Identifier: MIT
 *
 * Depths from a channel of the map, interpolated linearly along each axis between the centres of cells, and
 * the direction in which it grows. rt-safe.
 */
#include "contact_channel.h"

#include <math.h>

vxsi_channel vxsi_channel_of(const vxs_voxmap *map, int is_layers, const vxsi_span *span)
{
    static const double least_slope = 0.25;
    const double h = span->voxel;
    vxsi_channel channel = {.map = map};
    if (is_layers) {
        channel.layers = map->layers;
        channel.beyond = (int32_t)map->layer_count + 1;
        channel.step = h;
    } else {
        channel.distances = map->distances;
        channel.beyond = (int32_t)(map->distance_band / map->distance_step + 0.5);
        channel.step = map->distance_step;
    }
    channel.least = least_slope * h / channel.step;
    channel.least *= channel.least;
    for (int i = 0; i < 9; i++) channel.m[i] = span->rotation[i] / h;
    for (int i = 0; i < 3; i++) channel.b[i] = span->offset[i] / h - 0.5;
    return channel;
}

/* Value of a brick's cell. */
static inline int32_t value_of(const vxsi_channel *channel, uint32_t entry, uint32_t cell)
{
    if (entry < VXS_VOXMAP_ENTRY_FIRST)
        return entry == VXS_CELL_INTERIOR ? -channel->beyond : channel->beyond;
    size_t at = (size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * 512 + cell;
    return channel->distances ? channel->distances[at] : channel->layers[at];
}

void vxsi_channel_corners(const vxsi_channel *channel, int32_t i, int32_t j, int32_t k, uint32_t pairs[4])
{
    const vxs_voxmap *map = channel->map;
    for (int n = 0; n < 4; n++) {
        int32_t both[2];
        for (int dk = 0; dk < 2; dk++) {
            uint32_t ci = (uint32_t)(i + (n >> 1)), cj = (uint32_t)(j + (n & 1)), ck = (uint32_t)(k + dk);
            uint32_t entry = VXS_CELL_FREE; /* outside the box */
            if (ci < map->cells[0] && cj < map->cells[1] && ck < map->cells[2])
                entry = vxs_voxmap_entry(map, ci, cj, ck);
            both[dk] = value_of(channel, entry, vxs_voxmap_brick_cell(ci, cj, ck));
        }
        pairs[n] = vxsi_channel_pair(both[0], both[1]);
    }
}

void vxsi_channel_straddle(const vxsi_channel *channel, const uint32_t *slot, int32_t i, int32_t j, int32_t k,
                           uint32_t pairs[4])
{
    const uint32_t li = i & 7, lj = j & 7, lk = k & 7, next = lk + 1;
    for (uint32_t n = 0; n < 4; n++) {
        const uint32_t ni = li + (n >> 1), nj = lj + (n & 1), cell = (ni & 7) << 6 | (nj & 7) << 3;
        const uint32_t *at = slot + (ni >> 3 << 6 | nj >> 3 << 3);
        const int32_t low = value_of(channel, at[0], cell | lk),
                      high = value_of(channel, at[next >> 3], cell | (next & 7));
        pairs[n] = vxsi_channel_pair(low, high);
    }
}

uint32_t vxsi_sample_scalar(const vxs_voxmap *map, int is_layers, int is_steepest, const vxsi_span *span,
                            vxsi_hits *hits)
{
    const vxsi_channel channel = vxsi_channel_of(map, is_layers, span);
    const double *r = span->rotation, *m = channel.m;
    uint32_t deep = 0;
    for (uint32_t n = span->first; n < span->last; n++) {
        const double x = hits->x[n], y = hits->y[n], z = hits->z[n];
        double f[3], low[4], slope[4], edge[4];
        int32_t cell[3];
        uint32_t pairs[4];
        for (int i = 0; i < 3; i++) {
            double u = ((m[3 * i] * x + m[3 * i + 1] * y) + m[3 * i + 2] * z) + channel.b[i];
            cell[i] = (int32_t)u; /* near the box: floor() where u is not below it */
            cell[i] -= u < (double)cell[i];
            f[i] = u - (double)cell[i];
        }
        vxsi_channel_pairs(&channel, cell[0], cell[1], cell[2], pairs);
        for (int e = 0; e < 4; e++) {
            low[e] = (int16_t)pairs[e];
            slope[e] = (int16_t)(pairs[e] >> 16) - low[e];
            edge[e] = low[e] + f[2] * slope[e];
        }
        const double at_low = edge[0] + f[1] * (edge[1] - edge[0]),
                     at_high = edge[2] + f[1] * (edge[3] - edge[2]);
        const double inside = 0 - (at_low + f[0] * (at_high - at_low)); /* in units */
        double depth = inside * channel.step;
        int is_deep = inside >= (double)channel.beyond;
        if (is_steepest) {
            const double g0 = at_high - at_low,
                         g1 = (edge[1] - edge[0]) + f[0] * ((edge[3] - edge[2]) - (edge[1] - edge[0]));
            const double slope_low = slope[0] + f[1] * (slope[1] - slope[0]),
                         slope_high = slope[2] + f[1] * (slope[3] - slope[2]);
            const double g2 = slope_low + f[0] * (slope_high - slope_low);
            const double square = (g0 * g0 + g1 * g1) + g2 * g2;
            const int is_steep = square >= channel.least;
            const double inverse = 1 / sqrt(is_steep ? square : 1);
            hits->nx[n] = (float)(((r[0] * g0 + r[3] * g1) + r[6] * g2) * inverse);
            hits->ny[n] = (float)(((r[1] * g0 + r[4] * g1) + r[7] * g2) * inverse);
            hits->nz[n] = (float)(((r[2] * g0 + r[5] * g1) + r[8] * g2) * inverse);
            is_deep = inside > 0 && !is_steep;
            if (is_deep) depth = 0;
        } else if (is_layers) {
            /* The rings of a wall with normal N follow each other every h (|N0| + |N1| + |N2|). */
            const double nx = hits->nx[n], ny = hits->ny[n], nz = hits->nz[n];
            double rings = 0;
            for (int i = 0; i < 9; i += 3) rings += fabs((r[i] * nx + r[i + 1] * ny) + r[i + 2] * nz);
            depth *= rings;
        }
        hits->depth[n] = (float)depth;
        deep += (uint32_t)is_deep;
    }
    return deep;
}
