/* SPDX-License-Identifier: MIT
 *
 * A servo is recorded while it runs on its thread, and another one runs on the recording: the same wrenches
 * to the last bit. Scripted motion as text, and all that is no such text.
 */
#include "servo_bench.h" /* of tests/runtime */
#include "voxshell/recorder.h"
#include "voxshell/replay.h"
#include "voxshell/servo_thread.h"

enum { TICKS = 1500, ROWS = 2048 };
static const char path[] = "test_replay.recording";

static void move_hand(void *user, uint64_t tick)
{
    servo_bench *b = user;
    const double target[3] = {0, tick < 300 ? 0.012 : 0.0088, 0};
    vxs_simulated_hand(b->device, target, NULL);
}

static void *memory_of(size_t size)
{
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    CHECK(memory);
    return memory;
}

static size_t record(servo_bench *b)
{
    void *ring = memory_of(vxs_trace_memory(ROWS)), *recorder_memory = memory_of(vxs_recorder_memory());
    void *thread_memory = memory_of(vxs_servo_thread_memory());
    vxs_servo_thread_config config;
    vxs_servo_thread *thread;
    vxs_recorder *recorder;
    vxs_live live;
    vxs_servo_trace shown;
    vxs_servo_thread_config_default(&config);
    CHECK_INT(vxs_trace_init(ring, vxs_trace_memory(ROWS), ROWS, &config.trace), VXS_OK);
    CHECK_INT(vxs_live_create(&live, "test_replay.live"), VXS_OK);
    CHECK_INT(
        vxs_recorder_start(recorder_memory, vxs_recorder_memory(), "no/such/folder", config.trace, &recorder),
        VXS_IO);
    CHECK_INT(vxs_recorder_start(recorder_memory, vxs_recorder_memory() - 64, path, config.trace, &recorder),
              VXS_BUFFER);
    CHECK_INT(vxs_recorder_start(recorder_memory, vxs_recorder_memory(), path, config.trace, &recorder),
              VXS_OK);
    config.device = b->device;
    config.servo = b->servo;
    config.live = &live;
    config.on_tick = move_hand;
    config.user = b;
    config.max_ticks = TICKS;
    config.rate_hz = 5000;
    CHECK_INT(vxs_servo_thread_start(thread_memory, vxs_servo_thread_memory(), &config, &thread), VXS_OK);
    vxs_servo_thread_status status;
    do vxs_servo_thread_get(thread, &status);
    while (status.running);
    vxs_servo_thread_stop(thread);
    uint64_t rows;
    CHECK_INT(vxs_recorder_stop(recorder, &rows), VXS_OK);
    CHECK_INT(rows + vxs_trace_dropped(config.trace), TICKS);
    CHECK_INT(rows, TICKS); /* the ring is longer than the run */
    CHECK(vxs_live_get(&live, &shown) == 2 * TICKS && shown.tick == TICKS - 1);
    vxs_live_close(&live);
    free(ring);
    free(recorder_memory);
    free(thread_memory);
    return (size_t)rows;
}

static size_t read_file(uint8_t *bytes, size_t most)
{
    FILE *file = fopen(path, "rb");
    CHECK(file);
    size_t size = fread(bytes, 1, most, file);
    fclose(file);
    return size;
}

static void check_recording(void)
{
    static uint8_t bytes[1 << 20];
    static vxs_replay_row rows[ROWS];
    static vxs_servo_trace recorded[ROWS];
    servo_bench b;
    bench_prepare(&b);
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    size_t count, line, written = record(&b), size = read_file(bytes, sizeof bytes);
    CHECK_INT(size, 16 + written * sizeof *recorded);
    memcpy(recorded, bytes + 16, written * sizeof *recorded);
    CHECK_INT(vxs_replay_parse(bytes, size, NULL, 0, &count, &line), VXS_OK);
    CHECK_INT(count, written);
    CHECK_INT(vxs_replay_parse(bytes, size, rows, ROWS, &count, &line), VXS_OK);
    CHECK_INT(vxs_replay_parse(bytes, size - 1, rows, ROWS, &count, &line), VXS_TRUNCATED);
    CHECK_INT(vxs_replay_parse(bytes, 12, rows, ROWS, &count, &line), VXS_TRUNCATED);
    bytes[8]++;
    CHECK_INT(vxs_replay_parse(bytes, size, rows, ROWS, &count, &line), VXS_VERSION);

    vxs_replay_config config;
    vxs_replay_config_default(&config);
    config.rows = rows;
    config.row_count = written;
    config.sample_time = 0.001;
    uint8_t memory[512] __attribute__((aligned(64)));
    vxs_device *device;
    CHECK_INT(vxs_replay_open(memory, sizeof memory, &config, &device), VXS_OK);
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    CHECK_INT(vxs_servo_init(b.servo_memory, vxs_servo_memory(&b.servo_config), &b.servo_config, &b.servo),
              VXS_OK);
    double most = 0;
    for (size_t n = 0; n < written; n++) {
        vxs_servo_trace row;
        vxs_device_exchange(device, &b.command, &b.state, NULL);
        vxs_servo_tick(b.servo, &b.state, &b.command, &row);
        CHECK(memcmp(row.collision.force, recorded[n].collision.force, sizeof row.collision.force) == 0);
        CHECK(memcmp(row.command.force, recorded[n].command.force, sizeof row.command.force) == 0);
        most = fmax(most, row.command.force[1]);
    }
    CHECK(most > 0.05); /* it touched */
    vxs_device_close(device);
    bench_close(&b);
    remove(path);
}

