/* SPDX-License-Identifier: MIT
 *
 * The passivity observer and controller against energies that are known: of a virtual spring that a device
 * holds over a sample and gets late, which gives k s^2 (1 + 2 d) for every step s in and out (less d (d + 1)
 * k s^2 at the ends of a way).
 */
#include "lone_stage.h"

#define STIFFNESS 500.0
static const double sample_time = 0.001;

static void open_stage(lone_stage *l, const vxs_effect *effect)
{
    *lone_prepare(l, effect->kind) = *effect;
    CHECK(l->config.coupling.sample_time == sample_time);
    lone_open(l);
}

/* The device at `pose` and a wrench in; what is commanded comes out, and acts next. */
static vxs_wrench run_stage(lone_stage *l, const vxs_pose *pose, const vxs_wrench *wrench, uint32_t points,
                            uint32_t flags)
{
    vxs_tick *tick = lone_tick(l, pose, wrench);
    tick->contact.points = points;
    tick->flags = flags;
    lone_run(l);
    return l->last;
}

static vxs_effect passivity(uint32_t delay, double most_damping, double least_speed)
{
    vxs_effect effect;
    CHECK_INT(vxs_effect_default(VXS_EFFECT_PASSIVITY, &effect), VXS_OK);
    effect.as.passivity.delay = delay;
    effect.as.passivity.most_damping = most_damping;
    effect.as.passivity.least_speed = least_speed;
    return effect;
}

/* A spring that pushes out of x < 0, felt at `depth`. */
static vxs_wrench spring(double depth)
{
    vxs_wrench wrench = {{depth > 0 ? STIFFNESS * depth : 0, 0, 0}, {0, 0, 0}};
    return wrench;
}

/* Observer: n steps in, rest, n steps out, rest. */
static void check_observed(uint32_t delay)
{
    enum { STEPS = 40, REST = 8 };
    const double step = 1e-4;
    lone_stage l;
    vxs_effect effect = passivity(delay, 1, 1e9); /* nothing is fast enough to be damped */
    open_stage(&l, &effect);
    double deepest = 0;
    for (int k = 0; k <= 2 * (STEPS + REST); k++) {
        int in = k < STEPS ? k : k < STEPS + REST ? STEPS : 2 * STEPS + REST - k;
        double depth = step * (in > 0 ? in : 0);
        vxs_pose pose = vxs_pose_identity();
        pose.position[0] = -depth;
        vxs_wrench wrench = spring(depth), out = run_stage(&l, &pose, &wrench, 1, 0);
        CHECK(out.force[0] == wrench.force[0] && l.tick.damping == 0);
        if (k == STEPS + REST) deepest = l.tick.energy;
    }
    double unit = STIFFNESS * step * step, n = STEPS, d = delay;
    double taken = unit * (n - d) * (n - 1 - d) / 2; /* sum of f_(j-1-d) over the way in */
    CHECK_NEAR(deepest, taken, 1e-12);
    CHECK_NEAR(l.tick.energy, -unit * n * (1 + 2 * d) + unit * d * (d + 1), 1e-12);
}

/* Controller on the same spring, out and in along parabolas from a preloaded start: E above its bound, which
 * it breaks without. */
static double least_energy(uint32_t delay, double least_speed, double *bound, int *damped)
{
    enum { HALF = 50, ROUNDS = 400 };
    const double acceleration = 2.0; /* [m/s^2] each way: 0.1 m/s and 5 mm */
    lone_stage l;
    vxs_effect effect = passivity(delay, 1e9, least_speed);
    open_stage(&l, &effect);
    double depth = 0.006, speed = 0, least = 0, most_force = 0;
    *damped = 0;
    for (int k = 0; k < 4 * HALF * ROUNDS; k++) {
        int quarter = k / HALF % 4;
        vxs_pose pose = vxs_pose_identity();
        pose.position[0] = -depth;
        vxs_wrench wrench = spring(depth), out = run_stage(&l, &pose, &wrench, 1, 0);
        most_force = fmax(most_force, fabs(out.force[0]));
        least = fmin(least, l.tick.energy);
        *damped += (l.tick.flags & VXS_SERVO_DAMPED) != 0;
        speed += (quarter == 0 || quarter == 3 ? -1 : 1) * acceleration * sample_time;
        depth += speed * sample_time;
    }
    double d = delay;
    *bound = most_force * acceleration * sample_time * sample_time * (d + 1) * (d + 2) / 2;
    return least;
}

static void check_controlled(uint32_t delay)
{
    double bound, unbound;
    int damped;
    double least = least_energy(delay, 0, &bound, &damped);
    CHECK(least < 0 && least >= -bound * (1 + 1e-9) && damped > 100);
    double without = least_energy(delay, 1e9, &unbound, &damped);
    CHECK(without < -100 * bound && damped == 0);
    printf("delay %u: E at least %.3g J, bound %.3g J; %.3g J without the controller\n", delay, least, -bound,
           without);
}

