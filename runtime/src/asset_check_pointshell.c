/* SPDX-License-Identifier: MIT
 *
 * The rules of formats/pointshell.md, in the order of their ids. Linear time, no memory. Pure.
 */
#include "asset_check.h"
#include "voxshell/format/pointshell.h"

#include <math.h>
#include <string.h>

enum { SHEL, POSX, POSY, POSZ, NRMX, NRMY, NRMZ, AREA, CLUS, KNOWN };

static const struct {
    uint32_t id, stride;
} layout[KNOWN] = {
    {VXS_POINTSHELL_SECTION_SHEL, sizeof(vxs_pointshell_info)},
    {VXS_POINTSHELL_SECTION_POSX, 4},
    {VXS_POINTSHELL_SECTION_POSY, 4},
    {VXS_POINTSHELL_SECTION_POSZ, 4},
    {VXS_POINTSHELL_SECTION_NRMX, 4},
    {VXS_POINTSHELL_SECTION_NRMY, 4},
    {VXS_POINTSHELL_SECTION_NRMZ, 4},
    {VXS_POINTSHELL_SECTION_AREA, 4},
    {VXS_POINTSHELL_SECTION_CLUS, sizeof(vxs_pointshell_cluster)},
};

static const double max_coordinate = VXS_POINTSHELL_MAX_COORDINATE, max_radius = 1e16;

typedef struct shell_check {
    vxsi_check *check;
    const vxs_container_section *section[KNOWN];
    const vxs_pointshell_info *info;
    const float *array[KNOWN]; /* POSX .. AREA; NULL for AREA where there is none */
    const vxs_pointshell_cluster *clusters;
} shell_check;

static vxs_result refuse_at(const shell_check *s, const char *rule, int which, uint64_t offset,
                            const char *text)
{
    return vxsi_refuse(s->check, VXS_CORRUPT, rule, layout[which].id, s->section[which]->offset + offset,
                       text);
}

static vxs_result check_sections(shell_check *s)
{
    const vxs_container_section *table = vxsi_table(s->check->data);
    const vxs_container_header *header = (const vxs_container_header *)(const void *)s->check->data;
    const int no_area = (header->required_features & VXS_POINTSHELL_FEATURE_NO_AREA) != 0;
    int next = 0;
    for (int n = 0; n < KNOWN; n++) {
        if (n == AREA && no_area) continue;
        const vxs_container_section *entry = &table[next++];
        if (entry->id != layout[n].id) /* META is last, so a table that is too short fails here */
            return vxsi_refuse_entry(s->check, VXS_CORRUPT, "S101", entry, "not SHEL .. CLUS in order");
        s->section[n] = entry;
    }
    for (int n = 0; n < KNOWN; n++) {
        const vxs_container_section *entry = s->section[n];
        if (entry && (entry->stride != layout[n].stride || (n == SHEL && entry->count != 1)))
            return vxsi_refuse_entry(s->check, VXS_CORRUPT, "S102", entry, "wrong stride, or not one SHEL");
    }
    const vxs_container_section *area = vxsi_find_section(s->check->data, layout[AREA].id);
    if (no_area && area)
        return vxsi_refuse_entry(s->check, VXS_CORRUPT, "S103", area, "areas in a shell that has none");
    return VXS_OK;
}

#define FIELD(name) offsetof(vxs_pointshell_info, name)

static int not_negative(double value)
{
    return isfinite(value) && value >= 0;
}

static vxs_result refuse_info(const shell_check *s, const char *rule, size_t field, const char *text)
{
    return refuse_at(s, rule, SHEL, field, text);
}

