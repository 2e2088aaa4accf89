/* SPDX-License-Identifier: MIT
 *
 * The rules of formats/container.md, in the order of their ids: each makes safe what the next
 * one reads. Pure.
 */
#include "asset_check.h"
#include "voxshell/format/plan.h"
#include "voxshell/format/pointshell.h"
#include "voxshell/format/voxmap.h"

#include <string.h>

enum { HEADER_SIZE = sizeof(vxs_container_header), ENTRY_SIZE = sizeof(vxs_container_section) };

typedef struct asset_kind {
    char magic[VXS_CONTAINER_MAGIC_SIZE + 1];
    uint32_t kind;
    uint16_t major, minor;
    uint32_t features; /* bits of required_features that are known */
    vxs_result (*check)(vxsi_check *);
} asset_kind;

static const asset_kind kinds[] = {
    {VXS_VOXMAP_MAGIC, VXS_ASSET_VOXMAP, VXS_VOXMAP_VERSION_MAJOR, VXS_VOXMAP_VERSION_MINOR, 0,
     vxsi_check_voxmap},
    {VXS_POINTSHELL_MAGIC, VXS_ASSET_POINTSHELL, VXS_POINTSHELL_VERSION_MAJOR, VXS_POINTSHELL_VERSION_MINOR,
     VXS_POINTSHELL_FEATURE_NO_AREA, vxsi_check_pointshell},
    {VXS_PLAN_MAGIC, VXS_ASSET_PLAN, VXS_PLAN_VERSION_MAJOR, VXS_PLAN_VERSION_MINOR, 0, vxsi_check_plan},
};

vxs_result vxsi_refuse(vxsi_check *check, vxs_result result, const char *rule, uint32_t section,
                       uint64_t offset, const char *text)
{
    uint32_t number = 0;
    for (const char *digit = rule + 1; *digit; digit++) number = number * 10 + (uint32_t)(*digit - '0');
    check->issue.letter = rule[0];
    check->issue.rule = number;
    check->issue.section = section;
    check->issue.offset = offset;
    check->issue.text = text;
    return result;
}

vxs_result vxsi_refuse_entry(vxsi_check *check, vxs_result result, const char *rule,
                             const vxs_container_section *entry, const char *text)
{
    uint64_t offset = (uint64_t)((const uint8_t *)entry - check->data);
    return vxsi_refuse(check, result, rule, VXS_SECTION_TABL, offset, text);
}

const vxs_container_section *vxsi_table(const uint8_t *data)
{
    return (const vxs_container_section *)(const void *)(data + HEADER_SIZE);
}

const vxs_container_section *vxsi_find_section(const uint8_t *data, uint32_t id)
{
    const vxs_container_header *header = (const vxs_container_header *)(const void *)data;
    const vxs_container_section *table = vxsi_table(data);
    for (uint32_t i = 0; i < header->section_count; i++) {
        if (table[i].id == id) return &table[i];
    }
    return NULL;
}

static const asset_kind *find_kind(const uint8_t *data)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (memcmp(data, kinds[i].magic, VXS_CONTAINER_MAGIC_SIZE) == 0) return &kinds[i];
    }
    return NULL;
}

static vxs_result check_identity(vxsi_check *check, uint32_t wanted_kind, const asset_kind **kind)
{
    const vxs_container_header *header = (const vxs_container_header *)(const void *)check->data;
    if (check->size < HEADER_SIZE)
        return vxsi_refuse(check, VXS_TRUNCATED, "C101", VXS_SECTION_HEAD, 0,
                           "the file is shorter than a header");
    *kind = find_kind(check->data);
    if (!*kind)
        return vxsi_refuse(check, VXS_MAGIC, "C102", VXS_SECTION_HEAD, 0,
                           "the first eight bytes are no voxshell magic");
    if (wanted_kind != VXS_ASSET_ANY && (*kind)->kind != wanted_kind) {
        check->issue.section = VXS_SECTION_HEAD;
        check->issue.text = vxs_result_text(VXS_KIND);
        return VXS_KIND;
    }
    if (header->version_major != (*kind)->major) {
        check->issue.file_major = header->version_major;
        check->issue.file_minor = header->version_minor;
        check->issue.reader_major = (*kind)->major;
        check->issue.reader_minor = (*kind)->minor;
        return vxsi_refuse(
            check, VXS_VERSION, "C103", VXS_SECTION_HEAD, offsetof(vxs_container_header, version_major),
            "another major version than this reader's: convert the part again, or use newer tools");
    }
    return VXS_OK;
}

