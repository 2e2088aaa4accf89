/* SPDX-License-Identifier: MIT
 *
 * The gate that every device's driver stands behind, with a driver that says what it is told: numbers that are none, the
 * moment of arming, races at it (made with the clock), an I/O thread that cannot be had.
 */
#include "check.h"
#include "devices/link.h"

#include <errno.h>

enum { SEND, RECEIVE, CALLS };
static vxsi_link host;
static struct {
    int count[CALLS], lost_from; /* call of that number to receive, and all after, find nobody; 0: none */
    int64_t clock_ns;
    int (*at_clock)(void); /* once, as the link next asks for the time */
} wire;

static uint32_t exchange(vxs_device_state *state)
{
    vxs_device_exchange(&host.device, NULL, state, NULL);
    return state->state;
}

static vxs_device_state told;
static vxs_wrench made;
static vxs_result begin_told(vxsi_link *on)
{
    on->device.caps.dof_sensed = on->device.caps.dof_actuated = 63;
    on->device.caps.peak_force = 2;
    on->device.caps.peak_torque = 0.5;
    return VXS_OK;
}
static uint32_t take_told(vxsi_link *on, const uint8_t *bytes, size_t size, vxs_device_state *state)
{
    (void)on, (void)bytes, (void)size;
    *state = told;
    return VXSI_LINK_NEWS;
}
static size_t make_told(vxsi_link *on, const vxs_wrench *wrench, uint32_t arming, uint8_t *bytes)
{
    (void)on, (void)arming;
    made = *wrench;
    bytes[0] = 1;
    return 1;
}
static const vxsi_driver teller = {
    .name = "teller", .begin = begin_told, .take = take_told, .make = make_told};

static vxs_result take_byte(void *self, const uint8_t *bytes, size_t size)
{
    (void)self, (void)bytes, (void)size;
    wire.count[SEND]++;
    return VXS_OK;
}
static int32_t give_byte(void *self, uint8_t *bytes, size_t most, int64_t wait_ns)
{
    (void)self, (void)wait_ns;
    bytes[0] = 1;
    int n = ++wire.count[RECEIVE];
    return wire.lost_from && n >= wire.lost_from ? VXS_LOST : most > 0 && n % 2;
}
static void close_told(void *self)
{
    *(int *)self += 1;
}
static const vxsi_wire_ops telling = {
    .name = "teller", .send = take_byte, .receive = give_byte, .close = close_told};
static int closings;

static int64_t clock_of_ours(void *user)
{
    int (*at_clock)(void) = wire.at_clock;
    (void)user;
    wire.at_clock = NULL;
    if (at_clock) at_clock();
    return wire.clock_ns;
}

static void open_teller(void)
{
    vxs_hardware_config config;
    vxsi_wire ours = {&telling, &closings};
    vxs_hardware_config_default(&config);
    memset(&wire, 0, sizeof wire);
    memset(&host, 0, sizeof host);
    memset(&told, 0, sizeof told);
    closings = 0;
    wire.clock_ns = 1000000000;
    told.state = VXS_DEVICE_READY;
    told.pose = vxs_pose_identity();
    host.now = clock_of_ours;
    CHECK_INT(vxsi_link_open(&host, &teller, &config, &ours), VXS_OK);
}

static int lose_it(void)
{
    wire.lost_from = wire.count[RECEIVE] + 1;
    return vxsi_link_step(&host, 0);
}
static int fail_it(void)
{
    vxsi_link_fail(&host, VXS_DEVICE_FAULT_SOFTWARE);
    return 0;
}

/* Each number that a device says must be one: also those that no driver of ours can get wrong. */
static void check_numbers(void)
{
    double *const places[] = {&told.pose.position[2],    &told.pose.orientation[0], &told.pose.orientation[3],
                              &told.velocity[0],         &told.velocity[2],         &told.angular_velocity[0],
                              &told.angular_velocity[1], &told.angular_velocity[2]};
    const double bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t n = 0; n < sizeof places / sizeof *places; n++) {
        for (int i = 0; i < 3; i++) {
            vxs_device_state state;
            open_teller();
            told.velocity_source = VXS_DEVICE_VELOCITY_MEASURED;
            CHECK(vxsi_link_step(&host, 0) && vxs_device_arm(&host.device) == VXS_OK);
            *places[n] = bad[i];
            wire.clock_ns += 1000000;
            CHECK(vxsi_link_step(&host, 0));
            CHECK_INT(exchange(&state), VXS_DEVICE_FAULT);
            CHECK_INT(state.fault, VXS_DEVICE_FAULT_SOFTWARE);
            CHECK(isfinite(state.velocity[0] + state.pose.orientation[0] + state.angular_velocity[1]));
            for (int v = 0; v < 3; v++) CHECK(made.force[v] == 0 && made.torque[v] == 0);
            vxs_device_close(&host.device);
        }
    }
}

