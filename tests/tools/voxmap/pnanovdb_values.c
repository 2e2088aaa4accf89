/* SPDX-License-Identifier: GPL-3.0-or-later */
#define PNANOVDB_C
#define PNANOVDB_BUF_BOUNDS_CHECK
#include <nanovdb/PNanoVDB.h>

#include "pnanovdb_values.h"

static pnanovdb_buf_t buffer(const void *grid)
{
    uint32_t *words = (uint32_t *)(uintptr_t)grid; /* it only reads */
    pnanovdb_grid_handle_t whole = {{0}};
    return pnanovdb_make_buf(
        words, pnanovdb_grid_get_grid_size(pnanovdb_make_buf(words, PNANOVDB_GRID_SIZE / 4), whole) / 4);
}

static pnanovdb_address_t value(pnanovdb_buf_t buf, pnanovdb_grid_type_t type, int32_t i, int32_t j,
                                int32_t k)
{
    pnanovdb_grid_handle_t grid = {{0}};
    pnanovdb_root_handle_t root = pnanovdb_tree_get_root(buf, pnanovdb_grid_get_tree(buf, grid));
    pnanovdb_coord_t at = {i, j, k};
    return pnanovdb_root_get_value_address(type, buf, root, &at);
}

int32_t pnanovdb_int(const void *grid, int32_t i, int32_t j, int32_t k)
{
    pnanovdb_buf_t buf = buffer(grid);
    return pnanovdb_read_int32(buf, value(buf, PNANOVDB_GRID_TYPE_INT32, i, j, k));
}

float pnanovdb_float(const void *grid, int32_t i, int32_t j, int32_t k)
{
    pnanovdb_buf_t buf = buffer(grid);
    return pnanovdb_read_float(buf, value(buf, PNANOVDB_GRID_TYPE_FLOAT, i, j, k));
}

void pnanovdb_world(const void *grid, const float index[3], float world[3])
{
    pnanovdb_grid_handle_t whole = {{0}};
    pnanovdb_vec3_t from = {index[0], index[1], index[2]};
    pnanovdb_vec3_t to = pnanovdb_grid_index_to_worldf(buffer(grid), whole, &from);
    world[0] = to.x;
    world[1] = to.y;
    world[2] = to.z;
}
