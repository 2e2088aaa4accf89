/* SPDX-License-Identifier: MIT
 *
 * A block on a slope, free but for weight, contact and friction: it stays below the angle of friction, and
 * slides above it with g (sin a - mu_k cos a). And what a body cannot be stepped with. Argument: stays
 * only, for so many ticks.
 */
#include "servo_bench.h"

static const double voxel = 0.001, edges[3] = {0.04, 0.01, 0.04}, mass = 0.05, g = 9.80665;

static double plane_distance(const void *shape, const double p[3])
{
    (void)shape;
    return p[1];
}

typedef struct slope_bench {
    servo_bench b;
    vxs_pose tilt;
    vxs_servo_trace row;
} slope_bench;

/* The slope leads down along x; the block stands on it without sinking in. */
static void prepare(slope_bench *s, double angle, uint32_t law)
{
    servo_bench *b = &s->b;
    const int64_t low[3] = {-100, -10, -25}, high[3] = {400, 3, 25};
    const double half[3] = {edges[0] / 2, edges[1] / 2, edges[2] / 2};
    const int count[3] = {10, 4, 10};
    memset(s, 0, sizeof *s);
    bench_prepare(b);
    bench_map(b, build_field_map(voxel, low, high, plane_distance, NULL, 3));
    bench_shell(b, build_block_shell(voxel, half, count));
    s->tilt = (vxs_pose){{0, 0, 0}, {cos(angle / 2), 0, 0, -sin(angle / 2)}};
    b->statics.pose = &s->tilt;
    b->servo_config.contact.law = law;
    b->servo_config.contact.field = VXS_CONTACT_DISTANCE;
    b->servo_config.coupling.kind = VXS_COUPLING_NONE;
    vxs_effect *body = bench_effect(b, VXS_EFFECT_INERTIA);
    body->as.inertia.mass = mass;
    for (int i = 0; i < 3; i++) {
        const double a = edges[(i + 1) % 3], c = edges[(i + 2) % 3];
        body->as.inertia.inertia[i] = mass * (a * a + c * c) / 12;
    }
    body->as.inertia.stiffness = 0;
    bench_effect(b, VXS_EFFECT_GRAVITY)->as.gravity.mass = mass;
    bench_effect(b, VXS_EFFECT_CONTACT_DAMPING)->as.contact_damping.factor = 20;
    vxs_effect *friction = bench_effect(b, VXS_EFFECT_FRICTION);
    friction->as.friction.sticking = 0.5;
    friction->as.friction.sliding = 0.4;
}

static void start(slope_bench *s)
{
    bench_open(&s->b);
    bench_start(&s->b);
    const vxs_pose above = {{0, edges[1] / 2 - 1e-5, 0}, {1, 0, 0, 0}};
    CHECK(vxs_pose_compose(&s->tilt, &above, &s->b.state.pose));
}

/* How far down the slope the middle of the block is. */
static double tick(slope_bench *s)
{
    bench_follow(&s->b, &s->row);
    const double *p = s->row.body.position;
    double r[9];
    CHECK(vxs_pose_rotation(&s->tilt, r));
    return r[0] * p[0] + r[3] * p[1] + r[6] * p[2];
}

/* slow_rise: the slope is level first, and takes the block along as it rises. */
static void check_stays(uint32_t law, double angle, int slow_rise, long ticks)
{
    slope_bench s;
    prepare(&s, slow_rise ? 0 : angle, law);
    start(&s);
    double at = 0, settled = 0, most = 0;
    for (long k = 0; k < 5000; k++) {
        double now = slow_rise ? angle * fmin(1, (double)k / 4000) : angle;
        s.tilt = (vxs_pose){{0, 0, 0}, {cos(now / 2), 0, 0, -sin(now / 2)}};
        settled = tick(&s);
    }
    for (long k = 0; k < ticks; k++) {
        at = tick(&s);
        most = fmax(most, fabs(at - settled));
    }
    printf(
        "law %u: at %.1f degrees of %.1f it settles by %.3g mm and then stays within %.3g um for %ld ticks\n",
        law, angle * 57.29578, atan(0.5) * 57.29578, 1e3 * settled, 1e6 * most, ticks);
    CHECK(most < 1e-6 && settled < 1e-3);
    bench_close(&s.b);
}

static void check_slides(uint32_t law, double angle)
{
    slope_bench s;
    prepare(&s, angle, law);
    start(&s);
    double at[3] = {0, 0, 0};
    for (int k = 0; k < 600; k++) {
        double now = tick(&s);
        if (k == 199) at[0] = now;
        if (k == 399) at[1] = now;
        if (k == 599) at[2] = now;
    }
    double acceleration = (at[2] - 2 * at[1] + at[0]) / 0.04, wanted = g * (sin(angle) - 0.4 * cos(angle));
    printf("law %u: at %.1f degrees it slides with %.4f m/s^2 of %.4f\n", law, angle * 57.29578, acceleration,
           wanted);
    CHECK_NEAR(acceleration, wanted, 0.02 * wanted);
    bench_close(&s.b);
}

