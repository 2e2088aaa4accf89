/* SPDX-License-Identifier: MIT
 *
 * Set-up of couplings: the table of kinds, their limits, their constants.
 */
#include "coupling_ops.h"

#include <math.h>
#include <string.h>

enum { ALIGNMENT = 16 };

static const double pi = 3.14159265358979323846;

static int is_positive(double value)
{
    return isfinite(value) && value > 0;
}

static vxs_result check_damping(const vxs_coupling_config *config)
{
    return config->damping >= VXS_COUPLING_MIN_DAMPING && config->damping <= VXS_COUPLING_MAX_DAMPING
               ? VXS_OK
               : VXS_DAMPING;
}

static vxs_result check_none(const vxs_coupling_config *config)
{
    (void)config;
    return VXS_OK;
}

static vxs_result check_pt2(const vxs_coupling_config *config)
{
    double hertz = config->omega0 / (2 * pi);
    /* A hair of 1e-12: 2 pi 0.05 Hz must not fail by rounding. */
    if (!(hertz >= VXS_COUPLING_MIN_HZ * (1 - 1e-12) &&
          hertz * config->sample_time <= VXS_COUPLING_MAX_RATE * (1 + 1e-12)))
        return VXS_FREQUENCY;
    vxs_result result = check_damping(config);
    if (result != VXS_OK) return result;
    return is_positive(config->gain) ? VXS_OK : VXS_GAIN;
}

static vxs_result check_spring_damper(const vxs_coupling_config *config)
{
    if (!is_positive(config->stiffness) || !is_positive(config->mass) || !is_positive(config->radius))
        return VXS_IMPEDANCE;
    return check_damping(config);
}

/* Tustin's g: half a sample of w0. */
static double half_sample(const vxs_coupling_config *config)
{
    double g = config->omega0 * config->sample_time / 2;
    return config->prewarp ? tan(g) : g;
}

static void set_up_none(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    (void)coupling;
    (void)config;
}

static void set_up_pt2(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    double g = half_sample(config);
    vxsi_pt2 *pt2 = &coupling->as.pt2;
    pt2->gain = config->gain;
    pt2->a1 = 1 / (1 + g * (g + 2 * config->damping));
    pt2->a2 = g * pt2->a1;
    pt2->a3 = g * pt2->a2;
}

static void set_up_spring_damper(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    vxsi_spring_damper *s = &coupling->as.spring_damper;
    s->stiffness = config->stiffness;
    s->mass = config->mass;
    s->radius = config->radius;
    s->viscosity = 2 * config->damping * sqrt(config->stiffness * config->mass);
    s->sample_time = config->sample_time;
}

typedef struct coupling_kind {
    uint32_t kind;
    const char *name;
    const vxsi_coupling_ops *ops;
    vxs_result (*check)(const vxs_coupling_config *);
    void (*set_up)(vxs_coupling *, const vxs_coupling_config *);
} coupling_kind;

static const coupling_kind kinds[] = {
    {VXS_COUPLING_NONE, "none", &vxsi_coupling_none, check_none, set_up_none},
    {VXS_COUPLING_PT2, "pt2", &vxsi_coupling_pt2, check_pt2, set_up_pt2},
    {VXS_COUPLING_SPRING_DAMPER, "spring-damper", &vxsi_coupling_spring_damper, check_spring_damper,
     set_up_spring_damper},
};
enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

static const coupling_kind *find_kind(uint32_t kind)
{
    for (int n = 0; n < KIND_COUNT; n++) {
        if (kinds[n].kind == kind) return &kinds[n];
    }
    return NULL;
}

const char *vxs_coupling_kind_name(uint32_t kind)
{
    const coupling_kind *found = find_kind(kind);
    return found ? found->name : NULL;
}

uint32_t vxs_coupling_kind_named(const char *name)
{
    for (int n = 0; name && n < KIND_COUNT; n++) {
        if (strcmp(kinds[n].name, name) == 0) return kinds[n].kind;
    }
    return 0;
}

void vxs_coupling_config_default(vxs_coupling_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->kind = VXS_COUPLING_PT2;
    config->sample_time = 0.001;
    config->omega0 = 2 * pi * 5;
    config->damping = 1;
    config->gain = 1;
    config->stiffness = 1000;
    config->mass = 0.05;
    config->radius = 0.02;
}

vxs_result vxs_coupling_from_impedance(vxs_coupling_config *config, double stiffness, double damping,
                                       double mass, int physical_gain)
{
    if (!config) return VXS_PARAM;
    if (!is_positive(stiffness) || !is_positive(damping) || !is_positive(mass)) return VXS_IMPEDANCE;
    config->kind = VXS_COUPLING_PT2;
    config->omega0 = sqrt(stiffness / mass);
    config->damping = damping / (2 * sqrt(mass * stiffness));
    config->gain = physical_gain ? 1 / stiffness : 1;
    return VXS_OK;
}

vxs_result vxs_coupling_config_check(const vxs_coupling_config *config)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    const coupling_kind *kind = find_kind(config->kind);
    if (!kind) return VXS_PARAM;
    if (!(config->sample_time >= VXS_COUPLING_MIN_SAMPLE_TIME &&
          config->sample_time <= VXS_COUPLING_MAX_SAMPLE_TIME))
        return VXS_SAMPLE_TIME;
    return kind->check(config);
}

vxs_result vxs_coupling_design(const vxs_coupling_config *config, vxs_coupling_coefficients *out)
{
    vxs_result result = vxs_coupling_config_check(config);
    if (result != VXS_OK) return result;
    if (!out) return VXS_PARAM;
    if (config->kind != VXS_COUPLING_PT2) return VXS_UNSUPPORTED;
    double g = half_sample(config), d = config->damping;
    double scale = 1 / (1 + g * (g + 2 * d));
    out->b0 = config->gain * (g * g * scale);
    out->b1 = 2 * out->b0;
    out->b2 = out->b0;
    out->a1 = 2 * (g - 1) * (g + 1) * scale;
    out->a2 = (1 + g * (g - 2 * d)) * scale;
    return VXS_OK;
}

size_t vxs_coupling_memory(void)
{
    return (sizeof(vxs_coupling) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

vxs_result vxs_coupling_init(void *memory, size_t size, const vxs_coupling_config *config, vxs_coupling **out)
{
    vxs_result result = vxs_coupling_config_check(config);
    if (result != VXS_OK) return result;
    if (!memory || !out) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_coupling_memory()) return VXS_BUFFER;
    const coupling_kind *kind = find_kind(config->kind);
    vxs_coupling *coupling = memory;
    memset(coupling, 0, sizeof *coupling);
    coupling->ops = kind->ops;
    kind->set_up(coupling, config);
    vxs_pose origin = vxs_pose_identity();
    coupling->ops->reset(coupling, &origin);
    *out = coupling;
    return VXS_OK;
}
