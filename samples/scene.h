/* SPDX-License-Identifier: MIT
 *
 * scene.h - what the sample programs begin with: a plan (voxshell convert SCENE) and the assets that it names,
 * beside it, as the config of a servo. The laboratory's own part is what is left.
 */
#ifndef SAMPLES_SCENE_H
#define SAMPLES_SCENE_H

#include "voxshell/plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SCENE_ASSETS = 16 };

typedef struct scene {
    vxs_asset plan_file, assets[SCENE_ASSETS];
    vxs_plan plan;
    vxs_servo_config config; /* to be changed before scene_servo() */
    void *room, *memory;
} scene;

static inline void *scene_memory(size_t size)
{
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

/* One line of what is wrong. */
static inline int scene_refuses(const char *what, vxs_result result)
{
    fprintf(stderr, "%s: %s\n", what, vxs_result_text(result));
    return 0;
}

/* Not 0: s->config is the plan's. */
static inline int scene_open(scene *s, const char *path)
{
    memset(s, 0, sizeof *s);
    vxs_result result = vxs_asset_open(path, NULL, &s->plan_file, NULL);
    if (result == VXS_OK) result = vxs_plan_open(&s->plan_file, &s->plan);
    if (result == VXS_OK && s->plan.asset_count > SCENE_ASSETS) result = VXS_LIMIT;
    if (result != VXS_OK) return scene_refuses(path, result);
    const char *slash = strrchr(path, '/');
    int folder = slash ? (int)(slash - path) + 1 : 0;
    for (uint32_t n = 0; n < s->plan.asset_count; n++) {
        char name[4096];
        snprintf(name, sizeof name, "%.*s%s", folder, path, (const char *)s->plan.assets[n].name);
        result = vxs_asset_open(name, NULL, &s->assets[n], NULL);
        if (result != VXS_OK) return scene_refuses(name, result);
    }
    size_t size = vxs_plan_memory(&s->plan);
    s->room = scene_memory(size);
    result = vxs_plan_load(&s->plan, s->assets, s->room, size, &s->config, NULL);
    return result == VXS_OK ? 1 : scene_refuses(path, result);
}

/* The servo of s->config, or NULL. */
static inline vxs_servo *scene_servo(scene *s)
{
    vxs_servo *servo = NULL;
    size_t size = vxs_servo_memory(&s->config);
    s->memory = scene_memory(size);
    vxs_result result = vxs_servo_init(s->memory, size, &s->config, &servo);
    if (result != VXS_OK) scene_refuses("servo", result);
    return result == VXS_OK ? servo : NULL;
}

static inline void scene_close(scene *s)
{
    free(s->memory);
    free(s->room);
    for (uint32_t n = 0; n < s->plan.asset_count; n++) vxs_asset_close(&s->assets[n]);
    vxs_asset_close(&s->plan_file);
}

#endif
