/* SPDX-License-Identifier: MIT */
#include "trace_ring.h"

enum { ALIGNMENT = 64 };

size_t vxs_trace_memory(uint32_t rows)
{
    if (rows == 0 || (rows & (rows - 1)) != 0) return 0;
    return sizeof(vxs_trace) + (size_t)rows * sizeof(vxs_servo_trace);
}

vxs_result vxs_trace_init(void *memory, size_t size, uint32_t rows, vxs_trace **out)
{
    size_t needed = vxs_trace_memory(rows);
    if (!memory || !out || needed == 0) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < needed) return VXS_BUFFER;
    vxs_trace *trace = memory;
    trace->rows = (vxs_servo_trace *)(void *)(trace + 1);
    trace->row_count = rows;
    atomic_init(&trace->written, 0);
    atomic_init(&trace->dropped, 0);
    atomic_init(&trace->taken, 0);
    *out = trace;
    return VXS_OK;
}
