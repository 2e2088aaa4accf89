/* SPDX-License-Identifier: MIT
 *
 * What a kernel may answer to a tty and a hidraw node: each refusal of opening under its own name, halves and
 * interruptions of writing and reading, a tree of nodes with everything in it; then what is refused before a wire is
 * touched. The system's calls are wrapped: no device, no time.
 */
#define _GNU_SOURCE 1 /* ppoll */

#include "check.h"
#include "devices/wire.h"
#include "voxshell/hardware.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <termios.h>
#include <unistd.h>

int __real_open(const char *path, int flags, ...);
FILE *__real_fopen(const char *path, const char *mode);
DIR *__real_opendir(const char *path);
struct dirent *__real_readdir(DIR *folder);
ssize_t __real_write(int file, const void *bytes, size_t size);
ssize_t __real_read(int file, void *bytes, size_t size);
int __wrap_open(const char *path, int flags, ...);
FILE *__wrap_fopen(const char *path, const char *mode);
DIR *__wrap_opendir(const char *path);
struct dirent *__wrap_readdir(DIR *folder);
ssize_t __wrap_write(int file, const void *bytes, size_t size);
ssize_t __wrap_read(int file, void *bytes, size_t size);
int __wrap_flock(int file, int operation);
int __wrap_tcgetattr(int file, struct termios *mode);
int __wrap_tcsetattr(int file, int when, const struct termios *mode);
int __wrap_poll(struct pollfd *files, nfds_t count, int timeout);
int __wrap_ppoll(struct pollfd *files, nfds_t count, const struct timespec *timeout, const sigset_t *mask);

/* A call's answer: a count or a result, or minus an error number. */
enum { STEPS = 8 };
typedef struct script {
    long step[STEPS];
    short seen[STEPS]; /* poll: revents */
    int count, at;
} script;

/* The one file that is ours; everything else goes where it goes. */
static struct {
    int file; /* that it has while it is open, 0 */
    int open_error, lock_error, get_error, set_error;
    script writes, reads, polls;
    uint8_t written[64];
    size_t size;
    const char *const *nodes; /* names of /sys/class/hidraw, NULL: no such folder */
    const char *uevent;       /* of each; NULL: it cannot be read */
    int next;
} kernel;

static long answer(script *s, short *seen)
{
    CHECK(s->at < s->count); /* asked once too often */
    long step = s->step[s->at];
    if (seen) *seen = s->seen[s->at];
    s->at++;
    if (step >= 0) return step;
    errno = (int)-step;
    return -1;
}

static int fails(int error)
{
    errno = error;
    return error ? -1 : 0;
}

int __wrap_open(const char *path, int flags, ...)
{
    va_list list;
    va_start(list, flags);
    int mode = flags & O_CREAT ? va_arg(list, int) : 0;
    va_end(list);
    if (strncmp(path, "/dev/hidraw", 11) != 0 && strcmp(path, "/dev/ttyFAKE") != 0)
        return __real_open(path, flags, mode);
    if (fails(kernel.open_error) != 0) return -1;
    kernel.file = __real_open("/dev/null", O_RDWR | O_CLOEXEC);
    return kernel.file;
}

int __wrap_flock(int file, int operation)
{
    CHECK(file == kernel.file && operation != 0);
    return fails(kernel.lock_error);
}

int __wrap_tcgetattr(int file, struct termios *mode)
{
    CHECK(file == kernel.file);
    memset(mode, 0, sizeof *mode);
    return fails(kernel.get_error);
}

int __wrap_tcsetattr(int file, int when, const struct termios *mode)
{
    CHECK(file == kernel.file && when == TCSANOW && mode->c_cc[VMIN] == 1);
    return fails(kernel.set_error);
}

ssize_t __wrap_write(int file, const void *bytes, size_t size)
{
    if (!kernel.file || file != kernel.file) return __real_write(file, bytes, size);
    long count = answer(&kernel.writes, NULL);
    CHECK(count <= (long)size);
    if (count > 0) {
        memcpy(kernel.written + kernel.size, bytes, (size_t)count);
        kernel.size += (size_t)count;
    }
    return count;
}

