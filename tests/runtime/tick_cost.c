/* SPDX-License-Identifier: MIT
 *
 * Two hundred ticks on a way that is given, pressed onto a floor, slid and let go, with the effects that are
 * named: for effect_cost.sh to count the instructions of. Nothing that an effect does changes the way.
 * "list": the names that there are.
 */
#include "servo_bench.h"

int main(int count, char **names)
{
    if (count == 2 && strcmp(names[1], "list") == 0) {
        for (uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; n++) puts(vxs_effect_kind_name(kind));
        return 0;
    }
    const built_floor floor_shape = {-1, 60, 20};
    const vxs_effect_keyframe frames[2] = {{.pose = vxs_pose_identity()},
                                           {.time = 10, .pose = vxs_pose_identity()}};
    servo_bench b;
    bench_prepare(&b);
    bench_map(&b, build_floor_map(0.001, &floor_shape, BUILT_DISTANCES));
    b.servo_config.effects = b.effects;
    b.servo_config.effect_count = 0;
    for (int n = 1; n < count; n++) {
        uint32_t kind = vxs_effect_kind_named(names[n]);
        if (!kind) {
            fprintf(stderr, "no effect %s in this build\n", names[n]);
            return 2;
        }
        vxs_effect *effect = bench_effect(&b, kind);
        if (kind == VXS_EFFECT_MOTION) {
            effect->keyframes = frames;
            effect->keyframe_count = 2;
        }
        if (kind == VXS_EFFECT_WORKSPACE) effect->as.workspace.high[1] = 0.009; /* beyond it half the time */
        if (kind == VXS_EFFECT_PROXIMITY) effect->as.proximity.reach = 0.002;
        if (kind == VXS_EFFECT_PASSIVITY) effect->as.passivity.radius = 0.03;
    }
    b.has_no_torque = 1; /* but where it is named */
    bench_open(&b);
    bench_start(&b);
    vxs_servo_trace row;
    for (int k = 0; k < 200; k++) {
        double target = k < 10 ? 0.012 : k < 180 ? 0.009 : 0.013;
        b.state.pose.position[1] =
            k ? b.state.pose.position[1] + 0.05 * (target - b.state.pose.position[1]) : target;
        b.state.pose.position[0] = 1e-6 * k;
        bench_follow(&b, &row);
    }
    bench_close(&b);
    return 0;
}
