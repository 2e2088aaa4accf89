/* SPDX-License-Identifier: MIT
 *
 * What a hand can rely on, clause by clause (servo.h).
 */
#include "servo_bench.h"

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void check_off_and_ramp(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    bench_open(&b);
    uint32_t flags = bench_tick(&b, 0.012, &row);
    CHECK_INT(flags, VXS_SERVO_OFF | VXS_CONTACT_OUT_OF_MAP); /* the map's box ends at y = 0 */
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    flags = bench_tick(&b, 0.012, &row);
    CHECK(flags & VXS_SERVO_RAMPING && !(flags & VXS_SERVO_OFF));
    double last = 0;
    for (int k = 1; k < 500; k++) {
        flags = bench_tick(&b, 0.009, &row);
        CHECK(row.gain > last && row.gain <= 1);
        last = row.gain;
        CHECK_NEAR(row.command.force[1], row.gain * row.output.force[1], 1e-12);
        CHECK_NEAR(row.output.force[1], row.collision.force[1], 0);
    }
    CHECK_NEAR(row.gain, 1, 1e-9);
    flags = bench_tick(&b, 0.009, &row);
    CHECK(row.gain == 1);
    CHECK(!(flags & VXS_SERVO_RAMPING) && row.points > 0 && row.command.force[1] > 0.1);
    CHECK_INT(row.tick, 501);
    /* The hand is pushed up off the target by the floor. */
    CHECK(row.pose.position[1] > 0.009);
    CHECK_INT(vxs_device_disarm(b.device), VXS_OK);
    flags = bench_tick(&b, 0.009, &row);
    CHECK(flags & VXS_SERVO_OFF && length(row.command.force) == 0);
    /* Armed again: the ramp and the coupling start from nothing. */
    for (int k = 0; k < 300; k++) bench_tick(&b, 0.013, &row);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    flags = bench_tick(&b, 0.013, &row);
    CHECK(flags & VXS_SERVO_RAMPING && row.gain > 0 && row.gain < 0.003);
    bench_close(&b);
}

/* A filter that was cut off in contact must not let its memory out at the next arming. */
static void check_rearm(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    bench_effect(&b, VXS_EFFECT_START_INSIDE);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    for (int k = 0; k < 600; k++) bench_tick(&b, k < 10 ? 0.012 : 0.0088, &row);
    CHECK(length(row.output.force) > 0.1);
    vxs_device_state off = b.state, free_again = b.state;
    off.state = VXS_DEVICE_READY;
    free_again.pose.position[1] = 0.03;
    for (int k = 1; k < 3; k++) {
        vxs_device_state *next = k == 1 ? &off : &free_again;
        next->sequence += (uint64_t)k;
        next->time_ns += 1000000 * k;
        vxs_servo_tick(b.servo, next, &b.command, &row);
        CHECK(length(row.command.force) == 0 && length(row.output.force) == 0);
    }
    bench_close(&b);
}

static void check_start_in_contact(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.device_config.start.position[1] = 0.0092;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    for (int k = 0; k < 100; k++) {
        uint32_t flags = bench_tick(&b, 0.0092, &row);
        CHECK(flags & VXS_SERVO_START_IN_CONTACT);
        CHECK(row.points > 0 && length(row.collision.force) > 0 && length(row.command.force) == 0);
    }
    for (int k = 0; k < 400; k++) bench_tick(&b, 0.013, &row);
    CHECK(!(row.flags & VXS_SERVO_START_IN_CONTACT) && row.points == 0);
    for (int k = 0; k < 800; k++) bench_tick(&b, 0.0088, &row);
    CHECK(row.points > 0 && length(row.command.force) > 0.1);
    bench_close(&b);
}

static void check_fault(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    for (int k = 0; k < 2000; k++) bench_tick(&b, k < 10 ? 0.012 : 0.009, &row);
    CHECK(length(row.command.force) > 0.1);
    vxs_simulated_break(b.device, VXS_DEVICE_FAULT_SOFTWARE);
    uint32_t flags = bench_tick(&b, 0.009, &row);
    CHECK(flags & VXS_SERVO_FAULT && length(row.command.force) == 0);
    for (int k = 0; k < 1000; k++) { /* latched, although the device is fine again and free */
        flags = bench_tick(&b, 0.013, &row);
        CHECK(flags & VXS_SERVO_FAULT && length(b.command.wrench.force) == 0 &&
              length(b.command.wrench.torque) == 0);
    }
    vxs_servo_clear(b.servo);
    flags = bench_tick(&b, 0.013, &row);
    CHECK(!(flags & VXS_SERVO_FAULT) && flags & VXS_SERVO_RAMPING && row.gain < 0.01);

    /* Each number of a state that is not finite. */
    for (int n = 0; n < 16; n++) {
        vxs_device_state state = b.state;
        const double bad = n % 2 ? NAN : INFINITY;
        if (n < 3)
            state.pose.position[n] = bad;
        else if (n < 7)
            state.pose.orientation[n - 3] = bad;
        else if (n < 10)
            state.velocity[n - 7] = bad;
        else if (n < 13)
            state.angular_velocity[n - 10] = bad;
        else if (n == 13)
            memset(state.pose.orientation, 0, sizeof state.pose.orientation);
        else if (n == 14)
            state.time_ns = INT64_MAX;
        else
            state.time_ns = INT64_MIN;
        vxs_device_command command;
        memset(&command, 0xFF, sizeof command);
        CHECK(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_FAULT);
        CHECK(length(command.wrench.force) == 0 && length(command.wrench.torque) == 0);
        vxs_servo_clear(b.servo);
    }

    /* Unplugged: zero at once. Not latched: READY again needs an arm(), which ramps. */
    vxs_simulated_break(b.device, VXS_DEVICE_FAULT_USB);
    flags = bench_tick(&b, 0.009, &row);
    CHECK(flags & VXS_SERVO_DEVICE_LOST && flags & VXS_SERVO_OFF && length(row.command.force) == 0);
    bench_close(&b);
}

