/* SPDX-License-Identifier: MIT */
#include "emulated.h"

#include "check.h"
#include "devices/falcon_kinematics.h"

enum { TURNS = 4 };
static const double degree = 0.017453292519943295;

static uint32_t random_bits(emulated *e)
{
    e->random ^= e->random << 13;
    e->random ^= e->random >> 7;
    e->random ^= e->random << 17;
    return (uint32_t)(e->random >> 40);
}

static int happens(emulated *e, uint32_t share)
{
    return share > 0 && (random_bits(e) & 0xFFFF) < share;
}

static void push(emulated *e, const uint8_t *bytes, size_t size, int64_t delay_ns)
{
    if (e->count == EMULATED_QUEUE || size > EMULATED_PACKET || size == 0) return;
    uint32_t at = (e->first + e->count++) % EMULATED_QUEUE;
    memcpy(e->queue[at].bytes, bytes, size);
    e->queue[at].size = size;
    e->queue[at].due_ns = e->now_ns + delay_ns;
}

/* From the device to the host, with what can happen on the way. status: of FTDI's, before each piece. */
static void say(emulated *e, const uint8_t *bytes, size_t size, int has_status)
{
    uint8_t packet[EMULATED_PACKET];
    const emulated_trouble *t = &e->trouble;
    if (e->is_silent || happens(e, t->lost)) return;
    int64_t delay = happens(e, t->delayed) ? 3000000 + (random_bits(e) & 0xFFFFF) : 300000;
    size_t cut = happens(e, t->split) ? 1 + random_bits(e) % size : size;
    for (size_t from = 0, to; from < size; from = to) {
        to = from == 0 ? cut : size;
        size_t head = has_status ? 2 : 0;
        packet[0] = 1;
        packet[1] = 0x60;
        memcpy(packet + head, bytes + from, to - from);
        if (happens(e, t->damaged))
            packet[head + random_bits(e) % (to - from)] ^= (uint8_t)(1 + random_bits(e) % 255);
        push(e, packet, head + to - from, delay);
        if (has_status && happens(e, t->split)) push(e, packet, 2, delay); /* an idle one */
    }
    if (happens(e, t->doubled)) say(e, bytes, size, has_status);
    if (happens(e, t->random)) {
        for (size_t n = 0; n < 40; n++) packet[n] = (uint8_t)random_bits(e);
        push(e, packet, 1 + random_bits(e) % 40, delay);
    }
}

/* Where the tip is to be said to be: it may be made to jump. */
static void shown(emulated *e, double place[3])
{
    memcpy(place, e->place, sizeof e->place);
    if (happens(e, e->trouble.jump)) place[0] += place[0] > 0 ? -0.03 : 0.03;
}

static void motor_force(emulated *e, const double force[3])
{
    memcpy(e->force, force, sizeof e->force);
    e->heard++;
    e->last_heard_ns = e->now_ns;
}

/* --- Falcon: an FTDI chip before a processor that wants firmware --- */

static void falcon_reply(emulated *e)
{
    vxsi_falcon_input input = {{0, 0, 0}, 0, e->is_homed ? 7 : 0};
    double place[3], angle[3];
    uint8_t bytes[VXSI_FALCON_PACKET];
    shown(e, place);
    place[2] += 0.12;
    CHECK(vxsi_falcon_inverse(place, angle, NULL));
    for (int n = 0; n < 3; n++)
        input.encoder[n] = e->is_homed ? vxsi_falcon_count(angle[n]) : (int16_t)(1000 * n);
    vxsi_falcon_encode_input(&input, bytes);
    say(e, bytes, sizeof bytes, 1);
}

/* F = J^T torque */
static void falcon_move(emulated *e, const vxsi_falcon_output *output)
{
    double place[3] = {e->place[0], e->place[1], e->place[2] + 0.12}, angle[3], jacobian[9],
           force[3] = {0, 0, 0};
    CHECK(vxsi_falcon_inverse(place, angle, jacobian));
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 3; i++) force[i] += jacobian[3 * n + i] * (output->motor[n] / -2300.0);
    motor_force(e, force);
}

