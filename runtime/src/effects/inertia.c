/* SPDX-License-Identifier: MIT
 *
 * The object as a rigid body. Between kicks by what acts on it, it turns by Simo and Wong's energy and
 * momentum conserving rule ("Unconditionally stable algorithms for rigid body dynamics that exactly preserve
 * energy and momentum", Int. J. Numerical Methods in Engineering 31, 1991): the implicit midpoint of Euler's
 * equations and Cayley's turn. Kick, then drift (symplectic Euler) for what acts from outside; the spring to
 * the device is implicit.
 */
#include "../contact_state.h"
#include "../servo_state.h"
#include "../vector.h"

#include <math.h>
#include <string.h>

/* Of the body's frame, that of the object's tip; arm is from the centre of mass to the tip. */
typedef struct inertia {
    double sample_time, mass, tensor[9], arm[3];
    double stiffness, damping, square;        /* k, b, radius^2 */
    double drag, kept;                        /* of the implicit spring: T c and m / (m + T c), c = b + T k */
    double inverse[9];                        /* of the tensor with the spring */
    double most_stiffness;                    /* of contact [N/m] */
    double position[3], velocity[3], spin[3]; /* of the centre of mass, scene; of turning, body */
    vxs_pose tip;                             /* of the object */
    vxs_pose last;                            /* of the device, in the tick before */
} inertia;

/* A body turns at most so far in a tick [rad], where Newton's steps surely end. */
static const double most_turn = 1;
enum { NEWTON_STEPS = 8 };
static const double solved = 1e-15;

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

/* By cofactors. */
static double invert(const double m[9], double out[9])
{
    double columns[3][3], c[3][3];
    for (int i = 0; i < 9; i++) columns[i % 3][i / 3] = m[i];
    for (int i = 0; i < 3; i++) vxsi_cross(columns[(i + 1) % 3], columns[(i + 2) % 3], c[i]);
    double determinant = vxsi_dot(columns[0], c[0]);
    for (int i = 0; i < 9; i++) out[i] = c[i / 3][i % 3] / determinant;
    return determinant;
}

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
    if (!(invert(m, inverse) > 1e-12 * mean * mean * mean)) return VXS_PARAM;
    for (int i = 0; i < 9; i++) m[i] = (i % 4 == 0 ? 1.5 * mean + hair : 0) - m[i];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        if (!(m[4 * i] >= 0 && m[4 * i] * m[4 * j] - m[3 * i + j] * m[3 * j + i] >= 0)) return VXS_PARAM;
    }
    return invert(m, inverse) >= 0 ? VXS_OK : VXS_PARAM;
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
    invert(tensor, inverse);
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
    inertia *b = self;
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
    invert(sprung, b->inverse);
    b->most_stiffness = VXSI_CONTACT_SHARE / (compliance(effect, config) * b->sample_time * b->sample_time);
}

static void attach(void *self, vxs_servo *servo)
{
    const inertia *b = self;
    vxs_contact_config *contact = &servo->config.contact;
    if (contact->most_stiffness == 0 || contact->most_stiffness > b->most_stiffness)
        contact->most_stiffness = b->most_stiffness;
}

static double without_denormals(double value)
{
    return fabs(value) < 1e-150 ? 0 : value;
}

static void reset(void *self, const vxs_pose *tip)
{
    inertia *b = self;
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, arm[3];
    b->tip = b->last = *tip;
    vxs_pose_rotation(tip, r);
    vxsi_rotate(r, b->arm, arm);
    for (int i = 0; i < 3; i++) {
        b->position[i] = tip->position[i] - arm[i];
        b->velocity[i] = b->spin[i] = 0;
    }
}

static void pose(const void *self, const vxs_pose *tip, vxs_pose *body)
{
    (void)tip;
    *body = ((const inertia *)self)->tip;
}

/* The turn in the middle of a tick: tensor w + T/2 w x tensor w = momentum. */
static void turn_in_middle(const inertia *b, const double momentum[3], double w[3])
{
    const double half = b->sample_time / 2;
    for (int step = 0; step < NEWTON_STEPS; step++) {
        double spin[3], gyro[3], rest[3], slope[9], inverse[9], way[3];
        vxsi_rotate(b->tensor, w, spin);
        vxsi_cross(w, spin, gyro);
        for (int i = 0; i < 3; i++) rest[i] = momentum[i] - spin[i] - half * gyro[i];
        /* of w x tensor w: w x tensor . - (tensor w) x . */
        for (int i = 0; i < 3; i++) {
            const double axis[3] = {i == 0, i == 1, i == 2},
                         column[3] = {b->tensor[i], b->tensor[3 + i], b->tensor[6 + i]};
            double left[3], right[3];
            vxsi_cross(w, column, left);
            vxsi_cross(axis, spin, right);
            for (int row = 0; row < 3; row++)
                slope[3 * row + i] = column[row] + half * (left[row] + right[row]);
        }
        invert(slope, inverse);
        vxsi_rotate(inverse, rest, way);
        for (int i = 0; i < 3; i++) w[i] += way[i];
        if (vxsi_dot(way, way) <= solved * solved * vxsi_dot(w, w)) return;
    }
}

