/* SPDX-License-Identifier: MIT
 *
 * A file is shortened while it is mapped: a copy feels nothing, a guarded map ends in zero force and FAULT
 * until it is closed, an unguarded one ends the process, and so does what is not the guard's.
 */
#define _DEFAULT_SOURCE 1 /* ftruncate, mkstemp, fork */

#include "asset_builder.h"
#include "check.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

static built_asset map_bytes, shell_bytes;
static vxs_pointshell shell;

typedef struct felt {
    char path[32];
    vxs_asset asset;
    vxs_voxmap map;
    vxs_contact_static statics;
    void *memory;
    vxs_servo *servo;
    vxs_device_state state;
    vxs_device_command command;
} felt;

static void shorten(const felt *f, off_t size)
{
    CHECK(truncate(f->path, size) == 0);
}

static void open_felt(felt *f, uint32_t mode)
{
    memset(f, 0, sizeof *f);
    strcpy(f->path, "test_asset_guard_XXXXXX");
    int file = mkstemp(f->path);
    CHECK(file >= 0 && write(file, map_bytes.data, map_bytes.size) == (ssize_t)map_bytes.size &&
          close(file) == 0);
    vxs_asset_config config;
    vxs_asset_config_default(&config);
    config.mode = mode;
    CHECK_INT(vxs_asset_open(f->path, &config, &f->asset, NULL), VXS_OK);
    CHECK_INT(vxs_voxmap_open(&f->asset, &f->map), VXS_OK);
    f->statics = (vxs_contact_static){&f->map, NULL};
    vxs_servo_config servo;
    vxs_servo_config_default(&servo);
    servo.statics = &f->statics;
    servo.static_count = 1;
    servo.shell = &shell;
    servo.effect_count = 0;
    servo.coupling.kind = VXS_COUPLING_NONE;
    size_t size = (vxs_servo_memory(&servo) + 63) / 64 * 64;
    f->memory = aligned_alloc(64, size);
    CHECK_INT(vxs_servo_init(f->memory, size, &servo, &f->servo), VXS_OK);
    f->state.state = VXS_DEVICE_ARMED;
    f->state.pose = vxs_pose_identity();
    f->state.pose.position[1] = 0.0092;
}

static void close_felt(felt *f)
{
    vxs_asset_close(&f->asset);
    free(f->memory);
    CHECK(unlink(f->path) == 0);
}

/* |force|; every other tick elsewhere, so that nothing is remembered. */
static double tick(felt *f)
{
    f->state.sequence++;
    f->state.time_ns += 1000000;
    f->state.pose.position[0] = f->state.sequence % 2 ? 0.0001 : 0;
    CHECK(!(vxs_servo_tick(f->servo, &f->state, &f->command, NULL) & VXS_SERVO_FAULT));
    return fabs(f->command.wrench.force[1]);
}

static void check_copy(void)
{
    felt f;
    open_felt(&f, VXS_ASSET_COPY);
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK);
    double before[2] = {tick(&f), tick(&f)};
    CHECK(before[0] > 0);
    shorten(&f, 0);
    for (int n = 0; n < 4; n++) CHECK(tick(&f) == before[n % 2]);
    CHECK_INT(vxs_asset_lost(), 0);
    close_felt(&f);
}

static void check_guarded(off_t left)
{
    felt f;
    open_felt(&f, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK);
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK); /* once is enough */
    CHECK(tick(&f) > 0);
    CHECK_INT(vxs_asset_lost(), 0);
    shorten(&f, left);
    for (int n = 0; n < 4; n++) CHECK(tick(&f) <= 3);
    for (size_t at = (size_t)(left + 4095) / 4096 * 4096; at < f.asset.size; at++)
        CHECK_INT(f.asset.data[at], 0);
    CHECK_INT(vxs_asset_lost(), 1);
    close_felt(&f);
    CHECK_INT(vxs_asset_lost(), 0);
}

static void lose_it(void *user, uint64_t number)
{
    felt *f = user;
    if (number == 20) shorten(f, 0);
}

