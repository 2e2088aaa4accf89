/* SPDX-License-Identifier: MIT
 *
 * The probe in plain C: the meaning of every other probe.
 */
#include "contact_probe.h"

void vxsi_probe_scalar(const vxs_voxmap *map, const vxs_pointshell *shell, const vxsi_probe_motion *motion,
                       vxs_contact_scratch *scratch)
{
    const float *m = motion->m, *b = motion->b;
    const float extent[3] = {(float)map->cells[0], (float)map->cells[1],
                             (float)map->cells[2]}; /* exact: <= 2^20 */
    for (uint32_t point = 0; point < shell->point_count; point++) {
        float x = shell->x[point], y = shell->y[point], z = shell->z[point];
        float u0 = ((m[0] * x + m[1] * y) + m[2] * z) + b[0];
        float u1 = ((m[3] * x + m[4] * y) + m[5] * z) + b[1];
        float u2 = ((m[6] * x + m[7] * y) + m[8] * z) + b[2];
        /* A NaN fails every comparison; within the box truncation is floor. */
        if (!(u0 >= 0 && u0 < extent[0] && u1 >= 0 && u1 < extent[1] && u2 >= 0 && u2 < extent[2])) continue;
        uint32_t cell[3] = {(uint32_t)u0, (uint32_t)u1, (uint32_t)u2};
        uint32_t state = vxs_voxmap_state(map, cell[0], cell[1], cell[2]);
        if (state == VXS_CELL_FREE) continue;
        if (state == VXS_CELL_INTERIOR) {
            scratch->deep_count++;
        } else if (scratch->count < scratch->capacity) {
            scratch->hits[scratch->count++] = (vxsi_hit){point, {cell[0], cell[1], cell[2]}};
        } else {
            scratch->overflow = 1;
        }
    }
}
