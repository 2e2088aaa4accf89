/* SPDX-License-Identifier: MIT */
#include "spacemouse_protocol.h"

#include <string.h>

enum { ID_PLACE = 1, ID_TURN = 2, ID_BUTTONS = 3, ID_LAMP = 4, ID_BATTERY = 0x17 };
enum { SHORT_REPORT = 7, LONG_REPORT = 13 };

static void take(const uint8_t *bytes, int first, int count, vxsi_spacemouse_axes *axes)
{
    for (int n = 0; n < count; n++) {
        int32_t value = bytes[2 * n] | bytes[2 * n + 1] << 8;
        if (value >= 0x8000) value -= 0x10000;
        if (value > VXSI_SPACEMOUSE_FULL) value = VXSI_SPACEMOUSE_FULL;
        if (value < -VXSI_SPACEMOUSE_FULL) value = -VXSI_SPACEMOUSE_FULL;
        axes->axis[first + n] = (int16_t)value;
    }
}

int vxsi_spacemouse_decode(const uint8_t *bytes, size_t size, vxsi_spacemouse_axes *axes)
{
    if (size < 2) return VXSI_SPACEMOUSE_NONE;
    switch (bytes[0]) {
    case ID_PLACE:
        if (size < SHORT_REPORT) return VXSI_SPACEMOUSE_NONE;
        take(bytes + 1, 0, size >= LONG_REPORT ? 6 : 3, axes);
        return size >= LONG_REPORT ? VXSI_SPACEMOUSE_BOTH : VXSI_SPACEMOUSE_PLACE;
    case ID_TURN:
        if (size < SHORT_REPORT) return VXSI_SPACEMOUSE_NONE;
        take(bytes + 1, 3, 3, axes);
        return VXSI_SPACEMOUSE_TURN;
    case ID_BUTTONS: {
        uint32_t buttons = 0;
        for (size_t n = 1; n < size && n <= 4; n++) buttons |= (uint32_t)bytes[n] << 8 * (n - 1);
        axes->buttons = buttons;
        return VXSI_SPACEMOUSE_BUTTONS;
    }
    case ID_BATTERY:
        return VXSI_SPACEMOUSE_BATTERY;
    default:
        return VXSI_SPACEMOUSE_NONE;
    }
}

size_t vxsi_spacemouse_encode(const vxsi_spacemouse_axes *axes, int kind,
                              uint8_t bytes[VXSI_SPACEMOUSE_REPORT])
{
    memset(bytes, 0, VXSI_SPACEMOUSE_REPORT);
    if (kind == VXSI_SPACEMOUSE_BUTTONS) {
        bytes[0] = ID_BUTTONS;
        for (int n = 0; n < 4; n++) bytes[1 + n] = (uint8_t)(axes->buttons >> 8 * n);
        return 5;
    }
    int first = kind == VXSI_SPACEMOUSE_TURN ? 3 : 0, count = kind == VXSI_SPACEMOUSE_BOTH ? 6 : 3;
    bytes[0] = kind == VXSI_SPACEMOUSE_TURN ? ID_TURN : ID_PLACE;
    for (int n = 0; n < count; n++) {
        bytes[1 + 2 * n] = (uint8_t)axes->axis[first + n];
        bytes[2 + 2 * n] = (uint8_t)((uint16_t)axes->axis[first + n] >> 8);
    }
    return 1 + 2 * (size_t)count;
}

size_t vxsi_spacemouse_encode_lamp(int is_on, uint8_t bytes[VXSI_SPACEMOUSE_REPORT])
{
    bytes[0] = ID_LAMP;
    bytes[1] = is_on ? 1 : 0;
    return 2;
}

static double share(int16_t axis)
{
    int32_t size = axis < 0 ? -axis : axis;
    double past = size > VXSI_SPACEMOUSE_DEAD ? size - VXSI_SPACEMOUSE_DEAD : 0;
    past /= VXSI_SPACEMOUSE_FULL - VXSI_SPACEMOUSE_DEAD;
    return axis < 0 ? -past : past;
}

/* (right, towards the user, down) is right-handed as (right, up, towards the user) is: turns go as places do.
 */
void vxsi_spacemouse_rate(const vxsi_spacemouse_axes *axes, double translation[3], double turn[3])
{
    double *to[2] = {translation, turn};
    for (int n = 0; n < 2; n++) {
        to[n][0] = share(axes->axis[3 * n]);
        to[n][1] = -share(axes->axis[3 * n + 2]);
        to[n][2] = share(axes->axis[3 * n + 1]);
    }
}

int vxsi_spacemouse_is_known(uint16_t vendor, uint16_t product)
{
    static const uint16_t logitech[] = {0xC603, 0xC605, 0xC606, 0xC621, 0xC623, 0xC625,
                                        0xC626, 0xC627, 0xC628, 0xC629, 0xC62B};
    static const uint16_t connexion[] = {0xC62E, 0xC62F, 0xC631, 0xC632, 0xC633, 0xC635,
                                         0xC636, 0xC638, 0xC63A, 0xC641, 0xC652};
    for (size_t n = 0; vendor == 0x046D && n < sizeof logitech / sizeof *logitech; n++)
        if (logitech[n] == product) return 1;
    for (size_t n = 0; vendor == 0x256F && n < sizeof connexion / sizeof *connexion; n++)
        if (connexion[n] == product) return 1;
    return 0;
}
