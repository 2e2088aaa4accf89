/* SPDX-License-Identifier: MIT
 *
 * VXSI_DOUBLES lanes (2, 4 or 8) of the compiler's vectors, in functions for one instruction set or another.
 * The same operations in the same order whatever the vectors become, and never a fused one, so the same bits.
 */
#ifndef VXSI_CONTACT_LANES_H
#define VXSI_CONTACT_LANES_H

#include "contact_kernel.h"

#include <string.h>

#ifndef VXSI_DOUBLES
#define VXSI_DOUBLES 4
#endif
typedef double vd __attribute__((vector_size(8 * VXSI_DOUBLES)));
typedef float vf __attribute__((vector_size(4 * VXSI_DOUBLES)));
typedef int32_t vi __attribute__((vector_size(4 * VXSI_DOUBLES)));
typedef uint32_t vu __attribute__((vector_size(4 * VXSI_DOUBLES)));
typedef int64_t vl __attribute__((vector_size(8 * VXSI_DOUBLES)));
/* Of another kind. What the compiler splits in halves (AVX-512), a kernel defines before. */
#ifndef VXSI_TO_DOUBLE
#define VXSI_TO_DOUBLE(v) __builtin_convertvector(v, vd)    /* of vi */
#define VXSI_FLOAT_DOUBLE(v) __builtin_convertvector(v, vd) /* of vf */
#define VXSI_DOUBLE_FLOAT(v) __builtin_convertvector(v, vf)
#endif
#define LOAD_F(array, at)                                                                                    \
    __extension__({                                                                                          \
        vf loaded_;                                                                                          \
        memcpy(&loaded_, (array) + (at), sizeof loaded_);                                                    \
        VXSI_FLOAT_DOUBLE(loaded_);                                                                          \
    })
#define LOAD_I(array, at)                                                                                    \
    __extension__({                                                                                          \
        vi loaded_;                                                                                          \
        memcpy(&loaded_, (array) + (at), sizeof loaded_);                                                    \
        VXSI_TO_DOUBLE(loaded_);                                                                             \
    })
#define STORE_F(array, at, v)                                                                                \
    do {                                                                                                     \
        vf stored_ = VXSI_DOUBLE_FLOAT(v);                                                                   \
        memcpy((array) + (at), &stored_, sizeof stored_);                                                    \
    } while (0)
/* Lanes of v where mask is not 0, else +0; and of two. */
#define KEEP(mask, v) ((vd)((mask) & (vl)(v)))
#define SELECT(mask, v, otherwise) ((vd)(((mask) & (vl)(v)) | (~(mask) & (vl)(otherwise))))
/* a where a > b, else b. */
#ifndef VXSI_LARGER
#define VXSI_LARGER(a, b) SELECT((a) > (b), a, b)
#endif
#define ABS(v) ((vd)((vl)(v)&INT64_MAX))
#if VXSI_DOUBLES == 8
#define PLACES ((vl){0, 1, 2, 3, 4, 5, 6, 7})
#elif VXSI_DOUBLES == 4
#define PLACES ((vl){0, 1, 2, 3})
#else
#define PLACES ((vl){0, 1})
#endif
#define ALL_LANES(span, n) ((n) + VXSI_DOUBLES <= (span)->last)
/* All ones in the lanes of hits that exist. */
#define LANES_OF(span, n) (PLACES < (int64_t)(span)->last - (int64_t)(n))

#endif
