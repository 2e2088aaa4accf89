/* SPDX-License-Identifier: MIT
 *
 * Every kernel gives the scalar probe's result to the last bit, over random poses of shells of
 * every remainder, on maps of one chunk and of many.
 */
#include "asset_builder.h"
#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_POINTS = 203 };

static uint64_t state = 88172645463325252u;
static double uniform(void) /* xorshift: the same poses on every machine */
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53 * 2 - 1;
}

static built_point points[MOST_POINTS];

static void make_points(double radius)
{
    for (int n = 0; n < MOST_POINTS; n++) {
        double v[3], length;
        do {
            for (int i = 0; i < 3; i++) v[i] = uniform();
            length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        } while (length < 0.1);
        for (int i = 0; i < 3; i++) {
            points[n].position[i] = (float)(radius * v[i] / length);
            points[n].normal[i] = (float)(-v[i] / length);
        }
        points[n].area = (float)(1e-6 * (1.5 + uniform()));
    }
}

static vxs_contact_result evaluate(const vxs_voxmap *map, const vxs_pointshell *shell, const vxs_pose *pose,
                                   const vxs_contact_config *config, uint32_t kernel, uint32_t capacity)
{
    static uint8_t memory[1 << 16] __attribute__((aligned(64)));
    vxs_contact_scratch *scratch;
    vxs_contact_result result;
    CHECK_INT(vxs_contact_init(memory, sizeof memory, capacity, &scratch), VXS_OK);
    CHECK_INT(vxs_contact_use(scratch, kernel), VXS_OK);
    vxs_contact_evaluate(map, NULL, shell, pose, config, scratch, &result);
    return result;
}

static uint64_t compare(const vxs_voxmap *map, const vxs_pointshell *shell, const built_ball *ball, int poses,
                        uint32_t kernel)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    uint64_t touching = 0;
    for (int n = 0; n < poses; n++) {
        vxs_pose pose = vxs_pose_identity();
        for (int i = 0; i < 3; i++) pose.position[i] = ball->center[i] + 1.7 * ball->radius * uniform();
        for (int i = 0; i < 4; i++) pose.orientation[i] = uniform();
        config.law = n & 1 ? VXS_CONTACT_AVERAGE : VXS_CONTACT_ORIGINAL;
        config.weighting = n & 2 ? VXS_CONTACT_AREA : VXS_CONTACT_COUNT;
        uint32_t capacity = n % 17 == 0 ? 5 : shell->point_count; /* now and then too small */
        vxs_contact_result expected = evaluate(map, shell, &pose, &config, VXS_CONTACT_SCALAR, capacity);
        vxs_contact_result got = evaluate(map, shell, &pose, &config, kernel, capacity);
        CHECK(memcmp(&expected, &got, sizeof got) == 0);
        touching += expected.points > 0;
    }
    return touching;
}

int main(void)
{
    const double h = 0.001;
    vxs_contact_scratch *scratch;
    static uint8_t memory[4096] __attribute__((aligned(64)));
    CHECK_INT(vxs_contact_init(memory, sizeof memory, 16, &scratch), VXS_OK);
    CHECK_INT(vxs_contact_use(NULL, VXS_CONTACT_SCALAR), VXS_PARAM);
    CHECK_INT(vxs_contact_use(scratch, 99), VXS_PARAM);
    CHECK_INT(vxs_contact_use(scratch, VXS_CONTACT_FASTEST), VXS_OK);
    if (vxs_contact_use(scratch, VXS_CONTACT_AVX2) != VXS_OK) {
        printf("skipped: this processor has no AVX2\n");
        return 77;
    }
    const built_ball small = {h, {0.02, 0.03, 0.025}, 0.015}, large = {h, {0.01, 0.05, -0.03}, 0.08};
    const built_ball *balls[] = {&small, &large};
    for (int b = 0; b < 2; b++) {
        built_asset map_bytes = build_ball_map(balls[b], BUILT_PLAIN);
        vxs_voxmap map = open_voxmap(&map_bytes);
        make_points(0.6 * balls[b]->radius);
        uint64_t touching = 0;
        for (uint32_t count = MOST_POINTS - 8; count <= MOST_POINTS; count++) {
            built_asset shell_bytes = build_pointshell(h, points, count);
            vxs_pointshell shell = open_pointshell(&shell_bytes);
            touching += compare(&map, &shell, balls[b], 6000, VXS_CONTACT_AVX2);
            built_free(&shell_bytes);
        }
        CHECK(touching > 10000); /* of 54 000: the comparison is not about nothing */
        built_free(&map_bytes);
    }
    return 0;
}
