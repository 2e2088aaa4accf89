/* SPDX-License-Identifier: MIT
 *
 * Set-up of the simulated device: profiles, arms, opening.
 */
#include "simulated_model.h"

#include <math.h>
#include <string.h>

enum { ALIGNMENT = 16, MAX_SUBSTEPS = 1000 };

/* name, peak N, continuous N, peak N m, K N/m, B N s/m, step m, mass kg, friction N, viscosity N s/m, rate Hz
 */
static const vxs_simulated_profile profiles[] = {
    {"touch", 3.3, 0.88, 0, 400, 4, 55e-6, 0.045, 0.26, 0.15, 1000},
    {"omni", 3.3, 0.88, 0, 700, 5, 55e-6, 0.045, 0.26, 0.15, 1000},
    {"desktop", 7.9, 1.75, 0, 1000, 5, 23e-6, 0.045, 0.06, 0.1, 1000},
    {"phantom-premium-1.5", 8.5, 1.4, 0.188, 800, 5, 30e-6, 0.075, 0.04, 0.1, 1000},
    {"phantom-premium-3.0", 22, 3, 0, 1000, 5, 20e-6, 0.15, 0.2, 0.1, 1000},
    {"falcon", 8, 0, 0, 3000, 20, 38e-6, 0.3, 0.7, 1, 1000},
    {"omega-3", 12, 0, 0, 5000, 30, 10e-6, 0.22, 0.5, 0.5, 4000},
    {"delta-3", 20, 0, 0, 5000, 30, 30e-6, 0.25, 0.5, 0.5, 4000},
    {"inverse3", 10, 0, 0, 1000, 6, 10e-6, 0.15, 0.1, 0.1, 1000},
    {"dlr-lwr", 100, 0, 0, 5000, 50, 50e-6, 5, 1, 20, 1000},
};
enum { PROFILES = sizeof profiles / sizeof *profiles };

static const vxs_simulated_arm arms[] = {
    {"free", 0, 0, 0},
    {"pen", 0.02, 2, 200},
    {"hand", 0.15, 5, 500},
    {"arm", 1.5, 15, 300},
};
enum { ARMS = sizeof arms / sizeof *arms };

const vxs_simulated_profile *vxs_simulated_profile_at(uint32_t index)
{
    return index < PROFILES ? &profiles[index] : NULL;
}

const vxs_simulated_profile *vxs_simulated_profile_named(const char *name)
{
    for (int n = 0; name && n < PROFILES; n++) {
        if (strcmp(profiles[n].name, name) == 0) return &profiles[n];
    }
    return NULL;
}

const vxs_simulated_arm *vxs_simulated_arm_at(uint32_t index)
{
    return index < ARMS ? &arms[index] : NULL;
}

const vxs_simulated_arm *vxs_simulated_arm_named(const char *name)
{
    for (int n = 0; name && n < ARMS; n++) {
        if (strcmp(arms[n].name, name) == 0) return &arms[n];
    }
    return NULL;
}

void vxs_simulated_config_default(vxs_simulated_config *config, const vxs_simulated_profile *profile)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->delay_samples = 1;
    config->substeps = 16;
    config->profile = *(profile ? profile : vxs_simulated_profile_named("phantom-premium-1.5"));
    config->arm = *vxs_simulated_arm_named("hand");
    config->sample_time = 1 / config->profile.rate_hz;
    config->start = vxs_pose_identity();
    config->seed = 1;
}

static int not_negative(double value)
{
    return isfinite(value) && value >= 0;
}

static vxs_result check_config(const vxs_simulated_config *config)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    const vxs_simulated_profile *p = &config->profile;
    const vxs_simulated_arm *a = &config->arm;
    const double numbers[] = {
        p->peak_force, p->continuous_force, p->peak_torque, p->max_stiffness, p->max_damping, p->resolution,
        p->mass,       p->friction,         p->viscosity,   a->mass,          a->viscosity,   a->stiffness};
    for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++) {
        if (!not_negative(numbers[n])) return VXS_PARAM;
    }
    double rotation[9];
    int is_good = p->name && a->name && p->mass > 0 && p->peak_force > 0 && config->delay_samples >= 1 &&
                  config->delay_samples <= VXSI_SIMULATED_MAX_DELAY && config->substeps >= 1 &&
                  config->substeps <= MAX_SUBSTEPS && config->sample_time >= 1e-5 &&
                  config->sample_time <= 0.1 && vxs_pose_rotation(&config->start, rotation) &&
                  not_negative(config->noise) && config->loss >= 0 && config->loss <= 0.9 &&
                  config->loss_time >= 0 && config->loss_time <= 10;
    return is_good ? VXS_OK : VXS_PARAM;
}

