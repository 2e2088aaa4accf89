/* SPDX-License-Identifier: MIT
 *
 * mocked.h - the kernel's side of devices, played by this process for an unmodified client: a tree that stands
 * for /sys and /dev, and umockdev's preload, which sends each call on a node of it here, by its socket protocol
 * (the package umockdev alone; neither its library nor GLib).
 *
 * What cannot be had so: hot-plug events, and a kernel's timing, so there is no assertion on time.
 */
#ifndef VXS_TEST_MOCKED_H
#define VXS_TEST_MOCKED_H

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/* What the preload says and is told: three words each. */
enum {
    MOCKED_IOCTL = 1,        /* request, argument */
    MOCKED_RAN = 2,          /* result, errno: after MOCKED_RUN */
    MOCKED_DONE = 3,         /* result, errno */
    MOCKED_RUN = 4,          /* do it on the file itself */
    MOCKED_READ_MEMORY = 5,  /* address, size */
    MOCKED_WRITE_MEMORY = 6, /* address, size; then the bytes */
};

typedef struct mocked {
    char folder[128];
} mocked;

/* Whether umockdev is installed. */
int mocked_is_here(void);

void mocked_begin(mocked *m);
void mocked_end(const mocked *m);

/* Below the folder, with the folders above it. */
void mocked_put_bytes(const mocked *m, const char *path, const void *bytes, size_t size);
void mocked_put(const mocked *m, const char *path, const char *text);
void mocked_put_link(const mocked *m, const char *path, const char *target);

/* Where calls on a node ("/dev/hidraw0") arrive: a socket that does not block. */
int mocked_listen(const mocked *m, const char *node);

/* This program anew, with one argument, as this user, under the preload. */
pid_t mocked_run(const mocked *m, const char *argument, uid_t user);

int mocked_read(int file, void *bytes, size_t size);
int mocked_tell(int file, unsigned long command, unsigned long a, unsigned long b);

/* The monotonic clock [ns]; sleep. */
int64_t mocked_now(void);
void mocked_pause(long ms);

#endif
