/* SPDX-License-Identifier: MIT
 *
 * The object as a rigid body: free, it keeps energy and momentum as it tumbles, about every axis, and goes
 * where Euler's equations lead; pushed, pulled and hung on the device it does what Newton says; what it
 * cannot be stepped with is refused, or bounded. Argument: seconds to tumble.
 */
#include "lone_stage.h"
#include "servo_state.h"

static const double pi = 3.14159265358979323846;

static double dot(const double a[3], const double b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

static double length(const double v[3])
{
    return sqrt(dot(v, v));
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* A slanted body of three different moments, with its middle beside the tip. */
static const double moments[3] = {2e-5, 5e-5, 6.5e-5};

static void prepare(lone_stage *l, double stiffness)
{
    vxs_effect *effect = lone_prepare(l, VXS_EFFECT_INERTIA);
    memcpy(effect->as.inertia.inertia, moments, sizeof moments);
    effect->as.inertia.mass = 0.2;
    effect->as.inertia.com[0] = 0.01;
    effect->as.inertia.com[2] = -0.02;
    effect->as.inertia.stiffness = stiffness;
    l->config.grip = (vxs_pose){{0.003, 0.004, 0}, {0.9, 0.1, -0.3, 0.2}};
}

/* A tick with a wrench on the object and the device at `tip`; gives the object's tip and what the device
 * feels.
 */
static vxs_wrench step(lone_stage *l, const vxs_wrench *wrench, const vxs_pose *tip, vxs_pose *body)
{
    vxs_tick *tick = lone_tick(l, tip, wrench);
    l->stage->pose(l->memory, tip, &tick->body);
    l->stage->run(l->memory, tick);
    l->stage->pose(l->memory, tip, body);
    return tick->wrench;
}

/* The body's axes and its centre of mass where its tip is `tip`. */
static void body_of(const lone_stage *l, const vxs_pose *tip, double r[9], double com[3])
{
    vxs_pose at = *tip, shell = vxs_pose_identity();
    memcpy(shell.position, l->effect.as.inertia.com, sizeof shell.position);
    CHECK(vxs_pose_compose(&l->config.grip, &shell, &shell) && vxs_pose_compose(&at, &shell, &at) &&
          vxs_pose_rotation(&at, r));
    memcpy(com, at.position, sizeof at.position);
}

/* Energy and momentum from two tips a sample apart, without the rule's own terms: good to (w T)^2. */
static double energy_between(const lone_stage *l, const vxs_pose *before, const vxs_pose *now,
                             double momentum[3])
{
    double r[9], s[9], com[3], was[3], turn[3], energy = 0, v[3];
    body_of(l, before, r, was);
    body_of(l, now, s, com);
    vxs_pose_turn(before->orientation, now->orientation, turn);
    momentum[0] = momentum[1] = momentum[2] = 0;
    for (int axis = 0; axis < 3; axis++) {
        double along[3] = {(r[axis] + s[axis]) / 2, (r[3 + axis] + s[3 + axis]) / 2,
                           (r[6 + axis] + s[6 + axis]) / 2};
        double rate = dot(along, turn) / 0.001;
        energy += 0.5 * moments[axis] * rate * rate;
        for (int i = 0; i < 3; i++) momentum[i] += moments[axis] * rate * along[i];
        v[axis] = (com[axis] - was[axis]) / 0.001;
    }
    return energy + 0.5 * l->effect.as.inertia.mass * dot(v, v);
}

/* Energy and momentum of turning at the beginning of a sample, by the rule's own terms: Cayley's turn by T w
 * is one by 2 atan(T w / 2), and I w + T/2 w x I w was the momentum in the body's frame. */
static double exact_between(const lone_stage *l, const vxs_pose *before, const vxs_pose *now,
                            double momentum[3])
{
    double r[9], com[3], turn[3], w[3], spin[3], gyro[3], energy = 0;
    body_of(l, before, r, com);
    vxs_pose_turn(before->orientation, now->orientation, turn);
    const double cosine = sqrt(1 - dot(turn, turn) / 4);
    for (int i = 0; i < 3; i++) {
        const double axis[3] = {r[i], r[3 + i], r[6 + i]};
        w[i] = dot(axis, turn) / cosine / 0.001;
        spin[i] = moments[i] * w[i];
    }
    cross(w, spin, gyro);
    for (int i = 0; i < 3; i++) {
        spin[i] += 0.0005 * gyro[i];
        energy += 0.5 * spin[i] * spin[i] / moments[i];
    }
    for (int i = 0; i < 3; i++) momentum[i] = dot(r + 3 * i, spin);
    return energy;
}

static void check_tumble(const double rate[3], long seconds, double tolerance)
{
    lone_stage l;
    prepare(&l, 0);
    lone_open(&l);
    vxs_pose tip = vxs_pose_identity(), body, last;
    double r[9], com[3], first_com[3], push[3] = {0.02, -0.01, 0.03};
    vxs_wrench kick = {{0, 0, 0}, {0, 0, 0}};
    body_of(&l, &tip, r, com);
    memcpy(first_com, com, sizeof com);
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 3; i++) kick.torque[i] += moments[axis] * rate[axis] / 0.001 * r[3 * i + axis];
    /* and a push at the centre of mass: its torque about the tip */
    double torque[3];
    cross(com, push, torque);
    for (int i = 0; i < 3; i++) {
        kick.force[i] = push[i];
        kick.torque[i] += torque[i];
    }
    const double exact_energy = 0.5 * (moments[0] * rate[0] * rate[0] + moments[1] * rate[1] * rate[1] +
                                       moments[2] * rate[2] * rate[2]) +
                                0.5 * 0.2 * dot(push, push) * 1e-6 / 0.04;
    double exact_momentum[3], worst_energy = 0, worst_momentum = 0, momentum[3], flips = 0, side = 0;
    for (int i = 0; i < 3; i++) exact_momentum[i] = 0.001 * (kick.torque[i] - torque[i]);
    vxs_wrench felt = step(&l, &kick, &tip, &body);
    double first_energy = 0, first_momentum[3], exact = 0;
    for (long k = 1; k < 1000 * seconds; k++) {
        last = body;
        felt = step(&l, NULL, &tip, &body);
        double energy = energy_between(&l, &last, &body, momentum), off[3];
        for (int i = 0; i < 3; i++) off[i] = momentum[i] - exact_momentum[i];
        worst_energy = fmax(worst_energy, fabs(energy / exact_energy - 1));
        worst_momentum = fmax(worst_momentum, length(off) / length(exact_momentum));
        energy = exact_between(&l, &last, &body, momentum);
        if (k == 1) {
            first_energy = energy;
            memcpy(first_momentum, momentum, sizeof momentum);
        }
        for (int i = 0; i < 3; i++) off[i] = momentum[i] - first_momentum[i];
        exact = fmax(exact, fmax(fabs(energy / first_energy - 1), length(off) / length(first_momentum)));
        body_of(&l, &body, r, com);
        double now = r[1] * exact_momentum[0] + r[4] * exact_momentum[1] + r[7] * exact_momentum[2];
        flips += now * side < 0;
        if (now != 0) side = now;
    }
    CHECK(length(felt.force) == 0 && length(felt.torque) == 0);
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(com[i] - first_com[i], push[i] * 0.001 / 0.2 * (double)seconds, 1e-12 * (double)seconds);
    printf(
        "tumbles at %g %g %g rad/s for %ld s: energy within %.2g, momentum %.2g of its length, without the "
        "error of measuring them %.2g\n",
        rate[0], rate[1], rate[2], seconds, worst_energy, worst_momentum, exact);
    CHECK(exact < 1e-9);
    CHECK(worst_energy < tolerance && worst_momentum < tolerance);
    if (seconds >= 60 && rate[1] > 5 * (rate[0] + rate[2])) CHECK(flips >= 4);
}

/* Runge and Kutta's fourth order on Euler's equations, in small steps. */
static void slope_of(const double w[3], const double q[4], double dw[3], double dq[4])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        dw[i] = (moments[j] - moments[k]) * w[j] * w[k] / moments[i];
    }
    dq[0] = -0.5 * (q[1] * w[0] + q[2] * w[1] + q[3] * w[2]);
    dq[1] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]);
    dq[2] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]);
    dq[3] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
}