static void check_gate(void)
{
    vxs_device_state state;
    vxs_device_report report;
    vxs_device_command command = {
        .wrench = {{1, 0, 0}, {0, 0, 5}}, .hold_ns = INT64_MAX, .expires_ns = INT64_MAX};
    open_teller();
    CHECK(vxsi_link_step(&host, 0));
    CHECK_INT(vxs_device_arm(&host.device), VXS_OK);
    CHECK_INT(vxs_device_arm(&host.device), VXS_OK); /* it is */
    /* At the moment of arming the ramp is zero. */
    vxs_device_exchange(&host.device, &command, &state, &report);
    host.last_send_ns = 0;
    CHECK(vxsi_link_step(&host, 0));
    CHECK(made.force[0] == 0 && made.torque[2] == 0);
    /* Then torque beyond the peak is cut, force below it is not. */
    for (int n = 0; n < 600; n++) {
        wire.clock_ns += 1000000;
        CHECK(vxsi_link_step(&host, 0));
    }
    CHECK(made.force[0] == 1 && fabs(made.torque[2] - 0.5) < 1e-12);
    vxs_device_exchange(&host.device, NULL, &state, &report);
    CHECK(report.flags & VXS_DEVICE_CLAMPED);
    vxs_device_close(&host.device);
    CHECK_INT(closings, 1);
}

/* As the I/O thread would: between arm()'s look and its deed. */
static void check_races(void)
{
    vxs_device_state state;
    open_teller();
    CHECK(vxsi_link_step(&host, 0));
    wire.at_clock = fail_it;
    CHECK_INT(vxs_device_arm(&host.device), VXS_STATE);
    CHECK_INT(exchange(&state), VXS_DEVICE_FAULT);
    CHECK_INT(vxs_device_disarm(&host.device), VXS_OK);
    CHECK_INT(vxs_device_disarm(&host.device), VXS_OK);
    wire.at_clock = lose_it;
    CHECK_INT(vxs_device_arm(&host.device), VXS_LOST);
    CHECK_INT(exchange(&state), VXS_DEVICE_GONE);
    vxs_device_close(&host.device);

    open_teller();
    told.state = VXS_DEVICE_UNCALIBRATED;
    CHECK(vxsi_link_step(&host, 0));
    CHECK_INT(vxs_device_arm(&host.device), VXS_STATE);
    CHECK_INT(vxs_device_disarm(&host.device), VXS_STATE);
    vxs_device_close(&host.device);
}

/* The I/O thread: one that cannot be had, and one whose clock stands before the last packet's. */
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *argument);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *argument);
static int thread_error;

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *argument)
{
    return thread_error ? thread_error : __real_pthread_create(thread, how, run, argument);
}

static int64_t clock_that_stands(void *user)
{
    (void)user;
    return -5000000000;
}

static void check_thread(void)
{
    vxs_device_state state;
    open_teller();
    thread_error = EAGAIN;
    CHECK_INT(vxsi_link_run(&host), VXS_NO_THREAD);
    CHECK_INT(closings, 1);
    thread_error = 0;

    open_teller();
    host.now = clock_that_stands;
    CHECK_INT(vxsi_link_run(&host), VXS_OK);
    do {
        vxs_device_exchange(&host.device, NULL, &state, NULL);
    } while (state.state == VXS_DEVICE_READY);
    CHECK(state.state == VXS_DEVICE_FAULT && state.fault == VXS_DEVICE_FAULT_SOFTWARE);
    vxs_device_close(&host.device);
    CHECK_INT(closings, 1);
}

int main(void)
{
    check_numbers();
    check_gate();
    check_races();
    check_thread();
    return 0;
}