static void falcon_hear(emulated *e, const uint8_t *bytes, size_t size)
{
    static const uint8_t who[] = {0x0A, 0x44, 0x2C, 0x0D}, ready[] = {0x41};
    vxsi_falcon_output output;
    if (!e->has_firmware) {
        if (e->baud == 0x4138 && size == 3 && bytes[0] == 0x0A) say(e, who, sizeof who, 1);
        if (e->baud != 0x15) return;
        if (e->uploaded == 0 && size == 1 && bytes[0] == 0x41) {
            say(e, ready, 1, 1);
            e->uploaded = 1;
        } else if (e->uploaded > 0) {
            uint8_t echo[EMULATED_PACKET];
            memcpy(echo, bytes, size);
            if (e->bad_uploads > 0) echo[0] ^= 1;
            e->uploaded += (uint32_t)size;
            say(e, echo, size, 1);
        }
        return;
    }
    for (size_t n = 0; n < size; n++) {
        if (vxsi_falcon_take(&e->stream, bytes[n]) != 1 ||
            !vxsi_falcon_decode_output(e->stream.bytes, &output))
            continue;
        falcon_move(e, &output);
        falcon_reply(e);
    }
}

static vxs_result falcon_control(void *self, uint8_t request, uint16_t value)
{
    emulated *e = self;
    e->calls++;
    if (e->trouble.unplug_at && e->calls >= e->trouble.unplug_at) return VXS_LOST;
    if (request == 3) {
        /* Firmware runs once all of it came and the speed is the usual one again. */
        if (value == 2 && e->uploaded > 1) {
            if (e->bad_uploads > 0)
                e->bad_uploads--;
            else
                e->has_firmware = 1;
        }
        if (value == 0x4138) {
            if (e->uploaded > 0 && e->bad_uploads > 0) e->bad_uploads--;
            e->uploaded = 0;
        }
        e->baud = value;
    }
    if (request == 0 && value == 1) e->count = 0;
    return VXS_OK;
}

static void falcon_sample(emulated *e)
{
    const uint8_t idle[2] = {1, 0x60};
    if (e->tick % 16 == 0) push(e, idle, 2, 0); /* the latency timer's */
}

/* --- Haply --- */

static void haply_hear(emulated *e, const uint8_t *bytes, size_t size)
{
    float torque[VXSI_HAPLY_PORTS] = {0}, degrees[VXSI_HAPLY_PORTS] = {0};
    uint8_t reply[VXSI_HAPLY_FRAME];
    if (vxsi_haply_decode(bytes, size, &e->board, &e->board, torque) != 2) return;
    double middle[2] = {e->pantograph.base / 2, (e->pantograph.near_link + e->pantograph.far_link) * 2 / 3};
    double plane[2] = {e->place[0] + middle[0], e->place[2] + middle[1]}, angle[2], jacobian[4], found[2],
           shown_at[3];
    CHECK(vxsi_pantograph_inverse(&e->pantograph, plane, angle) &&
          vxsi_pantograph_forward(&e->pantograph, angle, found, jacobian));
    /* J^T force = torque */
    double t[2] = {(double)torque[1], (double)torque[0]},
           det = jacobian[0] * jacobian[3] - jacobian[1] * jacobian[2];
    double force[3] = {(t[0] * jacobian[3] - t[1] * jacobian[2]) / det, 0,
                       (t[1] * jacobian[0] - t[0] * jacobian[1]) / det};
    motor_force(e, force);
    shown(e, shown_at);
    plane[0] = shown_at[0] + middle[0];
    plane[1] = shown_at[2] + middle[1];
    CHECK(vxsi_pantograph_inverse(&e->pantograph, plane, angle));
    degrees[0] = (float)(angle[1] / degree);
    degrees[1] = (float)(angle[0] / degree);
    if (happens(e, e->trouble.not_finite)) degrees[random_bits(e) % 2] = random_bits(e) % 2 ? NAN : INFINITY;
    say(e, reply, vxsi_haply_encode_state(&e->board, degrees, reply), 0);
}

