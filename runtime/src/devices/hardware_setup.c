/* SPDX-License-Identifier: MIT
 *
 * The table of kinds, and opening one. A new kind: its driver in a file of its own, and a row here.
 */
#include "link.h"
#include "spacemouse_protocol.h"

#include <stdio.h>
#include <stdlib.h>

enum { ALIGNMENT = 64 };

#ifdef VXSI_LIBUSB
#define USB_BUILT 1
#define USB_LACKS NULL
#else
#define USB_BUILT 0
#define USB_LACKS "this build has no libusb-1.0 (Debian: libusb-1.0-0-dev)"
static uint32_t list_none(int (*is_known)(uint16_t, uint16_t), vxsi_usb_seen *seen, uint32_t most)
{
    (void)is_known, (void)seen, (void)most;
    return 0;
}
#define vxsi_usb_list list_none
#endif

static int is_falcon(uint16_t vendor, uint16_t product)
{
    return vendor == 0x0403 && product == 0xCB48;
}

enum { HVLINK, HAPLY, SPACEMOUSE, FALCON, KINDS };
static const vxs_hardware_kind kinds[KINDS] = {
    [HVLINK] = {"hvlink", "devices that people build, on the open protocol hvlink", VXS_HARDWARE_TTY, 1,
                NULL},
    [HAPLY] = {"haply", "Haply 2diy and other hAPI boards: 2 axes, force", VXS_HARDWARE_TTY, 1, NULL},
    [SPACEMOUSE] = {"spacemouse", "3Dconnexion's six-axis mice: speed in, no force", VXS_HARDWARE_USB,
                    USB_BUILT, USB_LACKS},
#ifdef VXSI_FALCON
    [FALCON] = {"falcon", "Novint Falcon: 3 axes, force; firmware is the user's", VXS_HARDWARE_USB, USB_BUILT,
                USB_LACKS},
#else
    [FALCON] = {"falcon", "Novint Falcon: 3 axes, force; firmware is the user's", VXS_HARDWARE_USB, 0,
                "this build was configured without -DVOXSHELL_FALCON=ON"},
#endif
};

/* Drivers, and where on USB they live. */
static const struct row {
    const vxsi_driver *driver;
    int (*is_known)(uint16_t vendor, uint16_t product);
    vxsi_usb_match match;
} rows[KINDS] = {
    [HVLINK] = {&vxsi_hvlink_driver, NULL, {0}},
    [HAPLY] = {&vxsi_haply_driver, NULL, {0}},
    [SPACEMOUSE] = {&vxsi_spacemouse_driver, vxsi_spacemouse_is_known, {.in = 0x81, .is_interrupt = 1}},
    [FALCON] = {&vxsi_falcon_driver, is_falcon, {.in = 0x81, .out = 0x02}},
};

const vxs_hardware_kind *vxs_hardware_kind_at(uint32_t index)
{
    return index < KINDS ? &kinds[index] : NULL;
}

const vxs_hardware_kind *vxs_hardware_kind_named(const char *name)
{
    for (int n = 0; name && n < KINDS; n++)
        if (strcmp(kinds[n].name, name) == 0) return &kinds[n];
    return NULL;
}

uint32_t vxs_hardware_probe(vxs_hardware_found *found, uint32_t most)
{
    enum { SEEN = 16 };
    uint32_t count = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        vxsi_usb_seen seen[SEEN];
        if (!rows[kind].is_known) continue;
        uint32_t here = vxsi_usb_list(rows[kind].is_known, seen, SEEN);
        for (uint32_t n = 0; n < here && n < SEEN; n++, count++) {
            if (count < most)
                found[count] = (vxs_hardware_found){&kinds[kind], seen[n].vendor, seen[n].product,
                                                    seen[n].bus,  seen[n].number, seen[n].usable};
        }
    }
    return count;
}

void vxs_hardware_config_default(vxs_hardware_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->units_per_nm = 2300;
    config->torque_gain = 1;
    config->rate_hz = 1000;
    config->max_speed = 20;
    config->linear_speed = 0.1;
    config->angular_speed = 1;
}

typedef struct hardware {
    vxsi_link link;
    vxsi_tty tty;
} hardware;

static size_t round_up(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

#ifdef VXSI_LIBUSB
/* "VVVV:PPPP", or the first device that the kind knows. */
static vxs_result open_usb(const struct row *row, const char *address, vxsi_usb *usb, vxsi_wire *wire)
{
    vxsi_usb_match match = row->match;
    if (address) {
        unsigned vendor, product;
        char end;
        if (sscanf(address, "%4x:%4x%c", &vendor, &product, &end) != 2) return VXS_PARAM;
        match.vendor = (uint16_t)vendor;
        match.product = (uint16_t)product;
    } else {
        vxsi_usb_seen seen;
        if (vxsi_usb_list(row->is_known, &seen, 1) == 0) return VXS_NO_DEVICE;
        match.vendor = seen.vendor;
        match.product = seen.product;
    }
    return vxsi_usb_open(usb, &match, wire);
}

size_t vxs_hardware_memory(void)
{
    return round_up(sizeof(hardware)) + round_up(vxsi_usb_memory());
}
#else
size_t vxs_hardware_memory(void)
{
    return round_up(sizeof(hardware));
}
#endif

static int is_positive(double value)
{
    return value > 0 && value < 1e9;
}

static vxs_result check(const vxs_hardware_config *config)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    return is_positive(config->units_per_nm) && is_positive(config->torque_gain) && config->rate_hz >= 100 &&
                   config->rate_hz <= 10000 && is_positive(config->max_speed) &&
                   is_positive(config->linear_speed) && is_positive(config->angular_speed)
               ? VXS_OK
               : VXS_PARAM;
}

vxs_result vxs_hardware_open(void *memory, size_t size, const vxs_hardware_kind *kind,
                             const vxs_hardware_config *config, vxs_device **out)
{
    vxs_result result = check(config);
    if (result != VXS_OK) return result;
    if (!memory || !out || !kind || kind < kinds || kind >= kinds + KINDS) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_hardware_memory()) return VXS_BUFFER;
    if (!kind->is_built) return VXS_UNSUPPORTED;
    hardware *h = memory;
    const struct row *row = &rows[kind - kinds];
    vxsi_wire wire;
    h->link.now = NULL;
    if (kind->wire == VXS_HARDWARE_TTY) {
        result = config->address ? vxsi_tty_open(&h->tty, config->address, &wire) : VXS_NO_DEVICE;
    } else {
#ifdef VXSI_LIBUSB
        result = open_usb(row, config->address, (vxsi_usb *)(void *)((uint8_t *)memory + round_up(sizeof *h)),
                          &wire);
#else
        return VXS_UNSUPPORTED;
#endif
    }
    if (result == VXS_OK) result = vxsi_link_open(&h->link, row->driver, config, &wire);
    if (result == VXS_OK) result = vxsi_link_run(&h->link);
    if (result == VXS_OK) *out = &h->link.device;
    return result;
}

void vxs_hardware_get(const vxs_device *device, vxs_hardware_counts *counts)
{
    const vxsi_link *link = device->self;
    counts->sent = atomic_load_explicit(&link->sent, memory_order_relaxed);
    counts->measured = atomic_load_explicit(&link->measured_count, memory_order_relaxed);
    counts->malformed = atomic_load_explicit(&link->malformed, memory_order_relaxed);
    counts->late = atomic_load_explicit(&link->late, memory_order_relaxed);
}
