/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L /* posix_memalign */

#include "asset_builder.h"
#include "check.h"

static built_asset block(size_t size)
{
    built_asset asset = {NULL, size};
    void *memory = NULL;
    CHECK(posix_memalign(&memory, 64, size) == 0);
    asset.data = memory;
    return asset;
}

void built_free(built_asset *asset)
{
    free(asset->data);
    asset->data = NULL;
    asset->size = 0;
}

built_asset built_prefix(const built_asset *asset, size_t size)
{
    built_asset copy = block(size);
    if (size > 0) memcpy(copy.data, asset->data, size);
    return copy;
}

/* Bit by bit, as the standard says: not the reader's code. */
static uint32_t crc32_of(const uint8_t *bytes, size_t size)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t n = 0; n < size; n++) {
        crc ^= bytes[n];
        for (int bit = 0; bit < 8; bit++) crc = crc & 1u ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
    }
    return crc ^ 0xFFFFFFFFu;
}

void built_seal(built_asset *asset)
{
    vxs_container_header *header = (vxs_container_header *)(void *)asset->data;
    vxs_container_section *table = (vxs_container_section *)(void *)(asset->data + 128);
    if (asset->size < 128) return;
    if (header->section_count <= 64 && 128 + 40 * (size_t)header->section_count <= asset->size) {
        for (uint32_t n = 0; n < header->section_count; n++) {
            if (table[n].offset > asset->size || table[n].size > asset->size - table[n].offset) continue;
            table[n].crc = crc32_of(asset->data + table[n].offset, (size_t)table[n].size);
        }
        header->table_crc = crc32_of(asset->data + 128, 40 * (size_t)header->section_count);
    }
    header->header_crc = crc32_of(asset->data, 124);
}

vxs_container_section *built_entry(const built_asset *asset, uint32_t id)
{
    vxs_container_header *header = (vxs_container_header *)(void *)asset->data;
    vxs_container_section *table = (vxs_container_section *)(void *)(asset->data + 128);
    for (uint32_t n = 0; n < header->section_count; n++) {
        if (table[n].id == id) return &table[n];
    }
    CHECK_FAIL("no such section");
}

void *built_bytes(const built_asset *asset, uint32_t id)
{
    return asset->data + built_entry(asset, id)->offset;
}

typedef struct part {
    uint32_t id, stride;
    uint64_t count;
    const void *bytes;
} part;

static built_asset assemble(const char *magic, const part *parts, uint32_t count)
{
    uint64_t end = 128 + 40 * (uint64_t)count;
    for (uint32_t n = 0; n < count; n++) end = (end + 63) / 64 * 64 + parts[n].stride * parts[n].count;
    built_asset asset = block((size_t)((end + 63) / 64 * 64));
    memset(asset.data, 0, asset.size);
    vxs_container_header *header = (vxs_container_header *)(void *)asset.data;
    memcpy(header->magic, magic, 8);
    header->version_major = 1;
    header->header_size = 128;
    header->file_size = asset.size;
    header->section_count = count;
    header->section_entry_size = 40;
    header->section_table_offset = 128;
    vxs_container_section *table = (vxs_container_section *)(void *)(asset.data + 128);
    uint64_t at = 128 + 40 * (uint64_t)count;
    for (uint32_t n = 0; n < count; n++) {
        at = (at + 63) / 64 * 64;
        table[n].id = parts[n].id;
        table[n].stride = parts[n].stride;
        table[n].count = parts[n].count;
        table[n].offset = at;
        table[n].size = parts[n].stride * parts[n].count;
        memcpy(asset.data + at, parts[n].bytes, (size_t)table[n].size);
        at += table[n].size;
    }
    built_seal(&asset);
    return asset;
}

/* Cells low - reach .. high + reach, k fastest. */
typedef struct field {
    int reach;
    int64_t low[3], size[3];
    int8_t *states, *layers;
    int16_t *distances;
} field;

enum { STEPS = 4096 }; /* of distance, in a cell */

static size_t field_index(const field *f, const int64_t cell[3])
{
    size_t index = 0;
    for (int axis = 0; axis < 3; axis++) {
        int64_t at = cell[axis] - f->low[axis];
        if (at < 0 || at >= f->size[axis]) return SIZE_MAX;
        index = index * (size_t)f->size[axis] + (size_t)at;
    }
    return index;
}

