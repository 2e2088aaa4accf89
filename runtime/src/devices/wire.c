/* SPDX-License-Identifier: MIT
 *
 * Bytes from a device that the kernel shows as a file.
 */
#define _GNU_SOURCE 1 /* ppoll */
#include "wire.h"

#include <errno.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

int32_t vxsi_wire_read(int file, uint8_t *bytes, size_t most, int64_t wait_ns)
{
    struct pollfd wait = {.fd = file, .events = POLLIN};
    int64_t left = wait_ns > 0 ? wait_ns : 0;
    struct timespec time = {.tv_sec = (time_t)(left / 1000000000), .tv_nsec = (long)(left % 1000000000)};
    int ready = ppoll(&wait, 1, &time, NULL);
    if (ready < 0) return errno == EINTR ? 0 : VXS_LOST;
    if (ready == 0) return 0;
    if (wait.revents & POLLIN) {
        ssize_t count = read(file, bytes, most);
        if (count > 0) return (int32_t)count;
        if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    }
    return VXS_LOST;
}
