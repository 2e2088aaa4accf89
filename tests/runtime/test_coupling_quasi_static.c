/* SPDX-License-Identifier: MIT
 *
 * The quasi-static coupling against the balance that can be computed: walls, a wedge, a lever, contact in
 * steps.
 */
#include "check.h"
#include "voxshell/coupling.h"

enum { MAX_PLANES = 3 };

/* Penalty planes that act at a point of the body: force k (offset - n . p) n where that is positive. */
typedef struct plane {
    double normal[3], offset, stiffness;
} plane;
typedef struct room {
    plane planes[MAX_PLANES];
    int count;
    double lever[3]; /* of the point, in the body's frame */
    double step;     /* > 0: depth comes in steps of so much */
    long evaluations;
} room;

static uint8_t memory[1024] __attribute__((aligned(16)));

static vxs_coupling *make(double stiffness, uint32_t evaluations)
{
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = VXS_COUPLING_QUASI_STATIC;
    config.stiffness = stiffness;
    config.radius = 0.02;
    config.evaluations = evaluations;
    vxs_coupling *coupling;
    CHECK(vxs_coupling_memory() <= sizeof memory);
    CHECK_INT(vxs_coupling_init(memory, sizeof memory, &config, &coupling), VXS_OK);
    return coupling;
}

static double touch(room *r, const vxs_pose *body, vxs_wrench *wrench)
{
    double m[9], arm[3], depth = 0;
    memset(wrench, 0, sizeof *wrench);
    r->evaluations++;
    CHECK(vxs_pose_rotation(body, m));
    for (int i = 0; i < 3; i++)
        arm[i] = m[3 * i] * r->lever[0] + m[3 * i + 1] * r->lever[1] + m[3 * i + 2] * r->lever[2];
    for (int n = 0; n < r->count; n++) {
        const plane *p = &r->planes[n];
        double d = p->offset;
        for (int i = 0; i < 3; i++) d -= p->normal[i] * (body->position[i] + arm[i]);
        if (!(d > 0)) continue;
        if (r->step > 0) d = floor(d / r->step + 0.5) * r->step;
        depth = fmax(depth, d);
        double f[3];
        for (int i = 0; i < 3; i++) f[i] = p->stiffness * d * p->normal[i];
        for (int i = 0; i < 3; i++) {
            wrench->force[i] += f[i];
            wrench->torque[i] += arm[(i + 1) % 3] * f[(i + 2) % 3] - arm[(i + 2) % 3] * f[(i + 1) % 3];
        }
    }
    return depth;
}

/* As the servo does. */
static void tick(vxs_coupling *coupling, room *r, const vxs_pose *device, vxs_wrench *contact,
                 vxs_wrench *out)
{
    vxs_pose body;
    double depth;
    long before = r->evaluations;
    do {
        vxs_coupling_pose(coupling, device, &body);
        depth = touch(r, &body, contact);
    } while (vxs_coupling_refine(coupling, contact, depth, device));
    CHECK(r->evaluations - before <= VXS_COUPLING_MAX_EVALUATIONS);
    CHECK_INT(vxs_coupling_step(coupling, contact, device, out), 0);
}

static vxs_pose at(double x, double y)
{
    vxs_pose pose = {{x, y, 0}, {1, 0, 0, 0}};
    return pose;
}

/* Free: at the device exactly, no force, and one evaluation a tick once it is so. */
static void check_free(void)
{
    vxs_coupling *coupling = make(700, 3);
    room r = {.count = 0};
    vxs_wrench contact, out;
    for (int k = 0; k < 1000; k++) {
        vxs_pose device = {{0.1 * k / 3, 1e3 - k, 1e-7 * k * k}, {1, 1e-4 * k, -0.3, 1e-3 * k}};
        tick(coupling, &r, &device, &contact, &out);
        for (int i = 0; i < 3; i++) CHECK(out.force[i] == 0 && out.torque[i] == 0);
    }
    CHECK(r.evaluations <= 1010);
}

/* In and out of a wall at 0.3 m/s, from a tenth to a million times the spring's stiffness: the spring and the
 * wall in series, in every tick from the second in contact on; nothing left behind when it ends. */