static void exact_turn(const double rate[3], double seconds, double q[4])
{
    const int steps = 200000;
    const double t = seconds / steps;
    double w[3] = {rate[0], rate[1], rate[2]};
    for (int n = 0; n < steps; n++) {
        double dw[4][3], dq[4][4], u[3], p[4];
        for (int stage = 0; stage < 4; stage++) {
            const double part = stage == 0 ? 0 : stage == 3 ? t : t / 2;
            for (int i = 0; i < 3; i++) u[i] = w[i] + (stage ? part * dw[stage - 1][i] : 0);
            for (int i = 0; i < 4; i++) p[i] = q[i] + (stage ? part * dq[stage - 1][i] : 0);
            slope_of(u, p, dw[stage], dq[stage]);
        }
        for (int i = 0; i < 3; i++) w[i] += t / 6 * (dw[0][i] + 2 * dw[1][i] + 2 * dw[2][i] + dw[3][i]);
        for (int i = 0; i < 4; i++) q[i] += t / 6 * (dq[0][i] + 2 * dq[1][i] + 2 * dq[2][i] + dq[3][i]);
    }
}

/* Where Euler's equations lead, with an error of the sample's square. */
static void check_way(void)
{
    const double rate[3] = {3, 7, -2};
    double errors[2], q[4] = {1, 0, 0, 0};
    exact_turn(rate, 2, q);
    for (int half = 0; half < 2; half++) {
        lone_stage l;
        vxs_effect *effect = lone_prepare(&l, VXS_EFFECT_INERTIA);
        memcpy(effect->as.inertia.inertia, moments, sizeof moments);
        effect->as.inertia.stiffness = 0;
        const double t = l.config.coupling.sample_time = half ? 0.001 : 0.002;
        lone_open(&l);
        vxs_pose tip = vxs_pose_identity(), body;
        vxs_wrench kick = {{0, 0, 0}, {0, 0, 0}};
        for (int i = 0; i < 3; i++) kick.torque[i] = moments[i] * rate[i] / t;
        step(&l, &kick, &tip, &body);
        for (int k = 1; k < (int)(2 / t + 0.5); k++) step(&l, NULL, &tip, &body);
        double turn[3];
        vxs_pose_turn(q, body.orientation, turn);
        errors[half] = length(turn);
    }
    printf("after 2 s %.3g rad off Euler's equations at 500 Hz, %.3g at 1 kHz\n", errors[0], errors[1]);
    CHECK(errors[1] < 1e-3);
    CHECK_NEAR(errors[0] / errors[1], 4, 0.1);
}

