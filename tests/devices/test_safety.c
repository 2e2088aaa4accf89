/* SPDX-License-Identifier: MIT
 *
 * What must not hurt anybody, each a named case: test_safety CASE, or all without one.
 * In each the motors push when it happens; they must be at zero within one tick of 1 ms (10 ms where the wire
 * itself is what is broken), the state FAULT or GONE with its cause, and nothing arms again by itself.
 */
#include "check.h"
#include "emulated.h"

typedef struct rig {
    emulated e;
    vxsi_link link;
    vxs_device_command command;
    vxs_device_state state;
    vxs_device_report report;
} rig;

static void push(rig *r)
{
    r->command = (vxs_device_command){.wrench = {{1, 0.5, -1}, {0, 0, 0}},
                                      .hold_ns = r->e.now_ns + 2000000,
                                      .expires_ns = r->e.now_ns + 12000000};
}

static void tick(rig *r, int does_push)
{
    emulated_run(&r->e, &r->link);
    if (does_push) push(r);
    vxs_device_exchange(&r->link.device, does_push ? &r->command : NULL, &r->state, &r->report);
}

static void start(rig *r, const emulated_kind *kind)
{
    memset(r, 0, sizeof *r);
    emulated_init(&r->e, kind);
    CHECK_INT(emulated_link(&r->e, &r->link), VXS_OK);
    for (int n = 0; n < 10; n++) tick(r, 0);
    CHECK_INT(r->state.state, VXS_DEVICE_READY);
}

static void start_pushing(rig *r, const emulated_kind *kind)
{
    start(r, kind);
    CHECK_INT(vxs_device_arm(&r->link.device), VXS_OK);
    for (int n = 0; n < 700; n++) tick(r, 1);
    CHECK_INT(r->state.state, VXS_DEVICE_ARMED);
    CHECK(emulated_force(&r->e) > 1);
}

/* From here on: at zero after so many ticks, with this state and cause, and it stays so, however much is
 * commanded. */
static void expect(rig *r, int within, uint32_t state, uint32_t fault)
{
    int ticks = 0;
    while (emulated_force(&r->e) != 0 && ticks <= within) {
        tick(r, 1);
        ticks++;
    }
    CHECK(ticks <= within);
    for (int n = 0; n < 1000; n++) {
        tick(r, 1);
        CHECK(emulated_force(&r->e) == 0);
        if (n > 1) CHECK_INT(r->state.state, state);
        if (n > 1) CHECK_INT(r->state.fault, fault);
    }
    CHECK(r->report.rendered.force[0] == 0);
    CHECK_INT(vxs_device_arm(&r->link.device), state == VXS_DEVICE_GONE ? VXS_LOST : VXS_STATE);
}

/* Out of FAULT only by hand, to READY, and only arm() makes force again. */
static void expect_recovery(rig *r)
{
    memset(&r->e.trouble, 0, sizeof r->e.trouble);
    r->e.is_silent = 0;
    for (int n = 0; n < 50; n++) tick(r, 1);
    CHECK_INT(r->state.state, VXS_DEVICE_FAULT);
    CHECK_INT(vxs_device_disarm(&r->link.device), VXS_OK);
    for (int n = 0; n < 200; n++) {
        tick(r, 1);
        CHECK(emulated_force(&r->e) == 0);
    }
    CHECK_INT(r->state.state, VXS_DEVICE_READY);
    CHECK_INT(vxs_device_arm(&r->link.device), VXS_OK);
    for (int n = 0; n < 700; n++) tick(r, 1);
    CHECK_INT(r->state.state, VXS_DEVICE_ARMED);
    CHECK(emulated_force(&r->e) > 1);
    vxs_device_close(&r->link.device);
    emulated_run(&r->e, NULL);
    CHECK(emulated_force(&r->e) == 0);
}

static rig r;