static vxs_result check_measures(const shell_check *s)
{
    static const struct {
        size_t field;
        const char *text;
    } measures[] = {
        {FIELD(area), "area is not finite, or negative"},
        {FIELD(gap_max), "gap_max is not finite, or negative"},
        {FIELD(surface_error), "surface_error is not finite, or negative"},
        {FIELD(center), NULL},
        {FIELD(radius), "radius is not finite, or negative"},
    };
    for (size_t n = 0; n < sizeof measures / sizeof *measures; n++) {
        double value;
        memcpy(&value, (const uint8_t *)s->info + measures[n].field, sizeof value);
        if (measures[n].text && !not_negative(value))
            return refuse_info(s, "S207", measures[n].field, measures[n].text);
        for (size_t axis = 0; axis < 3 && !measures[n].text; axis++) {
            if (!(fabs(s->info->center[axis]) <= max_coordinate))
                return refuse_info(s, "S207", FIELD(center) + 8 * axis,
                                   "center is not finite, or beyond 1e15 m");
        }
    }
    return VXS_OK;
}

static vxs_result check_info(const shell_check *s)
{
    const vxs_pointshell_info *info = s->info;
    if (!(info->voxel >= 1e-12 && info->voxel <= 1e3))
        return refuse_info(s, "S201", FIELD(voxel), "voxel is not within 1e-12 .. 1e3 m");
    if (info->kind != VXS_POINTSHELL_EXACT && info->kind != VXS_POINTSHELL_NAIVE)
        return refuse_info(s, "S202", FIELD(kind), "kind is neither exact nor naive");
    if (info->point_count < 1 || info->point_count > VXS_POINTSHELL_MAX_POINTS) {
        refuse_info(s, "S203", FIELD(point_count), "point_count is not within 1 .. 2^28");
        return VXS_LIMIT;
    }
    const uint32_t lanes = VXS_POINTSHELL_LANES, run = VXS_POINTSHELL_CLUSTER_POINTS;
    if (info->padded_count != (info->point_count + lanes - 1) / lanes * lanes)
        return refuse_info(s, "S204", FIELD(padded_count), "not point_count rounded up to 16");
    if (info->cluster_count != (info->point_count + run - 1) / run)
        return refuse_info(s, "S205", FIELD(cluster_count), "not point_count / 64 rounded up");
    for (int n = POSX; n < KNOWN; n++) {
        if (s->section[n] && s->section[n]->count != (n == CLUS ? info->cluster_count : info->padded_count))
            return vxsi_refuse_entry(s->check, VXS_CORRUPT, "S206", s->section[n],
                                     "wrong number of elements");
    }
    vxs_result result = check_measures(s);
    if (result != VXS_OK) return result;
    for (size_t i = 0; i < sizeof info->pad; i++) {
        if (info->pad[i] != 0) return refuse_info(s, "S208", FIELD(pad) + i, "padding is not 0");
    }
    if (info->surface_cells < 1 || info->surface_cells > info->point_count)
        return refuse_info(s, "S209", FIELD(surface_cells), "not within 1 .. point_count");
    return VXS_OK;
}

static vxs_result check_points(const shell_check *s)
{
    uint64_t count = s->info->point_count;
    for (uint64_t p = 0; p < count; p++) {
        for (int axis = POSX; axis <= POSZ; axis++) {
            if (!(fabs((double)s->array[axis][p]) <= max_coordinate))
                return refuse_at(s, "S301", axis, 4 * p, "a position is not finite, or beyond 1e15 m");
        }
    }
    for (uint64_t p = 0; p < count; p++) {
        double x = s->array[NRMX][p], y = s->array[NRMY][p], z = s->array[NRMZ][p];
        if (!(fabs(((x * x + y * y) + z * z) - 1) <= 1e-6))
            return refuse_at(s, "S302", NRMX, 4 * p, "a normal is not of length 1");
    }
    for (uint64_t p = 0; p < count && s->array[AREA]; p++) {
        float area = s->array[AREA][p];
        if (!not_negative(area) || signbit(area))
            return refuse_at(s, "S303", AREA, 4 * p, "an area is not finite, or negative");
    }
    double sum = 0;
    for (uint64_t p = 0; p < count && s->array[AREA]; p++) sum += s->array[AREA][p];
    if (s->array[AREA] && !(fabs(sum - s->info->area) <= 1e-6 * s->info->area))
        return refuse_info(s, "S304", FIELD(area), "not the sum of the areas");
    for (int n = POSX; n <= AREA && s->array[n]; n++) {
        float last = n == AREA ? 0.0f : s->array[n][count - 1];
        for (uint64_t p = count; p < s->info->padded_count; p++) {
            if (memcmp(&s->array[n][p], &last, sizeof last) != 0)
                return refuse_at(s, "S305", n, 4 * p, "padding does not repeat the last point with area 0");
        }
    }
    return VXS_OK;
}

