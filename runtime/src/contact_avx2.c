/* SPDX-License-Identifier: MIT
 *
 * The kernel on AVX2, eight points at a time: the same operations in the same order as
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

#define VXSI_AVX2 __attribute__((target("avx2"))) static inline

/* ((m0 x + m1 y) + m2 z) + b */
VXSI_AVX2 __m256 row(const float *m, float b, __m256 x, __m256 y, __m256 z)
{
    __m256 sum =
        _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(m[0]), x), _mm256_mul_ps(_mm256_set1_ps(m[1]), y));
    sum = _mm256_add_ps(sum, _mm256_mul_ps(_mm256_set1_ps(m[2]), z));
    return _mm256_add_ps(sum, _mm256_set1_ps(b));
}

/* All ones where 0 <= u < extent; a NaN is outside. */
VXSI_AVX2 __m256 within(__m256 u, float extent)
{
    return _mm256_and_ps(_mm256_cmp_ps(u, _mm256_setzero_ps(), _CMP_GE_OQ),
                         _mm256_cmp_ps(u, _mm256_set1_ps(extent), _CMP_LT_OQ));
}

VXSI_AVX2 __m256i masked(__m256i v, int mask)
{
    return _mm256_and_si256(v, _mm256_set1_epi32(mask));
}

VXSI_AVX2 __m256i low_bits(__m256i v, int shift, int mask)
{
    return masked(_mm256_srli_epi32(v, shift), mask);
}

/* Index of 8 x 8 x 8 things from bits 3 .. 5 of each coordinate. */
VXSI_AVX2 __m256i chunk_slot(const __m256i c[3])
{
    return _mm256_or_si256(_mm256_or_si256(masked(_mm256_slli_epi32(c[0], 3), 7 << 6), masked(c[1], 7 << 3)),
                           low_bits(c[2], 3, 7));
}

VXSI_AVX2 __m256i gather(__m256i otherwise, const void *base, __m256i index, __m256i lanes)
{
    return _mm256_mask_i32gather_epi32(otherwise, (const int *)base, index, lanes, 4);
}

VXSI_AVX2 __m256i is_index(__m256i entry)
{
    return _mm256_cmpgt_epi32(entry, _mm256_set1_epi32(VXS_VOXMAP_ENTRY_FIRST - 1));
}

/* Entry -> first element of its chunk or brick. */
VXSI_AVX2 __m256i first_of(__m256i entry, int log2_size)
{
    return _mm256_slli_epi32(_mm256_sub_epi32(entry, _mm256_set1_epi32(VXS_VOXMAP_ENTRY_FIRST)), log2_size);
}

VXSI_AVX2 unsigned lanes_of(__m256i mask)
{
    return (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(mask));
}

VXSI_AVX2 __m256i root_index(const vxs_voxmap *map, const __m256i c[3])
{
    __m256i index = _mm256_mullo_epi32(_mm256_srli_epi32(c[0], 6), _mm256_set1_epi32((int)map->root_dims[1]));
    index = _mm256_add_epi32(index, _mm256_srli_epi32(c[1], 6));
    index = _mm256_mullo_epi32(index, _mm256_set1_epi32((int)map->root_dims[2]));
    return _mm256_add_epi32(index, _mm256_srli_epi32(c[2], 6));
}

/* Halves of a block, looked up together, step by step: a processor does not see far past what waits for a
 * gather, and so always has something to do. */
enum { HALVES = 2 };
#define EACH for (int v = 0; v < HALVES; v++)

/* Around the first of these cells, or the nearest one to it of the box. */
__attribute__((target("avx2"), noinline)) static void lay_cube(vxsi_cube *cube, const vxs_voxmap *map,
                                                               const __m256i c[3])
{
    const __m256i number = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), none = _mm256_set1_epi32(-1);
    __m256i index = _mm256_setzero_si256(), inside = none;
    for (int axis = 0; axis < 3; axis++) {
        const int32_t last = (int32_t)map->cells[axis] - 1;
        int32_t cell = _mm256_cvtsi256_si32(c[axis]);
        cell = cell < 0 ? 0 : cell < last ? cell : last;
        cube->at[axis] = (cell - VXS_VOXMAP_CHUNK_CELLS / 2) & ~(VXS_VOXMAP_CHUNK_CELLS - 1);
        const __m256i size = _mm256_set1_epi32((int32_t)map->root_dims[axis]);
        const __m256i at = _mm256_add_epi32(_mm256_set1_epi32(cube->at[axis] / VXS_VOXMAP_CHUNK_CELLS),
                                            low_bits(number, 2 - axis, 1));
        inside = _mm256_and_si256(
            inside, _mm256_and_si256(_mm256_cmpgt_epi32(at, none), _mm256_cmpgt_epi32(size, at)));
        index = _mm256_add_epi32(_mm256_mullo_epi32(index, size), at);
    }
    __m256i entry = gather(_mm256_setzero_si256(), map->root, index, inside); /* free outside */
    const __m256i begins = _mm256_or_si256(first_of(entry, 9), _mm256_set1_epi32(INT32_MIN));
    entry = _mm256_blendv_epi8(entry, begins, is_index(entry));
    _mm256_storeu_si256((__m256i *)(void *)cube->entry, entry);
}

