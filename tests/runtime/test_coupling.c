/* SPDX-License-Identifier: MIT
 *
 * The PT2 against published coefficients, its own difference equation, the continuous step
 * response and its gain at rest; extreme parameters; what is refused, by name.
 */
#include "check.h"
#include "voxshell/coupling.h"

static const double pi = 3.14159265358979323846;
static uint8_t memory[1024] __attribute__((aligned(16)));

static vxs_coupling *make(const vxs_coupling_config *config)
{
    vxs_coupling *coupling;
    CHECK(vxs_coupling_memory() <= sizeof memory);
    CHECK_INT(vxs_coupling_init(memory, sizeof memory, config, &coupling), VXS_OK);
    return coupling;
}

static vxs_coupling_config pt2(double hertz, double damping, double sample_time)
{
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.omega0 = 2 * pi * hertz;
    config.damping = damping;
    config.sample_time = sample_time;
    return config;
}

static double push(vxs_coupling *coupling, double force)
{
    vxs_pose device = vxs_pose_identity();
    vxs_wrench in = {{force, 2 * force, -force}, {0, force, 3 * force}}, out;
    CHECK_INT(vxs_coupling_step(coupling, &in, &device, &out), 0);
    CHECK_NEAR(out.force[1], 2 * out.force[0], 1e-9 * (1 + fabs(out.force[0])));
    CHECK_NEAR(out.torque[1], out.force[0], 0);
    CHECK(out.torque[0] == 0);
    return out.force[0];
}

static void check_coefficients(void)
{
    vxs_coupling_config config = pt2(5, 1, 0.001);
    vxs_coupling_coefficients c;
    CHECK_INT(vxs_coupling_design(&config, &c), VXS_OK);
    CHECK_NEAR(c.b0, 2.391674313750438e-04, 1e-12);
    CHECK_NEAR(c.b1, 2 * 2.391674313750438e-04, 1e-12);
    CHECK_NEAR(c.b2, 2.391674313750438e-04, 1e-12);
    CHECK_NEAR(c.a1, -1.938139843986612, 1e-12);
    CHECK_NEAR(c.a2, 0.939096513712112, 1e-12);

    /* The step is that difference equation. */
    const double set[][3] = {
        {5, 1, 0.001}, {50, 0.3, 0.001}, {480, 0.707, 0.001}, {0.5, 2, 0.01}, {1000, 0.05, 0.0001}};
    for (size_t n = 0; n < sizeof set / sizeof *set; n++) {
        config = pt2(set[n][0], set[n][1], set[n][2]);
        CHECK_INT(vxs_coupling_design(&config, &c), VXS_OK);
        vxs_coupling *coupling = make(&config);
        double u1 = 0, u2 = 0, y1 = 0, y2 = 0;
        for (int k = 0; k < 5000; k++) {
            double u = k % 700 < 300 ? 1 + 0.3 * sin(0.1 * k) : -0.5;
            double y = c.b0 * u + c.b1 * u1 + c.b2 * u2 - c.a1 * y1 - c.a2 * y2;
            CHECK_NEAR(push(coupling, u), y, 1e-8);
            u2 = u1, u1 = u, y2 = y1, y1 = y;
        }
    }
}

/* Critically damped: y(t) = 1 - (1 + w0 t) exp(-w0 t). */
static void check_step_response(void)
{
    vxs_coupling_config config = pt2(5, 1, 0.001);
    vxs_coupling *coupling = make(&config);
    for (int k = 0; k < 2000; k++) {
        double t = (k + 0.5) * 0.001, w = config.omega0; /* Tustin centres the step */
        CHECK_NEAR(push(coupling, 1), 1 - (1 + w * t) * exp(-w * t), 2e-4);
    }
    vxs_pose device = vxs_pose_identity();
    vxs_coupling_reset(coupling, &device);
    CHECK(push(coupling, 0) == 0);
}

/* Amplitude at w0 is K / 2d: exactly with pre-warping, lower without. */
static void check_prewarp(void)
{
    for (uint32_t prewarp = 0; prewarp < 2; prewarp++) {
        vxs_coupling_config config = pt2(200, 0.5, 0.001);
        config.prewarp = prewarp;
        config.gain = 3;
        vxs_coupling *coupling = make(&config);
        double peak = 0;
        for (int k = 0; k < 4000; k++) {
            double y = push(coupling, sin(config.omega0 * 0.001 * k));
            if (k > 3000) peak = fmax(peak, fabs(y));
        }
        if (prewarp)
            CHECK_NEAR(peak, 3, 0.15); /* five samples a period: the peak falls between them */
        else
            CHECK(peak < 2.8);
    }
}

