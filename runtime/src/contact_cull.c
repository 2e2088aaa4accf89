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
    for (uint32_t n = 0; n < contact->groups.count; n++) {
        s->group_due[n] = -INFINITY;
        for (uint32_t k = 0; k < VXSI_GROUP_RUNS; k++) s->due[VXSI_GROUP_RUNS * n + k] = -INFINITY;
    }
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
    const uint32_t all = contact->shell.point_count, begin = first * VXSI_QUARTER,
                   end = last * VXSI_QUARTER < all ? last * VXSI_QUARTER : all;
    if (is_deep) contact->hits.deep_count += end - begin;
    if (contact->culling != VXS_CONTACT_CHECKED) return;
    vxsi_hits found = {.capacity = 0};
    for (uint32_t n = begin; n < end; n += VXSI_LANES) {
        const vxsi_block block = {n, (uint32_t)first_bits(end - n) & (uint32_t)first_bits(VXSI_LANES)};
        vxsi_probe_scalar(w->map, &contact->shell, &w->s->motion, &block, 1, &found);
    }
    if (found.overflow || found.deep_count != (is_deep ? end - begin : 0)) contact->wrong_skips++;
}

/* Judges those that are wanted. Returns which must be looked at. */
static uint64_t judge(walk *w, const vxsi_spheres *spheres, uint32_t first, uint64_t wanted,
                      vxsi_verdict *verdict)
{
    verdict->is_free = verdict->is_deep = 0;
    if (!wanted) return 0;
    w->contact->kernel->cull(w->map, spheres, first, wanted, &w->s->motion, verdict);
    verdict->is_free &= wanted;
    verdict->is_deep &= w->contact->hits.take & VXSI_TAKE_INTERIOR ? 0 : wanted;
    return wanted & ~(verdict->is_free | verdict->is_deep);
}

/* When the first of the judged spheres first .. first + count - 1 can matter again. */
static double due_of(const walk *w, const vxsi_verdict *verdict, uint32_t first, uint32_t count)
{
    if (~verdict->is_free >> first & first_bits(count)) return -INFINITY;
    float least = INFINITY;
    for (uint32_t n = first; n < first + count; n++)
        least = verdict->slack[n] < least ? verdict->slack[n] : least;
    return w->s->travel + (double)least;
}

/* Each of the lowest sixteen bits four times. */
static uint64_t spread(uint64_t bits)
{
    bits = (bits | bits << 24) & 0x000000FF000000FFu;
    bits = (bits | bits << 12) & 0x000F000F000F000Fu;
    bits = (bits | bits << 6) & 0x0303030303030303u;
    bits = (bits | bits << 3) & 0x1111111111111111u;
    return bits * 0xFu;
}

/* Of the clusters of a group, those in `must` are near. Without a branch: none would be foreseen. */
static void list_near(vxs_contact *contact, uint32_t first_cluster, uint64_t must)
{
    vxsi_block *near = contact->near + contact->near_count;
    uint32_t first = first_cluster * CLUSTER_QUARTERS;
    for (; must; must >>= VXSI_LANES) {
        uint64_t quarters = spread(must & first_bits(VXSI_LANES));
        for (int n = 0; n < CLUSTER_QUARTERS; n++, first += VXSI_LANES, quarters >>= VXSI_LANES) {
            *near = (vxsi_block){first, (uint32_t)(quarters & first_bits(VXSI_LANES))};
            near += near->which != 0;
        }
    }
    contact->near_count = (uint32_t)(near - contact->near);
}

/* The last quarter, or its points, may not all be there. */
static void end_at(vxsi_block *blocks, uint32_t count, uint32_t end)
{
    if (count && end - blocks[count - 1].first < VXSI_LANES)
        blocks[count - 1].which &= (uint32_t)first_bits(end - blocks[count - 1].first);
}

