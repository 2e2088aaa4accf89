/* SPDX-License-Identifier: MIT
 *
 * Which points are near a static, by its distance channel: for the effect proximity. rt-safe.
 */
#include "contact_channel.h"
#include "contact_state.h"

#include <math.h>

/* Interpolation and the channel's rounding move a distance by less [cells]: half a cell's diagonal, and a
 * bit. */
static const double slop = 1;

typedef struct search {
    const vxs_contact *contact;
    const vxsi_static *s;
    vxsi_channel channel;
    double reach, voxel, to_metres; /* of a slope in units a cell */
    vxsi_near *visit;
    void *self;
} search;

/* As contact_channel.c samples it, and how it grows, in the shell's frame. Returns 0 outside the box, or if
 * it is not below `most`. */
static int sample(const search *f, const double x[3], double most, double *distance, double gradient[3])
{
    const vxsi_channel *channel = &f->channel;
    const double *m = channel->m, *r = f->s->span.rotation;
    double part[3], low[4], slope[4], edge[4];
    int32_t cell[3];
    uint32_t pairs[4];
    for (int i = 0; i < 3; i++) {
        const double u = ((m[3 * i] * x[0] + m[3 * i + 1] * x[1]) + m[3 * i + 2] * x[2]) + channel->b[i];
        if (!(u >= -1 && u < (double)channel->map->cells[i])) return 0;
        cell[i] = (int32_t)(u + 1) - 1;
        part[i] = u - (double)cell[i];
    }
    vxsi_channel_pairs(channel, cell[0], cell[1], cell[2], pairs);
    for (int e = 0; e < 4; e++) {
        low[e] = (int16_t)pairs[e];
        slope[e] = (int16_t)(pairs[e] >> 16) - low[e];
        edge[e] = low[e] + part[2] * slope[e];
    }
    const double at_low = edge[0] + part[1] * (edge[1] - edge[0]),
                 at_high = edge[2] + part[1] * (edge[3] - edge[2]);
    *distance = (at_low + part[0] * (at_high - at_low)) * channel->step;
    if (!(fabs(*distance) < most)) return 0;
    const double across_low = edge[1] - edge[0], slope_low = slope[0] + part[1] * (slope[1] - slope[0]),
                 slope_high = slope[2] + part[1] * (slope[3] - slope[2]);
    const double g[3] = {at_high - at_low, across_low + part[0] * ((edge[3] - edge[2]) - across_low),
                         slope_low + part[0] * (slope_high - slope_low)};
    for (int i = 0; i < 3; i++)
        gradient[i] = ((r[i] * g[0] + r[3 + i] * g[1]) + r[6 + i] * g[2]) * f->to_metres;
    return 1;
}

static void visit_cluster(const search *f, uint32_t cluster)
{
    const vxs_pointshell *shell = &f->contact->shell;
    uint32_t first = cluster * VXS_POINTSHELL_CLUSTER_POINTS, last = first + VXS_POINTSHELL_CLUSTER_POINTS;
    if (last > shell->point_count) last = shell->point_count;
    const vxsi_spheres *s = &f->contact->clusters;
    const double middle[3] = {(double)s->x[cluster], (double)s->y[cluster], (double)s->z[cluster]};
    double away, unused[3];
    if (sample(f, middle, INFINITY, &away, unused) &&
        fabs(away) - (double)s->radius[cluster] >= f->reach + 2 * slop * f->voxel)
        return;
    for (uint32_t n = first; n < last; n++) {
        const double x[3] = {(double)shell->x[n], (double)shell->y[n], (double)shell->z[n]};
        double distance, gradient[3];
        if (sample(f, x, f->reach, &distance, gradient)) f->visit(f->self, x, distance, gradient);
    }
}

/* Of up to 64 spheres from first on, those that may hold a point within reach. */
static uint64_t within_reach(const search *f, const vxsi_spheres *spheres, uint32_t first)
{
    const vxs_voxmap *map = f->channel.map;
    const uint32_t count = spheres->count - first < VXSI_BATCH ? spheres->count - first : VXSI_BATCH;
    uint64_t all = count < VXSI_BATCH ? (UINT64_C(1) << count) - 1 : ~UINT64_C(0), found = 0;
    if (!map->clearance_index || f->contact->culling == VXS_CONTACT_BRUTE) return all;
    vxsi_verdict verdict;
    f->contact->kernel->cull(map, spheres, first, all, &f->s->motion, &verdict);
    const float need = (float)(f->reach / f->voxel + slop);
    for (uint32_t n = 0; n < count; n++) found |= (uint64_t) !(verdict.slack[n] >= need) << n;
    return found;
}

void vxsi_contact_near(const vxs_contact *contact, uint32_t number, const vxs_voxmap *map, double reach,
                       vxsi_near *visit, void *self)
{
    const vxsi_static *s = &contact->statics[number];
    if (!s->is_near) return;
    const search f = {.contact = contact,
                      .s = s,
                      .channel = vxsi_channel_of(map, 0, &s->span),
                      .reach = reach,
                      .voxel = map->voxel,
                      .to_metres = map->distance_step / map->voxel,
                      .visit = visit,
                      .self = self};
    for (uint32_t base = 0; base < contact->groups.count; base += VXSI_BATCH) {
        for (uint64_t groups = within_reach(&f, &contact->groups, base); groups; groups &= groups - 1) {
            const uint32_t first = (base + (uint32_t)__builtin_ctzll(groups)) * VXSI_GROUP_CLUSTERS;
            for (uint64_t left = within_reach(&f, &contact->clusters, first); left; left &= left - 1)
                visit_cluster(&f, first + (uint32_t)__builtin_ctzll(left));
        }
    }
}
