/* SPDX-License-Identifier: MIT
 *
 * Any bytes as a report: axes stay in their range, rates in theirs; what is in range encodes to the same
 * bytes.
 */
#include "devices/spacemouse_protocol.h"
#include "fuzz_target.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    vxsi_spacemouse_axes axes = {{0}, 0};
    uint8_t again[VXSI_SPACEMOUSE_REPORT];
    double rate[2][3];
    int kind = vxsi_spacemouse_decode(bytes, size, &axes), is_within = 1;
    for (int n = 0; n < 6; n++) FUZZ_CHECK(axes.axis[n] >= -350 && axes.axis[n] <= 350);
    vxsi_spacemouse_rate(&axes, rate[0], rate[1]);
    for (int n = 0; n < 6; n++) FUZZ_CHECK(rate[n / 3][n % 3] >= -1 && rate[n / 3][n % 3] <= 1);
    if (kind != VXSI_SPACEMOUSE_PLACE && kind != VXSI_SPACEMOUSE_TURN && kind != VXSI_SPACEMOUSE_BOTH)
        return 0;
    size_t count = vxsi_spacemouse_encode(&axes, kind, again);
    FUZZ_CHECK(count <= size);
    for (int n = 0; n < 6; n++) is_within &= axes.axis[n] > -350 && axes.axis[n] < 350;
    if (is_within) FUZZ_CHECK(memcmp(again, bytes, count) == 0);
    return 0;
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    const vxsi_spacemouse_axes axes = {{(int16_t)(number * 5), -350, 350, (int16_t)-number, 0, 9}, number};
    static const int kinds[4] = {VXSI_SPACEMOUSE_PLACE, VXSI_SPACEMOUSE_TURN, VXSI_SPACEMOUSE_BOTH,
                                 VXSI_SPACEMOUSE_BUTTONS};
    return most < VXSI_SPACEMOUSE_REPORT ? 0 : vxsi_spacemouse_encode(&axes, kinds[number % 4], bytes);
}