static const char script[] = "t_s,x_m,y_m,z_m,qw,qz,note,buttons\r\n0,0,0,0,1,0,begin,0\n0.01,0.01,0,0,0.8,0."
                             "6,,3\n\n0.02,0.01,-0.02,0,1,0,,0";

static vxs_result parse(const char *text, size_t size, size_t *line)
{
    vxs_replay_row rows[8];
    size_t count;
    char *exact = malloc(size + 1); /* a sanitizer sees a byte too far */
    memcpy(exact, text, size);
    exact = realloc(exact, size ? size : 1);
    vxs_result result = vxs_replay_parse(exact, size, rows, 8, &count, line);
    free(exact);
    return result;
}

static void check_script(void)
{
    vxs_replay_row rows[3];
    size_t count, line;
    CHECK_INT(vxs_replay_parse(script, strlen(script), rows, 3, &count, &line), VXS_OK);
    CHECK_INT(count, 3);
    uint8_t memory[512] __attribute__((aligned(64)));
    vxs_replay_config config;
    vxs_device *device;
    vxs_device_state state;
    vxs_device_report report;
    vxs_replay_config_default(&config);
    CHECK_INT(vxs_replay_open(memory, sizeof memory, &config, &device), VXS_PARAM); /* no rows */
    config.rows = rows;
    config.row_count = count;
    CHECK_INT(vxs_replay_open(memory, 16, &config, &device), VXS_BUFFER);
    config.struct_size--;
    CHECK_INT(vxs_replay_open(memory, sizeof memory, &config, &device), VXS_CONFIG);
    config.struct_size++;
    CHECK_INT(vxs_replay_open(memory, sizeof memory, &config, &device), VXS_OK);
    for (int n = 0; n < 40; n++) {
        vxs_device_exchange(device, NULL, &state, &report);
        double t = n * 0.001;
        CHECK_NEAR(state.pose.position[0], t < 0.01 ? t : 0.01, 1e-12);
        CHECK_NEAR(state.pose.position[1], t < 0.01 ? 0 : t < 0.02 ? -2 * (t - 0.01) : -0.02, 1e-12);
        CHECK_INT(state.buttons, n >= 10 && n < 20 ? 3 : 0);
        CHECK_INT(state.time_ns, (n + 1) * 1000000);
        CHECK_INT(state.state, VXS_DEVICE_READY);
    }
    CHECK_INT(vxs_device_arm(device), VXS_OK);
    vxs_device_command bad = {.wrench = {{NAN, 0, 0}, {0, 0, 0}}};
    vxs_device_exchange(device, &bad, &state, &report);
    CHECK(state.state == VXS_DEVICE_FAULT && state.fault == VXS_DEVICE_FAULT_SOFTWARE);
    CHECK(vxs_device_arm(device) == VXS_STATE && vxs_device_disarm(device) == VXS_OK &&
          vxs_device_arm(device) == VXS_OK);
    vxs_device_close(device);
    rows[2].time = rows[1].time; /* times that do not grow */
    CHECK_INT(vxs_replay_open(memory, sizeof memory, &config, &device), VXS_PARAM);

    static const struct {
        const char *text;
        size_t line;
    } bad_texts[] = {{"", 0},
                     {"x_m,y_m,z_m\n", 1},
                     {"t_s,x_m,y_m\n", 1},
                     {"t_s,t_s,x_m,y_m,z_m\n", 1},
                     {"t_s,x_m,y_m,z_m\n0,1,2\n", 2},
                     {"t_s,x_m,y_m,z_m\n0,1,2,3,4\n", 2},
                     {"t_s,x_m,y_m,z_m\n0,1,2,nan\n", 2},
                     {"t_s,x_m,y_m,z_m\n0,1,2,1e999\n", 2},
                     {"t_s,x_m,y_m,z_m\n0,1,2,3 m\n", 2},
                     {"t_s,x_m,y_m,z_m\n0,1,2,3\n1,,2,3\n", 3},
                     {"t_s,x_m,y_m,z_m,buttons\n0,1,2,3,-1\n", 2}};
    for (size_t n = 0; n < sizeof bad_texts / sizeof *bad_texts; n++) {
        CHECK_INT(parse(bad_texts[n].text, strlen(bad_texts[n].text), &line), VXS_CORRUPT);
        CHECK_INT(line, bad_texts[n].line);
    }
    for (size_t cut = 0; cut < sizeof script; cut++) parse(script, cut, &line);
}

int main(void)
{
    check_script();
    check_recording();
    return 0;
}
