/* SPDX-License-Identifier: MIT
 *
 * Reports of six-axis devices, one and two of them, and what a hand on the cap means.
 */
#include "check.h"
#include "devices/spacemouse_protocol.h"

int main(void)
{
    vxsi_spacemouse_axes axes = {{0}, 0};
    uint8_t again[VXSI_SPACEMOUSE_REPORT];
    static const uint8_t place[] = {1, 0x5E, 0x01, 0xA2, 0xFE, 0x0A, 0x00}; /* 350 -350 10 */
    static const uint8_t turn[] = {2, 0x01, 0x00, 0xFF, 0xFF, 0x00, 0x00};
    static const uint8_t both[] = {1, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 0xFA, 0xFF};
    static const uint8_t buttons[] = {3, 0x02, 0x01};

    CHECK_INT(vxsi_spacemouse_decode(place, sizeof place, &axes), VXSI_SPACEMOUSE_PLACE);
    CHECK(axes.axis[0] == 350 && axes.axis[1] == -350 && axes.axis[2] == 10 && axes.axis[3] == 0);
    CHECK_INT(vxsi_spacemouse_encode(&axes, VXSI_SPACEMOUSE_PLACE, again), sizeof place);
    CHECK(memcmp(again, place, sizeof place) == 0);
    CHECK_INT(vxsi_spacemouse_decode(turn, sizeof turn, &axes), VXSI_SPACEMOUSE_TURN);
    CHECK(axes.axis[0] == 350 && axes.axis[3] == 1 && axes.axis[4] == -1); /* the other half stays */
    CHECK_INT(vxsi_spacemouse_encode(&axes, VXSI_SPACEMOUSE_TURN, again), sizeof turn);
    CHECK(memcmp(again, turn, sizeof turn) == 0);
    CHECK_INT(vxsi_spacemouse_decode(both, sizeof both, &axes), VXSI_SPACEMOUSE_BOTH);
    CHECK(axes.axis[0] == 1 && axes.axis[5] == -6);
    CHECK_INT(vxsi_spacemouse_encode(&axes, VXSI_SPACEMOUSE_BOTH, again), sizeof both);
    CHECK(memcmp(again, both, sizeof both) == 0);
    CHECK_INT(vxsi_spacemouse_decode(buttons, sizeof buttons, &axes), VXSI_SPACEMOUSE_BUTTONS);
    CHECK_INT(axes.buttons, 0x102);
    CHECK_INT(vxsi_spacemouse_encode(&axes, VXSI_SPACEMOUSE_BUTTONS, again), 5);
    CHECK_INT(vxsi_spacemouse_decode(again, 5, &axes), VXSI_SPACEMOUSE_BUTTONS);
    CHECK_INT(axes.buttons, 0x102);
    CHECK_INT(vxsi_spacemouse_encode_lamp(1, again), 2);
    CHECK(again[0] == 4 && again[1] == 1);

    /* Cut short or unknown: nothing changes. Beyond the range: brought into it. */
    for (size_t cut = 0; cut < 7; cut++)
        CHECK_INT(vxsi_spacemouse_decode(place, cut, &axes), VXSI_SPACEMOUSE_NONE);
    CHECK_INT(axes.axis[0], 1);
    static const uint8_t wild[] = {1, 0xFF, 0x7F, 0x00, 0x80, 0, 0}, unknown[] = {9, 1, 2, 3, 4, 5, 6};
    CHECK_INT(vxsi_spacemouse_decode(wild, sizeof wild, &axes), VXSI_SPACEMOUSE_PLACE);
    CHECK(axes.axis[0] == 350 && axes.axis[1] == -350);
    CHECK_INT(vxsi_spacemouse_decode(unknown, sizeof unknown, &axes), VXSI_SPACEMOUSE_NONE);

    /* Sent as (right, towards the user, down); meant as (right, up, towards the user). */
    double v[3], w[3];
    const vxsi_spacemouse_axes pushed = {{350, 180, -10, 0, 350, -350}, 0};
    vxsi_spacemouse_rate(&pushed, v, w);
    CHECK_NEAR(v[0], 1, 0);
    CHECK_NEAR(v[1], 0, 0); /* within the dead band */
    CHECK_NEAR(v[2], 0.5, 1e-15);
    CHECK_NEAR(w[0], 0, 0);
    CHECK_NEAR(w[1], 1, 0);
    CHECK_NEAR(w[2], 1, 0);
    CHECK(vxsi_spacemouse_is_known(0x046D, 0xC626) && vxsi_spacemouse_is_known(0x256F, 0xC635));
    CHECK_INT(vxsi_spacemouse_encode_lamp(0, again), 2);
    CHECK_INT(again[1], 0);
    CHECK(!vxsi_spacemouse_is_known(0x256F, 0xC650) && !vxsi_spacemouse_is_known(0x1234, 0xC626));
    return 0;
}
