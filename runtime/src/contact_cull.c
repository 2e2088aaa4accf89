/* SPDX-License-Identifier: MIT
 *
 * Which points are worth a look. Two levels of bounding spheres against the map's clearance, and
 * time: a sphere that could grow by s cells and still be free cannot touch anything before the shell has
 * moved by s. Every skipped point is provably in a free cell (or, told apart, in an interior one), so the
 * wrench does not depend on any of this. rt-safe.
 */
#include "contact_state.h"

#include <math.h>

static void motion_of(const vxs_voxmap *map, const vxs_pointshell *shell, const vxsi_placement *place,
                      vxsi_motion *motion)
{
    for (int i = 0; i < 9; i++) motion->m[i] = (float)(place->rotation[i] / map->voxel);
    double size = shell->radius;
    for (int i = 0; i < 3; i++) {
        motion->b[i] = (float)(place->offset[i] / map->voxel);
        size += fabs(shell->center[i]) + fabs(place->offset[i]);
    }
    motion->scale = (float)((1 + 0x1p-20) / map->voxel);
    /* A rounded u is wrong by at most 8 units of 2^-24 of the largest sum per axis: twice that, times the
     * diagonal, for a sphere's centre and a point together; and a little for `travel`. */
    motion->margin = (float)(size / map->voxel * 0x1p-18 + 0x1p-9);
}

/* Bounds in cells how far any point of the shell is from where it was. */
static double moved(const vxs_voxmap *map, const vxs_pointshell *shell, const vxsi_placement *from,
                    const vxsi_placement *to)
{
    double turned = 0, way = 0;
    for (int row = 0; row < 3; row++) {
        double step = to->offset[row] - from->offset[row];
        for (int i = 0; i < 3; i++) {
            double change = to->rotation[3 * row + i] - from->rotation[3 * row + i];
            turned += change * change;
            step += change * shell->center[i];
        }
        way += step * step;
    }
    return (sqrt(way) + sqrt(turned) * shell->radius) / map->voxel;
}

static void forget(const vxs_contact *contact, vxsi_static *s)
{
    s->travel = 0;
    for (uint32_t n = 0; n < contact->clusters.count; n++) s->due[n] = -INFINITY;
    for (uint32_t n = 0; n < contact->groups.count; n++) s->group_due[n] = -INFINITY;
}

static void advance(const vxs_contact *contact, vxsi_static *s, const vxs_voxmap *map,
                    const vxsi_placement *place)
{
    /* Beyond this many cells at once, or in all, sums would lose what the margin allows for. */
    static const double far = 1 << 20;
    double step = s->root == map->root ? moved(map, &contact->shell, &s->place, place) : INFINITY;
    s->travel += step * (1 + 0x1p-30) + 0x1p-32;
    if (!(s->travel < far)) forget(contact, s);
    s->root = map->root;
    s->place = *place;
}

enum {
    CLUSTER_QUARTERS = VXS_POINTSHELL_CLUSTER_POINTS / VXSI_QUARTER,
    GROUP_QUARTERS = VXSI_GROUP_CLUSTERS * CLUSTER_QUARTERS
};

/* Points of quarters first .. last - 1. */
static uint32_t points_of(const vxs_pointshell *shell, uint32_t first, uint32_t last, uint32_t *begin)
{
    uint32_t end = last * VXSI_QUARTER;
    *begin = first * VXSI_QUARTER;
    return (end < shell->point_count ? end : shell->point_count) - *begin;
}

/* Quarters first .. last - 1 must be looked at. */
static void want(vxs_contact *contact, const vxsi_static *s, uint32_t first, uint32_t last)
{
    vxsi_run *run = contact->runs + contact->run_count;
    contact->wanted_quarters += last - first;
    if (contact->run_count > s->run_first && run[-1].last == first) {
        run[-1].last = last;
        return;
    }
    *run = (vxsi_run){first, last};
    contact->run_count++;
}

typedef struct walk {
    vxs_contact *contact;
    vxsi_static *s;
    const vxs_voxmap *map;
    double need; /* a part that is due later than this stays free in this evaluation */
    int is_coherent;
} walk;

static uint32_t lowest(uint64_t bits)
{
    return (uint32_t)__builtin_ctzll(bits);
}

static uint64_t first_bits(uint32_t count)
{
    return count < VXSI_BATCH ? (UINT64_C(1) << count) - 1 : ~UINT64_C(0);
}

