/* SPDX-License-Identifier: MIT
 *
 * No memory of the past: after an arming, a fault or a teleport a servo does to the last bit what a new one
 * does with the same device states, whatever the coupling went through before.
 */
#include "servo_bench.h"

enum { EVENT_ARM, EVENT_FAULT, EVENT_TELEPORT, EVENTS };

static vxs_device_state state_at(int64_t tick, double x, double y)
{
    vxs_device_state state;
    memset(&state, 0, sizeof state);
    state.sequence = (uint64_t)tick + 1;
    state.time_ns = tick * 1000000;
    state.pose = vxs_pose_identity();
    state.pose.position[0] = x;
    state.pose.position[1] = y;
    state.pose.orientation[1] = 0.1;
    state.state = VXS_DEVICE_ARMED;
    return state;
}

static int in_contact;

static void compare(vxs_servo *old, vxs_servo *fresh, vxs_device_state state)
{
    vxs_device_command command;
    vxs_servo_trace a, b;
    vxs_servo_tick(old, &state, &command, &a);
    vxs_servo_tick(fresh, &state, &command, &b);
    CHECK(memcmp(&a.collision, &b.collision, sizeof a.collision) == 0);
    CHECK(memcmp(&a.output, &b.output, sizeof a.output) == 0);
    CHECK(memcmp(&a.command, &b.command, sizeof a.command) == 0);
    CHECK(a.gain == b.gain);
    in_contact += a.points > 0 && a.command.force[1] != 0;
}

static void run(uint32_t kind, int event)
{
    servo_bench b, other;
    bench_prepare(&b);
    bench_prepare(&other);
    b.servo_config.coupling.kind = other.servo_config.coupling.kind = kind;
    b.servo_config.coupling.omega0 = other.servo_config.coupling.omega0 = 100;
    b.servo_config.contact.reference[0] = 0.003;
    other.servo_config.contact.reference[0] = 0.003;
    bench_open(&b);
    bench_open(&other);
    vxs_device_command command;
    vxs_servo_trace row;
    int64_t tick = 0;
    for (; tick < 700; tick++) {
        double y = tick < 100 ? 0.012 : 0.0085 + 1e-4 * (double)(tick % 5);
        vxs_device_state state = state_at(tick, 1e-5 * (double)tick, y);
        CHECK(!(vxs_servo_tick(b.servo, &state, &command, &row) & (VXS_SERVO_FAULT | VXS_SERVO_TELEPORT)));
    }
    CHECK(row.points > 0 && fabs(row.command.force[1]) > 0.1);

    vxs_device_state state = state_at(tick++, 0.006, 0.009);
    if (event == EVENT_ARM) {
        state.state = VXS_DEVICE_READY;
        CHECK(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_OFF);
    } else if (event == EVENT_FAULT) {
        state.pose.position[2] = NAN;
        CHECK(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_FAULT);
        vxs_servo_clear(b.servo);
    } else {
        state.pose.position[1] += 0.1;
        CHECK(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_TELEPORT);
        vxs_servo_tick(other.servo, &state, &command, &row);
    }
    CHECK(command.wrench.force[1] == 0 && command.wrench.torque[0] == 0);
    in_contact = 0;
    for (int64_t k = 0; k < 900; k++, tick++) {
        double lift = event == EVENT_TELEPORT ? 0.1 * (double)(k < 200 ? 200 - k : 0) / 200 : 0;
        double y = k < 100 ? 0.013 : 0.0087 + 1e-4 * (double)(k % 5);
        compare(b.servo, other.servo, state_at(tick, 0.006 - 1e-5 * (double)k, y + lift));
    }
    CHECK(in_contact > 500);
    bench_close(&b);
    bench_close(&other);
}

/* Turned over at once, at the same place: a teleport too. And motion that a hand can make is none. */
static void check_what_is_a_teleport(void)
{
    servo_bench b;
    bench_prepare(&b);
    bench_open(&b);
    vxs_device_command command;
    vxs_servo_trace row;
    vxs_device_state state = state_at(0, 0, 0.02);
    CHECK(!(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_TELEPORT));
    state = state_at(1, 0.019, 0.02); /* 19 m/s */
    CHECK(!(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_TELEPORT));
    state = state_at(1001, 9, 0.02); /* 9 m in a second */
    CHECK(!(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_TELEPORT));
    state = state_at(1002, 9, 0.02);
    for (int i = 0; i < 4; i++) state.pose.orientation[i] *= -3; /* the same orientation */
    CHECK(!(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_TELEPORT));
    state = state_at(1003, 9, 0.02);
    state.pose.orientation[1] = 1.2; /* about 89 degrees from atan(0.1) */
    CHECK(!(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_TELEPORT));
    state = state_at(1004, 9, 0.02);
    state.pose.orientation[1] = 0;
    state.pose.orientation[2] = 1;
    CHECK(vxs_servo_tick(b.servo, &state, &command, &row) & VXS_SERVO_TELEPORT);
    bench_close(&b);
}

int main(void)
{
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_QUASI_STATIC; kind++) {
        for (int event = 0; event < EVENTS; event++) run(kind, event);
    }
    check_what_is_a_teleport();
    return 0;
}
