/* SPDX-License-Identifier: MIT
 *
 * The Falcon's packets against recorded ones, its stream against broken ones; its kinematics against finite
 * differences, energy, and their own inverse.
 */
#include "check.h"
#include "devices/falcon_kinematics.h"
#include "devices/falcon_protocol.h"

static void check_packets(void)
{
    /* Recorded from the vendor's own driver. */
    static const struct {
        uint8_t bytes[16];
        int16_t motor[3];
    } recorded[] = {
        {{0x3C, 0x50, 0x50, 0x50, 0x41, 0x43, 0x45, 0x50, 0x41, 0x43, 0x4D, 0x50, 0x41, 0x45, 0x41, 0x3E},
         {4095, 3906, 4034}},
        {{0x3C, 0x46, 0x4A, 0x43, 0x41, 0x4C, 0x4E, 0x43, 0x41, 0x4F, 0x50, 0x43, 0x41, 0x45, 0x41, 0x3E},
         {661, 731, 766}},
        {{0x3C, 0x4D, 0x4B, 0x45, 0x50, 0x4C, 0x42, 0x41, 0x41, 0x42, 0x4B, 0x44, 0x41, 0x45, 0x41, 0x3E},
         {-2900, 27, 929}}};
    for (size_t n = 0; n < sizeof recorded / sizeof *recorded; n++) {
        vxsi_falcon_output output;
        uint8_t again[16];
        CHECK(vxsi_falcon_decode_output(recorded[n].bytes, &output));
        for (int i = 0; i < 3; i++) CHECK_INT(output.motor[i], recorded[n].motor[i]);
        CHECK_INT(output.lamps, VXSI_FALCON_BLUE);
        vxsi_falcon_encode_output(&output, again);
        CHECK(memcmp(again, recorded[n].bytes, 16) == 0);
    }
    vxsi_falcon_input input;
    const uint8_t state[16] = {'<', 0x4A, 0x46, 0x4B, 0x50, 'A',        'A', 'A',
                               'A', 'P',  'P',  'P',  'H',  'A' + 0x74, 'A', '>'};
    CHECK(vxsi_falcon_decode_input(state, &input));
    CHECK(input.encoder[0] == -1447 && input.encoder[1] == 0 && input.encoder[2] == 32767);
    CHECK(input.homed == 7 && input.buttons == 4);
    uint8_t bytes[16], broken[16];
    vxsi_falcon_encode_input(&input, bytes);
    CHECK(memcmp(bytes, state, 16) == 0);
    for (int n = 0; n < 14; n++) {
        memcpy(broken, state, 16);
        broken[n] = 0x20;
        CHECK(!vxsi_falcon_decode_input(broken, &input));
    }
    /* Every number there is, both ways. */
    for (int32_t v = -32768; v <= 32767; v++) {
        vxsi_falcon_input in = {{(int16_t)v, (int16_t)~v, 5}, (uint8_t)(v & 15), (uint8_t)(v & 7)}, out;
        vxsi_falcon_encode_input(&in, bytes);
        CHECK(vxsi_falcon_decode_input(bytes, &out) && memcmp(&in, &out, sizeof in) == 0);
    }
}

static void check_stream(void)
{
    vxsi_falcon_stream stream = {.count = 0};
    vxsi_falcon_input input = {{1, 2, 3}, 0, 7}, out;
    uint8_t packet[16];
    vxsi_falcon_encode_input(&input, packet);
    CHECK_INT(vxsi_falcon_take(&stream, 'x'), -1); /* begins in the middle of one */
    for (int whole = 0; whole < 3; whole++)
        for (int n = 0; n < 16; n++) CHECK_INT(vxsi_falcon_take(&stream, packet[n]), n == 15);
    CHECK(vxsi_falcon_decode_input(stream.bytes, &out) && out.encoder[2] == 3);
    for (int n = 0; n < 9; n++) CHECK_INT(vxsi_falcon_take(&stream, packet[n]), 0);
    CHECK_INT(vxsi_falcon_take(&stream, packet[0]), -1); /* bytes were lost: the next is whole */
    for (int n = 1; n < 16; n++) CHECK_INT(vxsi_falcon_take(&stream, packet[n]), n == 15);
    for (int n = 0; n < 15; n++) vxsi_falcon_take(&stream, packet[n]);
    CHECK_INT(vxsi_falcon_take(&stream, 'A'), -1); /* does not end */

    uint8_t bytes[130];
    for (int n = 0; n < 130; n++) bytes[n] = (uint8_t)n;
    CHECK_INT(vxsi_ftdi_strip(bytes, 130), 124); /* 62 + 62 + nothing */
    CHECK(bytes[0] == 2 && bytes[61] == 63 && bytes[62] == 66 && bytes[123] == 127);
    CHECK_INT(vxsi_ftdi_strip(bytes, 2), 0);
    CHECK_INT(vxsi_ftdi_strip(bytes, 1), 0);
    CHECK_INT(vxsi_ftdi_strip(bytes, 0), 0);
}

/* d angle / d place of order 4: error h^4, far below 1e-8 for h = 7 um; what is left is rounding where a leg
 * is all but stretched. */
