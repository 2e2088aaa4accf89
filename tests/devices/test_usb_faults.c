/* SPDX-License-Identifier: MIT
 *
 * libusb is played by this program: each of its calls fails in turn, with each of its errors; descriptors of every
 * shape; transfers that end badly, late, or never. After each nothing is held that was not given back.
 */
#include "check.h"
#include "devices/wire.h"
#include "voxshell/hardware.h"

#include <libusb-1.0/libusb.h>

/* --- the library --- */

struct libusb_device {
    uint16_t vendor, product;
    int open_error;
    const struct libusb_config_descriptor *config;
};

enum { MOST_DEVICES = 24, MOST_TRANSFERS = 8 };

static struct {
    long calls, fails; /* call number `fails` of those that may fail gives `error` */
    int error;
    int contexts, lists, handles, configs, claims, transfers; /* that are held */
    struct libusb_device device[MOST_DEVICES], *shown[MOST_DEVICES + 1];
    int count;
    struct libusb_transfer *made[MOST_TRANSFERS], *flying[MOST_TRANSFERS];
    int cancelled[MOST_TRANSFERS];
    int is_stuck, is_gone, turns;
    enum libusb_transfer_status status;                   /* that the next one ends with */
    int lengths[MOST_TRANSFERS], length_count, length_at; /* of what reads bring */
    int submits_left;
    int line_requests;
} usb;

static int failing(void)
{
    return ++usb.calls == usb.fails ? usb.error : 0;
}

int LIBUSB_CALL libusb_init(libusb_context **context)
{
    int error = failing();
    if (error) return error;
    usb.contexts++;
    *context = (libusb_context *)(void *)&usb;
    return 0;
}

void LIBUSB_CALL libusb_exit(libusb_context *context)
{
    CHECK(context == (libusb_context *)(void *)&usb);
    usb.contexts--;
}

ssize_t LIBUSB_CALL libusb_get_device_list(libusb_context *context, libusb_device ***list)
{
    int error = failing();
    CHECK(context);
    if (error) return error;
    for (int n = 0; n < usb.count; n++) usb.shown[n] = &usb.device[n];
    usb.lists++;
    *list = usb.shown;
    return usb.count;
}

void LIBUSB_CALL libusb_free_device_list(libusb_device **list, int unref)
{
    CHECK(list == usb.shown && unref == 1);
    usb.lists--;
}

int LIBUSB_CALL libusb_get_device_descriptor(libusb_device *device, struct libusb_device_descriptor *about)
{
    int error = failing();
    if (error) return error;
    memset(about, 0, sizeof *about);
    about->idVendor = device->vendor;
    about->idProduct = device->product;
    return 0;
}

uint8_t LIBUSB_CALL libusb_get_bus_number(libusb_device *device)
{
    CHECK(device);
    return 3;
}

uint8_t LIBUSB_CALL libusb_get_device_address(libusb_device *device)
{
    return (uint8_t)(device - usb.device + 1);
}

int LIBUSB_CALL libusb_open(libusb_device *device, libusb_device_handle **handle)
{
    int error = failing();
    if (error || device->open_error) return error ? error : device->open_error;
    usb.handles++;
    *handle = (libusb_device_handle *)(void *)device;
    return 0;
}

void LIBUSB_CALL libusb_close(libusb_device_handle *handle)
{
    CHECK(handle);
    usb.handles--;
}

libusb_device *LIBUSB_CALL libusb_get_device(libusb_device_handle *handle)
{
    return (libusb_device *)(void *)handle;
}

int LIBUSB_CALL libusb_get_active_config_descriptor(libusb_device *device,
                                                    struct libusb_config_descriptor **config)
{
    int error = failing();
    if (error) return error;
    usb.configs++;
    *config = (struct libusb_config_descriptor *)(uintptr_t)device->config;
    return 0;
}

void LIBUSB_CALL libusb_free_config_descriptor(struct libusb_config_descriptor *config)
{
    CHECK(config);
    usb.configs--;
}

int LIBUSB_CALL libusb_set_auto_detach_kernel_driver(libusb_device_handle *handle, int enable)
{
    CHECK(handle && enable);
    return LIBUSB_ERROR_NOT_SUPPORTED; /* where there is no such thing, nothing is lost */
}