static void check_gain_at_rest(void)
{
    const double hertz[] = {0.05, 0.3, 5, 50, 480}, damping[] = {0.05, 0.7, 1, 10};
    for (int i = 0; i < 5; i++) {
        for (int j = 0; j < 4; j++) {
            vxs_coupling_config config = pt2(hertz[i], damping[j], 0.001);
            vxs_coupling *coupling = make(&config);
            double y = 0, slowest = hertz[i] * fmin(damping[j], 0.5 / damping[j]);
            long steps = (long)(6000 / slowest) + 10000;
            for (long k = 0; k < steps; k++) y = push(coupling, 7);
            CHECK_NEAR(y, 7, 1e-9);
        }
    }
}

/* Any parameter that is accepted dies away, never grows, and ends at exactly zero. */
static void check_extremes(void)
{
    const double times[] = {1e-5, 1e-4, 1e-3, 0.1}, damping[] = {1e-3, 0.1, 1, 1e3};
    const long ticks = check_length(20000, 5000);
    for (int t = 0; t < 4; t++) {
        const double hertz[] = {0.05, 0.01 / times[t], 0.3 / times[t], 0.49 / times[t]};
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) {
                vxs_coupling_config config = pt2(hertz[i], damping[j], times[t]);
                if (hertz[i] < 0.05) continue;
                vxs_coupling_coefficients c;
                CHECK_INT(vxs_coupling_design(&config, &c), VXS_OK);
                CHECK(c.a2 < 1 && 1 + c.a1 + c.a2 > 0 && 1 - c.a1 + c.a2 > 0); /* Jury */
                vxs_coupling *coupling = make(&config);
                double peak = 0;
                for (long k = 0; k < ticks; k++) peak = fmax(peak, fabs(push(coupling, k < 100 ? 1e3 : 0)));
                CHECK(peak < 2.1e3);
            }
        }
    }
    vxs_coupling_config config = pt2(50, 1, 0.001);
    vxs_coupling *coupling = make(&config);
    push(coupling, 5);
    double y = 1;
    for (int k = 0; k < 4000; k++) y = push(coupling, 0);
    CHECK(y == 0); /* and no denormal on the way: the state was cut at 1e-150 */
    CHECK(push(coupling, 1e-200) == 0);
}

static void check_not_finite(void)
{
    vxs_pose device = vxs_pose_identity();
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_QUASI_STATIC; kind++) {
        vxs_coupling_config config = pt2(5, 1, 0.001);
        config.kind = kind;
        vxs_coupling *coupling = make(&config);
        vxs_wrench out, in = {{1, 0, 0}, {0, 0, 0}};
        CHECK_INT(vxs_coupling_step(coupling, &in, &device, &out), 0);
        const double bad[] = {NAN, INFINITY, -INFINITY};
        for (int n = 0; n < 3; n++) {
            in.torque[2] = bad[n];
            CHECK_INT(vxs_coupling_step(coupling, &in, &device, &out), VXS_COUPLING_INVALID);
            CHECK(out.force[0] == 0 && out.torque[2] == 0);
        }
        memset(&in, 0, sizeof in); /* nothing stuck: at rest again */
        CHECK_INT(vxs_coupling_step(coupling, &in, &device, &out), 0);
        CHECK(out.force[0] == 0 && out.torque[2] == 0);
        vxs_pose broken = {{0, 0, NAN}, {1, 0, 0, 0}};
        CHECK_INT(vxs_coupling_step(coupling, &in, &broken, &out), VXS_COUPLING_INVALID);
    }
}

