/* SPDX-License-Identifier: MIT
 *
 * contact.h - force and torque on a moving pointshell in a voxmap.
 *
 * Source: METHOD section 3 (paper section 4). A law gives each point that collides a direction, a field its
 * depth d, a weighting its share; F_p = k d n.
 *
 * Laws, for points p with inward unit normals n_p:
 *
 *   original  (McNeely)  each along its own n_p
 *
 *   average   (paper)    all along one n: the normalised mean of the n_p of all colliding points. Where
 *             that cancels (|mean| < 0.1), as `patch`
 *
 *   patch     each along the mean of the n_p that belong to its own. Normals are gathered in 96 fixed
 *             cells of directions (a cube's faces, each cut in 4 x 4 at angles of 22.5 degrees, in the
 *             shell's frame, so that a point never changes its cell). The n_p of another cell belong to
 *             those of this one in full where the mean normals of both are within 25 degrees, not at all
 *             beyond 45 degrees, in between by a share s^2 (3 - 2 s), s linear in the cosine. Where all
 *             belong together there is one patch, and this is `average` to the last bit. No mean of a
 *             patch cancels
 *
 *   gradient  along the gradient of the map's distance at p; with the field distance only
 *
 * Energy: gradient is the slope of one, to the step of the map's distances. The directions of the others are
 * the shell's, and lean against the wall: by as much as points are spread unevenly (2 % with original, 4 to 7
 * % with average and patch, whose mean counts points), and, with surface and layers on a wall that is tilted
 * against the grid, by another way in each cell (up to 26 %). On a way along a wall that is e F a metre,
 * taken or given: moved 7.6 depths along and lifted there, a ball gives back what it took and 0.4
 * (original), 1.6 (average) or 1.2 (patch) of that besides (tests/hard, case energy). Only the guard
 * PASSIVITY bounds it (effect.h; case energy_guarded: with every law).
 *
 * Edges: a point is one for all faces in its cell, and pushes with their whole area along one direction.
 * Where a good part of a contact is edges, in a slot or hole, original, average and patch push too much by
 * that part, with surface and layers also by up to a cell past the rim of a wall: the cases slot and
 * peg_in_hole are claimed by patch within 10 % with distance (peg_in_hole: and layers). Within a cell of a
 * valley or ridge of the static part the direction of gradient turns from one face's to the other's.
 *
 * Fields, for a point in a cell with centre c:
 *
 *   surface   (paper) collides in a surface cell; d = max(0, (c - p) . n). In an interior cell it is
 *             `deep`, and gives no force
 *
 *   layers    collides in a surface or interior cell; d = the larger of that, and of -R h (|N0| + |N1| +
 *             |N2|) (n_p . n): R the map's layer numbers, interpolated linearly along each axis between the
 *             centres of cells, N the point's n_p in the map's frame. So a plate without an interior pushes
 *             as with `surface`, and a point that sinks into a wall is pushed out ever more: rings of a plane
 *             follow each other every h (|N0| + |N1| + |N2|), and R does not jump from one to the next.
 *             Beyond the last layer R stays as it is there, and the point is `deep` too
 *
 *   distance  collides where the map's signed distance D, interpolated in the same way, is below 0;
 *             d = max(0, -D n_p . n): what of the way out leads along n. Beyond the band D stays as it is
 *             there, and the point is `deep` too. With the law gradient d = -D, and a point that is beyond
 *             the band, where there is no direction, gives no force
 *
 * Torque = sum (p - o) x F_p. Sums run in point order, in eight interleaved double sums.
 *
 * The tick is two passes and more. Probe, in float32, the points that are not culled: u = (R/h) x + b, cell =
 * floor(u), where R/h and b = (t - h origin_cell)/h are computed in double and rounded once, and u_i = ((m_i0
 * x + m_i1 y) + m_i2 z) + b_i in this order; it lists the colliding points and their cells. Evaluate, in
 * double, from the stored float32 points and those cells, relative to the box's corner: p = R x + (t - h
 * origin_cell), c = h (cell + 1/2), in the shell's frame; depths of channels, and normals that are not the
 * shell's, are rounded to float32 once. So the wrench is the same to the last bit on any machine, with any
 * instruction set and any culling.
 */
