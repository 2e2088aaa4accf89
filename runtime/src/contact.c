/* SPDX-License-Identifier: MIT
 *
 * One evaluation: place the shell, find the points that touch, find the normal or the patches, sum.
 * rt-safe.
 *
 * All geometry is relative to the box's corner, so that a part 10 km from the origin loses
 * nothing but what its pose has lost already. Sums are in the shell's frame and turned once.
 */
#include "contact_state.h"
#include "vector.h"

#include <math.h>
#include <string.h>

/* Below this length a mean of unit normals says nothing about a direction (METHOD section 3). */
static const double cancelled_mean = 0.1;

/* A law: where the hits' directions come from (contact.h). */
typedef struct law {
    uint8_t exists;
    uint8_t is_sampled; /* from the gradient of the field distance, else the shell's normals */
    uint8_t is_common;  /* one mean for all, unless it cancels */
    uint8_t splits;     /* one mean a patch */
} law;
enum { NEVER, WITHOUT_MEAN, ALWAYS };

static const law laws[] = {
    [VXS_CONTACT_ORIGINAL] = {1, .splits = NEVER},
    [VXS_CONTACT_AVERAGE] = {1, .is_common = 1, .splits = WITHOUT_MEAN},
    [VXS_CONTACT_GRADIENT] = {1, .is_sampled = 1, .splits = NEVER},
    [VXS_CONTACT_PATCH] = {1, .splits = ALWAYS},
};

typedef struct evaluation {
    vxs_contact *contact;
    const vxs_contact_config *config;
    const law *law;
    uint32_t count;             /* statics */
    double touching;            /* hits that collide */
    double force[3], moment[3]; /* per unit of stiffness, shell frame */
    double depth;
} evaluation;

/* inverse(map_pose) o pose, then to the box's corner. Returns 0 for a bad pose. */
static int place_shell(const vxs_contact_static *at, const double turn[9], const vxs_pose *pose,
                       vxsi_placement *place)
{
    double offset[3];
    memcpy(offset, pose->position, sizeof offset);
    memcpy(place->rotation, turn, sizeof place->rotation);
    if (at->pose) {
        double map_rotation[9];
        if (!vxs_pose_rotation(at->pose, map_rotation)) return 0;
        for (int i = 0; i < 3; i++) offset[i] -= at->pose->position[i];
        vxsi_rotate_back(map_rotation, offset, offset);
        for (int row = 0; row < 3; row++) {
            for (int column = 0; column < 3; column++) {
                place->rotation[3 * row + column] =
                    (map_rotation[row] * turn[column] + map_rotation[3 + row] * turn[3 + column]) +
                    map_rotation[6 + row] * turn[6 + column];
            }
        }
    }
    for (int i = 0; i < 3; i++)
        place->offset[i] = offset[i] - at->map->voxel * (double)at->map->origin_cell[i];
    return 1;
}

/* Whether the shell's bounding sphere, widened by the probe's rounding, meets the box at all. */
static int meets_box(const vxs_voxmap *map, const vxs_pointshell *shell, const vxsi_placement *place)
{
    double center[3], outside = 0, scale = 0;
    vxsi_rotate(place->rotation, shell->center, center);
    for (int i = 0; i < 3; i++) {
        center[i] = (center[i] + place->offset[i]) / map->voxel;
        double extent = map->cells[i];
        double gap = center[i] < 0 ? -center[i] : center[i] > extent ? center[i] - extent : 0;
        outside += gap * gap;
        scale += fabs(center[i]) + fabs(shell->center[i]) / map->voxel;
    }
    double radius = shell->radius / map->voxel;
    double reach = radius + 1 + (radius + scale) * 0x1p-18;
    return outside <= reach * reach; /* a NaN is outside */
}

/* Lists what to look at in one static: nothing if the shell is away from its box. Returns whether it is near.
 */
static int approach(vxs_contact *contact, vxsi_static *s, const vxs_voxmap *map, const vxsi_placement *place)
{
    vxsi_span *span = &s->span;
    s->look_count = 0;
    s->is_all = 0;
    int is_near = meets_box(map, &contact->shell, place);
    if (is_near)
        vxsi_contact_walk(contact, s, map, place);
    else
        s->root = NULL;
    s->is_near = is_near;
    span->has_area = (contact->hits.take & VXSI_TAKE_AREA) != 0;
    span->voxel = map->voxel;
    memcpy(span->rotation, place->rotation, sizeof span->rotation);
    memcpy(span->offset, place->offset, sizeof span->offset);
    return is_near;
}