typedef struct map_maker {
    vxs_voxmap_grid grid;
    const int64_t *low, *high;
    built_cells *cells;
    const void *shape;
    int channels;
    const struct field *field; /* or NULL: channels of no meaning */
    uint32_t *root, *chunks;
    uint64_t *bricks;
    int8_t *layers;
    int16_t *distances;
    uint64_t chunk_count, brick_count;
} map_maker;

static uint32_t state_at(const map_maker *m, int64_t i, int64_t j, int64_t k)
{
    if (m->field) {
        size_t at = field_index(m->field, (const int64_t[3]){i, j, k});
        return at == SIZE_MAX ? VXS_CELL_FREE : (uint32_t)m->field->states[at];
    }
    if (i < m->low[0] || i > m->high[0] || j < m->low[1] || j > m->high[1] || k < m->low[2] || k > m->high[2])
        return VXS_CELL_FREE;
    return m->cells(m->shape, i, j, k);
}

/* Appends a brick; returns its entry, or the uniform state where that says it all. */
static uint32_t make_brick(map_maker *m, const int64_t corner[3])
{
    uint64_t words[16] = {0};
    uint32_t first = state_at(m, corner[0], corner[1], corner[2]);
    int is_uniform = first != VXS_CELL_SURFACE;
    int8_t layers[512];
    int16_t distances[512];
    for (int cell = 0; cell < 512; cell++) {
        uint32_t state =
            state_at(m, corner[0] + (cell >> 6), corner[1] + (cell >> 3 & 7), corner[2] + (cell & 7));
        words[cell / 32] |= (uint64_t)state << (cell % 32 * 2);
        is_uniform = is_uniform && state == first;
        m->grid.surface_cells += state == VXS_CELL_SURFACE;
        m->grid.interior_cells += state == VXS_CELL_INTERIOR;
        layers[cell] = (int8_t)(state == VXS_CELL_SURFACE ? 0
                                : state == VXS_CELL_FREE  ? 1 + cell % 3
                                                          : -1 - cell % 3);
        distances[cell] = (int16_t)(state == VXS_CELL_SURFACE ? cell % 5 - 2
                                    : state == VXS_CELL_FREE  ? 3 + cell % 4
                                                              : -3 - cell % 4);
        if (m->field) {
            const int64_t here[3] = {corner[0] + (cell >> 6), corner[1] + (cell >> 3 & 7),
                                     corner[2] + (cell & 7)};
            size_t index = field_index(m->field, here);
            int beyond = m->field->reach + 1;
            layers[cell] = index == SIZE_MAX ? (int8_t)beyond : m->field->layers[index];
            distances[cell] =
                index == SIZE_MAX ? (int16_t)(m->field->reach * STEPS) : m->field->distances[index];
            is_uniform =
                is_uniform && abs(layers[cell]) == beyond && abs(distances[cell]) == m->field->reach * STEPS;
        }
        if (state == VXS_CELL_FREE) continue;
        int64_t at[3] = {corner[0] + (cell >> 6), corner[1] + (cell >> 3 & 7), corner[2] + (cell & 7)};
        for (int axis = 0; axis < 3; axis++) {
            if (at[axis] < m->grid.bbox_min[axis]) m->grid.bbox_min[axis] = at[axis];
            if (at[axis] > m->grid.bbox_max[axis]) m->grid.bbox_max[axis] = at[axis];
        }
    }
    if (is_uniform) return first;
    uint64_t n = m->brick_count++;
    m->bricks = realloc(m->bricks, (size_t)m->brick_count * 128);
    m->layers = realloc(m->layers, (size_t)m->brick_count * 512);
    m->distances = realloc(m->distances, (size_t)m->brick_count * 1024);
    CHECK(m->bricks && m->layers && m->distances);
    memcpy(m->bricks + n * 16, words, sizeof words);
    memcpy(m->layers + n * 512, layers, sizeof layers);
    memcpy(m->distances + n * 512, distances, sizeof distances);
    return (uint32_t)(4 + n);
}

