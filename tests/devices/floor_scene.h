/* SPDX-License-Identifier: MIT
 *
 * floor_scene.h - what an emulated device is led through: a ball that hangs 4 mm over a floor, and its servo;
 * or other assets.
 */
#ifndef VXS_TEST_FLOOR_SCENE_H
#define VXS_TEST_FLOOR_SCENE_H

#include "asset_builder.h"
#include "emulated.h"
#include "voxshell/servo.h"

static const double floor_clearance = 0.004; /* [m] of the ball to the floor */

typedef struct floor_scene {
    built_asset map_bytes, shell_bytes;
    vxs_asset map_file, shell_file;
    vxs_voxmap map;
    vxs_pointshell shell;
    vxs_contact_static statics;
    vxs_servo_config config;
    void *memory;
    vxs_servo *servo;
} floor_scene;

/* In memory; or from two files. config is ready for floor_scene_start() and may be changed before. */
void floor_scene_build(floor_scene *s);
void floor_scene_open(floor_scene *s, const char *map, const char *shell, uint32_t mode);

/* As files: the floor's height is h cells of 1 mm. */
void floor_scene_write(const char *map, const char *shell, int h);

/* A device that has x and z only has the floor's up along its z. */
void floor_scene_lay_flat(floor_scene *s);

void floor_scene_start(floor_scene *s);
void floor_scene_close(floor_scene *s);

#endif
