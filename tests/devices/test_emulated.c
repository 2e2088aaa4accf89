/* SPDX-License-Identifier: MIT
 *
 * A closed loop at 1 kHz against each emulated device: mass, hand, kinematics, packets, link, servo, a ball
 * on a floor; or on assets that are given:
 *     test_emulated [CASE]                      touch, start_in_contact, mouse, haply_boards; all without one
 *     test_emulated touch MAP SHELL HEIGHT      HEIGHT: of the tip at the device's centre [m]; the ball of SHELL
 *                                               touches 4 mm below (tests/pipeline/device_on_cup.py)
 * What the motors do must balance the hand: a check on units and Jacobians from end to end.
 */
#include "check.h"
#include "floor_scene.h"

static const double way = 0.010; /* [m] that the hand goes down */

static void open_scene(floor_scene *s, int is_flat, char **assets)
{
    if (assets) {
        floor_scene_open(s, assets[0], assets[1], VXS_ASSET_MAP);
        s->config.contact.stiffness = 3e8;
        s->config.contact.law = VXS_CONTACT_PATCH;
        s->config.contact.field = VXS_CONTACT_DISTANCE;
        s->config.mount.position[1] = strtod(assets[2], NULL);
    } else {
        floor_scene_build(s);
    }
    if (is_flat) floor_scene_lay_flat(s);
    floor_scene_start(s);
}

/* Arms, comes down in 0.4 s, and rests for 1.5 s. kind NULL: the simulated device itself, without a wire. */
static void touch(const emulated_kind *kind, char **assets)
{
    static emulated e;
    static vxsi_link link;
    floor_scene s;
    int is_flat = kind == &emulated_haply, up = is_flat ? 2 : 1;
    open_scene(&s, is_flat, assets);
    emulated_init(&e, kind ? kind : &emulated_falcon);
    vxs_device *device = kind ? &link.device : e.tip;
    if (kind) CHECK_INT(emulated_link(&e, &link), VXS_OK);
    for (int tick = 0; tick < 20 && kind; tick++) emulated_run(&e, &link);
    CHECK_INT(device->caps.has_motors != 0, kind != NULL);
    CHECK_INT(vxs_servo_may_drive(s.servo, &device->caps), VXS_OK);
    CHECK_INT(vxs_device_arm(device), VXS_OK);

    vxs_device_command command;
    vxs_device_state state;
    vxs_device_report report;
    vxs_servo_trace row;
    memset(&command, 0, sizeof command);
    double most = 0, depth = 0, lowest = 0, truth[3], velocity[3], swing = 0, rest = 0;
    uint32_t seen = 0, contact = 0;
    for (int tick = 0; tick < 2500; tick++) {
        e.hand[up] = tick < 600 ? 0 : tick < 1000 ? -way * (tick - 600) / 400 : -way;
        if (kind) {
            emulated_run(&e, &link);
            vxs_device_exchange(device, &command, &state, &report);
        } else {
            vxs_simulated_hand(device, e.hand, NULL);
            vxs_device_exchange(device, &command, &state, &report);
            memcpy(e.force, report.rendered.force, sizeof e.force);
        }
        seen |= vxs_servo_tick(s.servo, &state, &command, &row);
        contact += row.points > 0;
        depth = fmax(depth, row.depth);
        most = fmax(most, emulated_force(&e));
        vxs_simulated_truth(e.tip, truth, velocity);
        lowest = fmin(lowest, truth[up]);
        if (tick == 2000) rest = truth[up];
        if (tick > 2000) swing = fmax(swing, fabs(truth[up] - rest));
        if (tick < 100) CHECK(emulated_force(&e) == 0);
        CHECK_INT(state.state, VXS_DEVICE_ARMED);
    }
    double hand = 500 * (truth[up] - e.hand[up]), motor = e.force[up], apart = 0;
    for (int n = 0; n < 3; n++) apart = fmax(apart, fabs(state.pose.position[n] - truth[n]));
    vxs_hardware_counts counts = {2500, 2500, 0, 0};
    if (kind) vxs_hardware_get(device, &counts);
    printf("%-7s motors %.3f N, hand %.3f N, %.3f N at most; tip %.2f mm past touch, body %.3f mm deep, "
           "still to "
           "%.1f um; pose off by %.1f um; %llu sent, %llu measured, %llu late; %u ticks in contact\n",
           kind ? kind->name : "sim", motor, hand, most, 1e3 * (-lowest - floor_clearance), 1e3 * depth,
           1e6 * swing, 1e6 * apart, (unsigned long long)counts.sent, (unsigned long long)counts.measured,
           (unsigned long long)counts.late, contact);
    CHECK(contact > 1000);
    CHECK(motor > 0.5);
    CHECK_NEAR(motor, hand, 0.03);
    CHECK(most < 8);
    CHECK(apart < 60e-6);
    CHECK(swing < 150e-6); /* four steps of the encoder */
    CHECK(!(seen & (VXS_SERVO_FAULT | VXS_SERVO_TELEPORT | VXS_SERVO_DEVICE_LOST)));
    CHECK(counts.sent > 2450 && counts.malformed == 0 && counts.late == 0);
    vxs_device_close(device);
    if (kind) {
        CHECK(e.is_closed);
        emulated_run(&e, NULL);
        CHECK(emulated_force(&e) == 0);
    }
    floor_scene_close(&s);
}

