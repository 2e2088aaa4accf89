/* SPDX-License-Identifier: MIT
 *
 * Set-up of contact: config, memory, spheres of the upper level.
 */
#include "contact_state.h"

#include <math.h>
#include <string.h>

enum { ALIGNMENT = 64 };

void vxs_contact_config_default(vxs_contact_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->law = VXS_CONTACT_AVERAGE;
    config->weighting = VXS_CONTACT_COUNT;
    config->field = VXS_CONTACT_SURFACE;
    config->stiffness = 1000;
}

static size_t round_up(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static uint32_t group_count(const vxs_pointshell *shell)
{
    return (shell->cluster_count + VXSI_GROUP_CLUSTERS - 1) / VXSI_GROUP_CLUSTERS;
}

/* Hands out the caller's memory, or only counts it with memory NULL. */
typedef struct arena {
    uint8_t *memory;
    size_t used;
} arena;

static void *take(arena *a, size_t count, size_t size)
{
    void *taken = a->memory ? a->memory + a->used : NULL;
    a->used += round_up(count * size);
    return taken;
}

static void take_spheres(arena *a, vxsi_spheres *spheres, uint32_t count)
{
    size_t padded = (size_t)count + VXSI_LANES;
    float **arrays[] = {&spheres->x, &spheres->y, &spheres->z, &spheres->radius};
    for (int n = 0; n < 4; n++) *arrays[n] = take(a, padded, sizeof(float));
    spheres->count = count;
}

static void take_discs(arena *a, vxsi_discs *discs, uint32_t count)
{
    size_t padded = (size_t)count + VXSI_LANES;
    float **arrays[] = {&discs->x,  &discs->y,  &discs->z,      &discs->nx,
                        &discs->ny, &discs->nz, &discs->radius, &discs->half};
    for (int n = 0; n < 8; n++) *arrays[n] = take(a, padded, sizeof(float));
    discs->count = count;
}

/* Lays out everything; returns the bytes that it takes. */
static size_t lay_out(vxs_contact *contact, uint8_t *memory, const vxs_pointshell *shell, uint32_t statics)
{
    arena a = {memory, 0};
    take(&a, 1, sizeof *contact);
    vxsi_hits *hits = &contact->hits;
    size_t room = (size_t)shell->point_count + VXSI_LANES; /* a kernel may write whole vectors */
    float **floats[] = {&hits->x,  &hits->y,  &hits->z,    &hits->nx,
                        &hits->ny, &hits->nz, &hits->area, &hits->depth};
    int32_t **cells[] = {&hits->i, &hits->j, &hits->k};
    for (int n = 0; n < 8; n++) *floats[n] = take(&a, room, sizeof(float));
    for (int n = 0; n < 3; n++) *cells[n] = take(&a, room, sizeof(int32_t));
    hits->direction = take(&a, room, 1);
    take_spheres(&a, &contact->clusters, shell->cluster_count);
    take_spheres(&a, &contact->groups, group_count(shell));
    const uint32_t quarters = (shell->point_count + VXSI_QUARTER - 1) / VXSI_QUARTER;
    take_discs(&a, &contact->quarters, quarters);
    contact->near = take(&a, quarters / VXSI_LANES + 2, sizeof(vxsi_block));
    contact->statics = take(&a, statics, sizeof(vxsi_static));
    for (uint32_t n = 0; n < statics; n++) {
        double *due = take(&a, (size_t)VXSI_GROUP_RUNS * group_count(shell), sizeof(double));
        double *group_due = take(&a, group_count(shell), sizeof(double));
        vxsi_block *looks = take(&a, (size_t)quarters + VXSI_LANES, sizeof(vxsi_block));
        if (memory) {
            contact->statics[n].due = due;
            contact->statics[n].group_due = group_due;
            contact->statics[n].looks = looks;
        }
    }
    return a.used;
}

size_t vxs_contact_memory(const vxs_pointshell *shell, uint32_t statics)
{
    vxs_contact unplaced;
    return shell ? lay_out(&unplaced, NULL, shell, statics) + ALIGNMENT : 0;
}

#if defined(__x86_64__)
static int has_avx512(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
}
#endif

static const vxsi_kernel *kernel_named(uint32_t kernel)
{
    switch (kernel) {
    case VXS_CONTACT_SCALAR:
        return &vxsi_kernel_scalar;
#if defined(__x86_64__)
    case VXS_CONTACT_AVX2:
        return __builtin_cpu_supports("avx2") ? &vxsi_kernel_avx2 : NULL;
    case VXS_CONTACT_AVX512:
        return has_avx512() ? &vxsi_kernel_avx512 : NULL;
#elif defined(__aarch64__)
    case VXS_CONTACT_NEON:
        return &vxsi_kernel_neon;
#endif
    default:
        return NULL;
    }
}

vxs_result vxs_contact_use(vxs_contact *contact, uint32_t kernel)
{
    if (!contact || kernel > VXS_CONTACT_AVX512) return VXS_PARAM;
    const vxsi_kernel *chosen = kernel_named(kernel);
    for (uint32_t best = VXS_CONTACT_AVX512; kernel == VXS_CONTACT_FASTEST && !chosen; best--)
        chosen = kernel_named(best);
    if (!chosen) return VXS_UNSUPPORTED;
    contact->kernel = chosen;
    return VXS_OK;
}

vxs_result vxs_contact_cull(vxs_contact *contact, uint32_t culling)
{
    if (!contact || culling > VXS_CONTACT_CHECKED) return VXS_PARAM;
    contact->culling = culling;
    for (uint32_t n = 0; n < contact->static_capacity; n++) contact->statics[n].root = NULL;
    return VXS_OK;
}

static void copy_spheres(vxsi_spheres *out, const vxs_pointshell *shell)
{
    for (uint32_t n = 0; n < out->count; n++) {
        const vxs_pointshell_cluster *cluster = &shell->clusters[n];
        out->x[n] = cluster->center[0];
        out->y[n] = cluster->center[1];
        out->z[n] = cluster->center[2];
        out->radius[n] = cluster->radius;
    }
}

/* Spheres that hold their clusters': around the middle of the centres' box. */
static void group_spheres(vxsi_spheres *out, const vxsi_spheres *clusters)
{
    const float *axes[3] = {clusters->x, clusters->y, clusters->z};
    float *centers[3] = {out->x, out->y, out->z};
    for (uint32_t group = 0; group < out->count; group++) {
        uint32_t first = group * VXSI_GROUP_CLUSTERS, last = first + VXSI_GROUP_CLUSTERS;
        if (last > clusters->count) last = clusters->count;
        for (int axis = 0; axis < 3; axis++) {
            float low = axes[axis][first], high = low;
            for (uint32_t n = first; n < last; n++) {
                low = fminf(low, axes[axis][n]);
                high = fmaxf(high, axes[axis][n]);
            }
            centers[axis][group] = 0.5f * low + 0.5f * high;
        }
        double radius = 0;
        for (uint32_t n = first; n < last; n++) {
            double square = 0;
            for (int axis = 0; axis < 3; axis++) {
                double away = (double)axes[axis][n] - (double)centers[axis][group];
                square += away * away;
            }
            radius = fmax(radius, sqrt(square) + (double)clusters->radius[n]);
        }
        out->radius[group] = (float)(radius * (1 + 0x1p-22));
    }
}

/* A disc around a run of points, its axis the mean of their normals. */
static void wrap(vxsi_discs *out, uint32_t n, const vxs_pointshell *shell, uint32_t first, uint32_t last)
{
    const float *const positions[3] = {shell->x, shell->y, shell->z}, *const normals[3] = {
                                                                          shell->nx, shell->ny, shell->nz};
    float *const centers[3] = {out->x, out->y, out->z}, *const axes[3] = {out->nx, out->ny, out->nz};
    double center[3], axis[3], length = 0;
    for (int i = 0; i < 3; i++) {
        double low = INFINITY, high = -INFINITY;
        axis[i] = 0;
        for (uint32_t p = first; p < last; p++) {
            low = fmin(low, (double)positions[i][p]);
            high = fmax(high, (double)positions[i][p]);
            axis[i] += (double)normals[i][p];
        }
        centers[i][n] = (float)(0.5 * low + 0.5 * high);
        length += axis[i] * axis[i];
    }
    for (int i = 0; i < 3; i++) {
        axes[i][n] = length > 1e-6 ? (float)(axis[i] / sqrt(length)) : i == 0; /* any, if they cancel */
        center[i] = (double)centers[i][n];
        axis[i] = (double)axes[i][n];
    }
    double half = 0, square = 0;
    for (uint32_t p = first; p < last; p++) {
        double away[3], along = 0, across = 0;
        for (int i = 0; i < 3; i++) {
            away[i] = (double)positions[i][p] - center[i];
            along += away[i] * axis[i];
        }
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const double side = away[j] * axis[k] - away[k] * axis[j];
            across += side * side;
        }
        if (fabs(along) > half) half = fabs(along);
        if (across > square) square = across;
    }
    out->half[n] = (float)(half * (1 + 0x1p-20));
    out->radius[n] = (float)(sqrt(square) * (1 + 0x1p-20));
}

