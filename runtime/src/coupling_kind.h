/* SPDX-License-Identifier: MIT
 *
 * coupling_kind.h - private: what a kind of coupling is. One file a kind, and one line in the
 * table of coupling_kinds.c.
 */
#ifndef VXSI_COUPLING_KIND_H
#define VXSI_COUPLING_KIND_H

#include "voxshell/coupling.h"

#include <math.h>
#include <string.h>

/* Nothing here may block, allocate, call the system or a transcendental function: a kind's file is
 * part of the tick. Optional entries may be NULL. */
typedef struct vxsi_coupling_kind {
    uint32_t kind; /* VXS_COUPLING_*, or VXS_COUPLING_OWN and above */
    const char *name;
    /* Not 0: contact is evaluated at a body with a mass of its own, which weight and drag act on, too. */
    uint32_t has_body;
    /* Its own numbers of the config: VXS_OK, or what cannot be represented. Struct size and sample
     * time were checked before. Optional. */
    vxs_result (*check)(const vxs_coupling_config *config);
    /* Constants from a checked config into zeroed state; omega0 is already pre-warped. Optional. */
    void (*set_up)(vxs_coupling *coupling, const vxs_coupling_config *config);
    /* At rest with the device at this pose. Optional. */
    void (*reset)(vxs_coupling *coupling, const vxs_pose *device);
    /* Where contact is evaluated. Optional: NULL means at the device. */
    void (*pose)(const vxs_coupling *coupling, const vxs_pose *device, vxs_pose *object);
    /* Moves the object by what contact said; not 0: evaluate there again. Optional. */
    int (*refine)(vxs_coupling *coupling, const vxs_wrench *contact, double depth, const vxs_pose *device);
    /* One sample. */
    void (*step)(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out);
} vxsi_coupling_kind;

/* State is doubles and nothing else, so that a test can look at every one of them. A kind casts it to a
 * struct of its own; VXSI_COUPLING_FITS checks that there is room. */
enum { VXSI_COUPLING_DOUBLES = 80 };

struct vxs_coupling {
    const vxsi_coupling_kind *kind;
    uint32_t evaluations; /* of contact in this tick, so far */
    uint32_t most_evaluations;
    uint32_t has_torque; /* else it is not asked for */
    double depth;        /* of the last of them [m] */
    double sample_time;
    double state[VXSI_COUPLING_DOUBLES];
};

#define VXSI_COUPLING_FITS(type)                                                                             \
    _Static_assert(sizeof(type) <= VXSI_COUPLING_DOUBLES * sizeof(double), #type " is too large")

/* The table, ending in NULL. */
extern const vxsi_coupling_kind *const vxsi_coupling_kinds[];

/* The row of a kind, NULL for none such. */
const vxsi_coupling_kind *vxsi_coupling_kind_of(uint32_t kind);

static inline int vxsi_is_positive(double value)
{
    return isfinite(value) && value > 0;
}

static inline vxs_result vxsi_coupling_check_damping(const vxs_coupling_config *config)
{
    return config->damping >= VXS_COUPLING_MIN_DAMPING && config->damping <= VXS_COUPLING_MAX_DAMPING
               ? VXS_OK
               : VXS_DAMPING;
}

/* What dies away ends at 0 before it turns denormal, where arithmetic takes a hundred times as long. */
static inline double vxsi_without_denormals(double value)
{
    return fabs(value) < 1e-150 ? 0 : value;
}

#endif
