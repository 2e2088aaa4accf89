/* SPDX-License-Identifier: MIT
 *
 * The kernel's side of USB, emulated for an unmodified libusb (mocked.h):
 *     test_usb                                makes each device, runs itself as the client, unplugs it while it
 *                                             pushes
 *     test_usb falcon|mouse|haply|hvlink      the client
 */
#define _GNU_SOURCE 1

#include "check.h"
#include "emulated.h"
#include "mocked.h"

#include <errno.h>
#include <linux/usbdevice_fs.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct plug {
    const char *name;
    const emulated_kind *kind;
    uint16_t vendor, product;
    uint8_t is_serial, is_bulk;
} plug;
/* A serial device's VID:PID is its builder's affair: these are two of a maker of boards. */
static const plug plugs[] = {{"falcon", &emulated_falcon, 0x0403, 0xCB48, 0, 1},
                             {"mouse", &emulated_spacemouse, 0x256F, 0xC635, 0, 0},
                             {"haply", &emulated_haply, 0x2341, 0x003E, 1, 1},
                             {"hvlink", &emulated_hvlink, 0x2341, 0x804D, 1, 1}};
enum { PLUGS = sizeof plugs / sizeof *plugs };

/* --- the client: unmodified libusb below our wire --- */

static int is_ours(uint16_t vendor, uint16_t product)
{
    for (int n = 0; n < PLUGS; n++)
        if (plugs[n].vendor == vendor && plugs[n].product == product) return 1;
    return 0;
}

/* As the user opens it, by VID:PID. */
static vxs_device *open_serial(const plug *what, void *memory)
{
    char address[16];
    vxs_device *device = NULL;
    vxs_hardware_config config;
    const vxs_hardware_kind *kind = vxs_hardware_kind_named(what->name);
    CHECK(kind->wires & VXS_HARDWARE_USB);
    vxs_hardware_config_default(&config);
    config.is_in_place = 1;
    config.address = "1234:5678";
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_NO_DEVICE);
    config.address = "1234:56789";
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_PARAM);
    snprintf(address, sizeof address, "%04x:%04x", what->vendor, what->product);
    config.address = address;
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_BUSY);
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_OK);
    return device;
}

/* The Falcon's driver is tested also where it is not offered. */
static vxs_device *open_link(const plug *what, vxsi_usb *usb, vxsi_link *link)
{
    vxsi_usb_seen seen;
    vxs_hardware_config config;
    vxsi_wire wire;
    vxs_hardware_config_default(&config);
    CHECK_INT(vxsi_usb_list(is_ours, &seen, 1), 1);
    CHECK(seen.usable == VXS_OK && seen.bus == 1 && seen.number == 2);
    vxsi_usb_match match = {seen.vendor, seen.product, 0, 0x81, what->is_bulk ? 0x02 : 0, !what->is_bulk, 0};
    vxsi_usb_match none = {0x1234, 0x5678, 0, 0x81, 0, 1, 0};
    CHECK_INT(vxsi_usb_open(usb, &none, &wire), VXS_NO_DEVICE);
    CHECK_INT(vxsi_usb_open(usb, &match, &wire), VXS_BUSY); /* the first time somebody else has it */
    CHECK_INT(vxsi_usb_open(usb, &match, &wire), VXS_OK);
    memset(link, 0, sizeof *link);
    CHECK_INT(vxsi_link_open(link, what->kind->driver, &config, &wire), VXS_OK);
    CHECK_INT(vxsi_link_run(link), VXS_OK);
    return &link->device;
}

/* Pushes until the device is gone. */
static void use_until_gone(const char *name, vxs_device *device, int has_force)
{
    vxs_device_state state;
    vxs_device_report report;
    do {
        mocked_pause(1);
        vxs_device_exchange(device, NULL, &state, &report);
    } while (state.state == VXS_DEVICE_UNCALIBRATED);
    CHECK_INT(state.state, VXS_DEVICE_READY);
    if (has_force) CHECK_INT(vxs_device_arm(device), VXS_OK);
    int64_t end = mocked_now() + 20000000000;
    while (state.state != VXS_DEVICE_GONE && mocked_now() < end) {
        vxs_device_command command = {.wrench = {{1, 0, 0}, {0, 0, 0}},
                                      .hold_ns = state.time_ns + 20000000,
                                      .expires_ns = state.time_ns + 30000000};
        vxs_device_exchange(device, &command, &state, &report);
        mocked_pause(1);
    }
    vxs_hardware_counts counts;
    vxs_hardware_get(device, &counts);
    printf("%s: %llu sent, %llu measured, %llu malformed, %llu late, x = %.4f m\n", name,
           (unsigned long long)counts.sent, (unsigned long long)counts.measured,
           (unsigned long long)counts.malformed, (unsigned long long)counts.late, state.pose.position[0]);
    CHECK_INT(state.state, VXS_DEVICE_GONE);
    CHECK_INT(state.fault, VXS_DEVICE_FAULT_USB);
    CHECK(counts.measured > 20);
    CHECK(isfinite(state.pose.position[0]));
    if (!has_force) CHECK(state.pose.position[0] > 0);
    int64_t began = mocked_now();
    vxs_device_close(device);
    CHECK(mocked_now() - began < 5000000000);
}

