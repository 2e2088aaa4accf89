/* SPDX-License-Identifier: MIT
 *
 * In a program whose language has decimal commas a script is read as in any other, and so is an asset. The
 * language is made for the occasion; without localedef the test is skipped.
 */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "asset_builder.h"
#include "check.h"
#include "voxshell/replay.h"

#include <locale.h>

int main(void)
{
    if (system("localedef -i de_DE -f UTF-8 ./de_DE.UTF-8 >/dev/null 2>&1") == -1) SKIP("no shell");
    CHECK(setenv("LOCPATH", ".", 1) == 0);
    if (!setlocale(LC_ALL, "de_DE.UTF-8")) SKIP("no localedef, or not its German");
    CHECK(strtod("0,5", NULL) == 0.5); /* so it is such a language */
    static const char script[] = "t_s,x_m,y_m,z_m\n0.25,0.5,-1.5e-3,2\n1.5,0,0,0\n";
    vxs_replay_row rows[4];
    size_t count = 0, line = 0;
    CHECK_INT(vxs_replay_parse(script, sizeof script - 1, rows, 4, &count, &line), VXS_OK);
    CHECK_INT(count, 2);
    CHECK(rows[0].time == 0.25 && rows[0].pose.position[0] == 0.5 && rows[0].pose.position[1] == -1.5e-3);
    CHECK(strtod("0,5", NULL) == 0.5); /* and still is */
    built_ball ball = {0.001, {0, 0, 0}, 0.0063};
    built_asset bytes = build_ball_map(&ball, BUILT_PLAIN);
    (void)open_voxmap(&bytes);
    built_free(&bytes);
    return 0;
}