ssize_t __wrap_read(int file, void *bytes, size_t size)
{
    if (!kernel.file || file != kernel.file) return __real_read(file, bytes, size);
    long count = answer(&kernel.reads, NULL);
    CHECK(count <= (long)size);
    if (count > 0) memset(bytes, 7, (size_t)count);
    return count;
}

int __wrap_poll(struct pollfd *files, nfds_t count, int timeout)
{
    CHECK(count == 1 && files->fd == kernel.file && timeout <= 5);
    return (int)answer(&kernel.polls, &files->revents);
}

int __wrap_ppoll(struct pollfd *files, nfds_t count, const struct timespec *timeout, const sigset_t *mask)
{
    CHECK(count == 1 && files->fd == kernel.file && timeout->tv_nsec >= 0 && !mask);
    return (int)answer(&kernel.polls, &files->revents);
}

DIR *__wrap_opendir(const char *path)
{
    if (strcmp(path, "/sys/class/hidraw") != 0) return __real_opendir(path);
    kernel.next = 0;
    return kernel.nodes ? __real_opendir("/") : NULL;
}

struct dirent *__wrap_readdir(DIR *folder)
{
    static struct dirent entry;
    if (!kernel.nodes) return __real_readdir(folder);
    const char *name = kernel.nodes[kernel.next];
    if (!name) return NULL;
    kernel.next++;
    snprintf(entry.d_name, sizeof entry.d_name, "%s", name);
    return &entry;
}

FILE *__wrap_fopen(const char *path, const char *mode)
{
    if (strncmp(path, "/sys/class/hidraw/", 18) != 0) return __real_fopen(path, mode);
    if (strstr(path, "unreadable") || !kernel.uevent) return NULL;
    return fmemopen((void *)(uintptr_t)kernel.uevent, strlen(kernel.uevent), "r");
}

/* --- opening --- */

static const struct {
    int error;
    vxs_result tty, hidraw;
} refusals[] = {{ENOENT, VXS_NO_DEVICE, VXS_NO_DEVICE},
                {ENXIO, VXS_NO_DEVICE, VXS_NO_DEVICE},
                {ENODEV, VXS_NO_DEVICE, VXS_NO_DEVICE},
                {EACCES, VXS_ACCESS, VXS_ACCESS},
                {EPERM, VXS_ACCESS, VXS_ACCESS},
                {EBUSY, VXS_BUSY, VXS_IO},
                {EWOULDBLOCK, VXS_BUSY, VXS_IO},
                {EMFILE, VXS_IO, VXS_IO},
                {EIO, VXS_IO, VXS_IO},
                {EISDIR, VXS_IO, VXS_IO}};
enum { REFUSALS = sizeof refusals / sizeof *refusals };

static void check_closed(void)
{
    CHECK(kernel.file == 0 || (fcntl(kernel.file, F_GETFD) == -1 && errno == EBADF));
}

static void check_refused_openings(void)
{
    vxsi_tty tty;
    vxsi_hidraw hidraw;
    vxsi_wire wire = {NULL, NULL};
    for (int n = 0; n < REFUSALS; n++) {
        memset(&kernel, 0, sizeof kernel);
        kernel.open_error = refusals[n].error;
        CHECK_INT(vxsi_tty_open(&tty, "/dev/ttyFAKE", &wire), refusals[n].tty);
        CHECK_INT(vxsi_hidraw_open(&hidraw, "/dev/hidraw0", &wire), refusals[n].hidraw);
        kernel.open_error = 0;
        kernel.lock_error = refusals[n].error;
        CHECK_INT(vxsi_tty_open(&tty, "/dev/ttyFAKE", &wire), refusals[n].tty);
        check_closed();
        CHECK(!wire.ops);
    }
    memset(&kernel, 0, sizeof kernel);
    kernel.get_error = ENOTTY;
    CHECK_INT(vxsi_tty_open(&tty, "/dev/ttyFAKE", &wire), VXS_NO_DEVICE);
    check_closed();
    kernel.get_error = 0;
    kernel.set_error = EIO;
    CHECK_INT(vxsi_tty_open(&tty, "/dev/ttyFAKE", &wire), VXS_IO);
    check_closed();
    CHECK(!wire.ops);
}

/* --- writing --- */

