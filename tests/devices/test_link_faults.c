/* SPDX-License-Identifier: MIT
 *
 * What may go wrong between a host and a device, call by call and word by word: each call of opening fails in each way;
 * wires that are busy for ever; devices that say what no device may.
 */
#define _DEFAULT_SOURCE 1 /* mkstemp, fdopen */

#include "check.h"
#include "emulated.h"

#include <unistd.h>

/* --- a wire before the emulated device's own --- */

enum { SEND, RECEIVE, CONTROL, CALLS };

static emulated e;
static vxsi_link host;
static struct {
    int count[CALLS];
    int fails[CALLS], fails_until[CALLS]; /* calls of these numbers give `result`; 0: none */
    vxs_result result[CALLS];
    const uint8_t *before, *after; /* bytes that each reply of an FTDI chip's is wrapped in */
    size_t before_size, after_size;
    uint8_t sent[VXSI_WIRE_MOST]; /* the last packet */
    size_t sent_size;
    int is_mute; /* the device hears nothing more */
} wire;

static int is_failing(int call)
{
    int n = ++wire.count[call];
    return wire.fails[call] && n >= wire.fails[call] && n <= wire.fails_until[call];
}

static vxs_result send_bytes(void *self, const uint8_t *bytes, size_t size)
{
    if (is_failing(SEND)) return wire.result[SEND];
    memcpy(wire.sent, bytes, size);
    wire.sent_size = size;
    if (wire.is_mute) return VXS_OK;
    vxsi_wire inner = emulated_wire(self);
    return inner.ops->send(inner.self, bytes, size);
}

static int32_t receive_bytes(void *self, uint8_t *bytes, size_t most, int64_t wait_ns)
{
    uint8_t packet[VXSI_WIRE_MOST];
    vxsi_wire inner = emulated_wire(self);
    if (is_failing(RECEIVE)) {
        ((emulated *)self)->now_ns += wait_ns;
        return (int32_t)wire.result[RECEIVE];
    }
    int32_t size = inner.ops->receive(inner.self, bytes, most, wait_ns);
    if (size <= 2 || !wire.before || ((emulated *)self)->has_firmware) return size;
    memcpy(packet, bytes, (size_t)size);
    memcpy(bytes + 2, wire.before, wire.before_size);
    memcpy(bytes + 2 + wire.before_size, packet + 2, (size_t)size - 2);
    memcpy(bytes + size + wire.before_size, wire.after, wire.after_size);
    return size + (int32_t)(wire.before_size + wire.after_size);
}

static vxs_result control(void *self, uint8_t request, uint16_t value)
{
    vxsi_wire inner = emulated_wire(self);
    return is_failing(CONTROL) ? wire.result[CONTROL] : inner.ops->control(inner.self, request, value);
}

static void close_wire(void *self)
{
    vxsi_wire inner = emulated_wire(self);
    inner.ops->close(inner.self);
}

static const vxsi_wire_ops plain = {
    .name = "faulty", .send = send_bytes, .receive = receive_bytes, .close = close_wire};
static const vxsi_wire_ops ftdi = {
    .name = "faulty", .control = control, .send = send_bytes, .receive = receive_bytes, .close = close_wire};

static void begin(const emulated_kind *kind)
{
    memset(&wire, 0, sizeof wire);
    memset(&host, 0, sizeof host);
    emulated_init(&e, kind);
    host.now = emulated_now;
    host.user = &e;
}

static vxs_result open_as(const vxs_hardware_config *config)
{
    vxsi_wire ours = {e.kind == &emulated_falcon ? &ftdi : &plain, &e};
    vxs_result result = vxsi_link_open(&host, e.kind->driver, config, &ours);
    CHECK_INT(e.is_closed, result != VXS_OK);
    return result;
}

static vxs_hardware_config good_config(void)
{
    vxs_hardware_config config;
    vxs_hardware_config_default(&config);
    config.is_in_place = 1;
    return config;
}

static uint32_t exchange(vxs_device_state *state)
{
    vxs_device_exchange(&host.device, NULL, state, NULL);
    return state->state;
}

/* --- opening --- */

/* The k-th call of a sort fails, once or from then on, for every k: a device that opened works, one that did not
 * is closed, and why is passed on. */
