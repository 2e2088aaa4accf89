/* SPDX-License-Identifier: MIT
 *
 * A peg of 19.8 mm in a hole of 20 mm, tilted by a degree, against the elastic foundation: pressure k times
 * depth on the peg's surface, integrated over the true cylinder. Pushed in at 20 mm/s, tick by tick.
 */
#include "asset_builder.h"
#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double stiffness = 1e10;                                    /* [N/m^3] */
static const double peg_radius = 0.0099, peg_length = 0.030, tilt = 1.0; /* [m], [degrees] */

typedef struct hole {
    double radius, height; /* through a block, 0 <= y <= height, about the y axis at `center` */
    double center[2];
} hole;

static double hole_distance(const void *shape, const double p[3])
{
    const hole *h = shape;
    double play = h->radius - hypot(p[0] - h->center[0], p[2] - h->center[1]);
    double over = fabs(p[1] - h->height / 2) - h->height / 2;
    return play > 0 && over > 0 ? hypot(play, over) : fmax(play, over);
}

/* The side and the flat ends of a cylinder about the y axis, in a grid of about `spacing`. */
static built_asset peg_shell(double spacing)
{
    uint32_t around = (uint32_t)(2 * pi * peg_radius / spacing), along = (uint32_t)(peg_length / spacing);
    uint32_t rings = (uint32_t)(peg_radius / spacing), count = 0;
    built_point *points = calloc((size_t)around * (along + 2 * rings), sizeof *points);
    CHECK(points != NULL);
    for (uint32_t n = 0; n < along; n++) {
        for (uint32_t m = 0; m < around; m++) {
            double turn = 2 * pi * (m + 0.5 * (n % 2)) / around, c = cos(turn), s = sin(turn);
            points[count++] = (built_point){
                {(float)(peg_radius * c), (float)(peg_length * (n + 0.5) / along), (float)(peg_radius * s)},
                {(float)-c, 0, (float)-s},
                (float)(2 * pi * peg_radius * peg_length / around / along)};
        }
    }
    for (uint32_t end = 0; end < 2; end++) {
        for (uint32_t n = 0; n < rings; n++) {
            double radius = peg_radius * (n + 0.5) / rings;
            uint32_t number = (uint32_t)(2 * pi * radius / spacing) + 1;
            for (uint32_t m = 0; m < number; m++) {
                double turn = 2 * pi * m / number;
                points[count++] = (built_point){
                    {(float)(radius * cos(turn)), (float)(end * peg_length), (float)(radius * sin(turn))},
                    {0, end ? -1.0f : 1.0f, 0},
                    (float)(2 * pi * radius * peg_radius / rings / number)};
            }
        }
    }
    built_asset asset = build_pointshell(spacing, points, count);
    free(points);
    return asset;
}

typedef struct wrench {
    double force[3], torque[3], gross; /* about a reference in the peg; sum of |forces| */
} wrench;

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static double apart(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return length(d);
}

static void turn_by(const vxs_pose *pose, const double v[3], double out[3])
{
    double r[9];
    CHECK(vxs_pose_rotation(pose, r));
    for (int i = 0; i < 3; i++) out[i] = r[3 * i] * v[0] + r[3 * i + 1] * v[1] + r[3 * i + 2] * v[2];
}

