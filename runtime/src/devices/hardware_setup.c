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
#define USB VXS_HARDWARE_USB
#define USB_LACKS NULL
#else
#define USB 0
#define USB_LACKS "this build has no libusb-1.0 (Debian: libusb-1.0-0-dev)"
static uint32_t list_none(int (*is_known)(uint16_t, uint16_t), vxsi_usb_seen *seen, uint32_t most)
{
    (void)is_known, (void)seen, (void)most;
    return 0;
}
static size_t no_memory(void)
{
    return 0;
}
static vxs_result open_none(vxsi_usb *usb, const vxsi_usb_match *match, vxsi_wire *wire)
{
    (void)usb, (void)match, (void)wire;
    return VXS_UNSUPPORTED;
}
#define vxsi_usb_list list_none
#define vxsi_usb_memory no_memory
#define vxsi_usb_open open_none
#endif

static int is_falcon(uint16_t vendor, uint16_t product)
{
    return vendor == 0x0403 && product == 0xCB48;
}

#ifdef VXSI_FALCON
#define FALCON_LACKS USB_LACKS
#define FALCON_WIRES USB
#else
#define FALCON_LACKS "this build was configured without -DVOXSHELL_FALCON=ON"
#define FALCON_WIRES 0
#endif

enum { HVLINK, HAPLY, SPACEMOUSE, FALCON, KINDS };
static const vxs_hardware_kind kinds[KINDS] = {
    [HVLINK] = {"hvlink", "devices that people build, on the open protocol hvlink", VXS_HARDWARE_TTY | USB, 1,
                NULL},
    [HAPLY] = {"haply", "Haply 2diy and other hAPI boards: 2 axes, force", VXS_HARDWARE_TTY | USB, 1, NULL},
    [SPACEMOUSE] = {"spacemouse", "3Dconnexion's six-axis mice: speed in, no force",
                    VXS_HARDWARE_HIDRAW | USB, 1, NULL},
    [FALCON] = {"falcon", "Novint Falcon: 3 axes, force; firmware is the user's", FALCON_WIRES,
                FALCON_WIRES != 0, FALCON_LACKS},
};

