/* SPDX-License-Identifier: MIT
 *
 * Names, texts and pinned values of results; the library's version.
 */
#include "check.h"
#include "voxshell/voxshell.h"

int main(void)
{
    CHECK_INT(vxs_version(), VXS_VERSION_MAJOR << 16 | VXS_VERSION_MINOR << 8 | VXS_VERSION_PATCH);
    CHECK_INT(VXS_OK, 0);
    CHECK_INT(VXS_PARAM, -1);
    CHECK_INT(VXS_CONFIG, -5);
    CHECK_INT(VXS_IO, -20);
    CHECK_INT(VXS_VERSION, -23);
    CHECK_INT(VXS_CORRUPT, -27);
    CHECK_INT(VXS_LOST, -45);
    CHECK_INT(VXS_FREQUENCY, -60);
    CHECK_INT(VXS_TWO_BODIES, -72);
    CHECK_INT(VXS_NO_THREAD, -80);
    CHECK_TEXT(vxs_result_name(VXS_OK), "VXS_OK");
    CHECK_TEXT(vxs_result_name(VXS_CHECKSUM), "VXS_CHECKSUM");
    CHECK_TEXT(vxs_result_name((vxs_result)-19), "VXS_?");
    CHECK_TEXT(vxs_result_text((vxs_result)7), "not a result of this library");

    static const vxs_result all[] = {
#define VALUE(name, value, text) VXS_##name,
        VXS_RESULT_LIST(VALUE)
#undef VALUE
    };
    for (size_t n = 0; n < sizeof all / sizeof *all; n++) {
        CHECK(n == 0 ? all[n] == 0 : all[n] < all[n - 1]); /* descending: no value twice */
        CHECK(strncmp(vxs_result_name(all[n]), "VXS_", 4) == 0 && vxs_result_name(all[n])[4] != '?');
        CHECK(strlen(vxs_result_text(all[n])) > 1);
    }
    return 0;
}
