/* SPDX-License-Identifier: MIT
 *
 * Effects by kind and by name: what the table says.
 */
#include "servo_stage.h"

#include <string.h>

const vxsi_stage *vxsi_stage_of(uint32_t effect)
{
    for (uint32_t n = 0; effect && n < vxsi_servo_table_size; n++) {
        if (vxsi_servo_table[n]->effect == effect) return vxsi_servo_table[n];
    }
    return NULL;
}

vxs_result vxs_effect_default(uint32_t kind, vxs_effect *effect)
{
    const vxsi_stage *stage = vxsi_stage_of(kind);
    if (!stage || !effect) return VXS_PARAM;
    memset(effect, 0, sizeof *effect);
    effect->struct_size = sizeof *effect;
    effect->kind = kind;
    for (uint32_t n = 0; n < stage->constant_count; n++)
        effect->as.constants[n] = stage->constants[n].standard;
    return VXS_OK;
}

const vxs_effect_constant *vxs_effect_constants(uint32_t kind, uint32_t *count)
{
    const vxsi_stage *stage = vxsi_stage_of(kind);
    if (count) *count = stage ? stage->constant_count : 0;
    return stage ? stage->constants : NULL;
}

vxs_result vxs_effect_check(const vxs_effect *effect)
{
    if (!effect) return VXS_PARAM;
    if (effect->struct_size != sizeof *effect) return VXS_CONFIG;
    const vxsi_stage *stage = vxsi_stage_of(effect->kind);
    if (!stage) return VXS_PARAM;
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
    const vxsi_stage *stage = vxsi_stage_of(kind);
    return stage ? stage->name : NULL;
}

uint32_t vxs_effect_kind_named(const char *name)
{
    for (uint32_t n = 0; name && n < vxsi_servo_table_size; n++) {
        const vxsi_stage *stage = vxsi_servo_table[n];
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
    const vxsi_stage *stage = vxsi_stage_of(kind);
    return stage && stage->is_guard;
}