static void touch_all(char **assets)
{
    touch(NULL, assets);
    touch(&emulated_hvlink, assets);
    touch(&emulated_haply, assets);
    touch(&emulated_falcon, assets);
}

/* Armed while the ball is 2 mm in the floor: nothing, until it was free once. */
static void start_in_contact_of(const emulated_kind *kind)
{
    static emulated e;
    static vxsi_link link;
    floor_scene s;
    open_scene(&s, kind == &emulated_haply, NULL);
    emulated_init(&e, kind);
    CHECK_INT(emulated_link(&e, &link), VXS_OK);
    vxs_device_command command;
    vxs_device_state state;
    memset(&command, 0, sizeof command);
    int up = kind == &emulated_haply ? 2 : 1;
    uint32_t flags = 0;
    for (int tick = 0; tick < 2600; tick++) {
        e.hand[up] = tick < 1200 ? -0.006 : tick < 1700 ? 0.002 : -0.010;
        emulated_run(&e, &link);
        if (tick == 400) CHECK_INT(vxs_device_arm(&link.device), VXS_OK);
        vxs_device_exchange(&link.device, &command, &state, NULL);
        flags = vxs_servo_tick(s.servo, &state, &command, NULL);
        if (tick > 410 && tick < 1200) CHECK(flags & VXS_SERVO_START_IN_CONTACT);
        if (tick < 1700) CHECK(emulated_force(&e) < 1e-9);
    }
    CHECK(!(flags & VXS_SERVO_START_IN_CONTACT));
    CHECK(e.force[up] > 0.5);
    vxs_device_close(&link.device);
    floor_scene_close(&s);
}

static void start_in_contact(void)
{
    for (int n = 0; n < 3; n++) start_in_contact_of(emulated_kinds[n]);
}

/* A six-axis mouse: half a second at half speed. */
static void mouse(void)
{
    static emulated e;
    static vxsi_link link;
    vxs_device_state state;
    emulated_init(&e, &emulated_spacemouse);
    CHECK_INT(emulated_link(&e, &link), VXS_OK);
    for (int tick = 0; tick < 1000; tick++) {
        e.axes.axis[0] = tick < 496 ? 180 : 0;
        e.axes.axis[4] = tick < 496 ? 350 : 0;
        e.is_silent = tick > 560; /* zeros three times, then nothing */
        emulated_run(&e, &link);
        vxs_device_exchange(&link.device, NULL, &state, NULL);
    }
    CHECK_INT(state.state, VXS_DEVICE_READY);
    CHECK_NEAR(state.pose.position[0], 0.1 * 0.5 * 0.5, 1e-3);
    CHECK_NEAR(state.pose.orientation[3], sin(0.25), 3e-3); /* about the axis towards the user */
    CHECK(state.pose.orientation[1] == 0 && state.pose.orientation[2] == 0);
    printf("spacemouse: %.4f m, turned by %.3f rad\n", state.pose.position[0],
           2 * acos(state.pose.orientation[0]));
    CHECK(state.velocity[0] == 0 && state.link_age > 0.4);
    vxs_device_close(&link.device);
}

/* It drives the ball into the floor: the servo feels it and commands, nothing is rendered, and the device
 * says that it has no motor for that. */
