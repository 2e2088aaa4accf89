/* SPDX-License-Identifier: MIT
 *
 * trace_ring.h - private: the ring's memory. Writer's and reader's counters on lines of their own.
 */
#ifndef VXSI_TRACE_RING_H
#define VXSI_TRACE_RING_H

#include "voxshell/trace.h"

#include <stdalign.h>
#include <stdatomic.h>

struct vxs_trace {
    vxs_servo_trace *rows;
    uint64_t row_count; /* power of two */
    alignas(64) atomic_uint_least64_t written;
    atomic_uint_least64_t dropped;
    alignas(64) atomic_uint_least64_t taken;
};

#endif
