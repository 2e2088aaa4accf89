/* SPDX-License-Identifier: MIT
 *
 * Runs a fuzz target (libFuzzer's entry point) without libFuzzer: deterministic inputs, for the same number
 * of executions the same ones anywhere.
 *     fuzz_NAME [EXECUTIONS [SEED]]    every seed of the target's; then random bytes, or a seed mutated: by
 * the target's own way where it has one fuzz_NAME replay FOLDER          each file of a corpus once fuzz_NAME
 * seeds FOLDER           writes the target's seeds, for libFuzzer to begin with (long.sh) With the CMake
 * option VOXSHELL_FUZZ (clang) a target links to libFuzzer instead.
 */
#define _DEFAULT_SOURCE 1 /* scandir */

#include "fuzz_target.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST = 1 << 16, RANDOM_MOST = 1024, SEEDS = 64, PATH = 4096 };

static uint64_t state;

static uint32_t random_below(uint32_t end)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)((state >> 32) * end >> 32);
}

/* A target without a way of its own has the driver's. */
__attribute__((weak)) size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t most,
                                                     unsigned int seed)
{
    (void)seed;
    return LLVMFuzzerMutate(bytes, size, most);
}

size_t LLVMFuzzerMutate(uint8_t *bytes, size_t size, size_t most)
{
    for (uint32_t n = 1 + random_below(5); n > 0; n--) {
        size_t at = size ? random_below((uint32_t)size) : 0;
        size_t run = 1 + random_below(16), room = most - size;
        switch (random_below(8)) {
        case 0:
            if (size) bytes[at] ^= (uint8_t)(1 << random_below(8));
            break;
        case 1:
            if (size) bytes[at] = (uint8_t)random_below(256);
            break;
        case 2: {
            static const uint8_t edges[] = {0, 1, 0x7F, 0x80, 0xFF, 0xA5, 0x5A, '<', '>', 'A', 0xF0};
            if (size) bytes[at] = edges[random_below(sizeof edges)];
            break;
        }
        case 3:
            size = at;
            break;
        case 4: /* doubled */
            if (run > size - at) run = size - at;
            if (run > room) run = room;
            memmove(bytes + at + run, bytes + at, size - at);
            size += run;
            break;
        case 5: /* dropped */
            if (run > size - at) run = size - at;
            memmove(bytes + at, bytes + at + run, size - at - run);
            size -= run;
            break;
        case 6: /* spliced */
            run = fuzz_seed(random_below(SEEDS), bytes + size, room);
            size += run;
            break;
        default:
            for (size_t i = 0; i < run && size < most; i++) bytes[size++] = (uint8_t)random_below(256);
        }
    }
    return size;
}

/* A copy of just this size: a sanitizer sees a byte too far. */
static void execute(const uint8_t *bytes, size_t size)
{
    uint8_t *exact = malloc(size ? size : 1);
    FUZZ_CHECK(exact);
    memcpy(exact, bytes, size);
    LLVMFuzzerTestOneInput(exact, size);
    free(exact);
}

static int replay(const char *folder)
{
    struct dirent **found;
    int count = scandir(folder, &found, NULL, alphasort), ran = 0;
    for (int n = 0; n < count; n++) {
        char path[PATH];
        uint8_t bytes[MOST];
        snprintf(path, sizeof path, "%s/%s", folder, found[n]->d_name);
        FILE *file = found[n]->d_name[0] == '.' ? NULL : fopen(path, "rb");
        if (file) {
            size_t size = fread(bytes, 1, sizeof bytes, file);
            fclose(file);
            execute(bytes, size);
            ran++;
        }
        free(found[n]);
    }
    if (count >= 0) free(found);
    printf("%d files\n", ran);
    return ran > 0 ? 0 : 1;
}

static int write_seeds(const char *folder)
{
    for (uint32_t n = 0; n < SEEDS; n++) {
        char path[PATH];
        uint8_t bytes[MOST];
        size_t size = fuzz_seed(n, bytes, MOST);
        FUZZ_CHECK(size > 0); /* one that finds no room would never be tried */
        snprintf(path, sizeof path, "%s/seed%02u", folder, (unsigned)n);
        FILE *file = fopen(path, "wb");
        if (!file) return 1;
        size_t written = fwrite(bytes, 1, size, file);
        if (fclose(file) != 0 || written != size) return 1;
    }
    return 0;
}

int main(int count, char **arguments)
{
    if (count == 3 && strcmp(arguments[1], "replay") == 0) return replay(arguments[2]);
    if (count == 3 && strcmp(arguments[1], "seeds") == 0) return write_seeds(arguments[2]);
    unsigned long executions = count > 1 ? strtoul(arguments[1], NULL, 10) : 200000;
    state = 0x9E3779B97F4A7C15u ^ (count > 2 ? strtoul(arguments[2], NULL, 10) * 0xD1342543DE82EF95u : 0);
    clock_t began = clock();
    for (uint32_t n = 0; n < SEEDS; n++) {
        uint8_t bytes[MOST];
        size_t size = fuzz_seed(n, bytes, MOST);
        FUZZ_CHECK(size > 0);
        execute(bytes, size);
    }
    for (unsigned long n = 0; n < executions; n++) {
        uint8_t bytes[MOST];
        size_t size = 0;
        if (random_below(8) == 0) {
            size = random_below(RANDOM_MOST);
            for (size_t i = 0; i < size; i++) bytes[i] = (uint8_t)random_below(256);
        } else {
            size = fuzz_seed(random_below(SEEDS), bytes, MOST);
            size = LLVMFuzzerCustomMutator(bytes, size, MOST, random_below(1u << 30));
        }
        execute(bytes, size);
    }
    printf("%lu executions, %.1f s of processor\n", executions, (double)(clock() - began) / CLOCKS_PER_SEC);
    return 0;
}
