/* SPDX-License-Identifier: MIT
 *
 * How stiff a contact is as a whole: what config.most_stiffness bounds (contact.h). rt-safe.
 */
#include "contact_state.h"

#include <math.h>
#include <string.h>

/* A point counts in full from depth 0 on, and from an eighth of a cell outside less and less: so that it does
 * not come at once, and a wall that is near does not count as one that is touched. */
static double presence(double depth, double voxel)
{
    double share = 1 + depth / (voxel / 8);
    return share <= 0 ? 0 : share >= 1 ? 1 : share;
}

void vxsi_add_stiffness(const vxsi_hits *hits, const vxsi_span *span, const double reference[3],
                        double length, double sum[VXSI_STIFFNESS])
{
    for (uint32_t n = span->first; n < span->last; n++) {
        double weight = presence((double)hits->depth[n], span->voxel);
        if (!(weight > 0)) continue;
        if (span->has_area) weight *= (double)hits->area[n];
        const double arm[3] = {((double)hits->x[n] - reference[0]) / length,
                               ((double)hits->y[n] - reference[1]) / length,
                               ((double)hits->z[n] - reference[2]) / length};
        double v[6] = {hits->nx[n], hits->ny[n], hits->nz[n]};
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            v[3 + i] = arm[j] * v[k] - arm[k] * v[j];
        }
        double *to = sum;
        for (int row = 0; row < 6; row++) {
            double share = weight * v[row];
            for (int column = 0; column <= row; column++) *to++ += share * v[column];
        }
    }
}

/* The 2^n-th root of the trace of the matrix to the power of 2^n: at most 6^(1 / 2^n) times the eigenvalue.
 */
double vxsi_largest_eigenvalue(const double matrix[VXSI_STIFFNESS])
{
    enum { SQUARINGS = 12 };
    double a[6][6], square[6][6], traces[SQUARINGS + 1], root = 1;
    for (int row = 0, n = 0; row < 6; row++) {
        for (int column = 0; column <= row; column++) a[row][column] = a[column][row] = matrix[n++];
    }
    for (int s = 0; s <= SQUARINGS; s++) {
        traces[s] = ((a[0][0] + a[1][1]) + (a[2][2] + a[3][3])) + (a[4][4] + a[5][5]);
        if (!(traces[s] > 0)) return 0;
        double inverse = 1 / traces[s]; /* so that nothing overflows on the way */
        for (int row = 0; row < 6; row++) {
            for (int column = 0; column < 6; column++) {
                double sum = 0;
                for (int n = 0; n < 6; n++) sum += (a[row][n] * inverse) * (a[n][column] * inverse);
                square[row][column] = sum;
            }
        }
        memcpy(a, square, sizeof a);
    }
    for (int s = SQUARINGS; s > 0; s--) root = sqrt(traces[s] * root);
    return traces[0] * root;
}