static void nothing(emulated *e)
{
    (void)e;
}

/* --- hvlink: the device end that microcontrollers run --- */

static void hvlink_hear(emulated *e, const uint8_t *bytes, size_t size)
{
    uint8_t reply[VXS_HVLINK_MAX_FRAME];
    for (size_t n = 0; n < size; n++) {
        size_t answer = vxs_hvlink_device_receive(&e->hvlink, bytes[n], (uint32_t)(e->now_ns / 1000), reply);
        if (answer > 0) say(e, reply, answer, 0);
    }
}

static void hvlink_sample(emulated *e)
{
    uint8_t bytes[VXS_HVLINK_MAX_FRAME];
    float value[VXS_HVLINK_VALUES] = {0}, at[3];
    double force[3], place[3];
    vxs_hvlink_device_output(&e->hvlink, (uint32_t)(e->now_ns / 1000), value);
    for (int n = 0; n < 3; n++) force[n] = (double)value[n];
    motor_force(e, force);
    shown(e, place);
    for (int n = 0; n < 3; n++) at[n] = (float)place[n];
    if (happens(e, e->trouble.not_finite)) at[random_bits(e) % 3] = random_bits(e) % 2 ? NAN : -INFINITY;
    say(e, bytes, vxs_hvlink_device_state(&e->hvlink, at, NULL, 0, (uint32_t)(e->now_ns / 1000), bytes), 0);
}

/* --- SpaceMouse: two reports in turn each 8 ms while it is pushed, silence while it is not --- */

static void mouse_hear(emulated *e, const uint8_t *bytes, size_t size)
{
    (void)e, (void)bytes, (void)size;
}

static void mouse_sample(emulated *e)
{
    uint8_t report[VXSI_SPACEMOUSE_REPORT];
    if (e->tick % 8 != 0) return;
    int kind = e->tick % 16 == 0 ? VXSI_SPACEMOUSE_PLACE : VXSI_SPACEMOUSE_TURN;
    say(e, report, vxsi_spacemouse_encode(&e->axes, kind, report), 0);
}

const emulated_kind emulated_falcon = {"falcon", &vxsi_falcon_driver, falcon_hear, falcon_sample, 1};
const emulated_kind emulated_haply = {"haply", &vxsi_haply_driver, haply_hear, nothing, 1};
const emulated_kind emulated_hvlink = {"hvlink", &vxsi_hvlink_driver, hvlink_hear, hvlink_sample, 1};
const emulated_kind emulated_spacemouse = {"spacemouse", &vxsi_spacemouse_driver, mouse_hear, mouse_sample,
                                           0};
const emulated_kind *const emulated_kinds[4] = {&emulated_hvlink, &emulated_haply, &emulated_falcon,
                                                &emulated_spacemouse};

/* --- the wire --- */

static int is_unplugged(emulated *e)
{
    e->calls++;
    return e->trouble.unplug_at && e->calls >= e->trouble.unplug_at;
}

static vxs_result wire_send(void *self, const uint8_t *bytes, size_t size)
{
    emulated *e = self;
    uint8_t copy[VXSI_WIRE_MOST];
    CHECK(!e->is_closed && size > 0 && size <= sizeof copy);
    if (is_unplugged(e)) return VXS_LOST;
    if (happens(e, e->trouble.lost)) return happens(e, 32768) ? VXS_OK : VXS_BUSY;
    memcpy(copy, bytes, size);
    if (e->kind == &emulated_hvlink && happens(e, e->trouble.damaged)) copy[random_bits(e) % size] ^= 0x10;
    e->kind->hear(e, copy, size);
    if (happens(e, e->trouble.doubled)) e->kind->hear(e, copy, size);
    return VXS_OK;
}

