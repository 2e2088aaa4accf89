/* SPDX-License-Identifier: MIT
 *
 * Set-up of contact: config and scratch memory.
 */
#include "contact_probe.h"

#include <math.h>
#include <string.h>

enum { ALIGNMENT = 16 };

void vxs_contact_config_default(vxs_contact_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->law = VXS_CONTACT_AVERAGE;
    config->weighting = VXS_CONTACT_COUNT;
    config->stiffness = 1000;
}

static size_t round_up(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

size_t vxs_contact_memory(uint32_t point_count)
{
    return round_up(sizeof(vxs_contact_scratch)) + (size_t)point_count * sizeof(vxsi_hit) +
           round_up(point_count);
}

static vxsi_probe *probe_named(uint32_t kernel)
{
    switch (kernel) {
    case VXS_CONTACT_SCALAR:
        return vxsi_probe_scalar;
#if defined(__x86_64__)
    case VXS_CONTACT_AVX2:
        return __builtin_cpu_supports("avx2") ? vxsi_probe_avx2 : NULL;
#endif
    default:
        return NULL;
    }
}

vxs_result vxs_contact_use(vxs_contact_scratch *scratch, uint32_t kernel)
{
    if (!scratch || kernel > VXS_CONTACT_AVX2) return VXS_PARAM;
    vxsi_probe *probe = probe_named(kernel);
    for (uint32_t best = VXS_CONTACT_AVX2; kernel == VXS_CONTACT_FASTEST && !probe; best--)
        probe = probe_named(best);
    if (!probe) return VXS_UNSUPPORTED;
    scratch->probe = probe;
    return VXS_OK;
}

vxs_result vxs_contact_init(void *memory, size_t size, uint32_t point_count, vxs_contact_scratch **out)
{
    if (!memory || !out) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_contact_memory(point_count)) return VXS_BUFFER;
    vxs_contact_scratch *scratch = memory;
    memset(scratch, 0, sizeof *scratch);
    scratch->capacity = point_count;
    scratch->hits = (vxsi_hit *)(void *)((uint8_t *)memory + round_up(sizeof *scratch));
    scratch->patch = (uint8_t *)(scratch->hits + point_count);
    *out = scratch;
    return vxs_contact_use(scratch, VXS_CONTACT_FASTEST);
}