/* The points of quarters first .. last - 1 are passed over: free, or interior. */
static void skip(walk *w, uint32_t first, uint32_t last, int is_deep)
{
    vxs_contact *contact = w->contact;
    uint32_t begin, count = points_of(&contact->shell, first, last, &begin);
    if (is_deep) contact->hits.deep_count += count;
    if (contact->culling != VXS_CONTACT_CHECKED) return;
    vxsi_hits found = {.capacity = 0};
    vxsi_probe_scalar(w->map, &contact->shell, &w->s->motion, begin, begin + count, &found);
    if (found.overflow || found.deep_count != (is_deep ? count : 0)) contact->wrong_skips++;
}

/* Of the up to 64 parts with these due times, those that need a test. */
static uint64_t wanted_of(const walk *w, const double *due, uint32_t count)
{
    if (!w->is_coherent) return first_bits(count);
    uint64_t wanted = 0;
    for (uint32_t n = 0; n < count; n++) wanted |= (uint64_t) !(due[n] >= w->need) << n;
    return wanted;
}

/* Judges those that are wanted and says when they are due again. Returns which must be looked at. */
static uint64_t judge(walk *w, const vxsi_spheres *spheres, uint32_t first, uint64_t wanted, double *due,
                      vxsi_verdict *verdict)
{
    if (!wanted) return 0;
    w->contact->kernel->cull(w->map, spheres, first, wanted, &w->s->motion, verdict);
    verdict->is_free &= wanted;
    verdict->is_deep &= w->contact->hits.take & VXSI_TAKE_INTERIOR ? 0 : wanted;
    uint64_t left = wanted & ~verdict->is_free;
    if (w->is_coherent) {
        for (uint64_t bits = verdict->is_free; bits; bits &= bits - 1)
            due[lowest(bits)] = w->s->travel + (double)verdict->slack[lowest(bits)];
        for (uint64_t bits = left; bits; bits &= bits - 1) due[lowest(bits)] = -INFINITY;
    }
    return left & ~verdict->is_deep;
}

/* Each bit four times. */
static uint64_t spread(uint64_t bits)
{
    bits = (bits | bits << 24) & 0x000000FF000000FFu;
    bits = (bits | bits << 12) & 0x000F000F000F000Fu;
    bits = (bits | bits << 6) & 0x0303030303030303u;
    bits = (bits | bits << 3) & 0x1111111111111111u;
    return bits * 0xFu;
}

/* Of the clusters of a group, those in `must`: what of them must be looked at. */
static void walk_quarters(walk *w, uint32_t first_cluster, uint64_t must)
{
    enum { AT_ONCE = VXSI_BATCH / CLUSTER_QUARTERS };
    vxs_contact *contact = w->contact;
    for (uint32_t n = 0; n < VXSI_BATCH; n += AT_ONCE) {
        const uint32_t base = (first_cluster + n) * CLUSTER_QUARTERS;
        uint64_t wanted = spread(must >> n & first_bits(AT_ONCE));
        if (!wanted) continue;
        wanted &= first_bits(contact->quarters.count - base);
        if (contact->by_quarters && w->map->planes) {
            uint64_t clear = contact->kernel->clear(w->map, &contact->quarters, base, wanted, &w->s->motion);
            wanted &= ~clear;
            if (contact->culling == VXS_CONTACT_CHECKED) {
                for (; clear; clear &= clear - 1) skip(w, base + lowest(clear), base + lowest(clear) + 1, 0);
            }
        }
        while (wanted) { /* runs of quarters */
            uint32_t first = lowest(wanted),
                     length = ~(wanted >> first) ? lowest(~(wanted >> first)) : VXSI_BATCH;
            want(contact, w->s, base + first, base + first + length);
            wanted &= ~(first_bits(length) << first);
        }
    }
}

static void walk_group(walk *w, uint32_t group)
{
    const vxsi_spheres *clusters = &w->contact->clusters;
    uint32_t base = group * VXSI_GROUP_CLUSTERS, count = clusters->count - base;
    if (count > VXSI_GROUP_CLUSTERS) count = VXSI_GROUP_CLUSTERS;
    double *due = w->s->due + base;
    vxsi_verdict verdict = {.is_deep = 0};
    uint64_t must = judge(w, clusters, base, wanted_of(w, due, count), due, &verdict);
    if (verdict.is_deep || w->contact->culling == VXS_CONTACT_CHECKED) {
        for (uint64_t bits = first_bits(count) & ~must; bits; bits &= bits - 1) {
            uint32_t first = (base + lowest(bits)) * CLUSTER_QUARTERS;
            skip(w, first, first + CLUSTER_QUARTERS, (int)(verdict.is_deep >> lowest(bits) & 1u));
        }
    }
    walk_quarters(w, base, must);
    if (w->is_coherent) {
        double least = INFINITY;
        for (uint32_t n = 0; n < count; n++) least = due[n] < least ? due[n] : least;
        w->s->group_due[group] = least;
    }
}