int LIBUSB_CALL libusb_claim_interface(libusb_device_handle *handle, int number)
{
    int error = failing();
    CHECK(handle && number >= 0);
    if (!error) usb.claims |= 1 << number;
    return error;
}

int LIBUSB_CALL libusb_release_interface(libusb_device_handle *handle, int number)
{
    CHECK(handle && number >= 0);
    usb.claims &= ~(1 << number);
    return 0;
}

int LIBUSB_CALL libusb_control_transfer(libusb_device_handle *handle, uint8_t type, uint8_t request,
                                        uint16_t value, uint16_t index, unsigned char *data, uint16_t size,
                                        unsigned int timeout)
{
    int error = failing();
    CHECK(handle && timeout > 0 && (data != NULL) == (size > 0));
    if (type == 0x40) CHECK(request == 9 && value == 1 && index == 0);
    if (type == 0x21) usb.line_requests++;
    return error ? error : size;
}

struct libusb_transfer *LIBUSB_CALL libusb_alloc_transfer(int packets)
{
    CHECK_INT(packets, 0);
    if (failing()) return NULL;
    int n = 0;
    while (usb.made[n]) CHECK(++n < MOST_TRANSFERS);
    usb.transfers++;
    usb.made[n] = calloc(1, sizeof(struct libusb_transfer));
    return usb.made[n];
}

void LIBUSB_CALL libusb_free_transfer(struct libusb_transfer *transfer)
{
    if (!transfer) return;
    for (int n = 0; n < MOST_TRANSFERS; n++) {
        CHECK(usb.flying[n] != transfer);
        if (usb.made[n] == transfer) usb.made[n] = NULL;
    }
    usb.transfers--;
    free(transfer);
}

int LIBUSB_CALL libusb_submit_transfer(struct libusb_transfer *transfer)
{
    int error = failing();
    if (error) return error;
    if (usb.submits_left-- == 0) return LIBUSB_ERROR_NO_DEVICE;
    for (int n = 0; n < MOST_TRANSFERS; n++) {
        CHECK(usb.flying[n] != transfer); /* twice */
        if (usb.flying[n]) continue;
        usb.flying[n] = transfer;
        usb.cancelled[n] = 0;
        return 0;
    }
    CHECK_FAIL("too many transfers");
}

int LIBUSB_CALL libusb_cancel_transfer(struct libusb_transfer *transfer)
{
    for (int n = 0; n < MOST_TRANSFERS; n++)
        if (usb.flying[n] == transfer) usb.cancelled[n] = 1;
    return 0;
}

static void end_transfer(int n, enum libusb_transfer_status status, int length)
{
    struct libusb_transfer *transfer = usb.flying[n];
    usb.flying[n] = NULL;
    transfer->status = status;
    transfer->actual_length = length;
    transfer->callback(transfer);
}

/* Cancelled ones end first; then writes; then as many reads as there are lengths. */
int LIBUSB_CALL libusb_handle_events_timeout_completed(libusb_context *context, struct timeval *time,
                                                       int *completed)
{
    CHECK(context && time->tv_usec >= 0 && time->tv_usec < 1000000 && !completed);
    usb.turns++;
    if (usb.is_stuck == 1) return 0;
    if (usb.is_gone) return LIBUSB_ERROR_NO_DEVICE;
    for (int n = 0; n < MOST_TRANSFERS; n++)
        if (usb.flying[n] && usb.cancelled[n] && (usb.is_stuck != 2 || usb.flying[n]->endpoint & 0x80))
            end_transfer(n, LIBUSB_TRANSFER_CANCELLED, 0);
    for (int n = 0; n < MOST_TRANSFERS; n++)
        if (usb.flying[n] && usb.is_stuck != 2 && !(usb.flying[n]->endpoint & 0x80))
            end_transfer(n, usb.status, usb.flying[n]->length);
    for (int n = 0; n < MOST_TRANSFERS && usb.length_at < usb.length_count; n++) {
        if (!usb.flying[n] || !(usb.flying[n]->endpoint & 0x80)) continue;
        int length = usb.lengths[usb.length_at++];
        CHECK(length <= usb.flying[n]->length);
        memset(usb.flying[n]->buffer, usb.length_at, (size_t)length);
        end_transfer(n, usb.status, length);
    }
    return 0;
}

/* --- devices --- */

