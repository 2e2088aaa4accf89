/* SPDX-License-Identifier: MIT
 *
 * The kernel on AVX-512, sixteen points at a time: the same operations in the same order as
 * contact_scalar.c and no fused multiply-add, so the same bits.
 */
#include "contact_channel.h"

#if defined(__x86_64__)

#include <immintrin.h>
#include <string.h>

/* Gathers index by signed 32 bits: beyond these counts the scalar probe takes over. */
static const uint64_t max_chunks = INT32_MAX / VXS_VOXMAP_CHUNK_ENTRIES;
static const uint64_t max_clearances = INT32_MAX / (VXS_VOXMAP_CLEARANCE_BLOCKS / 4);
static const uint64_t max_bricks = INT32_MAX / (2 * VXS_VOXMAP_BRICK_WORDS);

#define VXSI_TARGET __attribute__((target("avx512f,avx512vl,avx512dq,avx512bw")))
#define VXSI_AVX512 VXSI_TARGET static inline

/* Of three vectors as truth tables: which bits of _mm512_ternarylogic_epi32 are set. */
enum { A_XOR_B_OR_C = 0xBE, A_WHERE_C_ELSE_B = 0xE4 };
#define TERNARY(table, a, b, c) _mm512_ternarylogic_epi32(a, b, c, table)

VXSI_AVX512 __m512i all(uint32_t value)
{
    return _mm512_set1_epi32((int)value);
}

/* ((m0 x + m1 y) + m2 z) + b for the three rows */
VXSI_AVX512 void place(const vxsi_motion *motion, const __m512 at[3], __m512 u[3])
{
    for (int axis = 0; axis < 3; axis++) {
        const float *m = motion->m + 3 * axis;
        __m512 sum = _mm512_add_ps(_mm512_mul_ps(_mm512_set1_ps(m[0]), at[0]),
                                   _mm512_mul_ps(_mm512_set1_ps(m[1]), at[1]));
        sum = _mm512_add_ps(sum, _mm512_mul_ps(_mm512_set1_ps(m[2]), at[2]));
        u[axis] = _mm512_add_ps(sum, _mm512_set1_ps(motion->b[axis]));
    }
}

/* Index of 8 x 8 x 8 things from bits 3 .. 5 of each coordinate. */
VXSI_AVX512 __m512i chunk_slot(const __m512i c[3])
{
    __m512i low = TERNARY(A_WHERE_C_ELSE_B, _mm512_srli_epi32(c[2], 3), c[1], all(7));
    return _mm512_and_si512(TERNARY(A_WHERE_C_ELSE_B, _mm512_slli_epi32(c[0], 3), low, all(7 << 6)),
                            all(VXS_VOXMAP_CHUNK_ENTRIES - 1));
}

VXSI_AVX512 __mmask16 is_index(__m512i entry)
{
    return _mm512_cmpge_epi32_mask(entry, all(VXS_VOXMAP_ENTRY_FIRST));
}

/* Entry -> first element of its chunk or brick. */
VXSI_AVX512 __m512i first_of(__m512i entry, unsigned log2_size)
{
    return _mm512_slli_epi32(_mm512_sub_epi32(entry, all(VXS_VOXMAP_ENTRY_FIRST)), log2_size);
}

VXSI_AVX512 __m512i gather(__m512i otherwise, __mmask16 lanes, const void *base, __m512i index)
{
    return _mm512_mask_i32gather_epi32(otherwise, lanes, index, base, 4);
}

VXSI_AVX512 __m512i root_index(const vxs_voxmap *map, const __m512i c[3])
{
    __m512i index = _mm512_mullo_epi32(_mm512_srli_epi32(c[0], 6), all(map->root_dims[1]));
    index = _mm512_add_epi32(index, _mm512_srli_epi32(c[1], 6));
    index = _mm512_mullo_epi32(index, all(map->root_dims[2]));
    return _mm512_add_epi32(index, _mm512_srli_epi32(c[2], 6));
}

/* Blocks that are looked up together, step by step: a processor does not see far past what waits for a
 * gather, and so always has something to do. */
enum { AT_ONCE = 3 };
#define EACH for (int v = 0; v < AT_ONCE; v++)

