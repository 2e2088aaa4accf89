/* SPDX-License-Identifier: MIT
 *
 * hAPI frames and the pantograph: bytes both ways; finite differences, virtual work, the inverse.
 */
#include "check.h"
#include "devices/haply_kinematics.h"
#include "devices/haply_protocol.h"

static const vxsi_haply_setup typical = {.device = 5,
                                         .motor_ports = 3,
                                         .encoder_ports = 3,
                                         .motor_turn = {0, 1},
                                         .encoder_turn = {0, 1},
                                         .offset = {-61, 241},
                                         .counts = {10752, 10752}};

static void check_frames(void)
{
    uint8_t bytes[VXSI_HAPLY_FRAME];
    /* By hand from the published order: kind, id, motors, encoders, no sensors, no outputs, then offset and
     * counts. */
    static const uint8_t setup[] = {1,    5,    3,    0,    1,    3,    0,    1,    0,
                                    0,    0x00, 0x00, 0x74, 0xC2, 0x00, 0x00, 0x28, 0x46,
                                    0x00, 0x00, 0x71, 0x43, 0x00, 0x00, 0x28, 0x46};
    CHECK_INT(vxsi_haply_encode_setup(&typical, bytes), sizeof setup);
    CHECK(memcmp(bytes, setup, sizeof setup) == 0);
    vxsi_haply_setup back;
    float torque[VXSI_HAPLY_PORTS] = {0};
    CHECK_INT(vxsi_haply_decode(setup, sizeof setup, &typical, &back, torque), 1);
    CHECK(back.offset[1] == 241 && back.counts[0] == 10752 && back.motor_turn[1] == 1 && back.device == 5);
    for (size_t cut = 0; cut < sizeof setup; cut++)
        CHECK_INT(vxsi_haply_decode(setup, cut, &typical, &back, torque), -1);

    static const uint8_t write[] = {2, 5, 0x00, 0x00, 0x00, 0x3F, 0x00, 0x00, 0xA0, 0xBF};
    const float wanted[2] = {0.5f, -1.25f};
    CHECK_INT(vxsi_haply_encode_torque(&typical, wanted, bytes), sizeof write);
    CHECK(memcmp(bytes, write, sizeof write) == 0);
    CHECK_INT(vxsi_haply_decode(write, sizeof write, &typical, &back, torque), 2);
    CHECK(torque[0] == 0.5f && torque[1] == -1.25f);
    CHECK_INT(vxsi_haply_encode_reset(5, bytes), 2);
    CHECK_INT(vxsi_haply_decode(bytes, 2, &typical, &back, torque), 0);

    static const uint8_t state[] = {5, 0x00, 0x00, 0x34, 0x42, 0x00, 0x00, 0x07, 0xC3};
    float degrees[VXSI_HAPLY_PORTS] = {0};
    CHECK_INT(vxsi_haply_state_size(&typical), sizeof state);
    CHECK(vxsi_haply_decode_state(&typical, state, sizeof state, degrees));
    CHECK(degrees[0] == 45 && degrees[1] == -135);
    CHECK_INT(vxsi_haply_encode_state(&typical, degrees, bytes), sizeof state);
    CHECK(memcmp(bytes, state, sizeof state) == 0);
    CHECK(!vxsi_haply_decode_state(&typical, state, sizeof state - 1, degrees));
    bytes[0] = 6;
    CHECK(!vxsi_haply_decode_state(&typical, bytes, sizeof state, degrees)); /* another device's */
    CHECK(vxsi_haply_ports(0) == 0 && vxsi_haply_ports(0xFF) == 4 && vxsi_haply_ports(10) == 2);
}

static void check_pantograph(void)
{
    static const vxsi_pantograph shapes[] = {{0.05, 0.07, 0.02}, {0.07, 0.09, 0.038}, {0.05, 0.07, 0}};
    double worst_jacobian = 0, worst_way = 0, worst_work = 0;
    int places = 0;
    for (size_t k = 0; k < sizeof shapes / sizeof *shapes; k++) {
        for (int i = -9; i <= 9; i++) {
            for (int j = 2; j <= 11; j++) {
                double place[2] = {shapes[k].base / 2 + 0.005 * i, 0.01 * j}, angle[2], found[2], jacobian[4];
                if (!vxsi_pantograph_inverse(&shapes[k], place, angle)) continue;
                if (!vxsi_pantograph_forward(&shapes[k], angle, found, jacobian)) continue;
                if (fabs(found[1] - place[1]) > 1e-3) continue; /* the mechanism's other side */
                double det = jacobian[0] * jacobian[3] - jacobian[1] * jacobian[2], scale = 0, error = 0;
                if (fabs(det) < 2e-4) continue; /* all but stretched: differences measure nothing there */
                places++;
                for (int i2 = 0; i2 < 2; i2++) worst_way = fmax(worst_way, fabs(found[i2] - place[i2]));
                for (int n = 0; n < 2; n++) {
                    double h = 2e-4, side[4][2];
                    static const double steps[4] = {-2, -1, 1, 2};
                    for (int s = 0; s < 4; s++) {
                        double near[2] = {angle[0], angle[1]};
                        near[n] += steps[s] * h;
                        CHECK(vxsi_pantograph_forward(&shapes[k], near, side[s], NULL));
                    }
                    for (int c = 0; c < 2; c++) {
                        double slope = (8 * (side[2][c] - side[1][c]) - (side[3][c] - side[0][c])) / (12 * h);
                        error = fmax(error, fabs(slope - jacobian[2 * c + n]));
                        scale = fmax(scale, fabs(jacobian[2 * c + n]));
                    }
                }
                worst_jacobian = fmax(worst_jacobian, error / scale);
                const double force[2] = {1, -2}, turn[2] = {1e-3, 2e-3};
                double work[2] = {0, 0};
                for (int n = 0; n < 2; n++) {
                    work[0] += (jacobian[n] * force[0] + jacobian[2 + n] * force[1]) * turn[n];
                    work[1] += force[n] * (jacobian[2 * n] * turn[0] + jacobian[2 * n + 1] * turn[1]);
                }
                worst_work = fmax(worst_work, fabs(work[0] - work[1]));
            }
        }
    }
    printf("pantograph: %d places, Jacobian off by %.2g of its largest, place by %.2g m\n", places,
           worst_jacobian, worst_way);
    CHECK(places > 200);
    CHECK(worst_jacobian <= 1e-8);
    CHECK(worst_way <= 1e-12);
    CHECK(worst_work <= 1e-15);
    const double apart[2] = {3.14159, 0}, nothing[2] = {NAN, 0};
    double place[2], jacobian[4];
    const vxsi_pantograph wide = {0.05, 0.03, 0.02};
    CHECK(!vxsi_pantograph_forward(&wide, apart, place, jacobian));
    CHECK(!vxsi_pantograph_forward(&shapes[0], nothing, place, jacobian));
}

int main(void)
{
    check_frames();
    check_pantograph();
    return 0;
}