/* Midpoints of 720 x 600 pieces of the cylinder's side; the ends touch nothing. */
static wrench foundation(const hole *h, const vxs_pose *pose, const double reference[3])
{
    enum { AROUND = 720, ALONG = 600 };
    wrench sum = {.gross = 0};
    const double area = 2 * pi * peg_radius * peg_length / AROUND / ALONG;
    double about[3];
    turn_by(pose, reference, about);
    for (int m = 0; m < AROUND; m++) {
        const double turn = 2 * pi * (m + 0.5) / AROUND, c = cos(turn), s = sin(turn),
                     inwards[3] = {-c, 0, -s};
        double normal[3];
        turn_by(pose, inwards, normal);
        for (int n = 0; n < ALONG; n++) {
            const double own[3] = {peg_radius * c, peg_length * (n + 0.5) / ALONG, peg_radius * s};
            double arm[3], at[3];
            turn_by(pose, own, arm);
            for (int i = 0; i < 3; i++) at[i] = pose->position[i] + arm[i];
            for (int i = 0; i < 3; i++) arm[i] -= about[i];
            const double depth = -hole_distance(h, at);
            if (depth <= 0) continue;
            const double size = stiffness * depth * area;
            sum.gross += size;
            for (int i = 0; i < 3; i++) {
                const int j = (i + 1) % 3, k = (i + 2) % 3;
                sum.force[i] += size * normal[i];
                sum.torque[i] += size * (arm[j] * normal[k] - arm[k] * normal[j]);
            }
        }
    }
    return sum;
}

typedef struct mode {
    const char *name;
    uint32_t law, field;
} mode;

static const mode modes[] = {
    {"patch distance", VXS_CONTACT_PATCH, VXS_CONTACT_DISTANCE},
    {"average distance", VXS_CONTACT_AVERAGE, VXS_CONTACT_DISTANCE},
    {"original distance", VXS_CONTACT_ORIGINAL, VXS_CONTACT_DISTANCE},
    {"gradient distance", VXS_CONTACT_GRADIENT, VXS_CONTACT_DISTANCE},
    {"patch layers", VXS_CONTACT_PATCH, VXS_CONTACT_LAYERS},
    {"average layers", VXS_CONTACT_AVERAGE, VXS_CONTACT_LAYERS},
    {"patch surface", VXS_CONTACT_PATCH, VXS_CONTACT_SURFACE},
    {"average surface", VXS_CONTACT_AVERAGE, VXS_CONTACT_SURFACE},
};
enum { MODES = sizeof modes / sizeof *modes };

/* Shares of the reference's |force| and |torque|; of its gross force, and that times the peg's radius, where
 * the two sides of the hole cancel to less than a quarter of it. [degrees]; there none. */
typedef struct worst {
    double force, torque, direction, jump, torque_jump;
    uint32_t patches;
} worst;

enum { TICKS = 850, EVERY = 50, SCORED = 350 };

/* Tick n: from 11 mm deep, where nothing touches, to 28 mm. The axis passes the middle of what is in the
 * hole, where torque is taken, at `aside` from the hole's, and sways across the tilt. */
static vxs_pose pose_at(const hole *h, int n, double aside, double reference[3])
{
    const double half = tilt * pi / 360, deep = 0.011 + 2e-5 * n;
    vxs_pose pose = {{h->center[0] + aside + sin(2 * half) * deep / 2, h->height - cos(2 * half) * deep,
                      h->center[1] + 0.00004 * sin(0.01 * n)},
                     {cos(half), 0, 0, sin(half)}};
    for (int i = 0; i < 3; i++) reference[i] = i == 1 ? deep / 2 : 0;
    return pose;
}

