/* SPDX-License-Identifier: MIT
 *
 * Contact against forces worked out by hand: floors, slots, balls.
 */
#include "asset_builder.h"
#include "check.h"

static const double h = 0.001;
static uint8_t memory[1 << 20] __attribute__((aligned(64)));

static vxs_contact_result evaluate(const vxs_voxmap *map, const vxs_pointshell *shell, const vxs_pose *pose,
                                   const vxs_contact_config *config)
{
    vxs_contact *contact;
    vxs_contact_result result;
    const vxs_contact_static statics = {map, NULL};
    CHECK_INT(vxs_contact_init(memory, sizeof memory, shell, 1, &contact), VXS_OK);
    CHECK_INT(vxs_contact_evaluate(contact, &statics, 1, pose, config, &result), result.flags);
    return result;
}

static vxs_contact_config config_of(uint32_t law, uint32_t weighting, double stiffness)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = law;
    config.weighting = weighting;
    config.stiffness = stiffness;
    CHECK_INT(vxs_contact_config_check(&config), VXS_OK);
    return config;
}

static vxs_pose at(double x, double y, double z)
{
    vxs_pose pose = vxs_pose_identity();
    pose.position[0] = x;
    pose.position[1] = y;
    pose.position[2] = z;
    return pose;
}

static void check_zero(const vxs_contact_result *result)
{
    for (int axis = 0; axis < 3; axis++) {
        CHECK(result->wrench.force[axis] == 0 && result->wrench.torque[axis] == 0);
    }
}

/* One point over a floor: d = c - p along +y, a point lever makes the torque. */
static void check_floor(void)
{
    built_floor shape = {0, 40, 20}; /* surface cells 0 <= y < h */
    built_point tip = {{0.01f, 0, 0.002f}, {0, 1, 0}, 1e-6f};
    built_asset map_bytes = build_floor_map(h, &shape, BUILT_PLAIN), tip_bytes = build_pointshell(h, &tip, 1);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&tip_bytes);
    const uint32_t laws[] = {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE};
    for (int n = 0; n < 2; n++) {
        vxs_contact_config config = config_of(laws[n], VXS_CONTACT_COUNT, 2000);
        vxs_pose pose = at(0, 0.0002, 0);
        vxs_contact_result r = evaluate(&map, &shell, &pose, &config);
        CHECK_INT(r.points, 1);
        CHECK_INT(r.flags, 0);
        CHECK_INT(r.patches, 1);
        CHECK_NEAR(r.depth, 0.0003, 1e-12);
        CHECK_NEAR(r.wrench.force[1], 0.6, 1e-9);
        CHECK(r.wrench.force[0] == 0 && r.wrench.force[2] == 0);
        CHECK_NEAR(r.wrench.torque[0], -(double)0.002f * r.wrench.force[1], 1e-12); /* lever x force */
        CHECK(r.wrench.torque[1] == 0);
        CHECK_NEAR(r.wrench.torque[2], (double)0.01f * r.wrench.force[1], 1e-12);
        CHECK_NEAR(r.normal[1], 1, 1e-15);
        config.reference[0] = 0.01f; /* about the point itself in x */
        r = evaluate(&map, &shell, &pose, &config);
        CHECK_NEAR(r.wrench.torque[2], 0, 1e-12);
        config.reference[0] = 0;

        pose = at(0, 0.0007, 0); /* above the cell's centre: in the cell, no force */
        r = evaluate(&map, &shell, &pose, &config);
        CHECK_INT(r.points, 1);
        CHECK(r.depth == 0);
        check_zero(&r);
        pose = at(0, 0.0011, 0); /* lifted */
        r = evaluate(&map, &shell, &pose, &config);
        CHECK_INT(r.points, 0);
        CHECK_INT(r.flags, 0);
        CHECK_INT(r.patches, 0);
        check_zero(&r);
        pose = at(0, -0.0051, 0); /* through the layer */
        r = evaluate(&map, &shell, &pose, &config);
        CHECK_INT(r.flags, VXS_CONTACT_DEEP);
        CHECK_INT(r.deep_points, 1);
        check_zero(&r);
        pose = at(0, 1, 0); /* far away */
        r = evaluate(&map, &shell, &pose, &config);
        CHECK_INT(r.flags, VXS_CONTACT_OUT_OF_MAP);
        pose = at(1e300, -1e300, 1e305);
        r = evaluate(&map, &shell, &pose, &config);
        CHECK_INT(r.points, 0);
        check_zero(&r);
    }
    built_free(&map_bytes);
    built_free(&tip_bytes);
}