static void check_kinematics(void)
{
    double worst_jacobian = 0, worst_way = 0, worst_work = 0;
    int places = 0;
    for (int x = -4; x <= 4; x++) {
        for (int y = -4; y <= 4; y++) {
            for (int z = 0; z <= 9; z++) {
                double place[3] = {x * 0.01, y * 0.01, 0.075 + z * 0.01}, angle[3], jacobian[9];
                if (!vxsi_falcon_inverse(place, angle, jacobian)) continue;
                places++;
                double scale = 0, error = 0;
                for (int i = 0; i < 3; i++) {
                    double h = 7e-6, side[4][3];
                    static const double steps[4] = {-2, -1, 1, 2};
                    for (int k = 0; k < 4; k++) {
                        double near[3] = {place[0], place[1], place[2]};
                        near[i] += steps[k] * h;
                        CHECK(vxsi_falcon_inverse(near, side[k], NULL));
                    }
                    for (int n = 0; n < 3; n++) {
                        double slope = (8 * (side[2][n] - side[1][n]) - (side[3][n] - side[0][n])) / (12 * h);
                        error = fmax(error, fabs(slope - jacobian[3 * n + i]));
                        scale = fmax(scale, fabs(jacobian[3 * n + i]));
                    }
                }
                worst_jacobian = fmax(worst_jacobian, error / scale);

                /* Back to the place, from far off and from nonsense. */
                static const double guesses[][3] = {
                    {0, 0, 0.12}, {0.04, -0.04, 0.16}, {-0.05, 0.05, 0.08}, {NAN, 0, 0}, {1, 1, -1}};
                for (size_t g = 0; g < sizeof guesses / sizeof *guesses; g++) {
                    double found[3] = {guesses[g][0], guesses[g][1], guesses[g][2]};
                    CHECK(vxsi_falcon_forward(angle, found));
                    for (int i = 0; i < 3; i++) worst_way = fmax(worst_way, fabs(found[i] - place[i]));
                }

                /* Virtual work: force . d place = torque . d angle, for any small way. */
                double force[3] = {3, -2, 1}, torque[3], way[3] = {1e-3, 2e-3, -1e-3}, work[2] = {0, 0};
                CHECK(vxsi_falcon_torque(jacobian, force, torque));
                for (int n = 0; n < 3; n++) {
                    double turn = 0;
                    for (int i = 0; i < 3; i++) turn += jacobian[3 * n + i] * way[i];
                    work[0] += torque[n] * turn;
                    work[1] += force[n] * way[n];
                }
                worst_work = fmax(worst_work, fabs(work[0] / work[1] - 1));
            }
        }
    }
    printf("falcon: %d places, Jacobian off by %.2g of its largest, place by %.2g m, work by %.2g\n", places,
           worst_jacobian, worst_way, worst_work);
    CHECK(places > 700);
    CHECK(worst_jacobian <= 1e-8);
    CHECK(worst_way <= 1e-11);
    CHECK(worst_work <= 1e-12);

    /* At rest (encoders 0) the tip is on the axis; the sum over the symmetric legs keeps it there. */
    double place[3] = {0.01, 0.01, 0.1},
           angle[3] = {vxsi_falcon_angle(0), vxsi_falcon_angle(0), vxsi_falcon_angle(0)};
    CHECK(vxsi_falcon_forward(angle, place));
    printf("falcon: encoders 0 at z = %.5f m\n", place[2]);
    CHECK_NEAR(place[2], 0.1346, 1e-4);
    CHECK_NEAR(place[0], 0, 1e-9);
    CHECK_NEAR(place[1], 0, 1e-9);
    for (int32_t c = -32768; c <= 32767; c += 7)
        CHECK_INT(vxsi_falcon_count(vxsi_falcon_angle((int16_t)c)), c);

    /* Angles of no place: said so, and at once. */
    double none[3] = {3, -3, 3}, far[3] = {1, 1, 1}, nan_angle[3] = {NAN, 0, 0}, kept[3] = {0, 0, 0.12};
    CHECK(!vxsi_falcon_inverse(far, none, NULL));
    CHECK(!vxsi_falcon_forward(none, kept) && !vxsi_falcon_forward(nan_angle, kept) && kept[2] == 0.12);
}

/* An angle that no encoder counts to is the last one that it does; a Jacobian without rank has no torques. */
static void check_limits(void)
{
    const double line[9] = {1, 2, 3, 2, 4, 6, 0, 0, 1}, force[3] = {1, 1, 1};
    double torque[3] = {7, 7, 7};
    CHECK_INT(vxsi_falcon_count(1e6), vxsi_falcon_count(1e9));
    CHECK_INT(vxsi_falcon_count(-1e6), vxsi_falcon_count(-1e9));
    CHECK_INT(vxsi_falcon_count(1e6) + vxsi_falcon_count(-1e6), -1);
    CHECK(!vxsi_falcon_torque(line, force, torque) && torque[0] == 7);
}

int main(void)
{
    check_packets();
    check_stream();
    check_kinematics();
    check_limits();
    return 0;
}
