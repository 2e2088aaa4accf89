/* SPDX-License-Identifier: MIT
 *
 * An hvlink device at the other end of a pseudo-terminal, real threads and real time: what the servo and the
 * I/O thread do to each other (ThreadSanitizer looks on), a second program, a plug that is pulled, a host
 * that is killed: test_tty CASE, or all without one. No assertion on how fast: that is the machine's affair.
 */
#define _GNU_SOURCE 1

#include "check.h"
#include "voxshell/hardware.h"
#include "voxshell/hvlink.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/wait.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

typedef struct knob {
    int master;
    char path[64];
    pthread_t thread;
    atomic_uint stop, is_silent, session;
    _Atomic float force, most; /* at the motor: now; at most since it was looked at */
    atomic_uint state;
} knob;

static int64_t now_us(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000 + time.tv_nsec / 1000;
}

static void pause_ms(long ms)
{
    struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    nanosleep(&time, NULL);
}

/* The device: a step a millisecond, its motor as its firmware says. */
static void *run_knob(void *argument)
{
    knob *k = argument;
    vxs_hvlink_caps caps = {.session = 5,
                            .sensed = 1,
                            .actuated = 1,
                            .rate_hz = 1000,
                            .ttl_ms = 10,
                            .peak_force = 3,
                            .name = "knob"};
    vxs_hvlink_device device;
    vxs_hvlink_device_init(&device, &caps);
    int64_t next = now_us();
    while (!atomic_load(&k->stop)) {
        uint8_t bytes[256], reply[VXS_HVLINK_MAX_FRAME];
        ssize_t count = read(k->master, bytes, sizeof bytes);
        uint32_t now = (uint32_t)now_us();
        for (ssize_t n = 0; n < count; n++) {
            size_t size = vxs_hvlink_device_receive(&device, bytes[n], now, reply);
            if (size > 0 && write(k->master, reply, size) < 0) break;
        }
        float force = 0, place = 0.001f;
        vxs_hvlink_device_output(&device, now, &force);
        atomic_store(&k->force, force);
        if (force > atomic_load(&k->most)) atomic_store(&k->most, force);
        atomic_store(&k->state, device.state);
        size_t size = vxs_hvlink_device_state(&device, &place, NULL, 0, now, bytes);
        if (!atomic_load(&k->is_silent) && write(k->master, bytes, size) < 0) continue;
        next += 1000;
        int64_t left = next - now_us();
        if (left > 0)
            pause_ms(1);
        else
            next = now_us();
    }
    return NULL;
}

static void plug(knob *k)
{
    memset(k, 0, sizeof *k);
    k->master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (k->master < 0 || grantpt(k->master) != 0 || unlockpt(k->master) != 0 ||
        ptsname_r(k->master, k->path, sizeof k->path) != 0)
        SKIP("no pseudo-terminals here");
    /* raw before anybody opens it: no echo of the device's own bytes */
    int slave = open(k->path, O_RDWR | O_NOCTTY);
    struct termios mode;
    CHECK(slave >= 0 && tcgetattr(slave, &mode) == 0);
    cfmakeraw(&mode);
    CHECK(tcsetattr(slave, TCSANOW, &mode) == 0);
    close(slave);
    CHECK(pthread_create(&k->thread, NULL, run_knob, k) == 0);
}

static void unplug(knob *k)
{
    atomic_store(&k->stop, 1);
    pthread_join(k->thread, NULL);
    close(k->master);
}

enum { HOST_REFUSED = 4 };

static void *open_memory(void)
{
    void *memory = aligned_alloc(64, vxs_hardware_memory());
    CHECK(memory);
    return memory;
}

static vxs_result open_host(const char *path, void *memory, vxs_device **device)
{
    vxs_hardware_config config;
    vxs_hardware_config_default(&config);
    config.address = path;
    return vxs_hardware_open(memory, vxs_hardware_memory(), vxs_hardware_kind_named("hvlink"), &config,
                             device);
}

/* The servo's side: so many exchanges, 1 N each. */
static void push(vxs_device *device, int ticks, vxs_device_state *state)
{
    vxs_device_report report;
    vxs_device_exchange(device, NULL, state, &report);
    for (int n = 0; n < ticks; n++) {
        vxs_device_command command = {.wrench = {{1, 0, 0}, {0, 0, 0}},
                                      .hold_ns = state->time_ns + 50000000,
                                      .expires_ns = state->time_ns + 60000000};
        vxs_device_exchange(device, &command, state, &report);
        pause_ms(1);
    }
}

