/* SPDX-License-Identifier: MIT
 *
 * Any bytes as a hAPI frame, to the host and to the board; any angles through the pantograph.
 */
#include "devices/haply_kinematics.h"
#include "devices/haply_protocol.h"
#include "fuzz_target.h"

#include <math.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static const vxsi_haply_setup known = {.device = 5, .motor_ports = 3, .encoder_ports = 3};
    static const vxsi_pantograph shape = {0.05, 0.07, 0.02};
    vxsi_haply_setup setup;
    float degrees[VXSI_HAPLY_PORTS], torque[VXSI_HAPLY_PORTS];
    uint8_t again[VXSI_HAPLY_FRAME];
    if (vxsi_haply_decode_state(&known, bytes, size, degrees)) {
        FUZZ_CHECK(vxsi_haply_encode_state(&known, degrees, again) == size &&
                   memcmp(again, bytes, size) == 0);
        double angle[2] = {degrees[0] * 0.017453292519943295, degrees[1] * 0.017453292519943295};
        double place[2], jacobian[4];
        if (vxsi_pantograph_forward(&shape, angle, place, jacobian))
            FUZZ_CHECK(isfinite(place[0] + place[1]) &&
                       isfinite(jacobian[0] + jacobian[1] + jacobian[2] + jacobian[3]));
    }
    switch (vxsi_haply_decode(bytes, size, &known, &setup, torque)) {
    case 1:
        FUZZ_CHECK(vxsi_haply_encode_setup(&setup, again) == size && memcmp(again, bytes, size) == 0);
        break;
    case 2:
        FUZZ_CHECK(vxsi_haply_encode_torque(&known, torque, again) == size &&
                   memcmp(again, bytes, size) == 0);
        break;
    default:
        break;
    }
    return 0;
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    vxsi_haply_setup setup = {.device = 5,
                              .motor_ports = number >> 2 & 15,
                              .encoder_ports = number & 15,
                              .offset = {-61, 241},
                              .counts = {1, 2, 3, 4}};
    const float numbers[VXSI_HAPLY_PORTS] = {(float)number * 4, 180 - (float)number, 0, 1};
    if (most < VXSI_HAPLY_FRAME) return 0;
    if (number % 3 == 0) return vxsi_haply_encode_setup(&setup, bytes);
    setup.motor_ports = setup.encoder_ports = 3;
    return number % 3 == 1 ? vxsi_haply_encode_state(&setup, numbers, bytes)
                           : vxsi_haply_encode_torque(&setup, numbers, bytes);
}
