/* SPDX-License-Identifier: MIT
 *
 * Coulomb's friction with presliding: one anchor for each load of the contact (contact.h) holds the object by
 * a spring and a damper up to a cone, and is dragged along from there on. The return to the cone is that of
 * plasticity (Simo and Hughes, "Computational Inelasticity", 1998, section 1.4), with the twist about the
 * normal as one more direction (the ellipsoid of Howe and Cutkosky, Int. J. Robotics Research 15, 1996).
 */
#include "../servo_state.h"
#include "../vector.h"

#include <math.h>
#include <string.h>

/* Lengths along the scene's axes, tangential, and in the fourth place twist x radius. */
typedef struct anchor {
    uint32_t name; /* of its load; anchors are in this order */
    uint32_t is_sliding;
    double share;      /* of the contact's force: of k_t and b_t */
    double stretch[4]; /* from the anchor to the object [m] */
    double normal[3];
} anchor;

/* A static that is touched, and where it is. */
typedef struct ground {
    uint32_t at;
    vxs_pose pose;
} ground;

typedef struct anchors {
    uint32_t count, ground_count;
    vxs_pose body;
    ground grounds[VXS_CONTACT_MAX_LOADS];
    anchor anchor[VXS_CONTACT_MAX_LOADS];
} anchors;

typedef struct friction {
    double sticking, sliding, stiffness, damping;
    double rate;    /* b_t / the time since the last tick */
    double pressed; /* the normal forces as damped, of those that contact told */
    const vxs_contact_static *statics;
    uint32_t now; /* which of both is this tick's */
    anchors ticks[2];
    vxs_contact_loads loads;
} friction;

static const vxs_effect_constant constants[] = {{"sticking", "", 0.4, 0, 10},
                                                {"sliding", "", 0.3, 0, 10},
                                                {"stiffness", "N/m", 1000, 1e-9, 1e12},
                                                {"damping", "Ns/m", 1, 0, 1e9}};

static vxs_result check(const vxs_effect *effect)
{
    return effect->as.friction.sliding <= effect->as.friction.sticking ? VXS_OK : VXS_PARAM;
}

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    friction *f = self;
    f->sticking = effect->as.friction.sticking;
    f->sliding = effect->as.friction.sliding;
    f->stiffness = effect->as.friction.stiffness;
    f->damping = effect->as.friction.damping;
    f->statics = config->statics;
}

static void attach(void *self, vxs_servo *servo)
{
    servo->config.contact.loads = &((friction *)self)->loads;
}

static double stiffness(const vxs_effect *effect, const vxs_servo_config *config)
{
    return effect->as.friction.stiffness + effect->as.friction.damping / config->coupling.sample_time;
}

static void reset(void *self, const vxs_pose *tip)
{
    friction *f = self;
    (void)tip;
    for (int n = 0; n < 2; n++) f->ticks[n].count = f->ticks[n].ground_count = 0;
}

static double without_denormals(double value)
{
    return fabs(value) < 1e-150 ? 0 : value;
}

static double length(const double v[4])
{
    return sqrt(vxsi_dot(v, v) + v[3] * v[3]);
}

static void add_cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] += a[j] * b[k] - a[k] * b[j];
    }
}

static void to_tangent(double v[3], const double normal[3])
{
    double along = vxsi_dot(v, normal);
    for (int i = 0; i < 3; i++) v[i] -= along * normal[i];
}

/* What anchors lose of their share goes, stretch and all, to those that gain: no more energy than there was,
 * since a mean's square is no more than the squares' mean. */
typedef struct pool {
    double share, sliding;
    double stretch[3], twist[3]; /* the twist along the normals that it was about */
} pool;

static void lose(pool *p, const anchor *a, double share)
{
    double lost = a->share - share;
    if (!(lost > 0)) return;
    p->share += lost;
    p->sliding += a->is_sliding ? lost : 0;
    for (int i = 0; i < 3; i++) {
        p->stretch[i] += lost * a->stretch[i];
        p->twist[i] += lost * (a->stretch[3] * a->normal[i]);
    }
}

static uint32_t name_of(const vxs_contact_load *load)
{
    return load->at * 128 + load->direction;
}

