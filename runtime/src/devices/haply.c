/* SPDX-License-Identifier: MIT
 *
 * Haply 2diy and other hAPI boards: a pantograph in the plane of x (right) and z (towards the user). Not
 * verified on hardware. The board has no watchdog: a host that is killed leaves the last torque; have a
 * switch at hand.
 */
#include "haply_kinematics.h"
#include "haply_protocol.h"
#include "link.h"

#include <stdio.h>

enum { DEVICE_ID = 5, ASKS = 5 };
static const int64_t gap_ns = 5000000;
static const double degree = 0.017453292519943295;

/* As most public sketches have them: motor and encoder 2 on port 1, 1 on port 2. */
static const vxsi_haply_setup setups[2] = {
    {.device = DEVICE_ID,
     .motor_ports = 3,
     .encoder_ports = 3,
     .motor_turn = {VXSI_HAPLY_CLOCKWISE, VXSI_HAPLY_COUNTER},
     .encoder_turn = {VXSI_HAPLY_CLOCKWISE, VXSI_HAPLY_COUNTER},
     .offset = {-61, 241},
     .counts = {10752, 10752}},
    {.device = DEVICE_ID,
     .motor_ports = 3,
     .encoder_ports = 3,
     .motor_turn = {VXSI_HAPLY_COUNTER, VXSI_HAPLY_COUNTER},
     .encoder_turn = {VXSI_HAPLY_COUNTER, VXSI_HAPLY_COUNTER},
     .offset = {12, 168},
     .counts = {4880, 4880}},
};

typedef struct haply_host {
    const vxsi_haply_setup *setup;
    vxsi_pantograph shape;
    double middle[2]; /* of what the arms reach, so that the pose begins near zero */
    uint8_t bytes[VXSI_HAPLY_FRAME];
    size_t count;
    int64_t began_ns;
    double jacobian[4];
    uint32_t has_place;
} haply_host;
_Static_assert(sizeof(haply_host) <= VXSI_LINK_MEMORY, "a driver's memory");

static haply_host *host_of(vxsi_link *link)
{
    return (haply_host *)(void *)link->driver_memory;
}

static size_t make(vxsi_link *link, const vxs_wrench *wrench, uint32_t arming, uint8_t *bytes)
{
    const haply_host *host = host_of(link);
    float torque[VXSI_HAPLY_PORTS] = {0};
    for (int motor = 0; motor < 2 && arming && host->has_place; motor++) {
        double t = host->jacobian[motor] * wrench->force[0] + host->jacobian[2 + motor] * wrench->force[2];
        torque[1 - motor] = (float)(t * link->config.torque_gain);
    }
    return vxsi_haply_encode_torque(host->setup, torque, bytes);
}

/* A pause is the only sign that a frame begins: what is left of one is dropped then. */
static uint32_t take(vxsi_link *link, const uint8_t *bytes, size_t size, vxs_device_state *state)
{
    haply_host *host = host_of(link);
    uint32_t found = 0;
    int64_t now = link->now(link->user);
    size_t whole = vxsi_haply_state_size(host->setup);
    if (host->count > 0 && now - host->began_ns > gap_ns) {
        host->count = 0;
        found |= VXSI_LINK_MALFORMED;
    }
    if (host->count == 0) host->began_ns = now;
    if (host->count + size > whole) { /* more than was asked for: the host is out of step */
        host->count = 0;
        return VXSI_LINK_MALFORMED;
    }
    memcpy(host->bytes + host->count, bytes, size);
    host->count += size;
    if (host->count < whole) return found;
    host->count = 0;
    float degrees[VXSI_HAPLY_PORTS];
    if (!vxsi_haply_decode_state(host->setup, host->bytes, whole, degrees)) return VXSI_LINK_MALFORMED;
    double angle[2] = {(double)degrees[1] * degree, (double)degrees[0] * degree}, place[2];
    int is_number = angle[0] - angle[0] == 0 && angle[1] - angle[1] == 0;
    if (is_number && !vxsi_pantograph_forward(&host->shape, angle, place, host->jacobian))
        return VXSI_LINK_MALFORMED;
    host->has_place = is_number;
    state->pose.position[0] = is_number ? place[0] - host->middle[0] : angle[0] + angle[1];
    state->pose.position[2] = is_number ? place[1] - host->middle[1] : 0;
    state->velocity_source = VXS_DEVICE_VELOCITY_NONE;
    state->state = link->start;
    return found | VXSI_LINK_NEWS;
}

static int is_answer(vxsi_link *link, const uint8_t *bytes, size_t size)
{
    vxs_device_state state = link->measured;
    return (take(link, bytes, size, &state) & VXSI_LINK_NEWS) != 0;
}

static vxs_result begin(vxsi_link *link)
{
    static const vxs_wrench zero = {{0, 0, 0}, {0, 0, 0}};
    vxs_device_caps *caps = &link->device.caps;
    const double *links = link->config.haply_links;
    haply_host *host = host_of(link);
    uint8_t bytes[VXSI_HAPLY_FRAME];
    host->setup = &setups[link->config.haply_setup - 2];
    host->shape = (vxsi_pantograph){links[0], links[1], links[2]};
    host->middle[0] = links[2] / 2;
    host->middle[1] = (links[0] + links[1]) * 2 / 3;
    snprintf(caps->name, sizeof caps->name, "Haply 2diy");
    caps->dof_sensed = caps->dof_actuated = 5; /* x and z */
    caps->peak_force = 4;
    caps->resolution = 50e-6;
    link->start = link->config.is_in_place ? VXS_DEVICE_READY : VXS_DEVICE_UNCALIBRATED;
    vxs_result result =
        link->wire.ops->send(link->wire.self, bytes, vxsi_haply_encode_setup(host->setup, bytes));
    if (result != VXS_OK) return result;
    result = VXS_TIMEOUT;
    for (int n = 0; n < ASKS && (result == VXS_TIMEOUT || result == VXS_BUSY); n++)
        result = vxsi_link_ask(link, bytes, make(link, &zero, 0, bytes), is_answer, 50000000);
    return result == VXS_BUSY ? VXS_TIMEOUT : result;
}

const vxsi_driver vxsi_haply_driver = {
    .name = "haply", .begin = begin, .take = take, .make = make, .answers = 1};
