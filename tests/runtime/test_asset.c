/* SPDX-License-Identifier: MIT
 *
 * Opening: from a file and from memory, both modes, both kinds; what is refused and how it is said.
 */
#define _POSIX_C_SOURCE 200809L /* mkstemp */

#include "asset_builder.h"
#include "check.h"

#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

static char path[] = "test_asset_XXXXXX";

static void write_file(const built_asset *asset)
{
    FILE *file = fopen(path, "wb");
    CHECK(file != NULL);
    CHECK(asset->size == 0 || fwrite(asset->data, asset->size, 1, file) == 1);
    CHECK(fclose(file) == 0);
}

static void check_file(const built_asset *bytes, uint32_t mode)
{
    vxs_asset_config config;
    vxs_asset_config_default(&config);
    config.mode = mode;
    vxs_asset asset;
    vxs_asset_issue issue;
    CHECK_INT(vxs_asset_open(path, &config, &asset, &issue), VXS_OK);
    CHECK_TEXT(issue.text, "ok");
    CHECK_INT(asset.size, bytes->size);
    CHECK_INT((uintptr_t)asset.data % 64, 0);
    CHECK(memcmp(asset.data, bytes->data, bytes->size) == 0);
    CHECK_INT(asset.version_major, 1);
    CHECK_INT(vxs_asset_header(&asset)->file_size, bytes->size);
    const vxs_container_section *meta = vxs_asset_section(&asset, VXS_SECTION_META);
    CHECK(meta != NULL && memcmp(asset.data + meta->offset, "{}", 2) == 0);
    CHECK(vxs_asset_section(&asset, VXS_SECTION_ID('N', 'O', 'P', 'E')) == NULL);
    vxs_asset_close(&asset);
    CHECK(asset.data == NULL);
    vxs_asset_close(&asset);
    vxs_asset_close(NULL);
}

static vxs_result open_error(const char *name, const vxs_asset_config *config, vxs_asset_issue *issue)
{
    vxs_asset asset;
    memset(&asset, 0xAA, sizeof asset);
    vxs_result result = vxs_asset_open(name, config, &asset, issue);
    CHECK(result != VXS_OK && asset.data == NULL && asset.size == 0);
    return result;
}

static void check_files(const built_asset *map, const built_asset *shell)
{
    vxs_asset_issue issue;
    int fd = mkstemp(path);
    CHECK(fd >= 0);
    close(fd);
    write_file(map);
    check_file(map, VXS_ASSET_MAP);
    check_file(map, VXS_ASSET_COPY);
    write_file(shell);
    check_file(shell, VXS_ASSET_MAP);
    check_file(shell, VXS_ASSET_COPY);

    vxs_asset_config config;
    vxs_asset_config_default(&config);
    config.kind = VXS_ASSET_VOXMAP;
    CHECK_INT(open_error(path, &config, &issue), VXS_KIND);
    CHECK_INT(issue.letter, 0);
    config.struct_size = 3;
    CHECK_INT(open_error(path, &config, &issue), VXS_CONFIG);
    CHECK_INT(open_error(NULL, NULL, &issue), VXS_PARAM);
    vxs_asset_config_default(&config);
    config.mode = 9;
    CHECK_INT(open_error(path, &config, NULL), VXS_PARAM);

    built_asset empty = {NULL, 0};
    write_file(&empty);
    CHECK_INT(open_error(path, NULL, &issue), VXS_TRUNCATED);
    CHECK_INT(issue.rule, 101);
    CHECK(remove(path) == 0);
    CHECK_INT(open_error(path, NULL, &issue), VXS_IO);
    CHECK_INT(issue.system_error, ENOENT);
    CHECK_INT(open_error("/", NULL, &issue), VXS_IO);
    CHECK_INT(open_error("/dev/null", NULL, &issue), VXS_IO);
    /* A pipe must not block the one who opens it. */
    CHECK(mkfifo(path, 0600) == 0);
    CHECK_INT(open_error(path, NULL, &issue), VXS_IO);
    CHECK(remove(path) == 0);
}