#ifndef VOXSHELL_CONTACT_H
#define VOXSHELL_CONTACT_H

#include "voxshell/pointshell.h"
#include "voxshell/pose.h"
#include "voxshell/voxmap.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Laws. */
enum { VXS_CONTACT_ORIGINAL = 1, VXS_CONTACT_AVERAGE = 2, VXS_CONTACT_GRADIENT = 3, VXS_CONTACT_PATCH = 4 };

/* Fields. */
enum { VXS_CONTACT_SURFACE = 1, VXS_CONTACT_LAYERS = 2, VXS_CONTACT_DISTANCE = 3 };

/* How points are weighted.
 *   COUNT         each counts the same: k in N/m per point (the paper)
 *   COUNT_CAPPED  COUNT, and from ten colliding points N on the net wrench is divided by N/10 (McNeely)
 *   AREA          k in N/m^3 times the point's area: does not grow with resolution */
enum { VXS_CONTACT_COUNT = 1, VXS_CONTACT_COUNT_CAPPED = 2, VXS_CONTACT_AREA = 3 };

enum {
    VXS_CONTACT_CAP_POINTS = 10,    /* COUNT_CAPPED */
    VXS_CONTACT_MAX_STATICS = 4096, /* of one contact */
    VXS_CONTACT_MAX_LOADS = 96      /* of one evaluation */
};

/* Flags of a result. */
enum {
    VXS_CONTACT_DEEP = 1 << 0,           /* a point is deeper than the field reaches */
    VXS_CONTACT_MEAN_CANCELLED = 1 << 1, /* average: |mean normal| < 0.1, evaluated as `patch` */
    VXS_CONTACT_OUT_OF_MAP = 1 << 2,     /* the shell's bounding sphere is beyond every map's box: free */
    VXS_CONTACT_OVERFLOW =
        1 << 3, /* more hits than points, through several statics: wrench of those that fit */
    VXS_CONTACT_INVALID = 1 << 4, /* pose or config refused, or wrench not finite: zero wrench */
    VXS_CONTACT_OVER_BUDGET =
        1 << 6,                    /* more than most_points were looked at, at the coarsest level of detail */
    VXS_CONTACT_SOFTENED = 1 << 7, /* most_stiffness acted */
    VXS_CONTACT_WRONG_SKIP = 1 << 5 /* VXS_CONTACT_CHECKED only: a map's clearance is not that of its cells */
};

/* What the points press with whose own normals are in one cell of directions (those of the law patch), on one
 * static. A point is in the same cell whatever the law and the pose, so a load keeps its name for as long as
 * it lasts. Frame: the scene's. */
typedef struct vxs_contact_load {
    uint32_t at;        /* the static, in the order of the evaluation's */
    uint32_t direction; /* the cell of directions, 0 .. 95 */
    double force;       /* sum |F_p| [N] > 0 */
    double normal[3];   /* of length 1: of sum F_p */
    double arm[3];      /* from o to the centre of pressure [m] */
    double radius;      /* mean distance of the pressure from the normal through it [m] */
} vxs_contact_load;

/* In the order of their statics, then of their directions; those that find no room are left out. */
typedef struct vxs_contact_loads {
    uint32_t count;                               /* of load that are told */
    vxs_contact_load load[VXS_CONTACT_MAX_LOADS]; /* who presses how */
} vxs_contact_loads;

