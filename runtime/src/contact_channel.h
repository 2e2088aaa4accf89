/* SPDX-License-Identifier: MIT
 *
 * A channel of a map around a place: what both ways to sample it share.
 */
#ifndef VXSI_CONTACT_CHANNEL_H
#define VXSI_CONTACT_CHANNEL_H

#include "contact_kernel.h"

#include <string.h>

/* One of layers and distances is NULL. */
typedef struct vxsi_channel {
    const vxs_voxmap *map;
    const int8_t *layers;
    const int16_t *distances;
    int32_t beyond; /* the value of what it does not reach; negative inside */
    double step;    /* [m] per unit; of layers: for a wall along the grid */
    double least; /* square of the slope [units a cell] below which it says nothing about a direction: it is h
                     / step but where it is clamped */
    double m[9], b[3]; /* shell to cells, a cell's centre at whole numbers */
} vxsi_channel;

vxsi_channel vxsi_channel_of(const vxs_voxmap *map, int is_layers, const vxsi_span *span);

/* The eight values around a place; i, j, k: the lowest corner, relative to the box, at least -1. Pairs along
 * k at (i, j) = 00 01 10 11, the lower one in the low 16 bits. */
void vxsi_channel_corners(const vxsi_channel *channel, int32_t i, int32_t j, int32_t k, uint32_t pairs[4]);

static inline uint32_t vxsi_channel_pair(int32_t low, int32_t high)
{
    return ((uint32_t)low & 0xFFFFu) | (uint32_t)high << 16;
}

/* The same where the corners lie in several bricks of one chunk; slot: that of the lowest one. */
void vxsi_channel_straddle(const vxsi_channel *channel, const uint32_t *slot, int32_t i, int32_t j, int32_t k,
                           uint32_t pairs[4]);

/* The same, quickly where all are in one brick. */
static inline void vxsi_channel_pairs(const vxsi_channel *channel, int32_t i, int32_t j, int32_t k,
                                      uint32_t pairs[4])
{
    static const size_t steps[4] = {0, 8, 64, 72};
    const vxs_voxmap *map = channel->map;
    const uint32_t ci = (uint32_t)i, cj = (uint32_t)j, ck = (uint32_t)k;
    uint32_t entry = VXS_CELL_FREE;
    if ((i & 63) != 63 && (j & 63) != 63 && (k & 63) != 63) /* else outside the box, too */
        entry = map->root[vxs_voxmap_root_index(map->root_dims, ci, cj, ck)];
    if (entry < VXS_VOXMAP_ENTRY_FIRST) {
        vxsi_channel_corners(channel, i, j, k, pairs);
        return;
    }
    const uint32_t *slot = map->chunks + (size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES +
                           vxs_voxmap_chunk_slot(ci, cj, ck);
    if ((i & 7) == 7 || (j & 7) == 7 || (k & 7) == 7 || *slot < VXS_VOXMAP_ENTRY_FIRST) {
        vxsi_channel_straddle(channel, slot, i, j, k, pairs);
        return;
    }
    size_t at = (size_t)(*slot - VXS_VOXMAP_ENTRY_FIRST) * 512 + vxs_voxmap_brick_cell(ci, cj, ck);
    if (channel->distances) {
        for (int n = 0; n < 4; n++)
            memcpy(&pairs[n], channel->distances + at + steps[n], sizeof pairs[n]); /* little-endian */
    } else {
        const int8_t *layers = channel->layers + at;
        for (int n = 0; n < 4; n++) pairs[n] = vxsi_channel_pair(layers[steps[n]], layers[steps[n] + 1]);
    }
}

#endif
