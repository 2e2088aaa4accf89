/* SPDX-License-Identifier: MIT
 *
 * The rules of formats/voxmap.md, in the order of their ids. Chunks and bricks are there once
 * each and in order, so every pass is linear in the file and needs no memory. Pure.
 */
#include "asset_check.h"
#include "voxshell/format/voxmap.h"

#include <math.h>

enum { GRID, ROOT, CHNK, BRIK, LAYR, DIST, CLRX, CLRV, CLRC, CLRP, KNOWN, FIRST_OPTIONAL = LAYR };

static const struct {
    uint32_t id, stride;
} layout[KNOWN] = {
    {VXS_VOXMAP_SECTION_GRID, sizeof(vxs_voxmap_grid)},
    {VXS_VOXMAP_SECTION_ROOT, 4},
    {VXS_VOXMAP_SECTION_CHNK, 4 * VXS_VOXMAP_CHUNK_ENTRIES},
    {VXS_VOXMAP_SECTION_BRIK, 8 * VXS_VOXMAP_BRICK_WORDS},
    {VXS_VOXMAP_SECTION_LAYR, 512},
    {VXS_VOXMAP_SECTION_DIST, 1024},
    {VXS_VOXMAP_SECTION_CLRX, 4},
    {VXS_VOXMAP_SECTION_CLRV, VXS_VOXMAP_CLEARANCE_BLOCKS},
    {VXS_VOXMAP_SECTION_CLRC, 4},
    {VXS_VOXMAP_SECTION_CLRP, sizeof(vxs_voxmap_plane) * VXS_VOXMAP_CHUNK_ENTRIES},
};

static const int64_t cell_limit = VXS_VOXMAP_MAX_INDEX;
static const uint64_t max_bricks = VXS_VOXMAP_MAX_BRICKS;

typedef struct map_check {
    vxsi_check *check;
    const vxs_container_section *section[KNOWN]; /* NULL for an absent optional one */
    const vxs_voxmap_grid *grid;
    const uint32_t *root, *chunks;
    const uint64_t *bricks;
    uint64_t surface, interior; /* counted */
    int64_t min[3], max[3];     /* found, relative cells */
} map_check;

static const void *bytes_of(const map_check *m, int which)
{
    return m->section[which] ? m->check->data + m->section[which]->offset : NULL;
}

static vxs_result refuse_at(const map_check *m, const char *rule, int which, uint64_t offset,
                            const char *text)
{
    return vxsi_refuse(m->check, VXS_CORRUPT, rule, layout[which].id, m->section[which]->offset + offset,
                       text);
}

static vxs_result check_sections(map_check *m)
{
    const vxs_container_section *table = vxsi_table(m->check->data);
    for (int n = 0; n < FIRST_OPTIONAL; n++) {
        if (table[n].id != layout[n].id) /* META is last, so a table that is too short fails here */
            return vxsi_refuse_entry(m->check, VXS_CORRUPT, "M101", &table[n],
                                     "not GRID, ROOT, CHNK, BRIK in order");
        m->section[n] = &table[n];
    }
    const vxs_container_section *next = &table[FIRST_OPTIONAL];
    for (int n = FIRST_OPTIONAL; n < KNOWN; n++) {
        m->section[n] = vxsi_find_section(m->check->data, layout[n].id);
        if (!m->section[n]) continue;
        if (m->section[n] != next)
            return vxsi_refuse_entry(m->check, VXS_CORRUPT, "M101", next,
                                     "LAYR, DIST, CLRX, CLRV, CLRC or CLRP is out of order");
        next++;
    }
    for (int n = 0; n < KNOWN; n++) {
        if (m->section[n] &&
            (m->section[n]->stride != layout[n].stride || (n == GRID && m->section[n]->count != 1)))
            return vxsi_refuse_entry(m->check, VXS_CORRUPT, "M102", m->section[n],
                                     "wrong stride, or not one GRID");
    }
    for (int n = LAYR; n <= DIST; n++) {
        if (m->section[n] && m->section[n]->count != m->section[BRIK]->count)
            return vxsi_refuse_entry(m->check, VXS_CORRUPT, "M103", m->section[n],
                                     "not one element per brick");
    }
    const vxs_container_section *index = m->section[CLRX], *values = m->section[CLRV],
                                *chunks = m->section[CLRC],
                                *there = index    ? index
                                         : values ? values
                                                  : chunks;
    const uint64_t entries = m->section[ROOT]->count;
    if (there && !(index && values && chunks && index->count == entries && chunks->count == entries))
        return vxsi_refuse_entry(
            m->check, VXS_CORRUPT, "M104", there,
            "CLRX, CLRV and CLRC are not all there, or not one entry per chunk of the box");
    const vxs_container_section *planes = m->section[CLRP];
    if (planes && !(there && planes->count == m->section[CHNK]->count))
        return vxsi_refuse_entry(m->check, VXS_CORRUPT, "M105", planes,
                                 "CLRP is there without CLRX, or not one element per chunk");
    return VXS_OK;
}