static void check_memory(built_asset *map)
{
    vxs_asset asset;
    vxs_asset_issue issue;
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, NULL, &asset, &issue), VXS_OK);
    vxs_asset_close(&asset);
    CHECK_INT(vxs_asset_from_memory(map->data + 8, map->size - 8, NULL, &asset, &issue), VXS_BUFFER);
    CHECK_INT(vxs_asset_from_memory(NULL, 128, NULL, &asset, &issue), VXS_PARAM);
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, NULL, NULL, NULL), VXS_PARAM);

    vxs_container_header *header = (vxs_container_header *)(void *)map->data;
    header->version_minor = 7;
    header->optional_features = 0x80000001u;
    built_seal(map);
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, NULL, &asset, &issue), VXS_OK);
    CHECK_INT(asset.version_minor, 7);
    header->version_major = 2;
    built_seal(map);
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, NULL, &asset, &issue), VXS_VERSION);
    CHECK_INT(issue.rule, 103);
    CHECK_INT(issue.file_major * 100 + issue.file_minor, 207);
    CHECK_INT(issue.reader_major * 100 + issue.reader_minor, 100);
    header->version_major = 1;
    built_seal(map);

    /* Without the section checksums damage to META passes, damage to meaning does not. */
    vxs_asset_config config;
    vxs_asset_config_default(&config);
    config.skip_checksums = 1;
    uint8_t *meta = built_bytes(map, VXS_SECTION_META);
    meta[0] ^= 1u;
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, NULL, &asset, &issue), VXS_CHECKSUM);
    CHECK_INT(issue.section, VXS_SECTION_META);
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, &config, &asset, &issue), VXS_OK);
    meta[0] ^= 1u;
    uint64_t *bricks = built_bytes(map, VXS_VOXMAP_SECTION_BRIK);
    bricks[1] ^= 3u;
    CHECK(vxs_asset_from_memory(map->data, map->size, &config, &asset, &issue) != VXS_OK);
    /* A trusted file's sections are not looked into; its header, table and sizes are. */
    config.skip_checksums = 0;
    config.trusted = 1;
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, &config, &asset, &issue), VXS_OK);
    bricks[1] ^= 3u;
    CHECK_INT(vxs_asset_from_memory(map->data, map->size - 64, &config, &asset, &issue), VXS_TRUNCATED);
    vxs_container_section *root = built_entry(map, VXS_VOXMAP_SECTION_ROOT);
    root->stride = 8;
    built_seal(map);
    CHECK(vxs_asset_from_memory(map->data, map->size, &config, &asset, &issue) != VXS_OK);
    root->stride = 4;
    built_seal(map);
    CHECK_INT(vxs_asset_from_memory(map->data, map->size, NULL, &asset, &issue), VXS_OK);
}

int main(void)
{
    built_ball ball = {0.001, {0.0101, -0.0052, 0.0003}, 0.0123};
    built_asset map = build_ball_map(&ball, BUILT_LAYERS | BUILT_DISTANCES);
    built_asset shell = build_ball_shell(0.001, 0.01, 200);
    check_files(&map, &shell);
    check_memory(&map);

    vxs_asset asset;
    vxs_voxmap map_view;
    vxs_pointshell shell_view;
    CHECK_INT(vxs_asset_from_memory(shell.data, shell.size, NULL, &asset, NULL), VXS_OK);
    CHECK_INT(vxs_voxmap_open(&asset, &map_view), VXS_KIND);
    CHECK_INT(vxs_pointshell_open(&asset, &shell_view), VXS_OK);
    CHECK_INT(shell_view.point_count, 200);
    vxs_asset_close(&asset);
    CHECK_INT(vxs_pointshell_open(&asset, &shell_view), VXS_PARAM);
    built_free(&map);
    built_free(&shell);
    return 0;
}
