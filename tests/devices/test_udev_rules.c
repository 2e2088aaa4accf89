/* SPDX-License-Identifier: MIT
 *
 * The rules that a package installs name each device that the drivers know, and no other.
 */
#include "check.h"
#include "devices/spacemouse_protocol.h"

static size_t occurrences(const char *text, const char *of)
{
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, of)) != NULL; at += strlen(of)) count++;
    return count;
}

int main(void)
{
    static char text[16384];
    FILE *file = fopen(VXS_TEST_SOURCE_DIR "/runtime/cmake/70-voxshell.rules", "r");
    CHECK(file != NULL);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);

    size_t known = 0;
    for (uint32_t vendor = 0; vendor < 65536; vendor++) {
        if (vendor != 0x046D && vendor != 0x256F && vendor % 97 != 0) continue;
        char usb[64];
        snprintf(usb, sizeof usb, "SUBSYSTEM==\"usb\", ATTR{idVendor}==\"%04x\"", vendor);
        const char *line = strstr(text, usb);
        for (uint32_t product = 0; product < 65536; product++) {
            if (!vxsi_spacemouse_is_known((uint16_t)vendor, (uint16_t)product)) continue;
            known++;
            char hidraw[32], name[8];
            snprintf(hidraw, sizeof hidraw, "*:%04X:%04X.*", vendor, product);
            CHECK(occurrences(text, hidraw) == 1);
            snprintf(name, sizeof name, "%04x", product);
            const char *found = line ? strstr(line + strlen(usb), name) : NULL;
            CHECK(found && !memchr(line, '\n', (size_t)(found - line)));
        }
    }
    CHECK(known == 22);
    CHECK(occurrences(text, "*:") == known);
    CHECK(occurrences(text, "|c6") + 2 == known); /* and two that come first */
    CHECK(strstr(text, "ATTR{idVendor}==\"0403\", ATTR{idProduct}==\"cb48\"") != NULL);
    CHECK(strstr(text, "MODE") == NULL); /* for who sits there, not for all */
    CHECK(occurrences(text, "TAG+=\"uaccess\"\n") == occurrences(text, "SUBSYSTEM=="));
    return 0;
}
