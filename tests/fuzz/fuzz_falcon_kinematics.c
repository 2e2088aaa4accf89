/* SPDX-License-Identifier: MIT
 *
 * Any three counts, from any place on: they lead to a place that has these very counts, or to none; forces
 * there make torques that are finite, and do the same work. Six bytes are the counts, bytes from 6 on a place
 * to begin from; with an odd first byte the counts are brought near those of the workspace, where most have a
 * place.
 */
#include "devices/falcon_kinematics.h"
#include "fuzz_target.h"

#include <math.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    int16_t count[3];
    double angle[3], begin[3] = {0, 0, 0.12}, place[3], again[3], jacobian[9];
    const double force[3] = {1, -2, 3};
    double torque[3];
    if (size < sizeof count) return 0;
    memcpy(count, bytes, sizeof count);
    if (size >= sizeof count + sizeof begin) memcpy(begin, bytes + sizeof count, sizeof begin);
    for (int n = 0; n < 3; n++) {
        if (bytes[0] & 1) count[n] = (int16_t)(count[n] % 1500);
        angle[n] = vxsi_falcon_angle(count[n]);
    }
    memcpy(place, begin, sizeof place);
    if (!vxsi_falcon_forward(angle, place)) {
        FUZZ_CHECK(memcmp(place, begin, sizeof place) == 0);
        return 0;
    }
    FUZZ_CHECK(isfinite(place[0]) && isfinite(place[1]) && isfinite(place[2]));
    FUZZ_CHECK(vxsi_falcon_inverse(place, again, jacobian));
    for (int n = 0; n < 3; n++) FUZZ_CHECK(vxsi_falcon_count(again[n]) == count[n]);
    if (vxsi_falcon_torque(jacobian, force, torque)) FUZZ_CHECK(isfinite(torque[0] + torque[1] + torque[2]));
    return 0;
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    const int16_t count[3] = {(int16_t)(number * 37 - 1000), (int16_t)(500 - number * 11),
                              (int16_t)(number * 5)};
    const double begin[3] = {(double)number * 1e-3 - 0.03, 0, 0.12};
    if (most < sizeof count + sizeof begin) return 0;
    memcpy(bytes, count, sizeof count);
    if (number % 2) return sizeof count;
    memcpy(bytes + sizeof count, begin, sizeof begin);
    return sizeof count + sizeof begin;
}
