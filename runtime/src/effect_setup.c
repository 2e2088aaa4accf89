/* SPDX-License-Identifier: MIT
 *
 * Effects by kind and by name: what the table says.
 */
#include "servo_stage.h"

#include <string.h>

extern const vxs_effect_kind vxsi_stage_coupling;

const vxs_effect_kind *vxsi_stage_of(uint32_t effect)
{
    for (uint32_t n = 0; effect && n < vxsi_servo_table_size; n++) {
        if (vxsi_servo_table[n]->effect == effect) return vxsi_servo_table[n];
    }
    return NULL;
}

const vxs_effect_kind *vxsi_effect_kind_of(const vxs_effect *effect)
{
    if (!effect->own) return vxsi_stage_of(effect->kind);
    return effect->kind == VXS_EFFECT_OWN ? effect->own : NULL;
}

uint32_t vxsi_own_place(const vxs_effect_kind *kind)
{
    const char *before = kind->before ? kind->before : "inertia";
    for (uint32_t n = 0; n < vxsi_servo_table_size; n++) {
        if (strcmp(vxsi_servo_table[n]->name, before) == 0) return n;
        if (n > 0 && vxsi_servo_table[n - 1] == &vxsi_stage_coupling) break;
    }
    return vxsi_servo_table_size;
}

static vxs_result check_own(const vxs_effect_kind *kind)
{
    if (kind->struct_size != sizeof *kind || kind->tick_size != sizeof(vxs_tick)) return VXS_CONFIG;
    if (!kind->name || !(kind->run || kind->add) || (kind->pose && !kind->compliance)) return VXS_PARAM;
    if (kind->constant_count > VXS_EFFECT_MAX_CONSTANTS || (kind->constant_count && !kind->constants))
        return VXS_PARAM;
    return vxsi_own_place(kind) < vxsi_servo_table_size ? VXS_OK : VXS_PARAM;
}

static void set_defaults(vxs_effect *effect, uint32_t number, const vxs_effect_kind *stage)
{
    memset(effect, 0, sizeof *effect);
    effect->struct_size = sizeof *effect;
    effect->kind = number;
    for (uint32_t n = 0; n < stage->constant_count; n++)
        effect->as.constants[n] = stage->constants[n].standard;
}

vxs_result vxs_effect_default(uint32_t kind, vxs_effect *effect)
{
    const vxs_effect_kind *stage = vxsi_stage_of(kind);
    if (!stage || !effect) return VXS_PARAM;
    set_defaults(effect, kind, stage);
    return VXS_OK;
}

vxs_result vxs_effect_own(const vxs_effect_kind *kind, vxs_effect *effect)
{
    if (!kind || !effect) return VXS_PARAM;
    vxs_result result = check_own(kind);
    if (result != VXS_OK) return result;
    set_defaults(effect, VXS_EFFECT_OWN, kind);
    effect->own = kind;
    return VXS_OK;
}

const vxs_effect_constant *vxs_effect_constants(uint32_t kind, uint32_t *count)
{
    const vxs_effect_kind *stage = vxsi_stage_of(kind);
    if (count) *count = stage ? stage->constant_count : 0;
    return stage ? stage->constants : NULL;
}

vxs_result vxs_effect_check(const vxs_effect *effect)
{
    if (!effect) return VXS_PARAM;
    if (effect->struct_size != sizeof *effect) return VXS_CONFIG;
    const vxs_effect_kind *stage = vxsi_effect_kind_of(effect);
    if (!stage) return VXS_PARAM;
    vxs_result result = stage == effect->own ? check_own(stage) : VXS_OK;
    if (result != VXS_OK) return result;
    for (uint32_t n = 0; n < VXS_EFFECT_MAX_CONSTANTS; n++) {
        double value = effect->as.constants[n];
        double least = n < stage->constant_count ? stage->constants[n].least : 0;
        double most = n < stage->constant_count ? stage->constants[n].most : 0;
        if (!(value >= least && value <= most)) return VXS_PARAM;
    }
    if (!stage->has_keyframes && (effect->keyframes || effect->keyframe_count)) return VXS_PARAM;
    if (effect->reserved) return VXS_PARAM;
    return stage->check ? stage->check(effect) : VXS_OK;
}

const char *vxs_effect_kind_name(uint32_t kind)
{
    const vxs_effect_kind *stage = vxsi_stage_of(kind);
    return stage ? stage->name : NULL;
}

uint32_t vxs_effect_kind_named(const char *name)
{
    for (uint32_t n = 0; name && n < vxsi_servo_table_size; n++) {
        const vxs_effect_kind *stage = vxsi_servo_table[n];
        if (stage->effect && strcmp(stage->name, name) == 0) return stage->effect;
    }
    return 0;
}

uint32_t vxs_effect_kind_at(uint32_t index)
{
    for (uint32_t n = 0; n < vxsi_servo_table_size; n++) {
        uint32_t effect = vxsi_servo_table[n]->effect;
        if (effect && index-- == 0) return effect;
    }
    return 0;
}

int vxs_effect_is_guard(uint32_t kind)
{
    const vxs_effect_kind *stage = vxsi_stage_of(kind);
    return stage && stage->is_guard;
}
