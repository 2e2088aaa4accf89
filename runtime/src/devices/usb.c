/* SPDX-License-Identifier: MIT
 *
 * A wire that is two endpoints of a USB device, by libusb; of a serial one (CDC-ACM) those that its descriptors
 * name, in place of the kernel's tty. All transfers are made at opening; one thread, the
 * one that calls send and receive, handles events, and the callbacks only note what is done.
 */
#include "wire.h"

#include <libusb-1.0/libusb.h>
#include <string.h>
#include <time.h>

enum { READS = 4, PACKET = 512, FULL_SPEED = 64, CONTROL_MS = 1000, CLOSE_TURNS = 40, CLOSE_TURN_MS = 5 };
enum { VENDOR_OUT = 0x40, CLASS_OUT = 0x21, SET_LINE_CODING = 0x20, SET_LINE_STATE = 0x22, DTR_AND_RTS = 3 };
enum { NO_INTERFACE = -1 };

struct vxsi_usb {
    libusb_context *context;
    libusb_device_handle *handle;
    int interface, line; /* line: a serial device's other interface, that it is told of the line by */
    struct libusb_transfer *write, *reads[READS];
    uint8_t written[VXSI_WIRE_MOST], read[READS][PACKET];
    uint8_t done[READS]; /* numbers of reads that have ended, oldest first */
    uint32_t done_count;
    uint32_t is_writing, reading; /* transfers that libusb holds */
    uint32_t is_gone, is_closing;
};

size_t vxsi_usb_memory(void)
{
    return sizeof(vxsi_usb);
}

static vxs_result result_of(int error)
{
    switch (error) {
    case LIBUSB_SUCCESS:
        return VXS_OK;
    case LIBUSB_ERROR_ACCESS:
        return VXS_ACCESS;
    case LIBUSB_ERROR_BUSY:
        return VXS_BUSY;
    case LIBUSB_ERROR_NO_DEVICE:
        return VXS_LOST;
    case LIBUSB_ERROR_NOT_FOUND:
        return VXS_NO_DEVICE;
    case LIBUSB_ERROR_TIMEOUT:
        return VXS_TIMEOUT;
    default:
        return VXS_IO;
    }
}

static void LIBUSB_CALL on_write(struct libusb_transfer *transfer)
{
    vxsi_usb *usb = transfer->user_data;
    usb->is_writing = 0;
    if (transfer->status != LIBUSB_TRANSFER_COMPLETED && !usb->is_closing) usb->is_gone = 1;
}

static void LIBUSB_CALL on_read(struct libusb_transfer *transfer)
{
    vxsi_usb *usb = transfer->user_data;
    usb->reading--;
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED) {
        for (uint8_t n = 0; n < READS; n++)
            if (usb->reads[n] == transfer) usb->done[usb->done_count++] = n;
    } else if (!usb->is_closing) {
        usb->is_gone = 1;
    }
}

static void submit_read(vxsi_usb *usb, uint32_t n)
{
    if (libusb_submit_transfer(usb->reads[n]) == LIBUSB_SUCCESS)
        usb->reading++;
    else
        usb->is_gone = 1;
}

static vxs_result control(void *self, uint8_t request, uint16_t value)
{
    vxsi_usb *usb = self;
    int result = libusb_control_transfer(usb->handle, VENDOR_OUT, request, value, 0, NULL, 0, CONTROL_MS);
    return result >= 0 ? VXS_OK : result_of(result);
}

static vxs_result send_bytes(void *self, const uint8_t *bytes, size_t size)
{
    vxsi_usb *usb = self;
    if (usb->is_gone || !usb->write || size > sizeof usb->written) return VXS_LOST;
    if (usb->is_writing) return VXS_BUSY;
    memcpy(usb->written, bytes, size);
    usb->write->length = (int)size;
    if (libusb_submit_transfer(usb->write) != LIBUSB_SUCCESS) {
        usb->is_gone = 1;
        return VXS_LOST;
    }
    usb->is_writing = 1;
    return VXS_OK;
}

static int32_t receive_bytes(void *self, uint8_t *bytes, size_t most, int64_t wait_ns)
{
    vxsi_usb *usb = self;
    if (usb->done_count == 0 || wait_ns == 0) {
        int64_t us = usb->done_count == 0 && wait_ns > 0 ? wait_ns / 1000 : 0;
        struct timeval time = {.tv_sec = (time_t)(us / 1000000), .tv_usec = (suseconds_t)(us % 1000000)};
        if (libusb_handle_events_timeout_completed(usb->context, &time, NULL) == LIBUSB_ERROR_NO_DEVICE)
            usb->is_gone = 1;
    }
    while (usb->done_count > 0) {
        uint32_t n = usb->done[0];
        memmove(usb->done, usb->done + 1, --usb->done_count);
        size_t count = (size_t)usb->reads[n]->actual_length;
        if (count > most) count = most;
        memcpy(bytes, usb->read[n], count);
        if (!usb->is_gone) submit_read(usb, n);
        if (count > 0) return (int32_t)count;
    }
    return usb->is_gone ? VXS_LOST : 0;
}