static int run_client(const plug *what)
{
    static vxsi_link link;
    size_t size = what->is_serial ? vxs_hardware_memory() : (vxsi_usb_memory() + 63) / 64 * 64;
    void *memory = aligned_alloc(64, size);
    vxs_device *device = what->is_serial ? open_serial(what, memory) : open_link(what, memory, &link);
    use_until_gone(what->name, device, what->kind->has_force);
    free(memory);
    return 0;
}

/* --- the device's side --- */

enum { URBS = 16 };

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
    const plug *what;
    emulated e;
    mocked tree;
    int file; /* the client's connection */
    struct {
        unsigned long address;
        kernel_urb urb;
        int is_done;
    } urbs[URBS];
    uint32_t urb_count, claims, is_unplugged, line_state;
    int64_t first_force_ns, began_ns;
    double force; /* [N] when the plug was pulled */
} port;

static int fetch(port *p, unsigned long address, void *bytes, size_t size)
{
    return mocked_tell(p->file, MOCKED_READ_MEMORY, address, size) && mocked_read(p->file, bytes, size);
}

static int store(port *p, unsigned long address, const void *bytes, size_t size)
{
    return mocked_tell(p->file, MOCKED_WRITE_MEMORY, address, size) &&
           write(p->file, bytes, size) == (ssize_t)size;
}

static int answer(port *p, long result, int error)
{
    return mocked_tell(p->file, MOCKED_DONE, (unsigned long)result, (unsigned long)error);
}

/* Time passes for the device. */
static void live(port *p)
{
    while (p->e.now_ns < mocked_now()) emulated_run(&p->e, NULL);
    if (!p->first_force_ns && (emulated_force(&p->e) > 0.3 || p->e.kind == &emulated_spacemouse))
        p->first_force_ns = mocked_now();
    if (p->is_unplugged || !p->first_force_ns || p->urb_count == 0) return;
    p->force = emulated_force(&p->e);
    p->is_unplugged = mocked_now() - p->first_force_ns > 700000000 &&
                      (p->force > 0.3 || !p->what->kind->has_force); /* not as the machine stalls */
}

