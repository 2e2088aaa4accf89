/* SPDX-License-Identifier: MIT
 *
 * The simulated device against free fall of a mass, springs at rest, friction, encoder, delay,
 * saturation and expiry; energy that does not come from nowhere; its states.
 */
#include "check.h"
#include "voxshell/simulated.h"

static uint8_t memory[1 << 14] __attribute__((aligned(64)));

static vxs_simulated_config plain(const char *arm)
{
    vxs_simulated_config config;
    vxs_simulated_config_default(&config, NULL);
    config.arm = *vxs_simulated_arm_named(arm);
    return config;
}

static vxs_device *opened(const vxs_simulated_config *config)
{
    vxs_device *device;
    CHECK(vxs_simulated_memory() <= sizeof memory);
    CHECK_INT(vxs_simulated_open(memory, sizeof memory, config, &device), VXS_OK);
    return device;
}

static vxs_device_command forever(double x, double y, double z)
{
    vxs_device_command command = {
        .wrench = {{x, y, z}, {0, 0, 0}}, .hold_ns = INT64_MAX, .expires_ns = INT64_MAX};
    return command;
}

static void check_motion(void)
{
    /* A bare mass under a constant force: x = F t^2 / 2m, after one sample of delay. */
    vxs_simulated_config config = plain("free");
    config.profile.friction = config.profile.viscosity = config.profile.resolution = 0;
    config.substeps = 100;
    vxs_device *device = opened(&config);
    vxs_device_state state;
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    vxs_device_command command = forever(0, 1.5, 0);
    for (int k = 0; k <= 200; k++) vxs_device_exchange(device, &command, &state, NULL);
    CHECK_NEAR(state.pose.position[1], 1.5 * 0.2 * 0.2 / (2 * 0.075), 1e-4);
    CHECK_NEAR(state.velocity[1], 1.5 * 0.2 / 0.075, 0.02);
    CHECK_INT(state.velocity_source, VXS_DEVICE_VELOCITY_ESTIMATED);
    CHECK_INT(state.time_ns, 201000000);
    CHECK_INT(state.sequence, 201);

    /* Against a hand's spring: x = F / k at rest, apart from what friction holds. */
    config = plain("hand");
    device = opened(&config);
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    command = forever(2, 0, 0);
    for (int k = 0; k < 3000; k++) vxs_device_exchange(device, &command, &state, NULL);
    CHECK_NEAR(state.pose.position[0], 2.0 / 500, (0.04 + 1e-9) / 500 + 30e-6);

    /* The hand moves: the device follows it. */
    config = plain("arm");
    device = opened(&config);
    double target[3] = {0.02, -0.01, 0}, turn[4] = {0.8, 0.6, 0, 0};
    for (int k = 0; k < 5000; k++) {
        vxs_simulated_hand(device, target, turn);
        vxs_device_exchange(device, NULL, &state, NULL);
    }
    CHECK_NEAR(state.pose.position[0], 0.02, 0.04 / 300 + 31e-6);
    CHECK_NEAR(state.pose.orientation[1], 0.6, 0);
    double bad[4] = {NAN, 0, 0, 0};
    vxs_simulated_hand(device, bad, bad); /* not taken */
    vxs_device_exchange(device, NULL, &state, NULL);
    CHECK(isfinite(state.pose.position[0]));
}

static void check_friction_and_encoder(void)
{
    vxs_simulated_config config = plain("free");
    config.profile = *vxs_simulated_profile_named("touch"); /* friction 0.26 N, step 55 um */
    vxs_device *device = opened(&config);
    vxs_device_state state;
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    vxs_device_command command = forever(0.25, 0, 0);
    double truth[3], velocity[3];
    for (int k = 0; k < 1000; k++) vxs_device_exchange(device, &command, &state, NULL);
    vxs_simulated_truth(device, truth, velocity);
    CHECK(truth[0] == 0 && velocity[0] == 0); /* held */
    command = forever(0.3, 0, 0);
    for (int k = 0; k < 300; k++) {
        vxs_device_exchange(device, &command, &state, NULL);
        vxs_simulated_truth(device, truth, NULL);
        double steps = state.pose.position[0] / 55e-6;
        CHECK_NEAR(steps, floor(steps + 0.5), 1e-9);
        CHECK_NEAR(state.pose.position[0], truth[0], 27.6e-6);
    }
    CHECK(truth[0] > 0.001);
}

