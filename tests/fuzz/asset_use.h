/* SPDX-License-Identifier: MIT
 *
 * asset_use.h - what a fuzz target does with an asset: opens bytes that may be hostile, and feels what is
 * accepted.
 */
#ifndef VXS_FUZZ_ASSET_USE_H
#define VXS_FUZZ_ASSET_USE_H

#include "voxshell/voxshell.h"

/* A copy of the bytes in a heap block of just their size, opened; *variant: as asset_variant(). NULL if it is
 * refused (the refusal is checked), else to be freed with use_close(). */
uint8_t *use_open(const uint8_t *bytes, size_t size, vxs_asset *asset, uint64_t *variant);
void use_close(uint8_t *copy, vxs_asset *asset);

/* Contacts of one shell with the fastest kernel and the scalar one, which must say the same. */
typedef struct use_pair {
    void *memory[4];
    vxs_contact *fast, *plain;
    const vxs_pointshell *shell;
} use_pair;
void use_pair_open(use_pair *pair, const vxs_pointshell *shell);
void use_pair_close(use_pair *pair);

/* A few evaluations with the shell's middle in a cell of the map that is not free; aborts unless the wrenches
 * are finite, and the same for both kernels. */
void use_touch(use_pair *pair, const vxs_voxmap *map, uint64_t variant);

/* The number of cells of each state at a sample of places; aborts at a state that is none. */
void use_look_up(const vxs_voxmap *map, uint64_t variant);

/* Good partners, made once: 0 a ball's map with layers and distances, 1 the golden one with a clearance. */
const vxs_voxmap *use_map(int which);
const vxs_pointshell *use_shell(void);
void use_partners(vxs_asset *map, vxs_asset *shell);

#endif
