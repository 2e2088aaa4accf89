/* SPDX-License-Identifier: MIT
 *
 * Before the program by LD_PRELOAD: call number FAULT_AT of FAULT_CALL (write, fsync, rename) to a regular
 * file fails with error number FAULT_ERRNO, from then on for good; with FAULT_SHORT no write takes more bytes
 * than that, and every other one is interrupted first. FAULT_COUNT names a file that is told how many calls
 * there were.
 */
#define _GNU_SOURCE 1
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static long calls, writes;

static long number(const char *name)
{
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

static int is_failing(const char *call)
{
    const char *wanted = getenv("FAULT_CALL");
    if (!wanted || strcmp(wanted, call) != 0) return 0;
    long now = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST), at = number("FAULT_AT");
    if (!at || now < at) return 0;
    errno = (int)number("FAULT_ERRNO");
    return 1;
}

static int is_file(int file)
{
    struct stat status;
    return file > 2 && fstat(file, &status) == 0 && S_ISREG(status.st_mode);
}

/* How many bytes to take of a write, -1: none, with an error. */
static ssize_t share(int file, size_t size)
{
    if (!is_file(file)) return (ssize_t)size;
    if (is_failing("write")) return -1;
    long most = number("FAULT_SHORT");
    if (most && __atomic_add_fetch(&writes, 1, __ATOMIC_SEQ_CST) % 2) {
        errno = EINTR;
        return -1;
    }
    return most && size > (size_t)most ? (ssize_t)most : (ssize_t)size;
}

ssize_t write(int file, const void *bytes, size_t size)
{
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) real = (ssize_t(*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write");
    ssize_t taken = share(file, size);
    return taken < 0 ? -1 : real(file, bytes, (size_t)taken);
}

ssize_t writev(int file, const struct iovec *parts, int count)
{
    static ssize_t (*real)(int, const struct iovec *, int);
    if (!real) real = (ssize_t(*)(int, const struct iovec *, int))dlsym(RTLD_NEXT, "writev");
    size_t size = 0;
    for (int n = 0; n < count; n++) size += parts[n].iov_len;
    ssize_t taken = share(file, size);
    if (taken < 0) return -1;
    if ((size_t)taken == size) return real(file, parts, count);
    int n = 0;
    while (n < count && parts[n].iov_len == 0) n++;
    size_t first = parts[n].iov_len < (size_t)taken ? parts[n].iov_len : (size_t)taken;
    return write(file, parts[n].iov_base, first);
}

int fsync(int file)
{
    static int (*real)(int);
    if (!real) real = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
    return is_file(file) && is_failing("fsync") ? -1 : real(file);
}

int rename(const char *from, const char *to)
{
    static int (*real)(const char *, const char *);
    if (!real) real = (int (*)(const char *, const char *))dlsym(RTLD_NEXT, "rename");
    return is_failing("rename") ? -1 : real(from, to);
}

__attribute__((destructor)) static void tell(void)
{
    const char *path = getenv("FAULT_COUNT");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    fprintf(file, "%ld\n", calls);
    fclose(file);
}
