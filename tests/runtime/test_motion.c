/* SPDX-License-Identifier: MIT
 *
 * Statics that follow keyframes: the way itself, contact there to the last bit, and that only relative
 * velocity counts, of several statics too.
 */
#include "servo_bench.h"
#include "servo_state.h"

static const double pi = 3.14159265358979323846;

static double angle_between(const double a[4], const double b[4])
{
    double turn[3];
    vxs_pose_turn(a, b, turn);
    return 2 * asin(sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]) / 2);
}

static vxs_pose turned_about_z(double x, double y, double angle)
{
    return (vxs_pose){{x, y, 0}, {cos(angle / 2), 0, 0, sin(angle / 2)}};
}

/* A tick of an armed device that is where it is put. */
static uint32_t tick_at(servo_bench *b, double x, double y, vxs_servo_trace *row)
{
    b->state.state = VXS_DEVICE_ARMED;
    b->state.pose = turned_about_z(x, y, 0);
    b->state.sequence++;
    b->state.time_ns += 1000000;
    return vxs_servo_tick(b->servo, &b->state, &b->command, row);
}

static void check_way(int is_loop)
{
    vxs_effect_keyframe frames[] = {{0.1, turned_about_z(1, 2, 0), 0, 0},
                                    {0.3, turned_about_z(1, 2.5, pi / 4), 0, 0},
                                    {1.1, turned_about_z(-1, 2.5, 3 * pi / 4), 0, 0}};
    for (int i = 0; i < 4; i++) frames[1].pose.orientation[i] *= -3; /* the same orientation */
    servo_bench b;
    vxs_servo_trace row;
    bench_prepare(&b);
    vxs_effect *e = bench_effect(&b, VXS_EFFECT_MOTION);
    e->keyframes = frames;
    e->keyframe_count = 3;
    e->as.motion.loop = is_loop;
    bench_open(&b);
    const vxs_pose *at = b.servo->config.statics[0].pose;
    for (int n = 0; n < 5; n++) { /* not armed: at rest */
        b.state.state = VXS_DEVICE_READY;
        b.state.pose = vxs_pose_identity();
        CHECK(vxs_servo_tick(b.servo, &b.state, &b.command, &row) & VXS_SERVO_OFF);
        CHECK(at->position[0] == 1 && at->position[1] == 2);
    }
    double worst = 0, right_angle = 0;
    for (int k = 0; k < 3000; k++) {
        tick_at(&b, 0, 5, &row);
        double t = k * 0.001, x = 1, y = 2, angle = 0;
        if (is_loop) t = (k % 1100) * 0.001;
        if (t > 0.1) y = fmin(2.5, 2 + 2.5 * (t - 0.1)), angle = fmin(1, 5 * (t - 0.1)) * pi / 4;
        if (t > 0.3) x = fmax(-1, 1 - 2.5 * (t - 0.3)), angle = pi / 4 + fmin(1, (t - 0.3) / 0.8) * pi / 2;
        CHECK_NEAR(at->position[0], x, 1e-12);
        CHECK_NEAR(at->position[1], y, 1e-12);
        const vxs_pose wanted = turned_about_z(0, 0, angle);
        double off = angle_between(at->orientation, wanted.orientation);
        if (t <= 0.3)
            worst = fmax(worst, off);
        else
            right_angle = fmax(right_angle, off);
        double length = 0;
        for (int i = 0; i < 4; i++) length += at->orientation[i] * at->orientation[i];
        CHECK_NEAR(length, 1, 1e-14);
        CHECK(at->orientation[1] == 0 && at->orientation[2] == 0);
    }
    printf("off the arc's pace by %.3f degrees for 45, %.3f for 90\n", worst * 180 / pi,
           right_angle * 180 / pi);
    CHECK(worst < 0.12 * pi / 180 && right_angle < 0.95 * pi / 180);
    CHECK(worst > 0.1 * pi / 180 && right_angle > 0.9 * pi / 180); /* the header's figures */
    /* A teleport is as an arming. */
    CHECK(tick_at(&b, 3, 5, &row) & VXS_SERVO_TELEPORT);
    CHECK(at->position[1] == 2);
    bench_close(&b);
}

/* The scene's floor and one beside, which others push it away from. */
typedef struct two_floors {
    servo_bench bench;
    vxs_contact_static statics[2];
    vxs_pose far;
} two_floors;

static void open_floors(two_floors *f, const vxs_effect_keyframe *frames, uint32_t count, uint32_t law)
{
    servo_bench *b = &f->bench;
    bench_prepare(b);
    f->far = turned_about_z(0, 0.0215, pi); /* a ceiling that leaves the ball 1.5 mm of play */
    f->statics[0] = f->statics[1] = b->statics;
    f->statics[1].pose = &f->far;
    b->servo_config.statics = f->statics;
    b->servo_config.static_count = 2;
    b->servo_config.coupling.kind = VXS_COUPLING_NONE;
    b->servo_config.contact.law = law;
    b->servo_config.max_force = 1e9;
    bench_effect(b, VXS_EFFECT_CONTACT_DAMPING)->as.contact_damping.most = 1e3;
    vxs_effect *e = bench_effect(b, VXS_EFFECT_MOTION);
    e->keyframes = frames;
    e->keyframe_count = count;
    bench_open(b);
}

/* Ball against floor, the ball moving, the floor, or both: the same damped wrench. A second static that moves
 * and does not touch changes nothing. */
