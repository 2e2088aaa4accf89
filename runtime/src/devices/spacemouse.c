/* SPDX-License-Identifier: MIT
 *
 * Six-axis mice: their deflection is a speed, the pose is its integral. No force. Not verified on hardware.
 */
#include "link.h"
#include "spacemouse_protocol.h"

#include <math.h>
#include <stdio.h>

static const double longest = 0.05; /* [s] that a report is taken to hold */

typedef struct mouse_host {
    vxsi_spacemouse_axes axes;
    double position[3], orientation[4];
    int64_t last_ns;
} mouse_host;
_Static_assert(sizeof(mouse_host) <= VXSI_LINK_MEMORY, "a driver's memory");

static mouse_host *host_of(vxsi_link *link)
{
    return (mouse_host *)(void *)link->driver_memory;
}

/* q <- (rotation by turn) q */
static void rotate(double q[4], const double turn[3])
{
    double w = 1, x = turn[0] / 2, y = turn[1] / 2, z = turn[2] / 2;
    double p[4] = {w * q[0] - x * q[1] - y * q[2] - z * q[3], w * q[1] + x * q[0] + y * q[3] - z * q[2],
                   w * q[2] - x * q[3] + y * q[0] + z * q[1], w * q[3] + x * q[2] - y * q[1] + z * q[0]};
    double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
    for (int n = 0; n < 4; n++) q[n] = p[n] / length;
}

/* Up to this report what the last one said was so. */
static uint32_t take(vxsi_link *link, const uint8_t *bytes, size_t size, vxs_device_state *state)
{
    mouse_host *host = host_of(link);
    double rate[2][3], turn[3];
    vxsi_spacemouse_axes before = host->axes;
    int kind = vxsi_spacemouse_decode(bytes, size, &host->axes);
    if (kind == VXSI_SPACEMOUSE_NONE) return VXSI_LINK_MALFORMED;
    int64_t now = link->now(link->user);
    double passed = host->last_ns && now > host->last_ns ? (double)(now - host->last_ns) * 1e-9 : 0;
    if (passed > longest) passed = longest;
    host->last_ns = now;
    vxsi_spacemouse_rate(&before, rate[0], rate[1]);
    for (int n = 0; n < 3; n++) {
        host->position[n] += passed * link->config.linear_speed * rate[0][n];
        turn[n] = passed * link->config.angular_speed * rate[1][n];
        state->velocity[n] = link->config.linear_speed * rate[0][n];
        state->angular_velocity[n] = link->config.angular_speed * rate[1][n];
    }
    rotate(host->orientation, turn);
    memcpy(state->pose.position, host->position, sizeof host->position);
    memcpy(state->pose.orientation, host->orientation, sizeof host->orientation);
    state->velocity_source = VXS_DEVICE_VELOCITY_MEASURED;
    state->buttons = host->axes.buttons;
    state->state = VXS_DEVICE_READY;
    return VXSI_LINK_NEWS;
}

static size_t make(vxsi_link *link, const vxs_wrench *wrench, uint32_t arming, uint8_t *bytes)
{
    (void)link, (void)wrench, (void)arming, (void)bytes;
    return 0;
}

static vxs_result begin(vxsi_link *link)
{
    snprintf(link->device.caps.name, sizeof link->device.caps.name, "six-axis mouse");
    link->device.caps.dof_sensed = VXS_DEVICE_DOF_TRANSLATION | VXS_DEVICE_DOF_ROTATION;
    host_of(link)->orientation[0] = 1;
    return VXS_OK;
}

const vxsi_driver vxsi_spacemouse_driver = {
    .name = "spacemouse", .begin = begin, .take = take, .make = make, .may_be_silent = 1};
