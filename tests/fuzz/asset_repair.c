/* SPDX-License-Identifier: MIT
 *
 * What several fields of an asset say together, made true again after one of them was changed: written from
 * the format pages, no code of the readers.
 */
#include "asset_mutator.h"
#include "voxshell/effect.h"
#include "voxshell/format/plan.h"
#include "voxshell/format/pointshell.h"
#include "voxshell/format/voxmap.h"

#include <math.h>
#include <string.h>

static void set_elements(draft_part *part, size_t stride, size_t count)
{
    if (!part || stride * count > ASSET_MOST) return;
    if (stride * count > part->size) memset(part->bytes + part->size, 0, stride * count - part->size);
    part->size = stride * count;
}

/* ---- voxmap ---- */

typedef struct map_draft {
    draft *d;
    vxs_voxmap_grid *grid;
    uint32_t *root, *chunks;
    uint64_t *bricks;
    size_t root_count, chunk_count, brick_count;
} map_draft;

static void *map_bytes(const map_draft *m, uint32_t id)
{
    draft_part *part = draft_find(m->d, id);
    return part ? part->bytes : NULL;
}

/* Entries from 4 on numbered as they come; returns how many. */
static size_t number_entries(uint32_t *entries, size_t count, size_t most)
{
    size_t next = 0;
    for (size_t n = 0; n < count; n++) {
        if (entries[n] == 1 || entries[n] == 3 || (entries[n] > 3 && next >= most)) entries[n] = 0;
        if (entries[n] > 3) entries[n] = VXS_VOXMAP_ENTRY_FIRST + (uint32_t)next++;
    }
    return next;
}

static int map_open(map_draft *m, draft *d, uint32_t leave)
{
    draft_part *grid = draft_find(d, VXS_VOXMAP_SECTION_GRID), *root = draft_find(d, VXS_VOXMAP_SECTION_ROOT),
               *chunks = draft_find(d, VXS_VOXMAP_SECTION_CHNK),
               *bricks = draft_find(d, VXS_VOXMAP_SECTION_BRIK);
    if (!grid || !root || !chunks || !bricks || grid->size < sizeof *m->grid || root->size < 4) return 0;
    *m = (map_draft){
        d, (void *)grid->bytes, (void *)root->bytes, (void *)chunks->bytes, (void *)bricks->bytes, 0, 0, 0};
    size_t entries = root->size / 4, product = 1;
    for (int axis = 0; axis < 3; axis++)
        product =
            m->grid->root_dims[axis] <= 4096 && product <= 4096 ? product * m->grid->root_dims[axis] : 0;
    if (!(leave & 1) && product >= 1 && product <= 4096) set_elements(root, 4, entries = product);
    if (!(leave & 1) && (product < 1 || product > 4096)) {
        m->grid->root_dims[0] = (uint32_t)entries;
        m->grid->root_dims[1] = m->grid->root_dims[2] = 1;
    }
    m->root_count = entries;
    m->chunk_count = chunks->size / 2048;
    if (!(leave & 2))
        set_elements(chunks, 2048, m->chunk_count = number_entries(m->root, entries, ASSET_MOST / 2048));
    m->brick_count = bricks->size / 128;
    if (!(leave & 4))
        set_elements(bricks, 128, m->brick_count = number_entries(m->chunks, m->chunk_count * 512, 24));
    if (leave & 7) return 0;
    set_elements(draft_find(d, VXS_VOXMAP_SECTION_LAYR), 512, m->brick_count);
    set_elements(draft_find(d, VXS_VOXMAP_SECTION_DIST), 1024, m->brick_count);
    set_elements(draft_find(d, VXS_VOXMAP_SECTION_CLRX), 4, entries);
    set_elements(draft_find(d, VXS_VOXMAP_SECTION_CLRC), 4, entries);
    set_elements(draft_find(d, VXS_VOXMAP_SECTION_CLRP), 2048, m->chunk_count);
    return (uint64_t)m->grid->root_dims[0] * m->grid->root_dims[1] * m->grid->root_dims[2] == entries;
}

static void count_cells(map_draft *m, uint32_t state, const uint32_t corner[3], uint32_t edge, int64_t low[3],
                        int64_t high[3])
{
    if (state == VXS_CELL_FREE) return;
    uint64_t cells = (uint64_t)edge * edge * edge;
    if (state == VXS_CELL_SURFACE) m->grid->surface_cells += cells;
    if (state == VXS_CELL_INTERIOR) m->grid->interior_cells += cells;
    for (int axis = 0; axis < 3; axis++) {
        int64_t first = m->grid->origin_cell[axis] + corner[axis];
        if (first < low[axis]) low[axis] = first;
        if (first + edge - 1 > high[axis]) high[axis] = first + edge - 1;
    }
}

