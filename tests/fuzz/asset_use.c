/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L /* posix_memalign */
#include "asset_use.h"
#include "asset_builder.h"
#include "asset_mutator.h"
#include "fuzz_target.h"

#include <math.h>
#include <string.h>

static void *block(size_t size)
{
    void *memory = NULL;
    FUZZ_CHECK(posix_memalign(&memory, 64, size ? size : 1) == 0);
    return memory;
}

uint8_t *use_open(const uint8_t *bytes, size_t size, vxs_asset *asset, uint64_t *variant)
{
    *variant = asset_variant(bytes, size);
    vxs_asset_config config;
    vxs_asset_config_default(&config);
    config.skip_checksums = !asset_is_summed(*variant);
    vxs_asset_issue issue;
    uint8_t *copy = block(size);
    memcpy(copy, bytes, size);
    vxs_result result = vxs_asset_from_memory(copy, size, &config, asset, &issue);
    if (result == VXS_OK) {
        FUZZ_CHECK(asset->data == copy && asset->size == size);
        return copy;
    }
    FUZZ_CHECK(strchr("CMSP", issue.letter) && issue.letter && issue.rule > 100 && issue.rule < 700);
    FUZZ_CHECK(issue.text && !asset->data && (issue.offset < size || size < sizeof(vxs_container_header)));
    free(copy);
    return NULL;
}

void use_close(uint8_t *copy, vxs_asset *asset)
{
    vxs_asset_close(asset);
    free(copy);
}

static vxs_contact *open_contact(const vxs_pointshell *shell, uint32_t kernel, void *memory[2])
{
    vxs_contact *contact;
    memory[0] = block(vxs_contact_memory(shell, 1));
    FUZZ_CHECK(vxs_contact_init(memory[0], vxs_contact_memory(shell, 1), shell, 1, &contact) == VXS_OK);
    FUZZ_CHECK(vxs_contact_use(contact, kernel) == VXS_OK);
    memory[1] = block(vxs_contact_levels_memory(shell));
    vxs_result result = vxs_contact_add_levels(contact, memory[1], vxs_contact_levels_memory(shell));
    FUZZ_CHECK(result == (shell->area ? VXS_OK : VXS_NO_AREA));
    return contact;
}

void use_pair_open(use_pair *pair, const vxs_pointshell *shell)
{
    pair->shell = shell;
    pair->fast = open_contact(shell, VXS_CONTACT_FASTEST, pair->memory);
    pair->plain = open_contact(shell, VXS_CONTACT_SCALAR, pair->memory + 2);
}

void use_pair_close(use_pair *pair)
{
    for (int n = 0; n < 4; n++) free(pair->memory[n]);
}

static void check_result(const vxs_contact_result *result, uint32_t flags)
{
    FUZZ_CHECK(flags == result->flags);
    double sum = 0;
    for (int axis = 0; axis < 3; axis++) {
        FUZZ_CHECK(isfinite(result->wrench.force[axis]) && isfinite(result->wrench.torque[axis]));
        FUZZ_CHECK(isfinite(result->normal[axis]));
        sum += fabs(result->wrench.force[axis]) + fabs(result->wrench.torque[axis]);
    }
    FUZZ_CHECK(isfinite(result->depth) && !(flags & VXS_CONTACT_WRONG_SKIP));
    FUZZ_CHECK(!(flags & VXS_CONTACT_INVALID) || sum == 0);
}

void use_touch(use_pair *pair, const vxs_voxmap *map, uint64_t variant)
{
    vxs_contact_loads loads[2];
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = 1 + (uint32_t)(variant % 4);
    config.field = 1 + (uint32_t)(variant / 4 % 3);
    config.weighting = 1 + (uint32_t)(variant / 16 % (pair->shell->area ? 3 : 2));
    if (config.law == VXS_CONTACT_GRADIENT) config.field = VXS_CONTACT_DISTANCE;
    if (variant >> 10 & 1) config.most_stiffness = 500;
    if (variant >> 11 & 1 && config.weighting == VXS_CONTACT_AREA) config.most_points = 4;
    uint32_t culling = variant >> 12 & 3;
    if (culling == VXS_CONTACT_CHECKED)
        culling = VXS_CONTACT_COHERENT; /* a forged clearance is verify's to find */
    FUZZ_CHECK(vxs_contact_cull(pair->fast, culling) == VXS_OK &&
               vxs_contact_cull(pair->plain, culling) == VXS_OK);

    const vxs_contact_static statics = {map, NULL};
    vxs_pose pose = {{0, 0, 0}, {1, 0, 0, 0}};
    for (int axis = 0; axis < 3; axis++) {
        int64_t low = map->bbox_min[axis], high = map->bbox_max[axis];
        int64_t cell = variant >> 14 & 1 ? low : variant >> 15 & 1 ? high : low + (high - low) / 2;
        pose.position[axis] = ((double)cell + 0.5) * map->voxel - pair->shell->center[axis];
    }
    int count = variant >> 16 & 15 ? 2 : 8;
    for (int n = 0; n < count; n++) {
        vxs_contact_result result[2];
        memset(result, 0, sizeof result);
        config.loads = variant >> 20 & 1 ? &loads[0] : NULL;
        uint32_t flags = vxs_contact_evaluate(pair->fast, &statics, 1, &pose, &config, &result[0]);
        check_result(&result[0], flags);
        config.loads = variant >> 20 & 1 ? &loads[1] : NULL;
        flags = vxs_contact_evaluate(pair->plain, &statics, 1, &pose, &config, &result[1]);
        FUZZ_CHECK(flags == result[0].flags &&
                   memcmp(&result[0].wrench, &result[1].wrench, sizeof(vxs_wrench)) == 0);
        FUZZ_CHECK(result[0].points == result[1].points &&
                   memcmp(&result[0].depth, &result[1].depth, 8) == 0);
        FUZZ_CHECK(!config.loads || loads[0].count == loads[1].count);
        pose.position[n % 3] += (variant >> 21 & 1 ? 0.3 : 2.0) * (n & 4 ? pair->shell->radius : map->voxel);
        double half = 0.1 * (n + 1), q[4] = {1 - half * half, n == 0 ? half : 0, n == 1 ? half : 0, half},
               length = 0;
        for (int i = 0; i < 4; i++) length += q[i] * q[i];
        for (int i = 0; i < 4; i++) pose.orientation[i] = q[i] / sqrt(length);
    }
}

