/* SPDX-License-Identifier: MIT
 *
 * asset.h - open an asset file (.voxmap, .pointshell, .plan) and trust it from then on.
 *
 * Opening checks every rule of formats/container.md and of the kind's own spec, once:
 * sizes, checksums, then meaning (each entry in range, no cell of state 3, unit normals,
 * spheres that hold their points ...). Only C303, the content hash, is left to `voxshell verify`. After
 * VXS_OK a look-up needs no check. A file may be hostile with valid checksums: no byte is trusted before its
 * rule has been checked, nothing is allocated by what a file says, and the work is linear in the file's size.
 *
 *     vxs_asset asset;
 *     vxs_asset_issue issue;
 *     vxs_result r = vxs_asset_open("cup.voxmap", NULL, &asset, &issue);
 *     if (r != VXS_OK && issue.letter) printf("%c%u: %s\n", issue.letter, (unsigned)issue.rule, issue.text);
 */
#ifndef VOXSHELL_ASSET_H
#define VOXSHELL_ASSET_H

#include "voxshell/format/container.h"
#include "voxshell/result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a file is, by its first bytes; ANY in a config: whatever it is. */
enum { VXS_ASSET_ANY = 0, VXS_ASSET_VOXMAP = 1, VXS_ASSET_POINTSHELL = 2, VXS_ASSET_PLAN = 3 };

/* How a file gets into memory. MAP shares the page cache and opens at once; the file must not be written or
 * shortened while open (a writer that renames, as the tools do, does neither): a byte that changes after the
 * checks is trusted like the one that was checked, and one that is gone raises SIGBUS, unless
 * vxs_asset_guard(). COPY reads the file into private memory and is independent of it from then on. */
enum { VXS_ASSET_MAP = 0, VXS_ASSET_COPY = 1 };

/* Config. */
typedef struct vxs_asset_config {
    uint32_t struct_size;
    uint32_t kind;           /* VXS_ASSET_ANY, or the only kind that is accepted */
    uint32_t mode;           /* VXS_ASSET_MAP (default) or _COPY */
    uint32_t skip_checksums; /* not 0: trust the section checksums (faster start); all else is checked */
    uint32_t trusted;        /* not 0: look at header, table and sizes only, not into the sections: opens at
                                once, whatever the size. For a file that was checked before and cannot have
                                changed since: a broken one reads and writes anywhere. Pages that nobody has
                                touched fault in the first ticks (VXS_ASSET_COPY does not) */
} vxs_asset_config;

/* View of a checked asset: borrowed bytes, valid until vxs_asset_close(). Read-only, may be
 * shared by any number of threads. */
typedef struct vxs_asset {
    const uint8_t *data;                   /* the whole file, 64-byte aligned */
    uint64_t size;                         /* [bytes], multiple of 64 */
    uint32_t kind;                         /* VXS_ASSET_VOXMAP, _POINTSHELL or _PLAN */
    uint16_t version_major, version_minor; /* of its format */
    uint64_t mapped_size;                  /* private to vxs_asset_close(): 0 for caller's memory */
} vxs_asset;

/* Why a file was refused: the first broken rule, in the order of the specs. The rule is the id
 * there: letter 'C' container.md, 'M' voxmap.md, 'S' pointshell.md, 'P' plan.md, and its number; "M305" is
 * {'M', 305}. Letter and rule are 0 where no rule was broken (VXS_IO, VXS_PARAM, VXS_KIND ...). */
typedef struct vxs_asset_issue {
    char letter;
    uint32_t rule;
    uint32_t section; /* VXS_SECTION_ID of the section, VXS_SECTION_HEAD or VXS_SECTION_TABL */
    uint64_t offset;  /* from the start of the file [bytes], of the field or element that breaks the rule */
    const char *text; /* static storage, one line */
    int system_error; /* errno of a VXS_IO, else 0 */
    uint16_t file_major, file_minor;     /* of a VXS_VERSION: what the file says, */
    uint16_t reader_major, reader_minor; /* and what this reader knows */
} vxs_asset_issue;

/* Fills a config with the defaults that its members name. Thread: any, rt-safe. */
VXS_API void vxs_asset_config_default(vxs_asset_config *config);

/* Opens and checks the file. config may be NULL (default), issue may be NULL. On failure *out
 * is all zero and nothing stays open.
 * Returns VXS_OK; VXS_PARAM, VXS_CONFIG; VXS_IO; VXS_MAGIC (not an asset), VXS_KIND (an asset
 * of another kind than config->kind), VXS_VERSION, VXS_FEATURE, VXS_TRUNCATED, VXS_CHECKSUM,
 * VXS_LIMIT, VXS_CORRUPT.
 * Thread: any, set-up (system calls; reads the whole file unless checksums are skipped). */
VXS_API vxs_result vxs_asset_open(const char *path, const vxs_asset_config *config, vxs_asset *out,
                                  vxs_asset_issue *issue);

/* The same checks on bytes that the caller holds and keeps unchanged until vxs_asset_close().
 * data must be 64-byte aligned (VXS_BUFFER otherwise); config->mode is ignored.
 * Thread: any, set-up (no system call, no allocation; linear in size). */
VXS_API vxs_result vxs_asset_from_memory(const void *data, size_t size, const vxs_asset_config *config,
                                         vxs_asset *out, vxs_asset_issue *issue);

/* Ends all views of the asset and zeroes it. NULL and a zeroed asset are allowed.
 * Thread: set-up; no other thread may use the asset's views any more. */
VXS_API void vxs_asset_close(vxs_asset *asset);

/* A file that is mapped may be shortened by somebody, or its disk may fail: the next touch of what is gone
 * raises SIGBUS and ends the process. After this call such a touch reads zeros, as all does from there to the
 * asset's end (cells that are free, points without normals): a tick that is under way ends, within the map,
 * and vxs_asset_lost() tells. A servo thread then commands zero with VXS_SERVO_FAULT, until the asset is
 * closed; who calls vxs_servo_tick() himself must ask after each tick, and command zero. Until
 * vxs_asset_close(); nothing to do for a copy. Installs a handler of SIGBUS for the process, once; what it
 * does not know goes to the handler that was there. Returns VXS_OK; VXS_PARAM for NULL or a closed asset;
 * VXS_LIMIT with 1024 guarded already; VXS_UNSUPPORTED. Thread: any, set-up. */
VXS_API vxs_result vxs_asset_guard(const vxs_asset *asset);

/* How many guarded assets have lost bytes and are still open. Thread: any, rt-safe. */
VXS_API uint32_t vxs_asset_lost(void);

/* The header of a checked asset: versions, hashes. Borrowed. Thread: any, rt-safe. */
VXS_API const vxs_container_header *vxs_asset_header(const vxs_asset *asset);

/* The table entry of a section, or NULL if the asset has none with this id: its bytes are
 * data + offset, size of them. Borrowed. Thread: any, rt-safe. */
VXS_API const vxs_container_section *vxs_asset_section(const vxs_asset *asset, uint32_t id);

/* CRC-32 (IEEE 802.3, as zlib's crc32() from 0) of the bytes. Thread: any, set-up. */
VXS_API uint32_t vxs_asset_crc32(const void *data, size_t size);

#ifdef __cplusplus
}
#endif
#endif