/* Config. */
typedef struct vxs_contact_config {
    uint32_t struct_size;
    uint32_t law;       /* VXS_CONTACT_ORIGINAL, _AVERAGE (default), _PATCH, _GRADIENT */
    uint32_t field;     /* VXS_CONTACT_SURFACE (default), _LAYERS, _DISTANCE */
    uint32_t weighting; /* VXS_CONTACT_COUNT (default), _COUNT_CAPPED, _AREA */
    /* 0 (default): no limit. Else so many points are looked at at most, at levels of detail as coarse as that
     * needs; only with AREA, and after vxs_contact_add_levels(). */
    uint32_t most_points;
    double stiffness; /* k > 0, finite: [N/m] per point, [N/m^3] with AREA; default 1000 */
    /* 0 (default): no bound, and no cost. Else no contact is stiffer than this as a whole [N/m]: one factor
     * on the wrench, so that its direction stays. How stiff: the largest eigenvalue (or up to 0.05 % more) of
     * K = sum k_p v v^T, v = (n, (p - o) x n / r) with r the shell's radius: that of the 6 x 6 matrix from a
     * small motion to its wrench, rotations scaled by r. k_p is k and the point's share in full from d = 0
     * on; from an eighth of a cell outside it grows to that linearly, as far as a point that does not push
     * yet is seen there (in its surface cell), so that the factor does not jump. */
    double most_stiffness;
    double reference[3]; /* o, the point about which torque is taken, in the shell's frame [m]; default 0 */
    vxs_contact_loads *loads; /* NULL (default), or where every evaluation says who presses how; it does not
                                 change the result by a bit */
} vxs_contact_config;

/* What the colliding points do. Frame: the scene's. */
typedef struct vxs_contact_result {
    vxs_wrench wrench;    /* on the object, about config.reference; exactly 0 without a colliding point */
    double normal[3];     /* mean inward normal of the colliding points, length 1; 0 without
                        any or if it cancels */
    double depth;         /* largest d [m] */
    double stiffness;     /* with most_stiffness: of the contact before that bounds it [N/m] */
    uint32_t points;      /* colliding, as the field says */
    uint32_t deep_points; /* deeper than the field reaches */
    /* 0 without a colliding point, else 1; or split: so many means of which no two belong together in full */
    uint32_t patches;
    uint32_t level;  /* coarsest level of detail: 0 all points, 1 a quarter, 2 a sixteenth, 3 one a cluster */
    uint32_t probed; /* points whose cell was looked up; the others were culled */
    uint32_t flags;  /* VXS_CONTACT_DEEP ... */
} vxs_contact_result;

/* A static map and where it is: pose map frame -> scene frame, NULL for identity. It may move from
 * one evaluation to the next. A map is known by the address of its bytes: after its asset was closed and
 * another one opened, which may get the same address, call vxs_contact_cull(). */
typedef struct vxs_contact_static {
    const vxs_voxmap *map;
    const vxs_pose *pose;
} vxs_contact_static;

/* Object: one shell's contact with up to so many static maps. Holds the points found, and what it knows
 * from the evaluation before. One thread at a time; one for each dynamic object. */
typedef struct vxs_contact vxs_contact;

/* Fills a config with the defaults that its members name. Thread: any, rt-safe. */
VXS_API void vxs_contact_config_default(vxs_contact_config *config);

/* VXS_OK; VXS_CONFIG; VXS_PARAM for an unknown law, field or weighting, or a number out of range;
 * VXS_LAW_FIELD for a law that the field cannot serve: gradient with surface or layers.
 * Thread: any, rt-safe. */
VXS_API vxs_result vxs_contact_config_check(const vxs_contact_config *config);

/* Bytes for vxs_contact_init(): about 48 a point, and 24 a cluster and static. 0 for a NULL shell.
 * Thread: any, rt-safe. */
VXS_API size_t vxs_contact_memory(const vxs_pointshell *shell, uint32_t statics);

/* Makes a contact in the caller's memory, which must stay until its last use, as must the shell's asset;
 * nothing to close. memory: any multiple of 16; it is written throughout. statics: 1 ..
 * VXS_CONTACT_MAX_STATICS. Returns VXS_OK; VXS_PARAM; VXS_BUFFER (too small or not aligned).
 * Thread: any, set-up. */
