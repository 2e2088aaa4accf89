/* SPDX-License-Identifier: MIT
 *
 * 100 000 ticks, in contact and out of it, with every law and coupling: not one allocation.
 * malloc and its kin are wrapped by the linker and counted.
 */
#include "servo_bench.h"

static long calls;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void __real_free(void *memory);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void __wrap_free(void *memory);

void *__wrap_malloc(size_t size)
{
    calls++;
    return __real_malloc(size);
}
void *__wrap_calloc(size_t count, size_t size)
{
    calls++;
    return __real_calloc(count, size);
}
void *__wrap_realloc(void *memory, size_t size)
{
    calls++;
    return __real_realloc(memory, size);
}
void __wrap_free(void *memory)
{
    calls++;
    __real_free(memory);
}

int main(void)
{
    void *volatile used = malloc(1);
    free(used);
    CHECK_INT(calls, 2); /* the wrap is in place */
    long contacts = 0, ticks = 0;
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_SPRING_DAMPER; kind++) {
        for (uint32_t law = VXS_CONTACT_ORIGINAL; law <= VXS_CONTACT_AVERAGE; law++) {
            servo_bench b;
            bench_prepare(&b);
            b.servo_config.coupling.kind = kind;
            b.servo_config.contact.law = law;
            bench_open(&b);
            CHECK_INT(vxs_device_arm(b.device), VXS_OK);
            long before = calls;
            for (int k = 0; k < 17000; k++, ticks++) {
                vxs_servo_trace row;
                bench_tick(&b, 0.0105 - 0.0018 * (k % 1000 < 700), &row);
                contacts += row.points > 0;
            }
            CHECK_INT(calls, before);
            bench_close(&b);
        }
    }
    CHECK(ticks >= 100000 && contacts > ticks / 10);
    return 0;
}
