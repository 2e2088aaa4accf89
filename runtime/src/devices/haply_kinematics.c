/* SPDX-License-Identifier: MIT */
#include "haply_kinematics.h"

#include <math.h>

/* The tip is where two circles meet: half-way between the elbows and off to the left of the line from the
 * first to the second. No division by a coordinate's difference, which vanishes when one elbow is above the
 * other. */
int vxsi_pantograph_forward(const vxsi_pantograph *shape, const double angle[2], double place[2],
                            double jacobian[4])
{
    double l = shape->near_link, reach = shape->far_link;
    double elbow[2][2] = {{l * cos(angle[0]), l * sin(angle[0])},
                          {shape->base + l * cos(angle[1]), l * sin(angle[1])}};
    double way[2] = {elbow[1][0] - elbow[0][0], elbow[1][1] - elbow[0][1]};
    double square = way[0] * way[0] + way[1] * way[1], rest = reach * reach - square / 4;
    if (!(square > 1e-12) || !(rest > 1e-12)) return 0;
    double off = sqrt(rest / square);
    double tip[2] = {(elbow[0][0] + elbow[1][0]) / 2 - off * way[1],
                     (elbow[0][1] + elbow[1][1]) / 2 + off * way[0]};

    /* The far links keep their length: (tip - elbow n) . (d tip - d elbow n) = 0. */
    double link[2][2];
    for (int n = 0; n < 2; n++)
        for (int i = 0; i < 2; i++) link[n][i] = tip[i] - elbow[n][i];
    double det = link[0][0] * link[1][1] - link[0][1] * link[1][0];
    if (!(fabs(det) > 1e-12)) return 0;
    if (jacobian) {
        double pull[2];
        for (int n = 0; n < 2; n++) pull[n] = l * (link[n][1] * cos(angle[n]) - link[n][0] * sin(angle[n]));
        jacobian[0] = pull[0] * link[1][1] / det;
        jacobian[1] = -pull[1] * link[0][1] / det;
        jacobian[2] = -pull[0] * link[1][0] / det;
        jacobian[3] = pull[1] * link[0][0] / det;
    }
    place[0] = tip[0];
    place[1] = tip[1];
    return 1;
}

int vxsi_pantograph_inverse(const vxsi_pantograph *shape, const double place[2], double angle[2])
{
    double out[2];
    for (int n = 0; n < 2; n++) {
        double x = place[0] - n * shape->base, y = place[1], far = sqrt(x * x + y * y);
        double cosine =
            (far * far + shape->near_link * shape->near_link - shape->far_link * shape->far_link) /
            (2 * far * shape->near_link);
        if (!(cosine > -1 && cosine < 1)) return 0;
        out[n] = atan2(y, x) + (n == 0 ? acos(cosine) : -acos(cosine));
    }
    angle[0] = out[0];
    angle[1] = out[1];
    return 1;
}
