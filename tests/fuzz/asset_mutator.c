/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L /* scandir */
#include "asset_mutator.h"
#include "fuzz_target.h"

#include <dirent.h>
#include <math.h>
#include <string.h>

enum { HEADER = sizeof(vxs_container_header), ENTRY = sizeof(vxs_container_section) };

static uint64_t state;

static uint32_t below(uint32_t end)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)((state >> 32) * end >> 32);
}

/* ---- checksums, by a table: they are most of a mutation's time ---- */

static uint32_t crc_of(const uint8_t *bytes, size_t size)
{
    static uint32_t table[256];
    if (!table[1]) {
        for (uint32_t n = 0; n < 256; n++) {
            table[n] = n;
            for (int bit = 0; bit < 8; bit++)
                table[n] = table[n] >> 1 ^ (0xEDB88320u & (0u - (table[n] & 1u)));
        }
    }
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t n = 0; n < size; n++) crc = crc >> 8 ^ table[(crc ^ bytes[n]) & 0xFFu];
    return ~crc;
}

uint64_t asset_variant(const uint8_t *bytes, size_t size)
{
    uint64_t variant = 0;
    if (size < sizeof(vxs_container_header)) return 0;
    memcpy(&variant, bytes + offsetof(vxs_container_header, content_hash), sizeof variant);
    variant *= 0x9E3779B97F4A7C15u;
    return variant ^ variant >> 32;
}

int asset_is_summed(uint64_t variant)
{
    return (variant >> 56 & 7u) == 0;
}

/* All checksums made right that will be looked at, as far as the table can be followed. */
static void seal(uint8_t *bytes, size_t size)
{
    vxs_container_header header;
    if (size < HEADER) return;
    memcpy(&header, bytes, sizeof header);
    if (header.section_count <= VXS_CONTAINER_MAX_SECTIONS &&
        HEADER + (size_t)ENTRY * header.section_count <= size) {
        for (uint32_t n = 0; n < header.section_count && asset_is_summed(asset_variant(bytes, size)); n++) {
            vxs_container_section entry;
            memcpy(&entry, bytes + HEADER + (size_t)n * ENTRY, sizeof entry);
            if (entry.offset > size || entry.size > size - entry.offset) continue;
            entry.crc = crc_of(bytes + entry.offset, (size_t)entry.size);
            memcpy(bytes + HEADER + (size_t)n * ENTRY, &entry, sizeof entry);
        }
        header.table_crc = crc_of(bytes + HEADER, (size_t)ENTRY * header.section_count);
        memcpy(bytes, &header, sizeof header);
    }
    header.header_crc = crc_of(bytes, offsetof(vxs_container_header, header_crc));
    memcpy(bytes, &header, sizeof header);
}

/* ---- apart and together ---- */

static uint8_t *room_of(uint32_t part)
{
    static uint8_t room[VXS_CONTAINER_MAX_SECTIONS][ASSET_MOST] __attribute__((aligned(64)));
    return room[part];
}

static int take_apart(draft *d, const uint8_t *bytes, size_t size)
{
    if (size < HEADER) return 0;
    memcpy(&d->header, bytes, sizeof d->header);
    d->count = d->header.section_count;
    if (d->count < 1 || d->count > VXS_CONTAINER_MAX_SECTIONS || HEADER + (size_t)ENTRY * d->count > size)
        return 0;
    for (uint32_t n = 0; n < VXS_CONTAINER_MAX_SECTIONS; n++) d->part[n].bytes = room_of(n);
    for (uint32_t n = 0; n < d->count; n++) {
        draft_part *part = &d->part[n];
        memcpy(&part->entry, bytes + HEADER + (size_t)n * ENTRY, sizeof part->entry);
        uint64_t offset = part->entry.offset, length = part->entry.size;
        if (offset > size) offset = size;
        if (length > size - offset) length = size - offset;
        if (length > ASSET_MOST) length = ASSET_MOST;
        part->size = (size_t)length;
        memcpy(part->bytes, bytes + offset, part->size);
    }
    return 1;
}

static uint64_t round64(uint64_t size)
{
    return (size + 63) / 64 * 64;
}