/* The motors of a device that is unplugged are nobody's; what the host must do is to see it and to end. */
static void unplug_at_every_step(void)
{
    for (int k = 0; k < 4; k++) {
        int is_over = 0;
        for (uint32_t at = 1; at < 100000 && !is_over; at += at < 400 ? 1 : 97) {
            memset(&r, 0, sizeof r);
            emulated_init(&r.e, emulated_kinds[k]);
            r.e.trouble.unplug_at = at;
            vxs_result result = emulated_link(&r.e, &r.link);
            CHECK(result == VXS_OK || result == VXS_LOST);
            if (result == VXS_OK) {
                int n = 0;
                for (; n < 30 && r.state.state != VXS_DEVICE_GONE; n++) tick(&r, 1);
                if (r.state.state != VXS_DEVICE_GONE) {
                    CHECK_INT(vxs_device_arm(&r.link.device), VXS_OK);
                    for (n = 0; n < 20 && r.state.state != VXS_DEVICE_GONE; n++) tick(&r, 1);
                }
                is_over = r.state.state == VXS_DEVICE_ARMED;
                if (!is_over) {
                    CHECK_INT(r.state.state, VXS_DEVICE_GONE);
                    CHECK_INT(r.state.fault, VXS_DEVICE_FAULT_USB);
                    CHECK(r.report.rendered.force[0] == 0);
                    CHECK_INT(vxs_device_arm(&r.link.device), VXS_LOST);
                    CHECK_INT(vxs_device_disarm(&r.link.device), VXS_LOST);
                }
                vxs_device_close(&r.link.device);
            }
            CHECK(r.e.is_closed);
        }
        CHECK(is_over);
    }
}

/* Seen within the tick that it happens in. */
static void unplug_while_pushing(void)
{
    for (int k = 0; k < 3; k++) {
        start_pushing(&r, emulated_kinds[k]);
        r.e.trouble.unplug_at = r.e.calls + 1;
        tick(&r, 1);
        CHECK_INT(r.state.state, VXS_DEVICE_GONE);
        CHECK_INT(r.state.fault, VXS_DEVICE_FAULT_USB);
        CHECK(r.report.rendered.force[0] == 0);
        r.e.trouble.unplug_at = 0; /* plugged in again: the old device stays gone */
        for (int n = 0; n < 100; n++) tick(&r, 1);
        CHECK_INT(r.state.state, VXS_DEVICE_GONE);
        vxs_device_close(&r.link.device);
        /* and the new one is not armed */
        memset(&r.link, 0, sizeof r.link);
        r.e.is_closed = 0;
        CHECK_INT(emulated_link(&r.e, &r.link), VXS_OK);
        for (int n = 0; n < 200; n++) tick(&r, 1);
        CHECK_INT(r.state.state, VXS_DEVICE_READY);
        CHECK(emulated_force(&r.e) == 0);
    }
}

/* Measurements stop: zero 10 ms after the last one, FAULT after 100 ms. */
static void stale_data(void)
{
    for (int k = 0; k < 3; k++) {
        start_pushing(&r, emulated_kinds[k]);
        r.e.is_silent = 1;
        for (int n = 0; n < 16; n++) tick(&r, 1); /* 10 ms, and the wire's answer that never came: 5 ms */
        CHECK(emulated_force(&r.e) == 0);
        CHECK(r.state.link_age > 0.01);
        for (int n = 0; n < 100; n++) {
            tick(&r, 1);
            CHECK(emulated_force(&r.e) == 0);
        }
        expect(&r, 0, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_WATCHDOG);
        expect_recovery(&r);
    }
}

/* A hundredth of all packets each: the loop goes on, no force is ever above what was asked for. */
static void lost_and_doubled(void)
{
    for (int k = 0; k < 3; k++) {
        start_pushing(&r, emulated_kinds[k]);
        r.e.trouble.lost = r.e.trouble.doubled = r.e.trouble.delayed = 655;
        int armed = 0;
        for (int n = 0; n < 3000; n++) {
            tick(&r, 1);
            CHECK(emulated_force(&r.e) < 1.6);
            armed += r.state.state == VXS_DEVICE_ARMED;
        }
        CHECK(armed > 0);
        if (r.state.state == VXS_DEVICE_FAULT) expect(&r, 10, VXS_DEVICE_FAULT, r.state.fault);
    }
}

