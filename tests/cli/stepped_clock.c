/* SPDX-License-Identifier: MIT
 *
 * Before the program by LD_PRELOAD: the wall clock is stepped at each look by an hour, forth and back, and stands before
 * 1970 at times; the monotonic clock is the machine's. Each 64th look at the monotonic clock another time zone is
 * written to CLOCK_ZONE, the file that TZ names. CLOCK_LOOKS names a file that is told at the end how often each was
 * looked at: monotonic, wall.
 */
#define _GNU_SOURCE 1
#include <dlfcn.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static long monotonic, wall;

static time_t stepped(time_t now)
{
    static const long steps[] = {3600, -3600, 86400, -7200, 0, -4000000000};
    return now + steps[__atomic_fetch_add(&wall, 1, __ATOMIC_SEQ_CST) % 6];
}

/* A zone of so many hours: version 1 of a time zone's file, without a change. */
static void move_zone(long looks)
{
    const char *name = getenv("CLOCK_ZONE");
    int file = name ? open(name, O_WRONLY | O_CREAT | O_CLOEXEC, 0644) : -1;
    if (file < 0) return;
    unsigned char bytes[44 + 6 + 4] = "TZif";
    int offset = (int)(looks / 64 % 24 - 12) * 3600;
    bytes[39] = 1; /* one type */
    bytes[43] = 4; /* letters of its name */
    for (int n = 0; n < 4; n++) bytes[44 + n] = (unsigned char)((unsigned)offset >> (24 - 8 * n));
    bytes[50] = bytes[51] = bytes[52] = 'X';
    if (write(file, bytes, sizeof bytes) != (ssize_t)sizeof bytes) abort();
    close(file);
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    int result = real(clock, time);
    if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) {
        time->tv_sec = stepped(time->tv_sec);
    } else {
        long looks = __atomic_add_fetch(&monotonic, 1, __ATOMIC_SEQ_CST);
        if (looks % 64 == 1) move_zone(looks);
    }
    return result;
}

int gettimeofday(struct timeval *restrict time, void *restrict zone)
{
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    *time = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
    return 0;
}

time_t time(time_t *out)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out) *out = now.tv_sec;
    return now.tv_sec;
}

__attribute__((destructor)) static void tell(void)
{
    const char *name = getenv("CLOCK_LOOKS");
    FILE *file = name ? fopen(name, "w") : NULL;
    if (!file) return;
    fprintf(file, "%ld %ld\n", monotonic, wall);
    fclose(file);
}