static vxs_result check_header(vxsi_check *check, const asset_kind *kind)
{
    const vxs_container_header *header = (const vxs_container_header *)(const void *)check->data;
#define REFUSE(result, rule, field, text)                                                                    \
    return vxsi_refuse(check, result, rule, VXS_SECTION_HEAD, offsetof(vxs_container_header, field), text)
    if (vxsi_crc32(check->data, offsetof(vxs_container_header, header_crc)) != header->header_crc)
        REFUSE(VXS_CHECKSUM, "C104", header_crc, "the header's checksum does not match");
    if (header->required_features & ~kind->features)
        REFUSE(VXS_FEATURE, "C105", required_features, "a required feature is not known to this reader");
    if (check->size < header->file_size)
        REFUSE(VXS_TRUNCATED, "C106", file_size, "the file is shorter than file_size");
    if (check->size > header->file_size)
        REFUSE(VXS_CORRUPT, "C106", file_size, "the file is longer than file_size");
    if (header->section_count < 1 || header->section_count > VXS_CONTAINER_MAX_SECTIONS ||
        HEADER_SIZE + (uint64_t)ENTRY_SIZE * header->section_count > check->size)
        REFUSE(VXS_LIMIT, "C107", section_count,
               "section_count is not within 1 .. 64, or the table leaves the file");
    if (header->header_size != HEADER_SIZE)
        REFUSE(VXS_CORRUPT, "C108", header_size, "header_size is not 128");
    if (header->section_entry_size != ENTRY_SIZE)
        REFUSE(VXS_CORRUPT, "C108", section_entry_size, "section_entry_size is not 40");
    if (header->section_table_offset != HEADER_SIZE)
        REFUSE(VXS_CORRUPT, "C108", section_table_offset, "section_table_offset is not 128");
    if (header->reserved[0] != 0 || header->reserved[1] != 0)
        REFUSE(VXS_CORRUPT, "C109", reserved, "a reserved field is not 0");
    if (vxsi_crc32(check->data + HEADER_SIZE, (size_t)ENTRY_SIZE * header->section_count) !=
        header->table_crc)
        REFUSE(VXS_CHECKSUM, "C110", table_crc, "the section table's checksum does not match");
#undef REFUSE
    return VXS_OK;
}

static int id_is_valid(uint32_t id)
{
    for (int letter = 0; letter < 4; letter++) {
        uint32_t byte = id >> (8 * letter) & 0xFFu;
        if (!((byte >= 'A' && byte <= 'Z') || (byte >= '0' && byte <= '9'))) return 0;
    }
    return id != VXS_SECTION_HEAD && id != VXS_SECTION_TABL;
}

static vxs_result check_entry(vxsi_check *check, uint32_t index, uint64_t start)
{
    const vxs_container_section *table = vxsi_table(check->data), *entry = &table[index];
    uint64_t at = HEADER_SIZE + (uint64_t)index * ENTRY_SIZE;
#define REFUSE(rule, field, text)                                                                            \
    return vxsi_refuse(check, VXS_CORRUPT, rule, VXS_SECTION_TABL,                                           \
                       at + offsetof(vxs_container_section, field), text)
    if (!id_is_valid(entry->id)) REFUSE("C201", id, "a section id is not four of A-Z 0-9, or is reserved");
    for (uint32_t other = 0; other < index; other++) {
        if (table[other].id == entry->id) REFUSE("C201", id, "two sections have this id");
    }
    if (entry->stride == 0) REFUSE("C202", stride, "stride is 0");
    if (entry->count == 0) REFUSE("C202", count, "count is 0");
    if (entry->count > UINT64_MAX / entry->stride || entry->count * entry->stride != entry->size)
        REFUSE("C202", size, "size is not stride x count");
    if (entry->offset != start) REFUSE("C203", offset, "a section does not start where the one before ends");
    if (entry->offset > check->size || entry->size > check->size - entry->offset)
        REFUSE("C203", offset, "a section leaves the file");
    if (entry->reserved != 0) REFUSE("C204", reserved, "a reserved field is not 0");
#undef REFUSE
    return VXS_OK;
}