static const struct libusb_endpoint_descriptor ends[] = {
    {.bEndpointAddress = 0x83, .bmAttributes = LIBUSB_TRANSFER_TYPE_INTERRUPT, .wMaxPacketSize = 8},
    {.bEndpointAddress = 0x81, .bmAttributes = LIBUSB_TRANSFER_TYPE_BULK, .wMaxPacketSize = 64},
    {.bEndpointAddress = 0x02, .bmAttributes = LIBUSB_TRANSFER_TYPE_BULK, .wMaxPacketSize = 64}};
static const struct libusb_endpoint_descriptor large[] = {
    {.bEndpointAddress = 0x83, .bmAttributes = LIBUSB_TRANSFER_TYPE_INTERRUPT, .wMaxPacketSize = 8},
    {.bEndpointAddress = 0x02, .bmAttributes = LIBUSB_TRANSFER_TYPE_BULK, .wMaxPacketSize = 1024},
    {.bEndpointAddress = 0x81, .bmAttributes = LIBUSB_TRANSFER_TYPE_BULK, .wMaxPacketSize = 1024}};
static const struct libusb_endpoint_descriptor empty[] = {
    {.bEndpointAddress = 0x81, .bmAttributes = LIBUSB_TRANSFER_TYPE_BULK, .wMaxPacketSize = 0},
    {.bEndpointAddress = 0x02, .bmAttributes = LIBUSB_TRANSFER_TYPE_BULK, .wMaxPacketSize = 64}};

#define SETTING(number, kind, first, count)                                                                  \
    &(const struct libusb_interface_descriptor)                                                              \
    {                                                                                                        \
        .bInterfaceNumber = number, .bInterfaceClass = kind, .bNumEndpoints = count, .endpoint = first       \
    }
#define CONFIG(...)                                                                                          \
    {                                                                                                        \
        .bNumInterfaces =                                                                                    \
            sizeof((const struct libusb_interface[]){__VA_ARGS__}) / sizeof(struct libusb_interface),        \
        .interface = (const struct libusb_interface[])                                                       \
        {                                                                                                    \
            __VA_ARGS__                                                                                      \
        }                                                                                                    \
    }
enum { COMM = LIBUSB_CLASS_COMM, DATA = LIBUSB_CLASS_DATA };