/* From the entries of the cells' bricks to the cells' states. */
VXSI_AVX2 void states_of(const vxs_voxmap *map, __m256i c[HALVES][3], __m256i state[HALVES])
{
    __m256i lanes[HALVES];
    EACH lanes[v] = is_index(state[v]);
    if (!lanes_of(_mm256_or_si256(lanes[0], lanes[1]))) return;
    EACH
    {
        /* Sixteen cells to a 32-bit half word: bits i2 i1 i0 j2 j1 say which, j0 k2 k1 k0 where. */
        __m256i word = _mm256_or_si256(masked(_mm256_slli_epi32(c[v][0], 2), 28), low_bits(c[v][1], 1, 3));
        __m256i cells = gather(_mm256_setzero_si256(), map->bricks,
                               _mm256_add_epi32(first_of(state[v], 5), word), lanes[v]);
        __m256i shift = _mm256_or_si256(masked(_mm256_slli_epi32(c[v][1], 4), 16),
                                        masked(_mm256_slli_epi32(c[v][2], 1), 14));
        state[v] = _mm256_blendv_epi8(state[v], masked(_mm256_srlv_epi32(cells, shift), 3), lanes[v]);
    }
}

/* States of cells truncated from u, wherever they are; those outside the box become cells of it. */
VXSI_AVX2 void states_anywhere(const vxs_voxmap *map, __m256 u[HALVES][3], __m256i c[HALVES][3],
                               __m256i state[HALVES])
{
    __m256i lanes[HALVES];
    EACH
    {
        __m256 within_all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
        for (int axis = 0; axis < 3; axis++)
            within_all = _mm256_and_ps(within_all, within(u[v][axis], (float)map->cells[axis]));
        const __m256i inside = _mm256_castps_si256(within_all);
        for (int axis = 0; axis < 3; axis++) c[v][axis] = _mm256_and_si256(c[v][axis], inside);
        state[v] = gather(_mm256_setzero_si256(), map->root, root_index(map, c[v]), inside);
        lanes[v] = is_index(state[v]);
    }
    if (!lanes_of(_mm256_or_si256(lanes[0], lanes[1]))) return;
    EACH state[v] =
        gather(state[v], map->chunks, _mm256_add_epi32(first_of(state[v], 9), chunk_slot(c[v])), lanes[v]);
    states_of(map, c, state);
}

/* ((m0 x + m1 y) + m2 z) + b for the three rows */
VXSI_AVX2 void place(const vxsi_motion *motion, __m256 x, __m256 y, __m256 z, __m256 u[3])
{
    for (int axis = 0; axis < 3; axis++) u[axis] = row(motion->m + 3 * axis, motion->b[axis], x, y, z);
}

