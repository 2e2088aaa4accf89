/* SPDX-License-Identifier: MIT */
#include "floor_scene.h"

#include "check.h"

static const double cell = 0.001, radius = 0.01; /* [m] */
enum { POINTS = 1000, HALF = 60, DEEP = 20 };

static built_asset build_floor(int h)
{
    const built_floor shape = {-1 + h, HALF, DEEP};
    return build_floor_map(cell, &shape, BUILT_PLAIN);
}

static void configure(floor_scene *s)
{
    s->statics = (vxs_contact_static){&s->map, NULL};
    vxs_servo_config_default(&s->config);
    s->config.statics = &s->statics;
    s->config.static_count = 1;
    s->config.shell = &s->shell;
    s->config.max_force = 4;
    s->config.contact.weighting = VXS_CONTACT_AREA;
    s->config.contact.stiffness = 1e9;
    s->config.coupling.kind = VXS_COUPLING_QUASI_STATIC;
    s->config.coupling.stiffness = 800;
    s->config.mount.position[1] = radius + floor_clearance;
}

void floor_scene_build(floor_scene *s)
{
    memset(s, 0, sizeof *s);
    s->map_bytes = build_floor(0);
    s->shell_bytes = build_ball_shell(cell, radius, POINTS);
    s->map = open_voxmap(&s->map_bytes);
    s->shell = open_pointshell(&s->shell_bytes);
    configure(s);
}

void floor_scene_open(floor_scene *s, const char *map, const char *shell, uint32_t mode)
{
    vxs_asset_config how;
    memset(s, 0, sizeof *s);
    vxs_asset_config_default(&how);
    how.mode = mode;
    CHECK_INT(vxs_asset_open(map, &how, &s->map_file, NULL), VXS_OK);
    CHECK_INT(vxs_asset_open(shell, &how, &s->shell_file, NULL), VXS_OK);
    CHECK_INT(vxs_voxmap_open(&s->map_file, &s->map), VXS_OK);
    CHECK_INT(vxs_pointshell_open(&s->shell_file, &s->shell), VXS_OK);
    configure(s);
}

static void write_file(const char *path, built_asset bytes)
{
    FILE *file = fopen(path, "wb");
    CHECK(file && fwrite(bytes.data, 1, bytes.size, file) == bytes.size && fclose(file) == 0);
    built_free(&bytes);
}

void floor_scene_write(const char *map, const char *shell, int h)
{
    write_file(map, build_floor(h));
    write_file(shell, build_ball_shell(cell, radius, POINTS));
}

void floor_scene_lay_flat(floor_scene *s)
{
    s->config.mount.orientation[0] = sqrt(0.5);
    s->config.mount.orientation[1] = -sqrt(0.5);
}

void floor_scene_start(floor_scene *s)
{
    size_t size = (vxs_servo_memory(&s->config) + 63) / 64 * 64;
    free(s->memory);
    s->memory = aligned_alloc(64, size);
    CHECK_INT(vxs_servo_init(s->memory, size, &s->config, &s->servo), VXS_OK);
}

void floor_scene_close(floor_scene *s)
{
    free(s->memory);
    vxs_asset_close(&s->map_file);
    vxs_asset_close(&s->shell_file);
    if (!s->map_bytes.data) return;
    built_free(&s->map_bytes);
    built_free(&s->shell_bytes);
}