/* Which anchor each load had, NULL for none; and what is lost meanwhile. */
static void match(const vxs_contact_loads *now, const anchors *last, double force,
                  const anchor *before[VXS_CONTACT_MAX_LOADS], pool *p)
{
    const anchor *a = last->anchor, *end = a + last->count;
    memset(p, 0, sizeof *p);
    for (uint32_t n = 0; n < now->count; n++) {
        uint32_t name = name_of(&now->load[n]);
        while (a < end && a->name < name) lose(p, a++, 0);
        before[n] = a < end && a->name == name ? a++ : NULL;
        if (before[n]) lose(p, before[n], now->load[n].force / force);
    }
    while (a < end) lose(p, a++, 0);
    for (int i = 0; i < 3 && p->share > 0; i++) {
        p->stretch[i] /= p->share;
        p->twist[i] /= p->share;
    }
}

/* A body's motion since the last tick: the way of its origin, and the turn from now back to then. */
typedef struct motion {
    double way[3], back[3];
} motion;

/* Of the object, by its tip, and of a static; all 0 if that was not touched in the last tick. */
typedef struct motions {
    motion object, ground;
    double lever[3]; /* from the static's origin to the tip */
} motions;

static void move(const vxs_pose *before, const vxs_pose *now, motion *m)
{
    vxs_pose_turn(now->orientation, before->orientation, m->back);
    for (int i = 0; i < 3; i++) m->way[i] = now->position[i] - before->position[i];
}

/* Adds the way, times sign, of the body's point that is at `arm` from its origin now: exact, since what is
 * left out of each tick adds up where a body swings to and fro. */
static void add_way(const motion *m, const double arm[3], double sign, double way[3])
{
    double across[3] = {0, 0, 0}, inwards[3] = {0, 0, 0};
    add_cross(m->back, arm, across);
    add_cross(m->back, across, inwards);
    double cosine = sqrt(fmax(0, 1 - vxsi_dot(m->back, m->back) / 4));
    for (int i = 0; i < 3; i++) way[i] += sign * (m->way[i] - (cosine * across[i] + 0.5 * inwards[i]));
}

static void look_at_ground(const friction *f, uint32_t at, const anchors *last, anchors *next, motions *m)
{
    const vxs_pose identity = vxs_pose_identity(), *pose = f->statics[at].pose;
    ground *now = &next->grounds[next->ground_count++];
    const ground *before = last->grounds, *end = before + last->ground_count;
    now->at = at;
    now->pose = identity;
    if (pose) vxs_pose_compose(pose, &identity, &now->pose);
    memset(m, 0, sizeof *m);
    while (before < end && before->at != at) before++;
    if (before == end) return;
    move(&last->body, &next->body, &m->object);
    move(&before->pose, &now->pose, &m->ground);
    for (int i = 0; i < 3; i++) m->lever[i] = next->body.position[i] - now->pose.position[i];
}

/* What it had, turned along with the static and to the new normal; it keeps its length unless most of it
 * would be made up. */
static void turn_along(const anchor *before, const double normal[3], const motions *m, double stretch[4])
{
    memcpy(stretch, before->stretch, 4 * sizeof *stretch);
    double square = vxsi_dot(stretch, stretch);
    add_cross(before->stretch, m->ground.back, stretch);
    to_tangent(stretch, normal);
    double left = vxsi_dot(stretch, stretch);
    double factor = left > 0.25 * square ? sqrt(square / left) : 1;
    for (int i = 0; i < 3; i++) stretch[i] *= factor;
}

/* An anchor before its load moves: from what it had and what it gains. */
static void begin_anchor(anchor *a, const vxs_contact_load *load, const anchor *before, const pool *p,
                         const motions *m)
{
    double kept = before ? fmin(before->share, a->share) : 0, gained = p->share > 0 ? a->share - kept : 0;
    double own[4] = {0, 0, 0, 0}, pooled[4];
    if (before) turn_along(before, load->normal, m, own);
    memcpy(pooled, p->stretch, 3 * sizeof *pooled);
    to_tangent(pooled, load->normal);
    pooled[3] = vxsi_dot(p->twist, load->normal);
    for (int i = 0; i < 4; i++) a->stretch[i] = (kept * own[i] + gained * pooled[i]) / a->share;
    double sliding = before && before->is_sliding ? kept : 0;
    if (gained > 0) sliding += gained * (p->sliding / p->share);
    a->is_sliding = sliding > 0.5 * a->share;
    a->name = name_of(load);
    memcpy(a->normal, load->normal, sizeof a->normal);
}

