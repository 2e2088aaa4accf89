/* SPDX-License-Identifier: MIT
 *
 * asset_mutator.h - another asset file from one: fields, table and contents are changed as what they are,
 * then mostly layout, counts and checksums are made right again, so that damage gets past the first rules.
 */
#ifndef VXS_FUZZ_ASSET_MUTATOR_H
#define VXS_FUZZ_ASSET_MUTATOR_H

#include "voxshell/format/container.h"

enum { ASSET_MOST = 1 << 15 }; /* bytes of a file, and of a section on the way */

typedef struct draft_part {
    vxs_container_section entry;
    uint8_t *bytes; /* ASSET_MOST of room, aligned for any type */
    size_t size;
} draft_part;

/* A file taken apart. */
typedef struct draft {
    vxs_container_header header;
    uint32_t count;
    draft_part part[VXS_CONTAINER_MAX_SECTIONS];
} draft;

/* The part with this id, or NULL. */
draft_part *draft_find(draft *d, uint32_t id);

/* Elements of a part, by its table entry's stride, that are there in full; 0 for NULL and for less than
 * stride bytes each. */
size_t draft_elements(const draft_part *part, size_t stride);

/* Makes true what the kind's rules say of several fields at once (asset_repair.c): counts, boxes, sums,
 * spheres, padding. By the header's magic. A bit of `leave` leaves out one of these. */
void draft_repair(draft *d, uint32_t leave);

/* A number from a file that no rule looks at (its content hash), for a target to choose by. */
uint64_t asset_variant(const uint8_t *bytes, size_t size);

/* Whether a target puts this variant to the sections' checksums: they take most of the time, and guard
 * nothing. */
int asset_is_summed(uint64_t variant);

/* Mutates `size` bytes in place; at most `most` of them result. */
size_t asset_mutate(uint8_t *bytes, size_t size, size_t most, uint32_t seed);

/* Number `number` (any) of the golden files, and of those in the folder corpus/ beside this source, with this
 * ending (".voxmap"); returns its size, 0 if it is larger than most. */
size_t asset_seed(const char *ending, uint32_t number, uint8_t *bytes, size_t most);

#endif
