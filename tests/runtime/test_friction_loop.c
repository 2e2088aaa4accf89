/* SPDX-License-Identifier: MIT
 *
 * Friction in the servo's loop, a block dragged over a floor with every coupling: it holds below the cone,
 * pulls with mu_k of the normal force beyond it, and nothing is left of it after a stop. The device is a
 * trajectory.
 */
#include "servo_bench.h"

static const double stiffness = 2000;

typedef struct drag_bench {
    servo_bench b;
    vxs_servo_trace row;
} drag_bench;

static void open_drag(drag_bench *d, uint32_t coupling, int has_friction)
{
    servo_bench *b = &d->b;
    const double half[3] = {0.01, 0.01, 0.01};
    const int count[3] = {20, 20, 20};
    bench_prepare(b);
    bench_shell(b, build_block_shell(0.001, half, count));
    b->servo_config.contact.stiffness = 1e7;
    b->servo_config.coupling.radius = 0.2; /* hardly tilts */
    b->servo_config.coupling.kind = coupling;
    b->servo_config.coupling.stiffness = 1000;
    b->servo_config.effects = NULL;
    b->servo_config.effect_count = 0;
    if (has_friction) bench_effect(b, VXS_EFFECT_FRICTION)->as.friction.stiffness = stiffness;
    bench_open(b);
    bench_start(b);
}

static void tick_at(drag_bench *d, double x, double y)
{
    d->b.state.pose = (vxs_pose){{x, y, 0}, {1, 0, 0, 0}};
    bench_follow(&d->b, &d->row);
}

static void check_coupling(uint32_t coupling, double tolerance)
{
    drag_bench d;
    open_drag(&d, coupling, 1);
    double at = 0;
    for (int k = 0; k < 600; k++) tick_at(&d, 0, 0.012 - 0.003 * fmin(1, k / 300.0));
    const double normal = d.row.output.force[1];
    CHECK(normal > 0.3 && fabs(d.row.output.force[0]) < 1e-3 * normal);
    /* Half way to the cone it holds; with a body that hangs on a spring, both give. */
    const int has_body = coupling == VXS_COUPLING_SPRING_DAMPER || coupling == VXS_COUPLING_QUASI_STATIC;
    const double series = has_body ? stiffness * 1000 / (stiffness + 1000) : stiffness,
                 way = 0.2 * normal / series;
    for (int k = 1; k <= 400; k++) tick_at(&d, at = way * k / 400, 0.009);
    for (int k = 1; k <= 4000; k++) tick_at(&d, at, 0.009);
    const double held = -d.row.output.force[0];
    CHECK_NEAR(held, 0.2 * normal, 0.02 * normal);
    for (int k = 1; k <= 4000; k++) tick_at(&d, at, 0.009);
    CHECK_NEAR(-d.row.output.force[0], held, 1e-9 * normal);
    /* Beyond it. */
    double worst = 0, most = 0;
    for (int k = 1; k <= 4000; k++) {
        tick_at(&d, at += 2e-6, 0.009);
        if (k > 3000) worst = fmax(worst, fabs(-d.row.output.force[0] / d.row.output.force[1] - 0.3));
        most = fmax(most, -d.row.output.force[0] / d.row.output.force[1]);
    }
    printf("%s: holds %.3f N pressed with %.3f N, slides with %.5f of it or that %+.1g, at most %.3f\n",
           vxs_coupling_kind_name(coupling), held, normal, 0.3, worst, most);
    CHECK(worst < tolerance && most > 0.31 && most < 0.41);
    /* Disarmed, moved and armed again: from rest. */
    d.b.state.state = VXS_DEVICE_READY;
    tick_at(&d, at, 0.009);
    d.b.state.state = VXS_DEVICE_ARMED;
    for (int k = 0; k < 400; k++) tick_at(&d, at, 0.009);
    CHECK_NEAR(d.row.output.force[0], 0, 1e-6 * normal);
    bench_close(&d.b);
}

/* Nothing touches: nothing is added. */
static void check_free(void)
{
    drag_bench with, without;
    open_drag(&with, VXS_COUPLING_NONE, 1);
    open_drag(&without, VXS_COUPLING_NONE, 0);
    for (int k = 0; k < 1000; k++) {
        tick_at(&with, 1e-5 * k, k < 500 ? 0.011 : 0.009);
        tick_at(&without, 1e-5 * k, k < 500 ? 0.011 : 0.009);
        CHECK(with.row.collision.force[1] == without.row.collision.force[1]);
        if (k < 500) CHECK(with.row.command.force[0] == 0 && with.row.command.torque[2] == 0);
        if (k > 900) CHECK(fabs(with.row.command.force[0]) > 1e-3 && without.row.command.force[0] > -1e-4);
    }
    bench_close(&with.b);
    bench_close(&without.b);
}

int main(void)
{
    for (uint32_t kind = (uint32_t)check_length(VXS_COUPLING_NONE, VXS_COUPLING_QUASI_STATIC);
         kind <= VXS_COUPLING_QUASI_STATIC; kind++)
        check_coupling(kind, 0.003);
    check_free();
    return 0;
}
