/* SPDX-License-Identifier: MIT
 *
 * A controller that owns its loop: no thread, no clock and no device of voxshell's, only vxs_servo_tick()
 * once a period. Usage: own_loop CUP.voxmap SPHERE.pointshell
 */
#include "voxshell/servo.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RATE = 2000, TICKS = 3 * RATE };

/* The controller's own arm: a mass that a person pulls at through a spring, from 75 to 47 mm, into the cup's
 * wall. */
typedef struct arm {
    double x, speed, hand; /* [m], [m/s], [m] */
} arm;

static void move_arm(arm *a, double force, int tick)
{
    const double mass = 0.4, spring = 500, damper = 12, period = 1.0 / RATE;
    double t = tick * period, share = t < 0.8 ? 0 : t < 1.2 ? (t - 0.8) / 0.4 : 1;
    a->hand = 0.075 - 0.028 * share;
    a->speed += period / mass * (force + spring * (a->hand - a->x) - damper * a->speed);
    a->x += period * a->speed;
}

static int open_scene(char **paths, vxs_asset files[2], vxs_voxmap *map, vxs_pointshell *shell)
{
    for (int n = 0; n < 2; n++) {
        vxs_asset_issue issue;
        vxs_result result = vxs_asset_open(paths[n], NULL, &files[n], &issue);
        if (result == VXS_OK) continue;
        fprintf(stderr, "%s: %s\n", paths[n], vxs_result_text(result));
        return 0;
    }
    return vxs_voxmap_open(&files[0], map) == VXS_OK && vxs_pointshell_open(&files[1], shell) == VXS_OK;
}

int main(int count, char **arguments)
{
    vxs_asset files[2];
    vxs_voxmap map;
    vxs_pointshell shell;
    if (count != 3 || !open_scene(arguments + 1, files, &map, &shell)) {
        fprintf(stderr, "usage: own_loop CUP.voxmap SPHERE.pointshell\n");
        return 1;
    }

    /* Once: what stands, what moves, how it feels. All memory is the caller's. */
    const vxs_contact_static statics = {&map, NULL};
    vxs_servo_config config;
    vxs_servo_config_default(&config);
    config.statics = &statics;
    config.static_count = 1;
    config.shell = &shell;
    config.contact.law = VXS_CONTACT_PATCH;
    config.contact.field = VXS_CONTACT_DISTANCE;
    config.contact.weighting = VXS_CONTACT_AREA;
    config.contact.stiffness = 3e8;
    config.coupling.kind = VXS_COUPLING_QUASI_STATIC;
    config.coupling.stiffness = 800;
    config.coupling.sample_time = 1.0 / RATE;
    config.max_force = 8;
    size_t size = vxs_servo_memory(&config);
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    vxs_servo *servo;
    vxs_result result = vxs_servo_init(memory, size, &config, &servo);
    if (result != VXS_OK) {
        fprintf(stderr, "servo: %s\n", vxs_result_text(result));
        return 1;
    }

    /* Each period: what was measured in, a command out. ARMED says that the arm may push. */
    arm a = {.x = 0.075, .hand = 0.075};
    vxs_device_state state;
    vxs_device_command command;
    vxs_servo_trace row;
    uint32_t flags = 0, seen = 0;
    memset(&state, 0, sizeof state);
    state.state = VXS_DEVICE_ARMED;
    for (int tick = 0; tick < TICKS; tick++) {
        state.sequence++;
        state.time_ns = (int64_t)tick * (1000000000 / RATE);
        state.pose = vxs_pose_identity();
        state.pose.position[0] = a.x;
        state.pose.position[1] = 0.04;
        state.velocity[0] = a.speed;
        state.velocity_source = VXS_DEVICE_VELOCITY_MEASURED;
        flags = vxs_servo_tick(servo, &state, &command, &row);
        seen |= flags;
        move_arm(&a, command.wrench.force[0], tick);
    }
    printf("arm at %.2f mm, hand at %.2f mm: the loop pushes with %.3f N, the hand with %.3f N\n", 1e3 * a.x,
           1e3 * a.hand, command.wrench.force[0], 500 * (a.x - a.hand));
    printf("the sphere is %.3f mm deep in the wall; flags of the last tick %#x, of all %#x\n",
           1e3 * row.depth, (unsigned)flags, (unsigned)seen);
    free(memory);
    vxs_asset_close(&files[0]);
    vxs_asset_close(&files[1]);
    return flags & VXS_SERVO_FAULT ? 1 : 0;
}
