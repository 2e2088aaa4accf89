/* SPDX-License-Identifier: MIT
 *
 * Friction's stage on its own: a spring below the cone, the cone beyond it, both about the normal too,
 * carried along by a static that moves; and never more energy given than taken, on walks with loads that
 * come, go and change. Argument: how many steps of the walks.
 */
#include "check.h"
#include "servo_state.h"

static const double sample_time = 0.001;
static _Alignas(16) uint8_t memory[1 << 17];

typedef struct lone_stage {
    const vxs_effect_kind *stage;
    vxs_contact_loads *loads;
    vxs_contact_static statics[3];
    vxs_pose poses[3];
    vxs_tick tick;
} lone_stage;

static void open_stage(lone_stage *l, double sticking, double sliding, double stiffness, double damping)
{
    vxs_effect effect;
    vxs_servo_config config;
    memset(l, 0, sizeof *l);
    memset(memory, 0, sizeof memory);
    CHECK_INT(vxs_effect_default(VXS_EFFECT_FRICTION, &effect), VXS_OK);
    effect.as.friction.sticking = sticking;
    effect.as.friction.sliding = sliding;
    effect.as.friction.stiffness = stiffness;
    effect.as.friction.damping = damping;
    CHECK_INT(vxs_effect_check(&effect), VXS_OK);
    vxs_servo_config_default(&config);
    config.coupling.sample_time = sample_time;
    config.statics = l->statics;
    config.static_count = 3;
    for (int n = 0; n < 3; n++) l->poses[n] = vxs_pose_identity();
    l->stage = vxsi_stage_of(VXS_EFFECT_FRICTION);
    CHECK(l->stage && l->stage->size <= sizeof memory);
    l->stage->set_up(memory, &effect, &config);
    static vxs_servo servo;
    l->stage->attach(memory, &servo);
    l->loads = servo.config.contact.loads;
    l->tick.body = vxs_pose_identity();
    l->tick.elapsed = sample_time;
    l->stage->reset(memory, &l->tick.body);
}

/* What friction adds. */
static vxs_wrench run_stage(lone_stage *l)
{
    memset(&l->tick.wrench, 0, sizeof l->tick.wrench);
    l->stage->add(memory, &l->tick);
    return l->tick.wrench;
}

/* A load on static 0 with its normal along y. */
static vxs_contact_load *one_load(lone_stage *l, double force, double radius)
{
    l->loads->count = 1;
    l->loads->load[0] =
        (vxs_contact_load){.direction = 5, .force = force, .normal = {0, 1, 0}, .radius = radius};
    return l->loads->load;
}

