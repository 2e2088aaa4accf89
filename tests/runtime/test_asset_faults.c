/* SPDX-License-Identifier: MIT
 *
 * Each system call of opening fails in turn, is interrupted, gives less than asked: a clean error or the
 * right bytes, and nothing is kept. Too little address space, ten thousand openings.
 */
#define _DEFAULT_SOURCE 1    /* mkstemp, truncate */
#define _FILE_OFFSET_BITS 64 /* to 4 GiB, where words have 32 bits */

#include "asset_builder.h"
#include "check.h"

#include <dirent.h>
#include <errno.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* The names that the C library gives them where files may be large. */
int __real_open64(const char *path, int flags, ...);
ssize_t __real_read(int file, void *to, size_t size);
int __real_fstat64(int file, struct stat *status);
void *__real_mmap64(void *at, size_t size, int protection, int flags, int file, off_t offset);
int __real_munmap(void *at, size_t size);

int __wrap_open64(const char *path, int flags, ...);
ssize_t __wrap_read(int file, void *to, size_t size);
int __wrap_fstat64(int file, struct stat *status);
void *__wrap_mmap64(void *at, size_t size, int protection, int flags, int file, off_t offset);
int __wrap_munmap(void *at, size_t size);

/* Call number `fails` of those that are counted gives `error`; reads give at most `portion` bytes, after as
 * many interruptions as `interruptions` says, and nothing from `end` on. */
static struct {
    long calls, fails, reads;
    int error, interruptions;
    size_t portion, end, given;
    long mapped; /* [bytes] */
} fault;

static int is_failing(void)
{
    if (++fault.calls != fault.fails) return 0;
    errno = fault.error;
    return 1;
}

int __wrap_open64(const char *path, int flags, ...)
{
    return is_failing() ? -1 : __real_open64(path, flags);
}

ssize_t __wrap_read(int file, void *to, size_t size)
{
    if (is_failing()) return -1;
    if (fault.interruptions && ++fault.reads % (fault.interruptions + 1) != 0) {
        errno = EINTR;
        return -1;
    }
    if (fault.portion && size > fault.portion) size = fault.portion;
    if (fault.end && size > fault.end - fault.given) size = fault.end - fault.given;
    ssize_t got = __real_read(file, to, size);
    if (got > 0) fault.given += (size_t)got;
    return got;
}

int __wrap_fstat64(int file, struct stat *status)
{
    return is_failing() ? -1 : __real_fstat64(file, status);
}

void *__wrap_mmap64(void *at, size_t size, int protection, int flags, int file, off_t offset)
{
    if (is_failing()) return MAP_FAILED;
    void *memory = __real_mmap64(at, size, protection, flags, file, offset);
    if (memory != MAP_FAILED) fault.mapped += (long)size;
    return memory;
}

int __wrap_munmap(void *at, size_t size)
{
    fault.mapped -= (long)size;
    return __real_munmap(at, size);
}

static char path[] = "test_asset_faults_XXXXXX";
static built_asset bytes;

static int files_open(void)
{
    DIR *folder = opendir("/proc/self/fd");
    int count = 0;
    if (!folder) return 0;
    while (readdir(folder)) count++;
    closedir(folder);
    return count;
}

static vxs_result open_it(uint32_t mode, int *error)
{
    vxs_asset asset;
    vxs_asset_issue issue;
    vxs_asset_config config;
    vxs_asset_config_default(&config);
    config.mode = mode;
    vxs_result result = vxs_asset_open(path, &config, &asset, &issue);
    *error = issue.system_error;
    if (result == VXS_OK) {
        CHECK(memcmp(asset.data, bytes.data, bytes.size) == 0);
        vxs_asset_close(&asset);
    }
    CHECK(asset.data == NULL && issue.text);
    return result;
}