/* Drivers, and where on USB they live. */
static const struct row {
    const vxsi_driver *driver;
    int (*is_known)(uint16_t vendor, uint16_t product);
    vxsi_usb_match match;
} rows[KINDS] = {
    [HVLINK] = {&vxsi_hvlink_driver, NULL, {.is_serial = 1}},
    [HAPLY] = {&vxsi_haply_driver, NULL, {.is_serial = 1}},
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

enum { SEEN = 16 };
typedef struct finding {
    vxs_hardware_found *found;
    uint32_t most, count;
} finding;

static vxs_hardware_found *next_found(finding *f, vxs_hardware_found *beyond)
{
    return f->count++ < f->most ? &f->found[f->count - 1] : beyond;
}

static void find_of(int kind, finding *f)
{
    int (*is_known)(uint16_t, uint16_t) = rows[kind].is_known;
    vxsi_hidraw_seen nodes[SEEN];
    vxsi_usb_seen seen[SEEN];
    vxs_hardware_found beyond;
    uint32_t node_count = 0;
    if (kinds[kind].wires & VXS_HARDWARE_HIDRAW) node_count = vxsi_hidraw_list(is_known, nodes, SEEN);
    if (node_count > SEEN) node_count = SEEN;
    for (uint32_t n = 0; n < node_count; n++) {
        vxs_hardware_found *at = next_found(f, &beyond);
        *at = (vxs_hardware_found){&kinds[kind],        nodes[n].vendor, nodes[n].product,
                                   VXS_HARDWARE_HIDRAW, nodes[n].usable, ""};
        memcpy(at->node, nodes[n].path, sizeof at->node);
    }
    uint32_t here = vxsi_usb_list(is_known, seen, SEEN);
    for (uint32_t n = 0; n < here && n < SEEN; n++) {
        int is_had = 0;
        for (uint32_t i = 0; i < node_count; i++)
            is_had |= nodes[i].usable == VXS_OK && nodes[i].vendor == seen[n].vendor &&
                      nodes[i].product == seen[n].product;
        if (is_had) continue;
        vxs_hardware_found *at = next_found(f, &beyond);
        *at = (vxs_hardware_found){&kinds[kind],     seen[n].vendor, seen[n].product,
                                   VXS_HARDWARE_USB, seen[n].usable, ""};
        snprintf(at->node, sizeof at->node, "/dev/bus/usb/%03u/%03u", (unsigned)seen[n].bus,
                 (unsigned)seen[n].number);
    }
}

uint32_t vxs_hardware_probe(vxs_hardware_found *found, uint32_t most)
{
    finding f = {found, most, 0};
    for (int kind = 0; kind < KINDS; kind++)
        if (rows[kind].is_known) find_of(kind, &f);
    return f.count;
}

void vxs_hardware_config_default(vxs_hardware_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->units_per_nm = 2300;
    config->haply_setup = 2;
    config->haply_links[0] = 0.05;
    config->haply_links[1] = 0.07;
    config->haply_links[2] = 0.02;
    config->torque_gain = 1;
    config->rate_hz = 1000;
    config->max_speed = 20;
    config->linear_speed = 0.1;
    config->angular_speed = 1;
}

typedef struct hardware {
    vxsi_link link;
    vxsi_tty tty;
    vxsi_hidraw hidraw;
} hardware;

static size_t round_up(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static vxsi_usb *usb_of(hardware *h)
{
    return (vxsi_usb *)(void *)((uint8_t *)h + round_up(sizeof *h));
}

size_t vxs_hardware_memory(void)
{
    return round_up(sizeof(hardware)) + round_up(vxsi_usb_memory());
}

static int is_positive(double value)
{
    return value > 0 && value < 1e9;
}

static vxs_result check(const vxs_hardware_config *config)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    for (int n = 0; n < 3; n++)
        if (!(config->haply_links[n] >= 0 && config->haply_links[n] < 1)) return VXS_PARAM;
    if (config->haply_setup != 2 && config->haply_setup != 3) return VXS_PARAM;
    return is_positive(config->units_per_nm) && is_positive(config->torque_gain) && config->rate_hz >= 100 &&
                   config->rate_hz <= 10000 && is_positive(config->max_speed) &&
                   is_positive(config->linear_speed) && is_positive(config->angular_speed)
               ? VXS_OK
               : VXS_PARAM;
}

/* "VVVV:PPPP" */
static int read_ids(const char *address, vxsi_usb_match *match)
{
    unsigned vendor, product;
    char end;
    if (sscanf(address, "%4x:%4x%c", &vendor, &product, &end) != 2 || vendor == 0) return 0;
    match->vendor = (uint16_t)vendor;
    match->product = (uint16_t)product;
    return 1;
}

/* The first node of such a device that may be read; VXS_ACCESS where there are but locked ones. */
static vxs_result open_hidraw(const struct row *row, const vxsi_usb_match *wanted, vxsi_hidraw *hidraw,
                              vxsi_wire *wire)
{
    vxsi_hidraw_seen seen[SEEN];
    vxs_result result = VXS_NO_DEVICE;
    uint32_t here = vxsi_hidraw_list(row->is_known, seen, SEEN);
    for (uint32_t n = 0; n < here && n < SEEN && result != VXS_OK; n++) {
        if (wanted->vendor && (seen[n].vendor != wanted->vendor || seen[n].product != wanted->product))
            continue;
        result = vxsi_hidraw_open(hidraw, seen[n].path, wire);
    }
    return result;
}

static vxs_result open_usb(const struct row *row, vxsi_usb_match match, vxsi_usb *usb, vxsi_wire *wire)
{
    vxsi_usb_seen seen;
    if (!match.vendor) {
        if (!row->is_known || vxsi_usb_list(row->is_known, &seen, 1) == 0) return VXS_NO_DEVICE;
        match.vendor = seen.vendor;
        match.product = seen.product;
    }
    return vxsi_usb_open(usb, &match, wire);
}

static vxs_result open_wire(hardware *h, const vxs_hardware_kind *kind, const char *address, vxsi_wire *wire)
{
    const struct row *row = &rows[kind - kinds];
    vxsi_usb_match match = row->match;
    if (address && strchr(address, '/')) {
        return kind->wires & VXS_HARDWARE_TTY      ? vxsi_tty_open(&h->tty, address, wire)
               : kind->wires & VXS_HARDWARE_HIDRAW ? vxsi_hidraw_open(&h->hidraw, address, wire)
                                                   : VXS_PARAM;
    }
    if (address && !read_ids(address, &match)) return VXS_PARAM;
    vxs_result result = VXS_NO_DEVICE, usb = VXS_NO_DEVICE;
    if (kind->wires & VXS_HARDWARE_HIDRAW) result = open_hidraw(row, &match, &h->hidraw, wire);
    if (result != VXS_OK && kind->wires & VXS_HARDWARE_USB) usb = open_usb(row, match, usb_of(h), wire);
    return result == VXS_NO_DEVICE || usb == VXS_OK ? usb : result;
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
    vxsi_wire wire;
    h->link.now = NULL;
    result = open_wire(h, kind, config->address, &wire);
    if (result == VXS_OK) result = vxsi_link_open(&h->link, rows[kind - kinds].driver, config, &wire);
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