/* On its spring: a steady push moves it by F / k and M / (k r^2), and the device feels just that. */
static void check_spring(void)
{
    lone_stage l;
    prepare(&l, 800);
    lone_open(&l);
    const vxs_wrench push = {{0.5, -0.2, 0.1}, {0.002, 0.001, -0.003}};
    vxs_pose tip = vxs_pose_identity(), body;
    vxs_wrench felt;
    for (int k = 0; k < 5000; k++) felt = step(&l, &push, &tip, &body);
    double turn[3];
    vxs_pose_turn(tip.orientation, body.orientation, turn);
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(felt.force[i], push.force[i], 1e-9);
        CHECK_NEAR(felt.torque[i], push.torque[i], 1e-9);
        CHECK_NEAR(body.position[i], push.force[i] / 800, 1e-9);
        CHECK_NEAR(turn[i], push.torque[i] / (800 * 4e-4), 1e-6);
    }
    /* The device runs on: in the end the body follows at its speed, and nothing is felt. */
    for (int k = 0; k < 5000; k++) {
        tip.position[0] += 1e-5;
        felt = step(&l, NULL, &tip, &body);
    }
    CHECK_NEAR(length(felt.force), 0, 1e-9);
    CHECK_NEAR(body.position[0] - tip.position[0], 0, 1e-9);
    /* However stiff, light and slow: no swinging up. */
    for (int n = 0; n < 3; n++) {
        prepare(&l, n ? 1e9 : 1e6);
        l.effect.as.inertia.damping = n == 2 ? 0 : 1;
        l.config.coupling.sample_time = n ? 0.1 : 0.001;
        l.effect.as.inertia.mass = 0.01;
        lone_open(&l);
        tip = vxs_pose_identity();
        for (int k = 0; k < 3000; k++) {
            tip.position[0] = k < 1000 ? 0.01 * (k % 2) : 0;
            step(&l, NULL, &tip, &body);
            CHECK(length(body.position) < 0.05);
        }
        CHECK_NEAR(length(body.position), 0, 1e-6);
    }
}