static double dot(const double a[3], const double b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

static double length(const double v[3])
{
    return sqrt(dot(v, v));
}

static void turn_body(vxs_pose *pose, const double axis[3], double angle)
{
    vxs_pose turn = vxs_pose_identity(), turned = *pose;
    turn.orientation[0] = cos(angle / 2);
    for (int i = 0; i < 3; i++) turn.orientation[1 + i] = sin(angle / 2) * axis[i];
    CHECK(vxs_pose_compose(&turn, pose, &turned));
    memcpy(pose->orientation, turned.orientation, sizeof pose->orientation);
}

/* Stiffness below the cone, mu_s N at its edge, mu_k N beyond it and back again. */
static void check_cone(void)
{
    lone_stage l;
    open_stage(&l, 0.5, 0.4, 2000, 0);
    one_load(&l, 3, 0.01);
    CHECK_NEAR(length(run_stage(&l).force), 0, 0);
    double most = 0, slip = 0;
    for (int k = 1; k <= 2000; k++) {
        l.tick.body.position[0] = 1e-6 * k;
        l.tick.body.position[1] = 1e-4 * (k % 7); /* along the normal: nothing */
        vxs_wrench w = run_stage(&l);
        CHECK(w.force[1] == 0 && w.force[2] == 0 && w.force[0] < 0);
        if (k <= 750) CHECK_NEAR(w.force[0], -2000 * 1e-6 * k, 1e-12); /* up to 1.5 N */
        if (k > 751) CHECK_NEAR(w.force[0], -1.2, 1e-12);
        most = fmax(most, -w.force[0]);
        slip = -w.force[0];
    }
    CHECK_NEAR(most, 1.5, 2.1e-3);
    printf("friction: sticks to %.4f N of 1.5, slides at %.6f N of 1.2\n", most, slip);
    for (int k = 1; k <= 1200; k++) { /* back: the spring of 1.2 N lets go and holds the other way */
        l.tick.body.position[0] -= 1e-6;
        CHECK_NEAR(run_stage(&l).force[0], -1.2 + 2e-3 * k, 1e-11);
    }
    one_load(&l, 1, 0.01); /* pressed less, it gives way at once; pressed again, it stays as it is */
    CHECK_NEAR(run_stage(&l).force[0], 0.4, 1e-12);
    one_load(&l, 3, 0.01);
    CHECK_NEAR(run_stage(&l).force[0], 0.4, 1e-12);
    l.loads->count = 0; /* lifted: forgotten */
    CHECK(length(run_stage(&l).force) == 0);
    one_load(&l, 3, 0.01);
    CHECK(length(run_stage(&l).force) == 0);
}

/* Where contact-damping has made more or less of contact, the cone is as much wider or narrower. */
static void check_damped_contact(void)
{
    lone_stage l;
    open_stage(&l, 0.5, 0.4, 2000, 0);
    l.tick.contact.wrench = (vxs_wrench){{0, 3, 0}, {0.1, 0, 0}};
    one_load(&l, 3, 0.01);
    for (int k = 0; k < 40; k++) {
        const double share = 0.1 * (k % 20);
        l.tick.body.position[0] += 1e-2;
        l.tick.wrench = (vxs_wrench){{0, 3 * share, 0}, {0.1 * share, 0, 0}};
        l.stage->add(memory, &l.tick);
        if (k > 0) CHECK_NEAR(l.tick.wrench.force[0], -0.4 * 3 * share, 1e-12);
        CHECK(l.tick.wrench.force[1] == 3 * share);
    }
}

/* The damper is within the cone too. */
static void check_damping(void)
{
    lone_stage l;
    open_stage(&l, 0.5, 0.5, 2000, 4);
    one_load(&l, 3, 0.01);
    run_stage(&l);
    l.tick.body.position[0] = 1e-4;
    CHECK_NEAR(run_stage(&l).force[0], -(0.2 + 0.4), 1e-12); /* k x + b v */
    CHECK_NEAR(run_stage(&l).force[0], -0.2, 1e-12);
    l.tick.body.position[0] = 5e-4;
    CHECK_NEAR(run_stage(&l).force[0], -1.5, 1e-12);
    for (int k = 0; k < 3; k++) CHECK(run_stage(&l).force[0] > -1.5);
}

/* Twist: k_t r^2 below, mu N r beyond; with a slide at the same time it shares the cone. */
static void check_twist(void)
{
    lone_stage l;
    const double up[3] = {0, 1, 0};
    open_stage(&l, 0.5, 0.5, 2000, 0);
    vxs_contact_load *load = one_load(&l, 3, 0.01);
    load->arm[0] = 0.02;
    l.tick.body.position[0] = -0.02; /* the centre of pressure stays at the origin */
    run_stage(&l);
    for (int k = 1; k <= 200; k++) {
        const double angle = 0.001 * k;
        l.tick.body = vxs_pose_identity();
        turn_body(&l.tick.body, up, angle);
        l.tick.body.position[0] = -0.02 * cos(angle);
        l.tick.body.position[2] = 0.02 * sin(angle);
        load->arm[0] = 0.02 * cos(angle);
        load->arm[2] = -0.02 * sin(angle);
        vxs_wrench w = run_stage(&l);
        CHECK_NEAR(length(w.force), 0, 0.02 * 1.5); /* an arc, in steps */
        double torque = w.torque[1] - (load->arm[2] * w.force[0] - load->arm[0] * w.force[2]);
        CHECK_NEAR(torque, -fmin(2000 * 1e-4 * angle, 1.5 * 0.01), 1e-5);
    }
    /* A body that slides and turns: neither is as strong as alone. */
    for (int k = 0; k < 200; k++) {
        turn_body(&l.tick.body, up, 0.01);
        l.tick.body.position[2] += 1e-4;
        load->arm[0] = load->arm[2] = 0;
        vxs_wrench w = run_stage(&l);
        if (k < 150) continue;
        CHECK_NEAR(w.force[2], -1.5 * sqrt(0.5), 1e-5);
        CHECK_NEAR(w.torque[1], -1.5 * 0.01 * sqrt(0.5), 1e-7);
    }
}

/* A static that moves takes the object along as one that rests holds it. */
static void check_moving_static(void)
{
    lone_stage still, moving;
    vxs_wrench w;
    const double axis[3] = {0, 1, 0};
    open_stage(&still, 0.5, 0.4, 2000, 1);
    one_load(&still, 3, 0.01)->arm[2] = 0.03;
    run_stage(&still);
    still.tick.body.position[0] = -2e-4;
    w = run_stage(&still);
    open_stage(&moving, 0.5, 0.4, 2000, 1);
    moving.statics[0].pose = &moving.poses[0];
    one_load(&moving, 3, 0.01)->arm[2] = 0.03;
    run_stage(&moving);
    moving.poses[0].position[0] = 2e-4;
    vxs_wrench v = run_stage(&moving);
    CHECK(memcmp(&w, &v, sizeof w) == 0 && v.force[0] > 0.4);
    /* Both turn together about a far axis: a force that stands in the static's frame. */
    moving.loads->load[0].arm[2] = 0;
    w = run_stage(&moving);
    for (int k = 0; k < 1000; k++) {
        turn_body(&moving.tick.body, axis, 0.002);
        double c = cos(0.002), s = sin(0.002), *p = moving.tick.body.position, x = p[0];
        p[0] = c * x + s * p[2];
        p[2] = -s * x + c * p[2];
        turn_body(&moving.poses[0], axis, 0.002);
        p = moving.poses[0].position, x = p[0];
        p[0] = c * x + s * p[2];
        p[2] = -s * x + c * p[2];
        v = run_stage(&moving);
    }
    CHECK_NEAR(length(v.force), length(w.force), 1e-6 * length(w.force));
    CHECK_NEAR(v.force[0], w.force[0] * cos(2) + w.force[2] * sin(2), 1e-5);
    CHECK_NEAR(v.force[2], -w.force[0] * sin(2) + w.force[2] * cos(2), 1e-5);
}

/* Contact goes over from one direction to the next, as on a ball that rolls: nothing jumps and nothing is
 * lost. */
static void check_hand_over(void)
{
    lone_stage l;
    open_stage(&l, 0.5, 0.4, 2000, 0);
    one_load(&l, 3, 0.01);
    run_stage(&l);
    l.tick.body.position[0] = 4e-4;
    vxs_wrench w = run_stage(&l);
    CHECK_NEAR(w.force[0], -0.8, 1e-12);
    for (uint32_t direction = 6; direction < 90; direction++) {
        for (int part = 0; part <= 4; part++) {
            l.loads->count = 0;
            for (int side = 0; side < 2; side++) {
                double force = 3 * (side ? part / 4.0 : 1 - part / 4.0);
                if (force == 0) continue;
                l.loads->load[l.loads->count++] =
                    (vxs_contact_load){.at = direction > 30 && side ? 1 : direction > 31,
                                       .direction = direction - 1 + (uint32_t)side,
                                       .force = force,
                                       .normal = {0, 1, 0},
                                       .radius = 0.01};
            }
            CHECK_NEAR(run_stage(&l).force[0], -0.8, 1e-12);
        }
    }
}

static uint32_t next_random(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    return *state ^= *state << 5;
}

static double uniform(uint32_t *state)
{
    return (next_random(state) >> 8) * 0x1p-24;
}

static double around(uint32_t *state)
{
    return 2 * uniform(state) - 1;
}

static void point_before(const vxs_pose *now, const vxs_pose *before, const double point[3], double out[3])
{
    double r[9], s[9], v[3];
    CHECK(vxs_pose_rotation(now, r) && vxs_pose_rotation(before, s));
    for (int i = 0; i < 3; i++) {
        v[i] = 0;
        for (int j = 0; j < 3; j++) v[i] += r[3 * j + i] * (point[j] - now->position[j]);
    }
    for (int i = 0; i < 3; i++) out[i] = dot(s + 3 * i, v) + before->position[i];
}

/* Of the only load's force, at the point that is at its centre now, and of its twist. */
static double work_of_one(const lone_stage *l, const vxs_wrench *w, const vxs_pose *body,
                          const vxs_pose *ground, const double turn[3])
{
    const vxs_contact_load *load = l->loads->load;
    double center[3], was[3], under[3], work = 0;
    for (int i = 0; i < 3; i++) center[i] = l->tick.body.position[i] + load->arm[i];
    point_before(&l->tick.body, body, center, was);
    point_before(&l->poses[0], ground, center, under);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        work -= w->force[i] * (under[i] - was[i]);
        work -= (w->torque[i] - (load->arm[j] * w->force[k] - load->arm[k] * w->force[j])) * turn[i];
    }
    return work;
}

