/* SPDX-License-Identifier: MIT
 *
 * most_stiffness: the contact's stiffness against a 6 x 6 matrix and an eigenvalue solver of the test's own,
 * against the slope of the force, and what bounding it does to the wrench.
 */
#include "asset_builder.h"
#include "check.h"

enum { BALL = 20000 };
static const double h = 0.001, radius = 0.02, k = 1e9;
static const double floor_height = 0.00037; /* in the cells 0 <= y < h, which are the surface */
static uint8_t memory[1 << 22] __attribute__((aligned(64)));

static double floor_distance(const void *shape, const double p[3])
{
    (void)shape;
    return p[1] - floor_height;
}

/* A floor and a wall: two contacts, of which the second comes while the first is loaded. */
static double corner_distance(const void *shape, const double p[3])
{
    (void)shape;
    return fmin(p[1] - floor_height, p[0] + 0.01);
}

/* The largest eigenvalue of a symmetric matrix by Jacobi's rotations. */
static double largest_eigenvalue(double a[6][6])
{
    for (int sweep = 0; sweep < 50; sweep++) {
        for (int p = 0; p < 6; p++) {
            for (int q = p + 1; q < 6; q++) {
                if (a[p][q] == 0) continue;
                double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
                double c = 1 / sqrt(t * t + 1), s = t * c;
                for (int n = 0; n < 6; n++) {
                    double x = a[n][p], y = a[n][q];
                    a[n][p] = c * x - s * y;
                    a[n][q] = s * x + c * y;
                }
                for (int n = 0; n < 6; n++) {
                    double x = a[p][n], y = a[q][n];
                    a[p][n] = c * x - s * y;
                    a[q][n] = s * x + c * y;
                }
            }
        }
    }
    double most = 0;
    for (int n = 0; n < 6; n++) most = fmax(most, a[n][n]);
    return most;
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

static vxs_contact_config config_of(uint32_t law, uint32_t field)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = law;
    config.field = field;
    config.weighting = VXS_CONTACT_AREA;
    config.stiffness = k;
    config.reference[0] = 0.003;
    return config;
}

/* K of the ball on the floor in the field distance, along each point's own normal; those that collide along
 * one (scene), if not NULL. */
static double expected_stiffness(const vxs_pointshell *shell, const vxs_pose *pose,
                                 const vxs_contact_config *config, const double *common, int is_all)
{
    double matrix[6][6] = {{0}}, r[9];
    CHECK(vxs_pose_rotation(pose, r));
    for (uint32_t n = 0; n < shell->point_count; n++) {
        const double p[3] = {shell->x[n], shell->y[n], shell->z[n]};
        const double y = r[3] * p[0] + r[4] * p[1] + r[5] * p[2] + pose->position[1];
        if (y >= h) continue;
        const double share = fmin(1, 1 + (floor_height - y) / (h / 8));
        if (share <= 0) continue;
        double normal[3] = {shell->nx[n], shell->ny[n], shell->nz[n]};
        for (int i = 0; i < 3 && common && (is_all || y < floor_height); i++)
            normal[i] = r[i] * common[0] + r[3 + i] * common[1] + r[6 + i] * common[2];
        double arm[3], v[6];
        for (int i = 0; i < 3; i++) arm[i] = (p[i] - config->reference[i]) / shell->radius;
        for (int i = 0; i < 3; i++) {
            v[i] = normal[i];
            v[3 + i] = arm[(i + 1) % 3] * normal[(i + 2) % 3] - arm[(i + 2) % 3] * normal[(i + 1) % 3];
        }
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++) matrix[i][j] += k * (double)shell->area[n] * share * v[i] * v[j];
    }
    return largest_eigenvalue(matrix);
}

