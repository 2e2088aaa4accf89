/* SPDX-License-Identifier: MIT
 *
 * A massless body hangs on the device by a spring and is always in balance: contact and spring cancel.
 *
 * Lengths: a body's motion is six numbers, its way and radius x its turn [m]; a wrench is six numbers,
 * force / k and torque / (k radius), how far it moves a body that hangs free. With W(q) that wrench, the
 * balance is f(q) = q - W(q) = device. Newton's step is q += H (device - f(q)), H = f'(q)^-1.
 *
 * Nobody tells H: it is learnt from the evaluations themselves.
 *   free                  H = 1, and the body is at the device exactly
 *   just touched          contact that would end after moving out by its depth: H = 1 - n n^T w / (w + depth)
 *                         along the wrench's direction n, w its length
 *   in contact            the BFGS rule on the last two evaluations, unless contact did not grow along that
 *                         way
 *   lost                  if the spring draws away from where contact was, free; else it is behind the next
 *                         corner: so the way to the device is taken in steps that grow, and is all taken by
 *                         the sixth. Contact that comes in jumps has no balance: this holds the body at the
 *                         jump
 * No step leaves contact by more than its depth. H is what ties body to device as well: a tick begins where the
 * last balance moves when the device moves, so that one evaluation a tick is exact for contact that is linear.
 * rt-safe.
 */
#include "coupling_body.h"

typedef struct quasi_static {
    double stiffness, radius;
    double is_free;          /* not 0: the body is at the device */
    double misses;           /* evaluations without contact since the last one with */
    double inverse[6][6];    /* H */
    vxs_pose object, anchor; /* balance, with the device at anchor */
    vxs_pose evaluated;      /* where contact was evaluated last, */
    double push[6];          /* and its wrench there */
    double pushed[6];        /* the last one that was not 0 */
} quasi_static;
VXS_COUPLING_FITS(quasi_static);

/* A contact that seems stiffer than so many springs is a step of the contact, not a slope. */
static const double steepest = 1e3;
/* Least part that force has in a wrench. */
static const double flattest = 0.1;
enum { most_misses = 6 };
/* In balance: what is left is so small beside the spring's stretch. */
static const double balanced = 1e-3;

static vxs_result check(const vxs_coupling_config *config)
{
    if (!vxsi_is_positive(config->stiffness) || !vxsi_is_positive(config->radius)) return VXS_IMPEDANCE;
    return config->evaluations >= 1 && config->evaluations <= VXS_COUPLING_MAX_EVALUATIONS ? VXS_OK
                                                                                           : VXS_PARAM;
}

static void forget_contact(quasi_static *s)
{
    s->is_free = 1;
    s->misses = 0;
    memset(s->push, 0, sizeof s->push);
    memset(s->pushed, 0, sizeof s->pushed);
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) s->inverse[i][j] = i == j;
    }
}

static void set_up(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    quasi_static *s = (quasi_static *)coupling->state;
    s->stiffness = config->stiffness;
    s->radius = config->radius;
    coupling->most_evaluations = config->evaluations;
}

static void reset(vxs_coupling *coupling, const vxs_pose *device)
{
    quasi_static *s = (quasi_static *)coupling->state;
    vxsi_unit_pose(device, &s->object);
    s->anchor = s->evaluated = s->object;
    forget_contact(s);
}

static double dot(const double a[6], const double b[6])
{
    return ((a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]) + ((a[3] * b[3] + a[4] * b[4]) + a[5] * b[5]);
}

static void way_between(const quasi_static *s, const vxs_pose *from, const vxs_pose *to, double way[6])
{
    vxs_pose_turn(from->orientation, to->orientation, way + 3);
    for (int i = 0; i < 3; i++) {
        way[i] = to->position[i] - from->position[i];
        way[3 + i] *= s->radius;
    }
}

static void multiply(const quasi_static *s, const double v[6], double out[6])
{
    for (int i = 0; i < 6; i++) out[i] = dot(s->inverse[i], v);
}

static void shorten(double v[6], double most)
{
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 6 && length > most; i++) v[i] *= most / length;
}

/* H v, of what is out of balance: contact only takes from it, so that this is never longer. */
static void answer(const quasi_static *s, const double v[6], double out[6])
{
    multiply(s, v, out);
    shorten(out, sqrt(dot(v, v)));
}

static void move(const quasi_static *s, vxs_pose *pose, const double way[6])
{
    double turn[3];
    for (int i = 0; i < 3; i++) {
        pose->position[i] = vxs_without_denormals(pose->position[i] + way[i]);
        turn[i] = way[3 + i] / s->radius;
    }
    vxsi_turn(pose->orientation, turn);
}

static int is_zero(const double v[6])
{
    return dot(v, v) == 0;
}

static void pose(const vxs_coupling *coupling, const vxs_pose *device, vxs_pose *object)
{
    const quasi_static *s = (const quasi_static *)coupling->state;
    vxs_pose now;
    double way[6], follows[6];
    vxsi_unit_pose(device, &now);
    *object = s->is_free ? now : s->object;
    way_between(s, &s->anchor, &now, way);
    if (s->is_free || is_zero(way)) return;
    answer(s, way, follows);
    move(s, object, follows);
}