/* The same contact with map and shell turned together about z: the wrench turns along. */
static void check_map_pose(void)
{
    built_floor shape = {0, 40, 20};
    built_point tip = {{0.01f, 0, 0.002f}, {0, 1, 0}, 1e-6f};
    built_asset map_bytes = build_floor_map(h, &shape, BUILT_PLAIN), tip_bytes = build_pointshell(h, &tip, 1);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&tip_bytes);
    vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_COUNT, 2000);
    vxs_pose turn = {{0.5, -2, 0.1}, {1, 0, 0, 1}}, local = at(0.0002, 0.0002, 0), pose;
    CHECK(vxs_pose_compose(&turn, &local, &pose));
    vxs_contact *contact;
    vxs_contact_result r;
    vxs_contact_static statics = {&map, &turn};
    CHECK_INT(vxs_contact_init(memory, sizeof memory, &shell, 1, &contact), VXS_OK);
    CHECK_INT(vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &r), 0);
    CHECK_INT(r.points, 1);
    CHECK_NEAR(r.wrench.force[0], -0.6, 1e-9); /* +y turned to -x */
    CHECK_NEAR(r.wrench.force[1], 0, 1e-12);
    CHECK_NEAR(r.normal[0], -1, 1e-12);
    CHECK_NEAR(r.wrench.torque[1], -0.002 * 0.6, 1e-8); /* -x turned to -y */
    CHECK_NEAR(r.wrench.torque[2], 0.01 * 0.6, 1e-8);
    vxs_pose bad = {{0, 0, 0}, {0, 0, 0, 0}};
    statics.pose = &bad;
    CHECK_INT(vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &r), VXS_CONTACT_INVALID);
    check_zero(&r);
    built_free(&map_bytes);
    built_free(&tip_bytes);
}

/* k x count x depth, shared from ten points on, or by area. */
static void check_weighting(void)
{
    enum { POINTS = 24 };
    built_floor shape = {0, 40, 20};
    built_point points[POINTS];
    for (int n = 0; n < POINTS; n++)
        points[n] = (built_point){{(float)(0.001 * n), 0, 0}, {0, 1, 0}, (float)(1e-6 * (1 + n % 3))};
    built_asset map_bytes = build_floor_map(h, &shape, BUILT_PLAIN);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pose pose = at(0, 0.00025, 0);
    for (uint32_t count = 9; count <= POINTS; count += 1) {
        built_asset bytes = build_pointshell(h, points, count);
        vxs_pointshell shell = open_pointshell(&bytes);
        vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_COUNT, 1000);
        vxs_contact_result r = evaluate(&map, &shell, &pose, &config);
        CHECK_NEAR(r.wrench.force[1], 0.25 * count, 1e-9);
        double torque = r.wrench.torque[2], force = r.wrench.force[1];
        config = config_of(VXS_CONTACT_ORIGINAL, VXS_CONTACT_COUNT_CAPPED, 1000);
        r = evaluate(&map, &shell, &pose, &config);
        double share = count <= 10 ? 1 : 10.0 / count;
        CHECK_NEAR(r.wrench.force[1], force * share, 1e-12);
        CHECK_NEAR(r.wrench.torque[2], torque * share, 1e-12);
        config = config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_AREA, 1e9);
        r = evaluate(&map, &shell, &pose, &config);
        double area = 0;
        for (uint32_t n = 0; n < count; n++) area += (double)points[n].area;
        CHECK_NEAR(r.wrench.force[1], 1e9 * area * 0.00025, 1e-6);
        built_free(&bytes);
    }
    built_free(&map_bytes);
}

/* Tilted normals on a floor: the original law leaks sideways, the average does not. */
static void check_average(void)
{
    built_floor shape = {0, 40, 20};
    const float s = 0.6f, c = 0.8f;
    built_point points[2] = {{{-0.005f, 0, 0}, {s, c, 0}, 1e-6f}, {{0.005f, 0.0001f, 0}, {-s, c, 0}, 1e-6f}};
    built_asset map_bytes = build_floor_map(h, &shape, BUILT_PLAIN), bytes = build_pointshell(h, points, 2);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_pose pose = at(0.0005, 0.0002, 0.0005); /* in x and z at the cells' centres */
    vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_COUNT, 1000);
    vxs_contact_result r = evaluate(&map, &shell, &pose, &config);
    CHECK_NEAR(r.wrench.force[0], 0, 1e-9);
    CHECK_NEAR(r.wrench.force[1], 0.3 + 0.2, 1e-7);
    CHECK_NEAR(r.depth, 0.0003, 1e-9);
    CHECK_NEAR(r.wrench.torque[2], -0.005 * 0.3 + 0.005 * 0.2, 1e-9);
    config.law = VXS_CONTACT_ORIGINAL;
    r = evaluate(&map, &shell, &pose, &config);
    /* d = 0.8 x 0.3 and 0.8 x 0.2 mm along each point's own normal */
    CHECK_NEAR(r.wrench.force[0], 0.6 * 0.8 * (0.3 - 0.2), 1e-7);
    CHECK_NEAR(r.wrench.force[1], 0.8 * 0.8 * (0.3 + 0.2), 1e-7);
    built_free(&map_bytes);
    built_free(&bytes);
}