static void check_delay(void)
{
    for (uint32_t delay = 1; delay <= 5; delay += 2) {
        vxs_simulated_config config = plain("free");
        config.delay_samples = delay;
        vxs_device *device = opened(&config);
        vxs_device_state state;
        vxs_device_report report;
        CHECK_INT(vxs_device_arm(device), VXS_OK);
        vxs_device_command command = forever(1, 0, 0);
        for (uint32_t k = 0; k < 8; k++) {
            double velocity[3];
            vxs_device_exchange(device, &command, &state, &report);
            vxs_simulated_truth(device, NULL, velocity);
            CHECK_INT(velocity[0] > 0, k >= delay);
            CHECK_NEAR(report.rendered.force[0], k >= delay, 0);
        }
    }
}

static void check_command(void)
{
    vxs_simulated_config config = plain("hand");
    vxs_device *device = opened(&config);
    vxs_device_state state;
    vxs_device_report report;
    /* Not armed: no force. */
    vxs_device_command command = forever(1, 0, 0);
    for (int k = 0; k < 3; k++) vxs_device_exchange(device, &command, &state, &report);
    CHECK(report.rendered.force[0] == 0 && state.state == VXS_DEVICE_READY);
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    for (int k = 0; k < 3; k++) { /* and what was commanded before arming never acts */
        vxs_device_exchange(device, NULL, &state, &report);
        CHECK(report.rendered.force[0] == 0 && state.state == VXS_DEVICE_ARMED);
    }

    /* Clamped by one common factor; torque likewise. */
    command = forever(30, 40, 0);
    command.wrench.torque[2] = 1;
    for (int k = 0; k < 3; k++) vxs_device_exchange(device, &command, &state, &report);
    CHECK(report.flags & VXS_DEVICE_CLAMPED);
    CHECK_NEAR(report.rendered.force[0], 8.5 * 0.6, 1e-12);
    CHECK_NEAR(report.rendered.force[1], 8.5 * 0.8, 1e-12);
    CHECK_NEAR(report.rendered.torque[2], 0.188, 1e-12);

    /* Full until hold, linear to zero at expiry, also if nobody sends anything any more. */
    command = forever(1, 0, 0);
    command.hold_ns = state.time_ns + 2000000;
    command.expires_ns = command.hold_ns + 10000000;
    vxs_device_exchange(device, &command, &state, &report);
    double last = 1;
    for (int k = 0; k < 20; k++) {
        vxs_device_exchange(device, NULL, &state, &report);
        double expected = k <= 2 ? 1 : k >= 12 ? 0 : (12 - k) / 10.0;
        CHECK_NEAR(report.rendered.force[0], expected, 1e-12);
        CHECK(report.rendered.force[0] <= last);
        last = report.rendered.force[0];
    }
    CHECK(report.flags & VXS_DEVICE_EXPIRED);

    command = forever(NAN, 0, 0);
    vxs_device_exchange(device, &command, &state, &report);
    CHECK(report.flags & VXS_DEVICE_REFUSED);
    CHECK_INT(state.state, VXS_DEVICE_FAULT);
    CHECK_INT(state.fault, VXS_DEVICE_FAULT_SOFTWARE);
    CHECK_INT(vxs_device_arm(device), VXS_STATE);
    CHECK_INT(vxs_device_disarm(device), VXS_OK);
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    vxs_simulated_break(device, VXS_DEVICE_FAULT_SOFTWARE);
    vxs_device_exchange(device, NULL, &state, &report);
    CHECK(isnan(state.pose.position[0]));
    vxs_simulated_break(device, VXS_DEVICE_FAULT_USB);
    vxs_device_exchange(device, NULL, &state, &report);
    CHECK_INT(state.state, VXS_DEVICE_GONE);
    CHECK_INT(vxs_device_arm(device), VXS_LOST);
    CHECK_INT(vxs_device_disarm(device), VXS_LOST);
    vxs_device_close(device);
    vxs_device_close(NULL);

    config.profile = *vxs_simulated_profile_named("falcon"); /* cannot render torque, and says so */
    device = opened(&config);
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    command = forever(0, 0, 0);
    command.wrench.torque[0] = 0.1;
    vxs_device_exchange(device, &command, &state, &report);
    CHECK(report.flags & VXS_DEVICE_INCOMPLETE);
}

