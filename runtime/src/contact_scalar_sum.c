/* SPDX-License-Identifier: MIT
 *
 * The rest of the kernel in plain C: what runs only where it was chosen.
 */
#include "contact_kernel.h"

#include <math.h>
#include <string.h>

#define VXSI_TARGET
#define VXSI_NAME(name) name##_scalar
#include "contact_sum.h"

const vxsi_kernel vxsi_kernel_scalar = {vxsi_cull_scalar, vxsi_probe_scalar, vxsi_sample_scalar,
                                        mean_scalar,      sum_common_scalar, sum_own_scalar,
                                        sum_given_scalar, set_planes_scalar};