static void check_each_call(const emulated_kind *kind, int call, vxs_result fault, int is_for_ever,
                            const char *firmware)
{
    vxs_hardware_config config = good_config();
    config.firmware = firmware;
    int opened = 0, refused = 0;
    for (int k = 1;; k++) {
        begin(kind);
        e.has_firmware = firmware == NULL;
        wire.fails[call] = k;
        wire.fails_until[call] = is_for_ever ? 1 << 30 : k;
        wire.result[call] = fault;
        vxs_result result = open_as(&config);
        if (wire.count[call] < k) {
            CHECK_INT(result, VXS_OK);
            vxs_device_close(&host.device);
            break;
        }
        if (result != VXS_OK) {
            CHECK(result == fault || (fault == VXS_BUSY && result == VXS_TIMEOUT));
            refused++;
            continue;
        }
        /* A call that was busy, or another try. */
        vxs_device_state state;
        CHECK(fault == VXS_BUSY || firmware);
        opened++;
        wire.fails[call] = 0;
        for (int n = 0; n < 50; n++) emulated_run(&e, &host);
        uint32_t now = exchange(&state);
        CHECK(now == VXS_DEVICE_READY || now == VXS_DEVICE_NO_FIRMWARE);
        vxs_device_close(&host.device);
    }
    CHECK(opened + refused > 0 && (fault == VXS_BUSY || refused > 0));
}

static void check_opening(const char *firmware)
{
    static const vxs_result faults[] = {VXS_BUSY, VXS_LOST, VXS_IO};
    for (int n = 0; n < 3; n++) {
        for (int k = 0; k < 3; k++) /* the mouse is not talked to */
            for (int is_for_ever = 0; is_for_ever < 2; is_for_ever++)
                check_each_call(emulated_kinds[k], SEND, faults[n], is_for_ever, NULL);
        check_each_call(&emulated_falcon, CONTROL, faults[n], 0, NULL);
        check_each_call(&emulated_falcon, CONTROL, faults[n], 0, firmware);
        check_each_call(&emulated_falcon, SEND, faults[n], 0, firmware);
        check_each_call(&emulated_falcon, SEND, faults[n], 1, firmware);
        if (faults[n] == VXS_BUSY) continue; /* receiving is never that */
        for (int k = 0; k < 3; k++) check_each_call(emulated_kinds[k], RECEIVE, faults[n], 1, NULL);
        check_each_call(&emulated_falcon, RECEIVE, faults[n], 0, firmware);
    }
    /* Lost as it waits for what was said before to go out. */
    vxs_hardware_config config = good_config();
    begin(&emulated_hvlink);
    wire.fails[SEND] = wire.fails[RECEIVE] = 1;
    wire.fails_until[SEND] = 1 << 30;
    wire.fails_until[RECEIVE] = 1 << 30;
    wire.result[SEND] = VXS_BUSY;
    wire.result[RECEIVE] = VXS_LOST;
    CHECK_INT(open_as(&config), VXS_LOST);

    /* A Falcon on a wire that has no such requests, a tty say, is none. */
    begin(&emulated_falcon);
    vxsi_wire tty = {&plain, &e};
    CHECK_INT(vxsi_link_open(&host, &vxsi_falcon_driver, &config, &tty), VXS_UNSUPPORTED);
    CHECK(e.is_closed);
}

/* The firmware's echo among bytes that nobody expects, and after a false start. */
static void check_echo(const char *firmware)
{
    static const uint8_t junk[] = {0x00, 0x55, 0xAA};
    vxs_hardware_config config = good_config();
    vxs_device_state state;
    config.firmware = firmware;
    begin(&emulated_falcon);
    e.has_firmware = 0;
    wire.before = wire.after = junk;
    wire.before_size = sizeof junk;
    wire.after_size = 2;
    CHECK_INT(open_as(&config), VXS_OK);
    CHECK(e.has_firmware);
    wire.before = NULL;
    for (int n = 0; n < 20; n++) emulated_run(&e, &host);
    CHECK_INT(exchange(&state), VXS_DEVICE_READY);
    vxs_device_close(&host.device);

    static const uint8_t half[] = {0x0A, 0x44, 0x55}; /* of the first answer, and then wrong */
    begin(&emulated_falcon);
    e.has_firmware = 0;
    wire.before = wire.after = half;
    wire.before_size = sizeof half;
    CHECK_INT(open_as(&config), VXS_OK);
    vxs_device_close(&host.device);
}

/* --- the drivers' own gates --- */

static const vxs_wrench push = {{3, -2, 1}, {0.1, 0.2, -0.3}};

