/* SPDX-License-Identifier: MIT
 *
 * Every law with every field against forces worked out by hand: walls, a slot, a groove, two distant
 * contacts. And what does not go together is refused by name.
 */
#include "asset_builder.h"
#include "check.h"

static const double h = 0.001, pi = 3.14159265358979323846;
static uint8_t memory[1 << 22] __attribute__((aligned(64)));

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double length(const double v[3])
{
    return sqrt(dot(v, v));
}

static vxs_contact_config config_of(uint32_t law, uint32_t field, double stiffness)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = law;
    config.field = field;
    config.weighting = VXS_CONTACT_AREA;
    config.stiffness = stiffness;
    return config;
}

static vxs_contact *contact_of(const vxs_pointshell *shell)
{
    vxs_contact *contact;
    CHECK_INT(vxs_contact_init(memory, sizeof memory, shell, 1, &contact), VXS_OK);
    return contact;
}

static vxs_contact_result evaluate(vxs_contact *contact, const vxs_voxmap *map, const vxs_pose *pose,
                                   const vxs_contact_config *config)
{
    vxs_contact_result result;
    const vxs_contact_static statics = {map, NULL};
    vxs_contact_evaluate(contact, &statics, 1, pose, config, &result);
    CHECK(!(result.flags & VXS_CONTACT_INVALID));
    return result;
}

/* Planes whose solid sides are joined: distance to a wedge, a slot or one wall. Exact but near where they
 * meet. */
typedef struct walls {
    int count;
    double normal[3][3], offset[3]; /* unit, outwards; n . p > offset is free of this wall */
} walls;

static double walls_distance(const void *shape, const double p[3])
{
    const walls *w = shape;
    double least = INFINITY;
    for (int n = 0; n < w->count; n++) least = fmin(least, dot(w->normal[n], p) - w->offset[n]);
    return least;
}

static built_asset walls_map(const walls *w, double voxel)
{
    const int64_t reach = (int64_t)(0.028 / voxel), low[3] = {-reach, -reach, -reach},
                  high[3] = {reach, reach, reach};
    return build_field_map(voxel, low, high, walls_distance, w, 3);
}

/* A square plate of count x count points in its plane, normal inwards, each with its share of the area. */
static void add_plate(built_point *points, uint32_t *count, const double center[3], const double normal[3],
                      double side, int each)
{
    const double other[3] = {fabs(normal[0]) < 0.6, fabs(normal[0]) >= 0.6, 0};
    double u[3], v[3];
    for (int i = 0; i < 3; i++) u[i] = other[i] - dot(other, normal) * normal[i];
    const double scale = length(u);
    for (int i = 0; i < 3; i++) u[i] /= scale;
    for (int i = 0; i < 3; i++)
        v[i] = normal[(i + 1) % 3] * u[(i + 2) % 3] - normal[(i + 2) % 3] * u[(i + 1) % 3];
    for (int n = 0; n < each * each; n++) {
        const double a = side * ((n / each + 0.5) / each - 0.5), b = side * ((n % each + 0.5) / each - 0.5);
        built_point *point = &points[(*count)++];
        for (int i = 0; i < 3; i++) {
            point->position[i] = (float)(center[i] + a * u[i] + b * v[i]);
            point->normal[i] = (float)normal[i];
        }
        point->area = (float)(side * side / each / each);
    }
}

static void check_refusals(void)
{
    static const uint32_t laws[] = {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE, VXS_CONTACT_GRADIENT,
                                    VXS_CONTACT_PATCH};
    for (uint32_t n = 0; n < 4; n++) {
        for (uint32_t field = VXS_CONTACT_SURFACE; field <= VXS_CONTACT_DISTANCE; field++) {
            const vxs_contact_config config = config_of(laws[n], field, 1);
            const int fits = laws[n] != VXS_CONTACT_GRADIENT || field == VXS_CONTACT_DISTANCE;
            CHECK_INT(vxs_contact_config_check(&config), fits ? VXS_OK : VXS_LAW_FIELD);
        }
    }
    vxs_contact_config config = config_of(VXS_CONTACT_PATCH + 1, VXS_CONTACT_SURFACE, 1);
    CHECK_INT(vxs_contact_config_check(&config), VXS_PARAM);
    config = config_of(VXS_CONTACT_PATCH, VXS_CONTACT_DISTANCE + 1, 1);
    CHECK_INT(vxs_contact_config_check(&config), VXS_PARAM);
    config = config_of(VXS_CONTACT_PATCH, VXS_CONTACT_SURFACE, 1);
    config.most_stiffness = -1;
    CHECK_INT(vxs_contact_config_check(&config), VXS_PARAM);
    config.most_stiffness = NAN;
    CHECK_INT(vxs_contact_config_check(&config), VXS_PARAM);

    /* A map without the channel, at the evaluation and at the servo's set-up. */
    const built_ball ball = {h, {0, 0, 0}, 0.01};
    built_asset map_bytes = build_ball_map(&ball, BUILT_PLAIN), bytes = build_ball_shell(h, 0.01, 500);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact = contact_of(&shell);
    const vxs_contact_static statics = {&map, NULL};
    const vxs_pose pose = {{0.019, 0, 0}, {1, 0, 0, 0}};
    for (uint32_t field = VXS_CONTACT_SURFACE; field <= VXS_CONTACT_DISTANCE; field++) {
        vxs_contact_result r;
        config = config_of(VXS_CONTACT_PATCH, field, 1);
        CHECK_INT(vxs_contact_has_field(&map, field), field == VXS_CONTACT_SURFACE);
        vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &r);
        CHECK_INT(!!(r.flags & VXS_CONTACT_INVALID), field != VXS_CONTACT_SURFACE);
        vxs_servo_config servo;
        vxs_servo_config_default(&servo);
        servo.statics = &statics;
        servo.static_count = 1;
        servo.shell = &shell;
        servo.contact = config;
        CHECK_INT(vxs_servo_config_check(&servo), field == VXS_CONTACT_SURFACE ? VXS_OK : VXS_CHANNEL);
    }
    built_free(&map_bytes);
    built_free(&bytes);
}

