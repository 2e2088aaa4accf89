/* SPDX-License-Identifier: MIT
 *
 * Set-up of inertia: which bodies there are, and what of contact and of the spring one can bear.
 */
#include "../contact_state.h"
#include "../servo_state.h"
#include "inertia.h"

#include <math.h>
#include <string.h>

static const vxs_effect_constant constants[] = {{"mass", "kg", 0.05, 1e-9, 1e6},
                                                {"com_x", "m", 0, -1e6, 1e6},
                                                {"com_y", "m", 0, -1e6, 1e6},
                                                {"com_z", "m", 0, -1e6, 1e6},
                                                {"inertia_xx", "kgm^2", 8e-6, 1e-18, 1e9},
                                                {"inertia_yy", "kgm^2", 8e-6, 1e-18, 1e9},
                                                {"inertia_zz", "kgm^2", 8e-6, 1e-18, 1e9},
                                                {"inertia_xy", "kgm^2", 0, -1e9, 1e9},
                                                {"inertia_xz", "kgm^2", 0, -1e9, 1e9},
                                                {"inertia_yz", "kgm^2", 0, -1e9, 1e9},
                                                {"stiffness", "N/m", 1000, 0, 1e9},
                                                {"damping", "", 1, 0, 1e3},
                                                {"radius", "m", 0.02, 1e-9, 1e3}};

static void tensor_of(const vxs_effect *effect, double m[9])
{
    const double *i = effect->as.inertia.inertia;
    const double full[9] = {i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2]};
    memcpy(m, full, sizeof full);
}

/* A tensor that a body can have: its sum m x x^T, tr/2 - I, has no eigenvalue below 0, and none of its own is
 * 0. */
static vxs_result check(const vxs_effect *effect)
{
    double m[9], inverse[9];
    tensor_of(effect, m);
    const double mean = (m[0] + m[4] + m[8]) / 3, hair = 1e-6 * mean;
    if (!(vxsi_invert(m, inverse) > 1e-12 * mean * mean * mean)) return VXS_PARAM;
    for (int i = 0; i < 9; i++) m[i] = (i % 4 == 0 ? 1.5 * mean + hair : 0) - m[i];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        if (!(m[4 * i] >= 0 && m[4 * i] * m[4 * j] - m[3 * i + j] * m[3 * j + i] >= 0)) return VXS_PARAM;
    }
    return vxsi_invert(m, inverse) >= 0 ? VXS_OK : VXS_PARAM;
}

/* The tensor along the axes of the tip's frame, and the way from the centre of mass to the tip. */
static void place(const vxs_effect *effect, const vxs_servo_config *config, double tensor[9], double arm[3])
{
    double r[9], m[9], half[9];
    vxs_pose com = vxs_pose_identity();
    memcpy(com.position, effect->as.inertia.com, sizeof com.position);
    vxs_pose_compose(&config->grip, &com, &com);
    vxs_pose_rotation(&com, r);
    tensor_of(effect, m);
    for (int row = 0; row < 3; row++) vxsi_rotate(m, r + 3 * row, half + 3 * row);
    for (int row = 0; row < 3; row++) vxsi_rotate(r, half + 3 * row, tensor + 3 * row);
    for (int i = 0; i < 3; i++) arm[i] = -com.position[i];
}

/* How much a force that contact.h's stiffness is about moves the body at most [1/kg]: the largest eigenvalue
 * of the inverse of its mass at the tip, rotations times the shell's radius. */
static double compliance(const vxs_effect *effect, const vxs_servo_config *config)
{
    const double radius = config->shell->radius;
    double tensor[9], inverse[9], arm[3], columns[6][6], lower[VXSI_STIFFNESS], *to = lower;
    place(effect, config, tensor, arm);
    vxsi_invert(tensor, inverse);
    for (int n = 0; n < 6; n++) {
        double force[3] = {n == 0, n == 1, n == 2}, torque[3], turn[3], way[3];
        vxsi_cross(arm, force, torque);
        for (int i = 0; i < 3; i++) torque[i] += n == 3 + i ? radius : 0;
        vxsi_rotate(inverse, torque, turn);
        vxsi_cross(turn, arm, way);
        for (int i = 0; i < 3; i++) {
            columns[n][i] = force[i] / effect->as.inertia.mass + way[i];
            columns[n][3 + i] = radius * turn[i];
        }
    }
    for (int row = 0; row < 6; row++)
        for (int column = 0; column <= row; column++) *to++ = columns[column][row];
    return vxsi_largest_eigenvalue(lower);
}

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    vxsi_inertia *b = self;
    double sprung[9];
    b->sample_time = config->coupling.sample_time;
    b->mass = effect->as.inertia.mass;
    b->stiffness = effect->as.inertia.stiffness;
    b->damping = 2 * effect->as.inertia.damping * sqrt(b->stiffness * b->mass);
    b->square = effect->as.inertia.radius * effect->as.inertia.radius;
    place(effect, config, b->tensor, b->arm);
    b->drag = b->sample_time * (b->damping + b->sample_time * b->stiffness);
    b->kept = b->mass / (b->mass + b->drag);
    for (int i = 0; i < 9; i++) {
        double lever = (i % 4 == 0 ? vxsi_dot(b->arm, b->arm) : 0) - b->arm[i / 3] * b->arm[i % 3];
        sprung[i] = b->tensor[i] + b->drag * ((i % 4 == 0 ? b->square : 0) + b->kept * lever);
    }
    vxsi_invert(sprung, b->inverse);
    b->most_stiffness = VXSI_CONTACT_SHARE / (compliance(effect, config) * b->sample_time * b->sample_time);
}

static void attach(void *self, vxs_servo *servo)
{
    const vxsi_inertia *b = self;
    vxs_contact_config *contact = &servo->config.contact;
    if (contact->most_stiffness == 0 || contact->most_stiffness > b->most_stiffness)
        contact->most_stiffness = b->most_stiffness;
}

extern const vxs_effect_kind vxsi_stage_inertia;
const vxs_effect_kind vxsi_stage_inertia = {
    .effect = VXS_EFFECT_INERTIA,
    .name = "inertia",
    .reads = "contact's wrench, the device's pose; in place of the coupling",
    .changes = "contact, coupling",
    .size = sizeof(vxsi_inertia),
    .constants = constants,
    .constant_count = sizeof constants / sizeof *constants,
    .check = check,
    .compliance = compliance,
    .set_up = set_up,
    .attach = attach,
    .reset = vxsi_inertia_reset,
    .pose = vxsi_inertia_pose,
    .run = vxsi_inertia_run};
