/* SPDX-License-Identifier: MIT
 *
 * The PT2 as two trapezoidal integrators (Tustin's rule element by element, so the transfer
 * function is that of the biquad). At rest both integrator inputs are exactly 0, hence a gain of
 * exactly K; the direct form loses it to cancellation in 1 + a1 + a2 when w0 T is small. rt-safe.
 */
#include "coupling_table.h"

/* a1 = 1/(1 + g (g + 2d)), a2 = g a1, a3 = g a2, with g = w0 T/2; the integrators of the six axes. */
typedef struct pt2 {
    double gain, a1, a2, a3;
    double axes[6][2];
} pt2;
VXS_COUPLING_FITS(pt2);

static vxs_result check(const vxs_coupling_config *config)
{
    double hertz = config->omega0 / (2 * 3.14159265358979323846);
    /* A hair of 1e-12: 2 pi 0.05 Hz must not fail by rounding. */
    if (!(hertz >= VXS_COUPLING_MIN_HZ * (1 - 1e-12) &&
          hertz * config->sample_time <= VXS_COUPLING_MAX_RATE * (1 + 1e-12)))
        return VXS_FREQUENCY;
    vxs_result result = vxsi_coupling_check_damping(config);
    if (result != VXS_OK) return result;
    return vxsi_is_positive(config->gain) ? VXS_OK : VXS_GAIN;
}

static void set_up(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    pt2 *p = (pt2 *)coupling->state;
    double g = config->omega0 * config->sample_time / 2;
    p->gain = config->gain;
    p->a1 = 1 / (1 + g * (g + 2 * config->damping));
    p->a2 = g * p->a1;
    p->a3 = g * p->a2;
}

static void reset(vxs_coupling *coupling, const vxs_pose *device)
{
    (void)device;
    pt2 *p = (pt2 *)coupling->state;
    memset(p->axes, 0, sizeof p->axes);
}

static double filter_axis(const pt2 *p, double state[2], double input)
{
    double rest = vxs_without_denormals(input) - state[1];
    double rate = p->a1 * state[0] + p->a2 * rest;
    double value = state[1] + (p->a2 * state[0] + p->a3 * rest);
    state[0] = vxs_without_denormals(2 * rate - state[0]);
    state[1] = vxs_without_denormals(2 * value - state[1]);
    return vxs_without_denormals(p->gain * value);
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    (void)device;
    pt2 *p = (pt2 *)coupling->state;
    for (int axis = 0; axis < 3; axis++)
        out->force[axis] = filter_axis(p, p->axes[axis], contact->force[axis]);
    for (int axis = 0; axis < 3 && coupling->has_torque; axis++)
        out->torque[axis] = filter_axis(p, p->axes[3 + axis], contact->torque[axis]);
}

const vxs_coupling_kind vxsi_coupling_pt2 = {
    .kind = VXS_COUPLING_PT2, .name = "pt2", .check = check, .set_up = set_up, .reset = reset, .step = step};