static int is_within(const shell_check *s, uint64_t point, const double center[3], double radius)
{
    double dx = s->array[POSX][point] - center[0];
    double dy = s->array[POSY][point] - center[1];
    double dz = s->array[POSZ][point] - center[2];
    return (dx * dx + dy * dy) + dz * dz <= radius * radius;
}

static vxs_result check_cluster(const shell_check *s, uint64_t number)
{
    const vxs_pointshell_cluster *cluster = &s->clusters[number];
    uint64_t first = number * VXS_POINTSHELL_CLUSTER_POINTS, left = s->info->point_count - first;
#define REFUSE(rule, field, text) return refuse_at(s, rule, CLUS, number * sizeof *cluster + (field), text)
    if (cluster->first != first)
        REFUSE("S401", offsetof(vxs_pointshell_cluster, first), "first is not 64 x the cluster's number");
    if (cluster->count != (left < VXS_POINTSHELL_CLUSTER_POINTS ? left : VXS_POINTSHELL_CLUSTER_POINTS))
        REFUSE("S401", offsetof(vxs_pointshell_cluster, count), "count is neither 64 nor what is left");
    double center[3];
    for (size_t axis = 0; axis < 3; axis++) {
        center[axis] = cluster->center[axis];
        if (!(fabs(center[axis]) <= max_coordinate))
            REFUSE("S402", 4 * axis, "center is not finite, or beyond 1e15 m");
    }
    if (!(cluster->radius >= 0 && cluster->radius <= max_radius))
        REFUSE("S402", offsetof(vxs_pointshell_cluster, radius), "radius is not within 0 .. 1e16 m");
    if (cluster->reserved[0] != 0 || cluster->reserved[1] != 0)
        REFUSE("S403", offsetof(vxs_pointshell_cluster, reserved), "a reserved field is not 0");
#undef REFUSE
    for (uint32_t p = 0; p < cluster->count; p++) {
        if (!is_within(s, first + p, center, cluster->radius))
            return refuse_at(s, "S404", POSX, 4 * (first + p), "a point is outside its cluster's sphere");
    }
    return VXS_OK;
}

static vxs_result check_spheres(const shell_check *s)
{
    for (uint64_t number = 0; number < s->info->cluster_count; number++) {
        vxs_result result = check_cluster(s, number);
        if (result != VXS_OK) return result;
    }
    for (uint64_t p = 0; p < s->info->point_count; p++) {
        if (!is_within(s, p, s->info->center, s->info->radius))
            return refuse_at(s, "S405", POSX, 4 * p, "a point is outside the sphere of all points");
    }
    return VXS_OK;
}

vxs_result vxsi_check_pointshell(vxsi_check *check)
{
    shell_check s = {.check = check};
    vxs_result result = check_sections(&s);
    if (result != VXS_OK) return result;
    s.info = (const vxs_pointshell_info *)(const void *)(check->data + s.section[SHEL]->offset);
    for (int n = POSX; n <= AREA && s.section[n]; n++)
        s.array[n] = (const float *)(const void *)(check->data + s.section[n]->offset);
    s.clusters = (const vxs_pointshell_cluster *)(const void *)(check->data + s.section[CLUS]->offset);
    result = check_info(&s);
    if (check->trusted) return result;
    if (result == VXS_OK) result = check_points(&s);
    if (result == VXS_OK) result = check_spheres(&s);
    return result;
}