static const struct {
    script writes, polls;
    vxs_result result;
} sendings[] = {
    {{.step = {10}, .count = 1}, {.count = 0}, VXS_OK},
    {{.step = {-EAGAIN}, .count = 1}, {.count = 0}, VXS_BUSY},
    {{.step = {-EINTR}, .count = 1}, {.count = 0}, VXS_BUSY},
    {{.step = {-EIO}, .count = 1}, {.count = 0}, VXS_LOST},
    {{.step = {-ENODEV}, .count = 1}, {.count = 0}, VXS_LOST},
    /* a half is finished, whatever interrupts it */
    {{.step = {4, 6}, .count = 2}, {.step = {1}, .seen = {POLLOUT}, .count = 1}, VXS_OK},
    {{.step = {1, -EAGAIN, 3, -EINTR, 6}, .count = 5},
     {.step = {1, 1, 1, 1}, .seen = {POLLOUT, POLLOUT, POLLOUT, POLLOUT}, .count = 4},
     VXS_OK},
    {{.step = {0, 10}, .count = 2}, {.step = {1}, .seen = {POLLOUT}, .count = 1}, VXS_OK},
    {{.step = {3, 0, 7}, .count = 3}, {.step = {1, 1}, .seen = {POLLOUT, POLLOUT}, .count = 2}, VXS_OK},
    /* or the wire is lost: a frame without its end */
    {{.step = {4}, .count = 1}, {.step = {0}, .count = 1}, VXS_LOST},
    {{.step = {4}, .count = 1}, {.step = {-EINTR}, .count = 1}, VXS_LOST},
    {{.step = {4}, .count = 1}, {.step = {1}, .seen = {POLLERR}, .count = 1}, VXS_LOST},
    {{.step = {4}, .count = 1}, {.step = {1}, .seen = {POLLHUP | POLLOUT}, .count = 1}, VXS_LOST},
    {{.step = {4, -EIO}, .count = 2}, {.step = {1}, .seen = {POLLOUT}, .count = 1}, VXS_LOST},
};

static void check_sending(void)
{
    static const uint8_t packet[10] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    vxsi_tty tty;
    vxsi_wire wire;
    for (size_t n = 0; n < sizeof sendings / sizeof *sendings; n++) {
        memset(&kernel, 0, sizeof kernel);
        CHECK_INT(vxsi_tty_open(&tty, "/dev/ttyFAKE", &wire), VXS_OK);
        kernel.writes = sendings[n].writes;
        kernel.polls = sendings[n].polls;
        CHECK_INT(wire.ops->send(wire.self, packet, sizeof packet), sendings[n].result);
        CHECK_INT(kernel.writes.at, kernel.writes.count);
        CHECK_INT(kernel.polls.at, kernel.polls.count);
        if (sendings[n].result == VXS_OK)
            CHECK(kernel.size == sizeof packet && memcmp(kernel.written, packet, sizeof packet) == 0);
        if (sendings[n].result == VXS_BUSY) CHECK_INT(kernel.size, 0); /* as a whole or not at all */
        wire.ops->close(wire.self);
        check_closed();
    }
}

/* --- reading --- */

static const struct {
    long ready;
    short seen;
    long count;
    int32_t result;
} hearings[] = {{0, 0, 0, 0},
                {-EINTR, 0, 0, 0},
                {-EBADF, 0, 0, VXS_LOST},
                {1, POLLIN, 5, 5},
                {1, POLLIN, -EAGAIN, 0},
                {1, POLLIN, -EINTR, 0},
                {1, POLLIN, -EIO, VXS_LOST},
                {1, POLLIN, 0, VXS_LOST},
                {1, POLLHUP, 0, VXS_LOST},
                {1, POLLIN | POLLHUP, 3, 3}};

static void check_hearing(void)
{
    vxsi_hidraw hidraw;
    vxsi_wire wire;
    for (size_t n = 0; n < sizeof hearings / sizeof *hearings; n++) {
        uint8_t bytes[16] = {0};
        memset(&kernel, 0, sizeof kernel);
        CHECK_INT(vxsi_hidraw_open(&hidraw, "/dev/hidraw0", &wire), VXS_OK);
        kernel.polls = (script){.step = {hearings[n].ready}, .seen = {hearings[n].seen}, .count = 1};
        kernel.reads = (script){.step = {hearings[n].count}, .count = hearings[n].seen & POLLIN ? 1 : 0};
        int64_t wait = n % 2 ? -1 : 2500000000;
        CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, wait), hearings[n].result);
        CHECK_INT(kernel.reads.at, kernel.reads.count);
        CHECK_INT(bytes[0], hearings[n].result > 0 ? 7 : 0);
        CHECK_INT(wire.ops->send(wire.self, bytes, 1), VXS_UNSUPPORTED);
        wire.ops->close(wire.self);
        check_closed();
    }
}

