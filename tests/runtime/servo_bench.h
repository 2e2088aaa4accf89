/* SPDX-License-Identifier: MIT
 *
 * servo_bench.h - a closed loop for tests: ball shell, floor map, simulated device, servo.
 */
#ifndef VXS_TEST_SERVO_BENCH_H
#define VXS_TEST_SERVO_BENCH_H

#include "asset_builder.h"
#include "check.h"

typedef struct servo_bench {
    built_asset map_bytes, shell_bytes;
    vxs_voxmap map;
    vxs_contact_static statics;
    vxs_pointshell shell;
    vxs_simulated_config device_config;
    vxs_servo_config servo_config;
    vxs_effect effects[32];
    int has_no_torque;
    void *device_memory, *servo_memory;
    vxs_device *device;
    vxs_servo *servo;
    vxs_device_command command;
    vxs_device_state state;
} servo_bench;

/* A ball of 10 mm over a floor at y = 0 (1 mm cells, top layer -1 mm .. 0), centre at y = 12 mm;
 * phantom-premium-1.5 held by a hand; PT2 of 5 Hz. Change the configs, then bench_open(). */
static inline void bench_prepare(servo_bench *b)
{
    memset(b, 0, sizeof *b);
    built_floor floor_shape = {-1, 60, 20};
    b->map_bytes = build_floor_map(0.001, &floor_shape, BUILT_PLAIN);
    b->shell_bytes = build_ball_shell(0.001, 0.01, 1000);
    b->map = open_voxmap(&b->map_bytes);
    b->shell = open_pointshell(&b->shell_bytes);
    vxs_simulated_config_default(&b->device_config, NULL);
    b->device_config.start.position[1] = 0.012;
    vxs_servo_config_default(&b->servo_config);
    b->statics = (vxs_contact_static){&b->map, NULL};
    b->servo_config.statics = &b->statics;
    b->servo_config.static_count = 1;
    b->servo_config.shell = &b->shell;
    b->servo_config.max_force = 8.5;
    b->servo_config.contact.weighting = VXS_CONTACT_AREA;
    b->servo_config.contact.stiffness = 1e8;
}

/* Another map or shell in place of the one that is there; takes the bytes. */
static inline void bench_map(servo_bench *b, built_asset bytes)
{
    built_free(&b->map_bytes);
    b->map_bytes = bytes;
    b->map = open_voxmap(&b->map_bytes);
}

static inline void bench_shell(servo_bench *b, built_asset bytes)
{
    built_free(&b->shell_bytes);
    b->shell_bytes = bytes;
    b->shell = open_pointshell(&b->shell_bytes);
}

/* Adds an effect, to change before bench_open(): the first replaces the default ones. */
static inline vxs_effect *bench_effect(servo_bench *b, uint32_t kind)
{
    if (b->servo_config.effects != b->effects) b->servo_config.effect_count = 0;
    b->servo_config.effects = b->effects;
    vxs_effect *effect = &b->effects[b->servo_config.effect_count++];
    CHECK_INT(vxs_effect_default(kind, effect), VXS_OK);
    return effect;
}

/* With torque, unless the bench lists nothing or said has_no_torque. */
static inline void bench_open(servo_bench *b)
{
    int has_torque = b->has_no_torque || b->servo_config.effects != b->effects;
    for (uint32_t n = 0; n < b->servo_config.effect_count && !has_torque; n++)
        has_torque = b->effects[n].kind == VXS_EFFECT_TORQUE;
    if (!has_torque) bench_effect(b, VXS_EFFECT_TORQUE);
    b->device_memory = aligned_alloc(64, (vxs_simulated_memory() + 63) / 64 * 64);
    size_t size = (vxs_servo_memory(&b->servo_config) + 63) / 64 * 64;
    b->servo_memory = aligned_alloc(64, size);
    CHECK(b->device_memory && b->servo_memory);
    CHECK_INT(vxs_simulated_open(b->device_memory, vxs_simulated_memory(), &b->device_config, &b->device),
              VXS_OK);
    CHECK_INT(vxs_servo_init(b->servo_memory, size, &b->servo_config, &b->servo), VXS_OK);
}

/* From rest: the device is a trajectory, which b->state.pose says; ready to go on with bench_follow(). */
static inline void bench_start(servo_bench *b)
{
    memset(&b->state, 0, sizeof b->state);
    b->state.state = VXS_DEVICE_ARMED;
    b->state.pose = vxs_pose_identity();
}

/* One tick of that trajectory, a millisecond later. */
static inline void bench_follow(servo_bench *b, vxs_servo_trace *row)
{
    b->state.sequence++;
    b->state.time_ns += 1000000;
    CHECK(!(vxs_servo_tick(b->servo, &b->state, &b->command, row) & VXS_SERVO_FAULT));
}

static inline void bench_close(servo_bench *b)
{
    vxs_device_close(b->device);
    free(b->device_memory);
    free(b->servo_memory);
    built_free(&b->map_bytes);
    built_free(&b->shell_bytes);
}

/* One sample with the hand at a height. */
static inline uint32_t bench_tick(servo_bench *b, double height, vxs_servo_trace *row)
{
    const double target[3] = {0, height, 0};
    vxs_simulated_hand(b->device, target, NULL);
    vxs_device_exchange(b->device, &b->command, &b->state, NULL);
    return vxs_servo_tick(b->servo, &b->state, &b->command, row);
}

#endif