/* How far the body must move along the wrench until a point that is so deep is out. */
static double way_out(const double push[6], double depth)
{
    double force = sqrt((push[0] * push[0] + push[1] * push[1]) + push[2] * push[2]);
    return depth * fmax(force / sqrt(dot(push, push)), flattest);
}

static void learn_first_touch(quasi_static *s, const double push[6], double out)
{
    double square = dot(push, push);
    forget_contact(s);
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) s->inverse[i][j] -= push[i] * push[j] / (square + sqrt(square) * out);
    }
}

/* BFGS: f's slope along the way from the last evaluation is what was seen there. */
static void learn_slope(quasi_static *s, const vxs_pose *at, const double push[6])
{
    double way[6], rise[6], turned[6];
    way_between(s, &s->evaluated, at, way);
    double square = dot(way, way);
    for (int i = 0; i < 6; i++) rise[i] = way[i] - (push[i] - s->push[i]);
    double product = dot(way, rise);
    if (!(square > 0) || dot(rise, rise) > steepest * steepest * square) return;
    if (product <= square) return;
    multiply(s, rise, turned);
    double factor = (1 + dot(rise, turned) / product) / product;
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++)
            s->inverse[i][j] = vxs_without_denormals(
                s->inverse[i][j] +
                (factor * (way[i] * way[j]) - (turned[i] * way[j] + way[i] * turned[j]) / product));
    }
    /* Contact only pushes back: f' is at least 1, H at most. What jumps aside looks otherwise. */
    for (int i = 0; i < 6; i++) {
        double share = s->inverse[i][i] > 1 ? 1 / sqrt(s->inverse[i][i]) : 1;
        for (int j = 0; j < 6 && share < 1; j++) {
            s->inverse[i][j] *= share;
            s->inverse[j][i] *= share;
        }
    }
}

/* What is out of balance at the pose where contact was just evaluated. */
static void look(const vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device,
                 vxs_pose *at, double push[6], double rest[6])
{
    const quasi_static *s = (const quasi_static *)coupling->state;
    vxs_pose now;
    pose(coupling, device, at);
    vxsi_unit_pose(device, &now);
    way_between(s, at, &now, rest);
    for (int i = 0; i < 3; i++) {
        push[i] = vxs_without_denormals(contact->force[i] / s->stiffness);
        push[3 + i] = vxs_without_denormals(contact->torque[i] / (s->stiffness * s->radius));
    }
    for (int i = 0; i < 6; i++) rest[i] += push[i];
}

static void newton(quasi_static *s, const vxs_pose *at, const double push[6], const double rest[6],
                   double depth, const vxs_pose *device)
{
    double way[6];
    vxsi_unit_pose(device, &s->anchor);
    if (is_zero(push)) {
        s->misses += 1;
        if (s->is_free || s->misses > most_misses || dot(rest, s->pushed) >= 0) {
            forget_contact(s);
            s->object = s->evaluated = s->anchor;
            return;
        }
        if (s->misses == 1) learn_slope(s, at, push);
        answer(s, rest, way);
        double share = 1;
        for (double n = s->misses; n < most_misses; n++) share /= 4;
        for (int i = 0; i < 6 && s->misses > 1; i++) way[i] += share * (rest[i] - way[i]);
    } else {
        double out = way_out(push, depth);
        if (s->is_free && depth > 0)
            learn_first_touch(s, push, out);
        else
            learn_slope(s, at, push);
        answer(s, rest, way);
        if (depth > 0 && dot(way, push) > 0) shorten(way, out);
        s->is_free = s->misses = 0;
        memcpy(s->pushed, push, sizeof s->pushed);
    }
    s->object = *at;
    move(s, &s->object, way);
    s->evaluated = *at;
    memcpy(s->push, push, sizeof s->push);
}

static int refine(vxs_coupling *coupling, const vxs_wrench *contact, double depth, const vxs_pose *device)
{
    quasi_static *s = (quasi_static *)coupling->state;
    vxs_pose at;
    double push[6], rest[6], stretch[6];
    look(coupling, contact, device, &at, push, rest);
    for (int i = 0; i < 6; i++) stretch[i] = push[i] - rest[i];
    if (dot(rest, rest) <= balanced * balanced * dot(stretch, stretch)) return 0;
    if (coupling->evaluations >= coupling->most_evaluations) return 0;
    newton(s, &at, push, rest, depth, device);
    return 1;
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    quasi_static *s = (quasi_static *)coupling->state;
    vxs_pose at;
    double push[6], rest[6], stretch[6];
    look(coupling, contact, device, &at, push, rest);
    newton(s, &at, push, rest, coupling->depth, device);
    way_between(s, &s->anchor, &s->object, stretch);
    /* In balance the stretch is the push. A step that goes too far must not draw the device against it. */
    double along = dot(stretch, push);
    for (int i = 0; i < 6 && along < 0; i++) stretch[i] -= along / dot(push, push) * push[i];
    for (int i = 0; i < 3; i++) {
        out->force[i] = s->stiffness * stretch[i];
        out->torque[i] = s->stiffness * s->radius * stretch[3 + i];
    }
}

const vxs_coupling_kind vxsi_coupling_quasi_static = {.kind = VXS_COUPLING_QUASI_STATIC,
                                                      .name = "quasi-static",
                                                      .check = check,
                                                      .set_up = set_up,
                                                      .reset = reset,
                                                      .pose = pose,
                                                      .refine = refine,
                                                      .step = step};
