/* SPDX-License-Identifier: MIT
 *
 * Set-up of couplings: kinds by number and name, what all of them check, the biquad of a PT2.
 */
#include "coupling_table.h"

enum { ALIGNMENT = 16 };

static const double pi = 3.14159265358979323846;

static const vxs_coupling_kind *row_of(uint32_t kind)
{
    for (int n = 0; vxsi_coupling_kinds[n]; n++) {
        if (vxsi_coupling_kinds[n]->kind == kind) return vxsi_coupling_kinds[n];
    }
    return NULL;
}

const vxs_coupling_kind *vxsi_coupling_kind_of(const vxs_coupling_config *config)
{
    const vxs_coupling_kind *own = config->own;
    if (!own) return row_of(config->kind);
    return config->kind == VXS_COUPLING_OWN && own->name && own->step ? own : NULL;
}

/* Pre-warping is another w0: the one whose Tustin image is exact at the one asked for. */
static vxs_coupling_config without_prewarp(const vxs_coupling_config *config)
{
    vxs_coupling_config resolved = *config;
    if (config->prewarp)
        resolved.omega0 = 2 / config->sample_time * tan(config->omega0 * config->sample_time / 2);
    resolved.prewarp = 0;
    return resolved;
}

const char *vxs_coupling_kind_name(uint32_t kind)
{
    const vxs_coupling_kind *found = row_of(kind);
    return found ? found->name : NULL;
}

uint32_t vxs_coupling_kind_named(const char *name)
{
    for (int n = 0; name && vxsi_coupling_kinds[n]; n++) {
        if (strcmp(vxsi_coupling_kinds[n]->name, name) == 0) return vxsi_coupling_kinds[n]->kind;
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
    config->evaluations = VXS_COUPLING_MAX_EVALUATIONS;
}

vxs_result vxs_coupling_from_impedance(vxs_coupling_config *config, double stiffness, double damping,
                                       double mass, int physical_gain)
{
    if (!config) return VXS_PARAM;
    if (!vxsi_is_positive(stiffness) || !vxsi_is_positive(damping) || !vxsi_is_positive(mass))
        return VXS_IMPEDANCE;
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
    const vxs_coupling_kind *kind = config->own; /* the sizes first: they say where all else stands */
    if (kind && (kind->struct_size != sizeof *kind || kind->coupling_size != sizeof(vxs_coupling)))
        return VXS_CONFIG;
    kind = vxsi_coupling_kind_of(config);
    if (!kind) return VXS_PARAM;
    if (!(config->sample_time >= VXS_COUPLING_MIN_SAMPLE_TIME &&
          config->sample_time <= VXS_COUPLING_MAX_SAMPLE_TIME))
        return VXS_SAMPLE_TIME;
    return kind->check ? kind->check(config) : VXS_OK;
}

vxs_result vxs_coupling_design(const vxs_coupling_config *config, vxs_coupling_coefficients *out)
{
    vxs_result result = vxs_coupling_config_check(config);
    if (result != VXS_OK) return result;
    if (!out) return VXS_PARAM;
    if (config->kind != VXS_COUPLING_PT2) return VXS_UNSUPPORTED;
    vxs_coupling_config resolved = without_prewarp(config);
    double g = resolved.omega0 * resolved.sample_time / 2, d = config->damping;
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
    const vxs_coupling_kind *kind = vxsi_coupling_kind_of(config);
    vxs_coupling *coupling = memory;
    memset(coupling, 0, sizeof *coupling);
    coupling->kind = kind;
    coupling->has_torque = 1;
    coupling->sample_time = config->sample_time;
    vxs_coupling_config resolved = without_prewarp(config);
    if (kind->set_up) kind->set_up(coupling, &resolved);
    vxs_pose origin = vxs_pose_identity();
    vxs_coupling_reset(coupling, &origin);
    *out = coupling;
    return VXS_OK;
}