/* Whatever pushes, pulls and turns: what its momentum changes by is what acted on it, the spring as it is
 * felt. */
static void check_newton(void)
{
    lone_stage l;
    prepare(&l, 2000);
    lone_open(&l);
    vxs_pose tip = vxs_pose_identity(), body = tip, last;
    double r[9], com[3], was[3], velocity[3] = {0, 0, 0}, momentum[3], before[3] = {0, 0, 0}, impulse[3],
                                 most = 0;
    body_of(&l, &body, r, was);
    for (int k = 0; k < 3000; k++) {
        const double a = 0.01 * k;
        const vxs_wrench push = {{2 * sin(a), cos(3 * a), 1},
                                 {0.01 * cos(2 * a), 0.02 * sin(5 * a), -0.01 * cos(a)}};
        tip.position[0] = 0.01 * sin(7 * a);
        tip.position[1] = 0.01 * cos(4 * a) - 0.01;
        lone_turn(tip.orientation, (const double[3]){0, 0.6, 0.8}, 0.3 * sin(3 * a));
        last = body;
        const vxs_wrench felt = step(&l, &push, &tip, &body);
        body_of(&l, &last, r, was);
        body_of(&l, &body, r, com);
        exact_between(&l, &last, &body, momentum);
        double arm[3], force[3], torque[3];
        for (int i = 0; i < 3; i++) {
            const double now = (com[i] - was[i]) / 0.001;
            arm[i] = last.position[i] - was[i];
            force[i] = push.force[i] - felt.force[i];
            CHECK_NEAR(0.2 * (now - velocity[i]), 0.001 * force[i], 1e-11);
            velocity[i] = now;
        }
        cross(arm, force, torque);
        for (int i = 0; i < 3; i++) {
            impulse[i] = 0.001 * (torque[i] + push.torque[i] - felt.torque[i]);
            if (k > 0) CHECK_NEAR(momentum[i] - before[i], impulse[i], 1e-11);
            most = fmax(most, fabs(impulse[i]));
        }
        memcpy(before, momentum, sizeof before);
    }
    CHECK(most > 1e-5);
}

/* Held at 1 rad a tick. */
static void check_fastest(void)
{
    lone_stage l;
    prepare(&l, 0);
    lone_open(&l);
    vxs_pose tip = vxs_pose_identity(), body, last;
    double most = 0, least = 9;
    const vxs_wrench kick = {{0, 0, 0}, {1e6, -2e6, 5e5}};
    step(&l, &kick, &tip, &body);
    for (int k = 0; k < 1000; k++) {
        double turn[3];
        last = body;
        step(&l, NULL, &tip, &body);
        vxs_pose_turn(last.orientation, body.orientation, turn);
        most = fmax(most, length(turn));
        least = fmin(least, length(turn));
    }
    CHECK(least > 0.5 && most < 2 * sin(atan(0.5)) + 0.1);
}

/* A light damping: frequency and decay of m x'' + b x' + k x = 0; the implicit spring damps by k T^2 / 2
 * besides.
 */
static void check_ringing(void)
{
    lone_stage l;
    vxs_effect *effect = lone_prepare(&l, VXS_EFFECT_INERTIA);
    effect->as.inertia.mass = 0.1;
    effect->as.inertia.stiffness = 100;
    effect->as.inertia.damping = 0.05;
    lone_open(&l);
    const double w = sqrt(100 / 0.1), zeta = 0.05 + w * 0.001 / 2;
    vxs_pose tip = vxs_pose_identity(), body;
    vxs_wrench hit = {{10, 0, 0}, {0, 0, 0}}; /* 0.1 m/s */
    double peaks[2] = {0, 0};
    int count = 0, first = 0, last = 0;
    double before = 0;
    for (int k = 0; k < 1500; k++) {
        step(&l, k == 0 ? &hit : NULL, &tip, &body);
        double x = body.position[0];
        if (before < 0 && x >= 0) {
            if (!first) first = k;
            last = k;
            count++;
        }
        if (count < 2) peaks[0] = fmax(peaks[0], x);
        if (count == 5) peaks[1] = fmax(peaks[1], x);
        before = x;
    }
    double period = (last - first) * 0.001 / (count - 1);
    CHECK_NEAR(period, 2 * pi / (w * sqrt(1 - zeta * zeta)), 0.02 * period);
    CHECK_NEAR(log(peaks[0] / peaks[1]) / 5, 2 * pi * zeta / sqrt(1 - zeta * zeta), 0.03);
}

