/* SPDX-License-Identifier: MIT
 *
 * The law `patch`: which normals belong together (contact.h). Normals are gathered in fixed cells of
 * directions in the shell's frame, so a point never changes its cell, and from tick to tick nothing changes
 * but by the points that come and go. Cells whose mean normals agree share their mean: linear in the hits,
 * and so is the weight with which a cell takes part. rt-safe.
 */
#include "contact_state.h"

#include <math.h>
#include <string.h>

/* A cube's faces, each cut in 4 x 4 at angles of 22.5 degrees: normals of one cell are within 33 degrees. */
enum { PARTS = 4, DIRECTIONS = 6 * PARTS * PARTS, SUMS = 4 };
static const float part_slope = 0.41421356f; /* tan 22.5 degrees */

/* Mean normals within 25 degrees belong together, beyond 45 degrees not at all. */
static const double together = 0.90630778703664996, apart = 0.70710678118654752;

/* A cell of directions, or several: the sum of normals and their number. */
typedef struct bundle {
    double sum[3], count;
} bundle;

void vxsi_name_directions(vxsi_hits *hits)
{
    for (uint32_t n = 0; n < hits->count; n++) {
        float x = hits->nx[n], y = hits->ny[n], z = hits->nz[n], ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
        int is_x = (ax >= ay) & (ax >= az), is_y = !is_x & (ay >= az);
        float along = is_x ? x : is_y ? y : z, u = is_x ? y : is_y ? z : x, v = is_x ? z : is_y ? x : y;
        float bound = part_slope * fabsf(along);
        int face = 2 * (2 - 2 * is_x - is_y) + (along < 0);
        int column = (u > -bound) + (u > 0) + (u > bound), row = (v > -bound) + (v > 0) + (v > bound);
        hits->direction[n] = (uint8_t)((face * PARTS + column) * PARTS + row);
    }
}

/* In SUMS interleaved sums. */
static void gather(const vxsi_hits *hits, int only_deep, bundle cells[DIRECTIONS])
{
    bundle sums[SUMS][DIRECTIONS];
    memset(sums, 0, sizeof sums);
    for (uint32_t n = 0; n < hits->count; n++) {
        if (only_deep && !(hits->depth[n] > 0)) continue;
        bundle *to = &sums[n % SUMS][hits->direction[n]];
        to->sum[0] += (double)hits->nx[n];
        to->sum[1] += (double)hits->ny[n];
        to->sum[2] += (double)hits->nz[n];
        to->count += 1;
    }
    for (int d = 0; d < DIRECTIONS; d++) {
        for (int i = 0; i < 3; i++)
            cells[d].sum[i] =
                (sums[0][d].sum[i] + sums[1][d].sum[i]) + (sums[2][d].sum[i] + sums[3][d].sum[i]);
        cells[d].count = (sums[0][d].count + sums[1][d].count) + (sums[2][d].count + sums[3][d].count);
    }
}

static double normalise(double v[3])
{
    double length = sqrt((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
    for (int i = 0; i < 3 && length > 0; i++) v[i] /= length;
    return length;
}

/* How far two mean normals belong together: 0 .. 1, smooth in the cosine. */
static double agreement(const double a[3], const double b[3])
{
    double cosine = (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2], share = (cosine - apart) / (together - apart);
    return share <= 0 ? 0 : share >= 1 ? 1 : share * share * (3 - 2 * share);
}

uint32_t vxsi_split_patches(vxsi_hits *hits, uint32_t field)
{
    bundle cells[DIRECTIONS];
    double mean[DIRECTIONS][3], sum[DIRECTIONS][3]; /* of the cells in use */
    float normals[DIRECTIONS][3];
    uint8_t used[DIRECTIONS];
    int is_first[DIRECTIONS];
    uint32_t count = 0, patches = 0;
    vxsi_name_directions(hits);
    gather(hits, field == VXS_CONTACT_DISTANCE, cells);
    for (uint8_t d = 0; d < DIRECTIONS; d++) {
        memcpy(mean[count], cells[d].sum, sizeof mean[count]);
        if (normalise(mean[count]) > 0) used[count++] = d;
    }
    int is_one = 1;
    for (uint32_t n = 0; n < count; n++) {
        int is_new = 1;
        memcpy(sum[n], cells[used[n]].sum, sizeof sum[n]);
        for (uint32_t m = 0; m < n; m++) {
            double share = agreement(mean[n], mean[m]);
            is_one &= share >= 1;
            is_new &= !is_first[m] || share < 1;
            for (int i = 0; i < 3; i++) {
                sum[n][i] += share * cells[used[m]].sum[i];
                sum[m][i] += share * cells[used[n]].sum[i];
            }
        }
        is_first[n] = is_new;
        patches += (uint32_t)is_new;
    }
    if (is_one) return count > 0;
    for (uint32_t n = 0; n < count; n++) {
        normalise(sum[n]);
        for (int i = 0; i < 3; i++) normals[used[n]][i] = (float)sum[n][i];
    }
    for (uint32_t n = 0; n < hits->count; n++) vxsi_turn_hit(hits, n, normals[hits->direction[n]], field);
    return patches < 2 ? 2 : patches;
}