/* From what is near to what must be looked at. */
static void list_looks(walk *w)
{
    vxs_contact *contact = w->contact;
    vxsi_static *s = w->s;
    const vxsi_discs *quarters = &contact->quarters;
    const int is_checked = contact->culling == VXS_CONTACT_CHECKED,
              by_planes = contact->by_quarters && w->map->planes &&
                          w->map->chunk_count <= INT32_MAX / VXS_VOXMAP_CHUNK_ENTRIES; /* its indices */
    end_at(contact->near, contact->near_count, quarters->count);
    if (by_planes && !is_checked)
        s->look_count = contact->kernel->clear(w->map, quarters, &s->motion, contact->near,
                                               contact->near_count, s->looks);
    for (uint32_t n = 0; n < contact->near_count && (!by_planes || is_checked); n++) {
        const vxsi_block *near = &contact->near[n];
        vxsi_block *looks = s->looks + s->look_count;
        uint32_t count = vxsi_list_points(near->first, near->which, VXSI_LANES, looks);
        if (by_planes) {
            uint64_t gone = near->which;
            count = contact->kernel->clear(w->map, quarters, &s->motion, near, 1, looks);
            for (uint32_t k = 0; k < count; k++)
                gone &= ~(UINT64_C(1) << (looks[k].first / VXSI_QUARTER - near->first));
            for (; gone; gone &= gone - 1)
                skip(w, near->first + lowest(gone), near->first + lowest(gone) + 1, 0);
        }
        s->look_count += count;
    }
    end_at(s->looks, s->look_count, contact->shell.point_count);
    s->is_listed = 0;
}

void vxsi_contact_list_all(const vxs_contact *contact, vxsi_static *s)
{
    const uint32_t count = contact->quarters.count;
    if (!s->is_listed) {
        for (uint32_t n = 0; n < count; n += VXSI_LANES)
            vxsi_list_points(n, UINT32_MAX, VXSI_LANES, s->looks + n);
        end_at(s->looks, count, contact->shell.point_count);
    }
    s->look_count = count;
    s->is_listed = 1;
}

static void walk_group(walk *w, uint32_t group)
{
    const vxsi_spheres *clusters = &w->contact->clusters;
    uint32_t base = group * VXSI_GROUP_CLUSTERS, count = clusters->count - base;
    if (count > VXSI_GROUP_CLUSTERS) count = VXSI_GROUP_CLUSTERS;
    double *due = w->s->due + base / VXSI_LANES, least = INFINITY;
    vxsi_verdict verdict;
    uint64_t wanted = 0;
    for (uint32_t n = 0; n < count; n += VXSI_LANES) {
        if (!(w->is_coherent && due[n / VXSI_LANES] >= w->need)) wanted |= first_bits(VXSI_LANES) << n;
    }
    wanted &= first_bits(count);
    const uint64_t must = judge(w, clusters, base, wanted, &verdict);
    if (verdict.is_deep || w->contact->culling == VXS_CONTACT_CHECKED) {
        for (uint64_t bits = first_bits(count) & ~must; bits; bits &= bits - 1) {
            uint32_t first = (base + lowest(bits)) * CLUSTER_QUARTERS;
            skip(w, first, first + CLUSTER_QUARTERS, (int)(verdict.is_deep >> lowest(bits) & 1u));
        }
    }
    list_near(w->contact, base, must);
    if (!w->is_coherent) return;
    for (uint32_t n = 0; n < count; n += VXSI_LANES) {
        double *own = &due[n / VXSI_LANES];
        if (wanted >> n & 1) *own = due_of(w, &verdict, n, count - n < VXSI_LANES ? count - n : VXSI_LANES);
        least = *own < least ? *own : least;
    }
    w->s->group_due[group] = least;
}

