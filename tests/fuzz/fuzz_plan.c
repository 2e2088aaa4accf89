/* SPDX-License-Identifier: MIT
 *
 * Any bytes as a .plan: refused by a rule, or loaded with good assets (whose hashes are made what it wants),
 * and the servo that it describes ticks within its limits.
 */
#define _POSIX_C_SOURCE 200809L /* posix_memalign */
#include "asset_mutator.h"
#include "asset_use.h"
#include "fuzz_target.h"

#include <math.h>
#include <string.h>

enum { STATICS = 4 };

static void *block(size_t size)
{
    void *memory = NULL;
    FUZZ_CHECK(posix_memalign(&memory, 64, size ? size : 1) == 0);
    return memory;
}

/* A good asset for each entry, with the hash that the plan says. */
static const vxs_asset *assets_for(const vxs_plan *plan)
{
    static vxs_asset copies[STATICS + 1], given[STATICS + 1];
    if (!copies[0].data) {
        for (int n = 0; n <= STATICS; n++) {
            vxs_asset map, shell, *from = n < STATICS ? &map : &shell;
            use_partners(&map, &shell);
            copies[n] = *from;
            copies[n].data = block((size_t)from->size);
            memcpy((void *)(uintptr_t)copies[n].data, from->data, (size_t)from->size);
        }
    }
    for (uint32_t n = 0; n < plan->asset_count; n++) {
        given[n] = copies[n + 1 < plan->asset_count ? n : STATICS];
        uint8_t *header = (uint8_t *)(uintptr_t)given[n].data;
        memcpy(header + offsetof(vxs_container_header, content_hash), plan->assets[n].content_hash, 32);
    }
    return given;
}

static void check_command(const vxs_device_command *command, const vxs_servo_config *config, uint32_t flags)
{
    double force = 0, torque = 0;
    for (int axis = 0; axis < 3; axis++) {
        FUZZ_CHECK(isfinite(command->wrench.force[axis]) && isfinite(command->wrench.torque[axis]));
        force += command->wrench.force[axis] * command->wrench.force[axis];
        torque += command->wrench.torque[axis] * command->wrench.torque[axis];
    }
    /* Squares of the largest doubles leave their range. */
    FUZZ_CHECK(!(force < INFINITY) || sqrt(force) <= config->max_force * 1.000001);
    FUZZ_CHECK(!(torque < INFINITY) || sqrt(torque) <= config->max_torque * 1.000001);
    FUZZ_CHECK(!(flags & VXS_SERVO_FAULT) || force + torque == 0);
}

static void tick(const vxs_servo_config *config, uint64_t variant)
{
    size_t size = vxs_servo_memory(config);
    if (size > 1 << 22) return;
    void *memory = block(size);
    vxs_servo *servo;
    FUZZ_CHECK(vxs_servo_init(memory, size, config, &servo) == VXS_OK);
    vxs_device_state state = {.state = VXS_DEVICE_ARMED};
    vxs_device_command command;
    vxs_servo_trace row;
    state.pose = vxs_pose_identity();
    int count = variant >> 20 & 63 ? 3 : 60;
    for (int n = 0; n < count; n++) {
        double way = (double)(variant >> 8 & 255) * 0.0002 + 0.001 * n;
        for (int axis = 0; axis < 3; axis++)
            state.pose.position[axis] = variant >> axis & 1 ? 0.032 - 0.0115 + way : 0.032 + 0.0001 * n;
        state.sequence++;
        state.time_ns += 1000000;
        memset(&command, 0xAA, sizeof command);
        uint32_t flags = vxs_servo_tick(servo, &state, &command, &row);
        check_command(&command, config, flags);
    }
    free(memory);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    vxs_asset asset;
    uint64_t variant;
    vxs_plan plan;
    uint8_t *copy = use_open(bytes, size, &asset, &variant);
    if (!copy) return 0;
    if (vxs_plan_open(&asset, &plan) == VXS_OK && plan.asset_count <= STATICS + 1) {
        FUZZ_CHECK(plan.asset_count >= 2);
        void *memory = block(vxs_plan_memory(&plan));
        vxs_servo_config config;
        vxs_plan_issue issue;
        vxs_result result =
            vxs_plan_load(&plan, assets_for(&plan), memory, vxs_plan_memory(&plan), &config, &issue);
        FUZZ_CHECK(result != VXS_PLAN && (result == VXS_OK || issue.text));
        if (result == VXS_OK) tick(&config, variant);
        free(memory);
    }
    use_close(copy, &asset);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t most, unsigned int seed)
{
    return asset_mutate(bytes, size, most, seed);
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    return asset_seed(".plan", number, bytes, most);
}