/* Appends the lanes in `hits`. */
VXSI_AVX2 void keep(vxsi_hits *found, const vxs_pointshell *shell, uint32_t point, const __m256i c[3],
                    unsigned hits)
{
    __m128i places = _mm_loadl_epi64((const __m128i *)(const void *)found->order[hits]);
    __m256i order = _mm256_cvtepu8_epi32(places);
    uint32_t n = found->count;
#define KEEP_F(array, from)                                                                                  \
    _mm256_storeu_ps((array) + n, _mm256_permutevar8x32_ps(_mm256_loadu_ps((from) + point), order))
#define KEEP_I(array, v)                                                                                     \
    _mm256_storeu_si256((__m256i *)(void *)((array) + n), _mm256_permutevar8x32_epi32(v, order))
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

__attribute__((target("avx2"))) static void probe_avx2(const vxs_voxmap *map, const vxs_pointshell *shell,
                                                       const vxsi_motion *motion, const vxsi_block *blocks,
                                                       uint32_t count, vxsi_hits *found)
{
    if (map->chunk_count > max_chunks || map->brick_count > max_bricks) {
        vxsi_probe_scalar(map, shell, motion, blocks, count, found);
        return;
    }
    const __m256i zero = _mm256_setzero_si256(),
                  beyond = _mm256_set1_epi32(~(2 * VXS_VOXMAP_CHUNK_CELLS - 1));
    /* The sign of an entry says that there is something to gather, and takes the index so far below. */
    const void *const chunks = (const void *)((uintptr_t)map->chunks + (UINT64_C(4) << 31));
    vxsi_cube *const cube = &found->cube;
    const int takes_interior = (found->take & VXSI_TAKE_INTERIOR) != 0;
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t point = blocks[n].first;
        __m256 u[HALVES][3], signs = _mm256_setzero_ps();
        __m256i c[HALVES][3], state[HALVES], which[HALVES], outside = zero;
        EACH
        {
            const __m256 at[3] = {_mm256_loadu_ps(shell->x + point + 8 * v),
                                  _mm256_loadu_ps(shell->y + point + 8 * v),
                                  _mm256_loadu_ps(shell->z + point + 8 * v)};
            place(motion, at[0], at[1], at[2], u[v]);
            which[v] = zero;
            for (int axis = 0; axis < 3; axis++) {
                c[v][axis] = _mm256_cvttps_epi32(u[v][axis]);
                signs = _mm256_or_ps(signs, u[v][axis]);
                const __m256i away = _mm256_sub_epi32(c[v][axis], _mm256_set1_epi32(cube->at[axis]));
                outside = _mm256_or_si256(outside, away);
                which[v] = _mm256_or_si256(_mm256_add_epi32(which[v], which[v]), _mm256_srli_epi32(away, 6));
            }
        }
        /* Truncation is floor where no sign is set; what is no cell is INT32_MIN, and in no cube. A cube, for in
         * cells so fine that a block is often in two chunks no processor foresees whether it is in one. */
        const int is_apart = !_mm256_testz_si256(outside, beyond);
        if (is_apart || _mm256_movemask_ps(signs)) {
            if (is_apart) lay_cube(cube, map, c[1]);
            states_anywhere(map, u, c, state);
        } else {
            const __m256i entries = _mm256_loadu_si256((const __m256i *)(const void *)cube->entry);
            EACH state[v] = _mm256_permutevar8x32_epi32(entries, which[v]);
            if (lanes_of(_mm256_or_si256(state[0], state[1]))) {
                EACH state[v] =
                    gather(state[v], chunks, _mm256_add_epi32(state[v], chunk_slot(c[v])), state[v]);
                states_of(map, c, state);
            }
        }
        EACH
        {
            unsigned hits = blocks[n].which >> 8 * v & lanes_of(_mm256_cmpgt_epi32(state[v], zero));
            if (!hits) continue;
            if (!takes_interior) {
                unsigned deep =
                    hits & lanes_of(_mm256_cmpeq_epi32(state[v], _mm256_set1_epi32(VXS_CELL_INTERIOR)));
                found->deep_count += (uint32_t)__builtin_popcount(deep);
                hits &= ~deep;
            }
            if (hits) keep(found, shell, point + 8 * (uint32_t)v, c[v], hits);
        }
    }
}

/* The clearance at the cells; *low: the bits of a cell within the cube that it is of. */
VXSI_AVX2 __m256 clearances(const vxs_voxmap *map, const __m256i c[3], __m256i *low)
{
    const __m256i all = _mm256_set1_epi32(-1), index = root_index(map, c);
    const __m256i entry = gather(all, map->clearance_index, index, all), lanes = is_index(entry);
    __m256 value = _mm256_setzero_ps();
    *low = _mm256_blendv_epi8(_mm256_set1_epi32(VXS_VOXMAP_CHUNK_CELLS - 1), _mm256_set1_epi32(3), lanes);
    if (lanes_of(lanes) != 0xFF) value = _mm256_cvtepi32_ps(gather(all, map->clearance_chunks, index, all));
    if (!lanes_of(lanes)) return value;
    __m256i block = _mm256_or_si256(_mm256_or_si256(_mm256_slli_epi32(low_bits(c[0], 2, 15), 8),
                                                    _mm256_slli_epi32(low_bits(c[1], 2, 15), 4)),
                                    low_bits(c[2], 2, 15));
    __m256i word = gather(_mm256_setzero_si256(), map->clearance,
                          _mm256_add_epi32(first_of(entry, 10), _mm256_srli_epi32(block, 2)), lanes);
    /* The byte to the top, then down again with its sign. */
    __m256i up = _mm256_slli_epi32(_mm256_sub_epi32(_mm256_set1_epi32(3), masked(block, 3)), 3);
    __m256 half = _mm256_cvtepi32_ps(_mm256_srai_epi32(_mm256_sllv_epi32(word, up), 24));
    return _mm256_blendv_ps(value, _mm256_mul_ps(half, _mm256_set1_ps(0.5f)), _mm256_castsi256_ps(lanes));
}

