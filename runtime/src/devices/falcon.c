/* SPDX-License-Identifier: MIT
 *
 * The Novint Falcon: an FTDI chip, a signal processor that needs firmware, three legs. Not verified on
 * hardware.
 *
 * No firmware is shipped, and none is fetched: the known blobs stand under a vendor's licence that forbids
 * those who accept it to emulate the protocol. The user passes a file of their own, or plugs in a device that
 * has it already. What a motor's unit is worth is not settled either: config.units_per_nm is the weak end of
 * what is reported.
 */
#include "falcon_kinematics.h"
#include "falcon_protocol.h"
#include "link.h"

#include <math.h>
#include <stdio.h>

/* Requests of the chip's. */
enum { FTDI_RESET = 0, FTDI_MODEM = 1, FTDI_FLOW = 2, FTDI_BAUD = 3, FTDI_DATA = 4, FTDI_LATENCY = 9 };
enum { BAUD_9600 = 0x4138, BAUD_140000 = 0x15, BAUD_1500000 = 0x2, CHUNK = 62, MOST_FIRMWARE = 65536 };
enum { MOTOR_MOST = 4095, UPLOADS = 10, PRESENCE_TRIES = 10 };
static const double centre_z = 0.12; /* of the workspace */

typedef struct falcon_host {
    vxsi_falcon_stream stream;
    double place[3], jacobian[9];
    uint32_t is_homed;
    uint8_t expected[CHUNK]; /* of the firmware's echo */
    uint32_t expected_size, got;
} falcon_host;
_Static_assert(sizeof(falcon_host) <= VXSI_LINK_MEMORY, "a driver's memory");

static falcon_host *host_of(vxsi_link *link)
{
    return (falcon_host *)(void *)link->driver_memory;
}

static vxs_result control(vxsi_link *link, const uint16_t (*steps)[2], size_t count)
{
    vxs_result result = link->wire.ops->control ? VXS_OK : VXS_UNSUPPORTED;
    for (size_t n = 0; n < count && result == VXS_OK; n++)
        result = link->wire.ops->control(link->wire.self, (uint8_t)steps[n][0], steps[n][1]);
    return result;
}

static vxs_result normal_mode(vxsi_link *link)
{
    static const uint16_t steps[][2] = {{FTDI_LATENCY, 1}, {FTDI_BAUD, BAUD_1500000}, {FTDI_DATA, 8},
                                        {FTDI_FLOW, 0},    {FTDI_RESET, 1},           {FTDI_RESET, 2}};
    return control(link, steps, sizeof steps / sizeof *steps);
}

static size_t make(vxsi_link *link, const vxs_wrench *wrench, uint32_t arming, uint8_t *bytes)
{
    const falcon_host *host = host_of(link);
    vxsi_falcon_output output = {{0, 0, 0}, VXSI_FALCON_HOMING};
    double torque[3], most = 0;
    output.lamps |= host->is_homed ? VXSI_FALCON_GREEN : VXSI_FALCON_RED;
    if (arming) output.lamps |= VXSI_FALCON_BLUE;
    /* Before the first place the Jacobian is zero, and has no torque. */
    if (arming && vxsi_falcon_torque(host->jacobian, wrench->force, torque)) {
        for (int n = 0; n < 3; n++) {
            torque[n] *= -link->config.units_per_nm;
            most = fmax(most, fabs(torque[n]));
        }
        double factor = most > MOTOR_MOST ? MOTOR_MOST / most : 1;
        for (int n = 0; n < 3 && isfinite(most); n++) output.motor[n] = (int16_t)lrint(torque[n] * factor);
    }
    vxsi_falcon_encode_output(&output, bytes);
    return VXSI_FALCON_PACKET;
}

static uint32_t take(vxsi_link *link, const uint8_t *bytes, size_t size, vxs_device_state *state)
{
    falcon_host *host = host_of(link);
    uint8_t copy[VXSI_WIRE_MOST];
    uint32_t found = 0;
    memcpy(copy, bytes, size);
    size = vxsi_ftdi_strip(copy, size);
    for (size_t n = 0; n < size; n++) {
        int taken = vxsi_falcon_take(&host->stream, copy[n]);
        vxsi_falcon_input input;
        double angle[3], place[3], jacobian[9];
        if (taken == 0) continue;
        found |= VXSI_LINK_MALFORMED;
        if (taken < 0 || !vxsi_falcon_decode_input(host->stream.bytes, &input)) continue;
        for (int i = 0; i < 3; i++) angle[i] = vxsi_falcon_angle(input.encoder[i]);
        memcpy(place, host->place, sizeof place);
        host->is_homed = input.homed == 7;
        /* Before homing the encoders mean nothing, and need not be a place. */
        if (host->is_homed &&
            (!vxsi_falcon_forward(angle, place) || !vxsi_falcon_inverse(place, angle, jacobian)))
            continue;
        if (host->is_homed) {
            memcpy(host->place, place, sizeof place);
            memcpy(host->jacobian, jacobian, sizeof jacobian);
            memcpy(state->pose.position, place, sizeof place);
            state->pose.position[2] -= centre_z;
        }
        state->buttons = input.buttons;
        state->velocity_source = VXS_DEVICE_VELOCITY_NONE;
        state->state = host->is_homed ? VXS_DEVICE_READY : VXS_DEVICE_UNCALIBRATED;
        found = VXSI_LINK_NEWS;
    }
    return found;
}

