/* SPDX-License-Identifier: MIT
 *
 * A viscous medium: Stokes' drag, linear in the object's velocity and turning.
 */
#include "object_motion.h"

typedef struct viscosity {
    double damping, turning;
    vxsi_object_motion motion;
} viscosity;

static const vxs_effect_constant constants[] = {{"damping", "Ns/m", 1, 0, 1e6},
                                                {"turning", "Nms/rad", 0, 0, 1e6}};

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    viscosity *v = self;
    v->damping = effect->as.viscosity.damping;
    v->turning = effect->as.viscosity.turning;
    vxsi_motion_set_up(&v->motion, config);
}

static double stiffness(const vxs_effect *effect, const vxs_servo_config *config)
{
    const double radius = config->shell->radius;
    return (effect->as.viscosity.damping + effect->as.viscosity.turning / (radius * radius)) /
           config->coupling.sample_time;
}

static void reset(void *self, const vxs_pose *tip)
{
    (void)tip;
    vxsi_motion_reset(&((viscosity *)self)->motion);
}

static void run(void *self, vxs_tick *tick)
{
    viscosity *v = self;
    vxs_wrench drag;
    vxsi_motion_follow(&v->motion, tick);
    for (int axis = 0; axis < 3; axis++) {
        drag.force[axis] = -v->damping * v->motion.velocity[axis];
        drag.torque[axis] = -v->turning * v->motion.spin[axis];
    }
    vxsi_at_middle(&v->motion, &drag);
    vxs_tick_add_field(tick, &drag);
}

extern const vxs_effect_kind vxsi_stage_viscosity;
const vxs_effect_kind vxsi_stage_viscosity = {.effect = VXS_EFFECT_VISCOSITY,
                                              .name = "viscosity",
                                              .reads = "the object's velocity",
                                              .size = sizeof(viscosity),
                                              .constants = constants,
                                              .constant_count = sizeof constants / sizeof *constants,
                                              .stiffness = stiffness,
                                              .set_up = set_up,
                                              .reset = reset,
                                              .run = run};