/* A shell without areas: weighed by count as any, refused where areas weigh. */
static void check_no_area(void)
{
    const built_ball ball = {h, {0, 0, 0}, 0.01};
    built_asset map_bytes = build_ball_map(&ball, BUILT_PLAIN), bytes = build_ball_shell(h, 0.01, 500);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes), bare = shell;
    bare.area = NULL;
    vxs_contact *with = contact_of(&shell), *without;
    const size_t own = vxs_contact_memory(&bare, 1);
    void *own_memory = aligned_alloc(64, (own + 63) / 64 * 64);
    CHECK(own_memory);
    CHECK_INT(vxs_contact_init(own_memory, own, &bare, 1, &without), VXS_OK);
    const vxs_contact_static statics = {&map, NULL};
    const vxs_pose pose = {{0.019, 0, 0}, {1, 0, 0, 0}};
    for (uint32_t weighting = VXS_CONTACT_COUNT; weighting <= VXS_CONTACT_AREA; weighting++) {
        vxs_contact_config config = config_of(VXS_CONTACT_PATCH, VXS_CONTACT_SURFACE, 1);
        config.weighting = weighting;
        vxs_contact_result r, expected;
        vxs_contact_evaluate(with, &statics, 1, &pose, &config, &expected);
        vxs_contact_evaluate(without, &statics, 1, &pose, &config, &r);
        CHECK(expected.points > 0 && !(expected.flags & VXS_CONTACT_INVALID));
        if (weighting == VXS_CONTACT_AREA) {
            CHECK_INT(r.flags, VXS_CONTACT_INVALID);
            CHECK(r.points == 0 && r.wrench.force[0] == 0);
        } else {
            CHECK(memcmp(&r, &expected, sizeof r) == 0);
        }
        vxs_servo_config servo;
        vxs_servo_config_default(&servo);
        servo.statics = &statics;
        servo.static_count = 1;
        servo.shell = &bare;
        servo.contact = config;
        CHECK_INT(vxs_servo_config_check(&servo), weighting == VXS_CONTACT_AREA ? VXS_NO_AREA : VXS_OK);
    }
    const size_t size = vxs_contact_levels_memory(&bare);
    void *room = aligned_alloc(64, (size + 63) / 64 * 64);
    CHECK(room);
    CHECK_INT(vxs_contact_add_levels(without, room, size), VXS_NO_AREA);
    CHECK(vxs_contact_point_cost(without) > 0);
    free(room);
    free(own_memory);
    built_free(&map_bytes);
    built_free(&bytes);
}

/* A plate of which every point sinks into a wall, deeper and deeper: the force is k A d, along the wall's
 * normal. */