/* A device that says itself that it is at fault: off while it does, and ramped up again after. */
static void check_device_fault(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    bench_open(&b);
    bench_start(&b);
    b.state.pose.position[1] = 0.012;
    for (int k = 0; k < 600; k++) bench_follow(&b, &row);
    b.state.pose.position[1] = 0.009;
    for (int k = 0; k < 10; k++) bench_follow(&b, &row);
    CHECK(length(row.command.force) > 0.1);
    static const uint32_t states[] = {VXS_DEVICE_FAULT, VXS_DEVICE_GONE};
    for (int n = 0; n < 2; n++) {
        b.state.state = states[n];
        bench_follow(&b, &row);
        CHECK(row.flags & VXS_SERVO_DEVICE_LOST && row.flags & VXS_SERVO_OFF &&
              length(row.command.force) == 0);
    }
    b.state.state = VXS_DEVICE_ARMED;
    b.state.pose.position[1] = 0.012;
    bench_follow(&b, &row);
    CHECK(!(row.flags & VXS_SERVO_DEVICE_LOST) && row.flags & VXS_SERVO_RAMPING && row.gain < 0.01);
    bench_close(&b);
}

/* A budget of points has levels of detail in the servo's own memory. */
static void check_budget(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    const size_t without = vxs_servo_memory(&b.servo_config);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    b.servo_config.contact.most_points = 128;
    CHECK(vxs_servo_memory(&b.servo_config) > without);
    bench_open(&b);
    bench_start(&b);
    b.state.pose.position[1] = 0.012;
    for (int k = 0; k < 600; k++) bench_follow(&b, &row);
    b.state.pose.position[1] = 0.0085;
    for (int k = 0; k < 10; k++) bench_follow(&b, &row);
    CHECK(row.level > 0 && row.points > 0 && row.points < 128 && row.command.force[1] > 0.1);
    bench_close(&b);

    /* Points without areas have no levels, and no weights. */
    bench_prepare(&b);
    b.shell.area = NULL;
    vxs_servo *servo = NULL;
    uint8_t *memory = aligned_alloc(64, 1 << 20);
    CHECK_INT(vxs_servo_init(memory, 1 << 20, &b.servo_config, &servo), VXS_NO_AREA);
    CHECK(!servo);
    free(memory);
    b.shell = open_pointshell(&b.shell_bytes);
    bench_open(&b);
    bench_close(&b);
}

/* Far beyond the limits: the force keeps its direction. */
static void check_clamp(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    b.servo_config.max_force = 1;
    b.servo_config.max_torque = 0.001;
    bench_effect(&b, VXS_EFFECT_START_INSIDE);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    b.servo_config.contact.stiffness = 1e11;
    b.servo_config.grip.position[0] = 0.003; /* the ball beside the tip: torque */
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    int saturated = 0;
    for (int k = 0; k < 3000; k++) {
        uint32_t flags = bench_tick(&b, k < 10 ? 0.012 : 0.0092, &row);
        CHECK(length(row.command.force) <= 1 + 1e-12 && length(row.command.torque) <= 0.001 + 1e-12);
        if (!(flags & VXS_SERVO_SATURATED)) continue;
        saturated++;
        double size = length(row.output.force), scale = length(row.command.force);
        for (int axis = 0; axis < 3; axis++)
            CHECK_NEAR(row.command.force[axis] / scale, row.output.force[axis] / size, 1e-9);
    }
    CHECK(saturated > 100);
    bench_close(&b);
}