static void push(const hole *h, const vxs_voxmap *map, vxs_contact *contact, double aside, int count,
                 worst out[MODES])
{
    wrench references[TICKS / EVERY + 1];
    double gross = 0; /* the largest */
    for (int n = 0; n <= TICKS; n += EVERY) {
        double reference[3];
        vxs_pose pose = pose_at(h, n, aside, reference);
        references[n / EVERY] = foundation(h, &pose, reference);
        gross = fmax(gross, references[n / EVERY].gross);
    }
    memset(out, 0, MODES * sizeof *out);
    for (int m = 0; m < count; m++) {
        vxs_contact_config config;
        vxs_contact_config_default(&config);
        config.law = modes[m].law;
        config.field = modes[m].field;
        config.weighting = VXS_CONTACT_AREA;
        config.stiffness = stiffness;
        vxs_contact_result last, r;
        const vxs_contact_static statics = {map, NULL};
        for (int n = 0; n <= TICKS; n++) {
            vxs_pose pose = pose_at(h, n, aside, config.reference);
            vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &r);
            CHECK(!(r.flags & VXS_CONTACT_INVALID));
            if (r.patches > out[m].patches) out[m].patches = r.patches;
            const double force = length(r.wrench.force), torque = length(r.wrench.torque);
            if (n > 0) {
                out[m].jump =
                    fmax(out[m].jump, apart(r.wrench.force, last.wrench.force) / fmax(force, 0.1 * gross));
                out[m].torque_jump = fmax(out[m].torque_jump, apart(r.wrench.torque, last.wrench.torque) /
                                                                  fmax(torque, 0.1 * gross * peg_radius));
            }
            last = r;
            if (n % EVERY || n < SCORED) continue;
            const wrench *w = &references[n / EVERY];
            const double size = length(w->force), bend = length(w->torque), lever = w->gross * peg_radius;
            const int is_net = size > 0.25 * w->gross;
            double along = 0;
            for (int i = 0; i < 3; i++) along += r.wrench.force[i] * w->force[i];
            out[m].force = fmax(out[m].force, apart(r.wrench.force, w->force) / (is_net ? size : w->gross));
            out[m].torque =
                fmax(out[m].torque, apart(r.wrench.torque, w->torque) / (bend > 0.25 * lever ? bend : lever));
            if (is_net)
                out[m].direction = fmax(out[m].direction, acos(fmin(1, along / size / force)) * 180 / pi);
        }
    }
}

/* With an argument: every mode everywhere, and finer cells. */
int main(int argc, char **argv)
{
    (void)argv;
    const int is_long = argc > 1;
    const hole h = {0.010, 0.030, {0.00037, -0.00021}};
    const double voxels[] = {0.0005, 0.00025}, asides[] = {0, 0.00004, 0.0001};
    for (int v = 0; v < 1 + is_long; v++) {
        const double voxel = voxels[v];
        const int64_t reach = (int64_t)(0.0125 / voxel), top = (int64_t)(h.height / voxel);
        const int64_t low[3] = {-reach, 0, -reach}, high[3] = {reach, top, reach};
        built_asset map_bytes = build_field_map(voxel, low, high, hole_distance, &h, 3),
                    bytes = peg_shell(voxel);
        vxs_voxmap map = open_voxmap(&map_bytes);
        vxs_pointshell shell = open_pointshell(&bytes);
        void *memory = NULL;
        CHECK((memory = aligned_alloc(64, (vxs_contact_memory(&shell, 1) + 63) / 64 * 64)) != NULL);
        vxs_contact *contact;
        CHECK_INT(vxs_contact_init(memory, vxs_contact_memory(&shell, 1), &shell, 1, &contact), VXS_OK);
        for (int a = (int)check_length(0, 2); a < 3; a++) {
            worst found[MODES];
            const int count = is_long ? MODES : a == 1 ? 2 : 1;
            push(&h, &map, contact, asides[a], count, found);
            printf("cells of %.2f mm, %u points, axis %.2f mm aside: error of force, torque, direction; "
                   "jumps of "
                   "force, torque; patches\n",
                   1e3 * voxel, (unsigned)shell.point_count, 1e3 * asides[a]);
            CHECK(found[0].force < 0.10 && found[0].torque < 0.10 && found[0].direction < 5);
            CHECK(found[0].jump < 0.05 && found[0].torque_jump < 0.05);
            for (int m = 0; m < count; m++)
                printf("  %-18s %6.1f %% %6.1f %% %6.2f deg  %5.2f %% %5.2f %%  %u\n", modes[m].name,
                       100 * found[m].force, 100 * found[m].torque, found[m].direction, 100 * found[m].jump,
                       100 * found[m].torque_jump, (unsigned)found[m].patches);
        }
        free(memory);
        built_free(&map_bytes);
        built_free(&bytes);
    }
    return 0;
}