/* Who waits lets time pass. */
static int32_t wire_receive(void *self, uint8_t *bytes, size_t most, int64_t wait_ns)
{
    emulated *e = self;
    CHECK(!e->is_closed);
    if (is_unplugged(e)) return VXS_LOST;
    for (int64_t end = e->now_ns + wait_ns;; e->now_ns += 100000) {
        if (e->count > 0 && e->queue[e->first].due_ns <= e->now_ns) {
            size_t size = e->queue[e->first].size;
            CHECK(size <= most);
            memcpy(bytes, e->queue[e->first].bytes, size);
            e->first = (e->first + 1) % EMULATED_QUEUE;
            e->count--;
            return (int32_t)size;
        }
        if (e->now_ns >= end) return 0;
    }
}

static void wire_close(void *self)
{
    emulated *e = self;
    CHECK(!e->is_closed);
    e->is_closed = 1;
}

vxsi_wire emulated_wire(emulated *e)
{
    static const vxsi_wire_ops plain = {
        .name = "emulated", .send = wire_send, .receive = wire_receive, .close = wire_close};
    static const vxsi_wire_ops ftdi = {.name = "emulated",
                                       .control = falcon_control,
                                       .send = wire_send,
                                       .receive = wire_receive,
                                       .close = wire_close};
    return (vxsi_wire){e->kind == &emulated_falcon ? &ftdi : &plain, e};
}

int64_t emulated_now(void *e)
{
    return ((emulated *)e)->now_ns;
}

void emulated_init(emulated *e, const emulated_kind *kind)
{
    emulated_init_held(e, kind, vxs_simulated_arm_named("hand"),
                       0); /* what the motors do is what the hand holds */
}

void emulated_init_held(emulated *e, const emulated_kind *kind, const vxs_simulated_arm *arm, double friction)
{
    static const vxs_hvlink_caps caps = {.session = 77,
                                         .sensed = 3,
                                         .actuated = 3,
                                         .rate_hz = 1000,
                                         .ttl_ms = 10,
                                         .peak_force = 8,
                                         .name = "emulated"};
    vxs_simulated_config config;
    memset(e, 0, sizeof *e);
    e->kind = kind;
    e->now_ns = 1000000000;
    e->random = 0x9E3779B97F4A7C15u;
    e->has_firmware = e->is_homed = 1;
    vxs_hvlink_device_init(&e->hvlink, &caps);
    e->pantograph = (vxsi_pantograph){0.05, 0.07, 0.02};
    e->board = (vxsi_haply_setup){.device = 5, .motor_ports = 3, .encoder_ports = 3};
    vxs_simulated_config_default(&config, vxs_simulated_profile_named("falcon"));
    config.arm = *arm;
    config.profile.friction = friction;
    CHECK_INT(vxs_simulated_open(e->memory, sizeof e->memory, &config, &e->tip), VXS_OK);
    CHECK_INT(vxs_device_arm(e->tip), VXS_OK);
}

vxs_result emulated_link_as(emulated *e, vxsi_link *link, const vxs_hardware_config *config)
{
    vxsi_wire wire = emulated_wire(e);
    link->now = emulated_now;
    link->user = e;
    return vxsi_link_open(link, e->kind->driver, config, &wire);
}

vxs_result emulated_link(emulated *e, vxsi_link *link)
{
    vxs_hardware_config config;
    vxs_hardware_config_default(&config);
    config.is_in_place = 1;
    return emulated_link_as(e, link, &config);
}

void emulated_run(emulated *e, vxsi_link *link)
{
    for (int n = 0; n < TURNS; n++) {
        e->now_ns += 1000000 / TURNS;
        if (link) vxsi_link_step(link, 0);
    }
    vxs_device_command push_back = {.hold_ns = INT64_MAX, .expires_ns = INT64_MAX};
    vxs_device_state state;
    memcpy(push_back.wrench.force, e->force, sizeof e->force);
    vxs_simulated_hand(e->tip, e->hand, NULL);
    vxs_device_exchange(e->tip, &push_back, &state, NULL);
    memcpy(e->place, state.pose.position, sizeof e->place);
    e->tick++;
    e->kind->sample(e);
}

double emulated_force(const emulated *e)
{
    return sqrt(e->force[0] * e->force[0] + e->force[1] * e->force[1] + e->force[2] * e->force[2]);
}