/* The k-th call fails, for every k that there is. */
static void check_each(uint32_t mode, int error)
{
    int files = files_open(), said;
    long tried = 0;
    for (long fails = 1;; fails++, tried++) {
        memset(&fault, 0, sizeof fault);
        fault.fails = fails;
        fault.error = error;
        vxs_result result = open_it(mode, &said);
        CHECK_INT(fault.mapped, 0);
        CHECK_INT(files_open(), files);
        if (fault.calls < fails) break;
        CHECK(error == EINTR || result == VXS_IO);
        CHECK(error == EINTR || said == error || said == EINVAL); /* EINVAL: it cannot be told what it is */
    }
    CHECK(tried >= (mode == VXS_ASSET_COPY ? 4 : 3));
}

static void check_reads(void)
{
    int said;
    for (size_t portion = 1; portion < 9; portion++) {
        memset(&fault, 0, sizeof fault);
        fault.portion = portion;
        fault.interruptions = (int)portion - 1;
        CHECK_INT(open_it(VXS_ASSET_COPY, &said), VXS_OK);
    }
    /* The file is shortened between its size and its bytes. */
    for (size_t end = 1; end < bytes.size; end += 1 + end / 3) {
        memset(&fault, 0, sizeof fault);
        fault.end = end;
        CHECK(open_it(VXS_ASSET_COPY, &said) != VXS_OK);
        CHECK_INT(fault.mapped, 0);
    }
    memset(&fault, 0, sizeof fault);
}

static long pages_used(void)
{
    long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file) return 0;
    CHECK(fscanf(file, "%ld", &pages) == 1);
    fclose(file);
    return pages;
}

static void check_cycles(void)
{
    int files = files_open(), said;
    long pages = 0;
    for (long n = 0; n < 10000; n++) {
        if (n == 100) pages = pages_used();
        CHECK_INT(open_it(n % 2 ? VXS_ASSET_MAP : VXS_ASSET_COPY, &said), VXS_OK);
    }
    CHECK_INT(files_open(), files);
    CHECK(pages_used() <= pages + 2000); /* an emulator takes some itself; a leak takes 50000 */
    CHECK_INT(fault.mapped, 0);
}

/* In a child, whose address space ends soon: a sparse file that does not fit. */
static void check_space(void)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return; /* they need terabytes of it */
#else
    int status;
    CHECK(truncate(path, (off_t)1 << 32) == 0);
    pid_t pid = fork();
    CHECK(pid >= 0);
    if (pid == 0) {
        struct rlimit limit = {(rlim_t)1 << 30, (rlim_t)1 << 30};
        CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
        if (mmap(NULL, (size_t)2 << 30, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED)
            _exit(0); /* an emulator does not keep to it */
        for (uint32_t mode = VXS_ASSET_MAP; mode <= VXS_ASSET_COPY; mode++) {
            int said;
            CHECK_INT(open_it(mode, &said), VXS_IO);
            CHECK_INT(said, sizeof(size_t) < 8 ? EFBIG : ENOMEM); /* 4 GiB is more than 32 bits can say */
        }
        _exit(0);
    }
    CHECK(waitpid(pid, &status, 0) == pid && WIFEXITED(status) && WEXITSTATUS(status) == 0);
    CHECK(truncate(path, (off_t)bytes.size) == 0);
#endif
}

int main(void)
{
    built_ball ball = {0.001, {0, 0, 0}, 0.0063};
    bytes = build_ball_map(&ball, BUILT_PLAIN);
    int file = mkstemp(path);
    CHECK(file >= 0 && write(file, bytes.data, bytes.size) == (ssize_t)bytes.size && close(file) == 0);
    static const int errors[] = {EIO, ENOMEM, EMFILE, EINTR};
    for (size_t n = 0; n < sizeof errors / sizeof *errors; n++) {
        check_each(VXS_ASSET_MAP, errors[n]);
        check_each(VXS_ASSET_COPY, errors[n]);
    }
    check_reads();
    check_cycles();
    check_space();
    CHECK(remove(path) == 0);
    built_free(&bytes);
    return 0;
}