/* What the damping is: along the motion, capped, none below the least speed; and of a turn. */
static void check_damping(void)
{
    lone_stage l;
    vxs_effect effect = passivity(0, 2, 0.01);
    effect.as.passivity.radius = 0.03;
    open_stage(&l, &effect);
    vxs_wrench push = {{1, 0, 0}, {0, 0, 0}}; /* gives energy: the hand goes its way */
    vxs_pose pose = vxs_pose_identity();
    run_stage(&l, &pose, &push, 1, 0);
    CHECK(l.tick.damping == 0); /* no motion yet */
    pose.position[0] = 3e-5;
    pose.position[1] = 4e-5;
    vxs_wrench out = run_stage(&l, &pose, &push, 1, 0);
    /* given 3e-5 J, and as much in the next sample: a = 6e-5 J T / (5e-5 m)^2 = 24, capped at 2 */
    CHECK_NEAR(l.tick.energy, -3e-5, 1e-18);
    CHECK_NEAR(l.tick.damping, 2, 0);
    CHECK_NEAR(out.force[0], 1 - 2 * 0.03, 1e-12);
    CHECK_NEAR(out.force[1], 0 - 2 * 0.04, 1e-12);
    CHECK(l.tick.flags & VXS_SERVO_DAMPED);
    pose.position[0] += 9e-6; /* 9 mm/s */
    out = run_stage(&l, &pose, &push, 1, 0);
    CHECK(l.tick.damping == 0 && out.force[0] == 1 && l.tick.energy < -3e-5);

    effect.as.passivity.most_damping = 100;
    open_stage(&l, &effect);
    vxs_wrench twist = {{0, 0, 0}, {0, 0, 0.02}};
    pose = vxs_pose_identity();
    run_stage(&l, &pose, &twist, 1, 0);
    pose.orientation[0] = 2 * cos(0.0005); /* 1 mrad about z; the length does not matter */
    pose.orientation[3] = 2 * sin(0.0005);
    out = run_stage(&l, &pose, &twist, 1, 0);
    CHECK_NEAR(l.tick.energy, -2e-5, 1e-11);
    /* a = 4e-5 J T / (0.03 m 1e-3)^2 = 44; torque -= a r^2 w = 44.4 0.0009 1 */
    CHECK_NEAR(l.tick.damping, 4e-8 / 9e-10, 1e-4);
    CHECK_NEAR(out.torque[2], 0.02 - 0.04, 1e-7);
    CHECK_NEAR(out.torque[0], 0, 0);
    /* The same orientation with the other sign is no motion. */
    for (int n = 0; n < 4; n++) pose.orientation[n] *= -1;
    run_stage(&l, &pose, &twist, 1, 0);
    CHECK_NEAR(l.tick.energy, -2e-5, 1e-11);
}

/* Surplus ends with contact, a deficit does not; a decayed command takes nothing. */
static void check_memory(void)
{
    lone_stage l;
    vxs_effect effect = passivity(0, 1e-6, 0);
    vxs_wrench push = {{1, 0, 0}, {0, 0, 0}}, none = {{0, 0, 0}, {0, 0, 0}};
    for (int sign = -1; sign <= 1; sign += 2) {
        open_stage(&l, &effect);
        vxs_pose pose = vxs_pose_identity();
        run_stage(&l, &pose, &push, 1, 0);
        pose.position[0] = sign * 1e-3;
        run_stage(&l, &pose, &push, 0, 0); /* free, but the wrench is not yet zero */
        CHECK_NEAR(l.tick.energy, -sign * 1e-3, 1e-8);
        run_stage(&l, &pose, &none, 0, 0);
        CHECK_NEAR(l.tick.energy, sign > 0 ? -1e-3 : 0, 1e-8);
    }
    open_stage(&l, &effect);
    vxs_pose pose = vxs_pose_identity();
    run_stage(&l, &pose, &push, 1, 0);
    pose.position[0] = -1e-3;
    run_stage(&l, &pose, &push, 1, VXS_SERVO_MISSED);
    CHECK(l.tick.energy == 0);
    pose.position[0] = 0;
    run_stage(&l, &pose, &push, 1, VXS_SERVO_MISSED);
    CHECK_NEAR(l.tick.energy, -1e-3, 1e-8);
}

static void check_refusals(void)
{
    vxs_effect effect = passivity(0, 5, 0);
    CHECK_INT(vxs_effect_check(&effect), VXS_OK);
    const double bad[] = {-1, NAN, INFINITY};
    for (int n = 0; n < 3; n++) {
        effect = passivity(0, bad[n], 0);
        CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
        effect = passivity(0, 5, bad[n]);
        CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
        effect = passivity(0, 5, 0);
        effect.as.passivity.radius = bad[n];
        CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
    }
    effect = passivity(0, 0, 0);
    CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
    effect = passivity(VXS_EFFECT_MAX_DELAY + 1, 5, 0);
    CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
}

int main(void)
{
    for (uint32_t delay = 0; delay < 4; delay++) {
        check_observed(delay);
        check_controlled(delay);
    }
    check_damping();
    check_memory();
    check_refusals();
    return 0;
}