static uint32_t make_chunk(map_maker *m, const int64_t corner[3])
{
    uint32_t entries[512];
    int is_uniform = 1;
    for (int slot = 0; slot < 512; slot++) {
        int64_t at[3] = {corner[0] + (slot >> 6) * 8, corner[1] + (slot >> 3 & 7) * 8,
                         corner[2] + (slot & 7) * 8};
        entries[slot] = make_brick(m, at);
        is_uniform = is_uniform && entries[slot] < 4 && entries[slot] == entries[0];
    }
    if (is_uniform) return entries[0];
    uint64_t n = m->chunk_count++;
    m->chunks = realloc(m->chunks, (size_t)m->chunk_count * sizeof entries);
    CHECK(m->chunks);
    memcpy(m->chunks + n * 512, entries, sizeof entries);
    return (uint32_t)(4 + n);
}

static int64_t floor_64(int64_t cell)
{
    return (cell >= 0 ? cell / 64 : -((-cell + 63) / 64)) * 64;
}

static built_asset make_map(double voxel, const int64_t low[3], const int64_t high[3], built_cells *cells,
                            const void *shape, int channels, const field *f)
{
    map_maker m = {
        .low = low, .high = high, .cells = cells, .shape = shape, .channels = channels, .field = f};
    m.grid.voxel = voxel;
    m.grid.flags = VXS_VOXMAP_FLAG_CLOSED;
    size_t entries = 1;
    for (int axis = 0; axis < 3; axis++) {
        m.grid.origin_cell[axis] = floor_64(low[axis]);
        m.grid.root_dims[axis] = (uint32_t)((floor_64(high[axis]) - floor_64(low[axis])) / 64 + 1);
        m.grid.bbox_min[axis] = INT64_MAX;
        m.grid.bbox_max[axis] = INT64_MIN;
        entries *= m.grid.root_dims[axis];
    }
    m.root = calloc(entries, 4);
    CHECK(m.root != NULL);
    for (size_t n = 0; n < entries; n++) {
        int64_t at[3] = {(int64_t)(n / m.grid.root_dims[2] / m.grid.root_dims[1]),
                         (int64_t)(n / m.grid.root_dims[2] % m.grid.root_dims[1]),
                         (int64_t)(n % m.grid.root_dims[2])};
        for (int axis = 0; axis < 3; axis++) at[axis] = m.grid.origin_cell[axis] + 64 * at[axis];
        m.root[n] = make_chunk(&m, at);
    }
    const int steps = f ? STEPS : 4;
    if (channels & BUILT_LAYERS) m.grid.layer_count = f ? (uint32_t)f->reach : 2;
    if (channels & BUILT_DISTANCES) {
        m.grid.distance_step = voxel / steps;
        m.grid.distance_band = m.grid.distance_step * (f ? f->reach * steps : 2 * steps);
        m.grid.distance_error = m.grid.distance_step / 2;
    }
    part parts[8] = {
        {VXS_VOXMAP_SECTION_GRID, 192, 1, &m.grid},
        {VXS_VOXMAP_SECTION_ROOT, 4, entries, m.root},
        {VXS_VOXMAP_SECTION_CHNK, 2048, m.chunk_count, m.chunks},
        {VXS_VOXMAP_SECTION_BRIK, 128, m.brick_count, m.bricks},
    };
    uint32_t count = 4;
    if (channels & BUILT_LAYERS)
        parts[count++] = (part){VXS_VOXMAP_SECTION_LAYR, 512, m.brick_count, m.layers};
    if (channels & BUILT_DISTANCES)
        parts[count++] = (part){VXS_VOXMAP_SECTION_DIST, 1024, m.brick_count, m.distances};
    parts[count++] = (part){VXS_SECTION_META, 1, 2, "{}"};
    built_asset asset = assemble(VXS_VOXMAP_MAGIC, parts, count);
    free(m.root);
    free(m.chunks);
    free(m.bricks);
    free(m.layers);
    free(m.distances);
    return asset;
}

built_asset build_voxmap(double voxel, const int64_t low[3], const int64_t high[3], built_cells *cells,
                         const void *shape, int channels)
{
    return make_map(voxel, low, high, cells, shape, channels, NULL);
}

