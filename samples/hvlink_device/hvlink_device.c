/* SPDX-License-Identifier: MIT
 *
 * A device that does not exist, at the end of a pseudo-terminal: the protocol hvlink as a microcontroller
 * runs it, above a simulated tip. Prints where it is, runs until it is ended, and says then what its motors
 * did. hvlink_device push                     in a hand that goes 28 mm to the left, 0.8 s after arming
 *     hvlink_device hang KG AFTER STRENGTH   in nobody's: a mass is hung on it AFTER seconds, its motors give
 * STRENGTH newtons for each that they are told
 */
#define _GNU_SOURCE 1 /* posix_openpt, ptsname_r, cfmakeraw */

#include "voxshell/hvlink.h"

#include <fcntl.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

enum { AXES = 3, STEP_US = 100, MOST_STEPS = 500 };

typedef struct tip {
    double x[AXES], speed[AXES], force[AXES];
    double hand[AXES], spring, weight; /* [m], [N/m], [N] down */
} tip;

static volatile sig_atomic_t is_over;

static void end(int number)
{
    (void)number;
    is_over = 1;
}

static int64_t now_us(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000 + time.tv_nsec / 1000;
}

/* 300 g; whoever holds it damps it, and so does its own friction. */
static void step(tip *t)
{
    const double mass = 0.3, damper = t->spring > 0 ? 8 : 1, dt = STEP_US * 1e-6;
    for (int n = 0; n < AXES; n++) {
        double weight = n == 1 ? -t->weight : 0;
        t->speed[n] +=
            dt / mass * (t->force[n] + weight + t->spring * (t->hand[n] - t->x[n]) - damper * t->speed[n]);
        t->x[n] += dt * t->speed[n];
    }
}

/* What arrived, to the protocol; what it answers, back. */
static void listen_to(int file, vxs_hvlink_device *device)
{
    uint8_t bytes[256], reply[VXS_HVLINK_MAX_FRAME];
    ssize_t count = read(file, bytes, sizeof bytes);
    for (ssize_t n = 0; n < count; n++) {
        size_t size = vxs_hvlink_device_receive(device, bytes[n], (uint32_t)now_us(), reply);
        if (size > 0 && write(file, reply, size) < 0) return;
    }
}

static int open_terminal(char *path, size_t size)
{
    struct termios mode;
    int master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0 || ptsname_r(master, path, size) != 0)
        return -1;
    int slave = open(path, O_RDWR | O_NOCTTY); /* stays open: a host that goes is no hang-up */
    if (slave < 0 || tcgetattr(slave, &mode) != 0) return -1;
    cfmakeraw(&mode); /* no echo of the device's own bytes */
    return tcsetattr(slave, TCSANOW, &mode) == 0 ? master : -1;
}

int main(int count, char **arguments)
{
    const vxs_hvlink_caps caps = {.session = (uint32_t)now_us(),
                                  .sensed = AXES,
                                  .actuated = AXES,
                                  .rate_hz = 1000,
                                  .ttl_ms = 10,
                                  .peak_force = 8,
                                  .name = "on a pseudo-terminal"};
    char path[64];
    int is_hung = count == 5 && strcmp(arguments[1], "hang") == 0;
    int file =
        is_hung || (count == 2 && strcmp(arguments[1], "push") == 0) ? open_terminal(path, sizeof path) : -2;
    if (file < 0) {
        fprintf(stderr, file == -2 ? "usage: hvlink_device push | hang KG AFTER STRENGTH\n"
                                   : "no pseudo-terminals here\n");
        return file == -2 ? 1 : 77;
    }
    double mass = is_hung ? strtod(arguments[2], NULL) : 0,
           after = is_hung ? strtod(arguments[3], NULL) : 0.8;
    double strength = is_hung ? strtod(arguments[4], NULL) : 1, most = 0, age = 0;
    tip t = {.spring = is_hung ? 0 : 500, .weight = is_hung ? 0.1 : 0};
    vxs_hvlink_device device;
    vxs_hvlink_device_init(&device, &caps);
    const struct sched_param priority = {.sched_priority = 84};
    sched_setscheduler(0, SCHED_FIFO, &priority); /* where allowed: a microcontroller does nothing else */
    signal(SIGTERM, end);
    signal(SIGINT, end);
    printf("%s\n", path);
    fflush(stdout);

    int64_t armed = 0, next = now_us(), last = next, heard = 0;
    while (!is_over) {
        listen_to(file, &device);
        int64_t now = now_us();
        if (device.state != VXS_HVLINK_ARMED) armed = now;
        double seconds = (double)(now - armed) * 1e-6;
        if (is_hung)
            t.weight = 0.1 + (seconds > after ? 9.81 * mass : 0);
        else
            t.hand[0] = -0.028 * fmin(fmax((seconds - after) / 0.4, 0), 1);

        float told[AXES] = {0}, place[AXES];
        vxs_hvlink_device_output(&device, (uint32_t)now, told);
        double force = 0;
        for (int n = 0; n < AXES; n++) {
            t.force[n] = strength * (double)told[n];
            force += t.force[n] * t.force[n];
        }
        most = fmax(most, sqrt(force));
        if (device.has_command) heard = now - (int64_t)(uint32_t)((uint32_t)now - device.command_us);
        if (force > 0) age = fmax(age, (double)(now - heard) * 1e-3);
        for (int n = 0; last + STEP_US <= now && n < MOST_STEPS; n++, last += STEP_US) step(&t);
        if (last + STEP_US <= now) last = now;

        uint8_t bytes[VXS_HVLINK_MAX_FRAME];
        for (int n = 0; n < AXES; n++) place[n] = (float)t.x[n];
        size_t size = vxs_hvlink_device_state(&device, place, NULL, 0, (uint32_t)now, bytes);
        if (write(file, bytes, size) < 0)
            tcflush(file, TCIOFLUSH); /* nobody listens: what is old is of no use */
        next += 1000;
        if (next < now) next = now;
        const struct timespec pause = {.tv_nsec = (long)(next - now) * 1000};
        nanosleep(&pause, NULL);
    }
    double force = sqrt(t.force[0] * t.force[0] + t.force[1] * t.force[1] + t.force[2] * t.force[2]);
    printf("%.3f N at most, %.3f N at the end, no force on a command older than %.1f ms; tip at %.2f %.2f "
           "%.2f mm\n",
           most, force, age, 1e3 * t.x[0], 1e3 * t.x[1], 1e3 * t.x[2]);
    return 0;
}