#define FIELD(name) offsetof(vxs_voxmap_grid, name)

static vxs_result refuse_grid(const map_check *m, const char *rule, size_t field, const char *text)
{
    return refuse_at(m, rule, GRID, field, text);
}

static vxs_result check_box(const map_check *m)
{
    const vxs_voxmap_grid *grid = m->grid;
    if (!(grid->voxel >= 1e-12 && grid->voxel <= 1e3))
        return refuse_grid(m, "M201", FIELD(voxel), "voxel is not within 1e-12 .. 1e3 m");
    for (size_t axis = 0; axis < 3; axis++) {
        int64_t origin = grid->origin_cell[axis];
        if (origin % VXS_VOXMAP_CHUNK_CELLS != 0 || origin < -cell_limit || origin >= cell_limit)
            return refuse_grid(m, "M202", FIELD(origin_cell) + 8 * axis,
                               "origin_cell is no multiple of 64 within 2^44");
    }
    for (size_t axis = 0; axis < 3; axis++) {
        if (grid->root_dims[axis] < 1)
            return refuse_grid(m, "M203", FIELD(root_dims) + 4 * axis, "an extent of the box is 0");
    }
    uint64_t entries = 1;
    for (size_t axis = 0; axis < 3; axis++) {
        uint32_t dims = grid->root_dims[axis];
        if (dims > VXS_VOXMAP_MAX_CELLS / VXS_VOXMAP_CHUNK_CELLS ||
            grid->origin_cell[axis] + (int64_t)VXS_VOXMAP_CHUNK_CELLS * dims > cell_limit) {
            refuse_grid(m, "M204", FIELD(root_dims) + 4 * axis, "the box exceeds 2^20 cells, or leaves 2^44");
            return VXS_LIMIT;
        }
        entries *= dims;
    }
    if (entries > VXS_VOXMAP_MAX_ROOT) {
        refuse_grid(m, "M205", FIELD(root_dims), "the box exceeds 2^24 chunks");
        return VXS_LIMIT;
    }
    if (m->section[BRIK]->count > max_bricks)
        return vxsi_refuse_entry(m->check, VXS_LIMIT, "M206", m->section[BRIK], "more than 2^28 bricks");
    if (m->section[ROOT]->count != entries)
        return vxsi_refuse_entry(m->check, VXS_CORRUPT, "M207", m->section[ROOT],
                                 "not one entry per chunk of the box");
    return VXS_OK;
}

/* Minus zero has a bit set, so 0 is compared as bits. */
static int is_bits_zero(double value)
{
    return value == 0 && !signbit(value);
}