static void count_map(map_draft *m)
{
    int64_t low[3] = {INT64_MAX, INT64_MAX, INT64_MAX}, high[3] = {INT64_MIN, INT64_MIN, INT64_MIN};
    const uint32_t *dims = m->grid->root_dims;
    for (int axis = 0; axis < 3; axis++) {
        if (m->grid->origin_cell[axis] > INT64_C(1) << 50 || m->grid->origin_cell[axis] < -(INT64_C(1) << 50))
            return;
    }
    m->grid->surface_cells = m->grid->interior_cells = 0;
    for (uint32_t n = 0; n < m->root_count; n++) {
        const uint32_t chunk[3] = {n / dims[2] / dims[1] * 64, n / dims[2] % dims[1] * 64, n % dims[2] * 64};
        if (m->root[n] < 4) count_cells(m, m->root[n], chunk, 64, low, high);
        for (uint32_t slot = 0; slot < 512 && m->root[n] >= 4; slot++) {
            uint32_t entry = m->chunks[(m->root[n] - 4) * 512 + slot];
            const uint32_t brick[3] = {chunk[0] + (slot >> 6) * 8, chunk[1] + (slot >> 3 & 7) * 8,
                                       chunk[2] + (slot & 7) * 8};
            if (entry < 4) count_cells(m, entry, brick, 8, low, high);
            for (uint32_t cell = 0; cell < 512 && entry >= 4; cell++) {
                const uint32_t at[3] = {brick[0] + (cell >> 6), brick[1] + (cell >> 3 & 7),
                                        brick[2] + (cell & 7)};
                count_cells(m, vxs_voxmap_brick_state(m->bricks + (size_t)(entry - 4) * 16, cell), at, 1, low,
                            high);
            }
        }
    }
    memcpy(m->grid->bbox_min, low, sizeof low);
    memcpy(m->grid->bbox_max, high, sizeof high);
}

static void fit_channels(map_draft *m)
{
    int8_t *layers = map_bytes(m, VXS_VOXMAP_SECTION_LAYR);
    int16_t *distances = map_bytes(m, VXS_VOXMAP_SECTION_DIST);
    vxs_voxmap_grid *grid = m->grid;
    if (!layers) grid->layer_count = 0;
    if (layers && (grid->layer_count < 1 || grid->layer_count > 126)) grid->layer_count = 3;
    if (!distances) {
        grid->distance_step = grid->distance_band = grid->distance_error = 0;
        grid->flags &= 1u;
    }
    double most = distances ? grid->distance_band / grid->distance_step : 0;
    for (size_t n = 0; n < m->brick_count * 512; n++) {
        uint32_t state = vxs_voxmap_brick_state(m->bricks + n / 512 * 16, n % 512);
        if (layers) {
            int ring = layers[n] < 0 ? -layers[n] : layers[n], beyond = (int)grid->layer_count + 1;
            if (ring < 1 || ring > beyond) ring = beyond;
            layers[n] = (int8_t)(state == VXS_CELL_SURFACE ? 0 : state == VXS_CELL_INTERIOR ? -ring : ring);
        }
        if (distances) {
            int far = distances[n] < 0 ? -(distances[n] + 1) : distances[n];
            if (!(far <= most)) far = most >= 0 && most < 32767 ? (int)most : 0;
            int is_in = state == VXS_CELL_INTERIOR && !(grid->flags & VXS_VOXMAP_FLAG_UNSIGNED);
            distances[n] = (int16_t)(is_in ? -far : far);
        }
    }
}

static uint32_t map_around(const map_draft *m, uint32_t chunk)
{
    const uint32_t *dims = m->grid->root_dims;
    int64_t at[3] = {chunk / dims[2] / dims[1], chunk / dims[2] % dims[1], chunk % dims[2]};
    uint32_t own = m->root[chunk];
    for (int n = 0; n < 27 && own < 4; n++) {
        int64_t i = at[0] + n / 9 - 1, j = at[1] + n / 3 % 3 - 1, k = at[2] + n % 3 - 1;
        int is_in = i >= 0 && j >= 0 && k >= 0 && i < dims[0] && j < dims[1] && k < dims[2];
        if ((is_in ? m->root[(i * dims[1] + j) * dims[2] + k] : 0) != own) return 4;
    }
    return own;
}

