/* SPDX-License-Identifier: MIT
 *
 * Two thousand ticks, pressed onto a floor and let go, with the effects that are named: for effect_cost.sh to
 * count the instructions of.
 */
#include "servo_bench.h"

int main(int count, char **names)
{
    servo_bench b;
    bench_prepare(&b);
    b.servo_config.effects = b.effects;
    b.servo_config.effect_count = 0;
    for (int n = 1; n < count; n++) {
        uint32_t kind = vxs_effect_kind_named(names[n]);
        if (!kind) {
            fprintf(stderr, "no effect %s in this build\n", names[n]);
            return 2;
        }
        vxs_effect *effect = bench_effect(&b, kind);
        if (kind == VXS_EFFECT_PASSIVITY) effect->as.passivity.radius = 0.03;
    }
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    vxs_servo_trace row;
    for (int k = 0; k < 2000; k++) bench_tick(&b, k < 100 ? 0.012 : k < 1800 ? 0.009 : 0.013, &row);
    bench_close(&b);
    return 0;
}
