/* SPDX-License-Identifier: MIT
 *
 * A hAPI board at the other end of a pseudo-terminal, in real time: the emulated one, its frames taken out of
 * what arrives by their size alone, as a board does. Opened, armed, pushed, closed while it pushes, unplugged
 * while it pushes. No assertion on how fast: that is the machine's affair.
 */
#define _GNU_SOURCE 1

#include "check.h"
#include "emulated.h"
#include "mocked.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <termios.h>
#include <unistd.h>

typedef struct board {
    emulated e;
    int master;
    char path[64];
    pthread_t thread;
    atomic_uint stop, setups;
    _Atomic double force, most; /* [N]: now; at most since it was looked at */
} board;

/* Bytes of the frame that begins so; 0 for none. */
static size_t size_of(uint8_t kind)
{
    return kind == 0 ? 2 : kind == 1 ? 26 : kind == 2 ? 10 : 0;
}

static void *run_board(void *argument)
{
    board *b = argument;
    vxsi_wire wire = emulated_wire(&b->e);
    uint8_t bytes[256], answer[VXSI_WIRE_MOST];
    size_t count = 0;
    b->e.now_ns = mocked_now();
    while (!atomic_load(&b->stop)) {
        ssize_t got = read(b->master, bytes + count, sizeof bytes - count);
        if (got > 0) count += (size_t)got;
        for (size_t size; count > 0 && (size = size_of(bytes[0])) <= count;) {
            if (size == 0) size = 1; /* out of step */
            if (bytes[0] == 1) atomic_fetch_add(&b->setups, 1);
            wire.ops->send(wire.self, bytes, size);
            count -= size;
            memmove(bytes, bytes + size, count);
        }
        while (b->e.now_ns < mocked_now()) emulated_run(&b->e, NULL);
        for (int32_t size; (size = wire.ops->receive(wire.self, answer, sizeof answer, 0)) > 0;)
            if (write(b->master, answer, (size_t)size) != size) break;
        double force = emulated_force(&b->e);
        atomic_store(&b->force, force);
        if (force > atomic_load(&b->most)) atomic_store(&b->most, force);
        mocked_pause(0);
    }
    return NULL;
}

static void plug(board *b)
{
    memset(b, 0, sizeof *b);
    emulated_init(&b->e, &emulated_haply);
    b->master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (b->master < 0 || grantpt(b->master) != 0 || unlockpt(b->master) != 0 ||
        ptsname_r(b->master, b->path, sizeof b->path) != 0)
        SKIP("no pseudo-terminals here");
    int slave = open(b->path, O_RDWR | O_NOCTTY); /* raw before anybody opens it: no echo */
    struct termios mode;
    CHECK(slave >= 0 && tcgetattr(slave, &mode) == 0);
    cfmakeraw(&mode);
    CHECK(tcsetattr(slave, TCSANOW, &mode) == 0);
    close(slave);
    CHECK(pthread_create(&b->thread, NULL, run_board, b) == 0);
}

static void unplug(board *b)
{
    atomic_store(&b->stop, 1);
    pthread_join(b->thread, NULL);
    close(b->master);
}

static vxs_device *open_board(const board *b, void *memory)
{
    vxs_hardware_config config;
    vxs_device *device = NULL;
    vxs_hardware_config_default(&config);
    config.address = b->path;
    config.is_in_place = 1;
    vxs_result result = VXS_TIMEOUT;
    for (int tries = 0; tries < 20 && result == VXS_TIMEOUT; tries++) /* a machine that stalls */
        result = vxs_hardware_open(memory, vxs_hardware_memory(), vxs_hardware_kind_named("haply"), &config,
                                   &device);
    CHECK_INT(result, VXS_OK);
    return device;
}

/* Until it pushes; again on a machine so busy that a watchdog acts. */
static void arm_and_push(board *b, vxs_device *device)
{
    vxs_device_state state;
    atomic_store(&b->most, 0);
    for (int tries = 0; tries < 50 && atomic_load(&b->most) < 0.2; tries++) {
        vxs_device_disarm(device);
        mocked_pause(20);
        vxs_device_exchange(device, NULL, &state, NULL);
        if (vxs_device_arm(device) != VXS_OK) continue;
        for (int n = 0; n < 600 && atomic_load(&b->most) < 0.2; n++) {
            vxs_device_command command = {.wrench = {{1, 0, 0}, {0, 0, 0}},
                                          .hold_ns = state.time_ns + 50000000,
                                          .expires_ns = state.time_ns + 60000000};
            vxs_device_exchange(device, &command, &state, NULL);
            mocked_pause(1);
        }
    }
    CHECK(atomic_load(&b->most) >= 0.2 && atomic_load(&b->most) < 1.01);
    CHECK(fabs(state.pose.position[0]) < 0.02);
}

static int lets_go(board *b)
{
    for (int n = 0; n < 3000 && atomic_load(&b->force) != 0; n++) mocked_pause(1);
    return atomic_load(&b->force) == 0;
}

int main(void)
{
    static board b;
    void *memory = aligned_alloc(64, vxs_hardware_memory());
    plug(&b);
    vxs_device *device = open_board(&b, memory), *second = NULL;
    CHECK_TEXT(device->caps.name, "Haply 2diy");
    CHECK(device->caps.has_motors && !device->caps.has_watchdog);

    vxs_hardware_config config;
    void *other = aligned_alloc(64, vxs_hardware_memory());
    vxs_hardware_config_default(&config);
    config.address = b.path;
    CHECK_INT(
        vxs_hardware_open(other, vxs_hardware_memory(), vxs_hardware_kind_named("haply"), &config, &second),
        VXS_BUSY);
    free(other);

    arm_and_push(&b, device);
    CHECK(lets_go(&b)); /* left alone, the command's time is over */
    arm_and_push(&b, device);
    vxs_device_close(device); /* while it pushes: zero is the last that is said */
    CHECK(lets_go(&b));

    /* What was under way when the port was closed may have been cut: then the board takes the next set-up for the rest of it. */
    unsigned before = atomic_load(&b.setups);
    device = NULL;
    for (int tries = 0; tries < 20 && atomic_load(&b.setups) == before; tries++) {
        if (device) vxs_device_close(device);
        mocked_pause(50);
        device = open_board(&b, memory);
    }
    CHECK(atomic_load(&b.setups) > before);
    arm_and_push(&b, device);
    unplug(&b);
    vxs_device_state state = {.state = VXS_DEVICE_ARMED};
    for (int n = 0; n < 3000 && state.state != VXS_DEVICE_GONE; n++) {
        vxs_device_exchange(device, NULL, &state, NULL);
        mocked_pause(1);
    }
    vxs_hardware_counts counts;
    vxs_hardware_get(device, &counts);
    printf("haply on a pseudo-terminal: %llu sent, %llu measured, %llu malformed, %llu late\n",
           (unsigned long long)counts.sent, (unsigned long long)counts.measured,
           (unsigned long long)counts.malformed, (unsigned long long)counts.late);
    CHECK_INT(state.state, VXS_DEVICE_GONE);
    CHECK_INT(vxs_device_arm(device), VXS_LOST);
    vxs_device_close(device);
    free(memory);
    return 0;
}