static void walk_groups(walk *w)
{
    const vxsi_spheres *groups = &w->contact->groups;
    for (uint32_t base = 0; base < groups->count; base += VXSI_BATCH) {
        uint32_t count = groups->count - base;
        if (count > VXSI_BATCH) count = VXSI_BATCH;
        double *due = w->s->group_due + base;
        vxsi_verdict verdict = {.is_deep = 0};
        uint64_t must = judge(w, groups, base, wanted_of(w, due, count), due, &verdict),
                 told = must | verdict.is_deep;
        if (w->contact->culling == VXS_CONTACT_CHECKED) told = first_bits(count);
        for (; told; told &= told - 1) { /* in order: so are the points found */
            uint32_t n = lowest(told), first = (base + n) * GROUP_QUARTERS;
            if (must >> n & 1u)
                walk_group(w, base + n);
            else
                skip(w, first, first + GROUP_QUARTERS, (int)(verdict.is_deep >> n & 1u));
        }
    }
}

void vxsi_contact_walk(vxs_contact *contact, vxsi_static *s, const vxs_voxmap *map,
                       const vxsi_placement *place)
{
    walk w = {.contact = contact, .s = s, .map = map};
    motion_of(map, &contact->shell, place, &s->motion);
    if (contact->culling == VXS_CONTACT_BRUTE || !map->clearance_index) {
        want(contact, s, 0, contact->quarters.count);
        return;
    }
    w.is_coherent = contact->culling != VXS_CONTACT_CULLED;
    if (w.is_coherent) advance(contact, s, map, place);
    w.need = s->travel + (double)s->motion.margin;
    walk_groups(&w);
}

/* Quarters first .. last - 1 at one level of detail. */
static void look(vxs_contact *contact, const vxs_voxmap *map, const vxsi_motion *motion, uint32_t level,
                 uint32_t first, uint32_t last)
{
    if (first == last) return;
    const vxs_pointshell *shell = level ? &contact->levels[level] : &contact->shell;
    uint32_t begin = first * VXSI_QUARTER >> (2 * level), end = last * VXSI_QUARTER >> (2 * level);
    if (last == contact->quarters.count) end = shell->point_count;
    contact->probed += end - begin;
    contact->kernel->probe(map, shell, motion, begin, end, &contact->hits);
    if (level > contact->level) contact->level = level;
}

int vxsi_contact_look(vxs_contact *contact, const vxs_contact_static *statics, uint32_t count,
                      uint32_t most_points)
{
    /* So many clusters at the coarser of two levels, the others at the finer one, that the points are few
     * enough: one cluster more in contact changes the level of one or two, and the force hardly. */
    uint64_t most = most_points ? most_points : UINT64_MAX,
             clusters = (contact->wanted_quarters + CLUSTER_QUARTERS - 1) / CLUSTER_QUARTERS;
    uint32_t fine = 0, coarse_quarters = 0;
    while (fine < VXSI_LEVELS && clusters * (VXS_POINTSHELL_CLUSTER_POINTS >> (2 * (fine + 1))) > most)
        fine++;
    if (fine < VXSI_LEVELS) {
        uint64_t each = VXS_POINTSHELL_CLUSTER_POINTS >> (2 * fine), excess = clusters * each;
        excess = excess > most ? excess - most : 0;
        coarse_quarters = (uint32_t)((excess + each - each / 4 - 1) / (each - each / 4)) * CLUSTER_QUARTERS;
    }
    contact->level = 0;
    for (uint32_t n = 0; n < count; n++) {
        vxsi_static *s = &contact->statics[n];
        s->span.first = contact->hits.count;
        contact->hits.chunk = (vxsi_chunk){{UINT32_MAX, UINT32_MAX, UINT32_MAX}, VXS_CELL_FREE};
        for (uint32_t r = s->run_first; r < s->run_last; r++) {
            vxsi_run run = contact->runs[r];
            uint32_t coarse = run.last - run.first < coarse_quarters ? run.last - run.first : coarse_quarters;
            look(contact, statics[n].map, &s->motion, fine + 1, run.first, run.first + coarse);
            look(contact, statics[n].map, &s->motion, fine, run.first + coarse, run.last);
            coarse_quarters -= coarse;
        }
        s->span.last = contact->hits.count;
    }
    return contact->probed <= most;
}
