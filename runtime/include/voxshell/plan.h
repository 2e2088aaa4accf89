/* SPDX-License-Identifier: MIT
 *
 * plan.h - a compiled scene: the config of a servo, and which assets it is for.
 *
 * Bytes: formats/plan.md. All of it is set-up; the servo that is made from it keeps nothing of the plan in
 * its tick but what the scene called for.
 *
 *     vxs_asset file, assets[8];
 *     vxs_plan plan;
 *     vxs_asset_open("cup_press.plan", NULL, &file, NULL);
 *     vxs_plan_open(&file, &plan);
 *     for (uint32_t n = 0; n < plan.asset_count; n++) vxs_asset_open(name beside the plan of plan.assets[n],
 * ...); void *room = aligned_alloc(64, vxs_plan_memory(&plan)); vxs_servo_config config; if
 * (vxs_plan_load(&plan, assets, room, vxs_plan_memory(&plan), &config, &issue) != VXS_OK) ... void *memory =
 * aligned_alloc(64, vxs_servo_memory(&config)); vxs_servo_init(memory, vxs_servo_memory(&config), &config,
 * &servo);
 */
#ifndef VOXSHELL_PLAN_H
#define VOXSHELL_PLAN_H

#include "voxshell/asset.h"
#include "voxshell/format/plan.h"
#include "voxshell/servo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* View: borrowed from the asset, valid until vxs_asset_close(). Plain; copy it freely. */
typedef struct vxs_plan {
    const vxs_plan_info *info;      /* its numbers */
    const vxs_plan_asset *assets;   /* statics, then the dynamic */
    uint32_t asset_count;           /* of assets */
    uint32_t effect_count;          /* of effects */
    const vxs_plan_effect *effects; /* in order of execution; NULL without */
    const vxs_plan_keyframe *hand;  /* of a simulated run; NULL without */
    const vxs_plan_motion *moves;   /* of statics that move; NULL without */
    uint32_t hand_count;            /* of hand */
    uint32_t move_count;            /* of moves */
} vxs_plan;

/* Why a plan cannot be loaded. */
typedef struct vxs_plan_issue {
    uint32_t entry;                  /* number in plan.assets or plan.effects */
    uint32_t is_effect;              /* not 0: of plan.effects */
    uint8_t expected[32], found[32]; /* content hashes, of a VXS_PLAN */
    const char *text;                /* static storage, one line */
} vxs_plan_issue;

/* The view of an open asset. VXS_OK; VXS_PARAM for NULL or a closed asset; VXS_KIND for an asset of another
 * kind. Thread: any, set-up. */
VXS_API vxs_result vxs_plan_open(const vxs_asset *asset, vxs_plan *out);

/* Bytes for vxs_plan_load(); 0 for NULL. Thread: any, set-up. */
VXS_API size_t vxs_plan_memory(const vxs_plan *plan);

/* Fills a servo's config. assets: plan->asset_count open ones in the plan's order. They, the plan's asset and
 * the memory (any multiple of 16) are borrowed until the servo's last tick. Effects are of this build: one
 * that it does not know, or a constant that it refuses, is told by its number. What the plan says of a budget
 * in seconds is the caller's to turn into config->contact.most_points (vxs_contact_point_cost()). issue may
 * be NULL. Returns VXS_OK; VXS_PARAM, VXS_BUFFER; VXS_KIND (an asset of another kind than its role's);
 * VXS_PLAN (an asset with another content hash than the plan was made for: the hashes are in the headers,
 * nothing is read again); VXS_UNSUPPORTED (an effect); and as vxs_servo_config_check(). Thread: any, set-up.
 */
VXS_API vxs_result vxs_plan_load(const vxs_plan *plan, const vxs_asset *assets, void *memory, size_t size,
                                 vxs_servo_config *config, vxs_plan_issue *issue);

#ifdef __cplusplus
}
#endif
#endif
