/* SPDX-License-Identifier: MIT
 *
 * contact.h - force and torque on a moving pointshell in a voxmap.
 *
 * Source: METHOD section 3 (paper section 4). A point collides if its cell is a surface cell.
 * For a colliding point p with inward unit normal n_p in a cell with centre c:
 *   original  (McNeely)  d = max(0, (c - p) . n_p),  F_p = k d n_p
 *   average   (paper)    the same with one normal n for all: the normalised mean of the n_p of
 *                        all colliding points
 *   gradient  d and n of each point from the map's signed distance, interpolated linearly between cell
 *             centres: d = max(0, -distance), n along its gradient; points in interior cells too, as far as
 *             the channel's band reaches (beyond it they are `deep`)
 * Torque = sum (p - o) x F_p. Sums run in point order, in four interleaved
 * double sums.
 *
 * The tick is two passes. Probe, in float32, the points that are not culled: u = (R/h) x + b, cell =
 * floor(u), where R/h and b = (t - h origin_cell)/h are computed in double and rounded once, and u_i = ((m_i0
 * x + m_i1 y) + m_i2 z) + b_i in this order; it lists the colliding points and their cells. Evaluate, in
 * double, from the stored float32 points and those cells, relative to the box's corner: p = R x + (t - h
 * origin_cell), c = h (cell + 1/2), in the shell's frame. So the wrench is the same to the last bit on any
 * machine, with any instruction set and any culling.
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
enum { VXS_CONTACT_ORIGINAL = 1, VXS_CONTACT_AVERAGE = 2, VXS_CONTACT_GRADIENT = 3 };

/* How points are weighted.
 *   COUNT         each counts the same: k in N/m per point (the paper)
 *   COUNT_CAPPED  COUNT, and from ten colliding points N on the net wrench is divided by N/10 (McNeely)
 *   AREA          k in N/m^3 times the point's area: does not grow with resolution */
enum { VXS_CONTACT_COUNT = 1, VXS_CONTACT_COUNT_CAPPED = 2, VXS_CONTACT_AREA = 3 };

enum {
    VXS_CONTACT_MAX_PATCHES = 8, /* normals that cancel are split into at most so many patches */
    VXS_CONTACT_CAP_POINTS = 10, /* COUNT_CAPPED */
    VXS_CONTACT_MAX_STATICS = 4096
};

/* Flags of a result. */
enum {
    VXS_CONTACT_DEEP = 1 << 0,           /* a point is too deep inside to give a force */
    VXS_CONTACT_MEAN_CANCELLED = 1 << 1, /* average: |mean normal| < 0.1, evaluated per patch */
    VXS_CONTACT_OUT_OF_MAP = 1 << 2,     /* the shell's bounding sphere is beyond every map's box: free */
    VXS_CONTACT_OVERFLOW =
        1 << 3, /* more hits than points, through several statics: wrench of those that fit */
    VXS_CONTACT_INVALID = 1 << 4, /* pose or config refused, or wrench not finite: zero wrench */
    VXS_CONTACT_OVER_BUDGET =
        1 << 6, /* more than most_points were looked at, at the coarsest level of detail */
    VXS_CONTACT_WRONG_SKIP = 1 << 5 /* VXS_CONTACT_CHECKED only: a map's clearance is not that of its cells */
};

/* Config. */
typedef struct vxs_contact_config {
    uint32_t struct_size;
    uint32_t law;       /* VXS_CONTACT_ORIGINAL, _AVERAGE (default), _GRADIENT */
    uint32_t weighting; /* VXS_CONTACT_COUNT (default), _COUNT_CAPPED, _AREA */
    /* 0 (default): no limit. Else so many points are looked at at most, at levels of detail as coarse as that
     * needs; only with AREA, and after vxs_contact_add_levels(). */
    uint32_t most_points;
    double stiffness; /* k > 0, finite: [N/m] per point, [N/m^3] with AREA; default 1000 */
    double reference[3]; /* o, the point about which torque is taken, in the shell's frame [m]; default 0 */
} vxs_contact_config;

/* What the colliding points do. Frame: the scene's. */
typedef struct vxs_contact_result {
    vxs_wrench wrench; /* on the object, about config.reference; exactly 0 without a colliding point */
    double normal[3];  /* unit mean inward normal of the colliding points; 0 without any or if it cancels */
    double depth;      /* largest d [m] */
    uint32_t points;   /* colliding: in a surface cell; gradient: of distance below 0 */
    uint32_t deep_points; /* in an interior cell; gradient: beyond the distance's band */
    uint32_t patches;     /* 0 without a colliding point, 1, or more after VXS_CONTACT_MEAN_CANCELLED */
    uint32_t level;  /* coarsest level of detail: 0 all points, 1 a quarter, 2 a sixteenth, 3 one a cluster */
    uint32_t probed; /* points whose cell was looked up; the others were culled */
    uint32_t flags;
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

/* Thread: any, rt-safe. */
VXS_API void vxs_contact_config_default(vxs_contact_config *config);

/* VXS_OK; VXS_CONFIG; VXS_PARAM for an unknown law or weighting, or a number out of range.
 * Thread: any, rt-safe. */
VXS_API vxs_result vxs_contact_config_check(const vxs_contact_config *config);

/* Bytes for vxs_contact_init(): about 42 a point, and 9 a cluster and static. 0 for a NULL shell.
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
    VXS_CONTACT_SCALAR = 1,
    VXS_CONTACT_AVX2 = 2,
    VXS_CONTACT_NEON = 3,
    VXS_CONTACT_AVX512 = 4
} vxs_contact_kernel;

/* Returns VXS_OK; VXS_PARAM; VXS_UNSUPPORTED (and keeps the kernel) if the processor has not got it.
 * Thread: the contact's, set-up. */
VXS_API vxs_result vxs_contact_use(vxs_contact *contact, uint32_t kernel);

/* Which points are passed over without a look, because they are provably in free cells (or in interior
 * ones). All give the same wrench to the last bit. A map without clearance (formats/voxmap.md) is BRUTE. */
typedef enum vxs_contact_culling {
    VXS_CONTACT_COHERENT = 0, /* CULLED, and what was far is not tested again until it can matter: default */
    VXS_CONTACT_CULLED = 1,   /* bounding spheres of points against the map's clearance */
    VXS_CONTACT_BRUTE = 2,    /* every point */
    VXS_CONTACT_CHECKED = 3   /* COHERENT, and every skip is checked: VXS_CONTACT_WRONG_SKIP */
} vxs_contact_culling;

/* Also forgets what is known from evaluations before. Returns VXS_OK; VXS_PARAM.
 * Thread: the contact's, rt-safe. */
VXS_API vxs_result vxs_contact_cull(vxs_contact *contact, uint32_t culling);

/* Whether the law gradient can use the map: it has the channel, with a sign. Without, an evaluation is
 * VXS_CONTACT_INVALID. Thread: any, rt-safe. */
VXS_API int vxs_contact_has_signed_distance(const vxs_voxmap *map);

/* Time-critical contact: bytes for vxs_contact_add_levels(), about 9 a point. Thread: any, rt-safe. */
VXS_API size_t vxs_contact_levels_memory(const vxs_pointshell *shell);

/* Makes the shell's levels of detail in the caller's memory, which must stay as long as the contact. They are
 * used with config.most_points only. Returns VXS_OK; VXS_PARAM; VXS_BUFFER. Thread: the contact's, set-up. */
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
