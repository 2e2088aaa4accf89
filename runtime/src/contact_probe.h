/* SPDX-License-Identifier: MIT
 *
 * contact_probe.h - private: the seam between the probe (one per instruction set) and the
 * evaluation (one for all).
 */
#ifndef VXSI_CONTACT_PROBE_H
#define VXSI_CONTACT_PROBE_H

#include "voxshell/contact.h"

/* A colliding point and its cell relative to the box. */
typedef struct vxsi_hit {
    uint32_t point;
    uint32_t cell[3];
} vxsi_hit;

struct vxsi_probe_motion;

/* Lists the points of the shell that are in surface cells, in point order. Whatever the
 * instruction set: the same hits, the same counts. */
typedef void vxsi_probe(const vxs_voxmap *map, const vxs_pointshell *shell,
                        const struct vxsi_probe_motion *motion, vxs_contact_scratch *scratch);

struct vxs_contact_scratch {
    vxsi_probe *probe;   /* chosen at set-up */
    uint32_t capacity;   /* points */
    uint32_t count;      /* hits of this evaluation */
    uint32_t deep_count; /* points in interior cells */
    uint32_t overflow;   /* not 0: a hit found no room */
    vxsi_hit *hits;      /* capacity, in point order */
    uint8_t *patch;      /* capacity, patch of each hit */
};

/* The shell's motion in cells of the map's box, float32 (contact.h says how it is rounded). */
typedef struct vxsi_probe_motion {
    float m[9], b[3];
} vxsi_probe_motion;

vxsi_probe vxsi_probe_scalar;
#if defined(__x86_64__)
vxsi_probe vxsi_probe_avx2;
#endif

#endif