/* From the entries of the cells' bricks to the cells' states. */
VXSI_AVX512 void states_of(const vxs_voxmap *map, __m512i c[AT_ONCE][3], __m512i state[AT_ONCE])
{
    __mmask16 lanes[AT_ONCE], any = 0;
    EACH any |= lanes[v] = is_index(state[v]);
    if (!any) return;
    EACH
    {
        /* Sixteen cells to a 32-bit half word: bits i2 i1 i0 j2 j1 say which, j0 k2 k1 k0 where. */
        __m512i word = _mm512_and_si512(
            TERNARY(A_WHERE_C_ELSE_B, _mm512_srli_epi32(c[v][1], 1), _mm512_slli_epi32(c[v][0], 2), all(3)),
            all(31));
        __m512i shift = _mm512_and_si512(
            TERNARY(A_WHERE_C_ELSE_B, _mm512_slli_epi32(c[v][1], 4), _mm512_slli_epi32(c[v][2], 1), all(16)),
            all(30));
        __m512i cells = gather(_mm512_setzero_si512(), lanes[v], map->bricks,
                               _mm512_add_epi32(first_of(state[v], 5), word));
        state[v] = _mm512_mask_and_epi32(state[v], lanes[v], _mm512_srlv_epi32(cells, shift), all(3));
    }
}

/* Adds to `differs` the bits in which the cells, rounded down, differ from the chunk's first one. What is no
 * cell is INT32_MIN. */
VXSI_AVX512 __m512i beyond_chunk(const vxsi_chunk *chunk, const __m512i c[3], __m512i differs)
{
    for (int axis = 0; axis < 3; axis++)
        differs = TERNARY(A_XOR_B_OR_C, c[axis], all(chunk->at[axis]), differs);
    return differs;
}

VXSI_AVX512 void enter_chunk(vxsi_chunk *chunk, const vxs_voxmap *map, const __m512i c[3])
{
    for (int axis = 0; axis < 3; axis++)
        chunk->at[axis] = (uint32_t)_mm512_cvtsi512_si32(c[axis]) & ~(uint32_t)(VXS_VOXMAP_CHUNK_CELLS - 1);
    chunk->entry = map->root[vxs_voxmap_root_index(map->root_dims, chunk->at[0], chunk->at[1], chunk->at[2])];
}

/* States of cells rounded down, wherever they are; those outside the box become cells of it. */
VXSI_AVX512 void states_anywhere(const vxs_voxmap *map, __m512i c[AT_ONCE][3], __m512i state[AT_ONCE])
{
    __mmask16 lanes[AT_ONCE], any = 0;
    EACH
    {
        __mmask16 inside = 0xFFFF; /* below 0 is far above as unsigned, and so is what is no cell */
        for (int axis = 0; axis < 3; axis++)
            inside = _mm512_mask_cmplt_epu32_mask(inside, c[v][axis], all(map->cells[axis]));
        for (int axis = 0; axis < 3; axis++) c[v][axis] = _mm512_maskz_mov_epi32(inside, c[v][axis]);
        state[v] = gather(all(VXS_CELL_FREE), inside, map->root, root_index(map, c[v]));
        any |= lanes[v] = is_index(state[v]);
    }
    if (!any) return;
    EACH state[v] =
        gather(state[v], lanes[v], map->chunks, _mm512_add_epi32(first_of(state[v], 9), chunk_slot(c[v])));
    states_of(map, c, state);
}

/* Appends the lanes in `hits`. */
VXSI_AVX512 void keep(vxsi_hits *found, const vxs_pointshell *shell, uint32_t point, const __m512i c[3],
                      __mmask16 hits)
{
    const __m512i places = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i order = _mm512_maskz_compress_epi32(hits, places);
    uint32_t n = found->count;
#define KEEP_F(array, from)                                                                                  \
    _mm512_storeu_ps((array) + n, _mm512_permutexvar_ps(order, _mm512_loadu_ps((from) + point)))
#define KEEP_I(array, v) _mm512_storeu_si512((array) + n, _mm512_permutexvar_epi32(order, v))
    KEEP_F(found->x, shell->x);
    KEEP_F(found->y, shell->y);
    KEEP_F(found->z, shell->z);
    KEEP_I(found->i, c[0]);
    KEEP_I(found->j, c[1]);
    KEEP_I(found->k, c[2]);
    if (found->take & VXSI_TAKE_NORMAL) {
        KEEP_F(found->nx, shell->nx);
        KEEP_F(found->ny, shell->ny);
        KEEP_F(found->nz, shell->nz);
    }
    if (found->take & VXSI_TAKE_AREA) KEEP_F(found->area, shell->area);
#undef KEEP_F
#undef KEEP_I
    n += (uint32_t)__builtin_popcount(hits);
    if (n > found->capacity) {
        n = found->capacity;
        found->overflow = 1;
    }
    found->count = n;
}

