/* SPDX-License-Identifier: MIT
 *
 * The PT2 as two trapezoidal integrators (Tustin's rule element by element, so the transfer
 * function is that of the biquad). At rest both integrator inputs are exactly 0, hence a gain of
 * exactly K; the direct form loses it to cancellation in 1 + a1 + a2 when w0 T is small. rt-safe.
 */
#include "coupling_ops.h"

#include <math.h>
#include <string.h>

static const double smallest = 1e-150;

static double without_denormals(double value)
{
    return fabs(value) < smallest ? 0 : value;
}

static double filter_axis(const vxsi_pt2 *pt2, double state[2], double input)
{
    double rest = input - state[1];
    double rate = pt2->a1 * state[0] + pt2->a2 * rest;
    double value = state[1] + (pt2->a2 * state[0] + pt2->a3 * rest);
    state[0] = without_denormals(2 * rate - state[0]);
    state[1] = without_denormals(2 * value - state[1]);
    return without_denormals(pt2->gain * value);
}

static void reset(vxs_coupling *coupling, const vxs_pose *device)
{
    (void)device;
    memset(coupling->as.pt2.state, 0, sizeof coupling->as.pt2.state);
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    (void)device;
    vxsi_pt2 *pt2 = &coupling->as.pt2;
    for (int axis = 0; axis < 3; axis++) {
        out->force[axis] = filter_axis(pt2, pt2->state[axis], without_denormals(contact->force[axis]));
        out->torque[axis] = filter_axis(pt2, pt2->state[3 + axis], without_denormals(contact->torque[axis]));
    }
}

const vxsi_coupling_ops vxsi_coupling_pt2 = {.reset = reset, .step = step};