static int is_answer(vxsi_link *link, const uint8_t *bytes, size_t size)
{
    vxs_device_state state = link->measured;
    return (take(link, bytes, size, &state) & VXSI_LINK_NEWS) != 0;
}

static vxs_result find_firmware(vxsi_link *link)
{
    static const vxs_wrench zero = {{0, 0, 0}, {0, 0, 0}};
    uint8_t bytes[VXSI_FALCON_PACKET];
    vxs_result result = normal_mode(link);
    for (int n = 0; n < PRESENCE_TRIES && result == VXS_OK; n++) {
        result = vxsi_link_ask(link, bytes, make(link, &zero, 0, bytes), is_answer, 20000000);
        if (result == VXS_OK) return VXS_OK;
        if (result == VXS_TIMEOUT || result == VXS_BUSY)
            result = n + 1 < PRESENCE_TRIES ? VXS_OK : VXS_TIMEOUT;
    }
    return result;
}

/* The bytes that are expected, in any number of pieces, a 0 before them passed over. */
static int is_echo(vxsi_link *link, const uint8_t *bytes, size_t size)
{
    falcon_host *host = host_of(link);
    uint8_t copy[VXSI_WIRE_MOST];
    memcpy(copy, bytes, size);
    size = vxsi_ftdi_strip(copy, size);
    for (size_t n = 0; n < size && host->got < host->expected_size; n++) {
        if (copy[n] == host->expected[host->got])
            host->got++;
        else if (host->got > 0 || copy[n] != 0)
            host->got = 0;
    }
    return host->got == host->expected_size;
}

static vxs_result say(vxsi_link *link, const uint8_t *bytes, size_t size, const uint8_t *expected,
                      uint32_t expected_size)
{
    falcon_host *host = host_of(link);
    memcpy(host->expected, expected, expected_size);
    host->expected_size = expected_size;
    host->got = 0;
    return vxsi_link_ask(link, bytes, size, is_echo, 100000000);
}

static vxs_result upload(vxsi_link *link, FILE *file)
{
    static const uint16_t before[][2] = {{FTDI_RESET, 1},        {FTDI_RESET, 2},      {FTDI_LATENCY, 16},
                                         {FTDI_BAUD, BAUD_9600}, {FTDI_DATA, 8},       {FTDI_FLOW, 0},
                                         {FTDI_MODEM, 0x0200},   {FTDI_MODEM, 0x0100}, {FTDI_MODEM, 0x0101}};
    static const uint16_t between[][2] = {{FTDI_MODEM, 0x0100}, {FTDI_BAUD, BAUD_140000}};
    static const uint8_t knock[] = {0x0A, 0x43, 0x0D}, who[] = {0x0A, 0x44, 0x2C, 0x0D}, ready[] = {0x41};
    uint8_t chunk[CHUNK];
    vxs_result result = control(link, before, sizeof before / sizeof *before);
    if (result == VXS_OK) result = say(link, knock, sizeof knock, who, sizeof who);
    if (result == VXS_OK) result = control(link, between, sizeof between / sizeof *between);
    if (result == VXS_OK) result = say(link, ready, sizeof ready, ready, sizeof ready);
    rewind(file);
    for (size_t size; result == VXS_OK && (size = fread(chunk, 1, sizeof chunk, file)) > 0;)
        result = say(link, chunk, size, chunk, (uint32_t)size);
    return result;
}

static vxs_result begin(vxsi_link *link)
{
    vxs_device_caps *caps = &link->device.caps;
    snprintf(caps->name, sizeof caps->name, "Novint Falcon");
    caps->dof_sensed = caps->dof_actuated = VXS_DEVICE_DOF_TRANSLATION;
    caps->peak_force = 8;
    caps->max_stiffness = 3000;
    caps->max_damping = 20;
    caps->resolution = 38e-6;
    host_of(link)->place[2] = centre_z;
    vxs_result result = find_firmware(link);
    if (result == VXS_TIMEOUT && link->config.firmware) {
        FILE *file = fopen(link->config.firmware, "rb");
        if (!file) return VXS_IO;
        /* It often fails at first, and works after some more tries. */
        for (int n = 0; n < UPLOADS && (result == VXS_TIMEOUT || result == VXS_BUSY); n++) {
            result = upload(link, file);
            if (result == VXS_OK) result = find_firmware(link);
        }
        fclose(file);
        if (result == VXS_BUSY) result = VXS_TIMEOUT;
    } else if (result == VXS_TIMEOUT) {
        link->start = VXS_DEVICE_NO_FIRMWARE;
        return VXS_OK;
    }
    link->start = VXS_DEVICE_UNCALIBRATED; /* READY when it says that it is homed */
    return result;
}

const vxsi_driver vxsi_falcon_driver = {
    .name = "falcon", .begin = begin, .take = take, .make = make, .answers = 1};