VXSI_TARGET static void probe_avx512(const vxs_voxmap *map, const vxs_pointshell *shell,
                                     const vxsi_motion *motion, const vxsi_block *blocks, uint32_t count,
                                     vxsi_hits *found)
{
    if (map->chunk_count > max_chunks || map->brick_count > max_bricks) {
        vxsi_probe_scalar(map, shell, motion, blocks, count, found);
        return;
    }
    vxsi_chunk chunk = found->chunk;
    const int takes_interior = (found->take & VXSI_TAKE_INTERIOR) != 0;
    for (uint32_t n = 0; n < count; n += AT_ONCE) {
        uint32_t point[AT_ONCE];
        __mmask16 which[AT_ONCE];
        __m512i c[AT_ONCE][3], state[AT_ONCE], differs = all(0);
        EACH
        {
            const int exists = (uint32_t)v < count - n;
            const vxsi_block *block = &blocks[exists ? n + (uint32_t)v : n];
            point[v] = block->first;
            which[v] = (__mmask16)(exists ? block->which : 0);
            const __m512 at[3] = {_mm512_loadu_ps(shell->x + point[v]), _mm512_loadu_ps(shell->y + point[v]),
                                  _mm512_loadu_ps(shell->z + point[v])};
            __m512 u[3];
            place(motion, at, u);
            for (int axis = 0; axis < 3; axis++)
                c[v][axis] = _mm512_cvt_roundps_epi32(u[axis], _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
            differs = beyond_chunk(&chunk, c[v], differs);
        }
        if (_mm512_test_epi32_mask(differs, all(~(uint32_t)(VXS_VOXMAP_CHUNK_CELLS - 1)))) {
            states_anywhere(map, c, state);
            enter_chunk(&chunk, map, c[AT_ONCE - 1]);
        } else if (chunk.entry < VXS_VOXMAP_ENTRY_FIRST) {
            EACH state[v] = all(chunk.entry);
        } else {
            const uint32_t *entries =
                map->chunks + (size_t)(chunk.entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES;
            EACH state[v] = _mm512_i32gather_epi32(chunk_slot(c[v]), entries, 4);
            states_of(map, c, state);
        }
        EACH
        {
            __mmask16 hits = _mm512_mask_test_epi32_mask(which[v], state[v], state[v]);
            if (!hits) continue;
            const __mmask16 surface = _mm512_mask_test_epi32_mask(hits, state[v], all(VXS_CELL_SURFACE));
            if (!takes_interior && hits != surface) {
                found->deep_count += (uint32_t)__builtin_popcount(hits ^ surface);
                hits = surface;
            }
            keep(found, shell, point[v], c[v], hits);
        }
    }
    found->chunk = chunk;
}

/* The clearance at the cells; *low: the bits of a cell within the cube that it is of. */
VXSI_AVX512 __m512 clearances(const vxs_voxmap *map, const __m512i c[3], __m512i *low)
{
    __m512i block = all(0), differs = all(0);
    for (int axis = 0; axis < 3; axis++) {
        block = _mm512_or_si512(_mm512_slli_epi32(block, 4),
                                _mm512_and_si512(_mm512_srli_epi32(c[axis], 2), all(15)));
        differs =
            TERNARY(A_XOR_B_OR_C, c[axis], _mm512_broadcastd_epi32(_mm512_castsi512_si128(c[axis])), differs);
    }
    __m512i word = _mm512_srli_epi32(block, 2);
    __m512 value = _mm512_setzero_ps();
    __mmask16 lanes = 0xFFFF;
    const int8_t *values = map->clearance;
    *low = all(3);
    if (!_mm512_test_epi32_mask(differs, all(~(uint32_t)(VXS_VOXMAP_CHUNK_CELLS - 1)))) {
        const size_t chunk =
            vxs_voxmap_root_index(map->root_dims, (uint32_t)_mm512_cvtsi512_si32(c[0]),
                                  (uint32_t)_mm512_cvtsi512_si32(c[1]), (uint32_t)_mm512_cvtsi512_si32(c[2]));
        const uint32_t entry = map->clearance_index[chunk];
        if (entry < VXS_VOXMAP_ENTRY_FIRST) {
            *low = all(VXS_VOXMAP_CHUNK_CELLS - 1);
            return _mm512_set1_ps((float)map->clearance_chunks[chunk]);
        }
        values += (size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CLEARANCE_BLOCKS;
    } else {
        const __m512i index = root_index(map, c);
        const __m512i entry = _mm512_i32gather_epi32(index, map->clearance_index, 4);
        lanes = is_index(entry);
        *low = _mm512_mask_mov_epi32(all(VXS_VOXMAP_CHUNK_CELLS - 1), lanes, all(3));
        if (lanes != 0xFFFF)
            value = _mm512_cvtepi32_ps(_mm512_i32gather_epi32(index, map->clearance_chunks, 4));
        if (!lanes) return value;
        word = _mm512_add_epi32(first_of(entry, 10), word);
    }
    word = gather(all(0), lanes, values, word);
    /* The byte to the top, then down again with its sign. */
    __m512i up = _mm512_slli_epi32(_mm512_andnot_si512(block, all(3)), 3);
    __m512 half = _mm512_cvtepi32_ps(_mm512_srai_epi32(_mm512_sllv_epi32(word, up), 24));
    return _mm512_mask_mul_ps(value, lanes, half, _mm512_set1_ps(0.5f));
}

VXSI_TARGET static void cull_avx512(const vxs_voxmap *map, const vxsi_spheres *spheres, uint32_t first,
                                    uint64_t wanted, const vxsi_motion *motion, vxsi_verdict *verdict)
{
    verdict->is_free = verdict->is_deep = 0;
    if (map->clearance_count > max_clearances) {
        vxsi_cull_scalar(map, spheres, first, wanted, motion, verdict);
        return;
    }
    const __m512 zero = _mm512_setzero_ps();
    for (uint32_t n = 0; n < VXSI_BATCH; n += VXSI_LANES) {
        if (!(wanted >> n & 0xFFFFu)) continue;
        const uint32_t s = first + n;
        const __m512 at[3] = {_mm512_loadu_ps(spheres->x + s), _mm512_loadu_ps(spheres->y + s),
                              _mm512_loadu_ps(spheres->z + s)};
        __m512 u[3], inside[3], square = zero;
        __m512i c[3], low;
        place(motion, at, u);
        for (int axis = 0; axis < 3; axis++) {
            /* max and min give their second operand for a NaN */
            inside[axis] =
                _mm512_min_ps(_mm512_max_ps(u[axis], zero), _mm512_set1_ps((float)map->cells[axis]));
            c[axis] = _mm512_min_epi32(_mm512_cvttps_epi32(inside[axis]), all(map->cells[axis] - 1));
        }
        const __m512 value = clearances(map, c, &low);
        const __m512i half = _mm512_srli_epi32(_mm512_add_epi32(low, all(1)), 1);
        for (int axis = 0; axis < 3; axis++) {
            __m512i center = _mm512_add_epi32(_mm512_andnot_si512(low, c[axis]), half);
            __m512 away = _mm512_sub_ps(inside[axis], _mm512_cvtepi32_ps(center));
            square = _mm512_add_ps(square, _mm512_mul_ps(away, away));
        }
        __m512 reach =
            _mm512_add_ps(_mm512_mul_ps(_mm512_loadu_ps(spheres->radius + s), _mm512_set1_ps(motion->scale)),
                          _mm512_set1_ps(motion->margin));
        __m512 left = _mm512_sub_ps(_mm512_abs_ps(value), _mm512_add_ps(_mm512_sqrt_ps(square), reach));
        uint64_t is_clear = _mm512_cmp_ps_mask(left, zero, _CMP_GE_OQ);
        uint64_t is_outside = _mm512_cmp_ps_mask(value, zero, _CMP_GT_OQ);
        _mm512_storeu_ps(verdict->slack + n, left);
        verdict->is_free |= (is_clear & is_outside) << n;
        verdict->is_deep |= (is_clear & ~is_outside) << n;
    }
}

#define VXSI_NAME(name) name##_avx512
#define VXSI_DOUBLES 8
#define VXSI_TO_DOUBLE(v) ((vd)_mm512_cvtepi32_pd((__m256i)(v)))
#define VXSI_FLOAT_DOUBLE(v) ((vd)_mm512_cvtps_pd((__m256)(v)))
#define VXSI_DOUBLE_FLOAT(v) ((vf)_mm512_cvtpd_ps((__m512d)(v)))
#define VXSI_LARGER(a, b) ((vd)_mm512_max_pd((__m512d)(a), (__m512d)(b)))
#include "contact_sum.h"
#define VXSI_SQRT(v) ((vd)_mm512_sqrt_pd((__m512d)(v)))
#define VXSI_TO_INT(v) ((vi)_mm512_cvttpd_epi32((__m512d)(v)))

/* Gathered where all corners are in one brick. */
VXSI_TARGET static void pairs_avx512(const vxsi_channel *channel, const vi corner[3], vu pairs[4])
{
    static const int steps[4] = {0, 8, 64, 72};
    const vxs_voxmap *map = channel->map;
    const vi i = corner[0], j = corner[1], k = corner[2];
    vi fits = ((i & 7) != 7) & ((j & 7) != 7) & ((k & 7) != 7); /* else outside the box, too */
    if (!channel->distances || map->brick_count > INT32_MAX / 512 || map->chunk_count > max_chunks)
        fits ^= fits;
    __mmask8 lanes = _mm256_movepi32_mask((__m256i)fits);
    const vi root =
        ((i >> 6) * (int32_t)map->root_dims[1] + (j >> 6)) * (int32_t)map->root_dims[2] + (k >> 6);
    const __m256i none = _mm256_setzero_si256(), first = _mm256_set1_epi32(VXS_VOXMAP_ENTRY_FIRST);
    const __m256i chunk = _mm256_mmask_i32gather_epi32(none, lanes, (__m256i)root, map->root, 4);
    lanes = _mm256_mask_cmpge_epi32_mask(lanes, chunk, first);
    const vi slot = ((vi)chunk - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES +
                    ((i << 3 & 7 << 6) | (j & 7 << 3) | (k >> 3 & 7));
    const __m256i brick = _mm256_mmask_i32gather_epi32(none, lanes, (__m256i)slot, map->chunks, 4);
    lanes = _mm256_mask_cmpge_epi32_mask(lanes, brick, first);
    const vi at = ((vi)brick - VXS_VOXMAP_ENTRY_FIRST) * 512 + ((i & 7) << 6 | (j & 7) << 3 | (k & 7));
    for (int e = 0; e < 4; e++) /* little-endian */
        pairs[e] =
            (vu)_mm256_mmask_i32gather_epi32(none, lanes, (__m256i)(at + steps[e]), channel->distances, 2);
    for (unsigned left = (unsigned)lanes ^ 0xFFu; left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        uint32_t own[4];
        vxsi_channel_pairs(channel, i[lane], j[lane], k[lane], own);
        for (int e = 0; e < 4; e++)
            pairs[e] = (vu)_mm256_mask_set1_epi32((__m256i)pairs[e], (__mmask8)(1u << lane), (int)own[e]);
    }
}

#include "contact_sample.h"
#define VXSI_WIDTH 16
#define VXSI_GATHER(base, index, lanes) ((vni)gather(all(0), VXSI_BITS(lanes), base, (__m512i)(index)))
#define VXSI_BITS(mask) _mm512_movepi32_mask((__m512i)(mask))
VXSI_AVX512 uint32_t list(uint32_t first, uint32_t which, vxsi_block *looks)
{
    const __m512i places = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i points = _mm512_slli_epi32(_mm512_add_epi32(places, all(first)), 4);
    const __m512i listed = _mm512_maskz_compress_epi32((__mmask16)which, points);
    const __m512i whole = _mm512_set1_epi64((int64_t)0xFFFF << 32);
    _mm512_storeu_si512(looks, _mm512_or_si512(_mm512_cvtepu32_epi64(_mm512_castsi512_si256(listed)), whole));
    _mm512_storeu_si512(looks + 8,
                        _mm512_or_si512(_mm512_cvtepu32_epi64(_mm512_extracti64x4_epi64(listed, 1)), whole));
    return (uint32_t)__builtin_popcount(which);
}
#define VXSI_LIST(first, which, looks) list(first, which, looks)
#define VXSI_SET(v) _mm512_test_epi32_mask((__m512i)(v), (__m512i)(v))
#include "contact_clear.h"

const vxsi_kernel vxsi_kernel_avx512 = {
    .cull = cull_avx512,
    .clear = clear_avx512,
    .probe = probe_avx512,
    .sample = sample_avx512,
    .mean = mean_avx512,
    .sum_common = sum_common_avx512,
    .sum_own = sum_own_avx512,
    .set_planes = set_planes_avx512,
};

#else
typedef int vxsi_no_avx512; /* a translation unit is not empty */
#endif