static vxs_result check_fields(const map_check *m)
{
    const vxs_voxmap_grid *grid = m->grid;
    if (grid->flags & ~(uint32_t)(VXS_VOXMAP_FLAG_CLOSED | VXS_VOXMAP_FLAG_UNSIGNED))
        return refuse_grid(m, "M208", FIELD(flags), "an unknown flag is set");
    const uint8_t *bytes = (const uint8_t *)grid;
    for (size_t at = FIELD(reserved); at < sizeof *grid; at++) {
        if (bytes[at] != 0) return refuse_grid(m, "M208", at, "a reserved byte is not 0");
    }
    int has_layers = bytes_of(m, LAYR) != NULL, has_distances = bytes_of(m, DIST) != NULL;
    if (has_layers ? grid->layer_count < 1 || grid->layer_count > VXS_VOXMAP_MAX_LAYERS
                   : grid->layer_count != 0)
        return refuse_grid(m, "M209", FIELD(layer_count), "layer_count does not fit LAYR");
    double step = grid->distance_step, band = grid->distance_band, error = grid->distance_error;
    if (has_distances) {
        if (!(isfinite(step) && step >= 1e-30))
            return refuse_grid(m, "M210", FIELD(distance_step),
                               "distance_step is not finite, or below 1e-30");
        if (!(isfinite(band) && band >= step && band <= 32767.0 * step))
            return refuse_grid(m, "M210", FIELD(distance_band),
                               "distance_band is not within 1 .. 32767 steps");
        if (!(isfinite(error) && error >= 0))
            return refuse_grid(m, "M210", FIELD(distance_error), "distance_error is not finite, or negative");
    } else {
        if (!is_bits_zero(step)) return refuse_grid(m, "M210", FIELD(distance_step), "not 0 without DIST");
        if (!is_bits_zero(band)) return refuse_grid(m, "M210", FIELD(distance_band), "not 0 without DIST");
        if (!is_bits_zero(error)) return refuse_grid(m, "M210", FIELD(distance_error), "not 0 without DIST");
        if (grid->flags & VXS_VOXMAP_FLAG_UNSIGNED)
            return refuse_grid(m, "M210", FIELD(flags), "unsigned distances without DIST");
    }
    if (grid->surface_cells < 1)
        return refuse_grid(m, "M211", FIELD(surface_cells), "a map without a surface cell");
    return VXS_OK;
}

/* An entry is a uniform state, or the next chunk or brick that no entry had before. */
static int take_entry(uint32_t entry, uint64_t *next)
{
    if (entry == VXS_CELL_FREE || entry == VXS_CELL_INTERIOR) return 1;
    if ((uint64_t)entry != VXS_VOXMAP_ENTRY_FIRST + *next) return 0;
    ++*next;
    return 1;
}

static vxs_result check_root(const map_check *m)
{
    const uint32_t *dims = m->grid->root_dims;
    uint32_t least[3] = {UINT32_MAX, UINT32_MAX, UINT32_MAX}, most[3] = {0, 0, 0};
    uint64_t next = 0, index = 0;
    uint32_t at[3];
    for (at[0] = 0; at[0] < dims[0]; at[0]++) {
        for (at[1] = 0; at[1] < dims[1]; at[1]++) {
            for (at[2] = 0; at[2] < dims[2]; at[2]++, index++) {
                if (!take_entry(m->root[index], &next))
                    return refuse_at(m, "M301", ROOT, index * 4, "no uniform state, and not the next chunk");
                if (m->root[index] == VXS_CELL_FREE) continue;
                for (int axis = 0; axis < 3; axis++) {
                    if (at[axis] < least[axis]) least[axis] = at[axis];
                    if (at[axis] > most[axis]) most[axis] = at[axis];
                }
            }
        }
    }
    if (next != m->section[CHNK]->count)
        return refuse_at(m, "M301", ROOT, 0, "not as many chunks as entries for them");
    for (int axis = 0; axis < 3; axis++) {
        if (least[axis] != 0 || most[axis] != dims[axis] - 1)
            return refuse_at(m, "M302", ROOT, 0, "a side of the box is free throughout");
    }
    return VXS_OK;
}

