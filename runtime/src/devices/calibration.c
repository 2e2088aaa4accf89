/* SPDX-License-Identifier: MIT
 *
 * A known mass on a device's tip.
 */
#include "voxshell/calibration.h"

#include <math.h>
#include <string.h>

enum { ALIGNMENT = 16, EMPTY_PERIODS = 3 };
static const double agree = 0.01, notice = 0.1; /* of the weight: two periods agree; a mass was hung */
static const double lag = 0.01;                 /* [s] of the speed */

struct vxs_calibration {
    vxs_calibration_config config;
    vxs_calibration_result result;
    uint32_t has_begun, in_period, period_samples, saturated;
    uint64_t sequence, samples, patience_samples;
    double begin[3], behind[3], speed[3], low, high; /* low, high: of this period, along down [m] */
    double sum, last;                                /* of this period; mean of the one before [N] */
};

void vxs_calibration_config_default(vxs_calibration_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->down[1] = -1;
    config->gravity = 9.81;
    config->sample_time = 0.001;
    config->stiffness = 400;
    config->damping = 2;
    config->way = 0.01;
    config->period = 2;
    config->patience = 60;
    config->max_force = 6;
    config->max_speed = 1;
}

size_t vxs_calibration_memory(void)
{
    return (sizeof(vxs_calibration) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static int is_within(double value, double least, double most)
{
    return value >= least && value <= most;
}

static vxs_result check(const vxs_calibration_config *c)
{
    if (!c) return VXS_PARAM;
    if (c->struct_size != sizeof *c) return VXS_CONFIG;
    double length = sqrt(c->down[0] * c->down[0] + c->down[1] * c->down[1] + c->down[2] * c->down[2]);
    return is_within(c->mass, 1e-6, 1e3) && is_within(length, 1 - 1e-6, 1 + 1e-6) &&
                   is_within(c->gravity, 1e-3, 1e3) && is_within(c->sample_time, 1e-4, 0.01) &&
                   is_within(c->stiffness, 1e-3, 1e6) && is_within(c->damping, 0, 1e4) &&
                   is_within(c->way, 1e-6, 1) && is_within(c->period, 0.2, 60) &&
                   is_within(c->patience, 1e-3, 1e6) && is_within(c->max_force, 1e-3, 1e4) &&
                   is_within(c->max_speed, 1e-3, 1e3)
               ? VXS_OK
               : VXS_PARAM;
}

vxs_result vxs_calibration_init(void *memory, size_t size, const vxs_calibration_config *config,
                                vxs_calibration **out)
{
    vxs_result result = check(config);
    if (result != VXS_OK) return result;
    if (!memory || !out) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_calibration_memory()) return VXS_BUFFER;
    vxs_calibration *c = memory;
    memset(c, 0, sizeof *c);
    c->config = *config;
    c->period_samples = (uint32_t)(config->period / config->sample_time + 0.5);
    c->patience_samples = (uint64_t)(config->patience / config->sample_time + 0.5);
    c->low = INFINITY;
    c->high = -INFINITY;
    *out = c;
    return VXS_OK;
}

/* Up and down evenly, -1 .. 1, a period of it from 0 to 1. */
static double triangle(double share)
{
    return share < 0.25 ? 4 * share : share < 0.75 ? 2 - 4 * share : 4 * share - 4;
}

static void end(vxs_calibration *c, uint32_t phase)
{
    c->result.phase = phase;
}

/* A whole period is over: its mean, beside the one before. The first of all holds the device's ramp. Where
 * friction held the tip a mean says nothing. */
static void judge(vxs_calibration *c, double mean)
{
    vxs_calibration_result *r = &c->result;
    if (c->high - c->low < c->config.way) return;
    double weight = c->config.mass * c->config.gravity, before = c->last;
    c->last = mean;
    r->periods++;
    r->spread = fabs(mean - before);
    if (r->phase == VXS_CALIBRATION_EMPTY) {
        if (r->periods < EMPTY_PERIODS || r->spread > agree * weight) return;
        r->empty = (mean + before) / 2;
        r->phase = VXS_CALIBRATION_HANG;
        c->samples = 0;
    } else if (r->phase == VXS_CALIBRATION_HANG) {
        if (mean - r->empty > notice * weight) r->phase = VXS_CALIBRATION_LOADED;
    } else if (c->saturated == c->period_samples) {
        end(c, VXS_CALIBRATION_TOO_HEAVY);
    } else if (mean - r->empty <= notice * weight) {
        r->phase = VXS_CALIBRATION_HANG; /* it was only a hand */
    } else if (r->spread <= agree * weight) {
        r->loaded = (mean + before) / 2;
        r->scale = (r->loaded - r->empty) / weight;
        end(c, VXS_CALIBRATION_DONE);
    }
}

static void hold(vxs_calibration *c, const vxs_device_state *state, double force[3])
{
    const vxs_calibration_config *config = &c->config;
    double share = (double)c->in_period / (double)c->period_samples,
           fresh = config->sample_time / (lag + config->sample_time);
    for (int n = 0; n < 3; n++) {
        /* From what trails behind: packets that come in bursts are no speed. */
        c->behind[n] += fresh * (state->pose.position[n] - c->behind[n]);
        c->speed[n] = (state->pose.position[n] - c->behind[n]) / lag;
        double target = c->begin[n] + config->way * triangle(share) * config->down[n];
        force[n] = config->stiffness * (target - state->pose.position[n]) - config->damping * c->speed[n];
    }
    double factor = vxs_device_clamp_factor(force, config->max_force);
    for (int n = 0; n < 3; n++) force[n] *= factor;
    c->saturated += factor < 1;
}

uint32_t vxs_calibration_tick(vxs_calibration *c, const vxs_device_state *state, vxs_device_command *command)
{
    memset(command, 0, sizeof *command);
    if (c->result.phase >= VXS_CALIBRATION_DONE) return c->result.phase;
    if (!c->has_begun) {
        memcpy(c->begin, state->pose.position, sizeof c->begin);
        memcpy(c->behind, state->pose.position, sizeof c->behind);
    }
    c->has_begun = 1;
    double *speed = c->speed;
    hold(c, state, command->wrench.force);
    if (state->state != VXS_DEVICE_ARMED ||
        !(speed[0] * speed[0] + speed[1] * speed[1] + speed[2] * speed[2] <
          c->config.max_speed * c->config.max_speed)) {
        memset(command, 0, sizeof *command);
        end(c, VXS_CALIBRATION_LET_GO);
        return c->result.phase;
    }
    command->sequence = ++c->sequence;
    command->hold_ns = state->time_ns + (int64_t)(2e9 * c->config.sample_time);
    command->expires_ns = command->hold_ns + 10000000;
    double along = 0;
    for (int n = 0; n < 3; n++) {
        c->sum -= command->wrench.force[n] * c->config.down[n];
        along += state->pose.position[n] * c->config.down[n];
    }
    c->low = fmin(c->low, along);
    c->high = fmax(c->high, along);
    c->samples++;
    if (++c->in_period == c->period_samples) {
        judge(c, c->sum / c->period_samples);
        c->sum = 0;
        c->in_period = c->saturated = 0;
        c->low = INFINITY;
        c->high = -INFINITY;
    }
    if (c->result.phase < VXS_CALIBRATION_DONE && c->samples > c->patience_samples)
        end(c, VXS_CALIBRATION_IMPATIENT);
    if (c->result.phase >= VXS_CALIBRATION_DONE) memset(command, 0, sizeof *command);
    return c->result.phase;
}

void vxs_calibration_get(const vxs_calibration *c, vxs_calibration_result *result)
{
    *result = c->result;
}
