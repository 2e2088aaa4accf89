/* SPDX-License-Identifier: MIT
 *
 * CRC-32 against published values and against the definition, bit by bit.
 */
#include "check.h"
#include "voxshell/asset.h"

static uint32_t by_definition(const uint8_t *bytes, size_t size)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t n = 0; n < size; n++) {
        for (int bit = 0; bit < 8; bit++) {
            uint32_t differs = (crc ^ (uint32_t)bytes[n] >> bit) & 1u;
            crc = crc >> 1 ^ (differs ? 0xEDB88320u : 0);
        }
    }
    return ~crc;
}

int main(void)
{
    CHECK_INT(vxs_asset_crc32("", 0), 0);
    CHECK_INT(vxs_asset_crc32("a", 1), 0xE8B7BE43u);
    CHECK_INT(vxs_asset_crc32("123456789", 9), 0xCBF43926u);
    CHECK_INT(vxs_asset_crc32("The quick brown fox jumps over the lazy dog", 43), 0x414FA339u);

    static uint8_t bytes[70000];
    uint32_t random = 1;
    for (size_t n = 0; n < sizeof bytes; n++)
        bytes[n] = (uint8_t)((random = random * 1664525u + 1013904223u) >> 24);
    for (size_t size = 0; size < 2100; size++)
        CHECK_INT(vxs_asset_crc32(bytes + size % 7, size), by_definition(bytes + size % 7, size));
    CHECK_INT(vxs_asset_crc32(bytes, sizeof bytes), by_definition(bytes, sizeof bytes));
    return 0;
}