static void check_depth(const double direction[3])
{
    walls wall = {.count = 1, .offset = {0.00013}};
    const double size = length(direction);
    for (int i = 0; i < 3; i++) wall.normal[0][i] = direction[i] / size;
    const double *n = wall.normal[0], rings = fabs(n[0]) + fabs(n[1]) + fabs(n[2]);
    static built_point points[1600];
    uint32_t count = 0;
    add_plate(points, &count, (const double[3]){0, 0, 0}, n, 0.012, (int)check_length(40, 24));
    built_asset map_bytes = walls_map(&wall, h), bytes = build_pointshell(h, points, count);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact = contact_of(&shell);
    static const uint32_t laws[] = {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE, VXS_CONTACT_PATCH,
                                    VXS_CONTACT_GRADIENT};
    for (int law = 0; law < 4; law++) {
        for (uint32_t field = VXS_CONTACT_LAYERS; field <= VXS_CONTACT_DISTANCE; field++) {
            if (laws[law] == VXS_CONTACT_GRADIENT && field == VXS_CONTACT_LAYERS) continue;
            const vxs_contact_config config = config_of(laws[law], field, 1e9);
            const double unit = 1e9 * 0.012 * 0.012;
            double last = 0, worst = 0, back = 0, jump = 0;
            for (int step = 0; step <= 550; step++) {
                const double depth = 1e-5 * step - 0.0004; /* to 5.1 mm: beyond either channel */
                vxs_pose pose = vxs_pose_identity();
                for (int i = 0; i < 3; i++)
                    pose.position[i] = (wall.offset[0] - depth) * n[i] + 1.3e-6 * step * (i == 0);
                const double true_depth = wall.offset[0] - dot(pose.position, n);
                const vxs_contact_result r = evaluate(contact, &map, &pose, &config);
                const double force = dot(r.wrench.force, n) / unit; /* [m] */
                for (int i = 0; i < 3 && (laws[law] != VXS_CONTACT_GRADIENT || true_depth < 1.2 * h); i++)
                    CHECK_NEAR(r.wrench.force[i], unit * force * n[i], 1e-4 * unit * fabs(force) + 1e-12);
                back = fmax(back, last - force);
                if (step > 0) jump = fmax(jump, force - last);
                last = force;
                if (field == VXS_CONTACT_DISTANCE) {
                    /* Cells that are clamped to the band of 3 h bend the field up to their diagonal before
                     * it. */
                    const double expected = fmax(0, fmin(true_depth, 3 * h)), near = 3 * h - 1.8 * h;
                    if (true_depth < near) worst = fmax(worst, fabs(force - expected));
                    if (laws[law] != VXS_CONTACT_GRADIENT && true_depth > 3 * h + 1.8 * h) {
                        CHECK_NEAR(force, 3 * h, 1e-6 * h);
                        CHECK_INT(r.deep_points, count);
                        CHECK(r.flags & VXS_CONTACT_DEEP);
                    }
                    if (true_depth < 0) CHECK(force == 0 && r.points == 0 && r.patches == 0);
                } else {
                    /* Rings start in the middle of the surface cells, whose middle is anywhere within half a
                     * ring. */
                    worst = fmax(
                        worst, true_depth > 0 && true_depth < 2.5 * h * rings ? fabs(force - true_depth) : 0);
                    if (true_depth > 4.6 * h * rings) {
                        CHECK(force > 3.9 * h * rings);
                        CHECK(r.deep_points == count);
                    }
                }
            }
            printf("wall (%.2f %.2f %.2f) law %u field %u: off by %.4f h, back by %.4f h, step %.4f h\n",
                   n[0], n[1], n[2], (unsigned)laws[law], (unsigned)field, worst / h, back / h, jump / h);
            CHECK(worst < (field == VXS_CONTACT_DISTANCE ? 0.001 : 0.6 * rings) * h);
            if (laws[law] != VXS_CONTACT_GRADIENT) {
                CHECK(back < (field == VXS_CONTACT_DISTANCE ? 1e-9 : 0.02) * h);
                CHECK(jump < (field == VXS_CONTACT_DISTANCE ? 0.012 : 0.05) * h); /* a step is 0.01 h */
            }
        }
    }
    built_free(&map_bytes);
    built_free(&bytes);
}

/* A ball on a wall, small enough a contact that all normals belong together: `patch` is `average` to the last
 * bit. */
static void check_one_patch(void)
{
    const walls wall = {.count = 1, .normal = {{0.36, 0.8, 0.48}}};
    built_asset map_bytes = walls_map(&wall, h), bytes = build_ball_shell(h, 0.1, 50000);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact = contact_of(&shell);
    for (uint32_t field = VXS_CONTACT_SURFACE; field <= VXS_CONTACT_DISTANCE; field++) {
        int touched = 0;
        for (int n = 0; n < 20; n++) {
            vxs_pose pose = {{0, 0, 0}, {1, 0.3 * n, -0.2 * n, 0.05}};
            for (int i = 0; i < 3; i++) pose.position[i] = wall.normal[0][i] * (0.1 - 0.0003 - 1e-5 * n);
            vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, field, 1e9);
            const vxs_contact_result average = evaluate(contact, &map, &pose, &config);
            config.law = VXS_CONTACT_PATCH;
            const vxs_contact_result patch = evaluate(contact, &map, &pose, &config);
            if (patch.patches > 1) continue;
            touched += patch.points > 0;
            CHECK(memcmp(&average, &patch, sizeof patch) == 0);
        }
        printf("one patch: field %u, %d of 20 poses\n", (unsigned)field, touched);
        CHECK(touched >= (field == VXS_CONTACT_SURFACE ? 10 : 15));
    }
    built_free(&map_bytes);
    built_free(&bytes);
}