/* What a serial device is told as its tty is opened: 115200 8N1, and that somebody listens. */
static void hear_of_line(port *p, const uint8_t *bytes, size_t size)
{
    static const uint8_t coding[] = {0x21, 0x20, 0, 0, 0, 0, 7, 0, 0x00, 0xC2, 0x01, 0x00, 0, 0, 8};
    static const uint8_t listens[] = {0x21, 0x22, 3, 0, 0, 0, 0, 0};
    int is_coding = size == sizeof coding && memcmp(bytes, coding, size) == 0;
    CHECK(is_coding || (size == sizeof listens && memcmp(bytes, listens, size) == 0));
    p->line_state |= is_coding ? 1 : 2;
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
    if (urb->type == USBDEVFS_URB_TYPE_CONTROL && p->what->is_serial)
        hear_of_line(p, bytes, (size_t)urb->buffer_length);
    else if (urb->type == USBDEVFS_URB_TYPE_CONTROL)
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

#define DEVICE "sys/devices/pci0000:00/0000:00:14.0/usb1/1-1/"
enum { BULK = 2, INTERRUPT = 3 };

static uint8_t *put_interface(uint8_t *at, uint8_t number, uint8_t ends, uint8_t kind)
{
    const uint8_t bytes[] = {9, 4, number, 0, ends, kind, 0, 0, 0};
    memcpy(at, bytes, sizeof bytes);
    return at + sizeof bytes;
}

static uint8_t *put_endpoint(uint8_t *at, uint8_t address, uint8_t type)
{
    const uint8_t bytes[] = {7, 5, address, type, 64, 0, 1};
    memcpy(at, bytes, sizeof bytes);
    return at + sizeof bytes;
}

static size_t make_descriptors(const plug *what, uint8_t *bytes)
{
    const uint8_t device[] = {18,
                              1,
                              0,
                              2,
                              0,
                              0,
                              0,
                              64,
                              (uint8_t)what->vendor,
                              (uint8_t)(what->vendor >> 8),
                              (uint8_t)what->product,
                              (uint8_t)(what->product >> 8),
                              0,
                              1,
                              0,
                              0,
                              0,
                              1};
    uint8_t *config = bytes + sizeof device, *at = config + 9, type = what->is_bulk ? BULK : INTERRUPT;
    memcpy(bytes, device, sizeof device);
    if (what->is_serial) at = put_endpoint(put_interface(at, 0, 1, 2), 0x83, INTERRUPT);
    at = put_interface(at, what->is_serial, 2, what->is_serial ? 0x0A : 0xFF);
    at = put_endpoint(put_endpoint(at, 0x81, type), 0x02, type);
    const uint8_t head[] = {9, 2, (uint8_t)(at - config), 0, (uint8_t)(1 + what->is_serial), 1, 0, 0x80, 50};
    memcpy(config, head, sizeof head);
    return (size_t)(at - bytes);
}

static void make_tree(const port *p)
{
    char text[8];
    uint8_t descriptors[96];
    size_t size = make_descriptors(p->what, descriptors);
    mocked_put(
        &p->tree, DEVICE "uevent",
        "DEVNAME=/dev/bus/usb/001/002\nDEVTYPE=usb_device\nBUSNUM=001\nDEVNUM=002\nMAJOR=189\nMINOR=1\n");
    mocked_put(&p->tree, DEVICE "busnum", "1\n");
    mocked_put(&p->tree, DEVICE "devnum", "2\n");
    snprintf(text, sizeof text, "%04x\n", p->what->vendor);
    mocked_put(&p->tree, DEVICE "idVendor", text);
    snprintf(text, sizeof text, "%04x\n", p->what->product);
    mocked_put(&p->tree, DEVICE "idProduct", text);
    mocked_put(&p->tree, DEVICE "bConfigurationValue", "1\n");
    mocked_put(&p->tree, DEVICE "speed", "12\n");
    mocked_put(&p->tree, DEVICE "dev", "189:1\n");
    mocked_put_bytes(&p->tree, DEVICE "descriptors", descriptors, size);
    mocked_put(&p->tree, "sys/bus/usb/devices/.keep", "");
    mocked_put(&p->tree, "dev/bus/usb/001/002", "");
    mocked_put(&p->tree, "dev/.node/.keep", "");
    mocked_put(&p->tree, "ioctl/dev/bus/usb/001/.keep", "");
    mocked_put_link(&p->tree, DEVICE "subsystem", "../../../../../bus/usb");
    mocked_put_link(&p->tree, "sys/bus/usb/devices/1-1", "../../../devices/pci0000:00/0000:00:14.0/usb1/1-1");
    mocked_put_link(&p->tree, "dev/.node/bus_usb_001_002", "189:1");
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
            CHECK(mocked_now() - p->began_ns < 60000000000);
            mocked_pause(1);
        } else if (!mocked_read(p->file, call, sizeof call) || call[0] != MOCKED_IOCTL ||
                   !serve_ioctl(p, call[1], call[2])) {
            close(p->file);
            p->file = -1;
            p->urb_count = 0;
        }
    }
    CHECK(WIFEXITED(status));
    CHECK_INT(WEXITSTATUS(status), 0);
}

static void plug_and_pull(const plug *what)
{
    static port p;
    memset(&p, 0, sizeof p);
    p.what = what;
    emulated_init(&p.e, what->kind);
    p.e.axes.axis[0] = 350;
    p.e.now_ns = p.began_ns = mocked_now();
    mocked_begin(&p.tree);
    make_tree(&p);
    int listener = mocked_listen(&p.tree, "/dev/bus/usb/001/002");
    serve(&p, listener, mocked_run(&p.tree, what->name, getuid()));
    close(listener);
    mocked_end(&p.tree);
    if (what->kind->has_force) CHECK(p.force > 0.3); /* it pushed when the plug was pulled */
    if (what->is_serial) CHECK_INT(p.line_state, 3);
}

int main(int count, char **arguments)
{
    for (int n = 0; n < PLUGS && count > 1; n++)
        if (strcmp(arguments[1], plugs[n].name) == 0) return run_client(&plugs[n]);
    signal(SIGPIPE, SIG_IGN);
    if (!mocked_is_here()) SKIP("no umockdev");
    for (int n = 0; n < PLUGS; n++) plug_and_pull(&plugs[n]);
    return 0;
}