/* Rings around the surface: each pass takes one from the ring before. */
static void number_rings(field *f, size_t count)
{
    for (size_t n = 0; n < count; n++)
        f->layers[n] = (int8_t)(f->states[n] == VXS_CELL_SURFACE ? 0 : f->reach + 1);
    for (int ring = 1; ring <= f->reach; ring++) {
        int64_t at[3];
        for (at[0] = 0; at[0] < f->size[0]; at[0]++)
            for (at[1] = 0; at[1] < f->size[1]; at[1]++)
                for (at[2] = 0; at[2] < f->size[2]; at[2]++) {
                    size_t here = ((size_t)at[0] * (size_t)f->size[1] + (size_t)at[1]) * (size_t)f->size[2] +
                                  (size_t)at[2];
                    if (f->layers[here] != ring - 1) continue;
                    for (int n = 0; n < 27; n++) {
                        const int64_t next[3] = {f->low[0] + at[0] + n / 9 - 1,
                                                 f->low[1] + at[1] + n / 3 % 3 - 1,
                                                 f->low[2] + at[2] + n % 3 - 1};
                        size_t to = field_index(f, next);
                        if (to != SIZE_MAX && f->layers[to] > ring) f->layers[to] = (int8_t)ring;
                    }
                }
    }
    for (size_t n = 0; n < count; n++)
        if (f->states[n] == VXS_CELL_INTERIOR) f->layers[n] = (int8_t)-f->layers[n];
}

built_asset build_field_map(double voxel, const int64_t low[3], const int64_t high[3],
                            built_distance *distance, const void *shape, int reach)
{
    field f = {.reach = reach};
    int64_t box_low[3], box_high[3];
    size_t count = 1;
    for (int axis = 0; axis < 3; axis++) {
        box_low[axis] = f.low[axis] = low[axis] - reach;
        box_high[axis] = high[axis] + reach;
        f.size[axis] = high[axis] - low[axis] + 1 + 2 * reach;
        count *= (size_t)f.size[axis];
    }
    f.states = calloc(count, 1);
    f.layers = calloc(count, 1);
    f.distances = calloc(count, 2);
    CHECK(f.states && f.layers && f.distances);
    for (size_t n = 0; n < count; n++) {
        const size_t row = n / (size_t)f.size[2];
        const int64_t cell[3] = {f.low[0] + (int64_t)(row / (size_t)f.size[1]),
                                 f.low[1] + (int64_t)(row % (size_t)f.size[1]),
                                 f.low[2] + (int64_t)(n % (size_t)f.size[2])};
        double center[3], slopes = 0;
        for (int axis = 0; axis < 3; axis++) center[axis] = voxel * ((double)cell[axis] + 0.5);
        const double away = distance(shape, center);
        for (int axis = 0; axis < 3; axis++) {
            double near[3] = {center[0], center[1], center[2]};
            near[axis] += 1e-3 * voxel;
            slopes += fabs(distance(shape, near) - away) / (1e-3 * voxel);
        }
        f.states[n] = (int8_t)(fabs(away - 1e-9 * voxel) <= voxel / 2 * slopes ? VXS_CELL_SURFACE
                               : away > 0                                      ? VXS_CELL_FREE
                                                                               : VXS_CELL_INTERIOR);
        const double steps = away / voxel * STEPS, most = reach * STEPS;
        f.distances[n] = (int16_t)lround(steps > most ? most : steps < -most ? -most : steps);
    }
    number_rings(&f, count);
    built_asset asset = make_map(voxel, box_low, box_high, NULL, NULL, BUILT_LAYERS | BUILT_DISTANCES, &f);
    free(f.states);
    free(f.layers);
    free(f.distances);
    return asset;
}

static uint32_t ball_cell(const void *shape, int64_t i, int64_t j, int64_t k)
{
    const built_ball *ball = shape;
    const int64_t cell[3] = {i, j, k};
    double nearest = 0, farthest = 0;
    for (int axis = 0; axis < 3; axis++) {
        double low = ball->voxel * (double)cell[axis] - ball->center[axis], high = low + ball->voxel;
        double away = low > 0 ? low : high < 0 ? -high : 0;
        double beyond = fmax(fabs(low), fabs(high));
        nearest += away * away;
        farthest += beyond * beyond;
    }
    double square = ball->radius * ball->radius;
    return farthest < square ? VXS_CELL_INTERIOR : nearest <= square ? VXS_CELL_SURFACE : VXS_CELL_FREE;
}

