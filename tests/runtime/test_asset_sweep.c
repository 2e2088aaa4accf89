/* SPDX-License-Identifier: MIT
 *
 * Hostile bytes: every prefix, every byte of header and table set to 0, 1, 7f and ff, and random
 * damage, with and without right checksums, each on a copy of exactly its size. What is still
 * accepted is used: each cell is looked up and a shell is pushed through.
 */
#include "asset_builder.h"
#include "check.h"

static long accepted, refused;
static built_asset good_map, good_shell;

static void use_map(const vxs_asset *asset)
{
    vxs_voxmap map;
    CHECK_INT(vxs_voxmap_open(asset, &map), VXS_OK);
    uint64_t surface = 0, interior = 0, cells = (uint64_t)map.cells[0] * map.cells[1] * map.cells[2];
    if (cells > 1 << 24) return;
    for (uint32_t i = 0; i < map.cells[0]; i++) {
        for (uint32_t j = 0; j < map.cells[1]; j++) {
            for (uint32_t k = 0; k < map.cells[2]; k++) {
                uint32_t state = vxs_voxmap_state(&map, i, j, k);
                surface += state == VXS_CELL_SURFACE;
                interior += state == VXS_CELL_INTERIOR;
                CHECK(state <= VXS_CELL_INTERIOR);
            }
        }
    }
    CHECK_INT(surface, map.surface_cells);
    CHECK_INT(interior, map.interior_cells);
}

static void touch(const vxs_voxmap *map, const vxs_pointshell *shell)
{
    static uint8_t memory[1 << 16] __attribute__((aligned(64)));
    vxs_contact *contact;
    const vxs_contact_static statics = {map, NULL};
    vxs_contact_config config;
    vxs_contact_result result;
    vxs_contact_config_default(&config);
    CHECK_INT(vxs_contact_init(memory, sizeof memory, shell, 1, &contact), VXS_OK);
    for (int n = 0; n < 5; n++) {
        vxs_pose pose = {{0.004 * n - 0.008, 0.001 * n, 0}, {1, 0.1 * n, 0, 0}};
        vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &result);
        CHECK(isfinite(result.wrench.force[0]) && isfinite(result.wrench.torque[2]));
    }
}

static void offer(const built_asset *bytes, int deep)
{
    vxs_asset asset;
    vxs_asset_issue issue;
    memset(&issue, 0xAA, sizeof issue);
    vxs_result result = vxs_asset_from_memory(bytes->data, bytes->size, NULL, &asset, &issue);
    if (result != VXS_OK) {
        refused++;
        CHECK(issue.letter == 'C' || issue.letter == 'M' || issue.letter == 'S');
        CHECK(issue.rule > 100 && issue.rule < 500 && issue.text != NULL);
        CHECK(issue.offset <= bytes->size || bytes->size < 128);
        return;
    }
    accepted++;
    if (!deep) return;
    if (asset.kind == VXS_ASSET_VOXMAP) {
        vxs_voxmap map;
        use_map(&asset);
        CHECK_INT(vxs_voxmap_open(&asset, &map), VXS_OK);
        vxs_pointshell shell = open_pointshell(&good_shell);
        touch(&map, &shell);
    } else {
        vxs_pointshell shell;
        CHECK_INT(vxs_pointshell_open(&asset, &shell), VXS_OK);
        vxs_voxmap map = open_voxmap(&good_map);
        touch(&map, &shell);
    }
}

static void sweep_prefixes(const built_asset *good)
{
    for (size_t size = 0; size < good->size; size += size < 2048 ? 1 : 61) {
        built_asset part = built_prefix(good, size);
        offer(&part, 0);
        if (size >= 128) { /* a shorter file that lies about nothing but its length */
            ((vxs_container_header *)(void *)part.data)->file_size = size;
            built_seal(&part);
            offer(&part, 0);
        }
        built_free(&part);
    }
    CHECK_INT(accepted, 0);
}

static void sweep_bytes(const built_asset *good)
{
    static const uint8_t values[] = {0, 1, 0x7F, 0xFF};
    const vxs_container_section *table = (const vxs_container_section *)(const void *)(good->data + 128);
    built_asset copy = built_prefix(good, good->size);
    size_t end = (size_t)table[0].offset + 256; /* header, table, and the kind's own header */
    for (size_t at = 0; at < end; at++) {
        for (size_t v = 0; v < sizeof values; v++) {
            memcpy(copy.data, good->data, good->size);
            copy.data[at] = values[v];
            offer(&copy, 0);
            built_seal(&copy);
            offer(&copy, 0);
        }
    }
    built_free(&copy);
}

static void sweep_random(const built_asset *good, int rounds)
{
    uint64_t random = 88172645463325252u;
    built_asset copy = built_prefix(good, good->size);
    for (int round = 0; round < rounds; round++) {
        memcpy(copy.data, good->data, good->size);
        for (int n = 0; n <= round % 4; n++) {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            size_t from = random & 1u ? 128 : 0, range = random & 2u ? 1024 : good->size - from;
            copy.data[from + (random >> 24) % range] = (uint8_t)(random >> 8);
        }
        built_seal(&copy);
        offer(&copy, round % 50 == 0);
    }
    built_free(&copy);
}

int main(void)
{
    built_ball ball = {0.001, {0.032, 0.032, 0.032}, 0.0063};
    good_map = build_ball_map(&ball, BUILT_LAYERS | BUILT_DISTANCES);
    good_shell = build_ball_shell(0.001, 0.005, 70);
    const built_asset *both[] = {&good_map, &good_shell};
    for (int n = 0; n < 2; n++) {
        accepted = 0;
        sweep_prefixes(both[n]);
        sweep_bytes(both[n]);
        sweep_random(both[n], 2000);
        CHECK(refused > 1000 && accepted > 0);
    }
    printf("%ld refused, the last file accepted %ld times\n", refused, accepted);
    built_free(&good_map);
    built_free(&good_shell);
    return 0;
}
