/* SPDX-License-Identifier: MIT
 *
 * A six-axis mouse by its hidraw node, in a tree that stands for the kernel's (mocked.h). The node is a pipe,
 * whose reports are read as they are written, one at a time; to a user who may not read it the kernel itself
 * says so.
 *     test_hidraw                 makes the device, runs itself as the client, unplugs it
 *     test_hidraw open|locked     the client
 */
#define _GNU_SOURCE 1

#include "check.h"
#include "emulated.h"
#include "mocked.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* --- the client --- */

static void *open_memory(vxs_hardware_config *config)
{
    void *memory = aligned_alloc(64, vxs_hardware_memory());
    CHECK(memory);
    vxs_hardware_config_default(config);
    return memory;
}

/* Of the two nodes there one is a keyboard's. */
static const vxs_hardware_kind *probe(vxs_result usable)
{
    const vxs_hardware_kind *kind = vxs_hardware_kind_named("spacemouse");
    vxs_hardware_found found[2];
    CHECK(kind->is_built && kind->wires & VXS_HARDWARE_HIDRAW);
    CHECK_INT(vxs_hardware_probe(found, 2), 1);
    CHECK(found[0].kind == kind && found[0].wire == VXS_HARDWARE_HIDRAW && found[0].product == 0xC635);
    CHECK_TEXT(found[0].node, "/dev/hidraw0");
    CHECK_INT(found[0].usable, usable);
    return kind;
}

static int run_locked(void)
{
    const char *const ways[] = {NULL, "256f:c635", "/dev/hidraw0"};
    const vxs_hardware_kind *kind = probe(VXS_ACCESS);
    vxs_hardware_config config;
    vxs_device *device = NULL;
    void *memory = open_memory(&config);
    for (int n = 0; n < 3; n++) {
        config.address = ways[n];
        CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_ACCESS);
    }
    free(memory);
    return 0;
}

/* By its id, its path, and as the first that is known; then it is moved until it is gone. */
static int run_open(void)
{
    const char *const ways[] = {"256F:C635", "/dev/hidraw0", NULL};
    const vxs_hardware_kind *kind = probe(VXS_OK);
    vxs_hardware_config config;
    vxs_device *device = NULL;
    vxs_device_state state;
    void *memory = open_memory(&config);
    config.address = "256f:c62e"; /* another of them */
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_NO_DEVICE);
    config.address = "/dev/hidraw7";
    CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_NO_DEVICE);
    for (int n = 0; n < 3; n++) {
        if (device) vxs_device_close(device);
        config.address = ways[n];
        CHECK_INT(vxs_hardware_open(memory, vxs_hardware_memory(), kind, &config, &device), VXS_OK);
        CHECK(!device->caps.has_motors);
    }
    do {
        mocked_pause(1);
        vxs_device_exchange(device, NULL, &state, NULL);
    } while (state.state == VXS_DEVICE_READY);
    vxs_hardware_counts counts;
    vxs_hardware_get(device, &counts);
    printf("hidraw: %llu measured, %llu malformed, x = %.4f m\n", (unsigned long long)counts.measured,
           (unsigned long long)counts.malformed, state.pose.position[0]);
    CHECK_INT(state.state, VXS_DEVICE_GONE);
    CHECK_INT(state.fault, VXS_DEVICE_FAULT_USB);
    CHECK(counts.measured > 20 && counts.malformed == 0 && counts.sent == 0);
    CHECK(state.pose.position[0] > 0);
    vxs_device_close(device);
    free(memory);
    return 0;
}

/* --- the device's side --- */

enum { REPORTS = 250 };

/* Calls on the node are the pipe's own affair. */
static void let_run(int listener, int *file)
{
    unsigned long call[3];
    if (*file < 0) *file = accept4(listener, NULL, NULL, SOCK_CLOEXEC);
    struct pollfd wait = {.fd = *file, .events = POLLIN};
    while (*file >= 0 && poll(&wait, 1, 0) > 0) {
        int is_over = !mocked_read(*file, call, sizeof call);
        if (!is_over)
            is_over = call[0] == MOCKED_RAN ? !mocked_tell(*file, MOCKED_DONE, call[1], call[2])
                                            : !mocked_tell(*file, MOCKED_RUN, 0, 0);
        if (!is_over) continue;
        close(*file);
        *file = -1;
    }
}

static void make_tree(const mocked *m, char *node, size_t most)
{
    mocked_put(m, "sys/class/hidraw/hidraw0/device/uevent",
               "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C635\nHID_NAME=a six-axis mouse\n");
    mocked_put(m, "sys/class/hidraw/hidraw1/device/uevent", "HID_ID=0003:0000046D:0000C31C\n");
    mocked_put(m, "dev/hidraw1", "");
    mocked_put(m, "ioctl/dev/.keep", "");
    snprintf(node, most, "%s/dev/hidraw0", m->folder);
    CHECK(mkfifo(node, 0600) == 0);
}

static void check_ending(int status)
{
    CHECK(WIFEXITED(status));
    CHECK_INT(WEXITSTATUS(status), 0);
}

/* So many reports, 8 ms apart, then nobody is there. */
static void plug_and_pull(void)
{
    static emulated e;
    mocked m;
    char node[256];
    uint8_t bytes[VXSI_WIRE_MOST];
    int status, file = -1, told = 0;
    mocked_begin(&m);
    make_tree(&m, node, sizeof node);
    int listener = mocked_listen(&m, "/dev/hidraw0");
    if (getuid() == 0) {
        pid_t nobody = mocked_run(&m, "locked", 65534);
        CHECK(waitpid(nobody, &status, 0) == nobody);
        check_ending(status);
    }
    int reports = open(node, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    CHECK(reports >= 0);
    pid_t child = mocked_run(&m, "open", getuid());
    int64_t began = mocked_now();
    emulated_init(&e, &emulated_spacemouse);
    e.axes.axis[0] = 350;
    e.now_ns = began;
    vxsi_wire wire = emulated_wire(&e);
    for (pid_t ended = 0; ended != child; ended = waitpid(child, &status, WNOHANG)) {
        CHECK(mocked_now() - began < 60000000000);
        let_run(listener, &file);
        while (e.now_ns < mocked_now()) emulated_run(&e, NULL);
        for (int32_t size; (size = wire.ops->receive(wire.self, bytes, sizeof bytes, 0)) > 0; told++)
            if (reports >= 0) CHECK(write(reports, bytes, (size_t)size) == size || errno == EAGAIN);
        if (told > REPORTS && reports >= 0) {
            close(reports);
            reports = -1;
        }
        mocked_pause(1);
    }
    check_ending(status);
    close(listener);
    mocked_end(&m);
}

int main(int count, char **arguments)
{
    if (count > 1) return strcmp(arguments[1], "locked") == 0 ? run_locked() : run_open();
    signal(SIGPIPE, SIG_IGN);
    if (!mocked_is_here()) SKIP("no umockdev");
    plug_and_pull();
    return 0;
}