/* A walk in contact: what the object's motion against the (moving) static gave, never below 0, whatever the
 * loads do. The wrench at a tick's end takes work over the tick. Returns the least sum over what passed. */
static double walk(uint32_t seed, long steps, int most_loads, double damping, int has_moving,
                   double *dissipated)
{
    lone_stage l;
    int is_gripping = seed % 2; /* never slides, so that nothing hides what the anchors hand over */
    open_stage(&l, is_gripping ? 10 : 0.5, is_gripping ? 10 : 0.4, 3000, damping);
    if (has_moving) l.statics[0].pose = l.statics[1].pose = l.statics[2].pose = &l.poses[0];
    uint32_t random = seed;
    double taken = 0, passed = 0, least = 0, stored = 0;
    for (long k = 0; k < steps; k++) {
        vxs_pose body = l.tick.body, ground = l.poses[0];
        double axis[3] = {around(&random), around(&random), around(&random)};
        double size = length(axis), fast = !is_gripping && k / 500 % 3 == 0 ? 1e-3 : 2e-5;
        for (int i = 0; i < 3; i++) {
            axis[i] /= size;
            l.tick.body.position[i] += fast * around(&random);
            if (has_moving) l.poses[0].position[i] += 1e-5 * around(&random);
        }
        turn_body(&l.tick.body, axis, 20 * fast * around(&random));
        if (has_moving) turn_body(&l.poses[0], axis, 1e-3 * around(&random));
        l.loads->count = 0;
        int is_lifted = k % 700 > 680;
        for (int n = 0; n < most_loads && !is_lifted; n++) {
            if (most_loads > 1 && uniform(&random) < 0.2) continue;
            vxs_contact_load *load = &l.loads->load[l.loads->count++];
            load->at = (uint32_t)(n % 3 == 2 ? 1 : 0) + (n > 5);
            load->direction = (uint32_t)(3 * n + 1);
            if (n > 0 && load->at < load[-1].at) load->at = load[-1].at;
            load->force = is_gripping              ? 5 + uniform(&random)
                          : uniform(&random) < 0.1 ? 1e-9
                                                   : 1e-9 + 5 * uniform(&random);
            load->radius = 0.001 + 0.01 * uniform(&random);
            double slant = most_loads > 1 ? 6.28 * n / most_loads : 0, wobble = 0.05 * around(&random);
            load->normal[0] = sin(slant + wobble);
            load->normal[1] = cos(slant + wobble);
            load->normal[2] = 0;
            for (int i = 0; i < 3; i++) load->arm[i] = 0.02 * around(&random);
        }
        vxs_wrench w = run_stage(&l);
        CHECK(isfinite(dot(w.force, w.force) + dot(w.torque, w.torque)));
        double turn[3], ground_turn[3], way[3], work = 0;
        vxs_pose_turn(body.orientation, l.tick.body.orientation, turn);
        vxs_pose_turn(ground.orientation, l.poses[0].orientation, ground_turn);
        double arm[3];
        for (int i = 0; i < 3; i++) arm[i] = l.tick.body.position[i] - l.poses[0].position[i];
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, m = (i + 2) % 3;
            way[i] = l.tick.body.position[i] - body.position[i] -
                     (l.poses[0].position[i] - ground.position[i] + ground_turn[j] * arm[m] -
                      ground_turn[m] * arm[j]);
            turn[i] -= ground_turn[i];
        }
        work = -(dot(w.force, way) + dot(w.torque, turn));
        if (most_loads == 1 && l.loads->count) work = work_of_one(&l, &w, &body, &ground, turn);
        taken += work;
        passed += fabs(work);
        least = fmin(least, taken);
        /* With one load, what is stored can be told from the wrench: no tick gives more than it had. */
        if (most_loads == 1 && damping == 0) {
            double now = 0;
            if (l.loads->count) {
                const vxs_contact_load *load = l.loads->load;
                double lever[3], twist;
                for (int i = 0; i < 3; i++)
                    lever[i] = w.torque[i] - (load->arm[(i + 1) % 3] * w.force[(i + 2) % 3] -
                                              load->arm[(i + 2) % 3] * w.force[(i + 1) % 3]);
                twist = length(lever) / load->radius;
                now = (dot(w.force, w.force) + twist * twist) / (2 * 3000);
            }
            CHECK(work - (now - stored) >= -1e-9 * passed);
            stored = now;
        }
    }
    *dissipated = taken;
    return passed > 0 ? least / passed : -1;
}

