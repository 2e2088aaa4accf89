/* SPDX-License-Identifier: MIT
 *
 * A known mass on emulated devices whose motors give more or less than what the host believes: how much is
 * found again, through the Falcon's and the pantograph's Jacobians, packets and friction. And everything that
 * ends it otherwise.
 */
#include "check.h"
#include "emulated.h"
#include "voxshell/calibration.h"

/* As good as nobody's hand: a weight is a target far away at the end of a soft spring. */
static const vxs_simulated_arm weightless = {"weight", 0.05, 0, 0.2};

typedef struct rig {
    emulated e;
    vxsi_link link;
    vxs_calibration_config config;
    vxs_calibration *calibration;
    vxs_device_command command;
    vxs_device_state state;
    uint8_t memory[1024] __attribute__((aligned(16)));
} rig;
static rig r;

static void start(const emulated_kind *kind, double units_per_nm, double torque_gain, double friction)
{
    vxs_hardware_config config;
    memset(&r, 0, sizeof r);
    emulated_init_held(&r.e, kind, &weightless, friction);
    vxs_hardware_config_default(&config);
    config.is_in_place = 1;
    config.units_per_nm = units_per_nm;
    config.torque_gain = torque_gain;
    CHECK_INT(emulated_link_as(&r.e, &r.link, &config), VXS_OK);
    for (int n = 0; n < 10; n++) {
        emulated_run(&r.e, &r.link);
        vxs_device_exchange(&r.link.device, NULL, &r.state, NULL);
    }
    vxs_calibration_config_default(&r.config);
    r.config.mass = 0.1;
    if (kind == &emulated_haply) { /* stands upright */
        r.config.down[1] = 0;
        r.config.down[2] = 1;
    }
}

static void begin(void)
{
    CHECK(vxs_calibration_memory() <= sizeof r.memory);
    CHECK_INT(vxs_calibration_init(r.memory, sizeof r.memory, &r.config, &r.calibration), VXS_OK);
    CHECK_INT(vxs_device_arm(&r.link.device), VXS_OK);
}

/* What pulls at the tip [N], downwards. */
static uint32_t tick(double weight)
{
    for (int n = 0; n < 3; n++) r.e.hand[n] = r.config.down[n] * weight / weightless.stiffness;
    emulated_run(&r.e, &r.link);
    vxs_device_exchange(&r.link.device, &r.command, &r.state, NULL);
    return vxs_calibration_tick(r.calibration, &r.state, &r.command);
}

static uint32_t run(double weight, uint32_t while_phase, int most)
{
    uint32_t phase = while_phase;
    for (int n = 0; n < most && phase == while_phase; n++) phase = tick(weight);
    return phase;
}

/* truth: commanded newtons that a true one takes. */
static void find(const emulated_kind *kind, double units_per_nm, double torque_gain, double friction,
                 double truth)
{
    const double grip = 0.3;
    vxs_calibration_result result;
    start(kind, units_per_nm, torque_gain, friction);
    begin();
    CHECK_INT(run(grip, VXS_CALIBRATION_EMPTY, 10000), VXS_CALIBRATION_HANG);
    for (int n = 0; n < 5000; n++) CHECK_INT(tick(grip), VXS_CALIBRATION_HANG);
    double weight = grip + r.config.mass * r.config.gravity;
    CHECK_INT(run(weight, VXS_CALIBRATION_HANG, 5000), VXS_CALIBRATION_LOADED);
    CHECK_INT(run(weight, VXS_CALIBRATION_LOADED, 20000), VXS_CALIBRATION_DONE);
    vxs_calibration_get(r.calibration, &result);
    printf("%s, %.2f N of friction: %.3f N empty, %.3f N loaded: %.4f commanded newtons a true one, truly "
           "%.4f\n",
           kind->name, friction, result.empty, result.loaded, result.scale, truth);
    CHECK_NEAR(result.scale / truth, 1, 0.015);
    CHECK_NEAR(result.empty, grip * truth, 0.02 * truth);
    for (int n = 0; n < 20; n++) tick(weight);
    CHECK(emulated_force(&r.e) == 0); /* and it lets go */
    vxs_device_close(&r.link.device);
}

