/* SPDX-License-Identifier: MIT
 *
 * pointshell.h - the dynamic object: points on its surface, inward unit normals, areas.
 *
 * Source: METHOD section 2 (paper section 3); bytes: formats/pointshell.md. Structure of
 * arrays; all coordinates in the part's own frame [m].
 */
#ifndef VOXSHELL_POINTSHELL_H
#define VOXSHELL_POINTSHELL_H

#include "voxshell/asset.h"
#include "voxshell/format/pointshell.h"

#ifdef __cplusplus
extern "C" {
#endif

/* View: borrowed from the asset, valid until vxs_asset_close(). Plain; copy it freely. */
typedef struct vxs_pointshell {
    double voxel;                           /* edge of the cells that the shell was made with [m] */
    uint32_t kind;                          /* VXS_POINTSHELL_EXACT or _NAIVE */
    uint32_t point_count;                   /* real points, >= 1 */
    uint32_t padded_count;                  /* elements of each array, multiple of 16 */
    uint32_t cluster_count;                 /* of at most VXS_POINTSHELL_CLUSTER_POINTS points each */
    const float *x, *y, *z;                 /* [m] */
    const float *nx, *ny, *nz;              /* of length 1, into the object */
    const float *area;                      /* [m^2], >= 0; NULL in a shell that was made without (NO_AREA) */
    const vxs_pointshell_cluster *clusters; /* cluster_count of them */
    double center[3], radius;               /* sphere that holds all points [m] */
    double total_area;                      /* of the surface that the points stand for [m^2] */
    double gap_max;                         /* largest distance between points of adjacent cells [m] */
    double surface_error;                   /* of a point from the mesh, at most [m] */
} vxs_pointshell;

/* The view of an open asset. Returns VXS_OK; VXS_PARAM for NULL or a closed asset; VXS_KIND
 * for an asset of another kind. Thread: any, set-up (but does no work that blocks). */
VXS_API vxs_result vxs_pointshell_open(const vxs_asset *asset, vxs_pointshell *out);

#ifdef __cplusplus
}
#endif
#endif