static void check_energy(long steps)
{
    double worst = 0, taken;
    int count = 0;
    for (uint32_t seed = 1; seed <= 6; seed++) {
        for (int loads = 1; loads <= 12; loads += loads == 1 ? 2 : 9) {
            for (int damping = 0; damping < 2; damping++) {
                for (int moving = 0; moving < 2; moving++, count++) {
                    double least =
                        walk(77 * seed + 2 * (uint32_t)loads, steps, loads, 2 * damping, moving, &taken);
                    CHECK(least >= -1e-9 && taken >= 0);
                    worst = fmin(worst, least);
                }
            }
        }
    }
    printf("friction: %d walks of %ld steps, least energy taken %.3g of what passed\n", count, steps, worst);
}

/* Pulls one wall while another bears the load, loads it, and lets go: stiffer on the way back, it would drive
 * a motor. */
static void check_pump(void)
{
    lone_stage l;
    open_stage(&l, 5, 5, 2000, 0);
    double taken = 0;
    for (int k = 0; k < 40000; k++) {
        const int phase = k % 40, is_loaded = phase >= 20; /* on the way back */
        const double last = l.tick.body.position[0];
        l.tick.body.position[0] = 1e-5 * (phase < 20 ? phase : 39 - phase);
        l.loads->count = 2;
        for (uint32_t n = 0; n < 2; n++)
            l.loads->load[n] = (vxs_contact_load){
                .direction = n, .force = (int)n == is_loaded ? 0.5 : 5, .normal = {n, !n, 0}, .radius = 0.01};
        taken -= run_stage(&l).force[0] * (l.tick.body.position[0] - last);
        CHECK(taken >= 0);
    }
}