/* On the wall clock: the device gets zero from that tick on. */
static void check_thread(void)
{
    felt f;
    open_felt(&f, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK);
    vxs_simulated_config simulated;
    vxs_simulated_config_default(&simulated, NULL);
    simulated.start.position[1] = 0.0092;
    void *device_memory = aligned_alloc(64, (vxs_simulated_memory() + 63) / 64 * 64);
    vxs_servo_thread_config config;
    vxs_servo_thread_config_default(&config);
    CHECK_INT(vxs_simulated_open(device_memory, vxs_simulated_memory(), &simulated, &config.device), VXS_OK);
    CHECK_INT(vxs_device_arm(config.device), VXS_OK);
    size_t size = (vxs_servo_thread_memory() + 63) / 64 * 64, ring_size = vxs_trace_memory(256);
    void *memory = aligned_alloc(64, size), *ring = aligned_alloc(64, (ring_size + 63) / 64 * 64);
    config.servo = f.servo;
    config.on_tick = lose_it;
    config.user = &f;
    config.max_ticks = 60;
    config.lock_memory = 0;
    config.priority = 0;
    vxs_servo_thread *thread;
    vxs_servo_thread_status status;
    CHECK_INT(vxs_trace_init(ring, ring_size, 256, &config.trace), VXS_OK);
    CHECK_INT(vxs_servo_thread_start(memory, size, &config, &thread), VXS_OK);
    do vxs_servo_thread_get(thread, &status);
    while (status.running);
    vxs_servo_thread_stop(thread);
    vxs_servo_trace rows[60];
    CHECK_INT(vxs_trace_drain(config.trace, rows, 60), 60);
    double most = 0;
    for (int n = 0; n < 60; n++) {
        double force =
            fabs(rows[n].command.force[0]) + fabs(rows[n].command.force[1]) + fabs(rows[n].command.force[2]);
        CHECK_INT((rows[n].flags & VXS_SERVO_FAULT) != 0, n >= 20);
        CHECK(n < 20 || force == 0);
        if (force > most) most = force;
    }
    CHECK(most > 0);
    CHECK(status.last_flags & VXS_SERVO_FAULT);
    vxs_device_close(config.device);
    free(device_memory);
    free(memory);
    free(ring);
    close_felt(&f);
}

static void default_bus(void)
{
    CHECK(signal(SIGBUS, SIG_DFL) != SIG_ERR); /* a sanitizer has its own */
}

/* The signal that ends a child. */
static int ending(void (*child)(void))
{
    int status;
    pid_t pid = fork();
    CHECK(pid >= 0);
    if (pid == 0) {
        child();
        _exit(0);
    }
    CHECK(waitpid(pid, &status, 0) == pid);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

static void touch_unguarded(void)
{
    felt f;
    default_bus();
    open_felt(&f, VXS_ASSET_MAP);
    shorten(&f, 0);
    unlink(f.path);
    tick(&f);
}

/* Another file's loss is not the guard's, nor is a signal that somebody sends. */
static void touch_other(void)
{
    felt f;
    default_bus();
    open_felt(&f, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK);
    int file = open(f.path, O_RDWR);
    volatile char *other = mmap(NULL, 4096, PROT_READ, MAP_SHARED, file, 0);
    unlink(f.path);
    CHECK(ftruncate(file, 0) == 0);
    (void)other[0];
}

static void sent(void)
{
    felt f;
    default_bus();
    open_felt(&f, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK);
    unlink(f.path);
    raise(SIGBUS);
    raise(SIGBUS);
}

static int given;
static void take(int number)
{
    given = number;
}

static void hand_on(void)
{
    felt f;
    CHECK(signal(SIGBUS, take) != SIG_ERR);
    open_felt(&f, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK);
    unlink(f.path);
    raise(SIGBUS);
    if (given == SIGBUS) raise(SIGUSR1);
}

int main(void)
{
    const built_floor floor_shape = {-1, 60, 20};
    map_bytes = build_floor_map(0.001, &floor_shape, BUILT_DISTANCES);
    shell_bytes = build_ball_shell(0.001, 0.01, 1000);
    shell = open_pointshell(&shell_bytes);
    CHECK(map_bytes.size > 65536);
    /* Children first: their handlers are their own. */
    CHECK_INT(ending(touch_unguarded), SIGBUS);
    CHECK_INT(ending(touch_other), SIGBUS);
    CHECK_INT(ending(sent), SIGBUS);
    CHECK_INT(ending(hand_on), SIGUSR1);
    check_copy();
    check_guarded(0);
    check_guarded(1);
    check_guarded(4096);
    check_guarded(8192 + 5);
    check_thread();
    CHECK_INT(vxs_asset_guard(NULL), VXS_PARAM);
    built_free(&map_bytes);
    built_free(&shell_bytes);
    return 0;
}