/* The mean of the normals of the hits that collide, of length 1. Returns 0 if it cancels. */
static int mean_normal(evaluation *e, double normal[3])
{
    double sum[3] = {0, 0, 0};
    e->touching = 0;
    for (uint32_t n = 0; n < e->count; n++) {
        double own[3], number;
        e->contact->kernel->mean(&e->contact->hits, &e->contact->statics[n].span,
                                 e->config->field == VXS_CONTACT_DISTANCE, own, &number);
        for (int i = 0; i < 3; i++) sum[i] += own[i];
        e->touching += number;
    }
    double length = sqrt(vxsi_dot(sum, sum));
    if (!(length >= cancelled_mean * e->touching) || e->touching == 0) return 0;
    for (int i = 0; i < 3; i++) normal[i] = sum[i] / length;
    return 1;
}

/* A static's part; for now per unit of stiffness and in the shell's frame. */
static void keep_part(evaluation *e, uint32_t n, const double force[3], const double moment[3])
{
    if (!e->contact->parts) return;
    memcpy(e->contact->parts[n].force, force, sizeof e->contact->parts[n].force);
    memcpy(e->contact->parts[n].torque, moment, sizeof e->contact->parts[n].torque);
}

static void scale_parts(evaluation *e, const double turn[9], double factor)
{
    for (uint32_t n = 0; e->contact->parts && n < e->count; n++) {
        vxs_wrench *part = &e->contact->parts[n];
        for (int i = 0; i < 3; i++) {
            part->force[i] *= factor;
            part->torque[i] *= factor;
        }
        vxsi_rotate(turn, part->force, part->force);
        vxsi_rotate(turn, part->torque, part->torque);
    }
}

static void add_depth(evaluation *e, double depth)
{
    if (depth > e->depth) e->depth = depth;
}

/* Forces along one normal: F = (sum w) n, torque = (sum w x - (sum w) o) x n. */
static void add_common(evaluation *e, const double normal[3])
{
    double weight = 0, moment[3] = {0, 0, 0}, arm[3], torque[3], force[3];
    for (uint32_t n = 0; n < e->count; n++) {
        vxsi_total total;
        e->contact->kernel->sum_common(&e->contact->hits, &e->contact->statics[n].span, normal, &total);
        weight += total.weight;
        for (int i = 0; i < 3; i++) moment[i] += total.moment[i];
        add_depth(e, total.depth);
        if (e->contact->parts) {
            for (int i = 0; i < 3; i++) {
                arm[i] = total.moment[i] - total.weight * e->config->reference[i];
                force[i] = total.weight * normal[i];
            }
            vxsi_cross(arm, normal, torque);
            keep_part(e, n, force, torque);
        }
    }
    for (int i = 0; i < 3; i++) arm[i] = moment[i] - weight * e->config->reference[i];
    vxsi_cross(arm, normal, torque);
    for (int i = 0; i < 3; i++) {
        e->force[i] += weight * normal[i];
        e->moment[i] += torque[i];
    }
}

/* Each force along its hit's own normal: as deep as its channel says, or under the plane of its cell. */
static void add_own(evaluation *e)
{
    const int is_given = e->config->field != VXS_CONTACT_SURFACE;
    for (uint32_t n = 0; n < e->count; n++) {
        vxsi_total total;
        e->contact->kernel->sum_own(&e->contact->hits, &e->contact->statics[n].span, e->config->reference,
                                    is_given, &total);
        for (int i = 0; i < 3; i++) {
            e->force[i] += total.force[i];
            e->moment[i] += total.moment[i];
        }
        add_depth(e, total.depth);
        keep_part(e, n, total.force, total.moment);
    }
}

/* Turns the hits that collide to one normal. */
static void turn_hits(vxsi_hits *hits, const double common[3], uint32_t field)
{
    const float normal[3] = {(float)common[0], (float)common[1], (float)common[2]};
    for (uint32_t n = 0; n < hits->count; n++) vxsi_turn_hit(hits, n, normal, field);
}

