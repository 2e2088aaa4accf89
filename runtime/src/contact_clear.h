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
#define TO_FLOAT(v) __builtin_convertvector(v, vnf)
#define LOAD_N(array, at)                                                                                    \
    __extension__({                                                                                          \
        vnf loaded_;                                                                                         \
        memcpy(&loaded_, (array) + (at), sizeof loaded_);                                                    \
        loaded_;                                                                                             \
    })
#define DOT_N(a, b) (((a)[0] * (b)[0] + (a)[1] * (b)[1]) + (a)[2] * (b)[2])

VXSI_TARGET static uint64_t VXSI_NAME(clear)(const vxs_voxmap *map, const vxsi_discs *discs, uint32_t first,
                                             uint64_t wanted, const vxsi_motion *motion)
{
    /* What rounding may take off the length of an axis: more than it does. */
    static const float longer = 1 + 0x1p-18f;
    const float voxel = (float)map->voxel;
    uint64_t clear = 0;
    if (map->chunk_count > INT32_MAX / VXS_VOXMAP_CHUNK_ENTRIES) return 0; /* indices have 32 bits */
    for (uint32_t n = 0; n < VXSI_BATCH; n += VXSI_WIDTH) {
        if (!(wanted >> n & ((UINT64_C(1) << VXSI_WIDTH) - 1))) continue;
        const uint32_t d = first + n;
        const vnf at[3] = {LOAD_N(discs->x, d), LOAD_N(discs->y, d), LOAD_N(discs->z, d)};
        const vnf axis[3] = {LOAD_N(discs->nx, d), LOAD_N(discs->ny, d), LOAD_N(discs->nz, d)};
        vnf u[3], turned[3];
        vni cell[3], inside = (vni){0} == 0;
#pragma GCC unroll 3
        for (int i = 0; i < 3; i++) {
            const float *m = motion->m + 3 * i;
            u[i] = ((m[0] * at[0] + m[1] * at[1]) + m[2] * at[2]) + motion->b[i];
            turned[i] = ((m[0] * axis[0] + m[1] * axis[1]) + m[2] * axis[2]) * voxel;
            inside &= (u[i] >= 0) & (u[i] < (float)map->cells[i]);
            cell[i] = __builtin_convertvector((vnf)((vni)u[i] & inside), vni);
        }
        const int32_t *dims = (const int32_t *)map->root_dims;
        vni index = ((cell[0] >> 6) * dims[1] + (cell[1] >> 6)) * dims[2] + (cell[2] >> 6);
        const vni entry = VXSI_GATHER(map->root, index & inside, inside);
        vni lanes = inside & (entry >= VXS_VOXMAP_ENTRY_FIRST);
        index = (entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES +
                ((cell[0] << 3 & 7 << 6) | (cell[1] & 7 << 3) | (cell[2] >> 3 & 7));
        const vni plane = VXSI_GATHER(map->planes, index & lanes, lanes);
        vnf normal[3], away[3];
#pragma GCC unroll 3
        for (int i = 0; i < 3; i++) {
            normal[i] = TO_FLOAT(plane << (24 - 8 * i) >> 24);
            away[i] = u[i] - TO_FLOAT((cell[i] & ~7) + 4);
        }
        const vnf half = LOAD_N(discs->half, d) * motion->scale + motion->margin,
                  radius = LOAD_N(discs->radius, d) * motion->scale + motion->margin;
        const vnf room = VXS_VOXMAP_PLANE_REACH - (half + radius);
        const vnf along = DOT_N(normal, turned), across = DOT_N(normal, normal) * longer - along * along;
        const vnf left = (TO_FLOAT(plane >> 24) * VXS_VOXMAP_PLANE_STEP - DOT_N(normal, away)) -
                         half * (vnf)((vni)along & INT32_MAX);
        lanes &= (room >= 0) & (DOT_N(away, away) <= room * room);
        lanes &= (left >= 0) & ((radius * radius) * across <= left * left);
        clear |= (uint64_t)VXSI_BITS(lanes) << n;
    }
    return clear & wanted;
}

#endif