static void check_wall(void)
{
    const double k = 700;
    for (uint32_t evaluations = 1; evaluations <= 3; evaluations++) {
        for (double wall = 0.1 * k; wall < 2e6 * k; wall *= 10) {
            vxs_coupling *coupling = make(k, evaluations);
            room r = {.planes = {{{0, 1, 0}, 0, wall}}, .count = 1};
            vxs_wrench contact, out;
            int since = 0, since_free = 0;
            double worst = 0;
            for (int n = 0; n < 400; n++) {
                double depth = 0.0003 * (n < 200 ? n - 100 : 300 - n) - 1e-5;
                vxs_pose device = at(0.01 * n, -depth);
                tick(coupling, &r, &device, &contact, &out);
                double balance = depth > 0 ? k * wall / (k + wall) * depth : 0;
                since = depth > 0 ? since + 1 : 0;
                since_free = depth > 0 ? 0 : since_free + 1;
                if (since > (evaluations == 1 ? 3 : 1))
                    worst = fmax(worst, fabs(out.force[1] - balance) / balance);
                if (since_free > 2) CHECK(out.force[1] == 0);
                CHECK(fabs(out.force[1]) <= k * (fabs(depth) + 0.0006));
                CHECK(out.force[0] == 0 || since_free <= 2);
            }
            printf("wall of %7g springs, %u evaluations: %.2g off at most\n", wall / k, evaluations, worst);
            CHECK(worst < (evaluations == 1 ? 0.05 : 0.01));
        }
    }
}

/* Two stiff planes at 60 degrees hold the body at their edge. */
static void check_wedge(void)
{
    const double c = 0.5, s = sqrt(0.75), k = 500;
    vxs_coupling *coupling = make(k, 3);
    room r = {.planes = {{{s, c, 0}, 0, 1e5}, {{-s, c, 0}, 0, 1e5}}, .count = 2};
    vxs_wrench contact, out;
    for (int n = 0; n < 2000; n++) {
        double depth = 0.005 * fmin(1, (n - 20) / 100.0),
               side = n < 200 ? 0 : 0.001 * fmin(1, (n - 200) / 200.0);
        vxs_pose device = at(side, -depth);
        tick(coupling, &r, &device, &contact, &out);
        CHECK(fabs(out.force[0]) <= 1.5 * k * 0.001 && fabs(out.force[1]) <= 1.5 * k * 0.005);
    }
    /* balance: body at u with 2 c^2 K u_y = k (depth - u_y), 2 s^2 K u_x = k (side - u_x) */
    CHECK_NEAR(out.force[1], k * 0.005 / (1 + k / (2 * c * c * 1e5)), 1e-4);
    CHECK_NEAR(out.force[0], -k * 0.001 / (1 + k / (2 * s * s * 1e5)), 1e-4);
}

/* A force beside the middle turns the body until the spring's torque holds it. */
static void check_lever(void)
{
    const double k = 500, radius = 0.02, arm = 0.03, depth = 0.002;
    vxs_coupling *coupling = make(k, 3);
    room r = {.planes = {{{0, 1, 0}, 0, 1e5}}, .count = 1, .lever = {arm, 0, 0}};
    vxs_wrench contact, out;
    for (int n = 0; n < 500; n++) {
        vxs_pose device = at(0, -depth * fmin(1, n / 100.0));
        tick(coupling, &r, &device, &contact, &out);
    }
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(out.force[i], contact.force[i], 1e-3);
        CHECK_NEAR(out.torque[i], contact.torque[i], 1e-3 * arm);
    }
    /* compliance at the point: 1/K + 1/k + arm^2/(k radius^2), to the square of the turn */
    double force = depth / (1e-5 + 1 / k + arm * arm / (k * radius * radius));
    CHECK_NEAR(out.force[1], force, 0.01 * force);
    CHECK_NEAR(out.torque[2], arm * force, 0.01 * arm * force);
}

/* Depth that comes in steps, as points enter cells. The first one, at half a step, is more than the spring
 * ever holds: there is no balance, and the body must stay at that corner, a quarter of a step at most. */
