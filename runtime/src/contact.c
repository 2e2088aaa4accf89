/* SPDX-License-Identifier: MIT
 *
 * One evaluation: place the shell, probe, find the normal or the patches, sum. rt-safe.
 *
 * All geometry is relative to the box's corner, so that a part 10 km from the origin loses
 * nothing but what its pose has lost already.
 */
#include "contact_probe.h"

#include <math.h>
#include <string.h>

/* Below this length a mean of unit normals says nothing about a direction (METHOD section 3). */
static const double cancelled_mean = 0.1;
/* A point joins a patch whose first normal is within 60 degrees of its own. */
static const double patch_cosine = 0.5;

/* The shell in the map's frame, origin at the box's corner. */
typedef struct placement {
    double rotation[9];
    double corner_to_shell[3]; /* t - h origin_cell [m] */
} placement;

typedef struct evaluation {
    const vxs_voxmap *map;
    const vxs_pointshell *shell;
    const vxs_contact_config *config;
    const vxs_contact_scratch *scratch;
    placement place;
    double force[3], torque[3];
    double depth;
} evaluation;

static double dot(const double a[3], const double b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

static void rotate(const double r[9], const double v[3], double out[3])
{
    double turned[3] = {dot(r, v), dot(r + 3, v), dot(r + 6, v)};
    memcpy(out, turned, sizeof turned);
}

static void rotate_back(const double r[9], const double v[3], double out[3])
{
    double turned[3];
    for (int i = 0; i < 3; i++) turned[i] = (r[i] * v[0] + r[3 + i] * v[1]) + r[6 + i] * v[2];
    memcpy(out, turned, sizeof turned);
}

/* inverse(map_pose) o pose, then to the box's corner. Returns 0 for a bad pose. */
static int place_shell(const vxs_voxmap *map, const vxs_pose *map_pose, double map_rotation[9],
                       const vxs_pose *pose, placement *place)
{
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double turn[9], offset[3];
    if (!vxs_pose_rotation(pose, turn)) return 0;
    memcpy(offset, pose->position, sizeof offset);
    memcpy(map_rotation, identity, sizeof identity);
    memcpy(place->rotation, turn, sizeof turn);
    if (map_pose) {
        if (!vxs_pose_rotation(map_pose, map_rotation)) return 0;
        for (int i = 0; i < 3; i++) offset[i] -= map_pose->position[i];
        rotate_back(map_rotation, offset, offset);
        for (int row = 0; row < 3; row++) {
            for (int column = 0; column < 3; column++) {
                place->rotation[3 * row + column] =
                    (map_rotation[row] * turn[column] + map_rotation[3 + row] * turn[3 + column]) +
                    map_rotation[6 + row] * turn[6 + column];
            }
        }
    }
    for (int i = 0; i < 3; i++)
        place->corner_to_shell[i] = offset[i] - map->voxel * (double)map->origin_cell[i];
    return 1;
}

/* Whether the shell's bounding sphere, widened by the probe's rounding, meets the box at all. */
static int meets_box(const vxs_voxmap *map, const vxs_pointshell *shell, const placement *place)
{
    double center[3], outside = 0, scale = 0;
    rotate(place->rotation, shell->center, center);
    for (int i = 0; i < 3; i++) {
        center[i] = (center[i] + place->corner_to_shell[i]) / map->voxel;
        double extent = map->cells[i];
        double gap = center[i] < 0 ? -center[i] : center[i] > extent ? center[i] - extent : 0;
        outside += gap * gap;
        scale += fabs(center[i]) + fabs(shell->center[i]) / map->voxel;
    }
    double radius = shell->radius / map->voxel;
    double reach = radius + 1 + (radius + scale) * 0x1p-18;
    return outside <= reach * reach; /* a NaN is outside */
}

static void probe_motion(const vxs_voxmap *map, const placement *place, vxsi_probe_motion *motion)
{
    for (int i = 0; i < 9; i++) motion->m[i] = (float)(place->rotation[i] / map->voxel);
    for (int i = 0; i < 3; i++) motion->b[i] = (float)(place->corner_to_shell[i] / map->voxel);
}

static void shell_normal(const vxs_pointshell *shell, uint32_t point, double normal[3])
{
    normal[0] = shell->nx[point];
    normal[1] = shell->ny[point];
    normal[2] = shell->nz[point];
}

/* Adds one point's force along the normal (map frame, unit). */
static void add_point(evaluation *e, const vxsi_hit *hit, const double normal[3])
{
    const vxs_pointshell *shell = e->shell;
    double local[3] = {shell->x[hit->point], shell->y[hit->point], shell->z[hit->point]};
    double turned[3], to_center[3];
    rotate(e->place.rotation, local, turned);
    for (int i = 0; i < 3; i++) {
        double p = turned[i] + e->place.corner_to_shell[i];
        to_center[i] = e->map->voxel * (hit->cell[i] + 0.5) - p;
    }
    double depth = dot(to_center, normal);
    if (!(depth > 0)) return;
    if (depth > e->depth) e->depth = depth;
    double size = e->config->stiffness * depth;
    if (e->config->weighting == VXS_CONTACT_AREA) size *= shell->area[hit->point];
    double force[3] = {size * normal[0], size * normal[1], size * normal[2]};
    double lever[3];
    for (int i = 0; i < 3; i++) lever[i] = local[i] - e->config->reference[i];
    rotate(e->place.rotation, lever, lever);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        e->force[i] += force[i];
        e->torque[i] += lever[j] * force[k] - lever[k] * force[j];
    }
}

/* The mean of the shell-frame normals of the hits of a patch (of all with patch < 0), turned into
 * the map's frame and of length 1. Returns 0 if it cancels. */
