/* SPDX-License-Identifier: MIT
 *
 * The newest row in shared memory: a mailbox behind a header. rt-safe.
 */
#include "live_memory.h"

void vxs_live_put(vxs_live *live, const vxs_servo_trace *row)
{
    vxsi_live_memory *memory = live->memory;
    vxsi_mailbox_put(&memory->box, row, sizeof *row);
}

uint64_t vxs_live_get(const vxs_live *live, vxs_servo_trace *row)
{
    vxsi_live_memory *memory = live->memory;
    return vxsi_mailbox_get(&memory->box, row, sizeof *row);
}
