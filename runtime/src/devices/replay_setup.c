/* SPDX-License-Identifier: MIT
 *
 * Set-up of the replay device: rows out of files, opening.
 */
#define _POSIX_C_SOURCE 200809L /* newlocale */

#include "replay_model.h"
#include "voxshell/servo.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 16, COLUMNS = 64, FIELD = 64, HEAD = 16, FIELDS = 9, MOST_NUMBER = 1000000000 };

void vxs_replay_config_default(vxs_replay_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->sample_time = 0.001;
}

size_t vxs_replay_memory(void)
{
    return (sizeof(vxsi_replay) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static vxs_result arm(void *self)
{
    vxsi_replay *r = self;
    if (r->state != VXS_DEVICE_READY && r->state != VXS_DEVICE_ARMED) return VXS_STATE;
    r->state = VXS_DEVICE_ARMED;
    return VXS_OK;
}

static vxs_result disarm(void *self)
{
    vxsi_replay *r = self;
    if (r->state == VXS_DEVICE_CLOSED) return VXS_STATE;
    r->state = VXS_DEVICE_READY;
    r->fault = VXS_DEVICE_FAULT_NONE;
    return VXS_OK;
}

static void close_device(void *self)
{
    vxsi_replay *r = self;
    r->state = VXS_DEVICE_CLOSED;
}

static const vxs_device_ops ops = {
    .name = "replay", .arm = arm, .disarm = disarm, .close = close_device, .exchange = vxsi_replay_exchange};

/* Bounded: the difference of two is finite, too. */
static int is_number(double value)
{
    return fabs(value) <= MOST_NUMBER;
}

static int are_rows(const vxs_replay_row *rows, size_t count)
{
    double rotation[9];
    for (size_t n = 0; n < count; n++) {
        const double *at = rows[n].pose.position;
        if (!is_number(rows[n].time) || !is_number(at[0]) || !is_number(at[1]) || !is_number(at[2]) ||
            (n > 0 && !(rows[n].time > rows[n - 1].time)) || !vxs_pose_rotation(&rows[n].pose, rotation))
            return 0;
    }
    return count > 0;
}

vxs_result vxs_replay_open(void *memory, size_t size, const vxs_replay_config *config, vxs_device **out)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    if (!memory || !out || !config->rows || !(config->sample_time >= 1e-5 && config->sample_time <= 0.1) ||
        !are_rows(config->rows, config->row_count))
        return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_replay_memory()) return VXS_BUFFER;
    vxsi_replay *r = memory;
    memset(r, 0, sizeof *r);
    r->device.ops = &ops;
    r->device.self = r;
    snprintf(r->device.caps.name, sizeof r->device.caps.name, "replay");
    r->device.caps.dof_sensed = VXS_DEVICE_DOF_TRANSLATION | VXS_DEVICE_DOF_ROTATION;
    r->device.caps.rate_hz = 1 / config->sample_time;
    r->config = *config;
    r->state = VXS_DEVICE_READY;
    r->sample_ns = (int64_t)(config->sample_time * 1e9 + 0.5);
    *out = &r->device;
    return VXS_OK;
}

/* Recordings: time from the device's clock. */
static vxs_result parse_recording(const uint8_t *bytes, size_t size, vxs_replay_row *rows, size_t most,
                                  size_t *count)
{
    uint32_t row_size;
    if (size < HEAD) return VXS_TRUNCATED;
    memcpy(&row_size, bytes + 8, sizeof row_size);
    if (row_size != sizeof(vxs_servo_trace)) return VXS_VERSION;
    if ((size - HEAD) % row_size != 0) return VXS_TRUNCATED;
    *count = (size - HEAD) / row_size;
    for (size_t n = 0; n < *count && n < most && rows; n++) {
        vxs_servo_trace row;
        memcpy(&row, bytes + HEAD + n * row_size, sizeof row);
        rows[n] = (vxs_replay_row){.time = (double)row.time_ns * 1e-9, .pose = row.pose};
    }
    return VXS_OK;
}

/* The next field of a line, without its separator; 0 at the line's end. */
static int field(const char **at, const char *end, char text[FIELD])
{
    const char *from = *at;
    if (from > end) return 0;
    while (*at < end && **at != ',') ++*at;
    size_t length = (size_t)(*at - from);
    if (length >= FIELD) length = FIELD - 1;
    memcpy(text, from, length);
    text[length] = 0;
    ++*at; /* past the comma, or past the end */
    return 1;
}

static int column_of(const char *name)
{
    static const char *const names[FIELDS] = {"t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "buttons"};
    if (strncmp(name, "device_", 7) == 0) name += 7;
    for (int n = 0; n < FIELDS; n++)
        if (strcmp(name, names[n]) == 0) return n;
    return -1;
}

static int read_head(const char *at, const char *end, int8_t columns[COLUMNS], int *count)
{
    char text[FIELD];
    uint32_t found = 0;
    for (*count = 0; field(&at, end, text); ++*count) {
        if (*count == COLUMNS) return 0;
        int column = column_of(text);
        if (column >= 0 && found >> column & 1) return 0;
        if (column >= 0) found |= 1u << column;
        columns[*count] = (int8_t)column;
    }
    return (found & 15) == 15;
}

static int read_row(const char *at, const char *end, const int8_t columns[COLUMNS], int count,
                    vxs_replay_row *row)
{
    double value[FIELDS] = {0, 0, 0, 0, 1, 0, 0, 0, 0};
    char text[FIELD];
    int n = 0;
    for (; field(&at, end, text); n++) {
        if (n == count) return 0;
        if (columns[n] < 0) continue;
        char *stop;
        value[columns[n]] = strtod(text, &stop);
        if (stop == text || *stop || !isfinite(value[columns[n]])) return 0;
    }
    if (n != count || !(value[8] >= 0 && value[8] <= 4294967295.0)) return 0;
    *row = (vxs_replay_row){.time = value[0], .buttons = (uint32_t)value[8]};
    memcpy(row->pose.position, value + 1, 3 * sizeof *value);
    memcpy(row->pose.orientation, value + 4, 4 * sizeof *value);
    return 1;
}

static vxs_result parse(const void *bytes, size_t size, vxs_replay_row *rows, size_t most, size_t *count,
                        size_t *line)
{
    int8_t columns[COLUMNS];
    int column_count = 0;
    *count = *line = 0;
    if (size >= 8 && memcmp(bytes, "VXSREC01", 8) == 0)
        return parse_recording(bytes, size, rows, most, count);
    const char *at = bytes, *end = at + size;
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        const char *last = stop ? stop : end;
        if (last > at && last[-1] == '\r') last--;
        ++*line;
        vxs_replay_row row;
        if (*line == 1) {
            if (!read_head(at, last, columns, &column_count)) return VXS_CORRUPT;
        } else if (last > at) {
            if (!read_row(at, last, columns, column_count, &row)) return VXS_CORRUPT;
            if (rows && *count < most) rows[*count] = row;
            ++*count;
        }
        at = stop ? stop + 1 : end;
    }
    return *line > 0 ? VXS_OK : VXS_CORRUPT;
}

/* The program's language may have a decimal comma; a file never has. */
vxs_result vxs_replay_parse(const void *bytes, size_t size, vxs_replay_row *rows, size_t most, size_t *count,
                            size_t *line)
{
    size_t ignored;
    if (!bytes || !count) return VXS_PARAM;
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    locale_t before = plain ? uselocale(plain) : (locale_t)0;
    vxs_result result = parse(bytes, size, rows, most, count, line ? line : &ignored);
    if (plain) {
        (void)uselocale(before);
        freelocale(plain);
    }
    return result;
}
