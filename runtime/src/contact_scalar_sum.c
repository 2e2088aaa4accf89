/* SPDX-License-Identifier: MIT
 *
 * The rest of the kernel in plain C: what runs only where it was chosen.
 */
#include "contact_kernel.h"

#include <math.h>
#include <string.h>

#define VXSI_TARGET
#define VXSI_NAME(name) name##_scalar
#define VXSI_DOUBLES 2
#include "contact_sum.h"
#define VXSI_WIDTH 4
#define VXSI_BITS(mask)                                                                                      \
    __extension__({                                                                                          \
        const vni mask_ = (mask);                                                                            \
        ((unsigned)mask_[0] & 1) | ((unsigned)mask_[1] & 2) | ((unsigned)mask_[2] & 4) |                     \
            ((unsigned)mask_[3] & 8);                                                                        \
    })
#include "contact_clear.h"

const vxsi_kernel vxsi_kernel_scalar = {
    .cull = vxsi_cull_scalar,
    .clear = clear_scalar,
    .probe = vxsi_probe_scalar,
    .sample = vxsi_sample_scalar,
    .mean = mean_scalar,
    .sum_common = sum_common_scalar,
    .sum_own = sum_own_scalar,
    .set_planes = set_planes_scalar,
};