/* Every callback is awaited before anything is freed. A kernel that never gives a transfer back keeps it:
 * memory is lost then, but nobody writes to what is not there any more. */
static void close_usb(void *self)
{
    vxsi_usb *usb = self;
    usb->is_closing = 1;
    if (usb->is_writing) libusb_cancel_transfer(usb->write);
    for (int n = 0; n < READS; n++)
        if (usb->reads[n] && usb->reading > 0) libusb_cancel_transfer(usb->reads[n]);
    for (int turn = 0; turn < CLOSE_TURNS && (usb->reading > 0 || usb->is_writing); turn++) {
        struct timeval time = {.tv_sec = 0, .tv_usec = CLOSE_TURN_MS * 1000};
        libusb_handle_events_timeout_completed(usb->context, &time, NULL);
    }
    int is_idle = usb->reading == 0 && !usb->is_writing;
    if (usb->handle) {
        libusb_release_interface(usb->handle, usb->interface);
        if (usb->line != NO_INTERFACE) libusb_release_interface(usb->handle, usb->line);
        if (is_idle) libusb_close(usb->handle);
    }
    if (!is_idle) return;
    libusb_free_transfer(usb->write);
    for (int n = 0; n < READS; n++) libusb_free_transfer(usb->reads[n]);
    libusb_exit(usb->context);
}

static const vxsi_wire_ops ops = {
    .name = "usb", .control = control, .send = send_bytes, .receive = receive_bytes, .close = close_usb};

/* Not there is one thing, not permitted another. */
static int open_matching(vxsi_usb *usb, const vxsi_usb_match *match)
{
    libusb_device **list;
    ssize_t count = libusb_get_device_list(usb->context, &list);
    int result = LIBUSB_ERROR_NOT_FOUND;
    for (ssize_t n = 0; n < count; n++) {
        struct libusb_device_descriptor about;
        if (libusb_get_device_descriptor(list[n], &about) != 0 || about.idVendor != match->vendor ||
            about.idProduct != match->product)
            continue;
        result = libusb_open(list[n], &usb->handle);
        break;
    }
    if (count >= 0) libusb_free_device_list(list, 1);
    return result;
}

