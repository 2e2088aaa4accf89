/* SPDX-License-Identifier: MIT
 *
 * clear of contact_kernel.h in as many lanes as the instruction set has: included once per instruction set,
 * with VXSI_TARGET, VXSI_NAME(), VXSI_WIDTH (lanes) and VXSI_BITS(mask) (one bit for each lane) defined;
 * where there is one, VXSI_GATHER(base, index, lanes) too (32 bits each, 0 in other lanes).
 *
 * A disc around c with half a thickness t, radius r and axis m reaches no farther along n than
 *     n . c + t |n . m| + r sqrt(n^2 - (n . m)^2).
 */
#ifndef VXSI_CONTACT_CLEAR_H
#define VXSI_CONTACT_CLEAR_H

#include "contact_kernel.h"

#include <string.h>

typedef float vnf __attribute__((vector_size(4 * VXSI_WIDTH)));
typedef int32_t vni __attribute__((vector_size(4 * VXSI_WIDTH)));
#ifndef VXSI_GATHER
#define VXSI_GATHER(base, index, lanes)                                                                      \
    __extension__({                                                                                          \
        vni gathered_, index_ = (index);                                                                     \
        for (int lane_ = 0; lane_ < VXSI_WIDTH; lane_++)                                                     \
            memcpy((char *)&gathered_ + 4 * lane_, (const char *)(base) + 4 * (size_t)index_[lane_], 4);     \
        gathered_ &(lanes);                                                                                  \
    })
#endif
#ifndef VXSI_LIST
#define VXSI_LIST(first, which, looks) vxsi_list_points(first, which, VXSI_WIDTH, looks)
#endif
#ifndef VXSI_SET
#define VXSI_SET(v) VXSI_BITS((v) != 0)
#endif
#define TO_FLOAT(v) __builtin_convertvector(v, vnf)
#define LOAD_N(array, at)                                                                                    \
    __extension__({                                                                                          \
        vnf loaded_;                                                                                         \
        memcpy(&loaded_, (array) + (at), sizeof loaded_);                                                    \
        loaded_;                                                                                             \
    })
/* As they come, 2^24 times as large: a power of two changes no bit of what is compared. */
#define TOP_BYTE (-(1 << 24))
#define DOT_N(a, b) (((a)[0] * (b)[0] + (a)[1] * (b)[1]) + (a)[2] * (b)[2])

VXSI_TARGET static uint32_t VXSI_NAME(clear)(const vxs_voxmap *map, const vxsi_discs *discs,
                                             const vxsi_motion *motion, const vxsi_block *near,
                                             uint32_t count, vxsi_block *looks)
{
    /* What rounding may take off the length of an axis: more than it does. */
    static const float longer = 1 + 0x1p-18f;
    vxsi_block *const begin = looks;
    const float voxel = (float)map->voxel;
    vxsi_chunk chunk = {{UINT32_MAX, UINT32_MAX, UINT32_MAX}, VXS_CELL_FREE};
    for (uint32_t n = 0; n < count * VXSI_LANES; n += VXSI_WIDTH) {
        const vxsi_block *block = &near[n / VXSI_LANES];
        const uint32_t lane = n % VXSI_LANES, d = block->first + lane;
        uint32_t which = block->which >> lane & ((1u << VXSI_WIDTH) - 1);
        if (!which) continue;
        const vnf at[3] = {LOAD_N(discs->x, d), LOAD_N(discs->y, d), LOAD_N(discs->z, d)};
        const vnf axis[3] = {LOAD_N(discs->nx, d), LOAD_N(discs->ny, d), LOAD_N(discs->nz, d)};
        vnf u[3], turned[3];
        vni cell[3], lanes = (vni){0} == 0, differs = {0};
#pragma GCC unroll 3
        for (int i = 0; i < 3; i++) {
            const float *row = motion->m + 3 * i;
            u[i] = ((row[0] * at[0] + row[1] * at[1]) + row[2] * at[2]) + motion->b[i];
            turned[i] = (row[0] * axis[0] + row[1] * axis[1]) + row[2] * axis[2];
            lanes &= (u[i] >= 0) & (u[i] < (float)map->cells[i]);
            cell[i] = __builtin_convertvector((vnf)((vni)u[i] & lanes), vni);
            differs |= cell[i] ^ (int32_t)chunk.at[i];
        }
        vni index = (cell[0] << 3 & 7 << 6) | (cell[1] & 7 << 3) | (cell[2] >> 3 & 7);
        const vxs_voxmap_plane *planes = map->planes;
        if (VXSI_SET(differs & ~(VXS_VOXMAP_CHUNK_CELLS - 1)) & which) {
            const int32_t *dims = (const int32_t *)map->root_dims;
            const vni root = ((cell[0] >> 6) * dims[1] + (cell[1] >> 6)) * dims[2] + (cell[2] >> 6);
            const vni entry = VXSI_GATHER(map->root, root, lanes);
            lanes &= entry >= VXS_VOXMAP_ENTRY_FIRST;
            index |= (entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES;
            for (int i = 0; i < 3; i++)
                chunk.at[i] = (uint32_t)cell[i][0] & ~(uint32_t)(VXS_VOXMAP_CHUNK_CELLS - 1);
            chunk.entry = map->root[root[0]];
        } else {
            if (chunk.entry < VXS_VOXMAP_ENTRY_FIRST)
                lanes ^= lanes; /* it has no planes */
            else
                planes += (size_t)(chunk.entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES;
        }
        const vni plane = VXSI_GATHER(planes, index & lanes, lanes);
        vnf normal[3], away[3];
#pragma GCC unroll 3
        for (int i = 0; i < 3; i++) {
            normal[i] = TO_FLOAT(plane << (24 - 8 * i) & TOP_BYTE);
            away[i] = u[i] - TO_FLOAT((cell[i] & ~7) + 4);
        }
        const vnf half = LOAD_N(discs->half, d) * motion->scale + motion->margin,
                  radius = LOAD_N(discs->radius, d) * motion->scale + motion->margin;
        const vnf room = VXS_VOXMAP_PLANE_REACH - (half + radius);
        const vnf along = DOT_N(normal, turned) * voxel,
                  across = DOT_N(normal, normal) * longer - along * along;
        const vnf left = (TO_FLOAT(plane & TOP_BYTE) * VXS_VOXMAP_PLANE_STEP - DOT_N(normal, away)) -
                         half * (vnf)((vni)along & INT32_MAX);
        lanes &= (room >= 0) & (DOT_N(away, away) <= room * room);
        lanes &= (left >= 0) & ((radius * radius) * across <= left * left);
        which &= ~(uint32_t)VXSI_BITS(lanes);
        looks += VXSI_LIST(d, which, looks);
    }
    return (uint32_t)(looks - begin);
}

#endif
