/* SPDX-License-Identifier: MIT
 *
 * From a checked plan and its assets to the config of a servo.
 */
#include "voxshell/plan.h"

#include <string.h>

#define SAME(file, runtime) _Static_assert((int)VXS_PLAN_##file == (int)VXS_##runtime, "as in the runtime")
SAME(LAW_ORIGINAL, CONTACT_ORIGINAL);
SAME(LAW_AVERAGE, CONTACT_AVERAGE);
SAME(LAW_GRADIENT, CONTACT_GRADIENT);
SAME(LAW_PATCH, CONTACT_PATCH);
SAME(FIELD_SURFACE, CONTACT_SURFACE);
SAME(FIELD_LAYERS, CONTACT_LAYERS);
SAME(FIELD_DISTANCE, CONTACT_DISTANCE);
SAME(WEIGHT_COUNT, CONTACT_COUNT);
SAME(WEIGHT_COUNT_CAPPED, CONTACT_COUNT_CAPPED);
SAME(WEIGHT_AREA, CONTACT_AREA);
SAME(COUPLING_NONE, COUPLING_NONE);
SAME(COUPLING_PT2, COUPLING_PT2);
SAME(COUPLING_SPRING_DAMPER, COUPLING_SPRING_DAMPER);
SAME(COUPLING_QUASI_STATIC, COUPLING_QUASI_STATIC);
SAME(MAX_CONSTANTS, EFFECT_MAX_CONSTANTS);
SAME(MAX_STATICS, CONTACT_MAX_STATICS);

_Static_assert(sizeof(vxs_plan_motion) == sizeof(vxs_effect_keyframe) &&
                   offsetof(vxs_plan_motion, position) == offsetof(vxs_effect_keyframe, pose.position) &&
                   offsetof(vxs_plan_motion, orientation) ==
                       offsetof(vxs_effect_keyframe, pose.orientation) &&
                   offsetof(vxs_plan_motion, asset) == offsetof(vxs_effect_keyframe, static_index),
               "the file's keyframes are the runtime's");

vxs_result vxs_plan_open(const vxs_asset *asset, vxs_plan *out)
{
    if (!asset || !out || !asset->data) return VXS_PARAM;
    if (asset->kind != VXS_ASSET_PLAN) return VXS_KIND;
    const vxs_container_section *info = vxs_asset_section(asset, VXS_PLAN_SECTION_PLAN),
                                *assets = vxs_asset_section(asset, VXS_PLAN_SECTION_ASST),
                                *effects = vxs_asset_section(asset, VXS_PLAN_SECTION_EFCT),
                                *hand = vxs_asset_section(asset, VXS_PLAN_SECTION_HAND),
                                *moves = vxs_asset_section(asset, VXS_PLAN_SECTION_MOVE);
    *out = (vxs_plan){
        .info = (const void *)(asset->data + info->offset),
        .assets = (const void *)(asset->data + assets->offset),
        .asset_count = (uint32_t)assets->count,
        .effect_count = effects ? (uint32_t)effects->count : 0,
        .effects = effects ? (const void *)(asset->data + effects->offset) : NULL,
        .hand = hand ? (const void *)(asset->data + hand->offset) : NULL,
        .moves = moves ? (const void *)(asset->data + moves->offset) : NULL,
        .hand_count = hand ? (uint32_t)hand->count : 0,
        .move_count = moves ? (uint32_t)moves->count : 0,
    };
    return VXS_OK;
}

/* What a servo's config borrows. */
typedef struct plan_static {
    vxs_voxmap map;
    vxs_pose pose;
} plan_static;

typedef struct plan_room {
    vxs_pointshell *shell;
    plan_static *placed;
    vxs_contact_static *statics;
    vxs_effect *effects;
    size_t size;
} plan_room;

static void *take(plan_room *room, uint8_t *memory, size_t size)
{
    void *part = memory ? memory + room->size : NULL;
    room->size += (size + 15) / 16 * 16;
    return part;
}

static plan_room lay_out(const vxs_plan *plan, void *memory)
{
    plan_room room = {0};
    size_t statics = plan->asset_count - 1;
    room.shell = take(&room, memory, sizeof(vxs_pointshell));
    room.placed = take(&room, memory, statics * sizeof(plan_static));
    room.statics = take(&room, memory, statics * sizeof(vxs_contact_static));
    room.effects = take(&room, memory, plan->effect_count * sizeof(vxs_effect));
    return room;
}

size_t vxs_plan_memory(const vxs_plan *plan)
{
    return plan && plan->info ? lay_out(plan, NULL).size : 0;
}

static vxs_result tell(vxs_plan_issue *issue, uint32_t entry, int is_effect, vxs_result result)
{
    if (issue) {
        issue->entry = entry;
        issue->is_effect = is_effect != 0;
        issue->text = vxs_result_text(result);
    }
    return result;
}

static vxs_pose pose_of(const double position[3], const double orientation[4])
{
    vxs_pose pose;
    memcpy(pose.position, position, sizeof pose.position);
    memcpy(pose.orientation, orientation, sizeof pose.orientation);
    return pose;
}