static vxs_result check_chunks(const map_check *m)
{
    uint64_t next = 0, chunk_count = m->section[CHNK]->count;
    for (uint64_t chunk = 0; chunk < chunk_count; chunk++) {
        const uint32_t *entries = m->chunks + chunk * VXS_VOXMAP_CHUNK_ENTRIES;
        uint64_t chunk_at = chunk * VXS_VOXMAP_CHUNK_ENTRIES * 4;
        int uniform = 1; /* no two entries name one brick */
        for (uint32_t slot = 0; slot < VXS_VOXMAP_CHUNK_ENTRIES; slot++) {
            if (!take_entry(entries[slot], &next))
                return refuse_at(m, "M303", CHNK, chunk_at + slot * 4u,
                                 "no uniform state, and not the next brick");
            uniform = uniform && entries[slot] == entries[0];
        }
        if (uniform) return refuse_at(m, "M304", CHNK, chunk_at, "a chunk is uniform throughout");
    }
    if (next != m->section[BRIK]->count)
        return refuse_at(m, "M303", CHNK, 0, "not as many bricks as entries for them");
    return VXS_OK;
}

static const uint64_t even_bits = 0x5555555555555555u;

static vxs_result check_bricks(const map_check *m)
{
    int has_channel = m->section[LAYR] || m->section[DIST];
    for (uint64_t brick = 0; brick < m->section[BRIK]->count; brick++) {
        const uint64_t *words = m->bricks + brick * VXS_VOXMAP_BRICK_WORDS;
        uint64_t brick_at = brick * VXS_VOXMAP_BRICK_WORDS * 8, differ = 0;
        for (uint32_t n = 0; n < VXS_VOXMAP_BRICK_WORDS; n++) {
            if (words[n] & words[n] >> 1 & even_bits)
                return refuse_at(m, "M305", BRIK, brick_at + n * 8u, "a state is 3");
            differ |= words[n] ^ words[0];
        }
        int uniform = !differ && (words[0] == 0 || words[0] == even_bits << 1);
        if (uniform && !has_channel)
            return refuse_at(m, "M306", BRIK, brick_at, "a brick is uniform throughout");
    }
    return VXS_OK;
}

static void include_cells(map_check *m, const int64_t low[3], const int64_t high[3])
{
    for (int axis = 0; axis < 3; axis++) {
        if (low[axis] < m->min[axis]) m->min[axis] = low[axis];
        if (high[axis] > m->max[axis]) m->max[axis] = high[axis];
    }
}

static void count_cube(map_check *m, const int64_t low[3], int64_t edge)
{
    int64_t high[3] = {low[0] + edge - 1, low[1] + edge - 1, low[2] + edge - 1};
    include_cells(m, low, high);
    m->interior += (uint64_t)(edge * edge * edge);
}

