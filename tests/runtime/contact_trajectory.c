/* SPDX-License-Identifier: MIT
 *
 * contact_trajectory MAP SHELL POSES: evaluates contact at random poses and along a trajectory with every
 * kernel and every culling, compares them to the last bit, and prints a hash of all wrenches for each part.
 * The same hash on any machine: poses are made by arithmetic alone.
 */
#include "check.h"
#include "voxshell/contact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STATICS = 2, MOST_VARIANTS = 16 };

typedef struct variant {
    uint32_t kernel, culling;
    void *memory;
    vxs_contact *contact;
    uint64_t probed;
} variant;

typedef struct bed {
    vxs_asset map_asset, shell_asset;
    vxs_voxmap map;
    vxs_pointshell shell;
    variant variants[MOST_VARIANTS];
    int count;
    uint64_t hash, touching, deep, points;
} bed;

static uint64_t dice = 88172645463325252u;
static double uniform(void) /* xorshift, -1 .. 1 */
{
    dice ^= dice << 13;
    dice ^= dice >> 7;
    dice ^= dice << 17;
    return (double)(dice >> 11) * 0x1p-53 * 2 - 1;
}

static void open_bed(bed *b, const char *map, const char *shell)
{
    CHECK_INT(vxs_asset_open(map, NULL, &b->map_asset, NULL), VXS_OK);
    CHECK_INT(vxs_asset_open(shell, NULL, &b->shell_asset, NULL), VXS_OK);
    CHECK_INT(vxs_voxmap_open(&b->map_asset, &b->map), VXS_OK);
    CHECK_INT(vxs_pointshell_open(&b->shell_asset, &b->shell), VXS_OK);
    CHECK(b->map.clearance_index != NULL);
    size_t size = (vxs_contact_memory(&b->shell, STATICS) + 63) / 64 * 64;
    for (uint32_t kernel = VXS_CONTACT_SCALAR; kernel <= VXS_CONTACT_AVX512; kernel++) {
        for (uint32_t culling = VXS_CONTACT_COHERENT; culling <= VXS_CONTACT_CHECKED; culling++) {
            variant *v = &b->variants[b->count];
            v->kernel = kernel;
            v->culling = culling;
            v->memory = aligned_alloc(64, size);
            CHECK(v->memory != NULL);
            CHECK_INT(vxs_contact_init(v->memory, size, &b->shell, STATICS, &v->contact), VXS_OK);
            CHECK_INT(vxs_contact_cull(v->contact, culling), VXS_OK);
            if (vxs_contact_use(v->contact, kernel) == VXS_OK)
                b->count++;
            else
                free(v->memory);
        }
    }
}

static void close_bed(bed *b)
{
    for (int n = 0; n < b->count; n++) free(b->variants[n].memory);
    vxs_asset_close(&b->map_asset);
    vxs_asset_close(&b->shell_asset);
}

static void add_to_hash(bed *b, const void *data, size_t size) /* FNV-1a */
{
    const uint8_t *bytes = data;
    for (size_t n = 0; n < size; n++) b->hash = (b->hash ^ bytes[n]) * 1099511628211u;
}

static void evaluate(bed *b, const vxs_contact_static *statics, uint32_t count, const vxs_pose *pose,
                     const vxs_contact_config *config)
{
    vxs_contact_result first;
    for (int n = 0; n < b->count; n++) {
        vxs_contact_result r;
        vxs_contact_evaluate(b->variants[n].contact, statics, count, pose, config, &r);
        b->variants[n].probed += r.probed;
        r.probed = 0;
        CHECK(!(r.flags & VXS_CONTACT_WRONG_SKIP));
        if (n == 0) first = r;
        CHECK(memcmp(&first, &r, sizeof r) == 0);
    }
    b->touching += first.points > 0;
    b->deep += first.deep_points > 0;
    b->points += first.points;
    add_to_hash(b, first.wrench.force, sizeof first.wrench.force);
    add_to_hash(b, first.wrench.torque, sizeof first.wrench.torque);
    add_to_hash(b, first.normal, sizeof first.normal);
    add_to_hash(b, &first.depth, sizeof first.depth);
    const uint32_t counts[] = {first.points, first.deep_points, first.patches, first.flags};
    add_to_hash(b, counts, sizeof counts);
}

static vxs_contact_config config_of(int n)
{
    static const uint32_t laws[] = {VXS_CONTACT_AVERAGE, VXS_CONTACT_ORIGINAL, VXS_CONTACT_GRADIENT};
    static const uint32_t weightings[] = {VXS_CONTACT_COUNT, VXS_CONTACT_AREA, VXS_CONTACT_COUNT_CAPPED};
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = laws[n % 3];
    if (config.law == VXS_CONTACT_GRADIENT) config.field = VXS_CONTACT_DISTANCE;
    config.weighting = weightings[n / 3 % 3];
    config.reference[0] = 0.001 * (n % 5);
    return config;
}

