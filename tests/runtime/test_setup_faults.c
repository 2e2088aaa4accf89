/* SPDX-License-Identifier: MIT
 *
 * What the system refuses to set-up: a thread, a mapping, room on the disk, a place in the schedule; each under its own
 * name, and nothing left behind. The calls are wrapped by the linker.
 */
#define _GNU_SOURCE 1 /* pthread_setaffinity_np */

#include "servo_bench.h"
#include "voxshell/live.h"
#include "voxshell/recorder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static const char path[] = "test_setup_faults.tmp";

/* Error numbers that calls give, 0: they do what they do. */
static struct {
    int thread, map, truncate, stat, unlink, open, fopen, write, schedule, lock, affinity;
} fails;
static int pinned_to;

static int failing(int error)
{
    errno = error;
    return error != 0;
}

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *argument);
void *__real_mmap(void *at, size_t size, int protection, int flags, int file, off_t offset);
int __real_ftruncate(int file, off_t size);
int __real_fstat(int file, struct stat *about);
int __real_unlink(const char *name);
int __real_open(const char *name, int flags, ...);
FILE *__real_fopen(const char *name, const char *mode);
size_t __real_fwrite(const void *from, size_t size, size_t count, FILE *file);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *argument);
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int file, off_t offset);
int __wrap_ftruncate(int file, off_t size);
int __wrap_fstat(int file, struct stat *about);
int __wrap_unlink(const char *name);
int __wrap_open(const char *name, int flags, ...);
FILE *__wrap_fopen(const char *name, const char *mode);
size_t __wrap_fwrite(const void *from, size_t size, size_t count, FILE *file);
int __wrap_pthread_setschedparam(pthread_t thread, int policy, const struct sched_param *parameter);
int __wrap_pthread_setaffinity_np(pthread_t thread, size_t size, const cpu_set_t *set);
int __wrap_mlockall(int flags);

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *argument)
{
    return fails.thread ? fails.thread : __real_pthread_create(thread, how, run, argument);
}

void *__wrap_mmap(void *at, size_t size, int protection, int flags, int file, off_t offset)
{
    return failing(fails.map) ? MAP_FAILED : __real_mmap(at, size, protection, flags, file, offset);
}

int __wrap_ftruncate(int file, off_t size)
{
    return failing(fails.truncate) ? -1 : __real_ftruncate(file, size);
}

int __wrap_fstat(int file, struct stat *about)
{
    return failing(fails.stat) ? -1 : __real_fstat(file, about);
}

int __wrap_unlink(const char *name)
{
    return failing(fails.unlink) ? -1 : __real_unlink(name);
}

int __wrap_open(const char *name, int flags, ...)
{
    va_list list;
    va_start(list, flags);
    int mode = flags & O_CREAT ? va_arg(list, int) : 0;
    va_end(list);
    return failing(fails.open) ? -1 : __real_open(name, flags, mode);
}

FILE *__wrap_fopen(const char *name, const char *mode)
{
    return failing(fails.fopen) ? NULL : __real_fopen(name, mode);
}

/* The disk is full from call number `write` on. */
size_t __wrap_fwrite(const void *from, size_t size, size_t count, FILE *file)
{
    if (fails.write == 1 && failing(ENOSPC)) return 0;
    if (fails.write > 1) fails.write--;
    return __real_fwrite(from, size, count, file);
}

int __wrap_pthread_setschedparam(pthread_t thread, int policy, const struct sched_param *parameter)
{
    CHECK(pthread_equal(thread, pthread_self()) && policy == SCHED_FIFO && parameter->sched_priority > 0);
    return fails.schedule;
}

int __wrap_pthread_setaffinity_np(pthread_t thread, size_t size, const cpu_set_t *set)
{
    CHECK(pthread_equal(thread, pthread_self()) && size == sizeof *set && CPU_COUNT(set) == 1);
    for (int n = 0; n < CPU_SETSIZE; n++)
        if (CPU_ISSET((size_t)n, set)) pinned_to = n;
    return fails.affinity;
}

int __wrap_mlockall(int flags)
{
    CHECK_INT(flags, MCL_CURRENT);
    return failing(fails.lock) ? -1 : 0;
}

static int files_open(void)
{
    int count = 0;
    DIR *folder = opendir("/proc/self/fd");
    CHECK(folder);
    while (readdir(folder)) count++;
    closedir(folder);
    return count;
}

static int is_there(void)
{
    return access(path, F_OK) == 0;
}

