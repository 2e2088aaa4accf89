/* SPDX-License-Identifier: MIT
 *
 * Who presses how: contact.h, vxs_contact_loads. Two passes over the hits: force, normal and centre; then how
 * far the pressure is spread about it. rt-safe.
 */
#include "contact_state.h"
#include "vector.h"

#include <math.h>
#include <string.h>

enum { DIRECTIONS = 96 };
static const double nothing = 1e-150; /* [N]: what is less would turn denormal further on */

/* Of a cell of directions, shell frame. */
typedef struct gathered {
    double force, normal[3], center[3], spread;
} gathered;

static double weight_of(const vxsi_hits *hits, const vxsi_span *span, uint32_t n)
{
    double depth = (double)hits->depth[n];
    return span->has_area ? depth * (double)hits->area[n] : depth;
}

static double length(const double v[3])
{
    return sqrt((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
}

/* Ends sums: normals of length 1, centres. What presses nothing has force 0. */
static void finish_sums(gathered cells[DIRECTIONS])
{
    for (gathered *g = cells; g < cells + DIRECTIONS; g++) {
        double size = length(g->normal);
        if (!(size > 0)) g->force = 0;
        for (int i = 0; i < 3 && g->force > 0; i++) {
            g->normal[i] /= size;
            g->center[i] /= g->force;
        }
    }
}

static void gather(const vxsi_hits *hits, const vxsi_span *span, gathered cells[DIRECTIONS])
{
    memset(cells, 0, DIRECTIONS * sizeof *cells);
    for (uint32_t n = span->first; n < span->last; n++) {
        double weight = weight_of(hits, span, n);
        if (!(weight > 0)) continue;
        gathered *to = &cells[hits->direction[n]];
        const double normal[3] = {hits->nx[n], hits->ny[n], hits->nz[n]},
                     at[3] = {hits->x[n], hits->y[n], hits->z[n]};
        to->force += weight;
        for (int i = 0; i < 3; i++) {
            to->normal[i] += weight * normal[i];
            to->center[i] += weight * at[i];
        }
    }
    finish_sums(cells);
    for (uint32_t n = span->first; n < span->last; n++) {
        double weight = weight_of(hits, span, n);
        if (!(weight > 0)) continue;
        gathered *to = &cells[hits->direction[n]];
        const double way[3] = {(double)hits->x[n] - to->center[0], (double)hits->y[n] - to->center[1],
                               (double)hits->z[n] - to->center[2]};
        const double *v = to->normal;
        const double across[3] = {way[1] * v[2] - way[2] * v[1], way[2] * v[0] - way[0] * v[2],
                                  way[0] * v[1] - way[1] * v[0]};
        to->spread += weight * length(across);
    }
}

void vxsi_gather_loads(const vxs_contact *contact, const vxs_contact_config *config, uint32_t statics,
                       double factor, const double turn[9])
{
    gathered cells[DIRECTIONS];
    vxs_contact_loads *loads = config->loads;
    for (uint32_t s = 0; s < statics; s++) {
        const vxsi_span *span = &contact->statics[s].span;
        if (span->first == span->last) continue;
        gather(&contact->hits, span, cells);
        for (uint32_t d = 0; d < DIRECTIONS; d++) {
            const gathered *from = &cells[d];
            if (!(from->force * factor > nothing) || loads->count == VXS_CONTACT_MAX_LOADS) continue;
            vxs_contact_load *to = &loads->load[loads->count++];
            double arm[3];
            for (int i = 0; i < 3; i++) arm[i] = from->center[i] - config->reference[i];
            to->at = s;
            to->direction = d;
            to->force = from->force * factor;
            to->radius = from->spread / from->force;
            vxsi_rotate(turn, from->normal, to->normal);
            vxsi_rotate(turn, arm, to->arm);
        }
    }
}