VXS_API vxs_result vxs_contact_init(void *memory, size_t size, const vxs_pointshell *shell, uint32_t statics,
                                    vxs_contact **out);

/* The instruction set. All give the same bits; a choice is for tests and benchmarks. */
typedef enum vxs_contact_kernel {
    VXS_CONTACT_FASTEST = 0, /* of those that this processor has: what vxs_contact_init() takes */
    VXS_CONTACT_SCALAR = 1,  /* plain C, on any: what the others mean */
    VXS_CONTACT_AVX2 = 2,    /* x86-64 */
    VXS_CONTACT_NEON = 3,    /* AArch64 */
    VXS_CONTACT_AVX512 = 4   /* x86-64 */
} vxs_contact_kernel;

/* Returns VXS_OK; VXS_PARAM; VXS_UNSUPPORTED (and keeps the kernel) if the processor has not got it.
 * Thread: the contact's, set-up. */
VXS_API vxs_result vxs_contact_use(vxs_contact *contact, uint32_t kernel);

/* Which points are passed over without a look, because they are provably in free cells (or in interior
 * ones). All give the same wrench to the last bit. A map without clearance (formats/voxmap.md) is BRUTE. */
typedef enum vxs_contact_culling {
    VXS_CONTACT_COHERENT = 0, /* CULLED, and what was far is not tested again until it can matter: default */
    VXS_CONTACT_CULLED = 1,   /* bounding spheres of 64 points and more against the map's clearance, discs
                               * around 16 against its planes */
    VXS_CONTACT_BRUTE = 2,    /* every point */
    VXS_CONTACT_CHECKED = 3   /* COHERENT, and every skip is checked: VXS_CONTACT_WRONG_SKIP */
} vxs_contact_culling;

/* Also forgets what is known from evaluations before. Returns VXS_OK; VXS_PARAM.
 * Thread: the contact's, rt-safe. */
VXS_API vxs_result vxs_contact_cull(vxs_contact *contact, uint32_t culling);

/* Whether the map has the channel of a field: layers; for distance a signed one. Without, an evaluation is
 * VXS_CONTACT_INVALID. Thread: any, rt-safe. */
VXS_API int vxs_contact_has_field(const vxs_voxmap *map, uint32_t field);

/* Time-critical contact: bytes for vxs_contact_add_levels(), about 9 a point. Thread: any, rt-safe. */
VXS_API size_t vxs_contact_levels_memory(const vxs_pointshell *shell);

/* Makes the shell's levels of detail in the caller's memory, which must stay as long as the contact. They are
 * used with config.most_points only. Returns VXS_OK; VXS_PARAM; VXS_BUFFER; VXS_NO_AREA. Thread: the
 * contact's, set-up. */
VXS_API vxs_result vxs_contact_add_levels(vxs_contact *contact, void *memory, size_t size);

/* What a point costs at most on this machine with the contact's kernel [s], law average: all of the shell in
 * contact. So most_points = budget / cost holds a budget in seconds. Thread: the contact's, set-up (takes
 * some ms). */
VXS_API double vxs_contact_point_cost(vxs_contact *contact);

/* Evaluates once. pose: shell frame -> scene frame. statics: count of them, each time in the same order; a
 * point that touches two counts twice. Returns result->flags; never fails: bad input gets a zero wrench and
 * VXS_CONTACT_INVALID. Time: with the points that are near a surface of a static; not with the size of the
 * maps. Thread: the contact's, rt-safe. */
VXS_API uint32_t vxs_contact_evaluate(vxs_contact *contact, const vxs_contact_static *statics, uint32_t count,
                                      const vxs_pose *pose, const vxs_contact_config *config,
                                      vxs_contact_result *result);

#ifdef __cplusplus
}
#endif
#endif