vxs_result vxs_contact_init(void *memory, size_t size, const vxs_pointshell *shell, uint32_t statics,
                            vxs_contact **out)
{
    if (!memory || !out || !shell || statics < 1 || statics > VXS_CONTACT_MAX_STATICS) return VXS_PARAM;
    if ((uintptr_t)memory % 16 != 0 || size < vxs_contact_memory(shell, statics)) return VXS_BUFFER;
    /* Every page is touched here, so that none faults in a tick. */
    memset(memory, 0, vxs_contact_memory(shell, statics));
    uint8_t *aligned = (uint8_t *)round_up((uintptr_t)memory); /* else a whole vector is in two cache lines */
    vxs_contact *contact = (vxs_contact *)(void *)aligned;
    lay_out(contact, aligned, shell, statics);
    contact->shell = *shell;
    contact->static_capacity = statics;
    contact->hits.capacity = shell->point_count;
    for (unsigned mask = 0; mask < 256; mask++) {
        int n = 0;
        for (uint8_t bit = 0; bit < 8; bit++) {
            if (mask >> bit & 1u) contact->order[mask][n++] = bit;
        }
    }
    contact->hits.order = (const uint8_t(*)[8])contact->order;
    copy_spheres(&contact->clusters, shell);
    group_spheres(&contact->groups, &contact->clusters);
    for (uint32_t n = 0; n < contact->quarters.count; n++) {
        const uint32_t first = n * VXSI_QUARTER, last = first + VXSI_QUARTER;
        wrap(&contact->quarters, n, shell, first, last < shell->point_count ? last : shell->point_count);
    }
    *out = contact;
    return vxs_contact_use(contact, VXS_CONTACT_FASTEST);
}
