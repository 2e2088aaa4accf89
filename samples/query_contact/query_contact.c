/* SPDX-License-Identifier: MIT
 *
 * Contact asked for, without a loop: what pushes where. A part's shell is moved along a line through a map, and
 * each place answers with a force, a depth and how many points touch. For planning, collision checks,
 * learning, plots. Usage: query_contact MAP.voxmap SHELL.pointshell
 */
#include "voxshell/contact.h"

#include <stdio.h>
#include <stdlib.h>

static int opens(const char *path, vxs_asset *file)
{
    vxs_asset_issue issue;
    vxs_result result = vxs_asset_open(path, NULL, file, &issue);
    if (result == VXS_OK) return 1;
    fprintf(stderr, "%s: %s", path, vxs_result_text(result));
    if (issue.rule) fprintf(stderr, " (rule %c%u: %s)", issue.letter, (unsigned)issue.rule, issue.text);
    fputc('\n', stderr);
    return 0;
}

int main(int count, char **arguments)
{
    vxs_asset map_file, shell_file;
    vxs_voxmap map;
    vxs_pointshell shell;
    if (count != 3 || !opens(arguments[1], &map_file) || !opens(arguments[2], &shell_file) ||
        vxs_voxmap_open(&map_file, &map) != VXS_OK || vxs_pointshell_open(&shell_file, &shell) != VXS_OK) {
        fprintf(stderr, "usage: query_contact MAP.voxmap SHELL.pointshell\n");
        return 1;
    }

    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = VXS_CONTACT_PATCH;
    config.field =
        vxs_contact_has_field(&map, VXS_CONTACT_DISTANCE) ? VXS_CONTACT_DISTANCE : VXS_CONTACT_SURFACE;
    config.weighting = VXS_CONTACT_AREA;
    config.stiffness = 3e8; /* [N/m^3]: 0.3 N for each square millimetre that is a millimetre deep */
    size_t size = vxs_contact_memory(&shell, 1);
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64); /* the library itself never allocates */
    vxs_contact *contact;
    if (vxs_contact_config_check(&config) != VXS_OK ||
        vxs_contact_init(memory, size, &shell, 1, &contact) != VXS_OK)
        return 1;

    const vxs_contact_static statics = {&map, NULL};
    printf("x_mm,force_x_n,force_y_n,force_z_n,depth_mm,points,flags\n");
    for (int n = 0; n <= 30; n++) {
        vxs_pose pose = {{0.056 - 1e-4 * n, 0.04, 0}, {1, 0, 0, 0}};
        vxs_contact_result r;
        vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &r);
        printf("%.1f,%.4f,%.4f,%.4f,%.4f,%u,%#x\n", 1e3 * pose.position[0], r.wrench.force[0],
               r.wrench.force[1], r.wrench.force[2], 1e3 * r.depth, (unsigned)r.points, (unsigned)r.flags);
    }
    free(memory);
    vxs_asset_close(&map_file);
    vxs_asset_close(&shell_file);
    return 0;
}