static void check_refusals(void)
{
    vxs_coupling_config config = pt2(5, 1, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_OK);
    config = pt2(0.05, 1, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_OK);
    config = pt2(490, 1, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_OK);
    config = pt2(0.049, 1, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_FREQUENCY);
    config = pt2(491, 1, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_FREQUENCY);
    config = pt2(NAN, 1, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_FREQUENCY);
    config = pt2(5, 0, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_DAMPING);
    config = pt2(5, NAN, 0.001);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_DAMPING);
    config = pt2(5, 1, 0);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_SAMPLE_TIME);
    config = pt2(5, 1, NAN);
    CHECK_INT(vxs_coupling_config_check(&config), VXS_SAMPLE_TIME);
    config = pt2(5, 1, 0.001);
    config.gain = -1;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_GAIN);
    config.gain = 1;
    config.kind = 9;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_PARAM);
    config.kind = VXS_COUPLING_SPRING_DAMPER;
    vxs_coupling_coefficients c;
    CHECK_INT(vxs_coupling_design(&config, &c), VXS_UNSUPPORTED);
    config.mass = 0;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_IMPEDANCE);
    config.struct_size = 0;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_CONFIG);

    config = pt2(5, 1, 0.001);
    CHECK_INT(vxs_coupling_from_impedance(&config, 1000, 14, 0.05, 1), VXS_OK);
    CHECK_NEAR(config.omega0, sqrt(1000 / 0.05), 1e-9);
    CHECK_NEAR(config.damping, 14 / (2 * sqrt(50.0)), 1e-12);
    CHECK_NEAR(config.gain, 0.001, 0);
    CHECK_INT(vxs_coupling_from_impedance(&config, 1000, 14, 0, 1), VXS_IMPEDANCE);
    CHECK_INT(vxs_coupling_kind_named("spring-damper"), VXS_COUPLING_SPRING_DAMPER);
    CHECK_INT(vxs_coupling_kind_named("fuzzy"), 0);
    CHECK_TEXT(vxs_coupling_kind_name(VXS_COUPLING_PT2), "pt2");
    CHECK(vxs_coupling_kind_name(0) == NULL);
}

/* The simulated body follows the device, and at rest carries a contact force to it. */
static void check_spring_damper(void)
{
    vxs_coupling_config config = pt2(5, 0.7, 0.001);
    config.kind = VXS_COUPLING_SPRING_DAMPER;
    vxs_coupling *coupling = make(&config);
    vxs_pose device = vxs_pose_identity(), body;
    vxs_wrench in = {{0, 2, 0}, {0.001, 0, 0}}, out;
    for (int k = 0; k < 3000; k++) vxs_coupling_step(coupling, &in, &device, &out);
    vxs_coupling_pose(coupling, &device, &body);
    CHECK_NEAR(out.force[1], 2, 1e-9);
    CHECK_NEAR(out.torque[0], 0.001, 1e-9);
    CHECK_NEAR(body.position[1], 2 / config.stiffness, 1e-12);
    CHECK(body.orientation[1] > 0);

    memset(&in, 0, sizeof in);
    device.position[0] = 0.3;
    device.orientation[2] = 0.4;
    for (int k = 0; k < 3000; k++) vxs_coupling_step(coupling, &in, &device, &out);
    vxs_coupling_pose(coupling, &device, &body);
    CHECK_NEAR(body.position[0], 0.3, 1e-9);
    CHECK_NEAR(body.position[1], 0, 1e-9);
    CHECK_NEAR(body.orientation[2] / body.orientation[0], 0.4, 1e-9);
    CHECK_NEAR(out.force[0], 0, 1e-9);
    for (int k = 0; k < 500; k++) { /* at constant speed it neither lags nor drags */
        device.position[0] += 1e-4;
        vxs_coupling_step(coupling, &in, &device, &out);
    }
    CHECK_NEAR(out.force[0], 0, 1e-6);

    config.stiffness = 1e9; /* far beyond what an explicit rule survives at 1 kHz */
    config.mass = 1e-3;
    coupling = make(&config);
    device = vxs_pose_identity();
    device.position[2] = 0.01;
    for (int k = 0; k < 1000; k++) CHECK_INT(vxs_coupling_step(coupling, &in, &device, &out), 0);
    CHECK_NEAR(out.force[2], 0, 1e-3);
}

int main(void)
{
    check_coefficients();
    check_step_response();
    check_prewarp();
    check_gain_at_rest();
    check_extremes();
    check_not_finite();
    check_refusals();
    check_spring_damper();
    CHECK_INT(vxs_coupling_init(memory, 8, NULL, NULL), VXS_PARAM);
    return 0;
}
