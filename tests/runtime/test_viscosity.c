/* SPDX-License-Identifier: MIT
 *
 * A viscous medium against its formula, and a mass in it against the recursion that a held command gives:
 * stable below 2 m / T and not above.
 */
#include "lone_stage.h"

static const double sample_time = 0.001;

/* (0.07, 0.02, 0) turned about (0, 0.6, 0.8), by Rodrigues. */
static void middle_at(double angle, double out[3])
{
    const double c = cos(angle), s = sin(angle), along = 0.6 * 0.02 * (1 - c);
    out[0] = 0.07 * c - 0.8 * 0.02 * s;
    out[1] = 0.02 * c + 0.8 * 0.07 * s + 0.6 * along;
    out[2] = -0.6 * 0.07 * s + 0.8 * along;
}

/* A point of the object that is not held in its middle: drag at the middle, torque about the tip. */
static void check_formula(void)
{
    static const double axis[3] = {0, 0.6, 0.8};
    lone_stage l;
    vxs_effect *e = lone_prepare(&l, VXS_EFFECT_VISCOSITY);
    e->as.viscosity.damping = 3;
    e->as.viscosity.turning = 0.02;
    l.shell.center[0] = 0.07;
    l.config.grip.position[1] = 0.02;
    lone_open(&l);
    vxs_pose pose = {{1, 2, 3}, {1, 0, 0, 0}};
    lone_tick(&l, &pose, NULL);
    lone_run(&l);
    for (int i = 0; i < 3; i++) CHECK(l.tick.field.force[i] == 0 && l.tick.field.torque[i] == 0);
    const double rate = 0.5, way[3] = {2e-4, -1e-4, 5e-5};
    for (int k = 1; k < 50; k++) {
        const double before = rate * sample_time * (k - 1), now = rate * sample_time * k;
        double arm[3], last[3];
        for (int i = 0; i < 3; i++) pose.position[i] += way[i];
        lone_turn(pose.orientation, axis, now);
        lone_tick(&l, &pose, NULL);
        lone_run(&l);
        middle_at(now, arm);
        middle_at(before, last);
        double force[3];
        for (int i = 0; i < 3; i++) {
            force[i] = -3 * (way[i] + arm[i] - last[i]) / sample_time;
            CHECK_NEAR(l.tick.field.force[i], force[i], 1e-9);
        }
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, m = (i + 2) % 3;
            double torque = -0.02 * rate * axis[i] + arm[j] * force[m] - arm[m] * force[j];
            CHECK_NEAR(l.tick.field.torque[i], torque, 1e-8);
        }
    }
    /* After missed ticks: by the time that passed. */
    pose.position[0] += 1e-3;
    lone_tick(&l, &pose, NULL)->elapsed = 0.01;
    lone_run(&l);
    CHECK_NEAR(l.tick.field.force[0], -3 * 0.1, 1e-9);
}

/* A free mass that starts at 0.2 m/s, b T / m = share: where it is after n samples, and the fastest since. */
static double coast(double share, int samples, double *fastest)
{
    const double mass = 0.08, speed = 0.2;
    lone_stage l;
    lone_prepare(&l, VXS_EFFECT_VISCOSITY)->as.viscosity.damping = share * mass / sample_time;
    lone_open(&l);
    vxs_pose pose = vxs_pose_identity();
    double velocity = 0, way = 0, step = 0, next = 0; /* step and next: the recursion */
    *fastest = 0;
    for (int k = 0; k < samples; k++) {
        lone_tick(&l, &pose, NULL);
        lone_run(&l);
        double force = l.tick.field.force[0];
        if (k == 0) velocity = speed, next = speed * sample_time;
        CHECK_NEAR(force, -share * mass * step / (sample_time * sample_time), 1e-9 * (1 + fabs(force)));
        double moved = velocity * sample_time + force / mass * sample_time * sample_time / 2;
        velocity += force / mass * sample_time;
        way += moved;
        pose.position[0] = way;
        double before = step;
        step = next - share * before / 2;
        next = next - share * before;
        *fastest = fmax(*fastest, fabs(velocity));
        if (k > samples / 2) CHECK(share >= 2 || fabs(velocity) < 1e-3 * speed);
    }
    return way;
}

static void check_coasting(void)
{
    double fastest;
    const double shares[] = {0.01, 0.1, 0.5, 1, 1.9};
    for (int n = 0; n < 5; n++) {
        double way = coast(shares[n], 4000, &fastest);
        CHECK_NEAR(way, 0.2 * sample_time / shares[n], 1e-9); /* m v / b */
        CHECK(fastest <= 0.2 * (shares[n] <= 0.1 ? 1 : 3));
        printf("b T / m = %.2f: comes to rest after %.4f mm\n", shares[n], 1e3 * way);
    }
    coast(2.1, 1500, &fastest);
    CHECK(fastest > 100); /* shakes itself to pieces, as said */
}

int main(void)
{
    check_formula();
    check_coasting();
    return 0;
}
