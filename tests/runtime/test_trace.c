/* SPDX-License-Identifier: MIT
 *
 * The ring between two threads: every row arrives once, in order and whole, or is counted as
 * dropped.
 */
#include "check.h"
#include "voxshell/trace.h"

#include <pthread.h>

enum { ROWS = 64, WRITES = 200000 };

static void fill(vxs_servo_trace *row, uint64_t number)
{
    memset(row, 0, sizeof *row);
    row->tick = number;
    row->depth = (double)number * 0.5;
    row->flags = (uint32_t)number * 2654435761u;
}

static void *write_rows(void *trace)
{
    for (uint64_t n = 0; n < WRITES; n++) {
        vxs_servo_trace row;
        fill(&row, n);
        vxs_trace_push(trace, &row);
    }
    return NULL;
}

int main(void)
{
    vxs_trace *trace;
    CHECK_INT(vxs_trace_memory(0), 0);
    CHECK_INT(vxs_trace_memory(48), 0);
    size_t size = (vxs_trace_memory(ROWS) + 63) / 64 * 64;
    void *memory = aligned_alloc(64, size);
    CHECK(memory != NULL);
    CHECK_INT(vxs_trace_init(memory, size, 48, &trace), VXS_PARAM);
    CHECK_INT(vxs_trace_init(memory, vxs_trace_memory(ROWS) - 1, ROWS, &trace), VXS_BUFFER);
    CHECK_INT(vxs_trace_init(memory, size, ROWS, &trace), VXS_OK);

    vxs_servo_trace rows[50];
    CHECK_INT(vxs_trace_drain(trace, rows, 50), 0);
    for (uint64_t n = 0; n < ROWS + 10; n++) {
        vxs_servo_trace row;
        fill(&row, n);
        vxs_trace_push(trace, &row);
    }
    CHECK_INT(vxs_trace_dropped(trace), 10);
    CHECK_INT(vxs_trace_drain(trace, rows, 50), 50);
    CHECK_INT(rows[49].tick, 49);
    CHECK_INT(vxs_trace_drain(trace, rows, 50), 14);
    CHECK_INT(rows[13].tick, 63);

    CHECK_INT(vxs_trace_init(memory, size, ROWS, &trace), VXS_OK);
    pthread_t writer;
    CHECK(pthread_create(&writer, NULL, write_rows, trace) == 0);
    uint64_t taken = 0, next = 0;
    while (next < WRITES && taken + vxs_trace_dropped(trace) < WRITES) {
        size_t count = vxs_trace_drain(trace, rows, 50);
        for (size_t n = 0; n < count; n++) {
            vxs_servo_trace expected;
            CHECK(rows[n].tick >= next);
            fill(&expected, rows[n].tick);
            CHECK(memcmp(&rows[n], &expected, sizeof expected) == 0);
            next = rows[n].tick + 1;
        }
        taken += count;
    }
    CHECK(pthread_join(writer, NULL) == 0);
    taken += vxs_trace_drain(trace, rows, 50);
    taken += vxs_trace_drain(trace, rows, 50);
    CHECK_INT(taken + vxs_trace_dropped(trace), WRITES);
    free(memory);
    return 0;
}
