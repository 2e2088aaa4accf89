/* SPDX-License-Identifier: MIT
 *
 * One writer, one reader, two counters that only grow. rt-safe.
 */
#include "trace_ring.h"

static vxs_servo_trace *row_at(const vxs_trace *trace, uint64_t number)
{
    return &trace->rows[number & (trace->row_count - 1)];
}

void vxs_trace_push(vxs_trace *trace, const vxs_servo_trace *row)
{
    uint64_t written = atomic_load_explicit(&trace->written, memory_order_relaxed);
    uint64_t taken = atomic_load_explicit(&trace->taken, memory_order_acquire);
    if (written - taken == trace->row_count) {
        atomic_fetch_add_explicit(&trace->dropped, 1, memory_order_relaxed);
        return;
    }
    *row_at(trace, written) = *row;
    atomic_store_explicit(&trace->written, written + 1, memory_order_release);
}

size_t vxs_trace_drain(vxs_trace *trace, vxs_servo_trace *rows, size_t max)
{
    uint64_t taken = atomic_load_explicit(&trace->taken, memory_order_relaxed);
    uint64_t written = atomic_load_explicit(&trace->written, memory_order_acquire);
    size_t count = written - taken < max ? (size_t)(written - taken) : max;
    for (size_t n = 0; n < count; n++) rows[n] = *row_at(trace, taken + n);
    atomic_store_explicit(&trace->taken, taken + count, memory_order_release);
    return count;
}

uint64_t vxs_trace_dropped(const vxs_trace *trace)
{
    return atomic_load_explicit(&trace->dropped, memory_order_relaxed);
}