/* Of an offset within a mapped file, so it cannot overflow. */
static uint64_t round64(uint64_t size)
{
    return (size + VXS_CONTAINER_ALIGNMENT - 1) / VXS_CONTAINER_ALIGNMENT * VXS_CONTAINER_ALIGNMENT;
}

static vxs_result check_table(vxsi_check *check)
{
    const vxs_container_header *header = (const vxs_container_header *)(const void *)check->data;
    const vxs_container_section *table = vxsi_table(check->data);
    uint64_t end = HEADER_SIZE + (uint64_t)ENTRY_SIZE * header->section_count;
    for (uint32_t i = 0; i < header->section_count; i++) {
        vxs_result result = check_entry(check, i, round64(end));
        if (result != VXS_OK) return result;
        end = table[i].offset + table[i].size;
    }
    if (check->size != round64(end))
        return vxsi_refuse(check, VXS_CORRUPT, "C205", VXS_SECTION_HEAD,
                           offsetof(vxs_container_header, file_size),
                           "the file does not end with the padding of its last section");
    const vxs_container_section *last = &table[header->section_count - 1];
    if (last->id != VXS_SECTION_META || last->stride != 1)
        return vxsi_refuse_entry(check, VXS_CORRUPT, "C206", last,
                                 "the last section is not META of stride 1");
    return VXS_OK;
}

static vxs_result check_gap(vxsi_check *check, uint32_t before, uint64_t from)
{
    for (uint64_t at = from; at < round64(from); at++) {
        if (check->data[at] != 0)
            return vxsi_refuse(check, VXS_CORRUPT, "C301", before, at, "padding is not 0");
    }
    return VXS_OK;
}

static vxs_result check_bytes(vxsi_check *check)
{
    const vxs_container_header *header = (const vxs_container_header *)(const void *)check->data;
    const vxs_container_section *table = vxsi_table(check->data);
    uint32_t count = header->section_count;
    vxs_result result = check_gap(check, VXS_SECTION_TABL, HEADER_SIZE + (uint64_t)ENTRY_SIZE * count);
    for (uint32_t i = 0; i < count && result == VXS_OK; i++)
        result = check_gap(check, table[i].id, table[i].offset + table[i].size);
    for (uint32_t i = 0; i < count && result == VXS_OK && !check->skip_checksums; i++) {
        if (vxsi_crc32(check->data + table[i].offset, (size_t)table[i].size) != table[i].crc)
            result = vxsi_refuse(check, VXS_CHECKSUM, "C302", table[i].id, table[i].offset,
                                 "the section's checksum does not match");
    }
    return result;
}

vxs_result vxsi_check_asset(vxsi_check *check, uint32_t wanted_kind, vxs_asset *out)
{
    const asset_kind *kind = NULL;
    vxs_result result = check_identity(check, wanted_kind, &kind);
    if (result == VXS_OK) result = check_header(check, kind);
    if (result == VXS_OK) result = check_table(check);
    if (result == VXS_OK) result = check_bytes(check);
    if (result == VXS_OK) result = kind->check(check);
    if (result != VXS_OK) return result;
    const vxs_container_header *header = (const vxs_container_header *)(const void *)check->data;
    *out = (vxs_asset){.data = check->data,
                       .size = check->size,
                       .kind = kind->kind,
                       .version_major = header->version_major,
                       .version_minor = header->version_minor};
    check->issue.text = vxs_result_text(VXS_OK);
    return VXS_OK;
}

const vxs_container_header *vxs_asset_header(const vxs_asset *asset)
{
    return (const vxs_container_header *)(const void *)asset->data;
}

const vxs_container_section *vxs_asset_section(const vxs_asset *asset, uint32_t id)
{
    return vxsi_find_section(asset->data, id);
}
