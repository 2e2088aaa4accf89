/* SPDX-License-Identifier: MIT
 *
 * A closed loop at 1 kHz against each emulated device: mass, hand, kinematics, packets, link, servo, a ball
 * on a floor; or on the assets that are given: test_emulated MAP SHELL HEIGHT (of the tip at the device's
 * centre, over the origin). What the motors do must balance the hand: a check on units and Jacobians from end
 * to end.
 */
#include "asset_builder.h"
#include "check.h"
#include "emulated.h"
#include "voxshell/servo.h"

typedef struct scene {
    built_asset map_bytes, shell_bytes;
    vxs_asset map_file, shell_file;
    vxs_voxmap map;
    vxs_pointshell shell;
    vxs_contact_static statics;
    vxs_servo_config config;
    void *memory;
    vxs_servo *servo;
} scene;

/* The floor is at y = 0, the tip begins over it; a device that has x and z only has the floor's up along its
 * z. */
static void open_scene(scene *s, const emulated_kind *kind, int count, char **arguments)
{
    memset(s, 0, sizeof *s);
    if (count >= 4) {
        CHECK_INT(vxs_asset_open(arguments[1], NULL, &s->map_file, NULL), VXS_OK);
        CHECK_INT(vxs_asset_open(arguments[2], NULL, &s->shell_file, NULL), VXS_OK);
        CHECK_INT(vxs_voxmap_open(&s->map_file, &s->map), VXS_OK);
        CHECK_INT(vxs_pointshell_open(&s->shell_file, &s->shell), VXS_OK);
    } else {
        built_floor floor_shape = {-1, 60, 20};
        s->map_bytes = build_floor_map(0.001, &floor_shape, BUILT_PLAIN);
        s->shell_bytes = build_ball_shell(0.001, 0.01, 1000);
        s->map = open_voxmap(&s->map_bytes);
        s->shell = open_pointshell(&s->shell_bytes);
    }
    s->statics = (vxs_contact_static){&s->map, NULL};
    vxs_servo_config_default(&s->config);
    s->config.statics = &s->statics;
    s->config.static_count = 1;
    s->config.shell = &s->shell;
    s->config.max_force = 4;
    s->config.contact.weighting = VXS_CONTACT_AREA;
    s->config.contact.stiffness = 1e9;
    s->config.coupling.kind = VXS_COUPLING_QUASI_STATIC;
    s->config.coupling.stiffness = 800;
    s->config.mount.position[1] = count >= 4 ? strtod(arguments[3], NULL) : 0.014;
    if (kind == &emulated_haply) {
        s->config.mount.orientation[0] = sqrt(0.5);
        s->config.mount.orientation[1] = -sqrt(0.5);
    }
    size_t size = (vxs_servo_memory(&s->config) + 63) / 64 * 64;
    s->memory = aligned_alloc(64, size);
    CHECK_INT(vxs_servo_init(s->memory, size, &s->config, &s->servo), VXS_OK);
}

static void close_scene(scene *s)
{
    free(s->memory);
    if (s->map_bytes.data) {
        built_free(&s->map_bytes);
        built_free(&s->shell_bytes);
    } else {
        vxs_asset_close(&s->map_file);
        vxs_asset_close(&s->shell_file);
    }
}

static void touch(const emulated_kind *kind, int count, char **arguments)
{
    static emulated e;
    static vxsi_link link;
    scene s;
    open_scene(&s, kind, count, arguments);
    emulated_init(&e, kind);
    CHECK_INT(emulated_link(&e, &link), VXS_OK);
    vxs_device_command command;
    vxs_device_state state;
    vxs_device_report report;
    memset(&command, 0, sizeof command);
    int up = kind == &emulated_haply ? 2 : 1;
    double most = 0, truth[3], velocity[3];
    uint32_t seen = 0, contact = 0;
    for (int tick = 0; tick < 20; tick++) emulated_run(&e, &link);
    CHECK_INT(vxs_device_arm(&link.device), VXS_OK);
    for (int tick = 0; tick < 2500; tick++) {
        e.hand[up] = tick < 600 ? 0 : tick < 1000 ? -0.010 * (tick - 600) / 400 : -0.010;
        emulated_run(&e, &link);
        vxs_device_exchange(&link.device, &command, &state, &report);
        vxs_servo_trace row;
        seen |= vxs_servo_tick(s.servo, &state, &command, &row);
        contact += row.points > 0;
        most = fmax(most, emulated_force(&e));
        if (tick < 100) CHECK(emulated_force(&e) == 0);
        CHECK_INT(state.state, VXS_DEVICE_ARMED);
    }
    vxs_simulated_truth(e.tip, truth, velocity);
    double hand = 500 * (truth[up] - e.hand[up]), motor = e.force[up], apart = 0;
    for (int n = 0; n < 3; n++) apart = fmax(apart, fabs(state.pose.position[n] - truth[n]));
    vxs_hardware_counts counts;
    vxs_hardware_get(&link.device, &counts);
    printf("%s: motors %.3f N, hand %.3f N, %.3f N at most, pose off by %.1f um, %llu sent, %llu measured, "
           "%u ticks in contact\n",
           kind->name, motor, hand, most, 1e6 * apart, (unsigned long long)counts.sent,
           (unsigned long long)counts.measured, contact);
    CHECK(contact > 1000);
    CHECK(motor > 0.5);
    CHECK_NEAR(motor, hand, 0.03);
    CHECK(most < 8);
    CHECK(apart < 60e-6);
    CHECK(!(seen & (VXS_SERVO_FAULT | VXS_SERVO_TELEPORT | VXS_SERVO_DEVICE_LOST)));
    CHECK(counts.sent > 2450 * (kind->driver->answers ? 1u : 1u) && counts.malformed == 0 &&
          counts.late == 0);
    vxs_device_close(&link.device);
    CHECK(e.is_closed);
    emulated_run(&e, NULL);
    CHECK(emulated_force(&e) == 0);
    close_scene(&s);
}

/* Armed while the ball is 2 mm in the floor: nothing, until it was free once. */
static void start_in_contact(const emulated_kind *kind)
{
    static emulated e;
    static vxsi_link link;
    scene s;
    open_scene(&s, kind, 0, NULL);
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
    close_scene(&s);
}

/* A six-axis mouse: half a second at half speed. */
static void push_mouse(void)
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

int main(int count, char **arguments)
{
    touch(&emulated_hvlink, count, arguments);
    touch(&emulated_haply, count, arguments);
    touch(&emulated_falcon, count, arguments);
    for (int n = 0; n < 3; n++) start_in_contact(emulated_kinds[n]);
    push_mouse();
    return 0;
}
