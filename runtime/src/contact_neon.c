/* SPDX-License-Identifier: MIT
 *
 * The kernel on NEON, which every AArch64 has, four points at a time: the same operations in the same
 * order as contact_scalar.c and no fused multiply-add, so the same bits. There is no gather: look-ups are
 * scalar.
 */
#include "contact_kernel.h"

#if defined(__aarch64__)

#include <arm_neon.h>
#include <string.h>

/* ((m0 x + m1 y) + m2 z) + b for the three rows */
static inline void place(const vxsi_motion *motion, float32x4_t x, float32x4_t y, float32x4_t z,
                         float32x4_t u[3])
{
    for (int axis = 0; axis < 3; axis++) {
        const float *m = motion->m + 3 * axis;
        float32x4_t sum = vaddq_f32(vmulq_n_f32(x, m[0]), vmulq_n_f32(y, m[1]));
        sum = vaddq_f32(sum, vmulq_n_f32(z, m[2]));
        u[axis] = vaddq_f32(sum, vdupq_n_f32(motion->b[axis]));
    }
}

/* One bit for each lane of a mask. */
static inline unsigned lanes_of(uint32x4_t mask)
{
    static const uint32_t bits[4] = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(mask, vld1q_u32(bits)));
}

/* Index of 8 x 8 x 8 things: bits shift .. shift + 2 of each coordinate. */
static inline uint32x4_t slot(const uint32x4_t c[3], int shift)
{
    const int32x4_t down = vdupq_n_s32(-shift);
    const uint32x4_t low = vdupq_n_u32(7);
    uint32x4_t i = vandq_u32(vshlq_u32(c[0], down), low), j = vandq_u32(vshlq_u32(c[1], down), low),
               k = vandq_u32(vshlq_u32(c[2], down), low);
    return vorrq_u32(vorrq_u32(vshlq_n_u32(i, 6), vshlq_n_u32(j, 3)), k);
}

static inline int is_in_chunk(const vxsi_chunk *chunk, const uint32x4_t c[3])
{
    uint32x4_t differs = vdupq_n_u32(0);
    for (int axis = 0; axis < 3; axis++)
        differs = vorrq_u32(differs, veorq_u32(c[axis], vdupq_n_u32(chunk->at[axis])));
    return vmaxvq_u32(differs) < VXS_VOXMAP_CHUNK_CELLS;
}

static inline void enter_chunk(vxsi_chunk *chunk, const vxs_voxmap *map, const uint32_t cell[3])
{
    for (int axis = 0; axis < 3; axis++)
        chunk->at[axis] = cell[axis] & ~(uint32_t)(VXS_VOXMAP_CHUNK_CELLS - 1);
    chunk->entry = map->root[vxs_voxmap_root_index(map->root_dims, cell[0], cell[1], cell[2])];
}

