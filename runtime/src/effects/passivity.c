/* SPDX-License-Identifier: MIT
 *
 * Hannaford and Ryu, "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics and
 * Automation 18 (2002), in the position form of Ryu, Kim and Hannaford (2004). All in the device's frame,
 * where the hand does work.
 */
#include "../servo_state.h"
#include "../vector.h"

#include <math.h>
#include <string.h>

static const double nothing = 1e-6; /* [N], [N m]: what was taken is forgotten below it */

typedef struct passivity {
    double sample_time, most_damping, least_way, radius_square;
    uint32_t delay;                            /* d */
    uint32_t at;                               /* where the newest command stands in `sent` */
    double energy;                             /* taken from the hand [J] */
    vxs_pose last;                             /* measured by the tick before */
    vxs_wrench sent[VXS_EFFECT_MAX_DELAY + 1]; /* a ring of the last d + 1 */
} passivity;

static const vxs_effect_constant constants[] = {{"most_damping", "Ns/m", 5, 1e-12, 1e12},
                                                {"least_speed", "m/s", 0.001, 0, 1e12},
                                                {"radius", "m", 0, 0, 1e3},
                                                {"delay", "", 1, 0, VXS_EFFECT_MAX_DELAY}};

static vxs_result check(const vxs_effect *effect)
{
    return effect->as.passivity.delay == floor(effect->as.passivity.delay) ? VXS_OK : VXS_PARAM;
}

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    passivity *p = self;
    p->sample_time = config->coupling.sample_time;
    p->most_damping = effect->as.passivity.most_damping;
    p->least_way = effect->as.passivity.least_speed * p->sample_time;
    p->radius_square = effect->as.passivity.radius * effect->as.passivity.radius;
    p->delay = (uint32_t)effect->as.passivity.delay;
}

static void attach(void *self, vxs_servo *servo)
{
    if (!servo->has_torque) ((passivity *)self)->radius_square = 0;
}

static double largest(const vxs_wrench *w)
{
    double most = 0;
    for (int axis = 0; axis < 3; axis++) most = fmax(most, fmax(fabs(w->force[axis]), fabs(w->torque[axis])));
    return most;
}

typedef struct motion {
    double way[3], turn[3]; /* turn is 0 if turning does not count */
} motion;

static double work(const vxs_wrench *w, const motion *m)
{
    return vxsi_dot(w->force, m->way) + vxsi_dot(w->torque, m->turn);
}

static void reset(void *self, const vxs_pose *tip)
{
    passivity *p = self;
    (void)tip;
    p->energy = 0;
    memset(&p->last, 0, sizeof p->last); /* no orientation: the next tick has no motion */
    memset(p->sent, 0, sizeof p->sent);
}

static void measure(passivity *p, const vxs_pose *measured, motion *m)
{
    const vxs_pose identity = vxs_pose_identity();
    vxs_pose now;
    memset(m, 0, sizeof *m);
    if (!vxs_pose_compose(measured, &identity, &now)) return;
    const double *q = p->last.orientation;
    if (q[0] != 0 || q[1] != 0 || q[2] != 0 || q[3] != 0) {
        for (int axis = 0; axis < 3; axis++) m->way[axis] = now.position[axis] - p->last.position[axis];
        if (p->radius_square > 0) vxs_pose_turn(q, now.orientation, m->turn);
    }
    p->last = now;
}

static void run(void *self, vxs_tick *tick)
{
    passivity *p = self;
    motion m;
    measure(p, &tick->state->pose, &m);
    p->at = p->at == p->delay ? 0 : p->at + 1;
    p->sent[p->at] = *tick->last;
    uint32_t oldest = p->at == p->delay ? 0 : p->at + 1;
    double given = work(&p->sent[oldest], &m);
    /* A command that decayed took less than it would have; it gave no more. */
    if (given > 0 || !(tick->flags & VXS_SERVO_MISSED)) p->energy -= given;
    if (p->energy > 0 && tick->contact.points == 0 && tick->contact.deep_points == 0 &&
        largest(&tick->wrench) < nothing)
        p->energy = 0;

    double after = p->energy - work(&tick->wrench, &m);
    for (uint32_t n = 0; n <= p->delay; n++)
        if (n != oldest) after -= work(&p->sent[n], &m);
    double way_square = vxsi_dot(m.way, m.way) + p->radius_square * vxsi_dot(m.turn, m.turn);
    tick->energy = p->energy;
    if (!(after < 0) || !(way_square > p->least_way * p->least_way)) return;
    double damping = fmin(-after * p->sample_time / way_square, p->most_damping);
    for (int axis = 0; axis < 3; axis++) {
        tick->wrench.force[axis] -= damping * (m.way[axis] / p->sample_time);
        tick->wrench.torque[axis] -= damping * p->radius_square * (m.turn[axis] / p->sample_time);
    }
    tick->damping = damping;
    tick->flags |= VXS_SERVO_DAMPED;
}

extern const vxs_effect_kind vxsi_stage_passivity;
const vxs_effect_kind vxsi_stage_passivity = {.effect = VXS_EFFECT_PASSIVITY,
                                              .is_guard = 1,
                                              .name = "passivity",
                                              .reads = "the device's motion, its own commands",
                                              .size = sizeof(passivity),
                                              .constants = constants,
                                              .constant_count = sizeof constants / sizeof *constants,
                                              .check = check,
                                              .set_up = set_up,
                                              .attach = attach,
                                              .reset = reset,
                                              .run = run};