static uint64_t ones(uint64_t bits)
{
    bits -= bits >> 1 & even_bits;
    bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
    bits = (bits + (bits >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
    return bits * 0x0101010101010101u >> 56;
}

/* Lowest and highest of 8 positions that are step bits apart; bits is not 0 there. */
static void extend(uint32_t bits, int step, int64_t corner, int64_t *low, int64_t *high)
{
    int least = 0, most = 7;
    while (!(bits >> (least * step) & 1u)) least++;
    while (!(bits >> (most * step) & 1u)) most--;
    *low = corner + least;
    *high = corner + most;
}

/* Word 2i + (j >> 2) holds row j & 3 of slice i in 16 bits, two bits a cell. */
static void count_brick(map_check *m, const uint64_t *words, const int64_t corner[3])
{
    uint32_t any_i = 0, any_j = 0, any_k = 0;
    for (uint32_t n = 0; n < VXS_VOXMAP_BRICK_WORDS; n++) {
        uint64_t surface = words[n] & even_bits, interior = words[n] >> 1 & even_bits,
                 used = surface | interior;
        m->surface += ones(surface);
        m->interior += ones(interior);
        if (!used) continue;
        any_i |= 1u << (n >> 1);
        for (uint32_t row = 0; row < 4; row++) {
            uint32_t cells = (uint32_t)(used >> (16 * row)) & 0xFFFFu;
            if (cells) any_j |= 1u << ((n & 1u) * 4 + row);
            any_k |= cells;
        }
    }
    if (!any_i) return;
    int64_t low[3], high[3];
    extend(any_i, 1, corner[0], &low[0], &high[0]);
    extend(any_j, 1, corner[1], &low[1], &high[1]);
    extend(any_k, 2, corner[2], &low[2], &high[2]);
    include_cells(m, low, high);
}

static void count_chunk(map_check *m, uint32_t chunk, const int64_t corner[3])
{
    const uint32_t *entries = m->chunks + (uint64_t)chunk * VXS_VOXMAP_CHUNK_ENTRIES;
    for (uint32_t slot = 0; slot < VXS_VOXMAP_CHUNK_ENTRIES; slot++) {
        int64_t low[3] = {corner[0] + (int64_t)(slot >> 6) * 8, corner[1] + (int64_t)(slot >> 3 & 7u) * 8,
                          corner[2] + (int64_t)(slot & 7u) * 8};
        uint32_t entry = entries[slot];
        if (entry == VXS_CELL_INTERIOR)
            count_cube(m, low, VXS_VOXMAP_BRICK_CELLS);
        else if (entry >= VXS_VOXMAP_ENTRY_FIRST)
            count_brick(m, m->bricks + (uint64_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_BRICK_WORDS,
                        low);
    }
}

static vxs_result check_counts(map_check *m)
{
    const vxs_voxmap_grid *grid = m->grid;
    for (int axis = 0; axis < 3; axis++) {
        m->min[axis] = INT64_MAX;
        m->max[axis] = INT64_MIN;
    }
    uint64_t index = 0;
    for (uint32_t i = 0; i < grid->root_dims[0]; i++) {
        for (uint32_t j = 0; j < grid->root_dims[1]; j++) {
            for (uint32_t k = 0; k < grid->root_dims[2]; k++, index++) {
                int64_t corner[3] = {(int64_t)i * 64, (int64_t)j * 64, (int64_t)k * 64};
                uint32_t entry = m->root[index];
                if (entry == VXS_CELL_INTERIOR)
                    count_cube(m, corner, VXS_VOXMAP_CHUNK_CELLS);
                else if (entry >= VXS_VOXMAP_ENTRY_FIRST)
                    count_chunk(m, entry - VXS_VOXMAP_ENTRY_FIRST, corner);
            }
        }
    }
    if (m->surface != grid->surface_cells)
        return refuse_grid(m, "M307", FIELD(surface_cells), "not the number of surface cells");
    if (m->interior != grid->interior_cells)
        return refuse_grid(m, "M307", FIELD(interior_cells), "not the number of interior cells");
    for (size_t axis = 0; axis < 3; axis++) {
        if (grid->bbox_min[axis] != grid->origin_cell[axis] + m->min[axis])
            return refuse_grid(m, "M308", FIELD(bbox_min) + 8 * axis, "not the least cell that is not free");
    }
    for (size_t axis = 0; axis < 3; axis++) {
        if (grid->bbox_max[axis] != grid->origin_cell[axis] + m->max[axis])
            return refuse_grid(m, "M308", FIELD(bbox_max) + 8 * axis,
                               "not the greatest cell that is not free");
    }
    return VXS_OK;
}

static uint32_t state_of(const map_check *m, uint64_t element)
{
    uint32_t cell = (uint32_t)(element % 512);
    uint64_t word = m->bricks[element / 512 * VXS_VOXMAP_BRICK_WORDS + (cell >> 5)];
    return (uint32_t)(word >> ((cell & 31u) << 1)) & 3u;
}

static vxs_result check_channels(const map_check *m)
{
    uint64_t cells = m->section[BRIK]->count * 512;
    const int8_t *layers = bytes_of(m, LAYR);
    int beyond = (int)m->grid->layer_count + 1;
    for (uint64_t n = 0; layers && n < cells; n++) {
        uint32_t state = state_of(m, n);
        int ring = state == VXS_CELL_INTERIOR ? -layers[n] : layers[n];
        if (state == VXS_CELL_SURFACE ? ring != 0 : ring < 1 || ring > beyond)
            return refuse_at(m, "M401", LAYR, n, "a layer does not fit its cell's state");
    }
    const int16_t *distances = bytes_of(m, DIST);
    int is_unsigned = (m->grid->flags & VXS_VOXMAP_FLAG_UNSIGNED) != 0;
    for (uint64_t n = 0; distances && n < cells; n++) {
        int value = distances[n];
        uint32_t state = state_of(m, n);
        int fits = is_unsigned
                       ? value >= 0
                       : (state != VXS_CELL_FREE || value >= 0) && (state != VXS_CELL_INTERIOR || value <= 0);
        if (!fits || !(fabs((double)value) * m->grid->distance_step <= m->grid->distance_band))
            return refuse_at(m, "M402", DIST, n * 2, "a distance exceeds the band or has the wrong sign");
    }
    return VXS_OK;
}

/* State of the eight cells around a block's centre, 1 (surface) where they differ. relative: of the block's
 * first cell. */
static uint32_t state_at_center(const map_check *m, const uint32_t relative[3])
{
    const uint32_t ci = relative[0], cj = relative[1], ck = relative[2];
    uint32_t entry = m->root[vxs_voxmap_root_index(m->grid->root_dims, ci, cj, ck)];
    if (entry < VXS_VOXMAP_ENTRY_FIRST) return entry;
    entry = m->chunks[(uint64_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES +
                      vxs_voxmap_chunk_slot(ci, cj, ck)];
    if (entry < VXS_VOXMAP_ENTRY_FIRST) return entry;
    const uint64_t *words = m->bricks + (uint64_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_BRICK_WORDS;
    uint32_t first = 0;
    for (uint32_t n = 0; n < 8; n++) {
        uint32_t cell = vxs_voxmap_brick_cell(ci + 1 + (n >> 2), cj + 1 + (n >> 1 & 1u), ck + 1 + (n & 1u));
        uint32_t state = vxs_voxmap_brick_state(words, cell);
        if (n == 0) first = state;
        if (state != first) return VXS_CELL_SURFACE;
    }
    return first;
}

/* The values of one chunk against the cells around the blocks' centres. */
static vxs_result check_clearances(const map_check *m, uint64_t element, const uint32_t chunk[3])
{
    const int8_t *values = (const int8_t *)bytes_of(m, CLRV) + element * VXS_VOXMAP_CLEARANCE_BLOCKS;
    for (uint32_t block = 0; block < VXS_VOXMAP_CLEARANCE_BLOCKS; block++) {
        const uint32_t cell[3] = {chunk[0] * 64 + (block >> 8) * 4, chunk[1] * 64 + (block >> 4 & 15u) * 4,
                                  chunk[2] * 64 + (block & 15u) * 4};
        uint32_t state = state_at_center(m, cell);
        int value = values[block];
        int fits = state == VXS_CELL_SURFACE ? value == 0 : state == VXS_CELL_FREE ? value > 0 : value < 0;
        if (!fits || value < -VXS_VOXMAP_CLEARANCE_BEYOND)
            return refuse_at(m, "M502", CLRV, element * VXS_VOXMAP_CLEARANCE_BLOCKS + block,
                             "a clearance does not fit the cells around its block's centre");
    }
    return VXS_OK;
}

/* The root entry that a chunk and the 26 around it share, VXS_VOXMAP_ENTRY_FIRST if they do not or are not
 * uniform. Outside the box all is free. */
static uint32_t entry_around(const map_check *m, const uint32_t chunk[3])
{
    const uint32_t *dims = m->grid->root_dims;
    uint32_t own = m->root[((uint64_t)chunk[0] * dims[1] + chunk[1]) * dims[2] + chunk[2]];
    for (uint32_t n = 0; n < 27; n++) { /* one that names a chunk is like no other */
        const uint32_t at[3] = {chunk[0] + n / 9 - 1, chunk[1] + n / 3 % 3 - 1, chunk[2] + n % 3 - 1};
        uint32_t entry = VXS_CELL_FREE;
        if (at[0] < dims[0] && at[1] < dims[1] && at[2] < dims[2])
            entry = m->root[((uint64_t)at[0] * dims[1] + at[1]) * dims[2] + at[2]];
        if (entry != own) return VXS_VOXMAP_ENTRY_FIRST;
    }
    return own;
}

static void chunk_of(const map_check *m, uint64_t n, uint32_t chunk[3])
{
    const uint32_t *dims = m->grid->root_dims;
    chunk[0] = (uint32_t)(n / dims[2] / dims[1]);
    chunk[1] = (uint32_t)(n / dims[2] % dims[1]);
    chunk[2] = (uint32_t)(n % dims[2]);
}

static vxs_result check_clearance(const map_check *m)
{
    const uint32_t *index = bytes_of(m, CLRX);
    const int32_t *chunks = bytes_of(m, CLRC);
    if (!index) return VXS_OK;
    uint64_t next = 0, count = m->section[CLRX]->count;
    for (uint64_t n = 0; n < count; n++) {
        uint32_t chunk[3];
        chunk_of(m, n, chunk);
        uint32_t around = entry_around(m, chunk);
        if (around < VXS_VOXMAP_ENTRY_FIRST
                ? index[n] != around
                : index[n] < VXS_VOXMAP_ENTRY_FIRST || !take_entry(index[n], &next))
            return refuse_at(m, "M501", CLRX, n * 4,
                             "not the state of the chunk and all around it, and not the next clearances");
    }
    if (next != m->section[CLRV]->count)
        return refuse_at(m, "M501", CLRX, 0, "not as many clearances as entries for them");
    for (uint64_t n = 0; n < count; n++) {
        uint32_t chunk[3];
        if (index[n] < VXS_VOXMAP_ENTRY_FIRST) continue;
        chunk_of(m, n, chunk);
        vxs_result result = check_clearances(m, index[n] - VXS_VOXMAP_ENTRY_FIRST, chunk);
        if (result != VXS_OK) return result;
    }
    for (uint64_t n = 0; n < count; n++) {
        int64_t value = index[n] == VXS_CELL_INTERIOR ? -(int64_t)chunks[n] : chunks[n];
        if (index[n] < VXS_VOXMAP_ENTRY_FIRST
                ? value < VXS_VOXMAP_CLEARANCE_LEAST || value > VXS_VOXMAP_CLEARANCE_MOST
                : value != 0)
            return refuse_at(m, "M503", CLRC, n * 4, "a chunk's clearance does not fit its entry of CLRX");
    }
    return VXS_OK;
}

/* The largest of the components of a plane's normal, by amount. */
static int longest(const vxs_voxmap_plane *plane)
{
    int most = 0;
    for (int axis = 0; axis < 3; axis++) {
        int component = plane->normal[axis] < 0 ? -plane->normal[axis] : plane->normal[axis];
        if (component > most) most = component;
    }
    return most;
}

static vxs_result check_planes(const map_check *m)
{
    const vxs_voxmap_plane *planes = bytes_of(m, CLRP);
    const uint64_t count = m->section[CHNK]->count * VXS_VOXMAP_CHUNK_ENTRIES;
    for (uint64_t n = 0; planes && n < count; n++) {
        const int length = longest(&planes[n]), offset = planes[n].offset;
        const int says_nothing = length == 0 && offset == -1;
        const int fits =
            m->chunks[n] == VXS_CELL_INTERIOR
                ? says_nothing
                : says_nothing || length == VXS_VOXMAP_PLANE_NORMAL || (length == 0 && offset == 0);
        if (!fits)
            return refuse_at(m, "M504", CLRP, n * sizeof *planes, "no plane, or it does not fit its brick");
    }
    return VXS_OK;
}

vxs_result vxsi_check_voxmap(vxsi_check *check)
{
    map_check m = {.check = check};
    vxs_result result = check_sections(&m);
    if (result != VXS_OK) return result;
    m.grid = bytes_of(&m, GRID);
    m.root = bytes_of(&m, ROOT);
    m.chunks = bytes_of(&m, CHNK);
    m.bricks = bytes_of(&m, BRIK);
    result = check_box(&m);
    if (result == VXS_OK) result = check_fields(&m);
    if (check->trusted) return result;
    if (result == VXS_OK) result = check_root(&m);
    if (result == VXS_OK) result = check_chunks(&m);
    if (result == VXS_OK) result = check_bricks(&m);
    if (result == VXS_OK) result = check_counts(&m);
    if (result == VXS_OK) result = check_channels(&m);
    if (result == VXS_OK) result = check_clearance(&m);
    if (result == VXS_OK) result = check_planes(&m);
    return result;
}