static void not_finite_from_device(void)
{
    for (int k = 0; k < 2; k++) { /* a Falcon's counts are integers */
        start_pushing(&r, emulated_kinds[k]);
        r.e.trouble.not_finite = 65536;
        tick(&r, 1); /* says it */
        r.e.trouble.not_finite = 0;
        tick(&r, 1); /* is heard */
        expect(&r, 1, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_SOFTWARE);
        expect_recovery(&r);
    }
}

static void not_finite_from_host(void)
{
    for (int k = 0; k < 3; k++) {
        for (int part = 0; part < 6; part++) {
            start_pushing(&r, emulated_kinds[k]);
            push(&r);
            (part < 3 ? r.command.wrench.force : r.command.wrench.torque)[part % 3] =
                part % 2 ? NAN : INFINITY;
            vxs_device_exchange(&r.link.device, &r.command, &r.state, &r.report);
            CHECK(r.report.flags & VXS_DEVICE_REFUSED);
            CHECK_INT(r.state.state, VXS_DEVICE_FAULT);
            tick(&r, 1);
            expect(&r, 1, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_SOFTWARE);
        }
        expect_recovery(&r);
    }
}

static void jump_of_position(void)
{
    for (int k = 0; k < 3; k++) {
        start_pushing(&r, emulated_kinds[k]);
        r.e.trouble.jump = 65536;
        tick(&r, 1);
        tick(&r, 1);
        expect(&r, 1, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_VELOCITY);
        /* where it jumped back is a jump, too: so disarm, and begin anew */
        memset(&r.e.trouble, 0, sizeof r.e.trouble);
        for (int n = 0; n < 10; n++) tick(&r, 1);
        expect_recovery(&r);
    }
}

static void clock_going_back(void)
{
    for (int k = 0; k < 3; k++) {
        start_pushing(&r, emulated_kinds[k]);
        r.e.now_ns -= 500000000;
        r.e.count = 0;
        expect(&r, 1, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_SOFTWARE);
    }
}

/* The servo stalls, for ever or by turns: the command decays to zero within 12 ms of the last one, and is
 * full again when the loop is. */
static void overrun_storms(void)
{
    for (int k = 0; k < 3; k++) {
        start_pushing(&r, emulated_kinds[k]);
        for (int storm = 0; storm < 20; storm++) {
            double last = INFINITY;
            for (int n = 0; n < 14 + storm; n++) {
                emulated_run(&r.e, &r.link);
                if (n > 0) CHECK(emulated_force(&r.e) <= last + 0.01); /* motor units are whole */
                last = emulated_force(&r.e);
            }
            CHECK(emulated_force(&r.e) == 0);
            for (int n = 0; n < 3; n++) tick(&r, 1);
            CHECK(emulated_force(&r.e) > 1);
        }
        vxs_device_close(&r.link.device);
    }
}