static vxs_result load_assets(const vxs_plan *plan, const vxs_asset *assets, const plan_room *room,
                              vxs_plan_issue *issue)
{
    for (uint32_t n = 0; n < plan->asset_count; n++) {
        const vxs_plan_asset *wanted = &plan->assets[n];
        int is_static = wanted->role == VXS_PLAN_ROLE_STATIC;
        vxs_result result = is_static ? vxs_voxmap_open(&assets[n], &room->placed[n].map)
                                      : vxs_pointshell_open(&assets[n], room->shell);
        if (result != VXS_OK) return tell(issue, n, 0, result);
        const uint8_t *found = vxs_asset_header(&assets[n])->content_hash;
        if (memcmp(found, wanted->content_hash, sizeof wanted->content_hash) != 0) {
            if (issue) {
                memcpy(issue->expected, wanted->content_hash, sizeof issue->expected);
                memcpy(issue->found, found, sizeof issue->found);
            }
            return tell(issue, n, 0, VXS_PLAN);
        }
        if (!is_static) continue;
        vxs_pose *pose = &room->placed[n].pose, identity = vxs_pose_identity();
        *pose = pose_of(wanted->position, wanted->orientation);
        int is_moved = memcmp(pose, &identity, sizeof identity) != 0;
        room->statics[n] = (vxs_contact_static){&room->placed[n].map, is_moved ? pose : NULL};
    }
    return VXS_OK;
}

static vxs_result load_effects(const vxs_plan *plan, const plan_room *room, vxs_plan_issue *issue)
{
    for (uint32_t n = 0; n < plan->effect_count; n++) {
        const vxs_plan_effect *from = &plan->effects[n];
        vxs_effect *effect = &room->effects[n];
        uint32_t kind = vxs_effect_kind_named((const char *)from->kind), known = 0;
        vxs_effect_constants(kind, &known);
        if (!kind || from->constant_count > known) return tell(issue, n, 1, VXS_UNSUPPORTED);
        vxs_effect_default(kind, effect); /* constants that are newer than the plan are as by default */
        memcpy(effect->as.constants, from->constants, from->constant_count * sizeof(double));
        if (kind == VXS_EFFECT_MOTION) {
            effect->keyframes = (const vxs_effect_keyframe *)(const void *)plan->moves;
            effect->keyframe_count = plan->move_count;
        }
        vxs_result result = vxs_effect_check(effect);
        if (result != VXS_OK) return tell(issue, n, 1, result);
    }
    return VXS_OK;
}

/* What a kind has not stays as by default. */
static void load_coupling(const vxs_plan_info *info, vxs_coupling_config *coupling)
{
    coupling->kind = info->coupling;
    coupling->sample_time = 1 / info->rate;
    coupling->prewarp = info->prewarp;
    if (info->evaluations) coupling->evaluations = info->evaluations;
    if (info->omega0 > 0) coupling->omega0 = info->omega0;
    if (info->damping > 0) coupling->damping = info->damping;
    if (info->gain > 0) coupling->gain = info->gain;
    if (info->coupling_stiffness > 0) coupling->stiffness = info->coupling_stiffness;
    if (info->radius > 0) coupling->radius = info->radius;
    if (info->mass > 0) coupling->mass = info->mass;
}

static void load_info(const vxs_plan_info *info, vxs_servo_config *config)
{
    config->mount = pose_of(info->mount_position, info->mount_orientation);
    config->grip = pose_of(info->grip_position, info->grip_orientation);
    config->scale = info->scale;
    config->contact.law = info->law;
    config->contact.field = info->field;
    config->contact.weighting = info->weighting;
    config->contact.stiffness = info->stiffness;
    config->contact.most_stiffness = info->most_stiffness;
    load_coupling(info, &config->coupling);
    config->max_force = info->max_force;
    config->max_torque = info->max_torque;
    config->max_speed = info->max_speed;
    config->hold_time = info->hold_time;
    config->decay_time = info->decay_time;
}

vxs_result vxs_plan_load(const vxs_plan *plan, const vxs_asset *assets, void *memory, size_t size,
                         vxs_servo_config *config, vxs_plan_issue *issue)
{
    if (issue) memset(issue, 0, sizeof *issue);
    if (!plan || !plan->info || !assets || !memory || !config) return VXS_PARAM;
    if ((uintptr_t)memory % 16 != 0 || size < vxs_plan_memory(plan)) return VXS_BUFFER;
    const plan_room room = lay_out(plan, memory);
    vxs_result result = load_assets(plan, assets, &room, issue);
    if (result == VXS_OK) result = load_effects(plan, &room, issue);
    if (result != VXS_OK) return result;
    vxs_servo_config_default(config);
    load_info(plan->info, config);
    config->statics = room.statics;
    config->static_count = plan->asset_count - 1;
    config->shell = room.shell;
    config->effects = plan->effect_count ? room.effects : NULL;
    config->effect_count = plan->effect_count;
    result = vxs_servo_config_check(config);
    if (issue) issue->text = vxs_result_text(result);
    return result;
}