/* Small circles below the cone give all of it back. */
static void check_closed_path(void)
{
    lone_stage l;
    open_stage(&l, 0.5, 0.4, 2000, 0);
    one_load(&l, 3, 0.01);
    run_stage(&l);
    double taken = 0, last[3] = {0, 0, 0};
    vxs_wrench w, before = {{0, 0, 0}, {0, 0, 0}};
    const long steps = check_length(100000, 10000);
    for (long k = 1; k <= steps; k++) {
        double angle = 6.283185307179586 * (double)k / 1000;
        double at[3] = {3e-4 * (1 - cos(angle)), 0, 3e-4 * sin(angle)};
        memcpy(l.tick.body.position, at, sizeof at);
        w = run_stage(&l);
        for (int i = 0; i < 3; i++) taken -= 0.5 * (w.force[i] + before.force[i]) * (at[i] - last[i]);
        memcpy(last, at, sizeof at);
        before = w;
    }
    CHECK_NEAR(taken, 0, 1e-15);
    CHECK_NEAR(length(w.force), 0, 1e-12); /* and after all rounds it is where it was */
}

int main(int count, char **arguments)
{
    vxs_effect wrong;
    CHECK_INT(vxs_effect_default(VXS_EFFECT_FRICTION, &wrong), VXS_OK);
    wrong.as.friction.sliding = 0.41; /* slides harder than it sticks */
    CHECK_INT(vxs_effect_check(&wrong), VXS_PARAM);
    check_cone();
    check_damped_contact();
    check_damping();
    check_twist();
    check_moving_static();
    check_hand_over();
    check_pump();
    check_closed_path();
    check_energy(count > 1 ? atol(arguments[1]) : check_length(5000, 500));
    return 0;
}