static void check_refusals(void)
{
    vxs_effect good, e;
    CHECK_INT(vxs_effect_default(VXS_EFFECT_INERTIA, &good), VXS_OK);
    CHECK(&good.as.inertia.inertia[0] == &good.as.constants[4] &&
          &good.as.inertia.radius == &good.as.constants[12]);
    static const double wrong[][6] = {{1e-6, 1e-6, 2.1e-6, 0, 0, 0},  /* more than the others together */
                                      {1e-6, 1e-6, 1e-6, 2e-6, 0, 0}, /* no eigenvalue may be below 0 */
                                      {1e-6, 1e-6, 1e-6, 0, 0.6e-6, 0}};
    static const double right[][6] = {{1e-6, 1e-6, 2e-6, 0, 0, 0}, /* a plate */
                                      {1e-9, 1e-6, 1e-6, 0, 0, 0}, /* a needle */
                                      {1e-6, 1e-6, 1e-6, 0.2e-6, 0, 0.1e-6}};
    for (int n = 0; n < 3; n++) {
        e = good;
        memcpy(e.as.inertia.inertia, wrong[n], sizeof wrong[n]);
        CHECK_INT(vxs_effect_check(&e), VXS_PARAM);
        memcpy(e.as.inertia.inertia, right[n], sizeof right[n]);
        CHECK_INT(vxs_effect_check(&e), VXS_OK);
    }
}

/* What contact may be at most: beside the largest eigenvalue of a ball's compliance, 1 / m or r^2 / I. */
static void check_bound(void)
{
    lone_stage l;
    lone_prepare(&l, VXS_EFFECT_INERTIA); /* m = 0.05, I = 8e-6, r = 0.01: 20 and 12.5 */
    lone_open(&l);
    static vxs_servo servo;
    double *most = &servo.config.contact.most_stiffness;
    l.stage->attach(l.memory, &servo);
    CHECK_NEAR(*most, 0.25 / (20 * 1e-6), 1e-3 * *most);
    *most = 300;
    l.stage->attach(l.memory, &servo);
    CHECK(*most == 300);
    lone_prepare(&l, VXS_EFFECT_INERTIA);
    for (int i = 0; i < 3; i++) l.effect.as.inertia.inertia[i] = 1e-6; /* 20 and 100 */
    lone_open(&l);
    *most = 0;
    l.stage->attach(l.memory, &servo);
    CHECK_NEAR(*most, 0.25 / (100 * 1e-6), 1e-3 * *most);
    lone_prepare(&l, VXS_EFFECT_INERTIA)->as.inertia.com[0] = 0.1; /* and 20 + 0.01 / 8e-6 beside the tip */
    lone_open(&l);
    *most = 0;
    l.stage->attach(l.memory, &servo);
    /* 2 x 2 of a push across and a turn: 20 + 1250, 125, 12.5. */
    CHECK_NEAR(*most, 0.25 / 1282.35e-6, 2e-3 * *most);
}

int main(int count, char **arguments)
{
    const long seconds = count > 1 ? atol(arguments[1]) : check_length(60, 5);
    const double rates[][3] = {{10, 0, 0}, {0, 0, 10}, {0.01, 10, 0}, {4, -6, 7}, {1e-6, 20, 1e-6}};
    check_refusals();
    check_bound();
    for (int n = 0; n < 5; n++) check_tumble(rates[n], seconds, 1e-3);
    const double fast[3] = {30, 200, -50};
    check_tumble(fast, seconds, 0.02); /* as the samples tell it: (w T)^2 / 12 and more */
    check_way();
    check_newton();
    check_fastest();
    check_spring();
    check_ringing();
    return 0;
}