/* Torque is about the tip, wherever the part's own origin is. */
static void check_grip(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    bench_effect(&b, VXS_EFFECT_START_INSIDE);
    b.servo_config.coupling.kind = VXS_COUPLING_NONE;
    b.servo_config.grip.position[0] = 0.003;
    b.servo_config.grip.orientation[1] = 0.5;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    for (int k = 0; k < 500; k++) bench_tick(&b, k < 10 ? 0.012 : 0.009, &row);
    CHECK(row.collision.force[1] > 0.05);
    /* r x F with r = 3 mm in x to the ball's axis */
    CHECK_NEAR(row.collision.torque[2] / row.collision.force[1], 0.003, 0.0005);
    bench_close(&b);
}

/* Ticks that do not come: the device lets go within 10 ms, the ramp goes on from what was felt. */
static void check_missed(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    for (int k = 0; k < 2000; k++) bench_tick(&b, k < 10 ? 0.012 : 0.009, &row);
    double before = length(row.command.force);
    CHECK(before > 0.1 && row.gain == 1 && !(row.flags & VXS_SERVO_MISSED));
    vxs_device_report report;
    vxs_device_exchange(b.device, &b.command, &b.state, &report);
    for (int k = 0; k < 7; k++) vxs_device_exchange(b.device, NULL, &b.state, &report);
    CHECK(length(report.rendered.force) < before && length(report.rendered.force) > 0);
    uint32_t flags = vxs_servo_tick(b.servo, &b.state, &b.command, &row);
    CHECK(flags & VXS_SERVO_MISSED && flags & VXS_SERVO_RAMPING);
    CHECK(row.gain > 0.2 && row.gain < 0.7);
    for (int k = 0; k < 15; k++) vxs_device_exchange(b.device, k ? NULL : &b.command, &b.state, &report);
    CHECK(length(report.rendered.force) == 0);
    flags = vxs_servo_tick(b.servo, &b.state, &b.command, &row);
    CHECK(row.gain <= 0.002 + 1e-12); /* from zero again */

    /* The clock goes on, the measurement does not: stale, then lost. */
    for (int k = 0; k < 2000; k++) bench_tick(&b, 0.009, &row);
    int lost = 0;
    for (int k = 1; k <= 20; k++) {
        b.state.time_ns += 1000000;
        flags = vxs_servo_tick(b.servo, &b.state, &b.command, &row);
        CHECK(flags & VXS_SERVO_DEVICE_STALE);
        if (flags & VXS_SERVO_DEVICE_LOST) lost++;
        CHECK_INT((flags & VXS_SERVO_DEVICE_LOST) != 0, k > 12);
        if (k > 12) CHECK(length(row.command.force) == 0);
    }
    CHECK_INT(lost, 8);
    bench_close(&b);
}

static void check_mount_and_scale(void)
{
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    /* Device y is scene z turned: the scene's floor pushes along the device's -z. */
    vxs_pose mount = {{0, 0, 0}, {1, 1, 0, 0}}; /* y -> z, z -> -y */
    b.servo_config.mount = mount;
    b.servo_config.scale = 0.5;
    bench_effect(&b, VXS_EFFECT_START_INSIDE);
    b.device_config.start.position[1] = 0;
    b.device_config.start.position[2] = -0.024;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    double target[3] = {0, 0, -0.024};
    for (int k = 0; k < 2000; k++) {
        if (k > 10) target[2] = -0.0172;
        vxs_simulated_hand(b.device, target, NULL);
        vxs_device_exchange(b.device, &b.command, &b.state, NULL);
        vxs_servo_tick(b.servo, &b.state, &b.command, &row);
    }
    CHECK(row.collision.force[1] > 0.05);
    CHECK_NEAR(row.command.force[2], -row.output.force[1], 1e-12);
    CHECK_NEAR(row.command.force[1], row.output.force[2], 1e-12);
    bench_close(&b);
}

static void check_config(void)
{
    servo_bench b;
    vxs_servo *servo;
    bench_prepare(&b);
    bench_open(&b);
    size_t size = vxs_servo_memory(&b.servo_config);
    CHECK_INT(vxs_servo_init(b.servo_memory, size - 1, &b.servo_config, &servo), VXS_BUFFER);
    vxs_servo_config config = b.servo_config;
    config.shell = NULL;
    CHECK_INT(vxs_servo_init(b.servo_memory, size, &config, &servo), VXS_PARAM);
    CHECK_INT(vxs_servo_memory(&config), 0);
    config = b.servo_config;
    config.max_force = INFINITY;
    CHECK_INT(vxs_servo_config_check(&config), VXS_PARAM);
    config = b.servo_config;
    config.coupling.omega0 = 1e9;
    CHECK_INT(vxs_servo_config_check(&config), VXS_FREQUENCY);
    config = b.servo_config;
    config.contact.struct_size = 0;
    CHECK_INT(vxs_servo_config_check(&config), VXS_CONFIG);
    bench_close(&b);
}

int main(void)
{
    check_off_and_ramp();
    check_rearm();
    check_start_in_contact();
    check_fault();
    check_device_fault();
    check_budget();
    check_clamp();
    check_grip();
    check_missed();
    check_mount_and_scale();
    check_config();
    return 0;
}