static int mean_normal(const evaluation *e, int patch, double normal[3])
{
    double sum[3] = {0, 0, 0}, count = 0;
    for (uint32_t n = 0; n < e->scratch->count; n++) {
        if (patch >= 0 && e->scratch->patch[n] != patch) continue;
        double own[3];
        shell_normal(e->shell, e->scratch->hits[n].point, own);
        for (int i = 0; i < 3; i++) sum[i] += own[i];
        count += 1;
    }
    double length = sqrt(dot(sum, sum));
    if (!(length >= cancelled_mean * count) || count == 0) return 0;
    for (int i = 0; i < 3; i++) sum[i] /= length;
    rotate(e->place.rotation, sum, normal);
    return 1;
}

/* Greedy, in point order: a point joins the first patch whose first normal agrees with its own,
 * else it opens one; when all are taken the last takes it. Returns the number of patches. */
static uint32_t split_patches(evaluation *e, vxs_contact_scratch *scratch)
{
    double seed[VXS_CONTACT_MAX_PATCHES][3];
    uint32_t patches = 0;
    for (uint32_t n = 0; n < scratch->count; n++) {
        double own[3];
        shell_normal(e->shell, scratch->hits[n].point, own);
        uint32_t patch = 0;
        while (patch < patches && dot(seed[patch], own) < patch_cosine) patch++;
        if (patch == VXS_CONTACT_MAX_PATCHES)
            patch--;
        else if (patch == patches)
            memcpy(seed[patches++], own, sizeof own);
        scratch->patch[n] = (uint8_t)patch;
    }
    return patches;
}

/* With normal NULL each point takes its own: the original law. */
static void add_hits(evaluation *e, int patch, const double *normal)
{
    for (uint32_t n = 0; n < e->scratch->count; n++) {
        if (patch >= 0 && e->scratch->patch[n] != patch) continue;
        const vxsi_hit *hit = &e->scratch->hits[n];
        double own[3];
        if (!normal) {
            shell_normal(e->shell, hit->point, own);
            rotate(e->place.rotation, own, own);
        }
        add_point(e, hit, normal ? normal : own);
    }
}

static void add_patches(evaluation *e, vxs_contact_scratch *scratch, vxs_contact_result *result)
{
    result->flags |= VXS_CONTACT_MEAN_CANCELLED;
    result->patches = split_patches(e, scratch);
    for (uint32_t patch = 0; patch < result->patches; patch++) {
        double normal[3];
        int has_normal = mean_normal(e, (int)patch, normal);
        add_hits(e, (int)patch, has_normal ? normal : NULL);
    }
}

static void give_wrench(const evaluation *e, const double map_rotation[9], vxs_contact_result *result)
{
    double share = 1;
    if (e->config->weighting == VXS_CONTACT_COUNT_CAPPED && result->points > VXS_CONTACT_CAP_POINTS)
        share = (double)VXS_CONTACT_CAP_POINTS / result->points;
    for (int i = 0; i < 3; i++) {
        result->wrench.force[i] = e->force[i] * share;
        result->wrench.torque[i] = e->torque[i] * share;
    }
    result->depth = e->depth;
    rotate(map_rotation, result->wrench.force, result->wrench.force);
    rotate(map_rotation, result->wrench.torque, result->wrench.torque);
    rotate(map_rotation, result->normal, result->normal);
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += fabs(result->wrench.force[i]) + fabs(result->wrench.torque[i]);
    if (!isfinite(sum)) {
        memset(&result->wrench, 0, sizeof result->wrench);
        result->flags |= VXS_CONTACT_INVALID;
    }
}

vxs_result vxs_contact_config_check(const vxs_contact_config *config)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    if (config->law != VXS_CONTACT_ORIGINAL && config->law != VXS_CONTACT_AVERAGE) return VXS_PARAM;
    if (config->weighting < VXS_CONTACT_COUNT || config->weighting > VXS_CONTACT_AREA) return VXS_PARAM;
    for (int i = 0; i < 3; i++) {
        if (!isfinite(config->reference[i])) return VXS_PARAM;
    }
    return isfinite(config->stiffness) && config->stiffness > 0 ? VXS_OK : VXS_PARAM;
}

uint32_t vxs_contact_evaluate(const vxs_voxmap *map, const vxs_pose *map_pose, const vxs_pointshell *shell,
                              const vxs_pose *pose, const vxs_contact_config *config,
                              vxs_contact_scratch *scratch, vxs_contact_result *result)
{
    memset(result, 0, sizeof *result);
    double map_rotation[9];
    evaluation e = {.map = map, .shell = shell, .config = config, .scratch = scratch};
    if (vxs_contact_config_check(config) != VXS_OK ||
        !place_shell(map, map_pose, map_rotation, pose, &e.place))
        return result->flags = VXS_CONTACT_INVALID;
    if (!meets_box(map, shell, &e.place)) return result->flags = VXS_CONTACT_OUT_OF_MAP;

    vxsi_probe_motion motion;
    probe_motion(map, &e.place, &motion);
    scratch->count = scratch->deep_count = scratch->overflow = 0;
    scratch->probe(map, shell, &motion, scratch);
    if (scratch->deep_count > 0) result->flags |= VXS_CONTACT_DEEP;
    if (scratch->overflow) result->flags |= VXS_CONTACT_OVERFLOW;
    result->deep_points = scratch->deep_count;
    result->points = scratch->count;
    if (scratch->count == 0) return result->flags;

    int has_mean = mean_normal(&e, -1, result->normal);
    result->patches = 1;
    if (config->law == VXS_CONTACT_ORIGINAL)
        add_hits(&e, -1, NULL);
    else if (has_mean)
        add_hits(&e, -1, result->normal);
    else
        add_patches(&e, scratch, result);
    give_wrench(&e, map_rotation, result);
    return result->flags;
}