/* Sections one after the other, as the table's order says; returns 0 if that is too much. */
static size_t put_together(draft *d, uint8_t *bytes, size_t most)
{
    uint64_t end = HEADER + (uint64_t)ENTRY * d->count;
    for (uint32_t n = 0; n < d->count; n++) {
        draft_part *part = &d->part[n];
        part->entry.offset = round64(end);
        part->entry.size = part->size;
        if (part->entry.stride) part->entry.count = part->size / part->entry.stride;
        end = part->entry.offset + part->size;
    }
    size_t size = (size_t)round64(end);
    if (size > most) return 0;
    d->header.section_count = d->count;
    d->header.file_size = size;
    memset(bytes, 0, size);
    memcpy(bytes, &d->header, sizeof d->header);
    for (uint32_t n = 0; n < d->count; n++) {
        memcpy(bytes + HEADER + (size_t)n * ENTRY, &d->part[n].entry, ENTRY);
        memcpy(bytes + d->part[n].entry.offset, d->part[n].bytes, d->part[n].size);
    }
    return size;
}

draft_part *draft_find(draft *d, uint32_t id)
{
    for (uint32_t n = 0; n < d->count; n++) {
        if (d->part[n].entry.id == id) return &d->part[n];
    }
    return NULL;
}

size_t draft_elements(const draft_part *part, size_t stride)
{
    return part ? part->size / stride : 0;
}

/* ---- changes ---- */

/* A number that is worth trying in a field of this many bytes. */
static void put_number(uint8_t *at, size_t width)
{
    static const uint64_t whole[] = {0,
                                     1,
                                     2,
                                     3,
                                     4,
                                     5,
                                     7,
                                     8,
                                     15,
                                     16,
                                     63,
                                     64,
                                     65,
                                     96,
                                     127,
                                     128,
                                     255,
                                     256,
                                     4095,
                                     4096,
                                     4097,
                                     16384,
                                     16385,
                                     1u << 16,
                                     1u << 24,
                                     1u << 28,
                                     0x7FFFFFFF,
                                     0x80000000u,
                                     UINT32_MAX,
                                     UINT64_C(1) << 44,
                                     UINT64_C(1) << 62,
                                     INT64_MAX,
                                     UINT64_C(1) << 63};
    static const double real[] = {0,    -0.0, 1,    -1,    0.5,   1e-12, 1e-30, 5e-324, 1e3, 1e15,
                                  1e16, 1e38, 1e39, 1e300, 0.001, 0.6,   0.8,   3600,   1e9, 1e-6};
    uint64_t value = whole[below(sizeof whole / sizeof *whole)];
    switch (below(8)) {
    case 0:
        value = 0 - value;
        break;
    case 1: /* what is there, a little more or less */
        value = 0;
        memcpy(&value, at, width);
        value += (uint64_t)below(9) - 4;
        break;
    case 2: { /* not finite */
        double odd = below(2) ? (double)INFINITY : (double)NAN;
        float narrow = (float)odd;
        if (width == 8) memcpy(&value, &odd, 8);
        if (width == 4) memcpy(&value, &narrow, 4);
        break;
    }
    case 3:
    case 4: {
        double number = real[below(sizeof real / sizeof *real)] * (below(4) ? 1 : -1);
        float narrow = (float)number;
        if (width == 8) memcpy(&value, &number, 8);
        if (width == 4) memcpy(&value, &narrow, 4);
        break;
    }
    case 5: { /* what is there, scaled */
        double number;
        float narrow;
        static const double factor[] = {-1, 0.5, 2, 0.999999, 1.000001, 1e6, 1e-6};
        double by = factor[below(7)];
        if (width == 8) {
            memcpy(&number, at, 8);
            number *= by;
            memcpy(&value, &number, 8);
        } else if (width == 4) {
            memcpy(&narrow, at, 4);
            narrow *= (float)by;
            memcpy(&value, &narrow, 4);
        }
        break;
    }
    default:
        break;
    }
    memcpy(at, &value, width); /* little-endian */
}

