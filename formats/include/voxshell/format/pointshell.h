/* SPDX-License-Identifier: MIT
 *
 * pointshell.h - what a .pointshell file holds (formats/pointshell.md): the dynamic
 * object as points on its surface with inward unit normals and area weights.
 *
 * Structure of arrays: each coordinate is its own section of float32, so that a kernel
 * loads eight points at a time. Every array holds padded_count elements; the padding
 * after point_count repeats the last point with area 0 (S305).
 */
#ifndef VOXSHELL_FORMAT_POINTSHELL_H
#define VOXSHELL_FORMAT_POINTSHELL_H

#include "voxshell/format/container.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    VXS_POINTSHELL_VERSION_MAJOR = 1,   /* of the format */
    VXS_POINTSHELL_VERSION_MINOR = 0,   /* of the format */
    VXS_POINTSHELL_LANES = 16,          /* padded_count is a multiple of this */
    VXS_POINTSHELL_CLUSTER_POINTS = 64, /* points per cluster, the last may hold fewer */
    VXS_POINTSHELL_MAX_POINTS = 1 << 28 /* S203 */
};

/* required_features: no section AREA (S101, S103). */
enum { VXS_POINTSHELL_FEATURE_NO_AREA = 1 };

/* Largest |coordinate| of a point or a centre [m] (S207, S301, S402). */
#define VXS_POINTSHELL_MAX_COORDINATE 1e15

/* What points are: EXACT, on the surface; NAIVE, the centres of its cells. */
enum { VXS_POINTSHELL_EXACT = 1, VXS_POINTSHELL_NAIVE = 2 };

/* Sections. */
#define VXS_POINTSHELL_SECTION_SHEL VXS_SECTION_ID('S', 'H', 'E', 'L') /* 1 x vxs_pointshell_info */
#define VXS_POINTSHELL_SECTION_POSX VXS_SECTION_ID('P', 'O', 'S', 'X') /* f32 [m] */
#define VXS_POINTSHELL_SECTION_POSY VXS_SECTION_ID('P', 'O', 'S', 'Y') /* f32 [m] */
#define VXS_POINTSHELL_SECTION_POSZ VXS_SECTION_ID('P', 'O', 'S', 'Z') /* f32 [m] */
#define VXS_POINTSHELL_SECTION_NRMX VXS_SECTION_ID('N', 'R', 'M', 'X') /* f32, inward, unit */
#define VXS_POINTSHELL_SECTION_NRMY VXS_SECTION_ID('N', 'R', 'M', 'Y') /* f32, inward, unit */
#define VXS_POINTSHELL_SECTION_NRMZ VXS_SECTION_ID('N', 'R', 'M', 'Z') /* f32, inward, unit */
#define VXS_POINTSHELL_SECTION_AREA VXS_SECTION_ID('A', 'R', 'E', 'A') /* f32 [m^2], >= 0 */
#define VXS_POINTSHELL_SECTION_CLUS VXS_SECTION_ID('C', 'L', 'U', 'S') /* vxs_pointshell_cluster */

/* What the shell is. */
typedef struct vxs_pointshell_info {
    double voxel;           /* edge h of the cells that the shell was made with [m] */
    uint32_t kind;          /* VXS_POINTSHELL_EXACT or _NAIVE */
    uint32_t point_count;   /* real points */
    uint32_t padded_count;  /* elements of every array */
    uint32_t cluster_count; /* elements of CLUS */
    double area;            /* sum of the area weights, in double before rounding [m^2] */
    double gap_max;         /* largest distance between points of adjacent cells [m] */
    double surface_error;   /* largest distance of a stored point from the mesh [m] */
    double center[3];       /* of the bounding sphere of all points [m] */
    double radius;          /* of that sphere: every |p - center| <= radius [m] */
    uint64_t surface_cells; /* cells that hold at least one point */
    uint8_t pad[24];        /* 0 */
} vxs_pointshell_info;

/* Points first .. first + count - 1 lie within radius of center. Clusters are in point
 * order, contiguous, and cover all points once (S401). */
typedef struct vxs_pointshell_cluster {
    float center[3];      /* [m] */
    float radius;         /* [m], rounded up */
    uint32_t first;       /* number of its first point */
    uint32_t count;       /* >= 1 */
    uint32_t reserved[2]; /* 0 */
} vxs_pointshell_cluster;

VXS_STATIC_ASSERT(sizeof(vxs_pointshell_info) == 112, "info is 112 bytes");
VXS_STATIC_ASSERT(offsetof(vxs_pointshell_info, area) == 24, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_pointshell_info, center) == 48, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_pointshell_info, surface_cells) == 80, "layout");
VXS_STATIC_ASSERT(sizeof(vxs_pointshell_cluster) == 32, "cluster is 32 bytes");

#ifdef __cplusplus
}
#endif
#endif