__attribute__((target("avx2"))) static void cull_avx2(const vxs_voxmap *map, const vxsi_spheres *spheres,
                                                      uint32_t first, uint64_t wanted,
                                                      const vxsi_motion *motion, vxsi_verdict *verdict)
{
    verdict->is_free = verdict->is_deep = 0;
    if (map->clearance_count > max_clearances) {
        vxsi_cull_scalar(map, spheres, first, wanted, motion, verdict);
        return;
    }
    const __m256 zero = _mm256_setzero_ps();
    for (uint32_t n = 0; n < VXSI_BATCH; n += 8) {
        if (!(wanted >> n & 0xFFu)) continue;
        const uint32_t s = first + n;
        __m256 u[3], inside[3], square = zero;
        __m256i c[3], low;
        place(motion, _mm256_loadu_ps(spheres->x + s), _mm256_loadu_ps(spheres->y + s),
              _mm256_loadu_ps(spheres->z + s), u);
        for (int axis = 0; axis < 3; axis++) {
            /* max and min give their second operand for a NaN */
            inside[axis] =
                _mm256_min_ps(_mm256_max_ps(u[axis], zero), _mm256_set1_ps((float)map->cells[axis]));
            c[axis] = _mm256_min_epi32(_mm256_cvttps_epi32(inside[axis]),
                                       _mm256_set1_epi32((int)map->cells[axis] - 1));
        }
        const __m256 value = clearances(map, c, &low);
        const __m256i half = _mm256_srli_epi32(_mm256_add_epi32(low, _mm256_set1_epi32(1)), 1);
        for (int axis = 0; axis < 3; axis++) {
            __m256i center = _mm256_add_epi32(_mm256_andnot_si256(low, c[axis]), half);
            __m256 away = _mm256_sub_ps(inside[axis], _mm256_cvtepi32_ps(center));
            square = _mm256_add_ps(square, _mm256_mul_ps(away, away));
        }
        __m256 reach =
            _mm256_add_ps(_mm256_mul_ps(_mm256_loadu_ps(spheres->radius + s), _mm256_set1_ps(motion->scale)),
                          _mm256_set1_ps(motion->margin));
        __m256 left = _mm256_sub_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0f), value),
                                    _mm256_add_ps(_mm256_sqrt_ps(square), reach));
        uint64_t is_clear = lanes_of(_mm256_castps_si256(_mm256_cmp_ps(left, zero, _CMP_GE_OQ)));
        uint64_t is_outside = lanes_of(_mm256_castps_si256(_mm256_cmp_ps(value, zero, _CMP_GT_OQ)));
        _mm256_storeu_ps(verdict->slack + n, left);
        verdict->is_free |= (is_clear & is_outside) << n;
        verdict->is_deep |= (is_clear & ~is_outside) << n;
    }
}

#define VXSI_TARGET __attribute__((target("avx2")))
#define VXSI_NAME(name) name##_avx2
#define VXSI_LARGER(a, b) ((vd)_mm256_max_pd((__m256d)(a), (__m256d)(b)))
#include "contact_sum.h"
#define VXSI_SQRT(v) ((vd)_mm256_sqrt_pd((__m256d)(v)))
#define VXSI_TO_INT(v) ((vi)_mm256_cvttpd_epi32((__m256d)(v)))

__attribute__((target("avx2"))) static void pairs_avx2(const vxsi_channel *channel, const vi corner[3],
                                                       vu pairs[4])
{
    uint32_t found[4][4];
#pragma GCC unroll 1
    for (int lane = 0; lane < 4; lane++)
        vxsi_channel_pairs(channel, corner[0][lane], corner[1][lane], corner[2][lane], found[lane]);
    for (int e = 0; e < 4; e++) pairs[e] = (vu){found[0][e], found[1][e], found[2][e], found[3][e]};
}

#include "contact_sample.h"
#define VXSI_WIDTH 8
#define VXSI_GATHER(base, index, lanes)                                                                      \
    ((vni)gather(_mm256_setzero_si256(), base, (__m256i)(index), (__m256i)(lanes)))
#define VXSI_BITS(mask) lanes_of((__m256i)(mask))
#include "contact_clear.h"

const vxsi_kernel vxsi_kernel_avx2 = {
    .cull = cull_avx2,
    .clear = clear_avx2,
    .probe = probe_avx2,
    .sample = sample_avx2,
    .mean = mean_avx2,
    .sum_common = sum_common_avx2,
    .sum_own = sum_own_avx2,
    .set_planes = set_planes_avx2,
};

#else
typedef int vxsi_no_avx2; /* a translation unit is not empty */
#endif
