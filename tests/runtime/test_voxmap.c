/* SPDX-License-Identifier: MIT
 *
 * Look-ups against the analytic shape that the map was made of.
 */
#include "asset_builder.h"
#include "check.h"

static uint32_t stripes(const void *shape, int64_t i, int64_t j, int64_t k)
{
    (void)shape;
    uint64_t mixed = (uint64_t)(i * 73856093 ^ j * 19349663 ^ k * 83492791);
    return i == -70 || mixed % 7 == 0 ? VXS_CELL_SURFACE
           : (i + 200) / 40 % 2       ? VXS_CELL_INTERIOR
                                      : VXS_CELL_FREE;
}

static void check_cell_of(const vxs_voxmap *map)
{
    int64_t cell[3] = {7, 7, 7};
    double p[3] = {-1e-9, 0, 0.0249999};
    CHECK(vxs_voxmap_cell_of(map, p, cell));
    CHECK(cell[0] == -1 && cell[1] == 0 && cell[2] == 49);
    p[0] = NAN;
    cell[1] = 5;
    CHECK(!vxs_voxmap_cell_of(map, p, cell));
    CHECK_INT(cell[1], 5);
    p[0] = 1e300;
    CHECK(!vxs_voxmap_cell_of(map, p, cell));
}

int main(void)
{
    int64_t low[3] = {-70, -3, 100}, high[3] = {61, 90, 140};
    built_asset asset = build_voxmap(0.0005, low, high, stripes, NULL, BUILT_LAYERS);
    vxs_voxmap map = open_voxmap(&asset);
    for (int axis = 0; axis < 3; axis++) {
        CHECK(map.origin_cell[axis] <= low[axis]);
        CHECK(map.origin_cell[axis] + (int64_t)map.cells[axis] > high[axis]);
    }
    for (int64_t i = low[0] - 70; i <= high[0] + 70; i += 1) {
        for (int64_t j = low[1] - 70; j <= high[1] + 70; j += 3) {
            for (int64_t k = low[2] - 70; k <= high[2] + 70; k += 2) {
                int inside =
                    i >= low[0] && i <= high[0] && j >= low[1] && j <= high[1] && k >= low[2] && k <= high[2];
                CHECK_INT(vxs_voxmap_state_at(&map, i, j, k),
                          inside ? stripes(NULL, i, j, k) : VXS_CELL_FREE);
            }
        }
    }
    CHECK_INT(vxs_voxmap_state_at(&map, INT64_MIN, INT64_MAX, 0), VXS_CELL_FREE);
    CHECK_INT(vxs_voxmap_state(&map, map.cells[0], 0, 0), VXS_CELL_FREE);
    CHECK_INT(vxs_voxmap_state(&map, UINT32_MAX, UINT32_MAX, UINT32_MAX), VXS_CELL_FREE);
    CHECK(map.layers != NULL && map.distances == NULL && map.layer_count == 2);
    check_cell_of(&map);
    CHECK_INT(vxs_voxmap_open(NULL, &map), VXS_PARAM);
    built_free(&asset);
    return 0;
}