static int motors_of_falcon(const uint8_t *bytes, int16_t motor[3])
{
    vxsi_falcon_stream stream = {.count = 0};
    vxsi_falcon_output output;
    for (int n = 0; n < VXSI_FALCON_PACKET; n++)
        if (vxsi_falcon_take(&stream, bytes[n]) == 1 && vxsi_falcon_decode_output(stream.bytes, &output)) {
            memcpy(motor, output.motor, sizeof output.motor);
            return 1;
        }
    return 0;
}

static void check_falcon(void)
{
    uint8_t bytes[VXSI_WIRE_MOST];
    int16_t motor[3], strong[3];
    vxs_hardware_config config = good_config();
    /* Nothing was measured: whoever arms it, no force. */
    begin(&emulated_falcon);
    host.config = config;
    CHECK_INT(vxsi_falcon_driver.make(&host, &push, 1, bytes), VXSI_FALCON_PACKET);
    CHECK(motors_of_falcon(bytes, motor) && motor[0] == 0 && motor[1] == 0 && motor[2] == 0);

    CHECK_INT(open_as(&config), VXS_OK);
    CHECK_INT(vxsi_falcon_driver.make(&host, &push, 1, bytes), VXSI_FALCON_PACKET);
    CHECK(motors_of_falcon(bytes, motor) && (motor[0] || motor[1] || motor[2]));
    CHECK_INT(vxsi_falcon_driver.make(&host, &push, 0, bytes), VXSI_FALCON_PACKET);
    CHECK(motors_of_falcon(bytes, strong) && strong[0] == 0 && strong[1] == 0 && strong[2] == 0);
    /* More than a motor's unit can say: all are cut by one factor, the direction stays. */
    host.config.units_per_nm = 1e7;
    CHECK_INT(vxsi_falcon_driver.make(&host, &push, 1, bytes), VXSI_FALCON_PACKET);
    CHECK(motors_of_falcon(bytes, strong));
    double factor = 0;
    for (int n = 0; n < 3; n++) factor = fmax(factor, fabs((double)strong[n]));
    CHECK_INT(factor, 4095);
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 3; i++) CHECK_NEAR(strong[n] * motor[i], strong[i] * motor[n], 4095 * 1.0);
    vxs_device_close(&host.device);

    /* Encoders that are no place of the tip's, of a device that says that it knows where it is. */
    begin(&emulated_falcon);
    CHECK_INT(open_as(&config), VXS_OK);
    vxs_device_state state = host.measured;
    vxsi_falcon_input input = {{32767, -32768, 32767}, 0, 7};
    bytes[0] = 1;
    bytes[1] = 0x60;
    vxsi_falcon_encode_input(&input, bytes + 2);
    CHECK_INT(vxsi_falcon_driver.take(&host, bytes, 2 + VXSI_FALCON_PACKET, &state), VXSI_LINK_MALFORMED);
    vxs_device_close(&host.device);
}

static void check_haply(void)
{
    uint8_t bytes[VXSI_WIRE_MOST], zero[VXSI_WIRE_MOST];
    float degrees[VXSI_HAPLY_PORTS] = {0};
    vxs_hardware_config config = good_config();
    begin(&emulated_haply);
    CHECK_INT(open_as(&config), VXS_OK);
    vxs_device_state state = host.measured;
    const vxs_wrench none = {{0, 0, 0}, {0, 0, 0}};
    size_t size = vxsi_haply_driver.make(&host, &none, 0, zero);
    CHECK(vxsi_haply_driver.make(&host, &push, 1, bytes) == size && memcmp(bytes, zero, size) != 0);

    /* Both elbows at one point: the tip may be anywhere. */
    const double half = acos(0.2) / 0.017453292519943295; /* base / 2 = link cos */
    degrees[1] = (float)half;
    degrees[0] = (float)(180 - half);
    size = vxsi_haply_encode_state(&e.board, degrees, bytes);
    CHECK_INT(vxsi_haply_driver.take(&host, bytes, size, &state), VXSI_LINK_MALFORMED);
    /* No number: it is shown, so that the link sees it, and no force is made of it, armed or not. */
    degrees[0] = NAN;
    size = vxsi_haply_encode_state(&e.board, degrees, bytes);
    CHECK_INT(vxsi_haply_driver.take(&host, bytes, size, &state), VXSI_LINK_NEWS);
    CHECK(isnan(state.pose.position[0]));
    size = vxsi_haply_driver.make(&host, &push, 1, bytes);
    CHECK(memcmp(bytes, zero, size) == 0);
    vxs_device_close(&host.device);
}

/* --- hvlink --- */

