/* SPDX-License-Identifier: MIT
 *
 * The kernel's side of USB, emulated for an unmodified libusb: umockdev's preload sends each ioctl on a
 * device's node here, by its socket protocol (the package umockdev alone; neither its library nor GLib). What
 * cannot be had so: a kernel's own refusal of permission, hot-plug events, and its timing, so there is no
 * assertion on time. test_usb                 makes the device, runs itself as the client, unplugs it while
 * it pushes test_usb falcon|mouse    the client
 */
#define _GNU_SOURCE 1

#include "check.h"
#include "emulated.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static int64_t now_ns(void *user)
{
    struct timespec time;
    (void)user;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

static void pause_ms(long ms)
{
    struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    nanosleep(&time, NULL);
}

/* --- the client: unmodified libusb below our wire --- */

static int is_ours(uint16_t vendor, uint16_t product)
{
    return (vendor == 0x0403 && product == 0xCB48) || (vendor == 0x256F && product == 0xC635);
}

static int run_client(const char *name)
{
    static vxsi_link link;
    int is_falcon = strcmp(name, "falcon") == 0;
    vxsi_usb_seen seen;
    vxs_device_state state;
    vxs_device_report report;
    vxs_hardware_config config;
    vxsi_wire wire;
    vxsi_usb *usb = aligned_alloc(64, (vxsi_usb_memory() + 63) / 64 * 64);
    vxs_hardware_config_default(&config);
    CHECK_INT(vxsi_usb_list(is_ours, &seen, 1), 1);
    CHECK(seen.usable == VXS_OK && seen.bus == 1 && seen.number == 2);
    vxsi_usb_match match = {seen.vendor, seen.product, 0, 0x81, is_falcon ? 0x02 : 0, !is_falcon};
    vxsi_usb_match none = {0x1234, 0x5678, 0, 0x81, 0, 1};
    CHECK_INT(vxsi_usb_open(usb, &none, &wire), VXS_NO_DEVICE);
    CHECK_INT(vxsi_usb_open(usb, &match, &wire), VXS_BUSY); /* the first time somebody else has it */
    CHECK_INT(vxsi_usb_open(usb, &match, &wire), VXS_OK);
    memset(&link, 0, sizeof link);
    CHECK_INT(
        vxsi_link_open(&link, is_falcon ? &vxsi_falcon_driver : &vxsi_spacemouse_driver, &config, &wire),
        VXS_OK);
    CHECK_INT(vxsi_link_run(&link), VXS_OK);
    do {
        pause_ms(1);
        vxs_device_exchange(&link.device, NULL, &state, &report);
    } while (state.state == VXS_DEVICE_UNCALIBRATED);
    CHECK_INT(state.state, VXS_DEVICE_READY);
    if (is_falcon) CHECK_INT(vxs_device_arm(&link.device), VXS_OK);
    int64_t end = now_ns(NULL) + 20000000000;
    while (state.state != VXS_DEVICE_GONE && now_ns(NULL) < end) {
        vxs_device_command command = {.wrench = {{1, 0, 0}, {0, 0, 0}},
                                      .hold_ns = state.time_ns + 20000000,
                                      .expires_ns = state.time_ns + 30000000};
        vxs_device_exchange(&link.device, &command, &state, &report);
        pause_ms(1);
    }
    vxs_hardware_counts counts;
    vxs_hardware_get(&link.device, &counts);
    printf("%s on libusb: %llu sent, %llu measured, %llu malformed, %llu late, x = %.4f m\n", name,
           (unsigned long long)counts.sent, (unsigned long long)counts.measured,
           (unsigned long long)counts.malformed, (unsigned long long)counts.late, state.pose.position[0]);
    CHECK_INT(state.state, VXS_DEVICE_GONE);
    CHECK_INT(state.fault, VXS_DEVICE_FAULT_USB);
    CHECK(counts.measured > 20);
    CHECK(isfinite(state.pose.position[0]));
    if (!is_falcon) CHECK(state.pose.position[0] > 0);
    int64_t began = now_ns(NULL);
    vxs_device_close(&link.device);
    CHECK(now_ns(NULL) - began < 5000000000);
    free(usb);
    return 0;
}

/* --- the device's side --- */

enum { CALL_IOCTL = 1, CALL_READ = 7, DONE = 3, READ_MEMORY = 5, WRITE_MEMORY = 6, URBS = 16 };

/* The kernel's struct without its array at the end. */
typedef struct kernel_urb {
    unsigned char type, endpoint;
    int status;
    unsigned int flags;
    void *buffer;
    int buffer_length, actual_length, start_frame, packets, errors;
    unsigned int signal;
    void *context;
} kernel_urb;
_Static_assert(sizeof(kernel_urb) == sizeof(struct usbdevfs_urb), "the kernel's layout");

typedef struct port {
    emulated e;
    char folder[128];
    int file; /* the client's connection */
    struct {
        unsigned long address;
        kernel_urb urb;
        int is_done;
    } urbs[URBS];
    uint32_t urb_count, claims, is_unplugged;
    int64_t first_force_ns, began_ns;
} port;

static int read_all(int file, void *bytes, size_t size)
{
    for (size_t done = 0; done < size;) {
        ssize_t count = read(file, (uint8_t *)bytes + done, size - done);
        if (count <= 0) return 0;
        done += (size_t)count;
    }
    return 1;
}

static int tell(int file, unsigned long command, unsigned long a, unsigned long b)
{
    unsigned long message[3] = {command, a, b};
    return write(file, message, sizeof message) == (ssize_t)sizeof message;
}

static int fetch(port *p, unsigned long address, void *bytes, size_t size)
{
    return tell(p->file, READ_MEMORY, address, size) && read_all(p->file, bytes, size);
}

static int store(port *p, unsigned long address, const void *bytes, size_t size)
{
    return tell(p->file, WRITE_MEMORY, address, size) && write(p->file, bytes, size) == (ssize_t)size;
}

static int answer(port *p, long result, int error)
{
    return tell(p->file, DONE, (unsigned long)result, (unsigned long)error);
}

/* Time passes for the device. */
static void live(port *p)
{
    while (p->e.now_ns < now_ns(NULL)) emulated_run(&p->e, NULL);
    if (!p->first_force_ns && (emulated_force(&p->e) > 0.3 || p->e.kind == &emulated_spacemouse))
        p->first_force_ns = now_ns(NULL);
    if (p->first_force_ns && now_ns(NULL) - p->first_force_ns > 700000000 && p->urb_count > 0)
        p->is_unplugged = 1;
}

static int submit(port *p, unsigned long address)
{
    uint8_t bytes[512];
    CHECK(p->urb_count < URBS);
    uint32_t n = p->urb_count++;
    kernel_urb *urb = &p->urbs[n].urb;
    p->urbs[n].address = address;
    p->urbs[n].is_done = 0;
    if (!fetch(p, address, urb, sizeof *urb)) return 0;
    if (urb->endpoint & 0x80) return answer(p, 0, 0);
    CHECK(urb->buffer_length <= (int)sizeof bytes);
    if (!fetch(p, (unsigned long)urb->buffer, bytes, (size_t)urb->buffer_length)) return 0;
    vxsi_wire wire = emulated_wire(&p->e);
    if (urb->type == USBDEVFS_URB_TYPE_CONTROL)
        wire.ops->control(wire.self, bytes[1], (uint16_t)(bytes[2] | bytes[3] << 8));
    else
        wire.ops->send(wire.self, bytes, (size_t)urb->buffer_length);
    urb->actual_length = urb->type == USBDEVFS_URB_TYPE_CONTROL ? 0 : urb->buffer_length;
    p->urbs[n].is_done = 1;
    return answer(p, 0, 0);
}

/* An IN transfer is done when the device has said something. */
static void fill(port *p)
{
    for (uint32_t n = 0; n < p->urb_count; n++) {
        kernel_urb *urb = &p->urbs[n].urb;
        uint8_t bytes[VXSI_WIRE_MOST];
        if (p->urbs[n].is_done || !(urb->endpoint & 0x80)) continue;
        vxsi_wire wire = emulated_wire(&p->e);
        int32_t size = wire.ops->receive(wire.self, bytes, sizeof bytes, 0);
        if (size <= 0) return;
        CHECK(size <= urb->buffer_length && store(p, (unsigned long)urb->buffer, bytes, (size_t)size));
        urb->actual_length = size;
        p->urbs[n].is_done = 1;
    }
}

static int reap(port *p, unsigned long where)
{
    fill(p);
    for (uint32_t n = 0; n < p->urb_count; n++) {
        if (!p->urbs[n].is_done) continue;
        unsigned long address = p->urbs[n].address;
        kernel_urb *urb = &p->urbs[n].urb;
        if (!store(p, address, urb, offsetof(kernel_urb, buffer)) ||
            !store(p, address + offsetof(kernel_urb, actual_length), &urb->actual_length, sizeof(int)) ||
            !store(p, where, &address, sizeof address))
            return 0;
        memmove(&p->urbs[n], &p->urbs[n + 1], (--p->urb_count - n) * sizeof p->urbs[0]);
        return answer(p, 0, 0);
    }
    return answer(p, -1, EAGAIN);
}

static int discard(port *p, unsigned long address)
{
    for (uint32_t n = 0; n < p->urb_count; n++) {
        if (p->urbs[n].address != address || p->urbs[n].is_done) continue;
        p->urbs[n].urb.status = -ENOENT;
        p->urbs[n].is_done = 1;
        return answer(p, 0, 0);
    }
    return answer(p, -1, EINVAL);
}

/* A host that is unplugged under a program gives its transfers back with ENODEV, and then has nothing to say.
 */
static int answer_gone(port *p, unsigned long request, unsigned long argument)
{
    for (uint32_t n = 0; n < p->urb_count; n++) {
        if (p->urbs[n].is_done) continue;
        p->urbs[n].urb.status = -ESHUTDOWN;
        p->urbs[n].is_done = 1;
    }
    if ((request == USBDEVFS_REAPURBNDELAY || request == USBDEVFS_REAPURB) && p->urb_count > 0)
        return reap(p, argument);
    return answer(p, -1, ENODEV);
}

static int serve_ioctl(port *p, unsigned long request, unsigned long argument)
{
    uint32_t capabilities =
        USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION | USBDEVFS_CAP_NO_PACKET_SIZE_LIM;
    live(p);
    if (p->is_unplugged) return answer_gone(p, request, argument);
    switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
        return store(p, argument, &capabilities, sizeof capabilities) && answer(p, 0, 0);
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
        return p->claims++ == 0 ? answer(p, -1, EBUSY) : answer(p, 0, 0);
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_RESET:
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_SETCONFIGURATION:
        return answer(p, 0, 0);
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:
        return answer(p, -1, ENODATA);
    case USBDEVFS_SUBMITURB:
        return submit(p, argument);
    case USBDEVFS_REAPURBNDELAY:
    case USBDEVFS_REAPURB:
        return reap(p, argument);
    case USBDEVFS_DISCARDURB:
        return discard(p, argument);
    default:
        return answer(p, -1, ENOTTY);
    }
}

