/* SPDX-License-Identifier: MIT
 *
 * CRC-32 (IEEE 802.3, reflected, 0xEDB88320), sixteen bytes a step. The tables are made per
 * call on the stack (some 10 us): no global state, no start-up code.
 */
#include "asset_check.h"

#include <string.h>

enum { SLICES = 16, TABLE_FROM = 1024 };

static uint32_t crc_bits(uint32_t crc)
{
    for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (0xEDB88320u & (0u - (crc & 1u)));
    return crc;
}

static void fill_tables(uint32_t table[SLICES][256])
{
    for (uint32_t byte = 0; byte < 256; byte++) table[0][byte] = crc_bits(byte);
    for (int slice = 1; slice < SLICES; slice++) {
        for (uint32_t byte = 0; byte < 256; byte++) {
            uint32_t before = table[slice - 1][byte];
            table[slice][byte] = before >> 8 ^ table[0][before & 0xFFu];
        }
    }
}

static uint32_t load32(const uint8_t *bytes)
{
    uint32_t word;
    memcpy(&word, bytes, sizeof word);
    return word;
}

static uint32_t four(uint32_t table[SLICES][256], int last, uint32_t word)
{
    return table[last + 3][word & 0xFFu] ^ table[last + 2][word >> 8 & 0xFFu] ^
           table[last + 1][word >> 16 & 0xFFu] ^ table[last][word >> 24];
}

uint32_t vxsi_crc32(const uint8_t *data, size_t size)
{
    uint32_t crc = 0xFFFFFFFFu;
    if (size >= TABLE_FROM) {
        uint32_t table[SLICES][256];
        fill_tables(table);
        for (; size >= SLICES; size -= SLICES, data += SLICES) {
            crc = four(table, 12, crc ^ load32(data)) ^ four(table, 8, load32(data + 4)) ^
                  four(table, 4, load32(data + 8)) ^ four(table, 0, load32(data + 12));
        }
    }
    for (; size > 0; size--, data++) crc = crc_bits(crc ^ *data);
    return ~crc;
}

uint32_t vxs_asset_crc32(const void *data, size_t size)
{
    return vxsi_crc32(data, size);
}
