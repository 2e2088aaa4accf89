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

/* The signal that ends a child, or minus its exit status. */
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
    return WIFSIGNALED(status) ? WTERMSIG(status) : -WEXITSTATUS(status);
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
}

/* --- a program that had a handler of its own --- */

enum { GIVEN = 42, GIVEN_WITH_ADDRESS = 43, STAYED = 44 };
static const volatile void *volatile touched; /* as a handler sees it */

static void take(int number)
{
    _exit(number == SIGBUS ? GIVEN : 1);
}

static void take_with_address(int number, siginfo_t *info, void *context)
{
    _exit(number == SIGBUS && context && (info->si_code <= 0 || info->si_addr == touched) ? GIVEN_WITH_ADDRESS
                                                                                          : 1);
}

static void guard_with(void (*handler)(int), felt *f)
{
    CHECK(signal(SIGBUS, handler) != SIG_ERR);
    open_felt(f, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&f->asset), VXS_OK);
    CHECK(unlink(f->path) == 0);
}

static void hand_on(void)
{
    felt f;
    guard_with(take, &f);
    raise(SIGBUS);
}

static void guard_with_address(felt *f)
{
    struct sigaction action = {.sa_sigaction = take_with_address, .sa_flags = SA_SIGINFO};
    CHECK(sigaction(SIGBUS, &action, NULL) == 0);
    open_felt(f, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&f->asset), VXS_OK);
}

/* Another file's loss, with where. */
static void hand_on_with_address(void)
{
    felt f;
    guard_with_address(&f);
    int file = open(f.path, O_RDWR);
    volatile char *other = mmap(NULL, 4096, PROT_READ, MAP_SHARED, file, 0);
    CHECK(unlink(f.path) == 0 && ftruncate(file, 0) == 0);
    touched = other;
    (void)other[0];
}

/* The guard's own zeros cannot be had: the loss is the program's. */
static volatile int has_no_memory, has_no_signals;
static void hand_on_without_memory(void)
{
    felt f;
    guard_with_address(&f);
    shorten(&f, 0);
    CHECK(unlink(f.path) == 0);
    touched = f.asset.data + 4096;
    has_no_memory = 1;
    (void)((const volatile uint8_t *)f.asset.data)[4096];
}

/* Who ignored it goes on ignoring it, and is guarded as before. */
static void ignore(void)
{
    felt f;
    guard_with(SIG_IGN, &f);
    raise(SIGBUS);
    raise(SIGBUS);
    struct sigaction now;
    CHECK(sigaction(SIGBUS, NULL, &now) == 0 && now.sa_flags & SA_SIGINFO);
    _exit(STAYED);
}

static void refused_by_system(void)
{
    felt f;
    open_felt(&f, VXS_ASSET_MAP);
    CHECK(unlink(f.path) == 0);
    has_no_signals = 1;
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_UNSUPPORTED);
    has_no_signals = 0;
    CHECK_INT(vxs_asset_guard(&f.asset), VXS_OK); /* it was not done in vain */
    _exit(STAYED);
}

void *__real_mmap(void *at, size_t size, int protection, int flags, int file, off_t offset);
int __real_sigaction(int number, const struct sigaction *action, struct sigaction *old);
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int file, off_t offset);
int __wrap_sigaction(int number, const struct sigaction *action, struct sigaction *old);

void *__wrap_mmap(void *at, size_t size, int protection, int flags, int file, off_t offset)
{
    return has_no_memory && flags & MAP_FIXED ? MAP_FAILED
                                              : __real_mmap(at, size, protection, flags, file, offset);
}

int __wrap_sigaction(int number, const struct sigaction *action, struct sigaction *old)
{
    return has_no_signals ? -1 : __real_sigaction(number, action, old);
}

/* Several at once: the one that is lost is found, whichever was opened first and which were closed since. */
static void check_several(void)
{
    enum { MAPS = 3 };
    static felt f[MAPS];
    for (int left_out = 0; left_out < MAPS; left_out++) {
        for (int n = 0; n < MAPS; n++) {
            open_felt(&f[n], VXS_ASSET_MAP);
            CHECK_INT(vxs_asset_guard(&f[n].asset), VXS_OK);
        }
        close_felt(&f[left_out]);
        uint32_t lost = 0;
        for (int n = 0; n < MAPS; n++) {
            if (n == left_out) continue;
            CHECK(tick(&f[n]) > 0);
            shorten(&f[n], 0);
            tick(&f[n]);
            CHECK_INT(vxs_asset_lost(), ++lost);
            CHECK_INT(f[n].asset.data[4096], 0);
        }
        for (int n = 0; n < MAPS; n++)
            if (n != left_out) close_felt(&f[n]);
        CHECK_INT(vxs_asset_lost(), 0);
    }
}

/* 1024 are guarded; one more is not, until another is closed. */
static void check_limit(void)
{
    enum { MOST = 1024 };
    static vxs_asset assets[MOST + 1];
    for (int n = 0; n <= MOST; n++) {
        assets[n].data = mmap(NULL, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        assets[n].mapped_size = 4096;
        CHECK_INT(vxs_asset_guard(&assets[n]), n < MOST ? VXS_OK : VXS_LIMIT);
    }
    vxs_asset_close(&assets[500]);
    CHECK_INT(vxs_asset_guard(&assets[MOST]), VXS_OK);
    for (int n = 0; n <= MOST; n++) vxs_asset_close(&assets[n]);
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
    CHECK_INT(ending(hand_on), -GIVEN);
    CHECK_INT(ending(hand_on_with_address), -GIVEN_WITH_ADDRESS);
    CHECK_INT(ending(hand_on_without_memory), -GIVEN_WITH_ADDRESS);
    CHECK_INT(ending(ignore), -STAYED);
    CHECK_INT(ending(refused_by_system), -STAYED);
    check_copy();
    check_guarded(0);
    check_guarded(1);
    check_guarded(4096);
    check_guarded(8192 + 5);
    check_several();
    check_limit();
    check_thread();
    CHECK_INT(vxs_asset_guard(NULL), VXS_PARAM);
    built_free(&map_bytes);
    built_free(&shell_bytes);
    return 0;
}
