/* SPDX-License-Identifier: MIT
 *
 * spacemouse_protocol.h - private: reports of 3Dconnexion's six-axis devices. Pure: no I/O, any bytes in are
 * safe.
 *
 * A device sends turn and translation in one report or in two, which its length tells, not the model. Facts:
 * PySpaceMouse, spacenavd, AndunHH/spacemouse. Not verified on hardware.
 */
#ifndef VXSI_SPACEMOUSE_PROTOCOL_H
#define VXSI_SPACEMOUSE_PROTOCOL_H

#include <stddef.h>
#include <stdint.h>

enum { VXSI_SPACEMOUSE_REPORT = 16, VXSI_SPACEMOUSE_FULL = 350, VXSI_SPACEMOUSE_DEAD = 10 };

/* What the cap shows, as sent: x right, y towards the user, z down; then turns about them; -350 .. 350. */
typedef struct vxsi_spacemouse_axes {
    int16_t axis[6];
    uint32_t buttons;
} vxsi_spacemouse_axes;

enum {
    VXSI_SPACEMOUSE_NONE = 0,    /* not one of ours, or cut short */
    VXSI_SPACEMOUSE_PLACE = 1,   /* x y z; the turn follows */
    VXSI_SPACEMOUSE_TURN = 2,    /* turns */
    VXSI_SPACEMOUSE_BOTH = 3,    /* all six */
    VXSI_SPACEMOUSE_BUTTONS = 4, /* up to 32 */
    VXSI_SPACEMOUSE_BATTERY = 5
};

/* Takes a report into *axes, what it does not speak of stays. Returns which it was. Numbers beyond the range
 * are brought into it. */
int vxsi_spacemouse_decode(const uint8_t *bytes, size_t size, vxsi_spacemouse_axes *axes);

/* The device's end, for emulation. kind: PLACE, TURN, BOTH or BUTTONS. Returns the report's size. */
size_t vxsi_spacemouse_encode(const vxsi_spacemouse_axes *axes, int kind,
                              uint8_t bytes[VXSI_SPACEMOUSE_REPORT]);

/* Report to the lamp. Returns its size. */
size_t vxsi_spacemouse_encode_lamp(int is_on, uint8_t bytes[VXSI_SPACEMOUSE_REPORT]);

/* Share -1 .. 1 of full speed along and about x right, y up, z towards the user; zero within the dead band
 * and without a jump at its edge. */
void vxsi_spacemouse_rate(const vxsi_spacemouse_axes *axes, double translation[3], double turn[3]);

/* Whether vendor and product are a six-axis device that is known to speak this. */
int vxsi_spacemouse_is_known(uint16_t vendor, uint16_t product);

#endif
