/* SPDX-License-Identifier: MIT
 *
 * A controller that owns its loop: no thread, no clock and no device of voxshell's, only vxs_servo_tick()
 * once a period. Usage: own_loop SCENE.plan
 */
#include "../scene.h"

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

int main(int count, char **arguments)
{
    scene s;
    if (count != 2 || !scene_open(&s, arguments[1])) {
        fprintf(stderr, "usage: own_loop SCENE.plan\n");
        return 1;
    }
    s.config.coupling.sample_time = 1.0 / RATE; /* what the scene says is for another rate */
    vxs_servo *servo = scene_servo(&s);
    if (!servo) return 1;

    /* Each period: what was measured in, a command out. ARMED says that the arm may push. */
    arm a = {.x = 0.075, .hand = 0.075};
    vxs_device_state state = {.state = VXS_DEVICE_ARMED,
                              .pose = vxs_pose_identity(),
                              .velocity_source = VXS_DEVICE_VELOCITY_MEASURED};
    vxs_device_command command;
    vxs_servo_trace row;
    uint32_t flags = 0, seen = 0;
    for (int tick = 0; tick < TICKS; tick++) {
        state.sequence++;
        state.time_ns = (int64_t)tick * (1000000000 / RATE);
        state.pose.position[0] = a.x;
        state.pose.position[1] = 0.04;
        state.velocity[0] = a.speed;
        flags = vxs_servo_tick(servo, &state, &command, &row);
        seen |= flags;
        move_arm(&a, command.wrench.force[0], tick);
    }
    printf("arm at %.2f mm, hand at %.2f mm: the loop pushes with %.3f N, the hand with %.3f N\n", 1e3 * a.x,
           1e3 * a.hand, command.wrench.force[0], 500 * (a.x - a.hand));
    printf("the sphere is %.3f mm deep in the wall; flags of the last tick %#x, of all %#x\n",
           1e3 * row.depth, (unsigned)flags, (unsigned)seen);
    scene_close(&s);
    return flags & VXS_SERVO_FAULT ? 1 : 0;
}
