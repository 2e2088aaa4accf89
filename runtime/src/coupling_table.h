/* SPDX-License-Identifier: MIT
 *
 * coupling_table.h - private: the kinds of coupling that are voxshell's. One file a kind, which is part of the
 * tick, and one line in the table of coupling_table.c.
 */
#ifndef VXSI_COUPLING_TABLE_H
#define VXSI_COUPLING_TABLE_H

#include "voxshell/coupling_kind.h"

#include <math.h>
#include <string.h>

/* The table, ending in NULL. */
extern const vxs_coupling_kind *const vxsi_coupling_kinds[];

/* The kind that a config asks for: the table's, or its own. NULL: there is none, or it is not sound. */
const vxs_coupling_kind *vxsi_coupling_kind_of(const vxs_coupling_config *config);

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

#endif