/* A ball on a floor far stiffer than it can be stepped with: it goes on bouncing as high as it began, or
 * lower and lower with contact-damping as it is by default. */
static void check_bounces(double height, double factor)
{
    slope_bench s;
    prepare(&s, 0, VXS_CONTACT_GRADIENT);
    servo_bench *b = &s.b;
    bench_shell(b, build_ball_shell(voxel, 0.01, 2000));
    b->servo_config.contact.stiffness = 1e12;
    for (int i = 0; i < 3; i++) b->effects[0].as.inertia.inertia[i] = 0.4 * mass * 1e-4;
    b->effects[2].as.contact_damping.factor = factor;
    b->servo_config.effect_count = 3; /* no friction */
    start(&s);
    b->state.pose.position[1] = 0.01 + height;
    double top = 0, last = height, lowest = 0, before = 0, worst = 0;
    int bounces = 0;
    const long ticks = check_length(10000, 3000);
    for (long k = 0; k < ticks; k++) {
        tick(&s);
        const double now = s.row.body.position[1] - 0.01;
        if (before < last && now <= last && k > 5) {
            bounces++;
            worst = fmax(worst, last / height - 1);
            if (factor > 0 && bounces > 1 && last > 0) CHECK(last < top);
            top = last;
        }
        before = last;
        last = now;
        lowest = fmin(lowest, now);
    }
    printf("bounces from %g mm, contact-damping %g s/m: %d times in %ld s, up to %+.1f %% of it, in the end "
           "%.3g mm, %.2g mm "
           "deep\n",
           1e3 * height, factor, bounces, ticks / 1000, 100 * worst, 1e3 * top, -1e3 * lowest);
    CHECK(bounces > 20 && worst < 0.1); /* a tenth of a per cent a bounce */
    bench_close(&s.b);
}

static void check_refusals(void)
{
    slope_bench s;
    prepare(&s, 0.1, VXS_CONTACT_PATCH);
    vxs_servo_config *config = &s.b.servo_config;
    CHECK_INT(vxs_servo_config_check(config), VXS_OK);
    config->coupling.kind = VXS_COUPLING_SPRING_DAMPER;
    CHECK_INT(vxs_servo_config_check(config), VXS_TWO_BODIES);
    config->coupling.kind = VXS_COUPLING_QUASI_STATIC;
    CHECK_INT(vxs_servo_config_check(config), VXS_TWO_BODIES);
    config->coupling.kind = VXS_COUPLING_PT2;
    CHECK_INT(vxs_servo_config_check(config), VXS_OK);
    vxs_effect *friction = &s.b.effects[3];
    friction->as.friction.stiffness = 1e5;
    CHECK_INT(vxs_servo_config_check(config), VXS_TOO_STIFF);
    friction->as.friction.stiffness = 1000;
    friction->as.friction.damping = 100;
    CHECK_INT(vxs_servo_config_check(config), VXS_TOO_STIFF);
    friction->as.friction.damping = 1;
    vxs_effect *drag = bench_effect(&s.b, VXS_EFFECT_VISCOSITY);
    CHECK_INT(vxs_servo_config_check(config), VXS_OK);
    drag->as.viscosity.damping = 100;
    CHECK_INT(vxs_servo_config_check(config), VXS_TOO_STIFF);
    s.b.effects[0] = s.b.effects[1]; /* without inertia nothing is too stiff */
    config->effect_count = 4;
    s.b.effects[1].kind = VXS_EFFECT_START_INSIDE;
    CHECK_INT(vxs_effect_default(VXS_EFFECT_START_INSIDE, &s.b.effects[1]), VXS_OK);
    CHECK_INT(vxs_servo_config_check(config), VXS_OK);
    built_free(&s.b.map_bytes);
    built_free(&s.b.shell_bytes);
}

int main(int count, char **arguments)
{
    if (count > 1) {
        check_stays(VXS_CONTACT_GRADIENT, 0.45, 1, atol(arguments[1]));
        return 0;
    }
    check_refusals();
    check_bounces(0.009, 1);
    const long ticks = check_length(30000, 1000);
    if (check_length(1, 0)) {
        check_bounces(0.009, 0);
        check_bounces(0.003, 0);
        check_stays(VXS_CONTACT_GRADIENT, 0.3, 0, ticks);
    }
    check_stays(VXS_CONTACT_GRADIENT, 0.45, 1, ticks);
    check_stays(VXS_CONTACT_PATCH, 0.3, 0, ticks);
    /* gradient: its normal is the slope's, and not that of a block that leans. */
    check_slides(VXS_CONTACT_GRADIENT, 0.5);
    check_slides(VXS_CONTACT_GRADIENT, 0.6);
    return 0;
}