static void check_floor(void)
{
    const int64_t low[3] = {-30, -12, -30}, high[3] = {30, 2, 30};
    built_asset map_bytes = build_field_map(h, low, high, floor_distance, NULL, 3),
                bytes = build_ball_shell(h, radius, BALL);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact;
    CHECK_INT(vxs_contact_init(memory, sizeof memory, &shell, 1, &contact), VXS_OK);
    static const uint32_t laws[] = {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE, VXS_CONTACT_GRADIENT};
    for (int law = 0; law < 3; law++) {
        for (int n = 0; n < 8; n++) {
            vxs_pose pose = {{0.0003 * n, radius + floor_height - 0.0002 * n, -0.0001 * n},
                             {1, 0.2 * n, 0.1, -0.05 * n}};
            vxs_contact_config config = config_of(laws[law], VXS_CONTACT_DISTANCE);
            const vxs_contact_result free = evaluate(contact, &map, &pose, &config);
            CHECK(free.stiffness == 0);
            config.most_stiffness = 1e12; /* looks, and does nothing */
            vxs_contact_result told = evaluate(contact, &map, &pose, &config);
            const double expected =
                expected_stiffness(&shell, &pose, &config, law ? told.normal : NULL, law == 2);
            if (told.points == 0) continue;
            CHECK(told.stiffness > (1 - 1e-5) * expected && told.stiffness < (1 + 6e-4) * expected);
            CHECK(!(told.flags & VXS_CONTACT_SOFTENED));
            const double stiffness = told.stiffness;
            told.stiffness = 0;
            CHECK(memcmp(&told, &free, sizeof free) == 0);
            config.most_stiffness = stiffness / 3;
            const vxs_contact_result soft = evaluate(contact, &map, &pose, &config);
            CHECK(soft.flags & VXS_CONTACT_SOFTENED);
            for (int i = 0; i < 3; i++) { /* shorter, not turned */
                CHECK_NEAR(soft.wrench.force[i], free.wrench.force[i] / 3,
                           1e-12 * fabs(free.wrench.force[1]));
                CHECK_NEAR(soft.wrench.torque[i], free.wrench.torque[i] / 3,
                           1e-12 * fabs(free.wrench.force[1]));
            }
        }
    }
    /* The slope of the force down the floor, a tick's micrometre at a time, stays under the bound. */
    for (uint32_t field = (uint32_t)check_length(VXS_CONTACT_SURFACE, VXS_CONTACT_DISTANCE);
         field <= VXS_CONTACT_DISTANCE; field++) {
        vxs_contact_config config = config_of(VXS_CONTACT_AVERAGE, field);
        double steepest[2] = {0, 0};
        for (int bounded = 0; bounded < 2; bounded++) {
            config.most_stiffness = bounded ? 20e3 : 0;
            double last = 0;
            for (int n = (int)check_length(0, 290); n < 1200; n++) { /* it touches from 300 on */
                vxs_pose pose = {{0, radius + floor_height + 0.0003 - 1e-6 * n, 0}, {1, 0.2, 0.1, -0.05}};
                const vxs_contact_result r = evaluate(contact, &map, &pose, &config);
                if (r.flags & VXS_CONTACT_DEEP) break;
                steepest[bounded] = fmax(steepest[bounded], (r.wrench.force[1] - last) / 1e-6);
                last = r.wrench.force[1];
            }
        }
        printf("field %u: the force rises by %.0f N/m at most, bounded to 20000 N/m by %.0f N/m\n",
               (unsigned)field, steepest[0], steepest[1]);
        if (field == VXS_CONTACT_DISTANCE) {
            CHECK(steepest[0] > 60e3);
            CHECK(steepest[1] < 20e3 * 1.001);
        }
    }
    built_free(&map_bytes);
    built_free(&bytes);
}

/* Down on the floor, then against the wall: the bounded wrench has no jump that the free one has not. */
static void check_corner(void)
{
    const int64_t low[3] = {-40, -12, -30}, high[3] = {30, 30, 30};
    built_asset map_bytes = build_field_map(h, low, high, corner_distance, NULL, 3),
                bytes = build_ball_shell(h, radius, BALL);
    vxs_voxmap map = open_voxmap(&map_bytes);
    vxs_pointshell shell = open_pointshell(&bytes);
    vxs_contact *contact;
    CHECK_INT(vxs_contact_init(memory, sizeof memory, &shell, 1, &contact), VXS_OK);
    for (uint32_t law = (uint32_t)check_length(VXS_CONTACT_AVERAGE, VXS_CONTACT_PATCH);
         law <= VXS_CONTACT_PATCH; law++) {
        for (int bounded = (int)check_length(0, 1); bounded < 2; bounded++) {
            vxs_contact_config config = config_of(law, VXS_CONTACT_DISTANCE);
            config.most_stiffness = bounded ? 30e3 : 0;
            vxs_contact_result last = {.points = 0};
            double jump = 0;
            for (int n = 0; n <= 800; n++) {
                vxs_pose pose = {{radius - 0.01 + 0.0004 - 1e-6 * n, radius + floor_height - 0.0004, 0},
                                 {1, 0, 0, 0}};
                const vxs_contact_result r = evaluate(contact, &map, &pose, &config);
                double square = 0, size = 0;
                for (int i = 0; i < 3; i++) {
                    square += pow(r.wrench.force[i] - last.wrench.force[i], 2);
                    size += pow(r.wrench.force[i], 2);
                }
                if (n > 0) jump = fmax(jump, sqrt(square / size));
                last = r;
            }
            printf("corner, law %u, %s: jumps by %.2f %% in 1 um\n", (unsigned)law,
                   bounded ? "bounded" : "free", 100 * jump);
            if (law != VXS_CONTACT_AVERAGE) CHECK(jump < 0.02);
        }
    }
    built_free(&map_bytes);
    built_free(&bytes);
}

int main(void)
{
    check_floor();
    check_corner();
    return 0;
}
