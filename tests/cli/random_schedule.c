/* SPDX-License-Identifier: MIT
 *
 * LD_PRELOAD: threads that take turns as a generator says, another for each VXS_SCHEDULE. A thread that is about to take memory or a
 * lock, lets one go, waits for another (a futex) or begins, sometimes gives its place away or sleeps a little.
 */
#define _GNU_SOURCE 1
#include <dlfcn.h>
#include <pthread.h>
#include <sched.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

void *__libc_malloc(size_t size);

static uint64_t next_number(void)
{
    static __thread uint64_t state;
    if (!state) {
        const char *seed = getenv("VXS_SCHEDULE");
        state = (uint64_t)(uintptr_t)&state ^ (seed ? strtoull(seed, NULL, 10) + 1 : 1) * 0x9E3779B97F4A7C15u;
    }
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state >> 16;
}

/* Once in `often` the place is given away, once in sixteen of these for up to a tenth of a millisecond. */
static void hesitate(uint32_t often)
{
    const uint64_t number = next_number();
    if (number % often) return;
    const struct timespec pause = {0, (long)(number / often % 100000)};
    if (number / often % 16 == 0)
        nanosleep(&pause, NULL);
    else
        sched_yield();
}

#define REAL(name, type)                                                                                     \
    static __typeof__(type) real;                                                                            \
    if (!real) real = (__typeof__(type))dlsym(RTLD_NEXT, name)

void *malloc(size_t size)
{
    hesitate(500);
    return __libc_malloc(size);
}

int pthread_mutex_lock(pthread_mutex_t *mutex)
{
    REAL("pthread_mutex_lock", int (*)(pthread_mutex_t *));
    hesitate(4);
    return real(mutex);
}

int pthread_mutex_unlock(pthread_mutex_t *mutex)
{
    REAL("pthread_mutex_unlock", int (*)(pthread_mutex_t *));
    const int result = real(mutex);
    hesitate(4);
    return result;
}

typedef struct beginning {
    void *(*run)(void *);
    void *self;
} beginning;

static void *begin(void *given)
{
    const beginning it = *(beginning *)given;
    free(given);
    const struct timespec pause = {0, (long)(next_number() % 3000000)};
    nanosleep(&pause, NULL);
    return it.run(it.self);
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *self)
{
    REAL("pthread_create", int (*)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *));
    beginning *it = __libc_malloc(sizeof *it);
    *it = (beginning){run, self};
    return real(thread, attributes, begin, it);
}

/* TBB waits by futex, through this. */
long syscall(long number, ...)
{
    REAL("syscall", long (*)(long, ...));
    va_list list;
    va_start(list, number);
    long a[6];
    for (int n = 0; n < 6; n++) a[n] = va_arg(list, long);
    va_end(list);
    hesitate(2);
    return real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
