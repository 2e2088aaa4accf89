/* SPDX-License-Identifier: MIT
 *
 * Each single bit of each golden file, flipped: the reader refuses all of them, before any content hash. The
 * checksums of header (C104), table (C110) and sections (C302) and the padding's rule (C301) leave no byte
 * out.
 */
#define _DEFAULT_SOURCE 1 /* scandir */

#include "asset_builder.h"
#include "check.h"

#include <dirent.h>

static built_asset golden(const char *name)
{
    char path[1024];
    static uint64_t bytes[1 << 13];
    snprintf(path, sizeof path, "%s/tests/golden/valid/%s", VXS_TEST_SOURCE_DIR, name);
    FILE *file = fopen(path, "rb");
    CHECK(file != NULL);
    built_asset view = {(uint8_t *)bytes, fread(bytes, 1, sizeof bytes, file)};
    CHECK(fgetc(file) == EOF);
    fclose(file);
    return built_prefix(&view, view.size);
}

static vxs_result verdict(const built_asset *bytes, vxs_asset_issue *issue)
{
    vxs_asset asset;
    return vxs_asset_from_memory(bytes->data, bytes->size, NULL, &asset, issue);
}

/* step: each so many-th bit. */
static long flip_all(const char *name, size_t step)
{
    built_asset bytes = golden(name);
    vxs_asset_issue issue;
    long flips = 0;
    CHECK_INT(verdict(&bytes, &issue), VXS_OK);
    for (size_t bit = 0; bit < bytes.size * 8; bit += step, flips++) {
        bytes.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
        if (verdict(&bytes, &issue) == VXS_OK) CHECK_FAIL("%s: bit %zu of byte %zu", name, bit % 8, bit / 8);
        CHECK(issue.letter == 'C' && issue.rule < 303); /* no rule of meaning is needed */
        bytes.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
    }
    built_free(&bytes);
    return flips;
}

int main(int count, char **arguments)
{
    struct dirent **found;
    int files = scandir(VXS_TEST_SOURCE_DIR "/tests/golden/valid", &found, NULL, alphasort), tried = 0;
    long flips = 0;
    size_t step = count > 1 ? (size_t)atoi(arguments[1]) : 1;
    for (int n = 0; n < files; n++) {
        if (found[n]->d_name[0] != '.') {
            flips += flip_all(found[n]->d_name, step);
            tried++;
        }
        free(found[n]);
    }
    free(found);
    CHECK(tried >= 10 && flips > 0);
    printf("%ld bits of %d files, each found\n", flips, tried);
    return 0;
}