/* The interface with data in both directions, and the one before it that tells of the line. */
static int find_serial(vxsi_usb *usb, vxsi_usb_match *match, int *packet)
{
    struct libusb_config_descriptor *config;
    int result = libusb_get_active_config_descriptor(libusb_get_device(usb->handle), &config);
    if (result != LIBUSB_SUCCESS) return result;
    match->in = match->out = 0;
    for (int n = 0; n < config->bNumInterfaces && !(match->in && match->out); n++) {
        const struct libusb_interface_descriptor *about = config->interface[n].altsetting;
        if (config->interface[n].num_altsetting < 1) continue;
        if (about->bInterfaceClass == LIBUSB_CLASS_COMM) usb->line = about->bInterfaceNumber;
        if (about->bInterfaceClass != LIBUSB_CLASS_DATA) continue;
        usb->interface = about->bInterfaceNumber;
        match->in = match->out = 0;
        for (int e = 0; e < about->bNumEndpoints; e++) {
            const struct libusb_endpoint_descriptor *end = &about->endpoint[e];
            if ((end->bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_BULK) continue;
            if (end->bEndpointAddress & LIBUSB_ENDPOINT_IN) {
                match->in = end->bEndpointAddress;
                *packet = end->wMaxPacketSize < PACKET ? end->wMaxPacketSize : PACKET;
            } else {
                match->out = end->bEndpointAddress;
            }
        }
    }
    libusb_free_config_descriptor(config);
    return match->in && match->out && *packet > 0 ? LIBUSB_SUCCESS : LIBUSB_ERROR_NOT_FOUND;
}

/* As opening a tty does: 115200 8N1, which such a device need not care for, and that somebody listens, which
 * many wait for. A device that knows neither request is as good. */
static int tell_line(vxsi_usb *usb)
{
    uint8_t coding[7] = {0x00, 0xC2, 0x01, 0x00, 0, 0, 8};
    const struct {
        uint8_t request;
        uint16_t value;
        uint8_t *bytes, size;
    } steps[] = {{SET_LINE_CODING, 0, coding, sizeof coding}, {SET_LINE_STATE, DTR_AND_RTS, NULL, 0}};
    for (int n = 0; n < 2 && usb->line != NO_INTERFACE; n++) {
        int result = libusb_control_transfer(usb->handle, CLASS_OUT, steps[n].request, steps[n].value,
                                             (uint16_t)usb->line, steps[n].bytes, steps[n].size, CONTROL_MS);
        if (result < 0 && result != LIBUSB_ERROR_PIPE) return result;
    }
    return LIBUSB_SUCCESS;
}

static int claim(vxsi_usb *usb, vxsi_usb_match *match, int *packet)
{
    *packet = FULL_SPEED;
    usb->interface = match->interface;
    libusb_set_auto_detach_kernel_driver(usb->handle, 1);
    int result = match->is_serial ? find_serial(usb, match, packet) : LIBUSB_SUCCESS;
    if (result == LIBUSB_SUCCESS && usb->line != NO_INTERFACE)
        result = libusb_claim_interface(usb->handle, usb->line);
    if (result == LIBUSB_SUCCESS) result = libusb_claim_interface(usb->handle, usb->interface);
    return result == LIBUSB_SUCCESS ? tell_line(usb) : result;
}

static int prepare(vxsi_usb *usb, const vxsi_usb_match *match, int packet)
{
    unsigned char type = match->is_interrupt ? LIBUSB_TRANSFER_TYPE_INTERRUPT : LIBUSB_TRANSFER_TYPE_BULK;
    if (match->out) {
        usb->write = libusb_alloc_transfer(0);
        if (!usb->write) return LIBUSB_ERROR_NO_MEM;
        libusb_fill_bulk_transfer(usb->write, usb->handle, match->out, usb->written, 0, on_write, usb, 0);
        usb->write->type = type;
    }
    for (int n = 0; n < READS; n++) {
        usb->reads[n] = libusb_alloc_transfer(0);
        if (!usb->reads[n]) return LIBUSB_ERROR_NO_MEM;
        libusb_fill_bulk_transfer(usb->reads[n], usb->handle, match->in, usb->read[n], packet, on_read, usb,
                                  0);
        usb->reads[n]->type = type;
    }
    for (uint32_t n = 0; n < READS; n++) submit_read(usb, n);
    return usb->is_gone ? LIBUSB_ERROR_NO_DEVICE : LIBUSB_SUCCESS;
}

vxs_result vxsi_usb_open(vxsi_usb *usb, const vxsi_usb_match *match, vxsi_wire *wire)
{
    vxsi_usb_match found = *match;
    int packet;
    memset(usb, 0, sizeof *usb);
    usb->line = NO_INTERFACE;
    int result = libusb_init(&usb->context);
    if (result != LIBUSB_SUCCESS) return result_of(result);
    result = open_matching(usb, match);
    if (result == LIBUSB_SUCCESS) result = claim(usb, &found, &packet);
    if (result == LIBUSB_SUCCESS) result = prepare(usb, &found, packet);
    if (result != LIBUSB_SUCCESS) {
        close_usb(usb);
        return result_of(result);
    }
    *wire = (vxsi_wire){&ops, usb};
    return VXS_OK;
}

uint32_t vxsi_usb_list(int (*is_known)(uint16_t vendor, uint16_t product), vxsi_usb_seen *seen, uint32_t most)
{
    libusb_context *context;
    libusb_device **list;
    uint32_t found = 0;
    if (libusb_init(&context) != LIBUSB_SUCCESS) return 0;
    ssize_t count = libusb_get_device_list(context, &list);
    for (ssize_t n = 0; n < count; n++) {
        struct libusb_device_descriptor about;
        libusb_device_handle *handle;
        if (libusb_get_device_descriptor(list[n], &about) != 0 || !is_known(about.idVendor, about.idProduct))
            continue;
        if (found++ >= most) continue;
        vxsi_usb_seen *s = &seen[found - 1];
        *s = (vxsi_usb_seen){about.idVendor, about.idProduct, libusb_get_bus_number(list[n]),
                             libusb_get_device_address(list[n]), VXS_OK};
        int result = libusb_open(list[n], &handle);
        s->usable = result_of(result);
        if (result == LIBUSB_SUCCESS) libusb_close(handle);
    }
    if (count >= 0) libusb_free_device_list(list, 1);
    libusb_exit(context);
    return found;
}
