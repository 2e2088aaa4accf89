/* SPDX-License-Identifier: MIT
 *
 * Hunt and Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", J. Applied Mechanics
 * 42 (1975): damping in proportion to the elastic force, so that it begins and ends with it.
 */
#include "object_motion.h"

#include <math.h>

typedef struct contact_damping {
    double factor, most, radius;
    vxsi_object_motion motion;
} contact_damping;

static const vxs_effect_constant constants[] = {{"factor", "s/m", 1, 0, 1e6}, {"most", "", 4, 1, 1e6}};

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    contact_damping *c = self;
    c->factor = effect->as.contact_damping.factor;
    c->most = effect->as.contact_damping.most;
    c->radius = config->shell->radius;
    vxsi_motion_set_up(&c->motion, config);
}

static void reset(void *self, const vxs_pose *tip)
{
    (void)tip;
    vxsi_motion_reset(&((contact_damping *)self)->motion);
}

/* What contact does to the statics that move is no approach. */
static double power_of_statics(const vxs_tick *tick)
{
    double power = 0;
    for (uint32_t n = 0; n < tick->moving->count; n++) {
        double velocity[3];
        vxsi_twist_at(&tick->moving->twists[n], tick->body.position, velocity);
        power += vxsi_dot(tick->moving->parts[n].force, velocity) +
                 vxsi_dot(tick->moving->parts[n].torque, tick->moving->twists[n].spin);
    }
    return power;
}

static void add(void *self, vxs_tick *tick)
{
    contact_damping *c = self;
    vxs_wrench *w = &tick->wrench;
    double torque[3];
    vxsi_motion_follow(&c->motion, tick);
    vxsi_cross(c->motion.arm, w->force, torque);
    for (int i = 0; i < 3; i++) torque[i] = w->torque[i] - torque[i]; /* about the middle */
    /* Forces that push one way have no more torque about the middle than |F| radius. Where they oppose each
     * other this is less than their sum, but still a part of it. */
    double size = fmax(sqrt(vxsi_dot(w->force, w->force)), sqrt(vxsi_dot(torque, torque)) / c->radius);
    if (!(size > 0)) return;
    double power = vxsi_dot(w->force, c->motion.velocity) + vxsi_dot(torque, c->motion.spin);
    if (tick->moving) power -= power_of_statics(tick);
    double factor = fmin(fmax(1 - c->factor * (power / size), 0), c->most);
    for (int i = 0; i < 3; i++) {
        w->force[i] *= factor;
        w->torque[i] *= factor;
    }
}

extern const vxs_effect_kind vxsi_stage_contact_damping;
const vxs_effect_kind vxsi_stage_contact_damping = {.effect = VXS_EFFECT_CONTACT_DAMPING,
                                                    .name = "contact-damping",
                                                    .reads = "contact's wrench, the object's velocity",
                                                    .size = sizeof(contact_damping),
                                                    .constants = constants,
                                                    .constant_count = sizeof constants / sizeof *constants,
                                                    .set_up = set_up,
                                                    .reset = reset,
                                                    .add = add};
