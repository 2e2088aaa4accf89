/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE 1

#include "mocked.h"

#include "check.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

int64_t mocked_now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

void mocked_pause(long ms)
{
    struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    nanosleep(&time, NULL);
}

int mocked_is_here(void)
{
    return system("LD_PRELOAD=libumockdev-preload.so.0 true 2>&1 | grep -q preload") != 0;
}

void mocked_begin(mocked *m)
{
    strcpy(m->folder, "/tmp/vxs_mocked_XXXXXX");
    CHECK(mkdtemp(m->folder) && chmod(m->folder, 0755) == 0);
}

void mocked_end(const mocked *m)
{
    char command[256];
    snprintf(command, sizeof command, "rm -r '%s'", m->folder);
    CHECK(system(command) == 0);
}

void mocked_put_bytes(const mocked *m, const char *path, const void *bytes, size_t size)
{
    char whole[256];
    snprintf(whole, sizeof whole, "%s/%s", m->folder, path);
    for (char *slash = whole + strlen(m->folder) + 1; (slash = strchr(slash, '/')); slash++) {
        *slash = 0;
        mkdir(whole, 0755);
        *slash = '/';
    }
    FILE *file = fopen(whole, "wb");
    CHECK(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
}

void mocked_put(const mocked *m, const char *path, const char *text)
{
    mocked_put_bytes(m, path, text, strlen(text));
}

void mocked_put_link(const mocked *m, const char *path, const char *target)
{
    char whole[256];
    snprintf(whole, sizeof whole, "%s/%s", m->folder, path);
    CHECK(symlink(target, whole) == 0);
}

int mocked_listen(const mocked *m, const char *node)
{
    struct sockaddr_un where = {.sun_family = AF_UNIX};
    size_t size = (size_t)snprintf(where.sun_path, sizeof where.sun_path, "%s/ioctl%s", m->folder, node);
    CHECK(size < sizeof where.sun_path);
    int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    CHECK(listener >= 0 && bind(listener, (struct sockaddr *)&where, sizeof where) == 0 &&
          listen(listener, 32) == 0);
    CHECK(chmod(where.sun_path, 0666) == 0); /* umockdev wants it even of a node that may not be opened */
    fcntl(listener, F_SETFL, O_NONBLOCK);
    return listener;
}

pid_t mocked_run(const mocked *m, const char *argument, uid_t user)
{
    pid_t child = fork();
    if (child != 0) return child;
    CHECK(user == getuid() || setuid(user) == 0);
    setenv("UMOCKDEV_DIR", m->folder, 1);
    setenv("LD_PRELOAD", "libumockdev-preload.so.0", 1);
    setenv("SYSTEMD_DEVICE_VERIFY_SYSFS", "0", 1);
    setenv("ASAN_OPTIONS", "verify_asan_link_order=0", 1);
    prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
    execl("/proc/self/exe", "client", argument, (char *)NULL);
    _exit(127);
}

int mocked_read(int file, void *bytes, size_t size)
{
    for (size_t done = 0; done < size;) {
        ssize_t count = read(file, (uint8_t *)bytes + done, size - done);
        if (count <= 0) return 0;
        done += (size_t)count;
    }
    return 1;
}

int mocked_tell(int file, unsigned long command, unsigned long a, unsigned long b)
{
    unsigned long message[3] = {command, a, b};
    return write(file, message, sizeof message) == (ssize_t)sizeof message;
}
