/* SPDX-License-Identifier: MIT
 *
 * asset_check.h - private: the pure checks behind vxs_asset_open(). Bytes in, verdict out; no
 * system call, no allocation.
 */
#ifndef VXSI_ASSET_CHECK_H
#define VXSI_ASSET_CHECK_H

#include "voxshell/asset.h"

typedef struct vxsi_check {
    const uint8_t *data; /* 64-byte aligned */
    uint64_t size;
    int skip_checksums, trusted;
    vxs_asset_issue issue;
} vxsi_check;

/* Container, then the kind's own rules; out is filled on VXS_OK. */
vxs_result vxsi_check_asset(vxsi_check *check, uint32_t wanted_kind, vxs_asset *out);

vxs_result vxsi_check_voxmap(vxsi_check *check);
vxs_result vxsi_check_pointshell(vxsi_check *check);
vxs_result vxsi_check_plan(vxsi_check *check);

/* Notes where and why, and returns result. rule: "M305". */
vxs_result vxsi_refuse(vxsi_check *check, vxs_result result, const char *rule, uint32_t section,
                       uint64_t offset, const char *text);

/* The same for a table entry as a whole. */
vxs_result vxsi_refuse_entry(vxsi_check *check, vxs_result result, const char *rule,
                             const vxs_container_section *entry, const char *text);

/* The section table, once the header has passed. */
const vxs_container_section *vxsi_table(const uint8_t *data);

/* The entry of a section in a table that has passed the container's rules, or NULL. */
const vxs_container_section *vxsi_find_section(const uint8_t *data, uint32_t id);

/* Ends vxs_asset_guard(). */
void vxsi_asset_unguard(const vxs_asset *asset);

uint32_t vxsi_crc32(const uint8_t *data, size_t size);

#endif