/* Moves the object by `way` against the anchor, and drags the anchor to the cone if that is beyond it. Gives
 * the force that the anchor stands against. */
static void drag(const friction *f, anchor *a, const double way[4], double load, double force[4])
{
    double stiffness = f->stiffness * a->share, rate = f->rate * a->share;
    for (int i = 0; i < 4; i++) force[i] = stiffness * (a->stretch[i] + way[i]) + rate * way[i];
    load *= f->pressed;
    double size = length(force), most = (a->is_sliding ? f->sliding : f->sticking) * load;
    a->is_sliding = size > most;
    double factor = size > most ? f->sliding * load / size : 1;
    for (int i = 0; i < 4; i++) {
        force[i] *= factor;
        a->stretch[i] =
            factor < 1 ? (force[i] + rate * a->stretch[i]) / (stiffness + rate) : a->stretch[i] + way[i];
        a->stretch[i] = without_denormals(a->stretch[i]);
    }
}

static void add_friction(const friction *f, const vxs_contact_load *load, const motions *m, anchor *a,
                         vxs_wrench *wrench)
{
    double way[4] = {0, 0, 0, 0}, force[4], lever[3], turn[3], torque[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        lever[i] = m->lever[i] + load->arm[i];
        turn[i] = m->ground.back[i] - m->object.back[i];
    }
    add_way(&m->object, load->arm, 1, way);
    add_way(&m->ground, lever, -1, way);
    to_tangent(way, load->normal);
    way[3] = load->radius * vxsi_dot(turn, load->normal);
    drag(f, a, way, load->force, force);
    add_cross(load->arm, force, torque);
    for (int i = 0; i < 3; i++) {
        wrench->force[i] -= force[i];
        wrench->torque[i] -= torque[i] + load->radius * force[3] * load->normal[i];
    }
}

/* By how much contact-damping has changed contact's wrench: it multiplies all of it. */
static double share_of(const vxs_wrench *now, const vxs_wrench *before)
{
    double share = 1, most = 0;
    for (int i = 0; i < 6; i++) {
        const double was = i < 3 ? before->force[i] : before->torque[i - 3];
        if (!(fabs(was) > most)) continue;
        most = fabs(was);
        share = (i < 3 ? now->force[i] : now->torque[i - 3]) / was;
    }
    return share;
}

static void add(void *self, vxs_tick *tick)
{
    friction *f = self;
    const anchor *before[VXS_CONTACT_MAX_LOADS];
    pool p;
    motions m;
    double force = 0;
    if (tick->evaluation == 0) f->now = !f->now;
    f->rate = f->damping / tick->elapsed;
    f->pressed = share_of(&tick->wrench, &tick->contact.wrench);
    const anchors *last = &f->ticks[!f->now];
    anchors *next = &f->ticks[f->now];
    next->count = next->ground_count = 0;
    next->body = tick->body;
    for (uint32_t n = 0; n < f->loads.count; n++) force += f->loads.load[n].force;
    match(&f->loads, last, force, before, &p);
    for (uint32_t n = 0; n < f->loads.count; n++) {
        const vxs_contact_load *load = &f->loads.load[n];
        if (n == 0 || load->at != load[-1].at) look_at_ground(f, load->at, last, next, &m);
        anchor *a = &next->anchor[next->count++];
        a->share = load->force / force;
        begin_anchor(a, load, before[n], &p, &m);
        add_friction(f, load, &m, a, &tick->wrench);
    }
}

extern const vxs_effect_kind vxsi_stage_friction;
const vxs_effect_kind vxsi_stage_friction = {.effect = VXS_EFFECT_FRICTION,
                                             .name = "friction",
                                             .reads = "who presses how in contact, the object's motion",
                                             .changes = "contact",
                                             .size = sizeof(friction),
                                             .constants = constants,
                                             .constant_count = sizeof constants / sizeof *constants,
                                             .check = check,
                                             .set_up = set_up,
                                             .reset = reset,
                                             .stiffness = stiffness,
                                             .attach = attach,
                                             .add = add};
