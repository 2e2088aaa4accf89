/* SPDX-License-Identifier: MIT
 *
 * The replay device's sample. rt-safe.
 */
#include "replay_model.h"

#include <math.h>
#include <string.h>

static int is_finite(const double v[3])
{
    return isfinite(fabs(v[0]) + fabs(v[1]) + fabs(v[2]));
}

/* Rows are passed as time goes on, so a sample costs what it passes. */
static void place(vxsi_replay *r, double time, vxs_pose *pose, uint32_t *buttons)
{
    const vxs_replay_row *rows = r->config.rows;
    double reached = time + 1e-6 * r->config.sample_time; /* a row that is on the sample but for rounding */
    while (r->at + 1 < r->config.row_count && rows[r->at + 1].time <= reached) r->at++;
    const vxs_replay_row *from = &rows[r->at];
    *pose = from->pose;
    *buttons = from->buttons;
    if (r->at + 1 == r->config.row_count || time <= from->time) return;
    double share = (time - from->time) / (from[1].time - from->time);
    for (int n = 0; n < 3; n++)
        pose->position[n] += share * (from[1].pose.position[n] - from->pose.position[n]);
}

void vxsi_replay_exchange(void *self, const vxs_device_command *command, vxs_device_state *state,
                          vxs_device_report *report)
{
    vxsi_replay *r = self;
    if (command && r->state == VXS_DEVICE_ARMED &&
        !(is_finite(command->wrench.force) && is_finite(command->wrench.torque))) {
        r->state = VXS_DEVICE_FAULT;
        r->fault = VXS_DEVICE_FAULT_SOFTWARE;
    }
    memset(state, 0, sizeof *state);
    state->sequence = ++r->sequence;
    state->time_ns = r->time_ns += r->sample_ns;
    place(r, r->config.rows[0].time + (double)(r->sequence - 1) * r->config.sample_time, &state->pose,
          &state->buttons);
    for (int n = 0; n < 3; n++)
        state->velocity[n] =
            r->sequence > 1 ? (state->pose.position[n] - r->last[n]) / r->config.sample_time : 0;
    memcpy(r->last, state->pose.position, sizeof r->last);
    state->velocity_source = VXS_DEVICE_VELOCITY_ESTIMATED;
    state->state = r->state;
    state->fault = r->fault;
    if (report) memset(report, 0, sizeof *report);
}