static void walk_groups(walk *w)
{
    const vxsi_spheres *groups = &w->contact->groups;
    for (uint32_t base = 0; base < groups->count; base += VXSI_BATCH) {
        uint32_t count = groups->count - base;
        if (count > VXSI_BATCH) count = VXSI_BATCH;
        double *due = w->s->group_due + base;
        vxsi_verdict verdict;
        uint64_t wanted = first_bits(count);
        for (uint32_t n = 0; n < count && w->is_coherent; n++)
            wanted &= ~((uint64_t)(due[n] >= w->need) << n);
        const uint64_t must = judge(w, groups, base, wanted, &verdict);
        uint64_t told = must | verdict.is_deep;
        for (uint64_t bits = w->is_coherent ? wanted : 0; bits; bits &= bits - 1)
            due[lowest(bits)] = due_of(w, &verdict, lowest(bits), 1);
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
        s->look_count = contact->quarters.count;
        s->is_all = 1;
        return;
    }
    w.is_coherent = contact->culling != VXS_CONTACT_CULLED;
    if (w.is_coherent) advance(contact, s, map, place);
    w.need = s->travel + (double)s->motion.margin;
    contact->near_count = 0;
    walk_groups(&w);
    list_looks(&w);
}

/* Quarters `from` and on of what is to be looked at, which are whole clusters: to looks[put] and on, which is
 * not after them, at a level of detail. Returns where they end. */
static uint32_t coarsen(vxsi_static *s, uint32_t from, uint32_t to, uint32_t put, uint32_t level,
                        const vxs_pointshell *shell)
{
    const uint32_t step = level ? CLUSTER_QUARTERS : 1, each = step * VXSI_QUARTER >> (2 * level);
    vxsi_block block = {0, 0};
    for (; from < to; from += step) {
        const uint32_t point = s->is_all ? from * VXSI_QUARTER : s->looks[from].first,
                       begin = point >> (2 * level), shift = begin % VXSI_LANES, first = begin - shift,
                       left = shell->point_count - begin;
        if (block.which && first != block.first) {
            s->looks[put++] = block;
            block.which = 0;
        }
        block.first = first;
        block.which |= (uint32_t)first_bits(left < each ? left : each) << shift;
    }
    if (block.which) s->looks[put++] = block;
    return put;
}

static uint32_t bits_of(uint32_t which)
{
    uint32_t count = 0;
    for (; which; which &= which - 1) count++;
    return count;
}

static void look(vxs_contact *contact, const vxs_voxmap *map, const vxsi_motion *motion, uint32_t level,
                 const vxsi_block *looks, uint32_t count)
{
    if (count == 0) return;
    const vxs_pointshell *shell = level ? &contact->levels[level] : &contact->shell;
    contact->kernel->probe(map, shell, motion, looks, count, &contact->hits);
    if (level > contact->level) contact->level = level;
    if (level == 0) { /* all but the last are whole */
        contact->probed += (count - 1) * VXSI_QUARTER;
        looks += count - 1;
        count = 1;
    }
    for (uint32_t n = 0; n < count; n++) contact->probed += bits_of(looks[n].which);
}

int vxsi_contact_look(vxs_contact *contact, const vxs_contact_static *statics, uint32_t count,
                      uint32_t most_points)
{
    /* So many clusters at the coarser of two levels, the others at the finer one, that the points are few
     * enough: one cluster more in contact changes the level of one or two, and the force hardly. */
    uint64_t most = most_points ? most_points : UINT64_MAX, clusters = CLUSTER_QUARTERS - 1;
    for (uint32_t n = 0; n < count; n++) clusters += contact->statics[n].look_count;
    clusters /= CLUSTER_QUARTERS;
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
        contact->hits.cube.at[0] = VXSI_NOWHERE;
        uint32_t coarse = 0;
        if (fine || coarse_quarters) {
            const uint32_t all = s->look_count, own = coarse_quarters < all ? coarse_quarters : all;
            coarse = coarsen(s, 0, own, 0, fine + 1, &contact->levels[fine + 1]);
            s->look_count =
                coarsen(s, own, all, coarse, fine, fine ? &contact->levels[fine] : &contact->shell);
            s->is_listed = 0;
            coarse_quarters -= own;
        } else if (s->is_all) {
            vxsi_contact_list_all(contact, s);
        }
        look(contact, statics[n].map, &s->motion, fine + 1, s->looks, coarse);
        look(contact, statics[n].map, &s->motion, fine, s->looks + coarse, s->look_count - coarse);
        s->span.last = contact->hits.count;
    }
    return contact->probed <= most;
}
