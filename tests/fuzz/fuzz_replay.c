/* SPDX-License-Identifier: MIT
 *
 * Any bytes as a recording or as lines of numbers: rows that a device opens with, and moves finitely; or the
 * line that is wrong.
 */
#include "fuzz_target.h"
#include "voxshell/replay.h"
#include "voxshell/servo.h"

#include <math.h>
#include <string.h>

enum { ROWS = 16 };

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static uint8_t memory[1024] __attribute__((aligned(64)));
    vxs_replay_row rows[ROWS];
    size_t count = 0, line = 0, counted = 0;
    vxs_result result = vxs_replay_parse(bytes, size, NULL, 0, &counted, &line);
    FUZZ_CHECK(vxs_replay_parse(bytes, size, rows, ROWS, &count, &line) == result && count == counted);
    if (result != VXS_OK) return 0;
    vxs_replay_config config;
    vxs_device *device;
    vxs_replay_config_default(&config);
    config.rows = rows;
    config.row_count = count < ROWS ? count : ROWS;
    FUZZ_CHECK(vxs_replay_memory() <= sizeof memory);
    if (vxs_replay_open(memory, sizeof memory, &config, &device) != VXS_OK) return 0;
    for (int n = 0; n < 8; n++) {
        vxs_device_state state;
        vxs_device_exchange(device, NULL, &state, NULL);
        for (int i = 0; i < 3; i++) FUZZ_CHECK(isfinite(state.pose.position[i]));
    }
    vxs_device_close(device);
    return 0;
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    static const char *const texts[] = {
        "t_s,x_m,y_m,z_m\n0,0,0,0\n0.01,1e-3,0,-0.5\n",
        "t_s,device_x_m,device_y_m,device_z_m,points\r\n0,0,0,0,7\r\n1,1,1,1,8\r\n",
        "qw,qx,qy,qz,buttons,t_s,x_m,y_m,z_m\n1,0,0,0,3,0,.1,.2,.3\n"};
    const char *text = texts[number % 3];
    size_t size = strlen(text);
    if (number % 4 == 0) {
        vxs_servo_trace row = {.pose = {{0.01 * number, 0, 0}, {1, 0, 0, 0}}};
        const uint32_t about[2] = {sizeof row, 0};
        size = 16 + 2 * sizeof row;
        if (size > most) return 0;
        memcpy(bytes, "VXSREC01", 8);
        memcpy(bytes + 8, about, sizeof about);
        for (int n = 0; n < 2; n++) {
            row.time_ns = (int64_t)n * 1000000;
            memcpy(bytes + 16 + (size_t)n * sizeof row, &row, sizeof row);
        }
        return size;
    }
    if (size > most) return 0;
    memcpy(bytes, text, size);
    return size;
}