void use_look_up(const vxs_voxmap *map, uint64_t variant)
{
    uint64_t roots = (uint64_t)map->root_dims[0] * map->root_dims[1] * map->root_dims[2];
    FUZZ_CHECK(map->surface_cells > 0 && roots > 0);
    for (int n = 0; n < 200; n++) {
        variant = variant * 6364136223846793005u + 1442695040888963407u;
        uint32_t cell[3];
        for (int axis = 0; axis < 3; axis++)
            cell[axis] = (uint32_t)((variant >> (20 * axis)) % map->cells[axis]);
        FUZZ_CHECK(vxs_voxmap_state(map, cell[0], cell[1], cell[2]) <= VXS_CELL_INTERIOR);
        uint32_t entry = vxs_voxmap_entry(map, cell[0], cell[1], cell[2]);
        FUZZ_CHECK(entry == VXS_CELL_FREE || entry == VXS_CELL_INTERIOR || entry - 4 < map->brick_count);
        uint32_t size;
        if (map->clearance_index)
            FUZZ_CHECK(fabsf(vxs_voxmap_clearance(map, cell[0], cell[1], cell[2], &size)) <= 4096 &&
                       size >= 4);
    }
    for (int axis = 0; axis < 3; axis++) {
        int64_t least = map->origin_cell[axis];
        FUZZ_CHECK(map->bbox_min[axis] >= least && map->bbox_min[axis] <= map->bbox_max[axis] &&
                   map->bbox_max[axis] < least + (int64_t)map->cells[axis]);
    }
    FUZZ_CHECK(vxs_voxmap_state_at(map, INT64_MIN, INT64_MAX, 0) == VXS_CELL_FREE);
}

static struct {
    int is_made;
    built_asset bytes[3];
    vxs_asset map[2], shell;
    vxs_voxmap view[2];
    vxs_pointshell points;
} partner;

static void read_golden(const char *name, built_asset *out)
{
    char path[512];
    snprintf(path, sizeof path, "%s/tests/golden/valid/%s", VXS_TEST_SOURCE_DIR, name);
    FILE *file = fopen(path, "rb");
    FUZZ_CHECK(file);
    *out = (built_asset){block(1 << 16), 0};
    out->size = fread(out->data, 1, 1 << 16, file);
    fclose(file);
}

static void make_partners(void)
{
    if (partner.is_made) return;
    partner.is_made = 1;
    const built_ball ball = {0.001, {0.032, 0.032, 0.032}, 0.0063};
    partner.bytes[0] = build_ball_map(&ball, BUILT_LAYERS | BUILT_DISTANCES);
    read_golden("clearance.voxmap", &partner.bytes[1]);
    partner.bytes[2] = build_ball_shell(0.001, 0.005, 70);
    for (int n = 0; n < 2; n++) {
        FUZZ_CHECK(vxs_asset_from_memory(partner.bytes[n].data, partner.bytes[n].size, NULL, &partner.map[n],
                                         NULL) == VXS_OK);
        FUZZ_CHECK(vxs_voxmap_open(&partner.map[n], &partner.view[n]) == VXS_OK);
    }
    FUZZ_CHECK(vxs_asset_from_memory(partner.bytes[2].data, partner.bytes[2].size, NULL, &partner.shell,
                                     NULL) == VXS_OK);
    FUZZ_CHECK(vxs_pointshell_open(&partner.shell, &partner.points) == VXS_OK);
}

const vxs_voxmap *use_map(int which)
{
    make_partners();
    return &partner.view[which];
}

const vxs_pointshell *use_shell(void)
{
    make_partners();
    return &partner.points;
}

void use_partners(vxs_asset *map, vxs_asset *shell)
{
    make_partners();
    *map = partner.map[0];
    *shell = partner.shell;
}