static int comes(atomic_uint *what, uint32_t value)
{
    for (int n = 0; n < 3000 && atomic_load(what) != value; n++) pause_ms(1);
    return atomic_load(what) == value;
}

static int lets_go(knob *k)
{
    for (int n = 0; n < 3000 && atomic_load(&k->force) != 0; n++) pause_ms(1);
    return atomic_load(&k->force) == 0;
}

/* On a machine so busy that either side's watchdog acts: again. */
static void arm_and_push(knob *k, vxs_device *device)
{
    vxs_device_state state = {.state = VXS_DEVICE_READY};
    atomic_store(&k->most, 0);
    for (int tries = 0; tries < 50; tries++) {
        pause_ms(20);
        vxs_device_disarm(device);
        pause_ms(20);
        if (vxs_device_arm(device) != VXS_OK) continue;
        int n = 0;
        do push(device, 50, &state);
        while (++n < 40 && atomic_load(&k->most) == 0);
        if (atomic_load(&k->most) > 0 && state.state == VXS_DEVICE_ARMED) break;
    }
    CHECK(atomic_load(&k->most) > 0 && atomic_load(&k->most) <= 1);
    CHECK_INT(state.state, VXS_DEVICE_ARMED);
    CHECK_NEAR(state.pose.position[0], 0.001, 1e-9);
}

/* A second device in this program, and a second program: refused while it is held, and the first goes on. */
static void second_process(void)
{
    knob k;
    vxs_device *device;
    void *memory = open_memory(), *other = open_memory();
    plug(&k);
    CHECK_INT(open_host(k.path, memory, &device), VXS_OK);
    arm_and_push(&k, device);
    vxs_device *second;
    CHECK_INT(open_host(k.path, other, &second), VXS_BUSY);
    pid_t child = fork();
    if (child == 0) {
        execl("/proc/self/exe", "test_tty", "host", k.path, (char *)NULL);
        _exit(2);
    }
    int status;
    CHECK(waitpid(child, &status, 0) == child && WIFEXITED(status));
    CHECK_INT(WEXITSTATUS(status), HOST_REFUSED);
    arm_and_push(&k, device);
    vxs_device_close(device);
    CHECK(lets_go(&k));
    CHECK_INT(open_host(k.path, other, &second), VXS_OK); /* and now it is free */
    vxs_device_close(second);
    unplug(&k);
    free(memory);
    free(other);
}

static void running(void)
{
    knob k;
    void *memory = open_memory();
    vxs_device *device;
    vxs_device_state state;
    vxs_hardware_counts counts;
    plug(&k);
    CHECK_INT(open_host(k.path, memory, &device), VXS_OK);
    CHECK_TEXT(device->caps.name, "hvlink knob");
    CHECK(device->caps.has_watchdog && !device->caps.verified && device->caps.dof_actuated == 1);
    arm_and_push(&k, device);

    /* Left alone the command expires, though the I/O thread lives on. */
    CHECK(lets_go(&k));
    CHECK_INT(vxs_device_disarm(device), VXS_OK);
    CHECK(comes(&k.state, VXS_HVLINK_READY));

    /* Silence: FAULT. */
    arm_and_push(&k, device);
    atomic_store(&k.is_silent, 1);
    for (int n = 0; n < 100; n++) push(device, 10, &state);
    CHECK_INT(state.state, VXS_DEVICE_FAULT);
    CHECK_INT(state.fault, VXS_DEVICE_FAULT_WATCHDOG);
    CHECK(lets_go(&k));
    atomic_store(&k.is_silent, 0);
    pause_ms(50);
    CHECK_INT(vxs_device_disarm(device), VXS_OK);

    /* Closed while pushing: off. */
    arm_and_push(&k, device);
    vxs_hardware_get(device, &counts);
    printf("pseudo-terminal: %llu sent, %llu measured, %llu malformed, %llu late\n",
           (unsigned long long)counts.sent, (unsigned long long)counts.measured,
           (unsigned long long)counts.malformed, (unsigned long long)counts.late);
    vxs_device_close(device);
    CHECK(lets_go(&k));

    /* Plugged out while pushing. */
    CHECK_INT(open_host(k.path, memory, &device), VXS_OK);
    arm_and_push(&k, device);
    unplug(&k);
    for (int n = 0; n < 300 && state.state != VXS_DEVICE_GONE; n++) push(device, 10, &state);
    CHECK_INT(state.state, VXS_DEVICE_GONE);
    CHECK_INT(state.fault, VXS_DEVICE_FAULT_USB);
    CHECK_INT(vxs_device_arm(device), VXS_LOST);
    vxs_device_close(device);
    free(memory);
}