/* The same for the law patch, for deeper fields, and for a bound on the stiffness. */
static vxs_contact_config deep_config_of(int n)
{
    static const uint32_t laws[] = {VXS_CONTACT_PATCH,    VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE,
                                    VXS_CONTACT_PATCH,    VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE,
                                    VXS_CONTACT_GRADIENT, VXS_CONTACT_PATCH};
    static const uint32_t fields[] = {VXS_CONTACT_SURFACE,  VXS_CONTACT_LAYERS,   VXS_CONTACT_LAYERS,
                                      VXS_CONTACT_LAYERS,   VXS_CONTACT_DISTANCE, VXS_CONTACT_DISTANCE,
                                      VXS_CONTACT_DISTANCE, VXS_CONTACT_DISTANCE};
    vxs_contact_config config = config_of(n / 8);
    config.law = laws[n % 8];
    config.field = fields[n % 8];
    if (n / 8 % 5 == 0) config.most_stiffness = config.weighting == VXS_CONTACT_AREA ? 0.05 : 5000;
    return config;
}

typedef vxs_contact_config config_maker(int n);

static void random_pose(const vxs_voxmap *map, vxs_pose *pose)
{
    for (int i = 0; i < 3; i++) {
        double low = map->voxel * (double)map->bbox_min[i], high = map->voxel * (double)map->bbox_max[i];
        pose->position[i] = 0.5 * (low + high) + 0.7 * (high - low) * uniform();
    }
    for (int i = 0; i < 4; i++) pose->orientation[i] = uniform();
}

static void begin(bed *b)
{
    b->hash = 14695981039346656037u;
    b->touching = b->deep = b->points = 0;
    for (int n = 0; n < b->count; n++) b->variants[n].probed = 0;
}

static void tell(const bed *b, const char *part, int poses)
{
    printf("%s %d poses: %llu touch, %llu deep, %llu points, hash %016llx\n", part, poses,
           (unsigned long long)b->touching, (unsigned long long)b->deep, (unsigned long long)b->points,
           (unsigned long long)b->hash);
}

static void random_part(bed *b, const char *name, config_maker *make, int poses)
{
    begin(b);
    for (int n = 0; n < poses; n++) {
        vxs_pose pose, moved;
        random_pose(&b->map, &pose);
        random_pose(&b->map, &moved);
        vxs_contact_config config = make(n);
        /* Now and then two statics of which one stands elsewhere. */
        const vxs_contact_static statics[STATICS] = {{&b->map, NULL}, {&b->map, &moved}};
        evaluate(b, statics, n % 7 == 0 ? 2 : 1, &pose, &config);
    }
    tell(b, name, poses);
    CHECK(b->touching > (uint64_t)poses / 50 && b->deep > (uint64_t)poses / 200);
}

/* A walk that a hand could make, at a kilohertz: it drifts towards random places, turns slowly, rests, and
 * now and then jumps; the second static moves by itself. */
static void trajectory_part(bed *b, const char *name, config_maker *make, int poses)
{
    begin(b);
    vxs_pose pose = vxs_pose_identity(), goal = pose, other = pose;
    for (int n = 0; n < poses; n++) {
        if (n % 400 == 0) random_pose(&b->map, &goal);
        double share = n % 1000 < 100 ? 0 : n % 5003 == 0 ? 1 : 0.004;
        for (int i = 0; i < 3; i++) pose.position[i] += share * (goal.position[i] - pose.position[i]);
        for (int i = 0; i < 4; i++)
            pose.orientation[i] += share * (goal.orientation[i] - pose.orientation[i]);
        double length = 0;
        for (int i = 0; i < 4; i++) length += pose.orientation[i] * pose.orientation[i];
        if (length < 1e-3) pose.orientation[0] = 1;
        other.position[0] = 0.02 + 1e-5 * n;
        other.orientation[2] = 1e-4 * n;
        vxs_contact_config config = make(n / 1000);
        const vxs_contact_static statics[STATICS] = {{&b->map, NULL}, {&b->map, &other}};
        evaluate(b, statics, n / 2000 % 2 ? 2 : 1, &pose, &config);
    }
    tell(b, name, poses);
    for (int n = 0; n < b->count; n++)
        fprintf(stderr, "kernel %u culling %u: %.1f points looked at in a tick\n",
                (unsigned)b->variants[n].kernel, (unsigned)b->variants[n].culling,
                (double)b->variants[n].probed / poses);
    CHECK(b->touching > (uint64_t)poses / 50);
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        fprintf(stderr, "contact_trajectory MAP SHELL POSES\n");
        return 1;
    }
    static bed b;
    open_bed(&b, argv[1], argv[2]);
    fprintf(stderr, "%u points, %d variants\n", (unsigned)b.shell.point_count, b.count);
    const int poses = atoi(argv[3]);
    random_part(&b, "random", config_of, poses);
    trajectory_part(&b, "trajectory", config_of, poses / 4);
    random_part(&b, "random deep", deep_config_of, poses / 5);
    trajectory_part(&b, "trajectory deep", deep_config_of, poses / 5);
    close_bed(&b);
    return 0;
}