static void change_header(draft *d)
{
    static const uint8_t field[][2] = {{0, 8},  {8, 2},  {10, 2}, {12, 4}, {24, 4},  {28, 4}, {32, 4},
                                       {36, 4}, {40, 8}, {48, 8}, {80, 8}, {116, 4}, {120, 4}};
    uint32_t which = below(sizeof field / sizeof *field);
    put_number((uint8_t *)&d->header + field[which][0], field[which][1]);
}

static void change_bytes(draft *d)
{
    draft_part *part = &d->part[below(d->count)];
    if (part->size == 0) return;
    if (below(6) == 0) {
        size_t at = below((uint32_t)part->size), run = 1 + below(24);
        if (run > part->size - at) run = part->size - at;
        (void)LLVMFuzzerMutate(part->bytes + at, run, run);
        return;
    }
    for (uint32_t n = 1 + below(3); n > 0; n--) {
        size_t width = (size_t)1 << below(4), count = part->size / width;
        /* Information sections are a few fields among thousands of elements: near the start more often. */
        size_t end = below(2) && count > 64 ? 64 : count;
        if (count > 0) put_number(part->bytes + width * below((uint32_t)end), width);
    }
}

/* A few elements copied onto others: what one part of a file says, in another place. */
static void copy_elements(draft *d)
{
    draft_part *part = &d->part[below(d->count)];
    size_t width = (size_t)1 << below(8), count = part->size / width;
    if (count < 2) return;
    memmove(part->bytes + width * below((uint32_t)count), part->bytes + width * below((uint32_t)count),
            width);
}

/* Elements more or fewer. */
static void resize_part(draft *d)
{
    draft_part *part = &d->part[below(d->count)];
    size_t stride = part->entry.stride && part->entry.stride <= 4096 ? part->entry.stride : 1;
    size_t change = stride * (1 + below(stride > 64 ? 2 : 40));
    if (below(2)) {
        if (change < part->size) part->size -= change;
    } else if (part->size + change <= ASSET_MOST) {
        if (part->size >= change && below(2))
            memcpy(part->bytes + part->size, part->bytes + part->size - change, change);
        else
            memset(part->bytes + part->size, 0, change);
        part->size += change;
    }
}

static void swap_parts(draft *d, uint32_t one, uint32_t other)
{
    draft_part part = d->part[one];
    d->part[one] = d->part[other];
    d->part[other] = part;
}

static void change_table(draft *d)
{
    static const uint32_t names[] = {VXS_SECTION_ID('L', 'A', 'Y', 'R'),
                                     VXS_SECTION_ID('D', 'I', 'S', 'T'),
                                     VXS_SECTION_ID('C', 'L', 'R', 'X'),
                                     VXS_SECTION_ID('C', 'L', 'R', 'V'),
                                     VXS_SECTION_ID('C', 'L', 'R', 'C'),
                                     VXS_SECTION_ID('C', 'L', 'R', 'P'),
                                     VXS_SECTION_ID('A', 'R', 'E', 'A'),
                                     VXS_SECTION_ID('E', 'F', 'C', 'T'),
                                     VXS_SECTION_ID('H', 'A', 'N', 'D'),
                                     VXS_SECTION_ID('M', 'O', 'V', 'E'),
                                     VXS_SECTION_ID('X', 'T', 'R', 'A'),
                                     VXS_SECTION_META,
                                     VXS_SECTION_HEAD,
                                     VXS_SECTION_TABL};
    uint32_t at = below(d->count);
    switch (below(5)) {
    case 0:
        d->part[at].entry.id = names[below(sizeof names / sizeof *names)];
        break;
    case 1:
        swap_parts(d, at, below(d->count));
        break;
    case 2: /* out */
        if (d->count < 2) break;
        for (uint32_t n = at; n + 1 < d->count; n++) swap_parts(d, n, n + 1);
        d->count--;
        break;
    case 3: { /* in, before META */
        if (d->count >= VXS_CONTAINER_MAX_SECTIONS) break;
        draft_part *part = &d->part[d->count];
        uint8_t *room = part->bytes;
        *part = d->part[at];
        part->bytes = room;
        memcpy(part->bytes, d->part[at].bytes, part->size);
        part->entry.id = names[below(sizeof names / sizeof *names)];
        swap_parts(d, d->count, d->count - 1);
        d->count++;
        break;
    }
    default:
        put_number((uint8_t *)&d->part[at].entry + (below(2) ? 4 : 36), 4);
    }
}

