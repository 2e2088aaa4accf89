/* SPDX-License-Identifier: MIT
 *
 * Four lanes of the compiler's vectors, in functions for one instruction set or another. The same operations
 * in the same order whatever the vectors become, and never a fused one, so the same bits.
 */
#ifndef VXSI_CONTACT_LANES_H
#define VXSI_CONTACT_LANES_H

#include "contact_kernel.h"

#include <string.h>

typedef double v4d __attribute__((vector_size(32)));
typedef float v4f __attribute__((vector_size(16)));
typedef int32_t v4i __attribute__((vector_size(16)));
typedef uint32_t v4u __attribute__((vector_size(16)));
typedef int64_t v4l __attribute__((vector_size(32)));
#define LOAD_F(array, at)                                                                                    \
    __extension__({                                                                                          \
        v4f loaded_;                                                                                         \
        memcpy(&loaded_, (array) + (at), sizeof loaded_);                                                    \
        __builtin_convertvector(loaded_, v4d);                                                               \
    })
#define LOAD_I(array, at)                                                                                    \
    __extension__({                                                                                          \
        v4i loaded_;                                                                                         \
        memcpy(&loaded_, (array) + (at), sizeof loaded_);                                                    \
        __builtin_convertvector(loaded_, v4d);                                                               \
    })
#define STORE_F(array, at, v)                                                                                \
    do {                                                                                                     \
        v4f stored_ = __builtin_convertvector(v, v4f);                                                       \
        memcpy((array) + (at), &stored_, sizeof stored_);                                                    \
    } while (0)
/* Lanes of v where mask is not 0, else +0; and of two. */
#define KEEP(mask, v) ((v4d)((mask) & (v4l)(v)))
#define SELECT(mask, v, otherwise) ((v4d)(((mask) & (v4l)(v)) | (~(mask) & (v4l)(otherwise))))
#define ABS(v) ((v4d)((v4l)(v)&INT64_MAX))
#define ADD_LANES(v) (((v)[0] + (v)[1]) + ((v)[2] + (v)[3]))

#define ALL_LANES(span, n) ((n) + 4 <= (span)->last)
/* All ones in the lanes of hits that exist. */
#define LANES_OF(span, n)                                                                                    \
    __extension__({                                                                                          \
        const int64_t left_ = (int64_t)(span)->last - (int64_t)(n);                                          \
        (v4l){0, 1, 2, 3} < (v4l){left_, left_, left_, left_};                                               \
    })

#endif