built_asset build_ball_map(const built_ball *ball, int channels)
{
    int64_t low[3], high[3];
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = (int64_t)floor((ball->center[axis] - ball->radius) / ball->voxel);
        high[axis] = (int64_t)floor((ball->center[axis] + ball->radius) / ball->voxel);
    }
    return build_voxmap(ball->voxel, low, high, ball_cell, ball, channels);
}

static uint32_t floor_cell(const void *shape, int64_t i, int64_t j, int64_t k)
{
    (void)i;
    (void)k;
    return j < ((const built_floor *)shape)->layer ? VXS_CELL_INTERIOR : VXS_CELL_SURFACE;
}

built_asset build_floor_map(double voxel, const built_floor *shape, int channels)
{
    int64_t low[3] = {-shape->reach, shape->layer - shape->depth, -shape->reach};
    int64_t high[3] = {shape->reach, shape->layer, shape->reach};
    return build_voxmap(voxel, low, high, floor_cell, shape, channels);
}

static uint32_t slot_cell(const void *shape, int64_t i, int64_t j, int64_t k)
{
    (void)i;
    (void)j;
    const built_slot *slot = shape;
    return k == slot->low || k == slot->high ? VXS_CELL_SURFACE : VXS_CELL_FREE;
}

built_asset build_slot_map(double voxel, const built_slot *slot)
{
    int64_t low[3] = {-slot->reach, -slot->reach, slot->low},
            high[3] = {slot->reach, slot->reach, slot->high};
    return build_voxmap(voxel, low, high, slot_cell, slot, BUILT_PLAIN);
}

/* A sphere about the middle of the points' box, a hair too large. */
static double sphere_of(const built_point *points, uint32_t count, double center[3])
{
    for (int axis = 0; axis < 3; axis++) {
        double least = INFINITY, most = -INFINITY;
        for (uint32_t n = 0; n < count; n++) {
            double at = points[n].position[axis];
            if (at < least) least = at; /* fmin() and fmax() here stop GCC 12 for AArch64 */
            if (at > most) most = at;
        }
        center[axis] = (float)((least + most) / 2);
    }
    double square = 0;
    for (uint32_t n = 0; n < count; n++) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) sum += pow(points[n].position[axis] - center[axis], 2);
        square = fmax(square, sum);
    }
    return sqrt(square) * 1.000001;
}

built_asset build_pointshell(double voxel, const built_point *points, uint32_t count)
{
    uint32_t padded = (count + 15) / 16 * 16, runs = (count + 63) / 64;
    vxs_pointshell_info info = {.voxel = voxel,
                                .kind = VXS_POINTSHELL_EXACT,
                                .point_count = count,
                                .padded_count = padded,
                                .cluster_count = runs,
                                .surface_cells = count};
    float *arrays = calloc(7 * (size_t)padded, sizeof *arrays);
    vxs_pointshell_cluster *clusters = calloc(runs, sizeof *clusters);
    CHECK(arrays && clusters);
    for (uint32_t n = 0; n < padded; n++) {
        const built_point *point = &points[n < count ? n : count - 1];
        for (uint32_t axis = 0; axis < 3; axis++) {
            arrays[axis * padded + n] = point->position[axis];
            arrays[(3 + axis) * padded + n] = point->normal[axis];
        }
        arrays[6 * padded + n] = n < count ? point->area : 0;
        if (n < count) info.area += (double)point->area;
    }
    info.radius = sphere_of(points, count, info.center);
    for (uint32_t run = 0; run < runs; run++) {
        double center[3];
        clusters[run].first = 64 * run;
        clusters[run].count = count - 64 * run < 64 ? count - 64 * run : 64;
        clusters[run].radius = (float)(sphere_of(points + 64 * run, clusters[run].count, center) * 1.000001);
        for (int axis = 0; axis < 3; axis++) clusters[run].center[axis] = (float)center[axis];
    }
    static const uint32_t ids[7] = {VXS_POINTSHELL_SECTION_POSX, VXS_POINTSHELL_SECTION_POSY,
                                    VXS_POINTSHELL_SECTION_POSZ, VXS_POINTSHELL_SECTION_NRMX,
                                    VXS_POINTSHELL_SECTION_NRMY, VXS_POINTSHELL_SECTION_NRMZ,
                                    VXS_POINTSHELL_SECTION_AREA};
    part parts[10] = {{VXS_POINTSHELL_SECTION_SHEL, sizeof info, 1, &info}};
    for (uint32_t n = 0; n < 7; n++) parts[1 + n] = (part){ids[n], 4, padded, arrays + n * padded};
    parts[8] = (part){VXS_POINTSHELL_SECTION_CLUS, sizeof *clusters, runs, clusters};
    parts[9] = (part){VXS_SECTION_META, 1, 2, "{}"};
    built_asset asset = assemble(VXS_POINTSHELL_MAGIC, parts, 10);
    free(arrays);
    free(clusters);
    return asset;
}

