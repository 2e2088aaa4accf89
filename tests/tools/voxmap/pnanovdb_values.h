/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Values of a NanoVDB grid by PNanoVDB.h, NanoVDB's reader in C, which shaders include too. */
#ifndef VOXSHELL_TEST_PNANOVDB_VALUES_H
#define VOXSHELL_TEST_PNANOVDB_VALUES_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* `grid`: the bytes of one grid, at an address that is a multiple of 32. */
int32_t pnanovdb_int(const void *grid, int32_t i, int32_t j, int32_t k);
float pnanovdb_float(const void *grid, int32_t i, int32_t j, int32_t k);
void pnanovdb_world(const void *grid, const float index[3], float world[3]);

#ifdef __cplusplus
}
#endif
#endif