/* Depths under the planes of the cells along the hits' normals; only_deeper: where they are larger. */
static void set_planes(evaluation *e, int only_deeper)
{
    for (uint32_t n = 0; n < e->count; n++)
        e->contact->kernel->set_planes(&e->contact->hits, &e->contact->statics[n].span, only_deeper);
}

/* As config.most_stiffness asks: the factor on the wrench. */
static double soften(evaluation *e, const double *common, double stiffness, vxs_contact_result *result)
{
    vxs_contact *contact = e->contact;
    double sum[VXSI_STIFFNESS] = {0};
    if (e->config->field == VXS_CONTACT_SURFACE) {
        if (common) turn_hits(&contact->hits, common, VXS_CONTACT_SURFACE);
        set_planes(e, 0);
    }
    for (uint32_t n = 0; n < e->count; n++)
        vxsi_add_stiffness(&contact->hits, &contact->statics[n].span, e->config->reference,
                           contact->shell.radius, sum);
    result->stiffness = vxsi_largest_eigenvalue(sum) * stiffness;
    if (!(result->stiffness > e->config->most_stiffness)) return 1;
    result->flags |= VXS_CONTACT_SOFTENED;
    return e->config->most_stiffness / result->stiffness;
}

static void give_wrench(evaluation *e, const double turn[9], const double *common, vxs_contact_result *result)
{
    double factor = e->config->stiffness;
    if (e->config->weighting == VXS_CONTACT_COUNT_CAPPED && result->points > VXS_CONTACT_CAP_POINTS)
        factor *= (double)VXS_CONTACT_CAP_POINTS / result->points;
    if (e->config->most_stiffness > 0) factor *= soften(e, common, factor, result);
    for (int i = 0; i < 3; i++) {
        result->wrench.force[i] = e->force[i] * factor;
        result->wrench.torque[i] = e->moment[i] * factor;
    }
    scale_parts(e, turn, factor);
    result->depth = e->depth;
    if (e->config->loads) {
        vxsi_hits *hits = &e->contact->hits;
        if (e->config->field == VXS_CONTACT_SURFACE) {
            if (common) turn_hits(hits, common, VXS_CONTACT_SURFACE);
            set_planes(e, 0);
        }
        vxsi_gather_loads(e->contact, e->config, e->count, factor, turn);
    }
    vxsi_rotate(turn, result->wrench.force, result->wrench.force);
    vxsi_rotate(turn, result->wrench.torque, result->wrench.torque);
    vxsi_rotate(turn, result->normal, result->normal);
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += fabs(result->wrench.force[i]) + fabs(result->wrench.torque[i]);
    if (!isfinite(sum)) {
        memset(&result->wrench, 0, sizeof result->wrench);
        result->flags |= VXS_CONTACT_INVALID;
        if (e->config->loads) e->config->loads->count = 0;
    }
}

vxs_result vxs_contact_config_check(const vxs_contact_config *config)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    if (config->law >= sizeof laws / sizeof *laws || !laws[config->law].exists) return VXS_PARAM;
    if (config->field < VXS_CONTACT_SURFACE || config->field > VXS_CONTACT_DISTANCE) return VXS_PARAM;
    if (config->weighting < VXS_CONTACT_COUNT || config->weighting > VXS_CONTACT_AREA) return VXS_PARAM;
    if (laws[config->law].is_sampled && config->field != VXS_CONTACT_DISTANCE) return VXS_LAW_FIELD;
    if (config->most_points && config->weighting != VXS_CONTACT_AREA) return VXS_PARAM;
    for (int i = 0; i < 3; i++) {
        if (!isfinite(config->reference[i])) return VXS_PARAM;
    }
    if (!isfinite(config->most_stiffness) || config->most_stiffness < 0) return VXS_PARAM;
    return isfinite(config->stiffness) && config->stiffness > 0 ? VXS_OK : VXS_PARAM;
}

int vxs_contact_has_field(const vxs_voxmap *map, uint32_t field)
{
    switch (field) {
    case VXS_CONTACT_SURFACE:
        return 1;
    case VXS_CONTACT_LAYERS:
        return map->layers != NULL;
    case VXS_CONTACT_DISTANCE:
        return map->distances && !(map->flags & VXS_VOXMAP_FLAG_UNSIGNED);
    default:
        return 0;
    }
}