static const struct {
    const char *what;
    int packet; /* 0: no serial device is there */
    struct libusb_config_descriptor config;
} shapes[] = {
    {"CDC-ACM", 64, CONFIG({SETTING(0, COMM, ends, 1), 1}, {SETTING(1, DATA, ends, 3), 1})},
    {"packets of high speed", 512, CONFIG({SETTING(0, COMM, ends, 1), 1}, {SETTING(1, DATA, large, 3), 1})},
    {"no line", 64, CONFIG({SETTING(2, DATA, ends, 3), 1})},
    {"a keyboard before it", 64, CONFIG({SETTING(0, 3, ends, 1), 1}, {SETTING(1, DATA, ends, 3), 1})},
    {"an interface without settings", 64, CONFIG({NULL, 0}, {SETTING(1, DATA, ends, 3), 1})},
    {"half a data interface before a whole one", 64,
     CONFIG({SETTING(1, DATA, ends, 2), 1}, {SETTING(2, DATA, ends, 3), 1}, {SETTING(3, DATA, ends, 3), 1})},
    {"nothing to write to", 0, CONFIG({SETTING(0, COMM, ends, 1), 1}, {SETTING(1, DATA, ends, 2), 1})},
    {"nothing to read", 0, CONFIG({SETTING(1, DATA, ends + 2, 1), 1})},
    {"packets of nothing", 0, CONFIG({SETTING(1, DATA, empty, 2), 1})},
    {"no data", 0, CONFIG({SETTING(0, COMM, ends, 3), 1})},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static const vxsi_usb_match serial = {.vendor = 0x2341, .product = 0x003E, .is_serial = 1};
static const vxsi_usb_match both = {.vendor = 0x0403, .product = 0xCB48, .in = 0x81, .out = 0x02};
static const vxsi_usb_match mouse = {.vendor = 0x256F, .product = 0xC635, .in = 0x81, .is_interrupt = 1};

static void begin(void)
{
    memset(&usb, 0, sizeof usb);
    usb.submits_left = -1;
    usb.device[0] = (struct libusb_device){0x2341, 0x1111, 0, NULL}; /* another of that maker's */
    usb.device[1] = (struct libusb_device){0x2341, 0x003E, 0, &shapes[0].config};
    usb.device[2] = (struct libusb_device){0x0403, 0xCB48, 0, NULL};
    usb.device[3] = (struct libusb_device){0x256F, 0xC635, 0, NULL};
    usb.count = 4;
}

static void check_nothing_held(void)
{
    CHECK_INT(usb.contexts, 0);
    CHECK_INT(usb.lists, 0);
    CHECK_INT(usb.handles, 0);
    CHECK_INT(usb.configs, 0);
    CHECK_INT(usb.claims, 0);
    CHECK_INT(usb.transfers, 0);
}

static vxsi_usb *memory;

/* --- opening --- */

static const struct {
    int error;
    vxs_result result;
} errors[] = {{LIBUSB_ERROR_ACCESS, VXS_ACCESS},    {LIBUSB_ERROR_BUSY, VXS_BUSY},
              {LIBUSB_ERROR_NO_DEVICE, VXS_LOST},   {LIBUSB_ERROR_NOT_FOUND, VXS_NO_DEVICE},
              {LIBUSB_ERROR_TIMEOUT, VXS_TIMEOUT},  {LIBUSB_ERROR_IO, VXS_IO},
              {LIBUSB_ERROR_NO_MEM, VXS_IO},        {LIBUSB_ERROR_OVERFLOW, VXS_IO},
              {LIBUSB_ERROR_NOT_SUPPORTED, VXS_IO}, {LIBUSB_ERROR_PIPE, VXS_IO},
              {LIBUSB_ERROR_INVALID_PARAM, VXS_IO}};

/* Call number k fails, for every k that there is. */
static void check_each_call(const vxsi_usb_match *match, int error, vxs_result expected)
{
    vxsi_wire wire;
    long k = 1;
    int said = 0;
    for (;; k++) {
        begin();
        usb.fails = k;
        usb.error = error;
        vxs_result result = vxsi_usb_open(memory, match, &wire);
        if (result == VXS_OK) {
            CHECK(usb.handles == 1 && usb.transfers == (match->out || match->is_serial ? 5 : 4));
            CHECK_INT(usb.lists + usb.configs, 0);
            wire.ops->close(wire.self);
        }
        check_nothing_held();
        if (usb.calls < k) break;
        /* Nobody's descriptor is there to be read; a transfer that is not had, or not taken, has its own cause; a
         * request about the line that the device does not know is as good. */
        CHECK(result == expected || result == VXS_NO_DEVICE || result == VXS_IO || result == VXS_LOST ||
              (result == VXS_OK && (usb.calls > k)));
        said += result == expected;
    }
    CHECK(k > 8 && said > 0);
}

static void check_opening(void)
{
    vxsi_wire wire;
    for (size_t n = 0; n < sizeof errors / sizeof *errors; n++) {
        check_each_call(&serial, errors[n].error, errors[n].result);
        check_each_call(&both, errors[n].error, errors[n].result);
        check_each_call(&mouse, errors[n].error, errors[n].result);
        /* What the kernel says of the device is passed on by its own name. */
        begin();
        usb.device[3].open_error = errors[n].error;
        CHECK_INT(vxsi_usb_open(memory, &mouse, &wire), errors[n].result);
        check_nothing_held();
    }
    for (int n = 0; n < SHAPES; n++) {
        begin();
        usb.device[1].config = &shapes[n].config;
        vxs_result result = vxsi_usb_open(memory, &serial, &wire);
        if (result != (shapes[n].packet ? VXS_OK : VXS_NO_DEVICE))
            CHECK_FAIL("%s: %d", shapes[n].what, result);
        if (result == VXS_OK) {
            int is_comm = shapes[n].config.interface->num_altsetting &&
                          shapes[n].config.interface->altsetting->bInterfaceClass == COMM;
            CHECK_INT(usb.line_requests, is_comm ? 2 : 0);
            CHECK_INT(usb.flying[0]->length, shapes[n].packet);
            CHECK(usb.flying[0]->endpoint == 0x81 && usb.flying[0]->type == LIBUSB_TRANSFER_TYPE_BULK);
            wire.ops->close(wire.self);
        }
        check_nothing_held();
    }
    begin();
    usb.count = 0;
    CHECK_INT(vxsi_usb_open(memory, &mouse, &wire), VXS_NO_DEVICE);
    check_nothing_held();
}

/* --- use --- */

static vxsi_wire open_it(const vxsi_usb_match *match)
{
    vxsi_wire wire;
    begin();
    CHECK_INT(vxsi_usb_open(memory, match, &wire), VXS_OK);
    return wire;
}

static void check_sending(void)
{
    uint8_t bytes[VXSI_WIRE_MOST + 1] = {0};
    vxsi_wire wire = open_it(&both);
    CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_OK);
    CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_BUSY);
    CHECK_INT(wire.ops->receive(wire.self, bytes, 64, 0), 0);
    CHECK_INT(wire.ops->send(wire.self, bytes, VXSI_WIRE_MOST), VXS_OK);
    wire.ops->receive(wire.self, bytes, 64, 0);
    CHECK_INT(wire.ops->send(wire.self, bytes, VXSI_WIRE_MOST + 1), VXS_LOST);
    usb.submits_left = 0;
    CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_LOST);
    usb.submits_left = -1;
    CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_LOST); /* for ever */
    CHECK_INT(wire.ops->receive(wire.self, bytes, 64, 1000), VXS_LOST);
    wire.ops->close(wire.self);
    check_nothing_held();

    /* A packet that did not get there is a wire that is lost. */
    wire = open_it(&both);
    CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_OK);
    usb.status = LIBUSB_TRANSFER_STALL;
    CHECK_INT(wire.ops->receive(wire.self, bytes, 64, 0), VXS_LOST);
    CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_LOST);
    wire.ops->close(wire.self);
    check_nothing_held();

    wire = open_it(&mouse); /* has no way in */
    CHECK_INT(wire.ops->send(wire.self, bytes, 1), VXS_LOST);
    wire.ops->close(wire.self);
    check_nothing_held();

    wire = open_it(&both);
    CHECK_INT(wire.ops->control(wire.self, 9, 1), VXS_OK);
    for (size_t n = 0; n < sizeof errors / sizeof *errors; n++) {
        usb.fails = usb.calls + 1;
        usb.error = errors[n].error;
        CHECK_INT(wire.ops->control(wire.self, 9, 1), errors[n].result);
    }
    wire.ops->close(wire.self);
    check_nothing_held();
}

