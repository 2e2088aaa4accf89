/* SPDX-License-Identifier: MIT
 *
 * A wire that is a tty, raw, held by one process.
 */
#define _GNU_SOURCE 1 /* cfmakeraw, flock */

#include "wire.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

static vxs_result result_of(int error)
{
    switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
        return VXS_NO_DEVICE;
    case EACCES:
    case EPERM:
        return VXS_ACCESS;
    case EBUSY:
    case EWOULDBLOCK:
        return VXS_BUSY;
    default:
        return VXS_IO;
    }
}

/* A packet goes as a whole or not at all: a half would break the frame for good on a wire without length. */
static vxs_result send_bytes(void *self, const uint8_t *bytes, size_t size)
{
    vxsi_tty *tty = self;
    ssize_t count = write(tty->file, bytes, size);
    if (count == (ssize_t)size) return VXS_OK;
    if (count < 0) return errno == EAGAIN || errno == EINTR ? VXS_BUSY : VXS_LOST;
    for (size_t done = (size_t)count; done < size;) {
        struct pollfd wait = {.fd = tty->file, .events = POLLOUT};
        if (poll(&wait, 1, 5) <= 0 || wait.revents & (POLLERR | POLLHUP)) return VXS_LOST;
        count = write(tty->file, bytes + done, size - done);
        if (count < 0 && errno != EAGAIN && errno != EINTR) return VXS_LOST;
        done += count > 0 ? (size_t)count : 0;
    }
    return VXS_OK;
}

static int32_t receive_bytes(void *self, uint8_t *bytes, size_t most, int64_t wait_ns)
{
    return vxsi_wire_read(((const vxsi_tty *)self)->file, bytes, most, wait_ns);
}

static void close_tty(void *self)
{
    vxsi_tty *tty = self;
    ioctl(tty->file, TIOCNXCL);
    close(tty->file);
    tty->file = -1;
}

static const vxsi_wire_ops ops = {
    .name = "tty", .send = send_bytes, .receive = receive_bytes, .close = close_tty};

vxs_result vxsi_tty_open(vxsi_tty *tty, const char *path, vxsi_wire *wire)
{
    int file = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return result_of(errno);
    struct termios mode;
    vxs_result result = VXS_OK;
    if (flock(file, LOCK_EX | LOCK_NB) != 0) {
        result = result_of(errno);
    } else if (tcgetattr(file, &mode) != 0) {
        result = VXS_NO_DEVICE; /* a file, but no tty */
    } else {
        ioctl(file, TIOCEXCL);
        cfmakeraw(&mode);
        mode.c_cc[VMIN] = 1;
        mode.c_cc[VTIME] = 0;
        cfsetispeed(&mode, B115200); /* CDC-ACM takes any */
        cfsetospeed(&mode, B115200);
        if (tcsetattr(file, TCSANOW, &mode) != 0) result = VXS_IO;
        tcflush(file, TCIOFLUSH);
    }
    if (result != VXS_OK) {
        close(file);
        return result;
    }
    tty->file = file;
    *wire = (vxsi_wire){&ops, tty};
    return VXS_OK;
}
