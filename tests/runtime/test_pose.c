/* SPDX-License-Identifier: MIT
 *
 * Rotations against hand-made matrices; what is no pose.
 */
#include "check.h"
#include "voxshell/pose.h"

/* A turn by an angle about an axis, from any orientation, either sign of the quaternion. */
static void check_turn(void)
{
    const double axis[3] = {0.48, -0.6, 0.64};
    const vxs_pose from = {{0, 0, 0}, {0.5, 0.1, -0.7, 0.5}};
    for (int n = 0; n < 8; n++) {
        double angle = n < 4 ? 0.05 * n / 3 : 3, turn[3], half = angle / 2;
        vxs_pose by = {{0, 0, 0}, {cos(half), sin(half) * axis[0], sin(half) * axis[1], sin(half) * axis[2]}};
        vxs_pose to;
        CHECK(vxs_pose_compose(&by, &from, &to));
        for (int i = 0; n % 2 && i < 4; i++) to.orientation[i] *= -1;
        vxs_pose_turn(from.orientation, to.orientation, turn);
        for (int i = 0; i < 3; i++) {
            CHECK_NEAR(turn[i], 2 * sin(half) * axis[i], 1e-12);
            if (n < 4) CHECK_NEAR(turn[i], angle * axis[i], 1.1e-4 * angle + 1e-12);
        }
    }
}

int main(void)
{
    check_turn();
    double r[9] = {0};
    vxs_pose pose = {{1, 2, 3}, {3, 0, 0, 3}}; /* a quarter turn about z, not of length 1 */
    CHECK(vxs_pose_rotation(&pose, r));
    const double quarter[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    for (int n = 0; n < 9; n++) CHECK_NEAR(r[n], quarter[n], 1e-15);
    vxs_pose negated = {{1, 2, 3}, {-3, 0, 0, -3}};
    CHECK(vxs_pose_rotation(&negated, r));
    for (int n = 0; n < 9; n++) CHECK_NEAR(r[n], quarter[n], 1e-15);

    vxs_pose inner = {{10, 0, 0}, {1, 1, 0, 0}}, both;
    CHECK(vxs_pose_compose(&pose, &inner, &both));
    CHECK_NEAR(both.position[0], 1, 1e-14);
    CHECK_NEAR(both.position[1], 12, 1e-14);
    CHECK_NEAR(both.position[2], 3, 0);
    /* z turn o x turn: y -> z -> z, z -> -y -> x, x -> x -> y */
    CHECK(vxs_pose_rotation(&both, r));
    const double product[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0};
    for (int n = 0; n < 9; n++) CHECK_NEAR(r[n], product[n], 1e-15);
    CHECK(vxs_pose_compose(&pose, &pose, &pose)); /* in place */
    CHECK_NEAR(fabs(pose.orientation[3]), 1, 1e-15);

    const vxs_pose bad[] = {
        {{0, 0, 0}, {0, 0, 0, 0}},        {{0, 0, 0}, {1e-7, 0, 0, 0}},     {{0, NAN, 0}, {1, 0, 0, 0}},
        {{0, 0, 0}, {1, 0, INFINITY, 0}}, {{INFINITY, 0, 0}, {1, 0, 0, 0}}, {{0, 0, 0}, {NAN, 0, 0, 0}},
        {{0, 0, 0}, {1e200, 0, 0, 0}},
    };
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
        r[4] = 42;
        CHECK(!vxs_pose_rotation(&bad[n], r));
        CHECK_NEAR(r[4], 42, 0);
        CHECK(!vxs_pose_compose(&bad[n], &inner, &both));
        CHECK(!vxs_pose_compose(&inner, &bad[n], &both));
    }
    return 0;
}