/* A tick without anything from outside. */
static void drift(inertia *b)
{
    const double t = b->sample_time, *q = b->tip.orientation;
    double size = sqrt(vxsi_dot(b->spin, b->spin)), momentum[3], w[3], r[9], arm[3];
    if (size * t > most_turn)
        for (int i = 0; i < 3; i++) b->spin[i] *= most_turn / (size * t);
    vxsi_rotate(b->tensor, b->spin, momentum);
    memcpy(w, b->spin, sizeof w);
    turn_in_middle(b, momentum, w);
    vxs_pose by = {{0, 0, 0}, {1, t / 2 * w[0], t / 2 * w[1], t / 2 * w[2]}},
             next = {{0, 0, 0}, {q[0], q[1], q[2], q[3]}};
    vxs_pose_compose(&next, &by, &next);
    vxs_pose_rotation(&next, r);
    vxsi_rotate(r, b->arm, arm);
    for (int i = 0; i < 3; i++) {
        b->spin[i] = without_denormals(2 * w[i] - b->spin[i]);
        b->position[i] = without_denormals(b->position[i] + t * b->velocity[i]);
        next.position[i] = b->position[i] + arm[i];
    }
    b->tip = next;
}

/* What acts from outside, and the spring as it will be at the tick's end. Leaves the spring's wrench on the
 * device in *wrench. */
static void kick(inertia *b, vxsi_tick *tick)
{
    vxs_wrench *wrench = &tick->wrench;
    const double t = b->sample_time, c = b->damping + t * b->stiffness;
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, arm[3], pull[3], twist[3], rate[3], free[3], push[3],
           torque[3], turned[3], momentum[3];
    vxs_pose_rotation(&b->tip, r);
    vxsi_rotate(r, b->arm, arm);
    vxs_pose_turn(b->tip.orientation, tick->tip.orientation, twist);
    vxs_pose_turn(b->last.orientation, tick->tip.orientation, rate);
    for (int i = 0; i < 3; i++) {
        pull[i] = b->stiffness * (tick->tip.position[i] - b->tip.position[i]) +
                  b->damping * ((tick->tip.position[i] - b->last.position[i]) / tick->elapsed);
        twist[i] = b->square * (b->stiffness * twist[i] + b->damping * (rate[i] / tick->elapsed));
        free[i] = (b->mass * b->velocity[i] + t * (wrench->force[i] + pull[i])) / (b->mass + b->drag);
        push[i] = t * (wrench->force[i] + pull[i]) - b->drag * free[i];
    }
    vxsi_cross(arm, push, torque);
    for (int i = 0; i < 3; i++) torque[i] += t * (wrench->torque[i] + twist[i]);
    vxsi_rotate_back(r, torque, turned);
    vxsi_rotate(b->tensor, b->spin, momentum);
    for (int i = 0; i < 3; i++) momentum[i] += turned[i];
    vxsi_rotate(b->inverse, momentum, b->spin);
    double turn[3], swing[3];
    vxsi_rotate(r, b->spin, turn);
    vxsi_cross(arm, turn, swing);
    for (int i = 0; i < 3; i++) {
        b->velocity[i] = without_denormals(free[i] + (1 - b->kept) * swing[i]);
        b->spin[i] = without_denormals(b->spin[i]);
        wrench->force[i] = c * (b->velocity[i] - swing[i]) - pull[i];
        wrench->torque[i] = b->square * c * turn[i] - twist[i];
    }
    b->last = tick->tip;
}

static void run(void *self, vxsi_tick *tick)
{
    kick(self, tick);
    drift(self);
}

extern const vxsi_stage vxsi_stage_inertia;
const vxsi_stage vxsi_stage_inertia = {.effect = VXS_EFFECT_INERTIA,
                                       .name = "inertia",
                                       .reads =
                                           "contact's wrench, the device's pose; in place of the coupling",
                                       .size = sizeof(inertia),
                                       .constants = constants,
                                       .constant_count = sizeof constants / sizeof *constants,
                                       .check = check,
                                       .compliance = compliance,
                                       .set_up = set_up,
                                       .attach = attach,
                                       .reset = reset,
                                       .pose = pose,
                                       .run = run};