static void arming_without_calibration(void)
{
    vxs_hardware_config config;
    vxs_hardware_config_default(&config);
    memset(&r, 0, sizeof r);
    emulated_init(&r.e, &emulated_haply); /* nobody said that it is in its place */
    CHECK_INT(emulated_link_as(&r.e, &r.link, &config), VXS_OK);
    for (int n = 0; n < 50; n++) tick(&r, 1);
    CHECK_INT(r.state.state, VXS_DEVICE_UNCALIBRATED);
    CHECK_INT(vxs_device_arm(&r.link.device), VXS_STATE);
    tick(&r, 1);
    CHECK(emulated_force(&r.e) == 0);

    memset(&r, 0, sizeof r);
    emulated_init(&r.e, &emulated_falcon); /* not pulled out and pushed in yet */
    r.e.is_homed = 0;
    CHECK_INT(emulated_link(&r.e, &r.link), VXS_OK);
    for (int n = 0; n < 50; n++) tick(&r, 1);
    CHECK_INT(r.state.state, VXS_DEVICE_UNCALIBRATED);
    CHECK_INT(vxs_device_arm(&r.link.device), VXS_STATE);
    CHECK(emulated_force(&r.e) == 0);
    r.e.is_homed = 1;
    for (int n = 0; n < 10; n++) tick(&r, 1);
    CHECK_INT(r.state.state, VXS_DEVICE_READY); /* homed, and no more than that */
    CHECK(emulated_force(&r.e) == 0);
    CHECK_INT(vxs_device_arm(&r.link.device), VXS_OK);
    for (int n = 0; n < 700; n++) tick(&r, 1);
    r.e.is_homed = 0; /* it lost its place */
    tick(&r, 1);
    tick(&r, 1);
    expect(&r, 1, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_PROTOCOL);

    memset(&r, 0, sizeof r);
    emulated_init(&r.e, &emulated_hvlink);
    r.e.hvlink.state = VXS_HVLINK_UNCALIBRATED;
    CHECK_INT(emulated_link(&r.e, &r.link), VXS_OK);
    for (int n = 0; n < 50; n++) tick(&r, 1);
    CHECK_INT(vxs_device_arm(&r.link.device), VXS_STATE);
}

/* Bytes against the protocol: zero from the third in a row, FAULT at the twentieth. */
static void nonsense(void)
{
    for (int k = 0; k < 3; k++) {
        start_pushing(&r, emulated_kinds[k]);
        r.e.trouble.damaged = 65536;
        for (int n = 0; n < 40 && r.state.state == VXS_DEVICE_ARMED; n++) tick(&r, 1);
        for (int n = 0; n < 100 && r.state.state == VXS_DEVICE_ARMED; n++) {
            tick(&r, 1);
            CHECK(emulated_force(&r.e) == 0);
        }
        CHECK_INT(r.state.state, VXS_DEVICE_FAULT);
        uint32_t fault = r.state.fault;
        CHECK(fault == VXS_DEVICE_FAULT_PROTOCOL || fault == VXS_DEVICE_FAULT_WATCHDOG ||
              fault == VXS_DEVICE_FAULT_VELOCITY || fault == VXS_DEVICE_FAULT_SOFTWARE);
        memset(&r.e.trouble, 0, sizeof r.e.trouble);
        expect(&r, 10, VXS_DEVICE_FAULT, fault);
        expect_recovery(&r);
    }
}

/* hvlink: the device started anew in between. It is off, its session is another, and the host does not arm
 * it. */
static void device_restarts(void)
{
    start_pushing(&r, &emulated_hvlink);
    vxs_hvlink_caps caps = r.e.hvlink.caps;
    caps.session++;
    vxs_hvlink_device_init(&r.e.hvlink, &caps);
    tick(&r, 1);
    tick(&r, 1);
    expect(&r, 1, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_DEADMAN);

    start_pushing(&r, &emulated_hvlink); /* its own fault: the cause comes through */
    vxs_hvlink_device_fail(&r.e.hvlink, VXS_DEVICE_FAULT_VELOCITY);
    tick(&r, 1);
    tick(&r, 1);
    expect(&r, 1, VXS_DEVICE_FAULT, VXS_DEVICE_FAULT_VELOCITY);
    expect_recovery(&r);
}

/* The first half second after arming: no more than the share of the peak that time has earned. */
static void arming_ramps(void)
{
    for (int k = 0; k < 3; k++) {
        start(&r, emulated_kinds[k]);
        push(&r);
        r.command.wrench.force[0] = 100;
        for (int n = 0; n < 5; n++) tick(&r, 1); /* before arming: never acts */
        CHECK_INT(vxs_device_arm(&r.link.device), VXS_OK);
        for (int n = 0; n < 600; n++) {
            emulated_run(&r.e, &r.link);
            push(&r);
            r.command.wrench.force[0] = 100;
            r.command.wrench.force[2] = 20;
            vxs_device_exchange(&r.link.device, &r.command, &r.state, &r.report);
            double most = r.link.device.caps.peak_force * (n < 500 ? (n + 1) / 500.0 : 1);
            CHECK(emulated_force(&r.e) <= most + 0.01);
        }
        CHECK(emulated_force(&r.e) > 0.9 * r.link.device.caps.peak_force);
        CHECK(r.report.flags & VXS_DEVICE_CLAMPED);
        vxs_device_close(&r.link.device);
    }
}

