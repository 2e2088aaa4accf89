/* SPDX-License-Identifier: MIT
 *
 * Who presses how (contact.h, vxs_contact_loads): of a block on a floor by hand, and for every law and field
 * in all poses the sum of what the wrench is, which the asking does not change.
 */
#include "asset_builder.h"
#include "check.h"

static const double h = 0.001;
static uint8_t memory[1 << 22] __attribute__((aligned(64)));

static double floor_distance(const void *shape, const double p[3])
{
    (void)shape;
    return p[1] - 0.3 * h;
}

/* A slot at a slant, open above: opposed walls and a floor. */
static double slot_distance(const void *shape, const double p[3])
{
    (void)shape;
    const double x = 0.96 * p[0] + 0.28 * p[2];
    return fmin(p[1], 0.0102 - fabs(x));
}

static double dot(const double a[3], const double b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

static vxs_contact_config config_of(uint32_t law, uint32_t field)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    CHECK(!config.loads);
    config.law = law;
    config.field = field;
    config.weighting = VXS_CONTACT_AREA;
    config.stiffness = 1e8;
    return config;
}

static vxs_contact *contact_of(const vxs_pointshell *shell, uint32_t statics)
{
    vxs_contact *contact;
    CHECK_INT(vxs_contact_init(memory, sizeof memory, shell, statics, &contact), VXS_OK);
    return contact;
}

static void check_block(void)
{
    const int64_t low[3] = {-40, -8, -40}, high[3] = {40, 2, 40};
    const double half[3] = {0.01, 0.01, 0.01};
    const int count[3] = {40, 40, 40};
    built_asset map_bytes = build_field_map(h, low, high, floor_distance, NULL, 3),
                bytes = build_block_shell(h, half, count);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact = contact_of(&shell, 2);
    vxs_contact_loads loads;
    vxs_contact_result result;
    vxs_contact_config config = config_of(VXS_CONTACT_PATCH, VXS_CONTACT_DISTANCE);
    config.loads = &loads;
    config.reference[0] = 0.004;
    const vxs_pose raised = {{0, 1, 0}, {1, 0, 0, 0}};
    vxs_contact_static statics[2] = {{&map, &raised}, {&map, NULL}};
    const double angle = 0.3; /* about the normal */
    vxs_pose pose = {{0.002, 0.0102, 0.001}, {cos(angle / 2), 0, sin(angle / 2), 0}};
    vxs_contact_evaluate(contact, statics, 2, &pose, &config, &result);
    CHECK_INT(loads.count, 1);
    const vxs_contact_load *load = loads.load;
    CHECK_INT(load->at, 1);
    const double force = 1e8 * 0.02 * 0.02 * 1e-4; /* 0.1 mm deep */
    CHECK_NEAR(load->force, force, 1e-3 * force);
    CHECK_NEAR(load->force, result.wrench.force[1], 1e-6 * force);
    CHECK_NEAR(load->normal[1], 1, 1e-6);
    CHECK_NEAR(load->arm[0], -0.004 * cos(angle), 1e-6);
    CHECK_NEAR(load->arm[1], -0.01, 1e-6);
    CHECK_NEAR(load->arm[2], 0.004 * sin(angle), 1e-6);
    /* The mean distance from the centre of a square of edge a: a (sqrt 2 + asinh 1) / 6. */
    CHECK_NEAR(load->radius, 0.02 * (sqrt(2) + log(1 + sqrt(2))) / 6, 2e-5);
    pose.position[1] = 0.02; /* lifted */
    vxs_contact_evaluate(contact, statics, 2, &pose, &config, &result);
    CHECK_INT(loads.count, 0);
    pose.position[1] = NAN;
    loads.count = 7;
    vxs_contact_evaluate(contact, statics, 2, &pose, &config, &result);
    CHECK_INT(loads.count, 0);
    built_free(&map_bytes);
    built_free(&bytes);
}

static void check_sums(void)
{
    const int64_t low[3] = {-30, -4, -30}, high[3] = {30, 20, 30};
    built_asset map_bytes = build_field_map(h, low, high, slot_distance, NULL, 3),
                bytes = build_ball_shell(h, 0.0104, 4000);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact = contact_of(&shell, 1);
    const vxs_contact_static statics = {&map, NULL};
    vxs_contact_loads loads;
    double worst = 0;
    uint32_t most = 0;
    for (uint32_t law = VXS_CONTACT_ORIGINAL; law <= VXS_CONTACT_PATCH; law++) {
        for (uint32_t field = VXS_CONTACT_SURFACE; field <= VXS_CONTACT_DISTANCE; field++) {
            for (int bound = 0; bound < 2; bound++) {
                vxs_contact_config config = config_of(law, field), asking;
                if (vxs_contact_config_check(&config) != VXS_OK) continue;
                config.most_stiffness = bound ? 2000 : 0;
                asking = config;
                asking.loads = &loads;
                for (int n = 0; n < 40; n++) {
                    vxs_contact_result plain, asked;
                    vxs_pose pose = {{2e-5 * n, 0.0105 - 1e-5 * n, 0.001}, {1, 0.02 * n, 0.3, 0}};
                    vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &plain);
                    vxs_contact_evaluate(contact, &statics, 1, &pose, &asking, &asked);
                    CHECK(memcmp(&plain, &asked, sizeof plain) == 0);
                    double sum[3] = {0, 0, 0}, force = 0;
                    for (uint32_t m = 0; m < loads.count; m++) {
                        const vxs_contact_load *load = &loads.load[m];
                        CHECK(load->force > 0 && load->radius >= 0 && load->radius < 0.011);
                        CHECK_NEAR(dot(load->normal, load->normal), 1, 1e-12);
                        CHECK(m == 0 || load->direction > load[-1].direction);
                        CHECK(dot(load->arm, load->arm) < 0.0105 * 0.0105);
                        for (int i = 0; i < 3; i++) sum[i] += load->force * load->normal[i];
                        force += load->force;
                    }
                    CHECK((loads.count > 0) == (plain.depth > 0));
                    most = loads.count > most ? loads.count : most;
                    double off = 0;
                    for (int i = 0; i < 3; i++) off += fabs(sum[i] - plain.wrench.force[i]);
                    if (force > 0) worst = fmax(worst, off / force);
                }
            }
        }
    }
    printf("loads: up to %u, their sum within %.2g of the force\n", most, worst);
    CHECK(most > 10);
    CHECK(worst < 0.02); /* normals of one direction are summed to one */
    built_free(&map_bytes);
    built_free(&bytes);
}

int main(void)
{
    check_block();
    check_sums();
    return 0;
}