static const struct {
    uint16_t major;
    uint8_t space, sensed, actuated;
    float force, torque;
    vxs_result result;
} talks[] = {{1, 0, 3, 3, 8, 0, VXS_OK},          {2, 0, 3, 3, 8, 0, VXS_UNSUPPORTED},
             {0, 0, 3, 3, 8, 0, VXS_UNSUPPORTED}, {1, VXS_HVLINK_JOINTS, 3, 3, 8, 0, VXS_UNSUPPORTED},
             {1, 0, 4, 3, 8, 0, VXS_UNSUPPORTED}, {1, 0, 6, 3, 8, 0, VXS_UNSUPPORTED},
             {1, 0, 8, 3, 8, 0, VXS_UNSUPPORTED}, {1, 0, 7, 6, 8, 1, VXS_OK},
             {1, 0, 7, 4, 8, 1, VXS_UNSUPPORTED}, {1, 0, 7, 7, 8, 1, VXS_UNSUPPORTED},
             {1, 0, 1, 0, 0, 0, VXS_OK},          {1, 0, 3, 3, 0, 0, VXS_PROTOCOL},
             {1, 0, 3, 3, -1, 0, VXS_PROTOCOL},   {1, 0, 3, 3, NAN, 0, VXS_PROTOCOL},
             {1, 0, 3, 3, 1e4f, 0, VXS_PROTOCOL}, {1, 0, 7, 6, 8, -1, VXS_PROTOCOL},
             {1, 0, 7, 6, 8, NAN, VXS_PROTOCOL},  {1, 0, 7, 6, 8, INFINITY, VXS_PROTOCOL}};

static void check_hvlink_caps(void)
{
    vxs_hardware_config config = good_config();
    for (size_t n = 0; n < sizeof talks / sizeof *talks; n++) {
        begin(&emulated_hvlink);
        vxs_hvlink_caps *caps = &e.hvlink.caps;
        caps->major = talks[n].major;
        caps->space = talks[n].space;
        caps->sensed = talks[n].sensed;
        caps->actuated = talks[n].actuated;
        caps->peak_force = talks[n].force;
        caps->peak_torque = talks[n].torque;
        CHECK_INT(open_as(&config), talks[n].result);
        if (talks[n].result != VXS_OK) continue;
        CHECK_INT(host.device.caps.dof_sensed, talks[n].sensed == 7 ? 63 : (1 << talks[n].sensed) - 1);
        CHECK_INT(host.device.caps.dof_actuated, (1 << talks[n].actuated) - 1);
        CHECK_INT(host.device.caps.has_motors, talks[n].actuated > 0);
        vxs_device_close(&host.device);
    }
}

/* Bytes of a STATE as this device would say it, to the driver. */
static uint32_t say(const vxs_hvlink_state *said, uint16_t sequence, vxs_device_state *state)
{
    vxs_hvlink_frame frame = {.sequence = sequence};
    uint8_t bytes[VXS_HVLINK_MAX_FRAME];
    vxs_hvlink_pack_state(said, &frame);
    size_t size = vxs_hvlink_encode(&frame, bytes, sizeof bytes);
    *state = host.measured;
    return vxsi_hvlink_driver.take(&host, bytes, size, state);
}

static uint8_t type_made(uint32_t arming, vxs_hvlink_command *command)
{
    uint8_t bytes[VXSI_WIRE_MOST];
    vxs_hvlink_stream stream = {.count = 0};
    vxs_hvlink_frame frame;
    size_t size = vxsi_hvlink_driver.make(&host, &push, arming, bytes);
    for (size_t n = 0; n < size; n++) vxs_hvlink_put(&stream, bytes[n]);
    if (size == 0 || !vxs_hvlink_take(&stream, &frame)) return 0;
    if (frame.type == VXS_HVLINK_CMD) CHECK(vxs_hvlink_unpack_command(&frame, command));
    return frame.type;
}

