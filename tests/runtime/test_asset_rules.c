/* SPDX-License-Identifier: MIT
 *
 * One damaged file per rule of the specs, with checksums made right again: refused by that rule,
 * in that section, at that offset.
 */
#include "asset_builder.h"
#include "check.h"

#define HEADER(a) ((vxs_container_header *)(void *)(a)->data)
#define TABLE(a) ((vxs_container_section *)(void *)((a)->data + 128))
#define GRID(a) ((vxs_voxmap_grid *)built_bytes(a, VXS_VOXMAP_SECTION_GRID))
#define ROOT(a) ((uint32_t *)built_bytes(a, VXS_VOXMAP_SECTION_ROOT))
#define CHNK(a) ((uint32_t *)built_bytes(a, VXS_VOXMAP_SECTION_CHNK))
#define BRIK(a) ((uint64_t *)built_bytes(a, VXS_VOXMAP_SECTION_BRIK))
#define LAYR(a) ((int8_t *)built_bytes(a, VXS_VOXMAP_SECTION_LAYR))
#define DIST(a) ((int16_t *)built_bytes(a, VXS_VOXMAP_SECTION_DIST))
#define SHEL(a) ((vxs_pointshell_info *)built_bytes(a, VXS_POINTSHELL_SECTION_SHEL))
#define CLUS(a) ((vxs_pointshell_cluster *)built_bytes(a, VXS_POINTSHELL_SECTION_CLUS))
#define FLOATS(a, name) ((float *)built_bytes(a, VXS_POINTSHELL_SECTION_##name))

static built_asset plain_map, channel_map, shell;
static int cases;

static built_asset fresh(const built_asset *from)
{
    return built_prefix(from, from->size);
}

static void refused(const built_asset *asset, vxs_result expected, const char *rule, const char *section,
                    int64_t offset)
{
    vxs_asset opened;
    vxs_asset_issue issue;
    vxs_result result = vxs_asset_from_memory(asset->data, asset->size, NULL, &opened, &issue);
    char found[16], where[5];
    snprintf(found, sizeof found, "%c%u", issue.letter ? issue.letter : '-', (unsigned)issue.rule);
    memcpy(where, &issue.section, 4);
    where[4] = 0;
    if (result != expected || strcmp(found, rule) != 0 || strcmp(where, section) != 0 ||
        (offset >= 0 && issue.offset != (uint64_t)offset))
        CHECK_FAIL("%s in %s at %lld expected, got %s %s in %s at %llu: %s", rule, section, (long long)offset,
                   vxs_result_name(result), found, where, (unsigned long long)issue.offset, issue.text);
    cases++;
}

