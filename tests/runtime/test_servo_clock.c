/* SPDX-License-Identifier: MIT
 *
 * The wall-clock loop on a clock of the test's own (clock_gettime and clock_nanosleep are wrapped by the linker):
 * at rates from 100 Hz to 10 kHz every wake-up is due at start + n periods to the nanosecond, however late those
 * before came; periods that an overrun took are counted and skipped, never caught up; a signal wakes nobody early.
 */
#define _GNU_SOURCE 1
#include "servo_bench.h"

#include <errno.h>
#include <time.h>

enum { TICKS = 2000 };

/* The servo thread's alone while it runs. */
static struct {
    int64_t now_ns, due_ns[TICKS];
    uint64_t random;
    int64_t late_ns;    /* of a wake-up, at most */
    int64_t overrun_ns; /* that every 100th tick takes */
    int count, interruptions;
} fake;

int __wrap_clock_gettime(clockid_t clock, struct timespec *time);
int __wrap_clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left);

int __wrap_clock_gettime(clockid_t clock, struct timespec *time)
{
    CHECK_INT(clock, CLOCK_MONOTONIC);
    *time = (struct timespec){.tv_sec = (time_t)(fake.now_ns / 1000000000),
                              .tv_nsec = (long)(fake.now_ns % 1000000000)};
    return 0;
}

int __wrap_clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left)
{
    (void)left;
    CHECK(clock == CLOCK_MONOTONIC && flags == TIMER_ABSTIME);
    int64_t due = (int64_t)until->tv_sec * 1000000000 + until->tv_nsec;
    fake.random = fake.random * 6364136223846793005u + 1442695040888963407u;
    if (fake.random >> 60 == 0) { /* a signal, before it is time */
        fake.interruptions++;
        return EINTR;
    }
    CHECK(fake.count < TICKS);
    fake.due_ns[fake.count++] = due;
    if (due > fake.now_ns) fake.now_ns = due;
    fake.now_ns += (int64_t)(fake.random >> 33) % (fake.late_ns + 1);
    return 0;
}

static void work(void *user, uint64_t tick)
{
    (void)user;
    fake.now_ns += 7000;
    if (tick % 100 == 50) fake.now_ns += fake.overrun_ns;
}

static void run(servo_bench *b, double rate_hz, double late, double overrun)
{
    size_t size = (vxs_servo_thread_memory() + 63) / 64 * 64;
    void *memory = aligned_alloc(64, size);
    vxs_servo_thread_config config;
    vxs_servo_thread *thread;
    vxs_servo_thread_status status;
    vxs_servo_thread_config_default(&config);
    config.device = b->device;
    config.servo = b->servo;
    config.on_tick = work;
    config.rate_hz = rate_hz;
    config.max_ticks = TICKS;
    config.priority = 0;
    config.lock_memory = 0;
    const int64_t start = 987654321, period = llround(1e9 / rate_hz);
    memset(&fake, 0, sizeof fake);
    fake.now_ns = start;
    fake.late_ns = (int64_t)(late * (double)period);
    fake.overrun_ns = (int64_t)(overrun * (double)period);
    CHECK_INT(vxs_servo_thread_start(memory, size, &config, &thread), VXS_OK);
    do vxs_servo_thread_get(thread, &status);
    while (status.running);
    vxs_servo_thread_stop(thread);
    vxs_servo_thread_get(thread, &status);

    CHECK_INT(status.ticks, TICKS);
    CHECK_INT(fake.count, TICKS);
    CHECK(fake.interruptions > 0);
    uint64_t skipped = 0, seen = 0;
    for (int n = 0; n < TICKS; n++) {
        int64_t since = fake.due_ns[n] - start;
        CHECK_INT(since % period, 0); /* on the grid of the first */
        CHECK(since / period >= n + 1);
        CHECK(n == 0 || fake.due_ns[n] > fake.due_ns[n - 1]);
        skipped = (uint64_t)(since / period - (n + 1));
    }
    CHECK_INT(status.missed, skipped);
    if (overrun < 1) CHECK_INT(skipped, 0);
    if (overrun > 1) CHECK(skipped >= (uint64_t)(overrun - 1) * (TICKS / 100));
    for (int n = 0; n < VXS_SERVO_THREAD_BINS; n++) seen += status.lateness.bins[n];
    CHECK_INT(seen, TICKS);
    /* What is not over when the next is due makes that one late, by less than a period. */
    CHECK(status.lateness.max_ns <= (uint64_t)(period + fake.late_ns));
    CHECK(late == 0 || status.lateness.max_ns > (uint64_t)fake.late_ns / 2);
    CHECK(status.work.max_ns >= (uint64_t)fake.overrun_ns &&
          status.work.max_ns <= (uint64_t)fake.overrun_ns + 7000);
    printf("%5.0f Hz: last wake-up due %lld periods after the start, %llu skipped, %d signals\n", rate_hz,
           (long long)((fake.due_ns[TICKS - 1] - start) / period), (unsigned long long)skipped,
           fake.interruptions);
    free(memory);
}

int main(void)
{
    static const double rates[] = {100, 333, 500, 1000, 3000, 4000, 10000};
    servo_bench b;
    bench_prepare(&b);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    for (size_t n = 0; n < sizeof rates / sizeof *rates; n++) {
        run(&b, rates[n], 0, 0);
        run(&b, rates[n], 0.9, 0);
        run(&b, rates[n], 0.5, 3.6);
    }
    run(&b, 1000, 0, 4e6); /* a machine that sleeps for more than an hour, 20 times: beyond the last bin */
    bench_close(&b);
    return 0;
}
