/* SPDX-License-Identifier: MIT
 *
 * The wall-clock loop, briefly: it runs as often as it says, stops when asked, tells what it was
 * granted. No assertion on timing: that is the machine's affair.
 */
#include "servo_bench.h"

static const double low = 0.0088;

static void move_hand(void *user, uint64_t tick)
{
    servo_bench *b = user;
    const double target[3] = {0, tick < 20 ? 0.012 : low, 0};
    vxs_simulated_hand(b->device, target, NULL);
}

static uint64_t sum_of(const vxs_servo_thread_histogram *histogram)
{
    uint64_t sum = 0;
    for (int n = 0; n < VXS_SERVO_THREAD_BINS; n++) sum += histogram->bins[n];
    return sum;
}

int main(void)
{
    servo_bench b;
    bench_prepare(&b);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    size_t ring_size = vxs_trace_memory(1024), size = (vxs_servo_thread_memory() + 63) / 64 * 64;
    void *ring = aligned_alloc(64, (ring_size + 63) / 64 * 64), *memory = aligned_alloc(64, size);
    CHECK(ring && memory);
    vxs_servo_thread_config config;
    vxs_servo_thread_config_default(&config);
    vxs_servo_thread *thread;
    CHECK_INT(vxs_servo_thread_start(memory, size, &config, &thread), VXS_PARAM); /* no device, no servo */
    config.device = b.device;
    config.servo = b.servo;
    CHECK_INT(vxs_trace_init(ring, ring_size, 1024, &config.trace), VXS_OK);
    config.on_tick = move_hand;
    config.user = &b;
    config.rate_hz = 99;
    CHECK_INT(vxs_servo_thread_start(memory, size, &config, &thread), VXS_PARAM);
    config.rate_hz = 2000;
    CHECK_INT(vxs_servo_thread_start(memory, size - 64, &config, &thread), VXS_BUFFER);
    config.struct_size--;
    CHECK_INT(vxs_servo_thread_start(memory, size, &config, &thread), VXS_CONFIG);
    config.struct_size++;

    /* A number of ticks, then it ends by itself. */
    config.max_ticks = 800;
    CHECK_INT(vxs_servo_thread_start(memory, size, &config, &thread), VXS_OK);
    vxs_servo_thread_status status;
    vxs_servo_trace rows[100];
    uint64_t next = 0;
    do {
        vxs_servo_thread_get(thread, &status);
        size_t count = vxs_trace_drain(config.trace, rows, 100);
        for (size_t n = 0; n < count; n++) CHECK_INT(rows[n].tick, next++);
    } while (status.running);
    vxs_servo_thread_stop(thread);
    vxs_servo_thread_get(thread, &status);
    CHECK_INT(status.ticks, 800);
    CHECK_INT(sum_of(&status.lateness), 800);
    CHECK_INT(sum_of(&status.work), 800);
    CHECK(strlen(status.scheduling_text) > 3 && strlen(status.memory_text) > 3);
    CHECK(status.is_realtime == (strcmp(status.scheduling_text, "SCHED_FIFO") == 0));
    CHECK(!(status.seen_flags & VXS_SERVO_FAULT));
    printf("%s; memory %s; %llu missed, late by %.0f us at most, work %.0f us at most\n",
           status.scheduling_text, status.memory_text, (unsigned long long)status.missed,
           (double)status.lateness.max_ns / 1e3, (double)status.work.max_ns / 1e3);
    for (size_t count; (count = vxs_trace_drain(config.trace, rows, 100)) > 0;) {
        for (size_t n = 0; n < count; n++) CHECK_INT(rows[n].tick, next++);
    }
    CHECK_INT(next + vxs_trace_dropped(config.trace), 800);

    /* Without an end: until asked. */
    config.max_ticks = 0;
    config.priority = 0;
    config.lock_memory = 0;
    config.trace = NULL;
    config.on_tick = NULL;
    CHECK_INT(vxs_servo_thread_start(memory, size, &config, &thread), VXS_OK);
    do vxs_servo_thread_get(thread, &status);
    while (status.ticks < 20);
    vxs_servo_thread_stop(thread);
    vxs_servo_thread_get(thread, &status);
    CHECK(!status.running && !status.is_realtime && !status.is_locked);
    /* The last exchange told the device to let go. */
    vxs_device_report report;
    vxs_device_exchange(b.device, NULL, &b.state, &report);
    CHECK(report.rendered.force[1] == 0);
    free(ring);
    free(memory);
    bench_close(&b);
    return 0;
}