static void check_hvlink_states(void)
{
    vxs_hardware_config config = good_config();
    vxs_device_state state;
    vxs_hvlink_command command = {.ttl_ms = 0};
    begin(&emulated_hvlink);
    e.hvlink.caps.sensed = 7;
    e.hvlink.caps.actuated = 6;
    e.hvlink.caps.ttl_ms = 4;
    e.hvlink.caps.peak_torque = 1;
    CHECK_INT(open_as(&config), VXS_OK);
    vxs_hvlink_state said = {.state = VXS_HVLINK_READY,
                             .count = 7,
                             .has_velocity = 1,
                             .value = {0.1f, 0.2f, 0.3f, 0, 1, 0, 0},
                             .velocity = {1, 2, 3, 4, 5, 6, 7}};
    uint16_t at = 100;
    CHECK_INT(say(&said, at, &state), VXSI_LINK_NEWS);
    CHECK(state.velocity[2] == 3 && state.velocity_source == VXS_DEVICE_VELOCITY_MEASURED);
    CHECK(state.pose.orientation[1] == 1 && state.pose.orientation[0] == 0);
    CHECK_INT(say(&said, at, &state), 0); /* again: no news */
    uint8_t pong[VXS_HVLINK_MAX_FRAME];   /* that nobody asked for is no news and no fault */
    const vxs_hvlink_frame frame = {.type = VXS_HVLINK_PONG, .sequence = at};
    CHECK_INT(vxsi_hvlink_driver.take(&host, pong, vxs_hvlink_encode(&frame, pong, sizeof pong), &state), 0);
    said.count = 3;
    CHECK_INT(say(&said, ++at, &state), VXSI_LINK_MALFORMED); /* not what it said it has */
    said.count = 7;
    said.state = 9;
    CHECK_INT(say(&said, ++at, &state), VXSI_LINK_MALFORMED); /* breaks the specification */

    /* A fault by a number that is none, while it is armed: the protocol's. */
    static const uint8_t faults[][2] = {{0, VXS_DEVICE_FAULT_PROTOCOL},
                                        {200, VXS_DEVICE_FAULT_PROTOCOL},
                                        {VXS_DEVICE_FAULT_OVERRUN, VXS_DEVICE_FAULT_OVERRUN},
                                        {VXS_DEVICE_FAULT_WATCHDOG, VXS_DEVICE_FAULT_WATCHDOG}};
    uint32_t arming = 1;
    for (int n = 0; n < 4; n++, arming++) {
        said.state = VXS_HVLINK_READY;
        CHECK_INT(say(&said, ++at, &state), VXSI_LINK_NEWS);
        CHECK_INT(type_made(arming, &command), VXS_HVLINK_ARM);
        said.state = VXS_HVLINK_ARMED;
        say(&said, ++at, &state);
        CHECK_INT(state.state, VXS_DEVICE_ARMED);
        CHECK_INT(type_made(arming, &command), VXS_HVLINK_CMD);
        CHECK(command.ttl_ms == 4 && command.count == 6); /* never longer than the device takes */
        CHECK(command.value[2] == 1 && command.value[3] == 0.1f && command.value[5] == -0.3f);
        said.state = VXS_HVLINK_FAULTED;
        said.fault = faults[n][0];
        say(&said, ++at, &state);
        CHECK(state.state == VXS_DEVICE_FAULT && state.fault == faults[n][1]);
        /* Armed anew over its fault: it must forget that first. */
        CHECK_INT(type_made(arming + 10, &command), VXS_HVLINK_DISARM);
        CHECK_INT(type_made(0, &command), VXS_HVLINK_DISARM);
        said.fault = 0;
    }
    /* It hears and never arms: after 200 times of asking somebody holds its switch. */
    said.state = VXS_HVLINK_READY;
    CHECK_INT(say(&said, ++at, &state), VXSI_LINK_NEWS);
    CHECK_INT(type_made(0, &command), 0);
    for (int n = 0; n < 200; n++) {
        CHECK_INT(type_made(99, &command), VXS_HVLINK_ARM);
        say(&said, ++at, &state);
        CHECK_INT(state.state, VXS_DEVICE_READY);
    }
    CHECK_INT(type_made(99, &command), VXS_HVLINK_ARM);
    say(&said, ++at, &state);
    CHECK(state.state == VXS_DEVICE_FAULT && state.fault == VXS_DEVICE_FAULT_DEADMAN);
    vxs_device_close(&host.device);
}

int main(void)
{
    char firmware[] = "test_link_faults_XXXXXX";
    uint8_t blob[200];
    int file = mkstemp(firmware);
    for (size_t n = 0; n < sizeof blob; n++) blob[n] = (uint8_t)(n * 37 + 11);
    CHECK(file >= 0);
    FILE *out = fdopen(file, "wb");
    CHECK(out && fwrite(blob, 1, sizeof blob, out) == sizeof blob && fclose(out) == 0);
    check_opening(firmware);
    CHECK(truncate(firmware, 40) ==
          0); /* so that an echo and what is about it are one packet of the chip's */
    check_echo(firmware);
    CHECK(remove(firmware) == 0);
    check_falcon();
    check_haply();
    check_hvlink_caps();
    check_hvlink_states();
    return 0;
}