/* Nothing that was commanded before acts after. */
static void let_go(vxsi_simulated *s)
{
    memset(&s->command, 0, sizeof s->command);
    memset(s->line, 0, sizeof s->line);
}

static vxs_result arm(void *self)
{
    vxsi_simulated *s = self;
    if (s->heard.state == VXS_DEVICE_GONE) return VXS_LOST;
    if (s->heard.state == VXS_DEVICE_ARMED) return VXS_OK;
    if (s->heard.state != VXS_DEVICE_READY) return VXS_STATE;
    let_go(s);
    s->heard.state = VXS_DEVICE_ARMED;
    return VXS_OK;
}

static vxs_result disarm(void *self)
{
    vxsi_simulated *s = self;
    if (s->heard.state == VXS_DEVICE_GONE) return VXS_LOST;
    if (s->heard.state == VXS_DEVICE_CLOSED) return VXS_STATE;
    s->heard.state = VXS_DEVICE_READY;
    s->heard.fault = VXS_DEVICE_FAULT_NONE;
    let_go(s);
    return VXS_OK;
}

static void close_device(void *self)
{
    vxsi_simulated *s = self;
    s->heard.state = VXS_DEVICE_CLOSED;
}

static const vxs_device_ops ops = {.name = "simulated",
                                   .arm = arm,
                                   .disarm = disarm,
                                   .close = close_device,
                                   .exchange = vxsi_simulated_exchange};

static void fill_caps(const vxs_simulated_config *config, vxs_device_caps *caps)
{
    const vxs_simulated_profile *p = &config->profile;
    strncpy(caps->name, p->name, sizeof caps->name - 1);
    caps->dof_sensed = VXS_DEVICE_DOF_TRANSLATION | VXS_DEVICE_DOF_ROTATION;
    caps->dof_actuated = VXS_DEVICE_DOF_TRANSLATION | (p->peak_torque > 0 ? VXS_DEVICE_DOF_ROTATION : 0u);
    caps->rate_hz = 1 / config->sample_time;
    caps->peak_force = p->peak_force;
    caps->continuous_force = p->continuous_force;
    caps->peak_torque = p->peak_torque;
    caps->max_stiffness = p->max_stiffness;
    caps->max_damping = p->max_damping;
    caps->resolution = p->resolution;
    caps->mass = p->mass;
    caps->friction = p->friction;
    caps->viscosity = p->viscosity;
    caps->delay_samples = config->delay_samples;
    caps->assumed = 1;
}

size_t vxs_simulated_memory(void)
{
    return (sizeof(vxsi_simulated) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

vxs_result vxs_simulated_open(void *memory, size_t size, const vxs_simulated_config *config, vxs_device **out)
{
    vxs_result result = check_config(config);
    if (result != VXS_OK) return result;
    if (!memory || !out) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_simulated_memory()) return VXS_BUFFER;
    vxsi_simulated *s = memory;
    memset(s, 0, sizeof *s);
    s->device.ops = &ops;
    s->device.self = s;
    s->config = *config;
    s->heard.state = VXS_DEVICE_READY;
    s->sample_ns = (int64_t)(config->sample_time * 1e9 + 0.5);
    s->random = (config->seed + 1) * 0x9E3779B97F4A7C15u | 1;
    double samples = floor(config->loss_time / config->sample_time + 0.5);
    s->lost_each = samples < 1 ? 1 : (uint32_t)samples;
    /* So often that drop-outs' share of all time is the loss. */
    s->lost_below =
        (uint32_t)(4294967296.0 * config->loss / ((1 - config->loss) * s->lost_each + config->loss));
    fill_caps(config, &s->device.caps);
    for (int axis = 0; axis < 3; axis++) {
        s->position[axis] = s->hand[axis] = s->target[axis] = config->start.position[axis];
        s->heard.pose.position[axis] = vxsi_simulated_encode(s, s->position[axis]);
    }
    memcpy(s->orientation, config->start.orientation, sizeof s->orientation);
    memcpy(s->heard.pose.orientation, s->orientation, sizeof s->orientation);
    s->heard.velocity_source = VXS_DEVICE_VELOCITY_ESTIMATED;
    *out = &s->device;
    return VXS_OK;
}

/* Of no tick: for those who look on, and for tests. */
void vxs_simulated_truth(const vxs_device *device, double position[3], double velocity[3])
{
    const vxsi_simulated *s = device->self;
    if (position) memcpy(position, s->position, sizeof s->position);
    if (velocity) memcpy(velocity, s->velocity, sizeof s->velocity);
}

void vxs_simulated_break(vxs_device *device, uint32_t fault)
{
    vxsi_simulated *s = device->self;
    s->broken = fault;
}
