/* SPDX-License-Identifier: MIT
 *
 * Walls around where the tip may be: a one-sided spring and damper on each side of a box.
 */
#include "../servo_stage.h"

#include <math.h>
#include <string.h>

static const double full_depth = 0.001; /* [m] where the damper is all there: it does not begin with a jump */

typedef struct workspace {
    double low[3], high[3], stiffness, damping;
    double at[3]; /* in the tick before */
    uint32_t is_known;
} workspace;

static const vxs_effect_constant constants[] = {
    {"low_x", "m", -0.1, -1e6, 1e6},   {"low_y", "m", -0.1, -1e6, 1e6}, {"low_z", "m", -0.1, -1e6, 1e6},
    {"high_x", "m", 0.1, -1e6, 1e6},   {"high_y", "m", 0.1, -1e6, 1e6}, {"high_z", "m", 0.1, -1e6, 1e6},
    {"stiffness", "N/m", 500, 0, 1e6}, {"damping", "Ns/m", 2, 0, 1e6}};

static vxs_result check(const vxs_effect *effect)
{
    for (int axis = 0; axis < 3; axis++)
        if (!(effect->as.workspace.low[axis] < effect->as.workspace.high[axis])) return VXS_PARAM;
    return VXS_OK;
}

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    workspace *w = self;
    (void)config;
    memcpy(w->low, effect->as.workspace.low, sizeof w->low);
    memcpy(w->high, effect->as.workspace.high, sizeof w->high);
    w->stiffness = effect->as.workspace.stiffness;
    w->damping = effect->as.workspace.damping;
}

static void reset(void *self, const vxs_pose *tip)
{
    (void)tip;
    ((workspace *)self)->is_known = 0;
}

/* Back inside, never farther out. outwards [m/s]. */
static double push(const workspace *w, double depth, double outwards)
{
    return fmax(0, w->stiffness * depth + w->damping * fmin(1, depth / full_depth) * outwards);
}

static void run(void *self, vxs_tick *tick)
{
    workspace *w = self;
    vxs_wrench wall = {{0, 0, 0}, {0, 0, 0}};
    int is_outside = 0;
    for (int axis = 0; axis < 3; axis++) {
        const double at = tick->tip.position[axis],
                     velocity = w->is_known ? (at - w->at[axis]) / tick->elapsed : 0;
        if (at < w->low[axis])
            wall.force[axis] = push(w, w->low[axis] - at, -velocity);
        else if (at > w->high[axis])
            wall.force[axis] = -push(w, at - w->high[axis], velocity);
        else
            continue;
        is_outside = 1;
    }
    memcpy(w->at, tick->tip.position, sizeof w->at);
    w->is_known = 1;
    if (is_outside) vxs_tick_add_to_hand(tick, &wall);
}

extern const vxs_effect_kind vxsi_stage_workspace;
const vxs_effect_kind vxsi_stage_workspace = {.effect = VXS_EFFECT_WORKSPACE,
                                              .name = "workspace",
                                              .reads = "the tip's position and velocity",
                                              .size = sizeof(workspace),
                                              .constants = constants,
                                              .constant_count = sizeof constants / sizeof *constants,
                                              .check = check,
                                              .set_up = set_up,
                                              .reset = reset,
                                              .run = run};