static void check_receiving(void)
{
    uint8_t bytes[VXSI_WIRE_MOST];
    vxsi_wire wire = open_it(&mouse);
    CHECK_INT(usb.flying[0]->type, LIBUSB_TRANSFER_TYPE_INTERRUPT);
    CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, 5000), 0);
    const int lengths[] = {7, 0, 13, 64};
    memcpy(usb.lengths, lengths, sizeof lengths);
    usb.length_count = 4;
    /* In the order that they came in, the empty one passed over, the long one cut. */
    CHECK(wire.ops->receive(wire.self, bytes, sizeof bytes, 2000000000) == 7 && bytes[0] == 1);
    CHECK(wire.ops->receive(wire.self, bytes, sizeof bytes, -1) == 13 && bytes[0] == 3);
    CHECK(wire.ops->receive(wire.self, bytes, 10, 0) == 10 && bytes[9] == 4);
    CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, 0), 0);

    /* What came before the plug was pulled is had, then nothing ever. */
    usb.length_count = 4;
    usb.length_at = 2;
    usb.submits_left = 0;
    CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, 0), 13);
    CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, 0), 64);
    CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, 0), VXS_LOST);
    wire.ops->close(wire.self);
    check_nothing_held();

    wire = open_it(&mouse);
    usb.is_gone = 1;
    CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, 0), VXS_LOST);
    usb.is_gone = 0;
    wire.ops->close(wire.self);
    check_nothing_held();

    wire = open_it(&mouse);
    usb.status = LIBUSB_TRANSFER_NO_DEVICE;
    usb.length_count = usb.lengths[0] = 1;
    CHECK_INT(wire.ops->receive(wire.self, bytes, sizeof bytes, 0), VXS_LOST);
    wire.ops->close(wire.self);
    check_nothing_held();
}

