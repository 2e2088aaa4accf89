/* SPDX-License-Identifier: MIT
 *
 * A lab's own coupling: this file is what it writes, and the table with one line more. The table here takes
 * the place of src/coupling_table.c, which is all of the runtime that changes.
 */
#include "coupling_table.h"
#include "servo_bench.h"

/* A first-order low-pass of corner omega0, by the implicit Euler rule. */
typedef struct lag {
    double share;
    double axes[6];
} lag;
VXS_COUPLING_FITS(lag);

enum { LAB_LAG = VXS_COUPLING_OWN };

static vxs_result lag_check(const vxs_coupling_config *config)
{
    return vxsi_is_positive(config->omega0) ? VXS_OK : VXS_FREQUENCY;
}

static void lag_set_up(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    double way = config->omega0 * config->sample_time;
    ((lag *)coupling->state)->share = way / (1 + way);
}

static void lag_reset(vxs_coupling *coupling, const vxs_pose *device)
{
    (void)device;
    memset(((lag *)coupling->state)->axes, 0, sizeof(double[6]));
}

static void lag_step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device,
                     vxs_wrench *out)
{
    (void)device;
    lag *l = (lag *)coupling->state;
    for (int axis = 0; axis < 6; axis++) {
        double in = axis < 3 ? contact->force[axis] : contact->torque[axis - 3];
        l->axes[axis] = vxs_without_denormals(l->axes[axis] + l->share * (in - l->axes[axis]));
        *(axis < 3 ? &out->force[axis] : &out->torque[axis - 3]) = l->axes[axis];
    }
}

static const vxs_coupling_kind lab_lag = {.kind = LAB_LAG,
                                          .name = "lab-lag",
                                          .check = lag_check,
                                          .set_up = lag_set_up,
                                          .reset = lag_reset,
                                          .step = lag_step};

extern const vxs_coupling_kind vxsi_coupling_pt2;
const vxs_coupling_kind *const vxsi_coupling_kinds[] = {&vxsi_coupling_pt2, &lab_lag, NULL};

int main(void)
{
    CHECK_INT(vxs_coupling_kind_named("lab-lag"), LAB_LAG);
    CHECK_TEXT(vxs_coupling_kind_name(LAB_LAG), "lab-lag");
    CHECK_INT(vxs_coupling_kind_named("spring-damper"), 0); /* not in this table */

    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = LAB_LAG;
    config.omega0 = -1;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_FREQUENCY);
    config.omega0 = 100;
    CHECK_INT(vxs_coupling_config_check(&config), VXS_OK);
    vxs_coupling_coefficients none;
    CHECK_INT(vxs_coupling_design(&config, &none), VXS_UNSUPPORTED);

    static uint8_t memory[1024] __attribute__((aligned(16)));
    vxs_coupling *coupling;
    CHECK_INT(vxs_coupling_init(memory, sizeof memory, &config, &coupling), VXS_OK);
    const vxs_wrench push = {{2, 0, 0}, {0, 0, -3}};
    const vxs_pose device = vxs_pose_identity();
    vxs_wrench out;
    double left = 1; /* of the way to 2 N after n samples: (1 - share)^n */
    for (int n = 0; n < 100; n++) {
        CHECK_INT(vxs_coupling_step(coupling, &push, &device, &out), 0);
        left /= 1 + 100 * 0.001;
        CHECK_NEAR(out.force[0], 2 * (1 - left), 1e-12);
        CHECK_NEAR(out.torque[2], -3 * (1 - left), 1e-12);
    }

    /* And in the servo. */
    servo_bench b;
    bench_prepare(&b);
    b.servo_config.coupling = config;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    vxs_servo_trace row;
    for (int k = 0; k < 2000; k++) CHECK(!(bench_tick(&b, k < 10 ? 0.012 : 0.009, &row) & VXS_SERVO_FAULT));
    CHECK(row.points > 0);
    CHECK_NEAR(row.output.force[1], row.collision.force[1], 0.05);
    bench_close(&b);
    return 0;
}
