/* SPDX-License-Identifier: MIT
 *
 * Contact's own state: the points found in this evaluation, and of each static map where the shell
 * was and when each part of it can matter again.
 */
#ifndef VXSI_CONTACT_STATE_H
#define VXSI_CONTACT_STATE_H

#include "contact_kernel.h"

/* Clusters to a group, the upper level of culling: points next to each other in the shell's order. */
enum { VXSI_GROUP_CLUSTERS = VXSI_BATCH };

/* The shell in a map's frame, origin at the box's corner. */
typedef struct vxsi_placement {
    double rotation[9];
    double offset[3]; /* corner to shell [m] */
} vxsi_placement;

typedef struct vxsi_static {
    const uint32_t *root; /* which map this was; NULL: nothing is known */
    vxsi_placement place;
    double travel;     /* bounds how far any point of the shell has moved since then, in all [cells] */
    double *due;       /* per cluster: free of contact until travel exceeds this */
    double *group_due; /* per group: the least of its clusters' */
    vxsi_span span;    /* hits of this evaluation */
} vxsi_static;

struct vxs_contact {
    vxs_pointshell shell;
    const vxsi_kernel *kernel;
    uint32_t culling;
    uint32_t static_capacity;
    vxsi_static *statics;
    vxsi_hits hits;
    vxsi_spheres clusters, groups;
    uint32_t probed;      /* points of this evaluation */
    uint32_t wrong_skips; /* VXS_CONTACT_CHECKED */
    uint8_t order[256][8];
};

/* Adds what the law `gradient` says of the span's hits: sums over the points that are inside. */
typedef struct vxsi_gradient_total {
    double normal[3], force[3], moment[3], depth;
    uint32_t points, deep; /* deep: too far inside for the distance's band to know a direction */
} vxsi_gradient_total;
void vxsi_sum_gradient(const vxs_voxmap *map, const vxsi_hits *hits, const vxsi_span *span, const double reference[3],
                       vxsi_gradient_total *total);

/* Finds the hits of the shell at `place`, which is also remembered for the next time. */
void vxsi_contact_walk(vxs_contact *contact, vxsi_static *s, const vxs_voxmap *map,
                       const vxsi_placement *place);

#endif