static void check_steps(void)
{
    const double k = 500, wall = 2e4, step = 0.0005;
    vxs_coupling *coupling = make(k, 3);
    room r = {.planes = {{{0, 1, 0}, 0, wall}}, .count = 1, .step = step};
    vxs_wrench contact, out;
    double worst = 0;
    for (int n = 0; n < 20000; n++) {
        double depth = 0.006 * (n < 10000 ? n / 1e4 : 2 - n / 1e4);
        vxs_pose device = at(0, -depth);
        tick(coupling, &r, &device, &contact, &out);
        if (depth > 0.001) worst = fmax(worst, fabs(out.force[1] - k * (depth - step / 2)));
    }
    printf("contact in steps of %g N: %.3g N off at most, the spring at its end holds %g N\n", wall * step,
           worst, k * 0.006);
    CHECK(worst < k * step / 4);
}

/* A floor whose force comes in steps of depth and leans another way in each cell, by up to 45 degrees:
 * nothing like a slope. The body may hang anywhere that force can hold it against the spring, and nowhere
 * else; and the spring never draws the device against contact. */
static void check_aside(void)
{
    const double k = 400, wall = 2e4, cell = 0.0005;
    vxs_coupling *coupling = make(k, 3);
    double stray = 0, drawn = 0, most = 0;
    for (int n = 0; n < 200000; n++) {
        double t = 1e-3 * n, depth = 0.004 * sin(7 * t);
        vxs_pose device = at(0.01 * sin(t), -depth), body;
        vxs_wrench contact, out;
        double d;
        do {
            vxs_coupling_pose(coupling, &device, &body);
            memset(&contact, 0, sizeof contact);
            d = fmax(0, ceil(-body.position[1] / cell) * cell);
            uint32_t where = (uint32_t)(int32_t)floor(body.position[0] / cell) * 2654435761u ^
                             (uint32_t)(int32_t)floor(body.position[1] / cell) * 2246822519u;
            double lean = (where >> 8 & 0xffff) / 32767.5 - 1;
            contact.force[0] = lean * wall * d;
            contact.force[1] = wall * d;
            stray = fmax(stray,
                         hypot(body.position[0] - device.position[0], body.position[1] - device.position[1]));
            most = fmax(most, hypot(contact.force[0], contact.force[1]));
        } while (vxs_coupling_refine(coupling, &contact, d, &device));
        CHECK_INT(vxs_coupling_step(coupling, &contact, &device, &out), 0);
        drawn = fmin(drawn, out.force[0] * contact.force[0] + out.force[1] * contact.force[1]);
    }
    printf(
        "contact that leans: body %.3g mm from the device at most, the largest force holds it at %.3g mm\n",
        1e3 * stray, 1e3 * most / k);
    CHECK(stray < 2 * 0.004); /* twice as far as the device is in */
    CHECK(drawn > -1e-9);
}

static void check_refusals(void)
{
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = VXS_COUPLING_QUASI_STATIC;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_OK);
    config.evaluations = 0;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_PARAM);
    config.evaluations = VXS_COUPLING_MAX_EVALUATIONS + 1;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_PARAM);
    config.evaluations = 1;
    config.stiffness = NAN;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_IMPEDANCE);
    config.stiffness = 1;
    config.radius = 0;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_IMPEDANCE);
    /* No other kind asks for a second evaluation. */
    const vxs_wrench contact = {{1, 2, 3}, {4, 5, 6}};
    const vxs_pose device = vxs_pose_identity();
    for (uint32_t kind = VXS_COUPLING_NONE; kind < VXS_COUPLING_QUASI_STATIC; kind++) {
        vxs_coupling_config_default(&config);
        config.kind = kind;
        vxs_coupling *coupling;
        CHECK_INT(vxs_coupling_init(memory, sizeof memory, &config, &coupling), VXS_OK);
        CHECK_INT(vxs_coupling_refine(coupling, &contact, 0.001, &device), 0);
    }
    vxs_coupling *coupling = make(500, 3);
    const vxs_wrench bad = {{NAN, 0, 0}, {0, 0, 0}};
    CHECK_INT(vxs_coupling_refine(coupling, &bad, 0.001, &device), 0);
    CHECK(vxs_coupling_refine(coupling, &contact, NAN, &device) != 0);
    vxs_wrench out;
    CHECK_INT(vxs_coupling_step(coupling, &bad, &device, &out), VXS_COUPLING_INVALID);
}

int main(void)
{
    check_free();
    check_wall();
    check_wedge();
    check_lever();
    check_steps();
    check_aside();
    check_refusals();
    return 0;
}
