/* SPDX-License-Identifier: MIT
 *
 * Levels of detail of a shell, made at set-up: level 1 has a point for four neighbouring ones of a cluster,
 * level 2 for sixteen, level 3 one for the cluster. Each is a point of the shell, with the area of those that
 * it stands for, so that every level has the shell's area in every cluster.
 */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */

#include "contact_state.h"

#include <float.h>
#include <math.h>
#include <string.h>
#include <time.h>

enum { ARRAYS = 7, ALIGNMENT = 64, MOST = VXS_POINTSHELL_CLUSTER_POINTS, GROUP = 4 };

static size_t array_bytes(const vxs_pointshell *shell, int level)
{
    size_t count = ((size_t)shell->cluster_count * MOST >> (2 * level)) + VXSI_LANES;
    return (count * sizeof(float) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

size_t vxs_contact_levels_memory(const vxs_pointshell *shell)
{
    size_t size = 0;
    for (int level = 1; shell && level <= VXSI_LEVELS; level++) size += ARRAYS * array_bytes(shell, level);
    return size;
}

static const float *axis_of(const vxs_pointshell *shell, int axis)
{
    return axis == 0 ? shell->x : axis == 1 ? shell->y : shell->z;
}

/* Halves the points along the longest side of their box until four are left: in the end each four in a row
 * are neighbours, and so are each sixteen. Of equal coordinates the lower point comes first. */
static void halve(const vxs_pointshell *shell, uint32_t *points, uint32_t count)
{
    if (count <= GROUP) return;
    int longest = 0;
    float side = -1;
    for (int axis = 0; axis < 3; axis++) {
        const float *at = axis_of(shell, axis);
        float low = at[points[0]], high = low;
        for (uint32_t n = 1; n < count; n++) {
            low = fminf(low, at[points[n]]);
            high = fmaxf(high, at[points[n]]);
        }
        if (high - low > side) {
            side = high - low;
            longest = axis;
        }
    }
    const float *at = axis_of(shell, longest);
    for (uint32_t n = 1; n < count; n++) { /* at most 64 */
        uint32_t point = points[n], to = n;
        for (; to > 0; to--) {
            uint32_t before = points[to - 1];
            if (at[before] < at[point] || (!(at[before] > at[point]) && before < point)) break;
            points[to] = before;
        }
        points[to] = point;
    }
    uint32_t half = GROUP;
    while (2 * half < count) half *= 2;
    halve(shell, points, half);
    halve(shell, points + half, count - half);
}

/* The one of `candidates` that is nearest to the middle of the points, by area. */
static uint32_t middle_one(const vxs_pointshell *shell, const uint32_t *points, uint32_t count,
                           const uint32_t *candidates, uint32_t candidate_count)
{
    double sum[3] = {0, 0, 0}, area = 0;
    for (uint32_t n = 0; n < count; n++) {
        double own = (double)shell->area[points[n]] + 1e-30;
        for (int axis = 0; axis < 3; axis++) sum[axis] += own * (double)axis_of(shell, axis)[points[n]];
        area += own;
    }
    uint32_t best = candidates[0];
    double least = INFINITY;
    for (uint32_t n = 0; n < candidate_count; n++) {
        double square = 0;
        for (int axis = 0; axis < 3; axis++) {
            double away = (double)axis_of(shell, axis)[candidates[n]] - sum[axis] / area;
            square += away * away;
        }
        if (square < least) {
            least = square;
            best = candidates[n];
        }
    }
    return best;
}

/* Writes point `from` of the shell as point `to` of the level. */
static void put(const vxs_pointshell *shell, float *const arrays[ARRAYS], uint32_t to, uint32_t from,
                double area)
{
    const float *const sources[ARRAYS] = {shell->x,  shell->y,  shell->z, shell->nx,
                                          shell->ny, shell->nz, NULL};
    for (int n = 0; n < ARRAYS; n++) arrays[n][to] = sources[n] ? sources[n][from] : (float)area;
}

static void fill_cluster(const vxs_pointshell *shell, uint32_t cluster,
                         float *arrays[VXSI_LEVELS + 1][ARRAYS])
{
    uint32_t points[MOST], chosen[MOST], count = shell->clusters[cluster].count;
    for (uint32_t n = 0; n < count; n++) points[n] = shell->clusters[cluster].first + n;
    halve(shell, points, count);
    memcpy(chosen, points, sizeof chosen);
    uint32_t candidates = count; /* of the level below, GROUP of them for each of this one */
    for (uint32_t level = 1; level <= VXSI_LEVELS; level++) {
        uint32_t size = 1u << (2 * level), groups = (count + size - 1) / size;
        for (uint32_t group = 0; group < groups; group++) {
            uint32_t first = group * size, last = first + size < count ? first + size : count;
            uint32_t low = group * GROUP, high = low + GROUP < candidates ? low + GROUP : candidates;
            uint32_t own = middle_one(shell, points + first, last - first, chosen + low, high - low);
            double area = 0;
            for (uint32_t n = first; n < last; n++) area += (double)shell->area[points[n]];
            if (area > (double)FLT_MAX) area = (double)FLT_MAX; /* no infinity, times depth 0 that is NaN */
            put(shell, arrays[level], (cluster * MOST >> (2 * level)) + group, own, area);
            chosen[group] = own;
        }
        candidates = groups;
    }
}

vxs_result vxs_contact_add_levels(vxs_contact *contact, void *memory, size_t size)
{
    if (!contact || !memory) return VXS_PARAM;
    const vxs_pointshell *shell = &contact->shell;
    if (!shell->area) return VXS_NO_AREA;
    if ((uintptr_t)memory % 16 != 0 || size < vxs_contact_levels_memory(shell)) return VXS_BUFFER;
    memset(memory, 0, vxs_contact_levels_memory(shell));
    float *arrays[VXSI_LEVELS + 1][ARRAYS];
    uint8_t *next = memory;
    for (int level = 1; level <= VXSI_LEVELS; level++) {
        for (int n = 0; n < ARRAYS; n++, next += array_bytes(shell, level))
            arrays[level][n] = (float *)(void *)next;
        vxs_pointshell *view = &contact->levels[level];
        *view = *shell;
        view->point_count = ((shell->cluster_count - 1) * MOST >> (2 * level)) +
                            ((shell->clusters[shell->cluster_count - 1].count - 1) >> (2 * level)) + 1;
        view->x = arrays[level][0];
        view->y = arrays[level][1];
        view->z = arrays[level][2];
        view->nx = arrays[level][3];
        view->ny = arrays[level][4];
        view->nz = arrays[level][5];
        view->area = arrays[level][6];
    }
    for (uint32_t cluster = 0; cluster < shell->cluster_count; cluster++)
        fill_cluster(shell, cluster, arrays);
    contact->has_levels = 1;
    return VXS_OK;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A map of one chunk in which every cell is surface, and the shell laid into it: every point is a hit. */
double vxs_contact_point_cost(vxs_contact *contact)
{
    static const uint32_t root[1] = {VXS_VOXMAP_ENTRY_FIRST};
    uint64_t brick[VXS_VOXMAP_BRICK_WORDS];
    uint32_t chunk[VXS_VOXMAP_CHUNK_ENTRIES];
    for (int n = 0; n < VXS_VOXMAP_BRICK_WORDS; n++) brick[n] = 0x5555555555555555u;
    for (int n = 0; n < VXS_VOXMAP_CHUNK_ENTRIES; n++) chunk[n] = VXS_VOXMAP_ENTRY_FIRST;
    const vxs_voxmap map = {.voxel = 1,
                            .cells = {VXS_VOXMAP_CHUNK_CELLS, VXS_VOXMAP_CHUNK_CELLS, VXS_VOXMAP_CHUNK_CELLS},
                            .root_dims = {1, 1, 1},
                            .root = root,
                            .chunks = chunk,
                            .bricks = brick,
                            .chunk_count = 1,
                            .brick_count = 1};
    const vxs_pointshell *shell = &contact->shell;
    vxsi_motion motion = {.margin = 0};
    const double scale = 24 / (shell->radius + 1e-12);
    for (int i = 0; i < 3; i++) {
        motion.m[4 * i] = (float)scale;
        motion.b[i] = (float)(32 - scale * shell->center[i]);
    }
    vxsi_hits *hits = &contact->hits;
    vxsi_static *all = contact->statics;
    vxsi_contact_list_all(contact, all);
    double least = INFINITY;
    for (int round = 0; round < 7; round++) {
        double sum[3], count, begin = now();
        vxsi_total total;
        hits->count = hits->deep_count = hits->overflow = 0;
        hits->take = VXSI_TAKE_NORMAL | (shell->area ? VXSI_TAKE_AREA : 0);
        contact->kernel->probe(&map, shell, &motion, all->looks, all->look_count, hits);
        vxsi_span span = {.last = hits->count,
                          .has_area = shell->area != NULL,
                          .voxel = 1,
                          .rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
        contact->kernel->mean(hits, &span, 0, sum, &count);
        contact->kernel->sum_common(hits, &span, sum, &total);
        double each = (now() - begin) / shell->point_count;
        if (each < least) least = each;
    }
    return least;
}
