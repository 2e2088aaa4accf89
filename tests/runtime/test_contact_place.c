/* SPDX-License-Identifier: MIT
 *
 * Where and how large does not matter: the same contact at 1 um, 1 m and 1 km, and 10 km from the
 * origin, gives the same points and, scaled, the same wrench.
 */
#include "asset_builder.h"
#include "check.h"

static uint8_t memory[1 << 20] __attribute__((aligned(64)));

typedef struct slab {
    int64_t shift[3];
} slab;

static uint32_t slab_cell(const void *shape, int64_t i, int64_t j, int64_t k)
{
    const slab *s = shape;
    (void)i;
    (void)k;
    return j - s->shift[1] == 0 ? VXS_CELL_SURFACE : VXS_CELL_INTERIOR;
}

static vxs_contact_result touch(double h, const int64_t shift[3])
{
    slab shape = {{shift[0], shift[1], shift[2]}};
    int64_t low[3] = {shift[0] - 30, shift[1] - 10, shift[2] - 30},
            high[3] = {shift[0] + 30, shift[1], shift[2] + 30};
    built_asset map_bytes = build_voxmap(h, low, high, slab_cell, &shape, BUILT_PLAIN);
    built_asset bytes = build_ball_shell(h, 20 * h, 5000);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.stiffness = 1 / h;
    vxs_contact *contact;
    const vxs_contact_static statics = {&map, NULL};
    vxs_contact_result result;
    CHECK_INT(vxs_contact_init(memory, sizeof memory, &shell, 1, &contact), VXS_OK);
    vxs_pose pose = {
        {h * ((double)shift[0] + 0.31), h * ((double)shift[1] + 20.1), h * ((double)shift[2] - 0.27)},
        {0.9, 0.1, 0.2, -0.3}};
    vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &result);
    built_free(&map_bytes);
    built_free(&bytes);
    return result;
}

int main(void)
{
    const int64_t home[3] = {0, 0, 0};
    vxs_contact_result at_home = touch(0.001, home);
    CHECK(at_home.points > 20 && at_home.wrench.force[1] > 0.1);
    const double scales[] = {1e-6, 1, 1000};
    for (int n = 0; n < 3; n++) {
        vxs_contact_result r = touch(scales[n], home);
        CHECK_INT(r.points, at_home.points);
        CHECK_NEAR(r.wrench.force[1], at_home.wrench.force[1], 1e-4);
        CHECK_NEAR(r.wrench.torque[0] / scales[n], at_home.wrench.torque[0] / 0.001, 1e-3);
    }
    const int64_t away[3] = {10000000 / 64 * 64, -6400, 3200000}; /* 10 km in x */
    vxs_contact_result r = touch(0.001, away);
    CHECK_INT(r.points, at_home.points);
    CHECK_NEAR(r.wrench.force[1], at_home.wrench.force[1], 1e-6);
    CHECK_NEAR(r.depth, at_home.depth, 1e-9);
    return 0;
}