/* Nobody pushes: whatever the profile and the arm, the tip comes to rest and stays there. */
static void check_passive(void)
{
    for (uint32_t p = 0; vxs_simulated_profile_at(p); p++) {
        for (uint32_t a = 0; vxs_simulated_arm_at(a); a++) {
            vxs_simulated_config config;
            vxs_simulated_config_default(&config, vxs_simulated_profile_at(p));
            config.arm = *vxs_simulated_arm_at(a);
            config.substeps = 1;
            vxs_device *device = opened(&config);
            CHECK(device->caps.assumed && strcmp(device->caps.name, config.profile.name) == 0);
            vxs_device_state state;
            CHECK_INT(vxs_device_arm(device), VXS_OK);
            vxs_device_command command = forever(config.profile.peak_force, 0, 0);
            for (int k = 0; k < 100; k++) vxs_device_exchange(device, &command, &state, NULL);
            command = forever(0, 0, 0);
            double velocity[3], energy = INFINITY;
            for (int k = 0; k < 30000; k++) {
                vxs_device_exchange(device, &command, &state, NULL);
                double truth[3];
                vxs_simulated_truth(device, truth, velocity);
                double now = 0.5 * (config.profile.mass + config.arm.mass) * velocity[0] * velocity[0] +
                             0.5 * config.arm.stiffness * truth[0] * truth[0];
                if (k > 2) CHECK(now <= energy * (1 + 1e-9) + 1e-15);
                energy = now;
            }
            CHECK_NEAR(velocity[0], 0, 1e-6);
        }
    }
}

/* Sums over many samples of a device at rest: what is added has the deviation that was asked for, and no
 * mean. */
static void check_noise(void)
{
    enum { SAMPLES = 200000 };
    vxs_simulated_config config = plain("hand");
    config.profile.resolution = 0;
    config.noise = 20e-6;
    vxs_device *device = opened(&config);
    vxs_device_state state;
    double sum[3] = {0, 0, 0}, squares[3] = {0, 0, 0}, cross = 0;
    for (int k = 0; k < SAMPLES; k++) {
        vxs_device_exchange(device, NULL, &state, NULL);
        for (int n = 0; n < 3; n++) {
            sum[n] += state.pose.position[n];
            squares[n] += state.pose.position[n] * state.pose.position[n];
        }
        cross += state.pose.position[0] * state.pose.position[1];
    }
    for (int n = 0; n < 3; n++) {
        CHECK_NEAR(sum[n] / SAMPLES / config.noise, 0, 0.01); /* four deviations of the mean */
        CHECK_NEAR(sqrt(squares[n] / SAMPLES) / config.noise, 1, 0.01);
    }
    CHECK_NEAR(cross / SAMPLES / (config.noise * config.noise), 0, 0.01);
}

/* The share that is lost is the one that was asked for, in runs of the length that was asked for. */
static void check_loss(void)
{
    enum { SAMPLES = 400000 };
    const double shares[][2] = {{0.01, 0}, {0.3, 0}, {0.05, 0.02}, {0.5, 0.1}};
    for (size_t n = 0; n < sizeof shares / sizeof *shares; n++) {
        vxs_simulated_config config = plain("hand");
        config.loss = shares[n][0];
        config.loss_time = shares[n][1];
        int each = shares[n][1] > 0 ? (int)(shares[n][1] * 1000 + 0.5) : 1, run = 0, lost = 0;
        vxs_device *device = opened(&config);
        vxs_device_state state, before;
        do vxs_device_exchange(device, NULL, &before, NULL);
        while (before.sequence == 0);
        for (int k = 1; k < SAMPLES; k++) {
            vxs_device_exchange(device, NULL, &state, NULL);
            CHECK(state.time_ns - before.time_ns == 1000000);
            if (state.sequence == before.sequence) {
                lost++;
                run++;
                CHECK_NEAR(state.link_age, before.link_age + 0.001, 1e-12);
                CHECK(memcmp(&state.pose, &before.pose, sizeof state.pose) == 0);
            } else {
                CHECK(run % each == 0 && state.link_age == 0); /* one may follow the other */
                run = 0;
            }
            before = state;
        }
        CHECK_NEAR((double)lost / SAMPLES / config.loss, 1, 0.15);
    }
}