static void mouse_in_scene(char **assets)
{
    static emulated e;
    static vxsi_link link;
    floor_scene s;
    vxs_device_command command;
    vxs_device_state state;
    vxs_device_report report;
    vxs_servo_trace row;
    uint32_t seen = 0;
    double most = 0, depth = 0;
    open_scene(&s, 0, assets);
    emulated_init(&e, &emulated_spacemouse);
    CHECK_INT(emulated_link(&e, &link), VXS_OK);
    CHECK(!link.device.caps.has_motors);
    memset(&command, 0, sizeof command);
    CHECK_INT(vxs_device_arm(&link.device), VXS_OK);
    for (int tick = 0; tick < 2000; tick++) {
        e.axes.axis[2] = tick > 600 && tick < 1000 ? 90 : 0; /* down */
        e.is_silent = tick > 1060;
        emulated_run(&e, &link);
        vxs_device_exchange(&link.device, &command, &state, &report);
        vxs_servo_tick(s.servo, &state, &command, &row);
        seen |= report.flags;
        most = fmax(most, row.command.force[1]);
        depth = fmax(depth, row.depth);
        for (int n = 0; n < 3; n++) CHECK(report.rendered.force[n] == 0);
    }
    printf("spacemouse driven to %.2f mm: %.3f N commanded at most and none rendered, body %.3f mm deep\n",
           1e3 * state.pose.position[1], most, 1e3 * depth);
    CHECK(state.pose.position[1] < -floor_clearance && most > 0.5);
    CHECK(seen & VXS_DEVICE_INCOMPLETE);
    vxs_device_close(&link.device);
    floor_scene_close(&s);
}

/* Which board and which arms are the user's to say: the board is told of its motors and encoders, place and
 * force come out right. */
static void haply_boards(void)
{
    static const struct {
        uint32_t setup;
        double links[3];
        float offset[2], counts;
        uint8_t turn;
    } boards[] = {{2, {0.05, 0.07, 0.02}, {-61, 241}, 10752, VXSI_HAPLY_CLOCKWISE},
                  {3, {0.05, 0.07, 0.02}, {12, 168}, 4880, VXSI_HAPLY_COUNTER},
                  {3, {0.065, 0.09, 0.038}, {12, 168}, 4880, VXSI_HAPLY_COUNTER}};
    static emulated e;
    static vxsi_link link;
    for (size_t k = 0; k < sizeof boards / sizeof *boards; k++) {
        vxs_hardware_config config;
        vxs_device_state state;
        double truth[3], velocity[3];
        vxs_hardware_config_default(&config);
        config.is_in_place = 1;
        config.haply_setup = boards[k].setup;
        memcpy(config.haply_links, boards[k].links, sizeof config.haply_links);
        emulated_init(&e, &emulated_haply);
        memcpy(&e.pantograph, boards[k].links, sizeof e.pantograph);
        CHECK_INT(emulated_link_as(&e, &link, &config), VXS_OK);
        CHECK(e.board.motor_ports == 3 && e.board.encoder_ports == 3 && e.board.motor_turn[1] == 1);
        for (int n = 0; n < 2; n++)
            CHECK(e.board.offset[n] == boards[k].offset[n] && e.board.counts[n] == boards[k].counts);
        CHECK_INT(e.board.motor_turn[0], boards[k].turn);
        CHECK_INT(e.board.encoder_turn[0], boards[k].turn);
        CHECK_INT(vxs_device_arm(&link.device), VXS_OK);
        for (int tick = 0; tick < 1500; tick++) {
            e.hand[0] = 1e-5 * tick;
            emulated_run(&e, &link);
            vxs_device_exchange(&link.device, NULL, &state, NULL);
            vxs_device_command command = {.wrench = {{0.5, 0, -0.75}, {0, 0, 0}},
                                          .hold_ns = state.time_ns + 2000000,
                                          .expires_ns = state.time_ns + 12000000};
            vxs_device_exchange(&link.device, &command, &state, NULL);
        }
        vxs_simulated_truth(e.tip, truth, velocity);
        printf("haply board %u: at (%.2f, %.2f) mm, feels (%.3f, %.3f) N\n", (unsigned)boards[k].setup,
               1e3 * state.pose.position[0], 1e3 * state.pose.position[2], e.force[0], e.force[2]);
        CHECK(truth[0] > 0.01);
        for (int n = 0; n < 3; n++) CHECK_NEAR(state.pose.position[n], truth[n], 60e-6);
        CHECK_NEAR(e.force[0], 0.5, 2e-3);
        CHECK_NEAR(e.force[2], -0.75, 2e-3);
        vxs_device_close(&link.device);
    }
}

int main(int count, char **arguments)
{
    const char *only = count > 1 ? arguments[1] : "";
    char **assets = count > 4 ? arguments + 2 : NULL;
    if (!*only || strcmp(only, "touch") == 0) {
        touch_all(assets);
        mouse_in_scene(assets);
    }
    if (!*only || strcmp(only, "start_in_contact") == 0) start_in_contact();
    if (!*only || strcmp(only, "mouse") == 0) mouse();
    if (!*only || strcmp(only, "haply_boards") == 0) haply_boards();
    return 0;
}
