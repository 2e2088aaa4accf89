/* SPDX-License-Identifier: MIT
 *
 * Hunt and Crossley's damping: the restitution of a mass against the exact solution, for two laws of force
 * and many speeds; never energy, never a pull; the factor's bounds.
 */
#include "lone_stage.h"

/* u of c v - ln(1 + c v) = -c u - ln(1 - c u), by halving. */
static double rebound(double c, double v)
{
    const double left = c * v - log1p(c * v);
    double low = 0, high = fmin(v, 1 / c);
    for (int n = 0; n < 200; n++) {
        double u = (low + high) / 2;
        if (-c * u - log1p(-c * u) < left)
            low = u;
        else
            high = u;
    }
    return low;
}

/* A mass falls on F_e = k x^power at speed v; returns the speed at which it leaves. */
static double bounce(double c, double v, double power, double *least)
{
    const double sample_time = 2e-6, mass = 0.1, stiffness = power == 1 ? 1000 : 1e5;
    lone_stage l;
    vxs_effect *e = lone_prepare(&l, VXS_EFFECT_CONTACT_DAMPING);
    e->as.contact_damping.factor = c;
    e->as.contact_damping.most = 1000;
    l.config.coupling.sample_time = sample_time;
    lone_open(&l);
    double y = 2e-9, speed = -v;
    *least = 0;
    for (long k = 0; k < 5000000; k++) {
        vxs_pose pose = vxs_pose_identity();
        pose.position[1] = y;
        double depth = y < 0 ? -y : 0;
        const vxs_wrench push = {{0, stiffness * pow(depth, power), 0}, {0, 0, 0}};
        lone_tick(&l, &pose, &push);
        lone_run(&l);
        double force = l.tick.wrench.force[1];
        *least = fmin(*least, force);
        if (c == 0) CHECK(force == push.force[1]);
        CHECK(l.tick.has_field == 0);
        if (y > 0 && speed > 0) return speed;
        speed += force / mass * sample_time;
        y += speed * sample_time;
    }
    CHECK(!"it leaves");
    return 0;
}

static void check_restitution(void)
{
    const double factors[] = {0, 0.1, 0.5, 2}, speeds[] = {0.05, 0.2, 1};
    for (int n = 0; n < 4; n++) {
        for (int m = 0; m < 3; m++) {
            for (double power = 1; power < 2; power += 0.5) {
                double c = factors[n], v = speeds[m], least, u = bounce(c, v, power, &least);
                double wanted = c > 0 ? rebound(c, v) : v;
                CHECK_NEAR(u / v, wanted / v, 1e-3);
                if (c * v <= 0.05) CHECK_NEAR(u / v, 1 - 2.0 / 3 * c * v, 2 * c * c * v * v + 1e-3);
                CHECK(least >= 0 && u <= v * (1 + 1e-3));
                if (power == 1)
                    printf("c = %.1f s/m, v = %.2f m/s: e = %.4f, exact %.4f\n", c, v, u / v, wanted / v);
            }
        }
    }
}

/* Factor, its bounds, turning, opposed forces. */
static void check_factor(void)
{
    lone_stage l;
    vxs_effect *e = lone_prepare(&l, VXS_EFFECT_CONTACT_DAMPING);
    e->as.contact_damping.factor = 2;
    e->as.contact_damping.most = 1.5;
    l.config.grip.position[0] = 0.05; /* held 50 mm beside the middle */
    lone_open(&l);
    const double speeds[] = {0, -0.1, 0.2, -0.3, 0.4, -2, 2};
    double y = 0;
    for (int n = 0; n < 7; n++) {
        vxs_pose pose = vxs_pose_identity();
        pose.position[1] = y += speeds[n] * 0.001;
        const vxs_wrench push = {{0, 3, 0}, {0, 0, 3 * 0.05}}; /* at the middle */
        lone_tick(&l, &pose, &push);
        lone_run(&l);
        double factor = fmin(fmax(1 - 2 * speeds[n], 0), 1.5);
        CHECK_NEAR(l.tick.wrench.force[1], 3 * factor, 1e-9);
        CHECK_NEAR(l.tick.wrench.torque[2], 0.15 * factor, 1e-9);
    }
    /* A couple of 0.02 N m, as of 2 N at the radius, against a turn of 1 rad/s: 10 mm/s. */
    lone_open(&l);
    const double z[3] = {0, 0, 1};
    const vxs_wrench couple = {{0, 0, 0}, {0, 0, 0.02}};
    vxs_pose pose = vxs_pose_identity();
    for (int n = 0; n < 3; n++) {
        lone_turn(pose.orientation, z, -0.001 * n);
        lone_tick(&l, &pose, &couple);
        lone_run(&l);
        CHECK_NEAR(l.tick.wrench.torque[2], n ? 0.02 * (1 + 2 * 0.01) : 0.02, 1e-9);
    }
    /* Forgotten at arming; nothing touches. */
    pose.position[1] += 1;
    l.stage->reset(l.memory, &pose);
    lone_tick(&l, &pose, &couple);
    lone_run(&l);
    CHECK(l.tick.wrench.torque[2] == 0.02);
    const vxs_wrench none = {{0, 0, 0}, {0, 0, 0}};
    pose.position[1] += 1;
    lone_tick(&l, &pose, &none);
    lone_run(&l);
    for (int i = 0; i < 3; i++) CHECK(l.tick.wrench.force[i] == 0 && l.tick.wrench.torque[i] == 0);
}

/* Any motion, any wrench: what it adds takes energy. */
static void check_passive(void)
{
    lone_stage l;
    lone_prepare(&l, VXS_EFFECT_CONTACT_DAMPING)->as.contact_damping.factor = 3;
    lone_open(&l);
    uint32_t random = 1;
    vxs_pose pose = vxs_pose_identity(), last;
    for (int k = 0; k < 100000; k++) {
        vxs_wrench push, more;
        double v[13];
        for (int n = 0; n < 13; n++) {
            random ^= random << 13, random ^= random >> 17, random ^= random << 5;
            v[n] = random / 4294967296.0 - 0.5;
        }
        last = pose;
        for (int i = 0; i < 3; i++) pose.position[i] += 1e-4 * v[i];
        for (int i = 0; i < 4; i++) pose.orientation[i] += 0.01 * v[3 + i];
        vxs_pose identity = vxs_pose_identity();
        CHECK(vxs_pose_compose(&pose, &identity, &pose));
        for (int i = 0; i < 3; i++) push.force[i] = v[7 + i], push.torque[i] = 0.01 * v[10 + i];
        lone_tick(&l, &pose, &push);
        lone_run(&l);
        double turn[3], work = 0;
        vxs_pose_turn(last.orientation, pose.orientation, turn);
        for (int i = 0; i < 3; i++) {
            more.force[i] = l.tick.wrench.force[i] - push.force[i];
            more.torque[i] = l.tick.wrench.torque[i] - push.torque[i];
            work += more.force[i] * (pose.position[i] - last.position[i]) + more.torque[i] * turn[i];
            CHECK(fabs(l.tick.wrench.force[i]) <= 4 * fabs(push.force[i]));
        }
        CHECK(work <= 1e-18);
    }
}

int main(void)
{
    check_restitution();
    check_factor();
    check_passive();
    return 0;
}
