/* SPDX-License-Identifier: MIT
 *
 * fuzz_target.h - what a fuzz target is: libFuzzer's entry point, and seeds.
 */
#ifndef VXS_FUZZ_TARGET_H
#define VXS_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Returns 0; aborts at a finding. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

/* Writes seed number `number` (any) into at most `most` bytes; returns its size. */
size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most);

/* As in libFuzzer; the driver has its own. Bits, bytes and lengths changed, pieces doubled, dropped and
 * spliced. */
size_t LLVMFuzzerMutate(uint8_t *bytes, size_t size, size_t most);

/* A target may have its own way to mutate, in terms of that one. */
size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t most, unsigned int seed);

#ifdef __cplusplus
}
#endif

#define FUZZ_CHECK(condition)                                                                                \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                                  \
            abort();                                                                                         \
        }                                                                                                    \
    } while (0)

#endif