/* --- the live state --- */

static void check_live(void)
{
    static const struct {
        int error;
        vxs_result result;
    } refusals[] = {{EACCES, VXS_ACCESS}, {EPERM, VXS_ACCESS}, {EROFS, VXS_IO}, {EMFILE, VXS_IO}};
    vxs_live live, reader;
    const int files = files_open();
    memset(&fails, 0, sizeof fails);
    for (int n = 0; n < 4; n++) {
        fails.unlink = refusals[n].error;
        CHECK_INT(vxs_live_create(&live, path), refusals[n].result);
        fails.unlink = 0;
        fails.open = refusals[n].error;
        CHECK_INT(vxs_live_create(&live, path), refusals[n].result);
        CHECK_INT(vxs_live_open(&live, path), refusals[n].result);
        fails.open = 0;
        CHECK(!is_there() && !live.memory);
    }
    fails.truncate = ENOSPC;
    CHECK_INT(vxs_live_create(&live, path), VXS_IO);
    CHECK(!is_there());
    fails.truncate = 0;
    fails.map = ENOMEM;
    CHECK_INT(vxs_live_create(&live, path), VXS_IO);
    CHECK(!is_there() && !live.memory);
    fails.map = 0;
    CHECK_INT(vxs_live_create(&live, path), VXS_OK);
    fails.map = ENOMEM;
    CHECK_INT(vxs_live_open(&reader, path), VXS_IO);
    fails.map = 0;
    fails.stat = EIO;
    CHECK_INT(vxs_live_open(&reader, path), VXS_TRUNCATED);
    fails.stat = 0;
    CHECK_INT(vxs_live_open(&reader, path), VXS_OK);
    vxs_live_close(&reader);

    /* Another version's rows; then another file altogether. */
    FILE *file = fopen(path, "r+b");
    uint8_t head[64];
    CHECK(file && fread(head, 1, sizeof head, file) == sizeof head);
    const uint32_t size = sizeof(vxs_servo_trace);
    size_t at = 8;
    while (at + 4 <= sizeof head && memcmp(head + at, &size, 4) != 0) at += 4;
    CHECK(at + 4 <= sizeof head);
    head[at]++;
    CHECK(fseek(file, 0, SEEK_SET) == 0 && fwrite(head, 1, sizeof head, file) == sizeof head &&
          fflush(file) == 0);
    CHECK_INT(vxs_live_open(&reader, path), VXS_VERSION);
    head[0]++;
    CHECK(fseek(file, 0, SEEK_SET) == 0 && fwrite(head, 1, sizeof head, file) == sizeof head &&
          fclose(file) == 0);
    CHECK_INT(vxs_live_open(&reader, path), VXS_MAGIC);
    CHECK(!reader.memory);
    vxs_live_close(&live);
    vxs_live_close(&live); /* it is closed */
    CHECK(!is_there());
    CHECK_INT(files_open(), files);
}

/* --- the recorder --- */

static atomic_int turns; /* of its thread, which does not sleep here */

int __wrap_nanosleep(const struct timespec *time, struct timespec *left);
int __wrap_nanosleep(const struct timespec *time, struct timespec *left)
{
    CHECK(time->tv_nsec > 0 && !left);
    atomic_fetch_add(&turns, 1);
    return sched_yield();
}

static void wait_for_turns(void)
{
    const int before = atomic_load(&turns);
    while (atomic_load(&turns) < before + 2) sched_yield();
}

