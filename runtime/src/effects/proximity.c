/* SPDX-License-Identifier: MIT
 *
 * A braking field before contact: damping of the approach that grows as the gap closes. Each point within
 * reach of a static brakes along the way out from it; their mean, by how near they are, so that nothing jumps
 * where another point comes to be the nearest.
 */
#include "../contact_state.h"
#include "../servo_state.h"
#include "object_motion.h"

#include <string.h>

typedef struct proximity {
    double damping, reach;
    const vxs_contact *contact;
    const vxs_contact_static *statics;
    uint32_t static_count;
    vxs_pose grip;
    double middle[3]; /* shell's frame */
    vxsi_object_motion motion;
} proximity;

/* Sums over points, shell's frame, about the middle. */
typedef struct brake {
    const double *middle;
    double reach, velocity[3], spin[3]; /* of the object relative to the static */
    double weight, most, force[3], torque[3];
} brake;

static const vxs_effect_constant constants[] = {{"damping", "Ns/m", 5, 0, 1e6},
                                                {"reach", "m", 0.003, 1e-9, 1e3}};

static vxs_result fits(const vxs_effect *effect, const vxs_servo_config *config)
{
    for (uint32_t n = 0; config->statics && n < config->static_count && n < VXS_CONTACT_MAX_STATICS; n++) {
        const vxs_voxmap *map = config->statics[n].map;
        if (map && !(vxs_contact_has_field(map, VXS_CONTACT_DISTANCE) &&
                     map->distance_band >= effect->as.proximity.reach))
            return VXS_CHANNEL;
    }
    return VXS_OK;
}

static double stiffness(const vxs_effect *effect, const vxs_servo_config *config)
{
    return effect->as.proximity.damping / config->coupling.sample_time;
}

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    proximity *p = self;
    p->damping = effect->as.proximity.damping;
    p->reach = effect->as.proximity.reach;
    p->grip = config->grip;
    memcpy(p->middle, config->shell->center, sizeof p->middle);
    vxsi_motion_set_up(&p->motion, config);
}

static void attach(void *self, vxs_servo *servo)
{
    proximity *p = self;
    p->contact = servo->contact;
    p->statics = servo->config.statics;
    p->static_count = servo->config.static_count;
}

static void reset(void *self, const vxs_pose *tip)
{
    (void)tip;
    vxsi_motion_reset(&((proximity *)self)->motion);
}

static void add_point(void *self, const double at[3], double distance, const double outwards[3])
{
    brake *b = self;
    const double arm[3] = {at[0] - b->middle[0], at[1] - b->middle[1], at[2] - b->middle[2]};
    const double share = 1 - (distance < 0 ? -distance : distance) / b->reach, weight = share * share;
    double velocity[3], torque[3];
    vxsi_cross(b->spin, arm, velocity);
    for (int i = 0; i < 3; i++) velocity[i] += b->velocity[i];
    b->weight += weight;
    if (weight > b->most) b->most = weight;
    const double approach = -vxsi_dot(velocity, outwards);
    if (!(approach > 0)) return;
    vxsi_cross(arm, outwards, torque);
    for (int i = 0; i < 3; i++) {
        b->force[i] += weight * approach * outwards[i];
        b->torque[i] += weight * approach * torque[i];
    }
}

/* The velocity relative to a static, shell's frame. */
static void look_from(brake *b, const proximity *p, const vxs_tick *tick, uint32_t n, const double turn[9])
{
    double velocity[3], spin[3], own[3];
    memcpy(velocity, p->motion.velocity, sizeof velocity);
    memcpy(spin, p->motion.spin, sizeof spin);
    if (tick->moving) {
        vxsi_twist_at(&tick->moving->twists[n], p->motion.next_at, own);
        for (int i = 0; i < 3; i++) {
            velocity[i] -= own[i];
            spin[i] -= tick->moving->twists[n].spin[i];
        }
    }
    vxsi_rotate_back(turn, velocity, b->velocity);
    vxsi_rotate_back(turn, spin, b->spin);
}

static void run(void *self, vxs_tick *tick)
{
    proximity *p = self;
    brake b = {.middle = p->middle, .reach = p->reach};
    vxs_pose object;
    double turn[9];
    vxsi_motion_follow(&p->motion, tick);
    if (!vxs_pose_compose(&tick->body, &p->grip, &object) || !vxs_pose_rotation(&object, turn)) return;
    for (uint32_t n = 0; n < p->static_count; n++) {
        look_from(&b, p, tick, n, turn);
        vxsi_contact_near(p->contact, n, p->statics[n].map, p->reach, add_point, &b);
    }
    if (!(b.weight > 0)) return;
    vxs_wrench wrench;
    vxsi_rotate(turn, b.force, wrench.force);
    vxsi_rotate(turn, b.torque, wrench.torque);
    const double factor = p->damping * b.most / b.weight;
    for (int i = 0; i < 3; i++) {
        wrench.force[i] *= factor;
        wrench.torque[i] *= factor;
    }
    vxsi_at_middle(&p->motion, &wrench);
    vxs_tick_add_field(tick, &wrench);
}

extern const vxs_effect_kind vxsi_stage_proximity;
const vxs_effect_kind vxsi_stage_proximity = {
    .effect = VXS_EFFECT_PROXIMITY,
    .name = "proximity",
    .reads = "the distance channel around the points, the object's velocity",
    .size = sizeof(proximity),
    .constants = constants,
    .constant_count = sizeof constants / sizeof *constants,
    .fits = fits,
    .stiffness = stiffness,
    .set_up = set_up,
    .attach = attach,
    .reset = reset,
    .run = run};