built_asset build_ball_shell(double voxel, double radius, uint32_t count)
{
    const double pi = acos(-1), golden = pi * (3 - sqrt(5));
    built_point *points = calloc(count, sizeof *points);
    CHECK(points != NULL);
    for (uint32_t n = 0; n < count; n++) {
        double y = 1 - 2 * (n + 0.5) / count, around = sqrt(1 - y * y), turn = golden * n;
        double direction[3] = {around * cos(turn), y, around * sin(turn)};
        for (int axis = 0; axis < 3; axis++) {
            points[n].position[axis] = (float)(radius * direction[axis]);
            points[n].normal[axis] = (float)-direction[axis];
        }
        points[n].area = (float)(4 * pi * radius * radius / count);
    }
    built_asset asset = build_pointshell(voxel, points, count);
    free(points);
    return asset;
}

built_asset build_block_shell(double voxel, const double half[3], const int count[3])
{
    uint32_t most = 0, made = 0;
    for (int axis = 0; axis < 3; axis++) most += (uint32_t)(2 * count[axis] * count[(axis + 1) % 3]);
    built_point *points = calloc(most, sizeof *points);
    CHECK(points != NULL);
    for (int face = 0; face < 6; face++) {
        const int axis = face / 2, a = (axis + 1) % 3, b = (axis + 2) % 3, side = face % 2 ? 1 : -1;
        for (int n = 0; n < count[a] * count[b]; n++, made++) {
            points[made].position[axis] = (float)(side * half[axis]);
            points[made].position[a] = (float)(half[a] * ((2 * (n / count[b]) + 1.0) / count[a] - 1));
            points[made].position[b] = (float)(half[b] * ((2 * (n % count[b]) + 1.0) / count[b] - 1));
            points[made].normal[axis] = (float)-side;
            points[made].area = (float)(4 * half[a] * half[b] / (count[a] * count[b]));
        }
    }
    built_asset asset = build_pointshell(voxel, points, made);
    free(points);
    return asset;
}

static vxs_asset open_asset(const built_asset *bytes, uint32_t kind)
{
    vxs_asset_config config;
    vxs_asset_issue issue;
    vxs_asset asset;
    vxs_asset_config_default(&config);
    config.kind = kind;
    vxs_result result = vxs_asset_from_memory(bytes->data, bytes->size, &config, &asset, &issue);
    if (result != VXS_OK)
        CHECK_FAIL("%s %c%u at %llu: %s", vxs_result_name(result), issue.letter ? issue.letter : '-',
                   issue.rule, (unsigned long long)issue.offset, issue.text);
    return asset;
}

vxs_voxmap open_voxmap(const built_asset *asset)
{
    vxs_asset opened = open_asset(asset, VXS_ASSET_VOXMAP);
    vxs_voxmap map;
    CHECK_INT(vxs_voxmap_open(&opened, &map), VXS_OK);
    return map;
}

vxs_pointshell open_pointshell(const built_asset *asset)
{
    vxs_asset opened = open_asset(asset, VXS_ASSET_POINTSHELL);
    vxs_pointshell shell;
    CHECK_INT(vxs_pointshell_open(&opened, &shell), VXS_OK);
    return shell;
}
