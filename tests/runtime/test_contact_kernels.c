/* SPDX-License-Identifier: MIT
 *
 * Every kernel gives the scalar one's result to the last bit, over random poses of shells of
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

typedef struct pair {
    vxs_contact *reference, *tested;
    uint8_t memory[2][1 << 15] __attribute__((aligned(64)));
} pair;

static uint64_t compare(pair *p, const vxs_voxmap *map, const vxs_pointshell *shell, const built_ball *ball,
                        int poses, uint32_t kernel)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    /* Now and then a second static overlaps the first, and the hits find no room. */
    CHECK_INT(vxs_contact_init(p->memory[0], sizeof p->memory[0], shell, 2, &p->reference), VXS_OK);
    /* Memory need not begin with a cache line. */
    CHECK_INT(vxs_contact_init(p->memory[1] + 16, sizeof p->memory[1] - 16, shell, 2, &p->tested), VXS_OK);
    CHECK_INT(vxs_contact_use(p->reference, VXS_CONTACT_SCALAR), VXS_OK);
    CHECK_INT(vxs_contact_use(p->tested, kernel), VXS_OK);
    const vxs_contact_static statics[2] = {{map, NULL}, {map, NULL}};
    uint64_t touching = 0;
    for (int n = 0; n < poses; n++) {
        vxs_pose pose = vxs_pose_identity();
        for (int i = 0; i < 3; i++) pose.position[i] = ball->center[i] + 1.7 * ball->radius * uniform();
        for (int i = 0; i < 4; i++) pose.orientation[i] = uniform();
        /* Without culling the probe meets what is outside the box, and where no cell has a number. */
        vxs_contact_cull(p->tested, n % 5 == 0 ? VXS_CONTACT_BRUTE : VXS_CONTACT_COHERENT);
        static const double far[] = {0.2, -0.2, 1e3, 1e7, -1e7, 1e300};
        if (n % 40 == 0) pose.position[n / 40 % 3] = far[n / 40 % 6];
        config.law = n & 1 ? VXS_CONTACT_AVERAGE : VXS_CONTACT_ORIGINAL;
        config.weighting = n & 2 ? VXS_CONTACT_AREA : VXS_CONTACT_COUNT;
        uint32_t count = n % 17 == 0 ? 2 : 1;
        vxs_contact_result expected, got;
        vxs_contact_evaluate(p->reference, statics, count, &pose, &config, &expected);
        vxs_contact_evaluate(p->tested, statics, count, &pose, &config, &got);
        CHECK(memcmp(&expected, &got, sizeof got) == 0);
        touching += expected.points > 0;
    }
    return touching;
}

int main(void)
{
    static pair p;
    const double h = 0.001;
    const built_ball small = {h, {0.02, 0.03, 0.025}, 0.015}, large = {h, {0.01, 0.05, -0.03}, 0.08};
    const built_ball *balls[] = {&small, &large};
    make_points(0.01);
    built_asset shell_bytes = build_pointshell(h, points, 16);
    vxs_pointshell shell = open_pointshell(&shell_bytes);
    CHECK_INT(vxs_contact_init(p.memory[0], sizeof p.memory[0], &shell, 1, &p.tested), VXS_OK);
    CHECK_INT(vxs_contact_use(NULL, VXS_CONTACT_SCALAR), VXS_PARAM);
    CHECK_INT(vxs_contact_use(p.tested, 99), VXS_PARAM);
    CHECK_INT(vxs_contact_use(p.tested, VXS_CONTACT_FASTEST), VXS_OK);
    uint32_t kernels[4], kernel_count = 0;
    for (uint32_t k = VXS_CONTACT_AVX2; k <= VXS_CONTACT_AVX512; k++) {
        if (vxs_contact_use(p.tested, k) == VXS_OK) kernels[kernel_count++] = k;
    }
    built_free(&shell_bytes);
    if (!kernel_count) {
        printf("skipped: this processor has no kernel but the scalar one\n");
        return 77;
    }
    for (uint32_t n = 0; n < 2 * kernel_count; n++) {
        const built_ball *ball = balls[n % 2];
        built_asset map_bytes = build_ball_map(ball, BUILT_PLAIN);
        vxs_voxmap map = open_voxmap(&map_bytes);
        make_points(0.6 * ball->radius);
        uint64_t touching = 0;
        for (uint32_t count = MOST_POINTS - 8; count <= MOST_POINTS; count++) {
            shell_bytes = build_pointshell(h, points, count);
            shell = open_pointshell(&shell_bytes);
            touching += compare(&p, &map, &shell, ball, 6000, kernels[n / 2]);
            built_free(&shell_bytes);
        }
        CHECK(touching > 10000); /* of 54 000: the comparison is not about nothing */
        /* A map of so many gigabytes that a gather's 31 bits do not reach them, as far as its counts say: another way to
         * the same bits. */
        shell_bytes = build_pointshell(h, points, MOST_POINTS);
        shell = open_pointshell(&shell_bytes);
        for (int what = 0; what < 3; what++) {
            vxs_voxmap huge = map;
            *(what == 0   ? &huge.chunk_count
              : what == 1 ? &huge.brick_count
                          : &huge.clearance_count) = 1ull << 33;
            CHECK(compare(&p, &huge, &shell, ball, 2000, kernels[n / 2]) > 300);
        }
        built_free(&shell_bytes);
        built_free(&map_bytes);
    }
    return 0;
}