/* A tongue in a slot: opposed normals cancel, and each side keeps its force. */
static void check_patches(void)
{
    built_slot slot = {-3, 2, 20}; /* surface cells at -3h .. -2h and 2h .. 3h */
    built_point points[6];
    for (int n = 0; n < 6; n++) {
        int above = n % 2;
        points[n] = (built_point){{0.0005f + 0.001f * (float)n, 0.0005f, above ? 0.0023f : -0.0021f},
                                  {0, 0, above ? -1.0f : 1.0f},
                                  1e-6f};
    }
    built_asset map_bytes = build_slot_map(h, &slot), bytes = build_pointshell(h, points, 6);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_pose pose = at(0, 0, 0);
    vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_COUNT, 1000);
    vxs_contact_result r = evaluate(&map, &shell, &pose, &config);
    CHECK_INT(r.points, 6);
    CHECK(r.flags & VXS_CONTACT_MEAN_CANCELLED);
    CHECK_INT(r.patches, 2);
    CHECK_NEAR(r.normal[2], 0, 0);
    /* above: d = (2.5 - 2.3) (-1) < 0: none. below: d = -2.5 + 2.1 < 0: none. So press into the walls. */
    check_zero(&r);
    for (int n = 0; n < 6; n++) points[n].position[2] = n % 2 ? 0.0028f : -0.0026f;
    built_free(&bytes);
    bytes = build_pointshell(h, points, 6);
    shell = open_pointshell(&bytes);
    r = evaluate(&map, &shell, &pose, &config);
    CHECK_INT(r.patches, 2);
    CHECK_NEAR(r.wrench.force[2], 3 * (0.1 - 0.3), 1e-6);
    CHECK_NEAR(r.depth, 0.0003, 1e-9);
    double original = 0;
    config.law = VXS_CONTACT_ORIGINAL;
    original = evaluate(&map, &shell, &pose, &config).wrench.force[2];
    CHECK_NEAR(r.wrench.force[2], original, 1e-12);
    built_free(&bytes);

    /* More directions than patches: nothing is dropped, each point still pushes. */
    enum { RAYS = 40 };
    built_point rays[RAYS];
    for (int n = 0; n < RAYS; n++) {
        double turn = 2 * acos(-1) * n / RAYS;
        rays[n] = (built_point){
            {0.0005f, 0.0005f, n % 2 ? 0.0028f : -0.0026f}, {(float)cos(turn), 0, (float)sin(turn)}, 1e-6f};
    }
    bytes = build_pointshell(h, rays, RAYS);
    shell = open_pointshell(&bytes);
    config.law = VXS_CONTACT_AVERAGE;
    r = evaluate(&map, &shell, &pose, &config);
    CHECK_INT(r.points, RAYS);
    CHECK(r.patches >= 3 && r.patches <= 14);
    CHECK(r.depth > 0);
    built_free(&bytes);
    built_free(&map_bytes);
}

/* A ball that sinks into a floor: symmetric about y, torque free, no matter how it is turned. */
static void check_ball(void)
{
    built_floor shape = {-1, 60, 20}; /* surface -h .. 0 */
    built_asset map_bytes = build_floor_map(h, &shape, BUILT_PLAIN), bytes = build_ball_shell(h, 0.02, 20000);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_AREA, 1e9);
    for (int n = 0; n < 12; n++) {
        vxs_pose pose = at(0.0013 * n, 0.02 - 0.00099, -0.0007 * n);
        pose.orientation[0] = 1;
        pose.orientation[1] = 0.3 * n;
        pose.orientation[2] = -0.17 * n;
        vxs_contact_result r = evaluate(&map, &shell, &pose, &config);
        double f = r.wrench.force[1];
        CHECK(f > 0);
        CHECK(fabs(r.wrench.force[0]) < 0.03 * f && fabs(r.wrench.force[2]) < 0.03 * f);
        /* The cap below y = -h/2: k times the volume of the sphere cut off there, 2 pi r (s^2 / 2). */
        double s = 0.00099 - 0.0005, expected = 1e9 * acos(-1) * 0.02 * s * s;
        CHECK_NEAR(f, expected, 0.05 * expected);
        CHECK(fabs(r.wrench.torque[1]) < 0.02 * 0.02 * f);
        CHECK_INT(r.flags, 0);
    }
    built_free(&map_bytes);
    built_free(&bytes);
}