static void fit_clearance(map_draft *m)
{
    draft_part *values_part = draft_find(m->d, VXS_VOXMAP_SECTION_CLRV);
    uint32_t *index = map_bytes(m, VXS_VOXMAP_SECTION_CLRX);
    int32_t *chunks = map_bytes(m, VXS_VOXMAP_SECTION_CLRC);
    if (!values_part || !index || !chunks) return;
    for (size_t n = 0; n < m->root_count; n++) {
        index[n] = map_around(m, (uint32_t)n);
        int far = chunks[n] < 0 ? -(chunks[n] + 1) : chunks[n];
        far = far < 96 ? 96 : far > 4096 ? 4096 : far;
        chunks[n] = index[n] == 0 ? far : index[n] == 2 ? -far : 0;
    }
    set_elements(values_part, 4096, number_entries(index, m->root_count, ASSET_MOST / 4096));
    const uint32_t *dims = m->grid->root_dims;
    for (uint32_t n = 0; n < m->root_count; n++) {
        if (index[n] < 4) continue;
        int8_t *values = (int8_t *)values_part->bytes + (size_t)(index[n] - 4) * 4096;
        const uint32_t chunk[3] = {n / dims[2] / dims[1] * 64, n / dims[2] % dims[1] * 64, n % dims[2] * 64};
        for (uint32_t block = 0; block < 4096; block++) {
            const uint32_t at[3] = {chunk[0] + (block >> 8) * 4 + 1, chunk[1] + (block >> 4 & 15) * 4 + 1,
                                    chunk[2] + (block & 15) * 4 + 1};
            /* A block's middle eight cells are in one brick. */
            uint32_t entry = m->root[n], first = entry, same = 1;
            if (entry >= 4)
                first = entry = m->chunks[(entry - 4) * 512 + vxs_voxmap_chunk_slot(at[0], at[1], at[2])];
            for (uint32_t e = 0; e < 8 && entry >= 4; e++) {
                uint32_t cell =
                    vxs_voxmap_brick_cell(at[0] + (e >> 2), at[1] + (e >> 1 & 1), at[2] + (e & 1));
                uint32_t found = vxs_voxmap_brick_state(m->bricks + (size_t)(entry - 4) * 16, cell);
                if (e == 0) first = found;
                same = same && found == first;
            }
            same = same && first != VXS_CELL_SURFACE;
            int far = values[block] < 0 ? -(values[block] + 1) : values[block];
            if (far < 1) far = 1;
            values[block] = (int8_t)(!same ? 0 : first == VXS_CELL_INTERIOR ? -far : far);
        }
    }
}

static void fit_planes(map_draft *m)
{
    vxs_voxmap_plane *planes = map_bytes(m, VXS_VOXMAP_SECTION_CLRP);
    for (size_t n = 0; planes && n < m->chunk_count * 512; n++) {
        int8_t *normal = planes[n].normal;
        int is_plane = normal[0] || normal[1] || normal[2];
        if (m->chunks[n] == VXS_CELL_INTERIOR || (!is_plane && planes[n].offset != 0))
            planes[n] = (vxs_voxmap_plane){{0, 0, 0}, -1};
        else if (is_plane)
            normal[n % 3] = 127;
    }
}

static void repair_map(draft *d, uint32_t leave)
{
    map_draft m;
    if (!map_open(&m, d, leave)) return;
    for (size_t n = 0; n < m.brick_count * 16 && !(leave & 8); n++)
        m.bricks[n] &= ~(m.bricks[n] << 1 & 0xAAAAAAAAAAAAAAAAu);
    if (!(leave & 16)) fit_channels(&m);
    if (!(leave & 32)) fit_clearance(&m);
    if (!(leave & 64)) fit_planes(&m);
    if (!(leave & 128)) count_map(&m);
}

/* ---- pointshell ---- */

static double away(const float *const position[3], size_t p, const double center[3])
{
    double square = 0;
    for (int axis = 0; axis < 3; axis++) {
        double step = (double)position[axis][p] - center[axis];
        square += step * step;
    }
    return sqrt(square);
}

static void fit_normals(float *const normal[3], size_t count)
{
    for (size_t p = 0; p < count; p++) {
        double x = (double)normal[0][p], y = (double)normal[1][p], z = (double)normal[2][p];
        double length = sqrt(x * x + y * y + z * z);
        int is_length = length > 0 && isfinite(length);
        normal[0][p] = is_length ? (float)(x / length) : 1;
        normal[1][p] = is_length ? (float)(y / length) : 0;
        normal[2][p] = is_length ? (float)(z / length) : 0;
    }
}