/* --- the tree that libudev looks at --- */

static void put_bytes(const port *p, const char *path, const void *bytes, size_t size)
{
    char whole[256];
    snprintf(whole, sizeof whole, "%s/%s", p->folder, path);
    for (char *slash = whole + strlen(p->folder) + 1; (slash = strchr(slash, '/')); slash++) {
        *slash = 0;
        mkdir(whole, 0755);
        *slash = '/';
    }
    FILE *file = fopen(whole, "wb");
    CHECK(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
}

static void put(const port *p, const char *path, const char *text)
{
    put_bytes(p, path, text, strlen(text));
}

static void put_link(const port *p, const char *path, const char *target)
{
    char whole[256];
    snprintf(whole, sizeof whole, "%s/%s", p->folder, path);
    CHECK(symlink(target, whole) == 0);
}

#define DEVICE "sys/devices/pci0000:00/0000:00:14.0/usb1/1-1/"
static void make_tree(const port *p, uint16_t vendor, uint16_t product, int is_falcon)
{
    char text[8], endpoint = is_falcon ? 2 : 3;
    const uint8_t descriptors[] = {18,
                                   1,
                                   0,
                                   2,
                                   0,
                                   0,
                                   0,
                                   64,
                                   (uint8_t)vendor,
                                   (uint8_t)(vendor >> 8),
                                   (uint8_t)product,
                                   (uint8_t)(product >> 8),
                                   0,
                                   1,
                                   0,
                                   0,
                                   0,
                                   1,
                                   9,
                                   2,
                                   32,
                                   0,
                                   1,
                                   1,
                                   0,
                                   0x80,
                                   50,
                                   9,
                                   4,
                                   0,
                                   0,
                                   2,
                                   0xFF,
                                   0,
                                   0,
                                   0,
                                   7,
                                   5,
                                   0x81,
                                   (uint8_t)endpoint,
                                   64,
                                   0,
                                   1,
                                   7,
                                   5,
                                   0x02,
                                   (uint8_t)endpoint,
                                   64,
                                   0,
                                   1};
    put(p, DEVICE "uevent",
        "DEVNAME=/dev/bus/usb/001/002\nDEVTYPE=usb_device\nBUSNUM=001\nDEVNUM=002\nMAJOR=189\nMINOR=1\n");
    put(p, DEVICE "busnum", "1\n");
    put(p, DEVICE "devnum", "2\n");
    snprintf(text, sizeof text, "%04x\n", vendor);
    put(p, DEVICE "idVendor", text);
    snprintf(text, sizeof text, "%04x\n", product);
    put(p, DEVICE "idProduct", text);
    put(p, DEVICE "bConfigurationValue", "1\n");
    put(p, DEVICE "speed", "12\n");
    put(p, DEVICE "dev", "189:1\n");
    put_bytes(p, DEVICE "descriptors", descriptors, sizeof descriptors);
    put(p, "sys/bus/usb/devices/.keep", "");
    put(p, "dev/bus/usb/001/002", "");
    put(p, "dev/.node/.keep", "");
    put(p, "ioctl/dev/bus/usb/001/.keep", "");
    put_link(p, DEVICE "subsystem", "../../../../../bus/usb");
    put_link(p, "sys/bus/usb/devices/1-1", "../../../devices/pci0000:00/0000:00:14.0/usb1/1-1");
    put_link(p, "dev/.node/bus_usb_001_002", "189:1");
}

static int listen_for(const port *p)
{
    struct sockaddr_un where = {.sun_family = AF_UNIX};
    size_t size =
        (size_t)snprintf(where.sun_path, sizeof where.sun_path, "%s/ioctl/dev/bus/usb/001/002", p->folder);
    CHECK(size < sizeof where.sun_path);
    int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    CHECK(listener >= 0 && bind(listener, (struct sockaddr *)&where, sizeof where) == 0 &&
          listen(listener, 4) == 0);
    fcntl(listener, F_SETFL, O_NONBLOCK);
    return listener;
}

static pid_t spawn(const port *p, const char *name)
{
    pid_t child = fork();
    if (child != 0) return child;
    setenv("UMOCKDEV_DIR", p->folder, 1);
    setenv("LD_PRELOAD", "libumockdev-preload.so.0", 1);
    setenv("SYSTEMD_DEVICE_VERIFY_SYSFS", "0", 1);
    setenv("ASAN_OPTIONS", "verify_asan_link_order=0", 1);
    prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
    execl("/proc/self/exe", "test_usb", name, (char *)NULL);
    _exit(127);
}

static void serve(port *p, int listener, pid_t child)
{
    int status = -1;
    p->file = -1;
    for (;;) {
        unsigned long call[3];
        if (p->file < 0) p->file = accept4(listener, NULL, NULL, SOCK_CLOEXEC);
        if (p->file < 0) {
            if (waitpid(child, &status, WNOHANG) == child) break;
            CHECK(now_ns(NULL) - p->began_ns < 60000000000);
            pause_ms(1);
        } else if (!read_all(p->file, call, sizeof call) || call[0] != CALL_IOCTL ||
                   !serve_ioctl(p, call[1], call[2])) {
            close(p->file);
            p->file = -1;
            p->urb_count = 0;
        }
    }
    CHECK(WIFEXITED(status));
    CHECK_INT(WEXITSTATUS(status), 0);
}

static void plug_and_pull(const char *name)
{
    static port p;
    char command[256];
    int is_falcon = strcmp(name, "falcon") == 0;
    memset(&p, 0, sizeof p);
    emulated_init(&p.e, is_falcon ? &emulated_falcon : &emulated_spacemouse);
    p.e.axes.axis[0] = 350;
    p.e.now_ns = p.began_ns = now_ns(NULL);
    strcpy(p.folder, "/tmp/vxs_usb_XXXXXX");
    CHECK(mkdtemp(p.folder));
    make_tree(&p, is_falcon ? 0x0403 : 0x256F, is_falcon ? 0xCB48 : 0xC635, is_falcon);
    int listener = listen_for(&p);
    serve(&p, listener, spawn(&p, name));
    close(listener);
    snprintf(command, sizeof command, "rm -r '%s'", p.folder);
    CHECK(system(command) == 0);
    if (is_falcon) CHECK(emulated_force(&p.e) > 0.3); /* it was pushing when the plug was pulled */
}

int main(int count, char **arguments)
{
    if (count > 1) return run_client(arguments[1]);
    signal(SIGPIPE, SIG_IGN);
    if (system("LD_PRELOAD=libumockdev-preload.so.0 true 2>&1 | grep -q preload") == 0) SKIP("no umockdev");
    plug_and_pull("falcon");
    plug_and_pull("mouse");
    return 0;
}