/* What is killed: test_tty host PATH. */
static int run_host(const char *path)
{
    vxs_device *device;
    vxs_device_state state;
    void *memory = open_memory();
    vxs_result result = open_host(path, memory, &device);
    if (result != VXS_OK) {
        free(memory);
        return result == VXS_BUSY ? HOST_REFUSED : 3;
    }
    for (;;) {
        pause_ms(20);
        vxs_device_disarm(device);
        pause_ms(20);
        if (vxs_device_arm(device) != VXS_OK) continue;
        do push(device, 100, &state);
        while (state.state == VXS_DEVICE_ARMED);
    }
}

/* A host that is killed: nothing of it runs any more, and the device's own watchdog lets go. */
static void check_signal(int number)
{
    knob k;
    plug(&k);
    pid_t child = fork();
    if (child == 0) {
        execl("/proc/self/exe", "test_tty", "host", k.path, (char *)NULL);
        _exit(2);
    }
    for (int n = 0; n < 5000 && atomic_load(&k.most) == 0; n++) pause_ms(1);
    CHECK(atomic_load(&k.most) > 0);
    kill(child, number);
    int status;
    CHECK(waitpid(child, &status, 0) == child && WIFSIGNALED(status));
    CHECK(lets_go(&k));
    for (int n = 0; n < 3000 && atomic_load(&k.state) == VXS_HVLINK_ARMED; n++) pause_ms(1);
    CHECK(atomic_load(&k.state) != VXS_HVLINK_ARMED);
    unplug(&k);
}

static void refusals(void)
{
    void *memory = open_memory();
    vxs_hardware_config config;
    vxs_device *device;
    const vxs_hardware_kind *kind = vxs_hardware_kind_named("hvlink");
    vxs_hardware_config_default(&config);
    config.address = "/dev/there-is-none";
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_NO_DEVICE);
    config.address = NULL;
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_NO_DEVICE);
    config.address = "/dev/null"; /* no tty */
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_NO_DEVICE);
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory() - 64, kind, &config, &device), VXS_BUFFER);
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), NULL, &config, &device), VXS_PARAM);
    config.rate_hz = 0;
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_PARAM);
    config.struct_size = 0;
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_CONFIG);
    for (uint32_t n = 0; vxs_hardware_kind_at(n); n++) {
        const vxs_hardware_kind *k = vxs_hardware_kind_at(n);
        CHECK(vxs_hardware_kind_named(k->name) == k && (k->is_built || k->lacks_text));
        if (k->is_built) continue;
        vxs_hardware_config_default(&config);
        CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), k, &config, &device), VXS_UNSUPPORTED);
    }
    vxs_hardware_found found[4];
    printf("%u known devices on USB here\n", vxs_hardware_probe(found, 4));
    free(memory);
}

static void sigkill(void)
{
    check_signal(SIGKILL);
}

static void sigterm(void)
{
    check_signal(SIGTERM);
}

static void sigint(void)
{
    check_signal(SIGINT);
}

static const struct {
    const char *name;
    void (*run)(void);
} cases[] = {{"refusals", refusals}, {"sigkill", sigkill}, {"sigterm", sigterm},
             {"sigint", sigint},     {"running", running}, {"second_process", second_process}};

int main(int count, char **arguments)
{
    int ran = 0;
    if (count == 3 && strcmp(arguments[1], "host") == 0) return run_host(arguments[2]);
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        if (count > 1 && strcmp(arguments[1], cases[n].name) != 0) continue;
        cases[n].run();
        ran++;
    }
    CHECK(ran > 0);
    return 0;
}
