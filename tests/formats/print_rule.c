/* SPDX-License-Identifier: MIT
 *
 * The C reader's verdict on files given on standard input, for test_readers.py: records of a
 * little-endian u32 length and that many bytes; a line for each, "OK" or "M305 BRIK 1234".
 * Every file lies in heap memory of exactly its size, so that a sanitizer sees a byte read beyond.
 */
#define _POSIX_C_SOURCE 200809L
#include "voxshell/asset.h"

#include <stdio.h>
#include <stdlib.h>

static uint8_t *read_record(size_t *size)
{
    uint8_t length[4];
    if (fread(length, 1, sizeof length, stdin) != sizeof length) return NULL;
    *size = length[0] | (size_t)length[1] << 8 | (size_t)length[2] << 16 | (size_t)length[3] << 24;
    void *data = NULL;
    if (posix_memalign(&data, VXS_CONTAINER_ALIGNMENT, *size) != 0) return NULL;
    if (fread(data, 1, *size, stdin) != *size) {
        free(data);
        return NULL;
    }
    return data;
}

int main(void)
{
    size_t size;
    uint8_t *data;
    while ((data = read_record(&size)) != NULL) {
        vxs_asset asset;
        vxs_asset_issue issue;
        vxs_result result = vxs_asset_from_memory(data, size, NULL, &asset, &issue);
        if (result == VXS_OK) {
            puts("OK");
            vxs_asset_close(&asset);
        } else {
            uint32_t id = issue.section;
            printf("%c%u %c%c%c%c %llu\n", issue.letter, (unsigned)issue.rule, (int)(id & 0xFF),
                   (int)(id >> 8 & 0xFF), (int)(id >> 16 & 0xFF), (int)(id >> 24 & 0xFF),
                   (unsigned long long)issue.offset);
        }
        free(data);
    }
    return 0;
}