static void check_ends(void)
{
    vxs_calibration_result result;
    /* nobody hangs anything */
    start(&emulated_hvlink, 2300, 1, 0);
    r.config.patience = 9;
    begin();
    CHECK_INT(run(0, VXS_CALIBRATION_EMPTY, 10000), VXS_CALIBRATION_HANG);
    CHECK_INT(run(0, VXS_CALIBRATION_HANG, 10000), VXS_CALIBRATION_IMPATIENT);
    vxs_calibration_get(r.calibration, &result);
    CHECK(result.scale == 0);
    CHECK(r.command.wrench.force[1] == 0);

    /* a cable that pulls now more, now less, each 2 s: not before it rests does anything hang there */
    start(&emulated_hvlink, 2300, 1, 0);
    begin();
    for (int period = 0; period < 8; period++)
        for (int n = 0; n < 2000; n++) CHECK_INT(tick(period % 2 ? 0.4 : 0), VXS_CALIBRATION_EMPTY);
    CHECK_INT(run(0.4, VXS_CALIBRATION_EMPTY, 10000), VXS_CALIBRATION_HANG);

    /* friction that the spring does not overcome */
    start(&emulated_hvlink, 2300, 1, 4);
    begin();
    CHECK_INT(run(0, VXS_CALIBRATION_EMPTY, 100000), VXS_CALIBRATION_IMPATIENT);

    /* somebody pulls for a moment: it waits on */
    start(&emulated_hvlink, 2300, 1, 0);
    begin();
    CHECK_INT(run(0, VXS_CALIBRATION_EMPTY, 10000), VXS_CALIBRATION_HANG);
    CHECK_INT(run(1, VXS_CALIBRATION_HANG, 5000), VXS_CALIBRATION_LOADED);
    CHECK_INT(run(0, VXS_CALIBRATION_LOADED, 5000), VXS_CALIBRATION_HANG);

    /* more than it may hold */
    start(&emulated_hvlink, 2300, 1, 0);
    r.config.max_force = 0.5;
    begin();
    CHECK_INT(run(0, VXS_CALIBRATION_EMPTY, 10000), VXS_CALIBRATION_HANG);
    uint32_t phase = run(0.6, VXS_CALIBRATION_HANG, 5000);
    CHECK_INT(phase, VXS_CALIBRATION_LOADED);
    CHECK_INT(run(0.6, VXS_CALIBRATION_LOADED, 20000), VXS_CALIBRATION_TOO_HEAVY);

    /* the device ends it, and a hand that throws it about does */
    start(&emulated_hvlink, 2300, 1, 0);
    begin();
    run(0, VXS_CALIBRATION_EMPTY, 500);
    vxs_hvlink_device_fail(&r.e.hvlink, VXS_DEVICE_FAULT_USER);
    CHECK_INT(run(0, VXS_CALIBRATION_EMPTY, 100), VXS_CALIBRATION_LET_GO);
    start(&emulated_hvlink, 2300, 1, 0);
    begin();
    run(0, VXS_CALIBRATION_EMPTY, 500);
    CHECK_INT(run(12, VXS_CALIBRATION_EMPTY, 500), VXS_CALIBRATION_LET_GO);
    for (int n = 0; n < 20; n++) tick(0);
    CHECK(emulated_force(&r.e) == 0);
}

static void check_config(void)
{
    vxs_calibration_config good, bad;
    vxs_calibration *calibration;
    uint8_t memory[1024] __attribute__((aligned(16)));
    vxs_calibration_config_default(&good);
    CHECK_INT(vxs_calibration_init(memory, sizeof memory, &good, &calibration), VXS_PARAM); /* no mass */
    good.mass = 0.1;
    CHECK_INT(vxs_calibration_init(memory, sizeof memory, &good, &calibration), VXS_OK);
    CHECK_INT(vxs_calibration_init(memory, 16, &good, &calibration), VXS_BUFFER);
    CHECK_INT(vxs_calibration_init(memory, sizeof memory, NULL, &calibration), VXS_PARAM);
    CHECK_INT(vxs_calibration_init(NULL, sizeof memory, &good, &calibration), VXS_PARAM);
    CHECK_INT(vxs_calibration_init(memory, sizeof memory, &good, NULL), VXS_PARAM);
    CHECK_INT(vxs_calibration_init(memory + 1, sizeof memory - 1, &good, &calibration), VXS_BUFFER);
    for (size_t n = 0; n < 12; n++) {
        double *const numbers[] = {&bad.mass,      &bad.down[0],   &bad.gravity,   &bad.sample_time,
                                   &bad.stiffness, &bad.damping,   &bad.way,       &bad.period,
                                   &bad.patience,  &bad.max_force, &bad.max_speed, &bad.down[1]};
        bad = good;
        for (int i = 0; i < 3; i++) {
            *numbers[n] = i == 0 ? NAN : i == 1 ? 1e9 : -1e9;
            CHECK_INT(vxs_calibration_init(memory, sizeof memory, &bad, &calibration), VXS_PARAM);
        }
    }
    bad = good;
    bad.struct_size = 0;
    CHECK_INT(vxs_calibration_init(memory, sizeof memory, &bad, &calibration), VXS_CONFIG);
}

int main(void)
{
    find(&emulated_hvlink, 2300, 1, 0, 1);
    find(&emulated_hvlink, 2300, 1, 0.3, 1);
    find(&emulated_falcon, 2300, 1, 0, 1);
    find(&emulated_falcon, 4600, 1, 0, 0.5); /* twice too strong */
    find(&emulated_falcon, 1150, 1, 0.7, 2);
    find(&emulated_haply, 2300, 0.5, 0, 2);
    find(&emulated_haply, 2300, 1.25, 0.4, 0.8);
    check_ends();
    check_config();
    return 0;
}
