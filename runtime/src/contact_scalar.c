/* SPDX-License-Identifier: MIT
 *
 * The kernel in plain C: the meaning of every other one. Here what the others fall back to.
 */
#include "contact_kernel.h"

#include <math.h>
#include <string.h>

static float to_cells(const float *m, float b, float x, float y, float z)
{
    return ((m[0] * x + m[1] * y) + m[2] * z) + b;
}

void vxsi_cull_scalar(const vxs_voxmap *map, const vxsi_spheres *spheres, uint32_t first, uint64_t wanted,
                      const vxsi_motion *motion, vxsi_verdict *verdict)
{
    verdict->is_free = verdict->is_deep = 0;
    for (uint32_t n = 0; n < VXSI_BATCH; n++) {
        if (!(wanted >> n & 1u)) continue;
        uint32_t s = first + n;
        uint32_t cell[3], size;
        float at[3], square = 0;
        for (int axis = 0; axis < 3; axis++) {
            float u =
                to_cells(motion->m + 3 * axis, motion->b[axis], spheres->x[s], spheres->y[s], spheres->z[s]);
            /* Outside the box the nearest point of the box is no farther from any cell. */
            float extent = (float)map->cells[axis];
            u = u > 0 ? u : 0; /* a NaN becomes 0: refused before */
            at[axis] = u < extent ? u : extent;
            uint32_t found = (uint32_t)at[axis];
            cell[axis] = found < map->cells[axis] ? found : map->cells[axis] - 1;
        }
        float value = vxs_voxmap_clearance(map, cell[0], cell[1], cell[2], &size);
        for (int axis = 0; axis < 3; axis++) {
            float away = at[axis] - (float)((cell[axis] & ~(size - 1)) + size / 2);
            square += away * away;
        }
        float left = fabsf(value) - (sqrtf(square) + (spheres->radius[s] * motion->scale + motion->margin));
        verdict->slack[n] = left;
        if (!(left >= 0)) continue;
        if (value > 0)
            verdict->is_free |= UINT64_C(1) << n;
        else
            verdict->is_deep |= UINT64_C(1) << n;
    }
}

/* What one point finds. */
static void probe_point(const vxs_voxmap *map, const vxs_pointshell *shell, const float *m, const float *b,
                        const float extent[3], uint32_t point, vxsi_hits *hits)
{
    float x = shell->x[point], y = shell->y[point], z = shell->z[point];
    float u0 = to_cells(m, b[0], x, y, z), u1 = to_cells(m + 3, b[1], x, y, z),
          u2 = to_cells(m + 6, b[2], x, y, z);
    /* A NaN fails every comparison; within the box truncation is floor. */
    if (!(u0 >= 0 && u0 < extent[0] && u1 >= 0 && u1 < extent[1] && u2 >= 0 && u2 < extent[2])) return;
    uint32_t cell[3] = {(uint32_t)u0, (uint32_t)u1, (uint32_t)u2};
    uint32_t state = vxs_voxmap_state(map, cell[0], cell[1], cell[2]);
    if (state == VXS_CELL_FREE) return;
    if (state == VXS_CELL_INTERIOR && !(hits->take & VXSI_TAKE_INTERIOR)) {
        hits->deep_count++;
        return;
    }
    if (hits->count == hits->capacity) {
        hits->overflow = 1;
        return;
    }
    uint32_t at = hits->count++;
    hits->x[at] = x;
    hits->y[at] = y;
    hits->z[at] = z;
    hits->i[at] = (int32_t)cell[0];
    hits->j[at] = (int32_t)cell[1];
    hits->k[at] = (int32_t)cell[2];
    if (hits->take & VXSI_TAKE_NORMAL) {
        hits->nx[at] = shell->nx[point];
        hits->ny[at] = shell->ny[point];
        hits->nz[at] = shell->nz[point];
    }
    if (hits->take & VXSI_TAKE_AREA) hits->area[at] = shell->area[point];
}

void vxsi_probe_scalar(const vxs_voxmap *map, const vxs_pointshell *shell, const vxsi_motion *motion,
                       const vxsi_block *blocks, uint32_t count, vxsi_hits *hits)
{
    const float *m = motion->m, *b = motion->b;
    const float extent[3] = {(float)map->cells[0], (float)map->cells[1],
                             (float)map->cells[2]}; /* exact: <= 2^20 */
    for (const vxsi_block *block = blocks; block < blocks + count; block++) {
        uint32_t point = block->first;
        for (uint32_t which = block->which; which; which >>= 1, point++)
            if (which & 1) probe_point(map, shell, m, b, extent, point, hits);
    }
}