static void check_bad_input(void)
{
    built_ball ball = {0.001, {0, 0, 0}, 0.01};
    built_asset map_bytes = build_ball_map(&ball, BUILT_PLAIN), bytes = build_ball_shell(h, 0.01, 500);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_COUNT, 1000);
    const vxs_pose bad[] = {
        {{NAN, 0, 0}, {1, 0, 0, 0}}, {{0, 0, 0}, {0, 0, 0, 0}}, {{0, 0, 0}, {1, NAN, 0, 0}}};
    for (int n = 0; n < 3; n++) {
        vxs_contact_result r = evaluate(&map, &shell, &bad[n], &config);
        CHECK_INT(r.flags, VXS_CONTACT_INVALID);
        check_zero(&r);
    }
    vxs_pose pose = at(0.005, 0, 0);
    const vxs_contact_result whole = evaluate(&map, &shell, &pose, &config);
    CHECK(whole.points > 30 && whole.wrench.force[0] > 0);
    CHECK(whole.flags & VXS_CONTACT_DEEP);

    /* More hits than points, since the statics overlap: told, never silent. */
    vxs_contact *contact;
    vxs_contact_result r;
    enum { STATICS = 200 };
    vxs_contact_static statics[STATICS];
    for (int n = 0; n < STATICS; n++) statics[n] = (vxs_contact_static){&map, NULL};
    CHECK_INT(vxs_contact_init(memory, sizeof memory, &shell, STATICS, &contact), VXS_OK);
    vxs_contact_evaluate(contact, statics, STATICS, &pose, &config, &r);
    CHECK(r.flags & VXS_CONTACT_OVERFLOW);
    CHECK_INT(r.points, shell.point_count);
    CHECK_INT(vxs_contact_init(memory, vxs_contact_memory(&shell, 2) - 1, &shell, 2, &contact), VXS_BUFFER);
    CHECK_INT(vxs_contact_init(memory + 1, sizeof memory - 1, &shell, 1, &contact), VXS_BUFFER);
    CHECK_INT(vxs_contact_init(NULL, 0, &shell, 1, &contact), VXS_PARAM);
    CHECK_INT(vxs_contact_init(memory, sizeof memory, &shell, 0, &contact), VXS_PARAM);
    CHECK_INT(vxs_contact_init(memory, sizeof memory, &shell, VXS_CONTACT_MAX_STATICS + 1, &contact),
              VXS_PARAM);

    vxs_contact_config odd = config;
    odd.struct_size--;
    CHECK_INT(vxs_contact_config_check(&odd), VXS_CONFIG);
    odd = config;
    odd.law = 7;
    CHECK_INT(vxs_contact_config_check(&odd), VXS_PARAM);
    odd = config;
    odd.stiffness = -1;
    CHECK_INT(vxs_contact_config_check(&odd), VXS_PARAM);
    r = evaluate(&map, &shell, &pose, &odd);
    CHECK_INT(r.flags, VXS_CONTACT_INVALID);
    check_zero(&r);
    odd.stiffness = 1e308; /* overflows in the sum */
    r = evaluate(&map, &shell, &pose, &odd);
    CHECK(r.flags & VXS_CONTACT_INVALID || isfinite(r.wrench.force[0]));

    /* The same to the last bit, with the quaternion scaled or negated by a power of two. */
    vxs_pose scaled = pose;
    for (int n = 0; n < 4; n++) scaled.orientation[n] *= -4;
    r = evaluate(&map, &shell, &scaled, &config);
    CHECK(memcmp(&r, &whole, sizeof r) == 0);
    built_free(&map_bytes);
    built_free(&bytes);
}

int main(void)
{
    check_floor();
    check_map_pose();
    check_weighting();
    check_average();
    check_patches();
    check_ball();
    check_bad_input();
    return 0;
}