/* Damage a copy, make the checksums right, expect the refusal. at: relative to the section. */
#define CASE(from, damage, result, rule, section, at)                                                        \
    do {                                                                                                     \
        built_asset one = fresh(from), *a = &one;                                                            \
        damage;                                                                                              \
        built_seal(a);                                                                                       \
        int64_t base =                                                                                       \
            strcmp(section, "HEAD") == 0 || strcmp(section, "TABL") == 0                                     \
                ? 0                                                                                          \
                : (int64_t)built_entry(from, VXS_SECTION_ID(section[0], section[1], section[2], section[3])) \
                      ->offset;                                                                              \
        refused(a, VXS_##result, rule, section, base + (int64_t)(at));                                       \
        built_free(a);                                                                                       \
    } while (0)

/* The same without sealing. */
#define RAW(from, damage, result, rule, section, at)                                                         \
    do {                                                                                                     \
        built_asset one = fresh(from), *a = &one;                                                            \
        damage;                                                                                              \
        refused(a, VXS_##result, rule, section, (int64_t)(at));                                              \
        built_free(a);                                                                                       \
    } while (0)

#define HEAD_AT(field) offsetof(vxs_container_header, field)
#define TABL_AT(n, field) (128 + 40 * (n) + offsetof(vxs_container_section, field))
#define GRID_AT(field) offsetof(vxs_voxmap_grid, field)
#define SHEL_AT(field) offsetof(vxs_pointshell_info, field)

static void check_container(void)
{
    const built_asset *m = &plain_map;
    built_asset tiny = built_prefix(m, 127);
    refused(&tiny, VXS_TRUNCATED, "C101", "HEAD", 0);
    built_free(&tiny);
    CASE(m, a->data[1] = 'W', MAGIC, "C102", "HEAD", 0);
    CASE(m, HEADER(a)->version_major = 0, VERSION, "C103", "HEAD", HEAD_AT(version_major));
    RAW(m, a->data[50] ^= 1u, CHECKSUM, "C104", "HEAD", HEAD_AT(header_crc));
    CASE(m, HEADER(a)->required_features = 4, FEATURE, "C105", "HEAD", HEAD_AT(required_features));
    CASE(m, HEADER(a)->file_size += 64, TRUNCATED, "C106", "HEAD", HEAD_AT(file_size));
    CASE(m, HEADER(a)->file_size -= 64, CORRUPT, "C106", "HEAD", HEAD_AT(file_size));
    CASE(m, HEADER(a)->file_size = UINT64_MAX, TRUNCATED, "C106", "HEAD", HEAD_AT(file_size));
    CASE(m, HEADER(a)->section_count = 0, LIMIT, "C107", "HEAD", HEAD_AT(section_count));
    CASE(m, HEADER(a)->section_count = 65, LIMIT, "C107", "HEAD", HEAD_AT(section_count));
    CASE(m, HEADER(a)->section_count = UINT32_MAX, LIMIT, "C107", "HEAD", HEAD_AT(section_count));
    CASE(m, HEADER(a)->header_size = 64, CORRUPT, "C108", "HEAD", HEAD_AT(header_size));
    CASE(m, HEADER(a)->section_entry_size = 48, CORRUPT, "C108", "HEAD", HEAD_AT(section_entry_size));
    CASE(m, HEADER(a)->section_table_offset = 192, CORRUPT, "C108", "HEAD", HEAD_AT(section_table_offset));
    CASE(m, HEADER(a)->reserved[1] = 1, CORRUPT, "C109", "HEAD", HEAD_AT(reserved));
    CASE(m, HEADER(a)->section_count = 4, CORRUPT, "C203", "TABL", TABL_AT(0, offset));
    RAW(m, TABLE(a)->crc ^= 1u, CHECKSUM, "C110", "HEAD", HEAD_AT(table_crc));

    CASE(m, TABLE(a)[1].id = VXS_SECTION_ID('r', 'o', 'o', 't'), CORRUPT, "C201", "TABL", TABL_AT(1, id));
    CASE(m, TABLE(a)[1].id = TABLE(a)[0].id, CORRUPT, "C201", "TABL", TABL_AT(1, id));
    CASE(m, TABLE(a)[1].id = VXS_SECTION_TABL, CORRUPT, "C201", "TABL", TABL_AT(1, id));
    CASE(m, TABLE(a)[2].stride = 0, CORRUPT, "C202", "TABL", TABL_AT(2, stride));
    CASE(m, TABLE(a)[2].count = 0, CORRUPT, "C202", "TABL", TABL_AT(2, count));
    CASE(m, TABLE(a)[2].size += 1, CORRUPT, "C202", "TABL", TABL_AT(2, size));
    CASE(m, TABLE(a)[2].count += (uint64_t)1 << 53, CORRUPT, "C202", "TABL",
         TABL_AT(2, size)); /* x 2048 wraps to the same */
    CASE(m, TABLE(a)[1].offset += 64, CORRUPT, "C203", "TABL", TABL_AT(1, offset));
    CASE(m, TABLE(a)[1].offset = TABLE(a)[0].offset, CORRUPT, "C203", "TABL", TABL_AT(1, offset));
    CASE(m, (TABLE(a)[4].count = TABLE(a)[4].size = (uint64_t)1 << 62), CORRUPT, "C203", "TABL",
         TABL_AT(4, offset));
    CASE(m, TABLE(a)[1].reserved = 1, CORRUPT, "C204", "TABL", TABL_AT(1, reserved));
    CASE(m, (TABLE(a)[4].count = TABLE(a)[4].size = 65), CORRUPT, "C203", "TABL", TABL_AT(4, offset));
    CASE(m, TABLE(a)[4].id = VXS_SECTION_ID('M', 'E', 'T', 'B'), CORRUPT, "C206", "TABL", TABL_AT(4, id));
    CASE(m, (TABLE(a)[4].stride = 2, TABLE(a)[4].count = 1), CORRUPT, "C206", "TABL", TABL_AT(4, id));
    CASE(m, a->data[128 + 40 * 5 + 3] = 1, CORRUPT, "C301", "TABL", 128 + 40 * 5 + 3);
    CASE(m, a->data[a->size - 1] = 1, CORRUPT, "C301", "META",
         (int64_t)m->size - 1 - (int64_t)built_entry(m, VXS_SECTION_META)->offset);
    RAW(m, BRIK(a)[3] ^= 1u, CHECKSUM, "C302", "BRIK", built_entry(m, VXS_VOXMAP_SECTION_BRIK)->offset);

    /* C205: one more block of zeros, and a file_size that knows it. */
    built_asset longer = built_prefix(m, m->size), padded = {NULL, 0};
    built_free(&longer);
    static uint64_t room[1 << 16];
    CHECK(m->size + 64 < sizeof room);
    memcpy(room, m->data, m->size);
    built_asset view = {(uint8_t *)room, m->size + 64};
    padded = built_prefix(&view, view.size);
    HEADER(&padded)->file_size = padded.size;
    built_seal(&padded);
    refused(&padded, VXS_CORRUPT, "C205", "HEAD", HEAD_AT(file_size));
    built_free(&padded);
}

static void swap_entries(built_asset *a, int one, int other)
{
    uint32_t id = TABLE(a)[one].id;
    TABLE(a)[one].id = TABLE(a)[other].id;
    TABLE(a)[other].id = id;
}

static uint32_t first_brick_slot(const built_asset *a)
{
    uint32_t slot = 0;
    while (CHNK(a)[slot] < 4) slot++;
    return slot;
}

static void check_voxmap(void)
{
    const built_asset *m = &plain_map, *c = &channel_map;
    CASE(m, swap_entries(a, 0, 1), CORRUPT, "M101", "TABL", TABL_AT(0, id));
    CASE(m, TABLE(a)[3].id = VXS_SECTION_ID('X', 'X', 'X', 'X'), CORRUPT, "M101", "TABL", TABL_AT(3, id));
    CASE(c, swap_entries(a, 4, 5), CORRUPT, "M101", "TABL", TABL_AT(4, id));
    CASE(c, TABLE(a)[4].id = VXS_SECTION_ID('X', 'X', 'X', 'X'), CORRUPT, "M101", "TABL", TABL_AT(4, id));
    CASE(m, (TABLE(a)[1].stride = 2, TABLE(a)[1].count *= 2), CORRUPT, "M102", "TABL", TABL_AT(1, id));
    CASE(m, (TABLE(a)[0].stride = 96, TABLE(a)[0].count = 2), CORRUPT, "M102", "TABL", TABL_AT(0, id));
    CASE(c, (TABLE(a)[4].stride = 256, TABLE(a)[4].count *= 2), CORRUPT, "M102", "TABL", TABL_AT(4, id));

    CASE(m, GRID(a)->voxel = NAN, CORRUPT, "M201", "GRID", 0);
    CASE(m, GRID(a)->voxel = 1.1e3, CORRUPT, "M201", "GRID", 0);
    CASE(m, GRID(a)->origin_cell[1] += 8, CORRUPT, "M202", "GRID", GRID_AT(origin_cell) + 8);
    CASE(m, GRID(a)->origin_cell[2] = INT64_MIN, CORRUPT, "M202", "GRID", GRID_AT(origin_cell) + 16);
    CASE(m, GRID(a)->root_dims[2] = 0, CORRUPT, "M203", "GRID", GRID_AT(root_dims) + 8);
    CASE(m, GRID(a)->root_dims[0] = 16385, LIMIT, "M204", "GRID", GRID_AT(root_dims));
    CASE(m, GRID(a)->origin_cell[1] = ((int64_t)1 << 44) - 64, LIMIT, "M204", "GRID", GRID_AT(root_dims) + 4);
    CASE(m, GRID(a)->root_dims[0] = GRID(a)->root_dims[1] = 16384, LIMIT, "M205", "GRID", GRID_AT(root_dims));
    CASE(m, GRID(a)->root_dims[1] += 1, CORRUPT, "M207", "TABL", TABL_AT(1, id));
    CASE(m, GRID(a)->flags |= 4u, CORRUPT, "M208", "GRID", GRID_AT(flags));
    CASE(m, GRID(a)->reserved = 0x100, CORRUPT, "M208", "GRID", GRID_AT(reserved) + 1);
    CASE(m, GRID(a)->pad[47] = 1, CORRUPT, "M208", "GRID", GRID_AT(pad) + 47);
    CASE(m, GRID(a)->layer_count = 1, CORRUPT, "M209", "GRID", GRID_AT(layer_count));
    CASE(c, GRID(a)->layer_count = 0, CORRUPT, "M209", "GRID", GRID_AT(layer_count));
    CASE(c, GRID(a)->layer_count = 127, CORRUPT, "M209", "GRID", GRID_AT(layer_count));
    CASE(m, GRID(a)->distance_band = -0.0, CORRUPT, "M210", "GRID", GRID_AT(distance_band));
    CASE(m, GRID(a)->flags |= VXS_VOXMAP_FLAG_UNSIGNED, CORRUPT, "M210", "GRID", GRID_AT(flags));
    CASE(c, GRID(a)->distance_step = 0, CORRUPT, "M210", "GRID", GRID_AT(distance_step));
    CASE(c, GRID(a)->distance_band = GRID(a)->distance_step / 2, CORRUPT, "M210", "GRID",
         GRID_AT(distance_band));
    CASE(c, GRID(a)->distance_band = INFINITY, CORRUPT, "M210", "GRID", GRID_AT(distance_band));
    CASE(c, GRID(a)->distance_error = -1, CORRUPT, "M210", "GRID", GRID_AT(distance_error));
    CASE(m, GRID(a)->surface_cells = 0, CORRUPT, "M211", "GRID", GRID_AT(surface_cells));

    uint32_t roots = (uint32_t)built_entry(m, VXS_VOXMAP_SECTION_ROOT)->count;
    uint32_t slot = first_brick_slot(m);
    CHECK(roots == 8 && ROOT(m)[0] == 4 && ROOT(m)[7] == 11);
    CASE(m, ROOT(a)[0] = 1, CORRUPT, "M301", "ROOT", 0);
    CASE(m, ROOT(a)[3] = 4, CORRUPT, "M301", "ROOT", 12);
    CASE(m, ROOT(a)[7] = UINT32_MAX, CORRUPT, "M301", "ROOT", 28);
    CASE(m, ROOT(a)[7] = 2, CORRUPT, "M301", "ROOT", 0);
    CASE(m, CHNK(a)[slot] = 3, CORRUPT, "M303", "CHNK", slot * 4);
    CASE(m, CHNK(a)[slot] = 5, CORRUPT, "M303", "CHNK", slot * 4);
    CASE(m, CHNK(a)[511 + 512 * 7] = 0x7FFFFFFF, CORRUPT, "M303", "CHNK", (511 + 512 * 7) * 4);
    CASE(m, BRIK(a)[5] |= 0xC000u, CORRUPT, "M305", "BRIK", 40);
    CASE(m, memset(BRIK(a) + 16, 0, 128), CORRUPT, "M306", "BRIK", 128);
    CASE(m, memset(BRIK(a), 0xAA, 128), CORRUPT, "M306", "BRIK", 0);
    CASE(m, GRID(a)->surface_cells += 1, CORRUPT, "M307", "GRID", GRID_AT(surface_cells));
    CASE(m, GRID(a)->interior_cells -= 1, CORRUPT, "M307", "GRID", GRID_AT(interior_cells));
    CASE(m, GRID(a)->bbox_min[1] += 1, CORRUPT, "M308", "GRID", GRID_AT(bbox_min) + 8);
    CASE(m, GRID(a)->bbox_max[2] += 1, CORRUPT, "M308", "GRID", GRID_AT(bbox_max) + 16);
    CASE(c, LAYR(a)[700] = 4, CORRUPT, "M401", "LAYR", 700);
    CASE(c, DIST(a)[3] = INT16_MIN, CORRUPT, "M402", "DIST", 6);
    CASE(c, GRID(a)->flags |= VXS_VOXMAP_FLAG_UNSIGNED, CORRUPT, "M402", "DIST",
         -1 - (int64_t)built_entry(c, VXS_VOXMAP_SECTION_DIST)->offset);
}

static uint32_t one_cell(const void *shape, int64_t i, int64_t j, int64_t k)
{
    (void)shape;
    (void)j;
    (void)k;
    return i == 0 ? VXS_CELL_SURFACE : VXS_CELL_FREE;
}

/* Rules that need a map of their own. */
static void check_odd_voxmaps(void)
{
    int64_t low[3] = {0, 0, 0}, high[3] = {127, 0, 0};
    built_asset wide = build_voxmap(1, low, high, one_cell, NULL, BUILT_PLAIN); /* second chunk: free */
    refused(&wide, VXS_CORRUPT, "M302", "ROOT", -1);
    built_free(&wide);

    /* M103: a channel of one element less, and an unknown section in the bytes that it leaves. */
    built_asset copy = fresh(&channel_map), *a = &copy;
    TABLE(a)[5].count -= 1;
    TABLE(a)[5].size -= 1024;
    memmove(a->data + TABLE(a)[6].offset - 1024, a->data + TABLE(a)[6].offset, 64);
    TABLE(a)[6].offset -= 1024;
    HEADER(a)->file_size -= 1024;
    built_asset shorter = built_prefix(a, a->size - 1024);
    built_seal(&shorter);
    refused(&shorter, VXS_CORRUPT, "M103", "TABL", TABL_AT(5, id));
    built_free(&shorter);
    built_free(a);

    /* M304: a chunk that says nothing. With a channel its bricks may be uniform, the chunk may not. */
    built_asset uniform = fresh(&plain_map);
    uint32_t *entries = CHNK(&uniform);
    for (uint32_t n = 0; n < 512; n++) entries[n] = 2;
    built_seal(&uniform);
    refused(&uniform, VXS_CORRUPT, "M304", "CHNK", -1);
    built_free(&uniform);

    /* M303 at the end: the last brick is not referred to. */
    built_asset orphan = fresh(&plain_map);
    uint32_t last = 512 * 8 - 1;
    while (CHNK(&orphan)[last] < 4) last--;
    CHNK(&orphan)[last] = 0;
    built_seal(&orphan);
    refused(&orphan, VXS_CORRUPT, "M303", "CHNK",
            (int64_t)built_entry(&orphan, VXS_VOXMAP_SECTION_CHNK)->offset);
    built_free(&orphan);

    /* An unknown section before META is read over. */
    built_asset extended = fresh(&channel_map);
    vxs_asset opened;
    TABLE(&extended)[5].id = VXS_SECTION_ID('X', 'T', 'R', 'A');
    GRID(&extended)->distance_step = GRID(&extended)->distance_band = GRID(&extended)->distance_error = 0;
    built_seal(&extended);
    CHECK_INT(vxs_asset_from_memory(extended.data, extended.size, NULL, &opened, NULL), VXS_OK);
    built_free(&extended);
}

static void check_pointshell(void)
{
    const built_asset *s = &shell;
    CASE(s, swap_entries(a, 2, 3), CORRUPT, "S101", "TABL", TABL_AT(2, id));
    CASE(s, (TABLE(a)[7].stride = 8, TABLE(a)[7].count /= 2), CORRUPT, "S102", "TABL", TABL_AT(7, id));
    CASE(s, (TABLE(a)[0].stride = 56, TABLE(a)[0].count = 2), CORRUPT, "S102", "TABL", TABL_AT(0, id));
    CASE(s, SHEL(a)->voxel = 0, CORRUPT, "S201", "SHEL", 0);
    CASE(s, SHEL(a)->kind = 3, CORRUPT, "S202", "SHEL", SHEL_AT(kind));
    CASE(s, SHEL(a)->point_count = 0, LIMIT, "S203", "SHEL", SHEL_AT(point_count));
    CASE(s, SHEL(a)->point_count = UINT32_MAX, LIMIT, "S203", "SHEL", SHEL_AT(point_count));
    CASE(s, SHEL(a)->padded_count += 16, CORRUPT, "S204", "SHEL", SHEL_AT(padded_count));
    CASE(s, SHEL(a)->cluster_count += 1, CORRUPT, "S205", "SHEL", SHEL_AT(cluster_count));
    CASE(s, (SHEL(a)->point_count = 180, SHEL(a)->padded_count = 192, SHEL(a)->cluster_count = 3), CORRUPT,
         "S206", "TABL", TABL_AT(1, id));
    CASE(s, (SHEL(a)->point_count = 193, SHEL(a)->surface_cells = 1), CORRUPT, "S304", "SHEL", SHEL_AT(area));
    CASE(s, SHEL(a)->area = -1, CORRUPT, "S207", "SHEL", SHEL_AT(area));
    CASE(s, SHEL(a)->gap_max = NAN, CORRUPT, "S207", "SHEL", SHEL_AT(gap_max));
    CASE(s, SHEL(a)->surface_error = INFINITY, CORRUPT, "S207", "SHEL", SHEL_AT(surface_error));
    CASE(s, SHEL(a)->center[1] = 2e15, CORRUPT, "S207", "SHEL", SHEL_AT(center) + 8);
    CASE(s, SHEL(a)->radius = -1e-9, CORRUPT, "S207", "SHEL", SHEL_AT(radius));
    CASE(s, SHEL(a)->pad[23] = 1, CORRUPT, "S208", "SHEL", SHEL_AT(pad) + 23);
    CASE(s, SHEL(a)->surface_cells = 201, CORRUPT, "S209", "SHEL", SHEL_AT(surface_cells));
    CASE(s, SHEL(a)->surface_cells = 0, CORRUPT, "S209", "SHEL", SHEL_AT(surface_cells));
    CASE(s, FLOATS(a, POSY)[9] = NAN, CORRUPT, "S301", "POSY", 36);
    CASE(s, FLOATS(a, POSZ)[199] = -2e15f, CORRUPT, "S301", "POSZ", 796);
    CASE(s, FLOATS(a, NRMY)[7] += 0.001f, CORRUPT, "S302", "NRMX", 28);
    CASE(s, FLOATS(a, NRMZ)[7] = INFINITY, CORRUPT, "S302", "NRMX", 28);
    CASE(s, FLOATS(a, AREA)[5] = -0.0f, CORRUPT, "S303", "AREA", 20);
    CASE(s, FLOATS(a, AREA)[5] = NAN, CORRUPT, "S303", "AREA", 20);
    CASE(s, FLOATS(a, AREA)[5] *= 2, CORRUPT, "S304", "SHEL", SHEL_AT(area));
    CASE(s, FLOATS(a, POSX)[200] = 0, CORRUPT, "S305", "POSX", 800);
    CASE(s, FLOATS(a, NRMZ)[207] = 0, CORRUPT, "S305", "NRMZ", 828);
    CASE(s, FLOATS(a, AREA)[200] = 1, CORRUPT, "S305", "AREA", 800);
    CASE(s, FLOATS(a, AREA)[207] = -0.0f, CORRUPT, "S305", "AREA", 828);
    CASE(s, CLUS(a)[1].first = 63, CORRUPT, "S401", "CLUS", 32 + 16);
    CASE(s, CLUS(a)[3].count = 64, CORRUPT, "S401", "CLUS", 96 + 20);
    CASE(s, CLUS(a)[2].center[2] = NAN, CORRUPT, "S402", "CLUS", 64 + 8);
    CASE(s, CLUS(a)[2].radius = -1, CORRUPT, "S402", "CLUS", 64 + 12);
    CASE(s, CLUS(a)[2].reserved[1] = 1, CORRUPT, "S403", "CLUS", 64 + 24);
    CASE(s, CLUS(a)[0].radius = 0, CORRUPT, "S404", "POSX", 0);
    CASE(s, SHEL(a)->radius *= 0.9, CORRUPT, "S405", "POSX", 0);
}

int main(void)
{
    built_ball ball = {0.001, {0, 0, 0}, 0.0123};
    plain_map = build_ball_map(&ball, BUILT_PLAIN);
    channel_map = build_ball_map(&ball, BUILT_LAYERS | BUILT_DISTANCES);
    shell = build_ball_shell(0.001, 0.01, 200);
    open_voxmap(&plain_map);
    open_voxmap(&channel_map);
    open_pointshell(&shell);
    check_container();
    check_voxmap();
    check_odd_voxmaps();
    check_pointshell();
    printf("%d damaged files, each refused by its rule\n", cases);
    built_free(&plain_map);
    built_free(&channel_map);
    built_free(&shell);
    return 0;
}