static void check_relative(uint32_t law)
{
    const double speed = 0.05;
    vxs_effect_keyframe none[] = {{0, turned_about_z(0, 0, 0), 0, 0}, {1, turned_about_z(0, 0, 0), 0, 0}};
    vxs_effect_keyframe all[] = {{0, turned_about_z(0, -speed, 0), 0, 0},
                                 {2, turned_about_z(0, speed, 0), 0, 0},
                                 {0, turned_about_z(0, 5, 0), 1, 0},
                                 {2, turned_about_z(0, 6, pi / 2), 1, 0}};
    vxs_effect_keyframe half[] = {{0, turned_about_z(0, -speed, 0), 0, 0},
                                  {4, turned_about_z(0, speed, 0), 0, 0}};
    two_floors f[3];
    vxs_servo_trace row[3];
    open_floors(&f[0], none, 2, law);
    open_floors(&f[1], all, 4, law);
    open_floors(&f[2], half, 2, law);
    /* Depth grows from -1 mm at speed: heights of the ball over each floor are the same. */
    int touched = 0;
    for (int k = 0; k < 60; k++) {
        double height = 0.011 - speed * 0.001 * k;
        tick_at(&f[0].bench, 0, height, &row[0]);
        tick_at(&f[1].bench, 0, 0.011 - speed, &row[1]);
        tick_at(&f[2].bench, 0, 0.011 - speed - speed / 2 * 0.001 * k, &row[2]);
        if (height < 0.0085) break;
        for (int n = 1; n < 3; n++) {
            CHECK_INT(row[n].points, row[0].points);
            CHECK_NEAR(row[n].output.force[1], row[0].output.force[1], 1e-9 * (1 + row[0].output.force[1]));
        }
        if (k == 0 || !(row[0].collision.force[1] > 0)) continue;
        touched++;
        CHECK_NEAR(row[0].output.force[1] / row[0].collision.force[1], 1 + speed, 1e-4);
    }
    CHECK(touched > 10);
    for (int n = 0; n < 3; n++) bench_close(&f[n].bench);
}

/* Pinched between a floor at rest and a ceiling that comes down, both pushing: the power of each counts. */
static void check_parts(uint32_t law)
{
    const double speed = 0.05;
    vxs_effect_keyframe frames[] = {{0, turned_about_z(0, 0.0190, pi), 1, 0},
                                    {1, turned_about_z(0, 0.0190 - speed, pi), 1, 0}};
    two_floors f;
    vxs_servo_trace row;
    open_floors(&f, frames, 2, law);
    int pinched = 0;
    for (int k = 0; k < 30; k++) {
        tick_at(&f.bench, 0.002, 0.0092, &row);
        const vxs_moving *moving = f.bench.servo->moving;
        const double *lower = moving->parts[0].force, *upper = moving->parts[1].force;
        for (int i = 0; i < 3; i++) {
            CHECK_NEAR(moving->parts[0].force[i] + moving->parts[1].force[i], row.collision.force[i], 1e-12);
            CHECK_NEAR(moving->parts[0].torque[i] + moving->parts[1].torque[i], row.collision.torque[i],
                       1e-12);
        }
        if (k == 0 || !(lower[1] > 0.01 && upper[1] < -0.01)) continue;
        pinched++;
        /* The ceiling's force works at -speed on it: an approach of speed, weighed by its share of the net
         * force. */
        const double *m = row.collision.torque, *net = row.collision.force;
        double size = fmax(sqrt(net[0] * net[0] + net[1] * net[1] + net[2] * net[2]),
                           sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) / f.bench.shell.radius);
        CHECK_NEAR(row.output.force[1], net[1] * fmax(0, 1 - upper[1] * speed / size), 1e-9);
    }
    CHECK(pinched > 10);
    bench_close(&f.bench);
}

static void check_refusals(void)
{
    const vxs_effect_keyframe good[] = {{0, turned_about_z(0, 0, 0), 0, 0},
                                        {1, turned_about_z(1, 0, 0), 0, 0}};
    servo_bench b;
    bench_prepare(&b);
    vxs_effect *e = bench_effect(&b, VXS_EFFECT_MOTION);
    CHECK_INT(vxs_effect_check(e), VXS_PARAM); /* no way */
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    vxs_effect_keyframe frames[2];
    e->keyframes = frames;
    e->keyframe_count = 2;
    for (int n = 0; n < 9; n++) {
        memcpy(frames, good, sizeof frames);
        e->as.motion.loop = 0;
        e->keyframe_count = 2;
        if (n == 1) frames[1].time = 0;
        if (n == 2) frames[0].time = -1;
        if (n == 3) frames[1].time = INFINITY;
        if (n == 4) frames[0].static_index = 1;
        if (n == 5) frames[1].pose.position[2] = NAN;
        if (n == 6) memset(frames[1].pose.orientation, 0, sizeof frames[1].pose.orientation);
        if (n == 7) e->as.motion.loop = 0.5;
        if (n == 8) e->keyframe_count = 0;
        CHECK_INT(vxs_effect_check(e), n ? VXS_PARAM : VXS_OK);
    }
    memcpy(frames, good, sizeof frames);
    e->as.motion.loop = 0;
    e->keyframe_count = 2;
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_OK);
    frames[1].static_index = 1; /* there is no such static */
    CHECK_INT(vxs_servo_config_check(&b.servo_config), VXS_PARAM);
    CHECK_INT(vxs_servo_memory(&b.servo_config), 0);
    built_free(&b.map_bytes);
    built_free(&b.shell_bytes);
}

int main(void)
{
    check_way(0);
    check_way(1);
    for (uint32_t law = VXS_CONTACT_ORIGINAL; law <= VXS_CONTACT_PATCH; law++) {
        if (law == VXS_CONTACT_GRADIENT) continue;
        check_relative(law);
        check_parts(law);
    }
    check_refusals();
    return 0;
}
