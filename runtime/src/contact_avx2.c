/* SPDX-License-Identifier: MIT
 *
 * The probe on AVX2, eight points at a time: the same operations in the same order as
 * contact_scalar.c and no fused multiply-add, so the same bits.
 */
#include "contact_probe.h"

#if defined(__x86_64__)

#include <immintrin.h>

/* Gathers index by signed 32 bits: beyond these counts the scalar probe takes over. */
static const uint64_t max_chunks = INT32_MAX / VXS_VOXMAP_CHUNK_ENTRIES;
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

VXSI_AVX2 __m256i low_bits(__m256i v, int shift, int mask)
{
    return _mm256_and_si256(_mm256_srli_epi32(v, shift), _mm256_set1_epi32(mask));
}

/* Index of 8 x 8 x 8 things: bits shift .. shift + 2 of each coordinate. */
VXSI_AVX2 __m256i slot(const __m256i c[3], int shift)
{
    return _mm256_or_si256(_mm256_or_si256(_mm256_slli_epi32(low_bits(c[0], shift, 7), 6),
                                           _mm256_slli_epi32(low_bits(c[1], shift, 7), 3)),
                           low_bits(c[2], shift, 7));
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

/* State of the cells in `inside`, free elsewhere. */
VXSI_AVX2 __m256i states(const vxs_voxmap *map, const __m256i c[3], __m256i inside)
{
    __m256i index = _mm256_mullo_epi32(_mm256_srli_epi32(c[0], 6), _mm256_set1_epi32((int)map->root_dims[1]));
    index = _mm256_add_epi32(index, _mm256_srli_epi32(c[1], 6));
    index = _mm256_mullo_epi32(index, _mm256_set1_epi32((int)map->root_dims[2]));
    index = _mm256_add_epi32(index, _mm256_srli_epi32(c[2], 6));
    __m256i entry = gather(_mm256_setzero_si256(), map->root, index, inside);
    __m256i lanes = is_index(entry);
    if (!lanes_of(lanes)) return entry;

    entry = gather(entry, map->chunks, _mm256_add_epi32(first_of(entry, 9), slot(c, 3)), lanes);
    lanes = is_index(entry);
    if (!lanes_of(lanes)) return entry;

    __m256i cell = slot(c, 0); /* sixteen cells to a 32-bit half word */
    __m256i word = gather(_mm256_setzero_si256(), map->bricks,
                          _mm256_add_epi32(first_of(entry, 5), _mm256_srli_epi32(cell, 4)), lanes);
    __m256i shift = _mm256_slli_epi32(_mm256_and_si256(cell, _mm256_set1_epi32(15)), 1);
    __m256i state = _mm256_and_si256(_mm256_srlv_epi32(word, shift), _mm256_set1_epi32(3));
    return _mm256_blendv_epi8(entry, state, lanes);
}

__attribute__((target("avx2"))) void vxsi_probe_avx2(const vxs_voxmap *map, const vxs_pointshell *shell,
                                                     const vxsi_probe_motion *motion,
                                                     vxs_contact_scratch *scratch)
{
    if (map->chunk_count > max_chunks || map->brick_count > max_bricks) {
        vxsi_probe_scalar(map, shell, motion, scratch);
        return;
    }
    const float *m = motion->m, *b = motion->b;
    const float extent[3] = {(float)map->cells[0], (float)map->cells[1], (float)map->cells[2]};
    for (uint32_t point = 0; point < shell->point_count; point += 8) {
        /* The arrays are padded to whole vectors; lanes beyond the last point do not count. */
        __m256 x = _mm256_loadu_ps(shell->x + point), y = _mm256_loadu_ps(shell->y + point),
               z = _mm256_loadu_ps(shell->z + point);
        __m256 u[3] = {row(m, b[0], x, y, z), row(m + 3, b[1], x, y, z), row(m + 6, b[2], x, y, z)};
        __m256i inside = _mm256_castps_si256(_mm256_and_ps(
            _mm256_and_ps(within(u[0], extent[0]), within(u[1], extent[1])), within(u[2], extent[2])));
        if (!lanes_of(inside)) continue;
        __m256i c[3];
        for (int axis = 0; axis < 3; axis++) c[axis] = _mm256_and_si256(_mm256_cvttps_epi32(u[axis]), inside);
        __m256i state = states(map, c, inside);
        unsigned deep = lanes_of(_mm256_cmpeq_epi32(state, _mm256_set1_epi32(VXS_CELL_INTERIOR)));
        unsigned hits = lanes_of(_mm256_cmpeq_epi32(state, _mm256_set1_epi32(VXS_CELL_SURFACE)));
        if (!(deep | hits)) continue;
        if (shell->point_count - point < 8) {
            unsigned real = (1u << (shell->point_count - point)) - 1;
            deep &= real;
            hits &= real;
        }
        scratch->deep_count += (uint32_t)__builtin_popcount(deep);
        uint32_t cell[3][8];
        if (hits)
            for (int axis = 0; axis < 3; axis++) _mm256_storeu_si256((__m256i *)(void *)cell[axis], c[axis]);
        for (; hits; hits &= hits - 1) {
            unsigned lane = (unsigned)__builtin_ctz(hits);
            if (scratch->count == scratch->capacity) {
                scratch->overflow = 1;
                break;
            }
            scratch->hits[scratch->count++] =
                (vxsi_hit){point + lane, {cell[0][lane], cell[1][lane], cell[2][lane]}};
        }
    }
}

#else
typedef int vxsi_no_avx2; /* a translation unit is not empty */
#endif