static void fit_spheres(vxs_pointshell_info *info, vxs_pointshell_cluster *clusters,
                        const float *const position[3])
{
    info->radius = 0;
    for (uint32_t n = 0; n < info->cluster_count; n++) {
        vxs_pointshell_cluster *c = &clusters[n];
        uint32_t left = info->point_count - n * 64;
        c->first = n * 64;
        c->count = left < 64 ? left : 64;
        c->reserved[0] = c->reserved[1] = 0;
        double center[3] = {(double)c->center[0], (double)c->center[1], (double)c->center[2]}, most = 0;
        for (uint32_t p = c->first; p < c->first + c->count; p++) {
            double radius = away(position, p, center), whole = away(position, p, info->center);
            if (radius > most) most = radius;
            if (whole > info->radius) info->radius = whole;
        }
        c->radius = (float)(most * 1.000001);
    }
    info->radius *= 1.000001;
}

static void repair_shell(draft *d, uint32_t leave)
{
    static const uint32_t ids[] = {VXS_POINTSHELL_SECTION_POSX, VXS_POINTSHELL_SECTION_POSY,
                                   VXS_POINTSHELL_SECTION_POSZ, VXS_POINTSHELL_SECTION_NRMX,
                                   VXS_POINTSHELL_SECTION_NRMY, VXS_POINTSHELL_SECTION_NRMZ,
                                   VXS_POINTSHELL_SECTION_AREA};
    draft_part *part = draft_find(d, VXS_POINTSHELL_SECTION_SHEL),
               *clusters = draft_find(d, VXS_POINTSHELL_SECTION_CLUS);
    float *array[7];
    if (!part || !clusters || part->size < sizeof(vxs_pointshell_info)) return;
    vxs_pointshell_info *info = (void *)part->bytes;
    if (info->point_count < 1 || info->point_count > 1024) info->point_count = 1 + info->point_count % 1024;
    size_t padded = (info->point_count + 15) / 16 * 16;
    if (!(leave & 1)) info->padded_count = (uint32_t)padded;
    if (!(leave & 2)) info->cluster_count = (info->point_count + 63) / 64;
    if (leave & 3) return;
    set_elements(clusters, sizeof(vxs_pointshell_cluster), info->cluster_count);
    for (int n = 0; n < 7; n++) {
        part = draft_find(d, ids[n]);
        if (!part && n < 6) return;
        if (!(leave & 4)) set_elements(part, 4, padded);
        if (part && part->size < 4 * padded) return;
        array[n] = part ? (float *)(void *)part->bytes : NULL;
    }
    d->header.required_features = array[6] ? 0 : VXS_POINTSHELL_FEATURE_NO_AREA;
    if (!(leave & 8)) fit_normals(array + 3, info->point_count);
    if (!(leave & 16)) {
        for (int n = 0; n < 7 && array[n]; n++) {
            for (size_t p = info->point_count; p < padded; p++)
                array[n][p] = n == 6 ? 0 : array[n][info->point_count - 1];
        }
    }
    if (array[6] && !(leave & 32)) {
        info->area = 0;
        for (uint32_t p = 0; p < info->point_count; p++) {
            array[6][p] = fabsf(array[6][p]);
            info->area += (double)array[6][p];
        }
    }
    const float *const position[3] = {array[0], array[1], array[2]};
    if (!(leave & 64)) fit_spheres(info, (void *)clusters->bytes, position);
    if (info->surface_cells < 1 || info->surface_cells > info->point_count) info->surface_cells = 1;
}

/* ---- plan ---- */

static void fit_pose(double orientation[4])
{
    double length = 0;
    for (int n = 0; n < 4; n++) length += orientation[n] * orientation[n];
    length = sqrt(length);
    if (fabs(length - 1) < 1e-7) return;
    for (int n = 0; n < 4; n++)
        orientation[n] = length > 0 && isfinite(length) ? orientation[n] / length : n == 0;
}