/* With a packet on its way; and by a kernel that gives nothing back: what it may write to is not freed. */
static void check_closing(void)
{
    const uint8_t bytes[16] = {0};
    vxsi_wire wire = open_it(&both);
    CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_OK);
    wire.ops->close(wire.self);
    CHECK(usb.turns <= 2);
    check_nothing_held();

    for (int does_write = 0; does_write < 2; does_write++) {
        wire = open_it(&both);
        if (does_write) CHECK_INT(wire.ops->send(wire.self, bytes, 16), VXS_OK);
        usb.is_stuck = 1 + does_write; /* all, or what is written alone */
        wire.ops->close(wire.self);
        CHECK_INT(usb.turns, 40);
        CHECK(usb.handles == 1 && usb.transfers == 5 && usb.contexts == 1 && usb.claims == 0);
        for (int n = 0; n < MOST_TRANSFERS; n++) {
            CHECK(!usb.flying[n] || usb.cancelled[n]);
            free(usb.made[n]);
        }
    }
}

/* --- which there are --- */

static int is_ours(uint16_t vendor, uint16_t product)
{
    return (vendor == 0x256F && product == 0xC635) || (vendor == 0x0403 && product == 0xCB48);
}

static void check_listing(void)
{
    vxsi_usb_seen seen[2];
    for (size_t n = 0; n < sizeof errors / sizeof *errors; n++) {
        begin();
        usb.device[3].open_error = errors[n].error;
        CHECK_INT(vxsi_usb_list(is_ours, seen, 2), 2);
        CHECK(seen[0].usable == VXS_OK && seen[1].usable == errors[n].result);
        CHECK(seen[1].vendor == 0x256F && seen[1].bus == 3 && seen[1].number == 4);
        CHECK_INT(vxsi_usb_list(is_ours, seen, 1), 2);
        CHECK_INT(seen[0].vendor, 0x0403);
        check_nothing_held();
    }
    /* The library, its list; the ids of two that are not ours, of the Falcon, opening it, the mouse's the same. */
    static const uint32_t left[] = {0, 0, 2, 2, 1, 2, 1, 2};
    for (long k = 1; k <= 8; k++) {
        begin();
        usb.fails = k;
        usb.error = LIBUSB_ERROR_IO;
        CHECK_INT(vxsi_usb_list(is_ours, seen, 2), left[k - 1]);
        check_nothing_held();
    }
}

/* As the user's programs meet it: through the kinds' table. Whether this machine has a mouse on hidraw is its own affair. */
static void check_kinds(void)
{
    static vxs_hardware_found found[64];
    static _Alignas(64) uint8_t room[1 << 17];
    const vxs_hardware_kind *kind = vxs_hardware_kind_named("spacemouse");
    vxs_hardware_config config;
    vxs_device *device = NULL;
    vxs_hardware_config_default(&config);
    begin();
    usb.count = 0;
    const uint32_t here = vxs_hardware_probe(found, 64);
    if (here > 0) SKIP("a device of ours is plugged in");
    begin();
    uint32_t count = vxs_hardware_probe(found, 64);
    CHECK_INT(count, 2); /* the mouse and the Falcon, which is seen also where it is not offered */
    for (uint32_t n = 0; n < count; n++)
        CHECK(found[n].wire == VXS_HARDWARE_USB && found[n].usable == VXS_OK);
    CHECK_TEXT(found[0].node, "/dev/bus/usb/003/004");
    CHECK_INT(vxs_hardware_probe(found, 0), 2);

    usb.count = MOST_DEVICES;
    for (int n = 4; n < MOST_DEVICES; n++) usb.device[n] = usb.device[3];
    CHECK_INT(vxs_hardware_probe(found, 64), 17); /* 16 of a kind are enough for anybody */

    begin();
    CHECK_INT(vxs_hardware_open(room, sizeof room, kind, &config, &device), VXS_OK);
    vxs_device_close(device);
    check_nothing_held();
    config.address = "256f:c635";
    CHECK_INT(vxs_hardware_open(room, sizeof room, kind, &config, &device), VXS_OK);
    vxs_device_close(device);
    check_nothing_held();
    usb.device[3].open_error = LIBUSB_ERROR_ACCESS;
    config.address = NULL;
    CHECK_INT(vxs_hardware_open(room, sizeof room, kind, &config, &device), VXS_ACCESS);
    usb.count = 3;
    CHECK_INT(vxs_hardware_open(room, sizeof room, kind, &config, &device), VXS_NO_DEVICE);
    check_nothing_held();
}

int main(void)
{
    memory = aligned_alloc(64, (vxsi_usb_memory() + 63) / 64 * 64);
    CHECK(memory);
    check_opening();
    check_sending();
    check_receiving();
    check_closing();
    check_listing();
    check_kinds();
    free(memory);
    return 0;
}