/* Across drop-outs a device that moves evenly is measured as moving evenly; and a command that was not heard
 * does not act, though the next one does. */
static void check_loss_of_both(void)
{
    vxs_simulated_config config = plain("hand");
    config.profile.resolution = 0;
    config.loss = 0.2;
    config.loss_time = 0.005;
    vxs_device *device = opened(&config);
    vxs_device_state state;
    vxs_device_report report;
    for (int k = 0; k < 5000; k++) {
        const double hand[3] = {k * 1e-5, 0, 0};
        vxs_simulated_hand(device, hand, NULL);
        vxs_device_exchange(device, NULL, &state, NULL);
        if (k > 2000) CHECK_NEAR(state.velocity[0], 0.01, 1e-9);
    }
    int unheard = 0;
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    double acts = 0; /* what was heard last, a sample ago */
    for (int k = 1; k < 5000; k++) {
        vxs_device_command command = forever(k * 1e-4, 0, 0);
        uint64_t before = state.sequence;
        vxs_device_exchange(device, &command, &state, &report);
        CHECK_NEAR(report.rendered.force[0], acts, 1e-12);
        if (state.sequence != before)
            acts = command.wrench.force[0];
        else
            unheard++;
    }
    CHECK(unheard > 500);
}

static int64_t trace_of(const vxs_simulated_config *config, double places[1000])
{
    vxs_device *device = opened(config);
    vxs_device_state state;
    for (int k = 0; k < 1000; k++) {
        const double hand[3] = {k * 1e-5, 0, 0};
        vxs_simulated_hand(device, hand, NULL);
        vxs_device_exchange(device, NULL, &state, NULL);
        places[k] = state.pose.position[0];
    }
    return (int64_t)state.sequence;
}

/* The same seed, the same trace; another, another. */
static void check_seed(void)
{
    static double first[1000], again[1000];
    vxs_simulated_config config = plain("hand");
    config.noise = 50e-6;
    config.loss = 0.1;
    CHECK(trace_of(&config, first) == trace_of(&config, again));
    CHECK(memcmp(first, again, sizeof first) == 0);
    config.seed = 2;
    trace_of(&config, again);
    CHECK(memcmp(first, again, sizeof first) != 0);
}

static void check_config(void)
{
    const double wrong[][3] = {{-1e-6, 0, 0}, {NAN, 0, 0},  {0, -0.1, 0}, {0, 0.91, 0},
                               {0, NAN, 0},   {0, 0.1, -1}, {0, 0.1, 11}};
    for (size_t n = 0; n < sizeof wrong / sizeof *wrong; n++) {
        vxs_simulated_config bad = plain("hand");
        vxs_device *none;
        bad.noise = wrong[n][0];
        bad.loss = wrong[n][1];
        bad.loss_time = wrong[n][2];
        CHECK_INT(vxs_simulated_open(memory, sizeof memory, &bad, &none), VXS_PARAM);
    }

    vxs_simulated_config config = plain("hand");
    vxs_device *device;
    config.delay_samples = 0;
    CHECK_INT(vxs_simulated_open(memory, sizeof memory, &config, &device), VXS_PARAM);
    config = plain("hand");
    config.profile.mass = 0;
    CHECK_INT(vxs_simulated_open(memory, sizeof memory, &config, &device), VXS_PARAM);
    config = plain("hand");
    config.struct_size = 1;
    CHECK_INT(vxs_simulated_open(memory, sizeof memory, &config, &device), VXS_CONFIG);
    config = plain("hand");
    CHECK_INT(vxs_simulated_open(memory, 64, &config, &device), VXS_BUFFER);
    CHECK(vxs_simulated_profile_named("toaster") == NULL && vxs_simulated_arm_named(NULL) == NULL);
}

int main(void)
{
    check_motion();
    check_friction_and_encoder();
    check_delay();
    check_command();
    check_passive();
    check_noise();
    check_loss();
    check_loss_of_both();
    check_seed();
    check_config();
    return 0;
}