/* What the device has no motor for is said, and is not made of another axis. */
static void incomplete(void)
{
    start_pushing(&r, &emulated_haply);
    CHECK(r.report.flags & VXS_DEVICE_INCOMPLETE); /* y */
    CHECK(r.report.rendered.force[1] == 0);
    CHECK_NEAR(r.e.force[0], 1, 1e-3);
    CHECK_NEAR(r.e.force[2], -1, 1e-3);
    vxs_device_close(&r.link.device);
}

/* A Falcon without firmware, then with a file of somebody's, which is taken at the third try. */
static void firmware(void)
{
    memset(&r, 0, sizeof r);
    emulated_init(&r.e, &emulated_falcon);
    r.e.has_firmware = 0;
    CHECK_INT(emulated_link(&r.e, &r.link), VXS_OK);
    tick(&r, 1);
    CHECK_INT(r.state.state, VXS_DEVICE_NO_FIRMWARE);
    CHECK_INT(vxs_device_arm(&r.link.device), VXS_STATE);
    vxs_device_close(&r.link.device);

    char path[] = "test_safety_firmware.bin";
    FILE *file = fopen(path, "wb");
    CHECK(file);
    for (int n = 0; n < 1000; n++) fputc(n * 7 & 0xFF, file);
    fclose(file);
    vxs_hardware_config config;
    vxs_hardware_config_default(&config);
    for (uint32_t bad = 0; bad <= 20; bad += 2) {
        memset(&r, 0, sizeof r);
        emulated_init(&r.e, &emulated_falcon);
        r.e.has_firmware = 0;
        r.e.bad_uploads = bad;
        config.firmware = path;
        vxs_result result = emulated_link_as(&r.e, &r.link, &config);
        CHECK_INT(result, bad < 10 ? VXS_OK : VXS_TIMEOUT);
        if (result != VXS_OK) break;
        for (int n = 0; n < 10; n++) tick(&r, 0);
        CHECK_INT(r.state.state, VXS_DEVICE_READY);
        vxs_device_close(&r.link.device);
    }
    remove(path);
    memset(&r, 0, sizeof r);
    emulated_init(&r.e, &emulated_falcon);
    r.e.has_firmware = 0;
    CHECK_INT(emulated_link_as(&r.e, &r.link, &config), VXS_IO); /* the file is gone */
}

static const struct {
    const char *name;
    void (*run)(void);
} cases[] = {{"unplug_at_every_step", unplug_at_every_step},
             {"unplug_while_pushing", unplug_while_pushing},
             {"stale_data", stale_data},
             {"lost_and_doubled", lost_and_doubled},
             {"not_finite_from_device", not_finite_from_device},
             {"not_finite_from_host", not_finite_from_host},
             {"jump_of_position", jump_of_position},
             {"clock_going_back", clock_going_back},
             {"overrun_storms", overrun_storms},
             {"arming_without_calibration", arming_without_calibration},
             {"nonsense", nonsense},
             {"device_restarts", device_restarts},
             {"arming_ramps", arming_ramps},
             {"incomplete", incomplete},
             {"firmware", firmware}};

int main(int count, char **arguments)
{
    int ran = 0;
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        if (count > 1 && strcmp(arguments[1], cases[n].name) != 0) continue;
        fprintf(stderr, "%s\n", cases[n].name);
        cases[n].run();
        ran++;
    }
    CHECK(ran > 0);
    return 0;
}
