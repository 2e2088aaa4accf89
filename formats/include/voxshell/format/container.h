/* SPDX-License-Identifier: MIT
 *
 * container.h - the frame that every voxshell asset shares (formats/container.md).
 *
 * One header, one section table, then sections. Little-endian, no pointers, no
 * bit-fields, no implicit padding. Nothing here allocates or reads: these are the
 * bytes themselves. Rule ids (C101 ...) are those of container.md.
 */
#ifndef VOXSHELL_FORMAT_CONTAINER_H
#define VOXSHELL_FORMAT_CONTAINER_H

#include <stddef.h>
#include <stdint.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "voxshell assets are little-endian and mapped as they are: a big-endian host cannot read them in place"
#endif

#ifdef __cplusplus
/* Does not compile unless expr holds. */
#define VXS_STATIC_ASSERT(expr, text) static_assert(expr, text)
extern "C" {
#else
/* The same in C. */
#define VXS_STATIC_ASSERT(expr, text) _Static_assert(expr, text)
#endif

enum {
    VXS_CONTAINER_MAGIC_SIZE = 8,    /* [bytes] */
    VXS_CONTAINER_ALIGNMENT = 64,    /* of every section, and of the file size */
    VXS_CONTAINER_MAX_SECTIONS = 64, /* C107 */
    VXS_CONTAINER_HASH_SIZE = 32     /* SHA-256 [bytes] */
};

/* 0x89 as in PNG (not text, catches a 7-bit path), three letters for the kind, then
 * CR LF ^Z LF (catches line-end conversion). One magic per kind from the first day. */
#define VXS_VOXMAP_MAGIC "\x89VXM\r\n\x1a\n"     /* voxmap.h */
#define VXS_POINTSHELL_MAGIC "\x89VXP\r\n\x1a\n" /* pointshell.h */
#define VXS_PLAN_MAGIC "\x89VXL\r\n\x1a\n"       /* plan.h */

/* A section's id: four characters as they stand in the file. */
#define VXS_SECTION_ID(a, b, c, d)                                                                           \
    ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)

/* META: UTF-8 JSON object, tool version, options, names. For people and for `inspect`;
 * the runtime never parses it. The last section, outside the content hash (C206, C303). */
#define VXS_SECTION_META VXS_SECTION_ID('M', 'E', 'T', 'A')

/* Never in a file: where a broken rule is reported that belongs to no section (C201). */
#define VXS_SECTION_HEAD VXS_SECTION_ID('H', 'E', 'A', 'D') /* the header */
#define VXS_SECTION_TABL VXS_SECTION_ID('T', 'A', 'B', 'L') /* the section table */

/* Edge of a cell that an asset may state [m] (M201, S201). */
#define VXS_VOXEL_MIN 1e-12 /* least */
#define VXS_VOXEL_MAX 1e3   /* most */

/* What a file begins with. */
typedef struct vxs_container_header {
    uint8_t magic[VXS_CONTAINER_MAGIC_SIZE];       /* VXS_VOXMAP_MAGIC ... */
    uint16_t version_major;                        /* of the kind's format: a newer one is refused, */
    uint16_t version_minor;                        /* a newer one of these is read */
    uint32_t header_size;                          /* 128: this struct */
    uint64_t file_size;                            /* of the whole file [bytes] */
    uint32_t required_features;                    /* a bit the reader does not know: refuse */
    uint32_t optional_features;                    /* a bit the reader does not know: ignore */
    uint32_t section_count;                        /* entries of the table */
    uint32_t section_entry_size;                   /* 40: vxs_container_section */
    uint64_t section_table_offset;                 /* 128 */
    uint8_t content_hash[VXS_CONTAINER_HASH_SIZE]; /* SHA-256, container.md "Content hash" */
    uint8_t source_hash[VXS_CONTAINER_HASH_SIZE];  /* SHA-256 of the input's bytes */
    uint32_t table_crc;                            /* CRC-32 of the section table */
    uint32_t reserved[2];                          /* 0 */
    uint32_t header_crc;                           /* CRC-32 of bytes 0..123 */
} vxs_container_header;

/* An entry of the section table. */
typedef struct vxs_container_section {
    uint32_t id;       /* four characters, VXS_SECTION_ID */
    uint32_t stride;   /* bytes per element, never 0 */
    uint64_t count;    /* elements */
    uint64_t offset;   /* from the start of the file: the first multiple of 64 after what comes before */
    uint64_t size;     /* count * stride, without the padding to the next 64 */
    uint32_t crc;      /* CRC-32 of the size bytes */
    uint32_t reserved; /* 0 */
} vxs_container_section;

VXS_STATIC_ASSERT(sizeof(vxs_container_header) == 128, "container header is 128 bytes");
VXS_STATIC_ASSERT(offsetof(vxs_container_header, file_size) == 16, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_container_header, section_table_offset) == 40, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_container_header, content_hash) == 48, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_container_header, source_hash) == 80, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_container_header, header_crc) == 124, "layout");
VXS_STATIC_ASSERT(sizeof(vxs_container_section) == 40, "section entry is 40 bytes");
VXS_STATIC_ASSERT(offsetof(vxs_container_section, crc) == 32, "layout");

#ifdef __cplusplus
}
#endif
#endif
