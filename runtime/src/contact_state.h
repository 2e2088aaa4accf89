/* SPDX-License-Identifier: MIT
 *
 * Contact's own state: the points found in this evaluation, and of each static map where the shell
 * was and when each part of it can matter again.
 */
#ifndef VXSI_CONTACT_STATE_H
#define VXSI_CONTACT_STATE_H

#include "contact_kernel.h"

/* Clusters to a group, the upper level of culling: points next to each other in the shell's order. */
enum { VXSI_GROUP_CLUSTERS = VXSI_BATCH, VXSI_GROUP_RUNS = VXSI_GROUP_CLUSTERS / VXSI_LANES };

/* Levels of detail above the shell itself, which is level 0; each has a quarter of the points of the last. */
enum { VXSI_LEVELS = 3 };

/* The shell in a map's frame, origin at the box's corner. */
typedef struct vxsi_placement {
    double rotation[9];
    double offset[3]; /* corner to shell [m] */
} vxsi_placement;

typedef struct vxsi_static {
    const uint32_t *root; /* which map this was; NULL: nothing is known */
    vxsi_placement place;
    double travel;     /* bounds how far any point of the shell has moved since then, in all [cells] */
    double *due;       /* per VXSI_LANES clusters: free of contact until travel exceeds this */
    double *group_due; /* per group: its own, or the least of its clusters' */
    vxsi_motion motion;
    int is_near;       /* the shell's bounding sphere meets the map's box */
    vxsi_block *looks; /* points to look at in this evaluation */
    uint32_t look_count;
    int is_all, is_listed; /* that is all points; looks lists them all, maybe from an evaluation before */
    vxsi_span span;        /* and what was found */
} vxsi_static;

struct vxs_contact {
    vxs_pointshell shell;
    const vxsi_kernel *kernel;
    uint32_t culling;
    uint32_t static_capacity;
    vxsi_static *statics;
    vxsi_hits hits;
    vxsi_spheres clusters, groups;
    vxsi_discs quarters;
    vxsi_block *near; /* of quarters, of the static at hand: not free by their clusters' spheres */
    uint32_t near_count;
    int by_quarters; /* quarters of a cluster are told apart; else it is looked at as a whole */
    int has_levels;
    vxs_pointshell levels[VXSI_LEVELS + 1]; /* from 1 on: the level's arrays */
    uint32_t probed;                        /* points of this evaluation */
    uint32_t level;                         /* the coarsest of this evaluation */
    uint32_t wrong_skips;                   /* VXS_CONTACT_CHECKED */
    vxs_wrench *parts; /* NULL, or for each static: its part of the wrench of the last evaluation */
    uint8_t order[256][8];
};

/* Gives a hit a normal that is not its own, and the part of its depth, if it was sampled, that lies along it.
 * A hit that does not collide, which the field distance has too, stays as it is. */
static inline void vxsi_turn_hit(vxsi_hits *hits, uint32_t n, const float normal[3], uint32_t field)
{
    const float along = (hits->nx[n] * normal[0] + hits->ny[n] * normal[1]) + hits->nz[n] * normal[2];
    if (field != VXS_CONTACT_SURFACE) {
        const int is_deep = hits->depth[n] > 0;
        if (field == VXS_CONTACT_DISTANCE && !is_deep) return;
        hits->depth[n] *= is_deep ? along : 1;
    }
    hits->nx[n] = normal[0];
    hits->ny[n] = normal[1];
    hits->nz[n] = normal[2];
}

/* The cell of directions of each hit, of 96, into hits.direction; from its own normal, before it is turned.
 */
void vxsi_name_directions(vxsi_hits *hits);

/* Fills config.loads from the hits, that have their depths and are turned to their normals. factor: [N] per
 * unit of depth x weight; turn: shell to scene. */
void vxsi_gather_loads(const vxs_contact *contact, const vxs_contact_config *config, uint32_t statics,
                       double factor, const double turn[9]);

/* Splits hits into patches (contact.h, law patch) and turns them, where there are more than one, to the
 * normals of their patches. Returns the number of patches. */
uint32_t vxsi_split_patches(vxsi_hits *hits, uint32_t field);

/* The lower triangle, row by row, of a symmetric 6 x 6 matrix. */
enum { VXSI_STIFFNESS = 21 };

/* Adds the stiffness of the span's hits with hits.depth along their normals, per unit of k: sum w v v^T, v =
 * (n, (x - o) x n / length). */
void vxsi_add_stiffness(const vxsi_hits *hits, const vxsi_span *span, const double reference[3],
                        double length, double sum[VXSI_STIFFNESS]);

/* The largest eigenvalue, or up to 0.05 % more, of a matrix that has none below 0. */
double vxsi_largest_eigenvalue(const double matrix[VXSI_STIFFNESS]);

/* Lists in s->looks what of the shell at `place` must be looked at; remembers the place for the next time. */
void vxsi_contact_walk(vxs_contact *contact, vxsi_static *s, const vxs_voxmap *map,
                       const vxsi_placement *place);

/* Lists all the shell's points there. */
void vxsi_contact_list_all(const vxs_contact *contact, vxsi_static *s);

/* Looks at what is listed: finds the hits of each static. most_points: 0, or the levels of detail are chosen
 * so that no more are looked at. Returns 0 if the coarsest level is not coarse enough. */
int vxsi_contact_look(vxs_contact *contact, const vxs_contact_static *statics, uint32_t count,
                      uint32_t most_points);

/* After an evaluation, with the shell where that had it: calls visit for each point at x (shell's frame)
 * whose signed distance from static `number` is within +-reach, with the gradient of that (shell's frame; 1,
 * but less where it is not sure). In point order; which these are does not depend on culling. The map has a
 * signed distance of a band of reach at least. */
typedef void vxsi_near(void *self, const double x[3], double distance, const double gradient[3]);
void vxsi_contact_near(const vxs_contact *contact, uint32_t number, const vxs_voxmap *map, double reach,
                       vxsi_near *visit, void *self);

#endif