static void check_recorder(void)
{
    const int files = files_open();
    vxs_trace *trace = NULL;
    vxs_recorder *recorder = NULL;
    void *ring = aligned_alloc(64, (vxs_trace_memory(16) + 63) / 64 * 64);
    void *memory = aligned_alloc(64, vxs_recorder_memory());
    vxs_servo_trace row;
    uint64_t rows = 99;
    memset(&row, 0, sizeof row);
    memset(&fails, 0, sizeof fails);
    CHECK_INT(vxs_trace_init(ring, vxs_trace_memory(16), 16, &trace), VXS_OK);
    static const int errors[][2] = {{EACCES, VXS_ACCESS}, {EPERM, VXS_ACCESS}, {ENOSPC, VXS_IO}};
    for (int n = 0; n < 3; n++) {
        fails.fopen = errors[n][0];
        CHECK_INT(vxs_recorder_start(memory, vxs_recorder_memory(), path, trace, &recorder), errors[n][1]);
    }
    fails.fopen = 0;
    fails.thread = EAGAIN;
    CHECK_INT(vxs_recorder_start(memory, vxs_recorder_memory(), path, trace, &recorder), VXS_NO_THREAD);
    CHECK(!is_there() && !recorder);
    fails.thread = 0;

    /* The head, its second half, the first rows, later ones do not fit: it says so at the end, and how many did; and
     * goes on emptying the ring. */
    for (int call = 1; call <= 4; call++) {
        const uint64_t dropped = vxs_trace_dropped(trace);
        fails.write = call;
        CHECK_INT(vxs_recorder_start(memory, vxs_recorder_memory(), path, trace, &recorder), VXS_OK);
        for (int batch = 0; batch < 3; batch++) {
            for (int n = 0; n < 16; n++) vxs_trace_push(trace, &row);
            wait_for_turns();
        }
        CHECK_INT(vxs_recorder_stop(recorder, &rows), VXS_IO);
        CHECK(call < 4 ? rows == 0 : rows > 0 && rows < 48);
        CHECK_INT(vxs_trace_dropped(trace), dropped);
        fails.write = 0;
        CHECK(is_there() && remove(path) == 0);
    }
    CHECK_INT(vxs_recorder_start(memory, vxs_recorder_memory(), path, trace, &recorder), VXS_OK);
    CHECK_INT(vxs_recorder_stop(recorder, NULL), VXS_OK);
    CHECK(remove(path) == 0);
    CHECK_INT(files_open(), files);
    free(ring);
    free(memory);
}

/* --- the servo thread --- */

static void check_thread(void)
{
    servo_bench b;
    vxs_servo_thread_config config;
    vxs_servo_thread *thread = NULL;
    vxs_servo_thread_status status;
    vxs_live live, reader;
    void *memory = aligned_alloc(64, (vxs_servo_thread_memory() + 63) / 64 * 64);
    bench_prepare(&b);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    vxs_servo_thread_config_default(&config);
    config.device = b.device;
    config.servo = b.servo;
    config.max_ticks = 5;
    config.priority = 10;
    config.cpu = 0;
    memset(&fails, 0, sizeof fails);
    CHECK_INT(vxs_live_create(&live, path), VXS_OK);
    CHECK_INT(vxs_live_open(&reader, path), VXS_OK);
    config.live = &live;
    fails.thread = EAGAIN;
    CHECK_INT(vxs_servo_thread_start(memory, vxs_servo_thread_memory(), &config, &thread), VXS_NO_THREAD);
    CHECK(!thread);
    fails.thread = 0;

    /* What is not granted is said, and the loop runs on without. */
    for (int refused = 0; refused < 8; refused++) {
        fails.schedule = refused & 1 ? EPERM : 0;
        fails.lock = refused & 2 ? ENOMEM : 0;
        fails.affinity = refused & 4 ? EINVAL : 0;
        config.lock_memory = 1;
        pinned_to = -1;
        CHECK_INT(vxs_servo_thread_start(memory, vxs_servo_thread_memory(), &config, &thread), VXS_OK);
        do vxs_servo_thread_get(thread, &status);
        while (status.running);
        vxs_servo_thread_stop(thread);
        vxs_servo_thread_get(thread, &status);
        CHECK_INT(status.ticks, 5);
        CHECK(status.is_realtime == !(refused & 1) && status.is_locked == !(refused & 2) &&
              status.is_pinned == !(refused & 4));
        CHECK((strstr(status.scheduling_text, "not allowed") != NULL) == !status.is_realtime);
        CHECK((strstr(status.memory_text, "not locked") != NULL) == !status.is_locked);
        CHECK_INT(pinned_to, 0);
        vxs_servo_trace row;
        CHECK(vxs_live_get(&reader, &row) > 0);
        CHECK_INT(row.tick, 5 * (refused + 1) - 1);
    }
    config.cpu = CPU_SETSIZE; /* there is none such: it is as if none were asked for */
    config.live = NULL;
    pinned_to = -1;
    CHECK_INT(vxs_servo_thread_start(memory, vxs_servo_thread_memory(), &config, &thread), VXS_OK);
    do vxs_servo_thread_get(thread, &status);
    while (status.running);
    vxs_servo_thread_stop(thread);
    CHECK(!status.is_pinned && pinned_to == -1);
    vxs_live_close(&reader);
    vxs_live_close(&live);
    bench_close(&b);
    free(memory);
}

int main(void)
{
    check_live();
    check_recorder();
    check_thread();
    return 0;
}