/* States of cells that are all in the chunk. */
static inline uint32x4_t states_in_chunk(const vxs_voxmap *map, const vxsi_chunk *chunk,
                                         const uint32x4_t c[3])
{
    if (chunk->entry < VXS_VOXMAP_ENTRY_FIRST) return vdupq_n_u32(chunk->entry);
    const uint32_t *entries =
        map->chunks + (size_t)(chunk->entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_CHUNK_ENTRIES;
    uint32_t brick[4], cell[4], state[4];
    vst1q_u32(brick, slot(c, 3));
    vst1q_u32(cell, slot(c, 0));
    for (int lane = 0; lane < 4; lane++) {
        uint32_t entry = state[lane] = entries[brick[lane]];
        if (entry < VXS_VOXMAP_ENTRY_FIRST) continue;
        const uint64_t *words =
            map->bricks + (size_t)(entry - VXS_VOXMAP_ENTRY_FIRST) * VXS_VOXMAP_BRICK_WORDS;
        state[lane] = vxs_voxmap_brick_state(words, cell[lane]);
    }
    return vld1q_u32(state);
}

/* States of the cells in `inside`, not all zero, free elsewhere; enters the last one's chunk.
 */
static inline uint32x4_t states(const vxs_voxmap *map, vxsi_chunk *chunk, const uint32x4_t c[3],
                                unsigned inside)
{
    uint32_t cells[3][4], state[4] = {VXS_CELL_FREE, VXS_CELL_FREE, VXS_CELL_FREE, VXS_CELL_FREE};
    uint32_t cell[3] = {0, 0, 0};
    for (int axis = 0; axis < 3; axis++) vst1q_u32(cells[axis], c[axis]);
    for (int lane = 0; lane < 4; lane++) {
        if (!(inside >> lane & 1u)) continue;
        for (int axis = 0; axis < 3; axis++) cell[axis] = cells[axis][lane];
        state[lane] = vxs_voxmap_state(map, cell[0], cell[1], cell[2]);
    }
    enter_chunk(chunk, map, cell);
    return vld1q_u32(state);
}

/* Appends the lanes in `hits`. */
static inline void keep(vxsi_hits *found, const vxs_pointshell *shell, uint32_t point,
                        const float32x4_t at[3], const uint32x4_t c[3], unsigned hits)
{
    /* From places of lanes to places of their bytes. */
    uint32x4_t lanes = vmovl_u16(vget_low_u16(vmovl_u8(vld1_u8(found->order[hits]))));
    uint8x16_t order =
        vreinterpretq_u8_u32(vmlaq_n_u32(vdupq_n_u32(UINT32_C(0x03020100)), lanes, UINT32_C(0x04040404)));
    uint32_t n = found->count;
#define KEEP_F(array, v)                                                                                     \
    vst1q_f32((array) + n, vreinterpretq_f32_u8(vqtbl1q_u8(vreinterpretq_u8_f32(v), order)))
#define KEEP_I(array, v)                                                                                     \
    vst1q_s32((array) + n, vreinterpretq_s32_u8(vqtbl1q_u8(vreinterpretq_u8_u32(v), order)))
    KEEP_F(found->x, at[0]);
    KEEP_F(found->y, at[1]);
    KEEP_F(found->z, at[2]);
    KEEP_I(found->i, c[0]);
    KEEP_I(found->j, c[1]);
    KEEP_I(found->k, c[2]);
    if (found->take & VXSI_TAKE_NORMAL) {
        KEEP_F(found->nx, vld1q_f32(shell->nx + point));
        KEEP_F(found->ny, vld1q_f32(shell->ny + point));
        KEEP_F(found->nz, vld1q_f32(shell->nz + point));
    }
    if (found->take & VXSI_TAKE_AREA) KEEP_F(found->area, vld1q_f32(shell->area + point));
#undef KEEP_F
#undef KEEP_I
    n += (uint32_t)__builtin_popcount(hits);
    if (n > found->capacity) {
        n = found->capacity;
        found->overflow = 1;
    }
    found->count = n;
}

static void probe_neon(const vxs_voxmap *map, const vxs_pointshell *shell, const vxsi_motion *motion,
                       const vxsi_block *blocks, uint32_t count, vxsi_hits *found)
{
    const float32x4_t zero = vdupq_n_f32(0);
    vxsi_chunk chunk = found->chunk;
    const int takes_interior = (found->take & VXSI_TAKE_INTERIOR) != 0;
    for (uint32_t n = 0; n < 4 * count; n++) {
        const uint32_t lane = n % 4 * 4, point = blocks[n / 4].first + lane,
                       which = blocks[n / 4].which >> lane & 0xF;
        if (!which) continue;
        const float32x4_t at[3] = {vld1q_f32(shell->x + point), vld1q_f32(shell->y + point),
                                   vld1q_f32(shell->z + point)};
        float32x4_t u[3];
        place(motion, at[0], at[1], at[2], u);
        /* Truncation is floor where u is not negative; a NaN fails the comparison. */
        const uint32x4_t c[3] = {vcvtq_u32_f32(u[0]), vcvtq_u32_f32(u[1]), vcvtq_u32_f32(u[2])};
        uint32x4_t inside =
            vandq_u32(vandq_u32(vcgeq_f32(u[0], zero), vcgeq_f32(u[1], zero)), vcgeq_f32(u[2], zero));
        uint32x4_t state;
        if (is_in_chunk(&chunk, c) && vminvq_u32(inside)) {
            state = states_in_chunk(map, &chunk, c);
        } else {
            for (int axis = 0; axis < 3; axis++)
                inside = vandq_u32(inside, vcltq_u32(c[axis], vdupq_n_u32(map->cells[axis])));
            unsigned lanes = lanes_of(inside);
            if (!lanes) continue;
            state = states(map, &chunk, c, lanes);
        }
        unsigned hits = which & lanes_of(vtstq_u32(state, state));
        if (!hits) continue;
        if (!takes_interior) {
            unsigned deep = hits & lanes_of(vceqq_u32(state, vdupq_n_u32(VXS_CELL_INTERIOR)));
            found->deep_count += (uint32_t)__builtin_popcount(deep);
            hits &= ~deep;
        }
        if (hits) keep(found, shell, point, at, c, hits);
    }
    found->chunk = chunk;
}

static void cull_neon(const vxs_voxmap *map, const vxsi_spheres *spheres, uint32_t first, uint64_t wanted,
                      const vxsi_motion *motion, vxsi_verdict *verdict)
{
    const float32x4_t zero = vdupq_n_f32(0);
    verdict->is_free = verdict->is_deep = 0;
    for (uint32_t n = 0; n < VXSI_BATCH; n += 4) {
        if (!(wanted >> n & 0xFu)) continue;
        const uint32_t s = first + n;
        float32x4_t u[3], inside[3], square = zero;
        uint32x4_t c[3];
        uint32_t cells[3][4], sizes[4];
        float clearance[4];
        place(motion, vld1q_f32(spheres->x + s), vld1q_f32(spheres->y + s), vld1q_f32(spheres->z + s), u);
        for (int axis = 0; axis < 3; axis++) {
            /* Not max and min: a NaN becomes 0. */
            const float32x4_t extent = vdupq_n_f32((float)map->cells[axis]);
            inside[axis] = vbslq_f32(vcgtq_f32(u[axis], zero), u[axis], zero);
            inside[axis] = vbslq_f32(vcltq_f32(inside[axis], extent), inside[axis], extent);
            c[axis] = vminq_u32(vcvtq_u32_f32(inside[axis]), vdupq_n_u32(map->cells[axis] - 1));
            vst1q_u32(cells[axis], c[axis]);
        }
        for (int lane = 0; lane < 4; lane++)
            clearance[lane] =
                vxs_voxmap_clearance(map, cells[0][lane], cells[1][lane], cells[2][lane], &sizes[lane]);
        const float32x4_t value = vld1q_f32(clearance);
        const uint32x4_t size = vld1q_u32(sizes);
        for (int axis = 0; axis < 3; axis++) {
            uint32x4_t center =
                vaddq_u32(vbicq_u32(c[axis], vsubq_u32(size, vdupq_n_u32(1))), vshrq_n_u32(size, 1));
            float32x4_t away = vsubq_f32(inside[axis], vcvtq_f32_u32(center));
            square = vaddq_f32(square, vmulq_f32(away, away));
        }
        float32x4_t reach = vaddq_f32(vmulq_n_f32(vld1q_f32(spheres->radius + s), motion->scale),
                                      vdupq_n_f32(motion->margin));
        float32x4_t left = vsubq_f32(vabsq_f32(value), vaddq_f32(vsqrtq_f32(square), reach));
        uint64_t is_clear = lanes_of(vcgeq_f32(left, zero));
        uint64_t is_outside = lanes_of(vcgtq_f32(value, zero));
        vst1q_f32(verdict->slack + n, left);
        verdict->is_free |= (is_clear & is_outside) << n;
        verdict->is_deep |= (is_clear & ~is_outside) << n;
    }
}

#define VXSI_TARGET
#define VXSI_NAME(name) name##_neon
#define VXSI_DOUBLES 2
#include "contact_sum.h"
#define VXSI_WIDTH 4
#define VXSI_BITS(mask) lanes_of((uint32x4_t)(mask))
#include "contact_clear.h"

const vxsi_kernel vxsi_kernel_neon = {
    .cull = cull_neon,
    .clear = clear_neon,
    .probe = probe_neon,
    .sample = vxsi_sample_scalar,
    .mean = mean_neon,
    .sum_common = sum_common_neon,
    .sum_own = sum_own_neon,
    .set_planes = set_planes_neon,
};

#else
typedef int vxsi_no_neon; /* a translation unit is not empty */
#endif