/* --- which nodes there are --- */

static const char spacemouse[] = "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C635\n";

static int is_c635(uint16_t vendor, uint16_t product)
{
    return vendor == 0x256F && product == 0xC635;
}

static void check_listing(void)
{
    static const char *const names[] = {".",          "..",      "hidraw0", "a_name_of_many_letters",
                                        "unreadable", "hidraw1", "hidraw2", NULL};
    static const char *const none[] = {NULL};
    static const struct {
        const char *uevent;
        uint32_t found;
    } ids[] = {{spacemouse, 3},
               {"HID_ID=0003:0000046D:0000C31C\n", 0},                                /* a keyboard */
               {"DRIVER=hid-generic\n", 0},                                           /* says nothing */
               {"HID_ID=0003:0001256F:0000C635\n", 0},                                /* more than 16 bits */
               {"HID_ID=0003:0000256F:0001C635\nHID_ID=0003:0000256F:0000C635\n", 3}, /* then a right one */
               {NULL, 0}};
    vxsi_hidraw_seen seen[2];
    for (size_t n = 0; n < sizeof ids / sizeof *ids; n++) {
        memset(&kernel, 0, sizeof kernel);
        memset(seen, 0, sizeof seen);
        kernel.nodes = names;
        kernel.uevent = ids[n].uevent;
        CHECK_INT(vxsi_hidraw_list(is_c635, seen, 2), ids[n].found);
        if (!ids[n].found) continue;
        CHECK_TEXT(seen[0].path, "/dev/hidraw0");
        CHECK_TEXT(seen[1].path, "/dev/hidraw1");
        CHECK(seen[1].usable == VXS_OK && seen[1].vendor == 0x256F && seen[1].product == 0xC635);
        check_closed();
        kernel.open_error = EACCES;
        CHECK_INT(vxsi_hidraw_list(is_c635, seen, 1), ids[n].found);
        CHECK_INT(seen[0].usable, VXS_ACCESS);
    }
    kernel.nodes = NULL;
    CHECK_INT(vxsi_hidraw_list(is_c635, seen, 2), 0);
    kernel.nodes = none;
    CHECK_INT(vxsi_hidraw_list(is_c635, seen, 2), 0);
}

/* More nodes than anybody has are counted, and as many shown as there is room for. */
static void check_probing(void)
{
    enum { NODES = 20, ROOM = 32 };
    static char name[NODES][12];
    static const char *names[NODES + 1];
    static vxs_hardware_found found[ROOM];
    for (int n = 0; n < NODES; n++) {
        snprintf(name[n], sizeof name[n], "hidraw%d", n);
        names[n] = name[n];
    }
    memset(&kernel, 0, sizeof kernel);
    kernel.nodes = names;
    kernel.uevent = spacemouse;
    uint32_t all = vxs_hardware_probe(found, ROOM);
    CHECK(all >= 16 && found[15].wire == VXS_HARDWARE_HIDRAW);
    CHECK_TEXT(found[15].node, "/dev/hidraw15");
    CHECK_INT(vxs_hardware_probe(found, 1), all);
    CHECK_TEXT(found[0].node, "/dev/hidraw0");

    /* None of them may be opened: that is what is said, not that there is none. */
    static _Alignas(64) uint8_t memory[1 << 17];
    vxs_hardware_config config;
    vxs_device *device = NULL;
    const vxs_hardware_kind *mouse = vxs_hardware_kind_named("spacemouse");
    CHECK(vxs_hardware_memory() <= sizeof memory);
    vxs_hardware_config_default(&config);
    kernel.open_error = EACCES;
    CHECK_INT(vxs_hardware_open(memory, sizeof memory, mouse, &config, &device), VXS_ACCESS);
    config.address = "256f:c635";
    CHECK_INT(vxs_hardware_open(memory, sizeof memory, mouse, &config, &device), VXS_ACCESS);
    config.address = "046d:c635"; /* another vendor's */
    CHECK_INT(vxs_hardware_open(memory, sizeof memory, mouse, &config, &device), VXS_NO_DEVICE);
    CHECK(!device);
}