/* A field of the table that layout and sealing would mend. */
static void change_layout(uint8_t *bytes, size_t size)
{
    static const uint8_t field[][2] = {{0, 4}, {4, 4}, {8, 8}, {16, 8}, {24, 8}, {32, 4}, {36, 4}};
    uint32_t count, which = below(8);
    memcpy(&count, bytes + offsetof(vxs_container_header, section_count), sizeof count);
    if (which == 7 || count == 0 || count > VXS_CONTAINER_MAX_SECTIONS) {
        put_number(bytes + offsetof(vxs_container_header, file_size), 8);
        return;
    }
    size_t at = HEADER + (size_t)ENTRY * below(count) + field[which][0];
    if (at + 8 <= size) put_number(bytes + at, field[which][1]);
}

size_t asset_mutate(uint8_t *bytes, size_t size, size_t most, uint32_t seed)
{
    static draft d;
    state = (seed + UINT64_C(1)) * 0x9E3779B97F4A7C15u;
    if (most > ASSET_MOST) most = ASSET_MOST;
    if (size > most) size = most;
    if (below(64) == 0 || !take_apart(&d, bytes, size)) {
        size = LLVMFuzzerMutate(bytes, size, most);
        if (below(4)) seal(bytes, size);
        return size;
    }
    for (uint32_t n = 1 + below(4); n > 0; n--) {
        switch (below(16)) {
        case 0:
            change_header(&d);
            break;
        case 1:
        case 2:
            change_table(&d);
            break;
        case 3:
        case 4:
            resize_part(&d);
            break;
        case 5:
        case 6:
            copy_elements(&d);
            break;
        default:
            change_bytes(&d);
        }
    }
    if (below(4)) draft_repair(&d, below(2) ? 0 : 1u << below(16));
    size_t done = put_together(&d, bytes, most);
    if (done == 0) return size;
    if (below(12) == 0) change_layout(bytes, done);
    if (below(64) == 0) done -= 1 + below(200) % (uint32_t)done; /* cut */
    if (below(64)) seal(bytes, done);
    if (below(64) == 0) bytes[below((uint32_t)done + (done == 0))] ^= (uint8_t)(1 << below(8));
    return done;
}

/* ---- seeds ---- */

enum { SEEDS_MOST = 512 };

typedef struct seeds {
    uint8_t *bytes[SEEDS_MOST];
    size_t size[SEEDS_MOST], count;
} seeds;

static int by_name(const struct dirent **one, const struct dirent **other)
{
    return strcmp((*one)->d_name, (*other)->d_name);
}

static void add_file(seeds *all, const char *folder, const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    all->bytes[all->count] = malloc(ASSET_MOST);
    FUZZ_CHECK(file && all->bytes[all->count]);
    all->size[all->count] = fread(all->bytes[all->count], 1, ASSET_MOST, file);
    FUZZ_CHECK(fgetc(file) == EOF);
    fclose(file);
    all->count++;
}

static void add_folder(seeds *all, const char *folder, const char *ending)
{
    struct dirent **entries = NULL;
    int found = scandir(folder, &entries, NULL, by_name);
    for (int n = 0; n < found; n++) {
        const char *name = entries[n]->d_name;
        size_t length = strlen(name), tail = strlen(ending);
        if (all->count < SEEDS_MOST && length > tail && strcmp(name + length - tail, ending) == 0)
            add_file(all, folder, name);
        free(entries[n]);
    }
    free(entries);
}

size_t asset_seed(const char *ending, uint32_t number, uint8_t *bytes, size_t most)
{
    static seeds all;
    if (all.count == 0) {
        add_folder(&all, VXS_TEST_SOURCE_DIR "/tests/golden/valid", ending);
        FUZZ_CHECK(all.count > 0);
        add_folder(&all, VXS_TEST_SOURCE_DIR "/tests/fuzz/corpus", ending);
    }
    number %= (uint32_t)all.count;
    size_t size = all.size[number];
    if (size > most) return 0;
    memcpy(bytes, all.bytes[number], size);
    return size;
}