/* Kinds that the runtime has, with as many constants as it knows; returns the motion's number, or -1. */
static int fit_effects(draft_part *part)
{
    size_t count = draft_elements(part, sizeof(vxs_plan_effect));
    int motion = -1;
    for (size_t n = 0; n < count; n++) {
        vxs_plan_effect *effect = (vxs_plan_effect *)(void *)part->bytes + n;
        uint32_t kind = vxs_effect_kind_named((const char *)effect->kind), known = 0;
        if (!kind || effect->kind[sizeof effect->kind - 1]) {
            for (uint32_t at = 0; vxs_effect_kind_at(at); at++) {
                if (at == (effect->kind[0] + n) % 16) kind = vxs_effect_kind_at(at);
            }
        }
        vxs_effect fresh;
        if (vxs_effect_default(kind, &fresh) != VXS_OK) continue;
        vxs_effect_constants(kind, &known);
        if (strncmp((const char *)effect->kind, vxs_effect_kind_name(kind), sizeof effect->kind) != 0) {
            memset(effect, 0, sizeof *effect);
            strncpy((char *)effect->kind, vxs_effect_kind_name(kind), sizeof effect->kind - 1);
            memcpy(effect->constants, fresh.as.constants, known * sizeof(double));
        }
        if (effect->constant_count != known && effect->constant_count > VXS_PLAN_MAX_CONSTANTS)
            effect->constant_count = known;
        if (kind == VXS_EFFECT_MOTION) motion = (int)n;
    }
    return motion;
}

static void repair_plan(draft *d, uint32_t leave)
{
    draft_part *info_part = draft_find(d, VXS_PLAN_SECTION_PLAN),
               *assets = draft_find(d, VXS_PLAN_SECTION_ASST), *hand = draft_find(d, VXS_PLAN_SECTION_HAND),
               *moves = draft_find(d, VXS_PLAN_SECTION_MOVE);
    if (!(leave & 1)) (void)fit_effects(draft_find(d, VXS_PLAN_SECTION_EFCT));
    if (info_part && info_part->size >= sizeof(vxs_plan_info) && !(leave & 2)) {
        vxs_plan_info *info = (void *)info_part->bytes;
        fit_pose(info->mount_orientation);
        fit_pose(info->grip_orientation);
        if (info->evaluations == 0 && info->coupling == VXS_PLAN_COUPLING_QUASI_STATIC) info->evaluations = 1;
    }
    size_t count = draft_elements(assets, sizeof(vxs_plan_asset));
    for (size_t n = 0; n < count && !(leave & 4); n++) {
        vxs_plan_asset *asset = (vxs_plan_asset *)(void *)assets->bytes + n;
        asset->role = n + 1 < count ? VXS_PLAN_ROLE_STATIC : VXS_PLAN_ROLE_DYNAMIC;
        fit_pose(asset->orientation);
        if (n + 1 == count) {
            memset(asset->position, 0, sizeof asset->position + sizeof asset->orientation);
            asset->orientation[0] = 1;
        }
    }
    double before = -1;
    for (size_t n = 0; n < draft_elements(hand, sizeof(vxs_plan_keyframe)) && !(leave & 8); n++) {
        vxs_plan_keyframe *k = (vxs_plan_keyframe *)(void *)hand->bytes + n;
        if (!(k->time > before) || signbit(k->time)) k->time = before < 0 ? 0 : before + 0.25;
        before = k->time;
        fit_pose(k->orientation);
        if (n == 0 || k->move > VXS_PLAN_MOVE_TURN) k->move = VXS_PLAN_MOVE_STRAIGHT;
        if (k->move == VXS_PLAN_MOVE_STRAIGHT)
            memset(k->turn_about, 0, sizeof *k - offsetof(vxs_plan_keyframe, turn_about));
    }
    before = -1;
    uint32_t of = 0;
    for (size_t n = 0; n < draft_elements(moves, sizeof(vxs_plan_motion)) && !(leave & 16); n++) {
        vxs_plan_motion *m = (vxs_plan_motion *)(void *)moves->bytes + n;
        if (m->asset < of || m->asset + 1 >= count) m->asset = of;
        if (m->asset > of) before = -1;
        of = m->asset;
        if (!(m->time > before) || signbit(m->time)) m->time = before < 0 ? 0 : before + 0.25;
        before = m->time;
        fit_pose(m->orientation);
    }
}

void draft_repair(draft *d, uint32_t leave)
{
    if (memcmp(d->header.magic, VXS_VOXMAP_MAGIC, 8) == 0) repair_map(d, leave);
    if (memcmp(d->header.magic, VXS_POINTSHELL_MAGIC, 8) == 0) repair_shell(d, leave);
    if (memcmp(d->header.magic, VXS_PLAN_MAGIC, 8) == 0) repair_plan(d, leave);
}