/* --- what is refused before a wire is touched --- */

static void check_refused_configs(void)
{
    static _Alignas(64) uint8_t memory[1 << 17];
    const vxs_hardware_kind *haply = vxs_hardware_kind_named("haply"),
                            *falcon = vxs_hardware_kind_named("falcon");
    const size_t size = vxs_hardware_memory();
    vxs_hardware_config good, config;
    vxs_device *device = NULL;
    memset(&kernel, 0, sizeof kernel);
    kernel.open_error = ENOENT;
    vxs_hardware_config_default(&good);
    good.address = "/dev/ttyFAKE";
#define REFUSES(expected, change)                                                                            \
    do {                                                                                                     \
        config = good;                                                                                       \
        change;                                                                                              \
        CHECK_INT(vxs_hardware_open(memory, size, haply, &config, &device), expected);                       \
    } while (0)
    REFUSES(VXS_NO_DEVICE, (void)0); /* as far as the wire */
    REFUSES(VXS_CONFIG, config.struct_size++);
    const double bad[] = {0, -1, NAN, 1e9, INFINITY};
    for (int n = 0; n < 5; n++) {
        REFUSES(VXS_PARAM, config.units_per_nm = bad[n]);
        REFUSES(VXS_PARAM, config.torque_gain = bad[n]);
        REFUSES(VXS_PARAM, config.max_speed = bad[n]);
        REFUSES(VXS_PARAM, config.linear_speed = bad[n]);
        REFUSES(VXS_PARAM, config.angular_speed = bad[n]);
        REFUSES(VXS_PARAM, config.rate_hz = bad[n]);
        for (int i = 0; i < 3 && n > 0; i++) REFUSES(VXS_PARAM, config.haply_links[i] = bad[n]);
    }
    REFUSES(VXS_PARAM, config.rate_hz = 10001);
    REFUSES(VXS_PARAM, config.haply_links[2] = 1);
    REFUSES(VXS_PARAM, config.haply_setup = 1);
    REFUSES(VXS_PARAM, config.haply_setup = 4);
    REFUSES(VXS_NO_DEVICE, config.haply_setup = 3);
    REFUSES(VXS_PARAM, config.address = "0000:1234"); /* no vendor has that number */
    REFUSES(VXS_PARAM, config.address = "2341");
    REFUSES(VXS_NO_DEVICE, config.address = NULL); /* a serial device's ids are its builder's affair */
    CHECK_INT(vxs_hardware_open(memory, size, haply, NULL, &device), VXS_PARAM);
    CHECK_INT(vxs_hardware_open(NULL, size, haply, &good, &device), VXS_PARAM);
    CHECK_INT(vxs_hardware_open(memory, size, haply, &good, NULL), VXS_PARAM);
    CHECK_INT(vxs_hardware_open(memory, size, NULL, &good, &device), VXS_PARAM);
    const vxs_hardware_kind *last = vxs_hardware_kind_at(0);
    for (uint32_t n = 0; vxs_hardware_kind_at(n); n++) last = vxs_hardware_kind_at(n);
    const uintptr_t before = (uintptr_t)vxs_hardware_kind_at(0) - sizeof *last;
    CHECK_INT(vxs_hardware_open(memory, size, (const vxs_hardware_kind *)before, &good, &device), VXS_PARAM);
    CHECK_INT(vxs_hardware_open(memory, size, last + 1, &good, &device), VXS_PARAM);
    CHECK_INT(vxs_hardware_open(memory + 8, size, haply, &good, &device), VXS_BUFFER);
    CHECK_INT(vxs_hardware_open(memory, size - 1, haply, &good, &device), VXS_BUFFER);
    if (!falcon->is_built)
        CHECK_INT(vxs_hardware_open(memory, size, falcon, &good, &device), VXS_UNSUPPORTED);
    CHECK(!device && !vxs_hardware_kind_named(NULL) && !vxs_hardware_kind_named("a pen"));
}

int main(void)
{
    check_refused_openings();
    check_sending();
    check_hearing();
    check_listing();
    check_probing();
    check_refused_configs();
    return 0;
}
