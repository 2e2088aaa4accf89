/* SPDX-License-Identifier: MIT
 *
 * A wire that is a HID device's node of the kernel: reports in, nothing out. The desktop keeps the device.
 */
#define _GNU_SOURCE 1 /* O_CLOEXEC */

#include "wire.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { NAME = 16 }; /* "hidraw" and a number */

static vxs_result open_node(const char *path, int *file)
{
    *file = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (*file >= 0) return VXS_OK;
    return errno == EACCES || errno == EPERM                      ? VXS_ACCESS
           : errno == ENOENT || errno == ENXIO || errno == ENODEV ? VXS_NO_DEVICE
                                                                  : VXS_IO;
}

/* What a six-axis mouse understands (its light) is nothing that anybody waits for. */
static vxs_result send_nothing(void *self, const uint8_t *bytes, size_t size)
{
    (void)self, (void)bytes, (void)size;
    return VXS_UNSUPPORTED;
}

static int32_t receive_report(void *self, uint8_t *bytes, size_t most, int64_t wait_ns)
{
    return vxsi_wire_read(((const vxsi_hidraw *)self)->file, bytes, most, wait_ns);
}

static void close_hidraw(void *self)
{
    vxsi_hidraw *hidraw = self;
    close(hidraw->file);
    hidraw->file = -1;
}

static const vxsi_wire_ops ops = {
    .name = "hidraw", .send = send_nothing, .receive = receive_report, .close = close_hidraw};

vxs_result vxsi_hidraw_open(vxsi_hidraw *hidraw, const char *path, vxsi_wire *wire)
{
    vxs_result result = open_node(path, &hidraw->file);
    if (result == VXS_OK) *wire = (vxsi_wire){&ops, hidraw};
    return result;
}

/* Of a line "HID_ID=0003:0000256F:0000C635" (bus, vendor, product), on USB or Bluetooth. */
static int read_id(const char *name, unsigned *vendor, unsigned *product)
{
    char path[64], line[256];
    unsigned bus;
    int is_found = 0;
    snprintf(path, sizeof path, "/sys/class/hidraw/%s/device/uevent", name);
    FILE *file = fopen(path, "re");
    if (!file) return 0;
    while (!is_found && fgets(line, sizeof line, file))
        is_found = sscanf(line, "HID_ID=%x:%x:%x", &bus, vendor, product) == 3 && *vendor <= 0xFFFF &&
                   *product <= 0xFFFF;
    fclose(file);
    return is_found;
}

uint32_t vxsi_hidraw_list(int (*is_known)(uint16_t vendor, uint16_t product), vxsi_hidraw_seen *seen,
                          uint32_t most)
{
    uint32_t found = 0;
    DIR *folder = opendir("/sys/class/hidraw");
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        unsigned vendor, product;
        if (entry->d_name[0] == '.' || strlen(entry->d_name) >= NAME ||
            !read_id(entry->d_name, &vendor, &product) || !is_known((uint16_t)vendor, (uint16_t)product))
            continue;
        if (found++ >= most) continue;
        vxsi_hidraw_seen *s = &seen[found - 1];
        int file;
        s->vendor = (uint16_t)vendor;
        s->product = (uint16_t)product;
        snprintf(s->path, sizeof s->path, "/dev/%s", entry->d_name);
        s->usable = open_node(s->path, &file);
        if (s->usable == VXS_OK) close(file);
    }
    if (folder) closedir(folder);
    return found;
}
