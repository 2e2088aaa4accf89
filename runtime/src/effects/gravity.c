/* SPDX-License-Identifier: MIT
 *
 * Weight: a constant force at the object's centre of mass.
 */
#include "../servo_stage.h"

#include <string.h>

typedef struct gravity {
    double weight[3]; /* [N], scene's frame */
    double arm[3];    /* from the object's tip, in its frame */
} gravity;

static const vxs_effect_constant constants[] = {{"mass", "kg", 0.1, 0, 1e6},
                                                {"com_x", "m", 0, -1e6, 1e6},
                                                {"com_y", "m", 0, -1e6, 1e6},
                                                {"com_z", "m", 0, -1e6, 1e6},
                                                {"acceleration_x", "m/s^2", 0, -1e6, 1e6},
                                                {"acceleration_y", "m/s^2", -9.80665, -1e6, 1e6},
                                                {"acceleration_z", "m/s^2", 0, -1e6, 1e6}};

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    gravity *g = self;
    vxs_pose com = vxs_pose_identity();
    memcpy(com.position, effect->as.gravity.com, sizeof com.position);
    vxs_pose_compose(&config->grip, &com, &com);
    memcpy(g->arm, com.position, sizeof g->arm);
    for (int axis = 0; axis < 3; axis++)
        g->weight[axis] = effect->as.gravity.mass * effect->as.gravity.acceleration[axis];
}

static void run(void *self, vxs_tick *tick)
{
    const gravity *g = self;
    const double *w = g->weight;
    double r[9], arm[3];
    if (!vxs_pose_rotation(&tick->body, r)) return;
    for (int i = 0; i < 3; i++)
        arm[i] = (r[3 * i] * g->arm[0] + r[3 * i + 1] * g->arm[1]) + r[3 * i + 2] * g->arm[2];
    const vxs_wrench weight = {
        {w[0], w[1], w[2]},
        {arm[1] * w[2] - arm[2] * w[1], arm[2] * w[0] - arm[0] * w[2], arm[0] * w[1] - arm[1] * w[0]}};
    vxs_tick_add_field(tick, &weight);
}

extern const vxs_effect_kind vxsi_stage_gravity;
const vxs_effect_kind vxsi_stage_gravity = {.effect = VXS_EFFECT_GRAVITY,
                                            .name = "gravity",
                                            .reads = "the object's orientation",
                                            .size = sizeof(gravity),
                                            .constants = constants,
                                            .constant_count = sizeof constants / sizeof *constants,
                                            .set_up = set_up,
                                            .run = run};