/* What the probe must keep for the law and field. */
static uint32_t take_of(const vxs_contact_config *config)
{
    return (laws[config->law].is_sampled && !config->loads ? 0 : VXSI_TAKE_NORMAL) |
           (config->field == VXS_CONTACT_SURFACE ? 0 : VXSI_TAKE_INTERIOR) |
           (config->weighting == VXS_CONTACT_AREA ? VXSI_TAKE_AREA : 0);
}

/* Depths from the field's channel, and normals if the law takes them from there. */
static void sample(evaluation *e, const vxs_contact_static *statics, vxs_contact_result *result)
{
    for (uint32_t n = 0; n < e->count; n++)
        result->deep_points +=
            e->contact->kernel->sample(statics[n].map, e->config->field == VXS_CONTACT_LAYERS,
                                       e->law->is_sampled, &e->contact->statics[n].span, &e->contact->hits);
}

uint32_t vxs_contact_evaluate(vxs_contact *contact, const vxs_contact_static *statics, uint32_t count,
                              const vxs_pose *pose, const vxs_contact_config *config,
                              vxs_contact_result *result)
{
    memset(result, 0, sizeof *result);
    evaluation e = {.contact = contact, .config = config, .count = count};
    double turn[9];
    if (vxs_contact_config_check(config) != VXS_OK) return result->flags = VXS_CONTACT_INVALID;
    e.law = &laws[config->law];
    if (config->loads) config->loads->count = 0;
    if (count > contact->static_capacity || (config->most_points && !contact->has_levels) ||
        (config->weighting == VXS_CONTACT_AREA && !contact->shell.area) || !vxs_pose_rotation(pose, turn))
        return result->flags = VXS_CONTACT_INVALID;
    vxsi_hits *hits = &contact->hits;
    hits->count = hits->deep_count = hits->overflow = 0;
    if (contact->parts) memset(contact->parts, 0, count * sizeof *contact->parts);
    hits->take = take_of(config);
    contact->probed = contact->wrong_skips = 0;
    contact->by_quarters = config->most_points == 0; /* levels of detail are of whole clusters */
    int is_near = 0;
    for (uint32_t n = 0; n < count; n++) {
        vxsi_placement place;
        if (!vxs_contact_has_field(statics[n].map, config->field) ||
            !place_shell(&statics[n], turn, pose, &place))
            return result->flags = VXS_CONTACT_INVALID;
        is_near |= approach(contact, &contact->statics[n], statics[n].map, &place);
    }
    if (!is_near) result->flags |= VXS_CONTACT_OUT_OF_MAP;
    if (!vxsi_contact_look(contact, statics, count, config->most_points))
        result->flags |= VXS_CONTACT_OVER_BUDGET;
    if (hits->overflow) result->flags |= VXS_CONTACT_OVERFLOW;
    if (contact->wrong_skips) result->flags |= VXS_CONTACT_WRONG_SKIP;
    result->probed = contact->probed;
    result->level = contact->level;
    result->deep_points = hits->deep_count;
    if (config->loads) vxsi_name_directions(hits);
    if (config->field != VXS_CONTACT_SURFACE) sample(&e, statics, result);
    if (result->deep_points > 0) result->flags |= VXS_CONTACT_DEEP;

    const int has_mean = mean_normal(&e, result->normal);
    if (e.touching == 0) return result->flags;
    result->points = (uint32_t)e.touching;
    result->patches = 1;
    int is_common = e.law->is_common && has_mean;
    if (e.law->splits == ALWAYS || (e.law->splits == WITHOUT_MEAN && !has_mean)) {
        if (e.law->splits == WITHOUT_MEAN) result->flags |= VXS_CONTACT_MEAN_CANCELLED;
        result->patches = vxsi_split_patches(hits, config->field);
        is_common = result->patches == 1;
    }
    const double *common = is_common ? result->normal : NULL;
    if (config->field != VXS_CONTACT_SURFACE) {
        if (common) turn_hits(hits, common, config->field);
        if (config->field == VXS_CONTACT_LAYERS) set_planes(&e, 1);
        add_own(&e);
    } else if (common) {
        add_common(&e, common);
    } else {
        add_own(&e);
    }
    give_wrench(&e, turn, common, result);
    return result->flags;
}