/* Plates that lie against walls: each pushes along its own wall's normal, with its own lever. */
static void check_plates(const char *name, const walls *w, const double centers[][3], const double depths[])
{
    static built_point points[4 * 400];
    uint32_t count = 0;
    const double side = 0.004, k = 1e9;
    double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0}, gross = 0, arm = 0;
    for (int n = 0; n < w->count; n++) {
        double center[3];
        const double move = w->offset[n] - depths[n] - dot(centers[n], w->normal[n]);
        for (int i = 0; i < 3; i++) center[i] = centers[n][i] + move * w->normal[n][i];
        add_plate(points, &count, center, w->normal[n], side, 20);
        const double size = k * side * side * depths[n];
        gross += size;
        arm = fmax(arm, length(center));
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, l = (i + 2) % 3;
            force[i] += size * w->normal[n][i];
            torque[i] += size * (center[j] * w->normal[n][l] - center[l] * w->normal[n][j]);
        }
    }
    built_asset map_bytes = walls_map(w, h / 2), bytes = build_pointshell(h / 2, points, count);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact = contact_of(&shell);
    static const uint32_t laws[] = {VXS_CONTACT_PATCH, VXS_CONTACT_AVERAGE, VXS_CONTACT_ORIGINAL,
                                    VXS_CONTACT_GRADIENT};
    for (int law = 0; law < 4; law++) {
        const vxs_contact_config config = config_of(laws[law], VXS_CONTACT_DISTANCE, k);
        const vxs_pose pose = vxs_pose_identity();
        const vxs_contact_result r = evaluate(contact, &map, &pose, &config);
        double off[3], bend[3];
        for (int i = 0; i < 3; i++) {
            off[i] = r.wrench.force[i] - force[i];
            bend[i] = r.wrench.torque[i] - torque[i];
        }
        printf("%-14s law %u: force off by %6.2f %%, torque by %6.2f %% of what pushes, %u patches\n", name,
               (unsigned)laws[law], 100 * length(off) / gross, 100 * length(bend) / gross / arm,
               (unsigned)r.patches);
        if (laws[law] == VXS_CONTACT_AVERAGE) continue;
        CHECK(length(off) < 0.005 * gross);
        CHECK(length(bend) < 0.005 * gross * arm);
        if (laws[law] == VXS_CONTACT_PATCH) CHECK_INT(r.patches, w->count);
    }
    built_free(&map_bytes);
    built_free(&bytes);
}

int main(void)
{
    check_refusals();
    check_no_area();
    if (check_length(1, 0)) {
        check_depth((const double[3]){0, 1, 0});
        check_depth((const double[3]){0.3, 1, -0.2});
    }
    check_depth((const double[3]){1, 1, 1});
    check_one_patch();

    const walls slot = {.count = 2, .normal = {{0, 0, 1}, {0, 0, -1}}, .offset = {-0.008, -0.008}};
    check_plates("slot", &slot, (const double[][3]){{0.006, 0.002, 0}, {-0.005, -0.003, 0}},
                 (const double[]){2e-4, 5e-4});
    const double c = cos(pi / 3), s = sin(pi / 3); /* walls of a groove of 60 degrees are steep */
    const walls groove = {.count = 2, .normal = {{s, c, 0}, {-s, c, 0}}, .offset = {-0.009, -0.009}};
    check_plates("groove", &groove, (const double[][3]){{-0.004, 0.004, 0.003}, {0.004, 0.004, -0.003}},
                 (const double[]){4e-4, 3e-4});
    const walls corner = {.count = 3,
                          .normal = {{0, 1, 0}, {0.6, 0, 0.8}, {-0.8, 0, 0.6}},
                          .offset = {-0.009, -0.008, -0.0075}};
    check_plates("corner", &corner,
                 (const double[][3]){{0.003, 0, 0.012}, {-0.006, 0.006, -0.003}, {0.007, 0.008, -0.001}},
                 (const double[]){3e-4, 4e-4, 2e-4});
    /* Floors at both ends of a rod of 40 mm, one level and one at 50 degrees. */
    const double t = 50 * pi / 180;
    const walls ends = {.count = 2, .normal = {{0, 1, 0}, {-sin(t), cos(t), 0}}, .offset = {-0.004, -0.018}};
    check_plates("distant", &ends, (const double[][3]){{-0.020, 0, 0}, {0.020, 0.001, 0.001}},
                 (const double[]){3e-4, 5e-4});
    return 0;
}
