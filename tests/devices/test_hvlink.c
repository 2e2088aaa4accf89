/* SPDX-License-Identifier: MIT
 *
 * hvlink: golden frames of formats/hvlink.md both ways, damaged and broken streams, and what a device must
 * do.
 */
#include "check.h"
#include "voxshell/hvlink.h"

static size_t from_text(const char *text, uint8_t *bytes)
{
    size_t size = 0;
    for (unsigned value; *text; text += text[2] ? 3 : 2) {
        CHECK(sscanf(text, "%2x", &value) == 1);
        bytes[size++] = (uint8_t)value;
    }
    return size;
}

/* The bytes are a frame; and the frame, those bytes. */
static vxs_hvlink_frame golden(const char *text)
{
    uint8_t bytes[VXS_HVLINK_MAX_FRAME], again[VXS_HVLINK_MAX_FRAME];
    size_t size = from_text(text, bytes);
    vxs_hvlink_stream stream = {.count = 0};
    vxs_hvlink_frame frame;
    for (size_t n = 0; n < size; n++) {
        CHECK_INT(vxs_hvlink_take(&stream, &frame), 0);
        vxs_hvlink_put(&stream, bytes[n]);
    }
    CHECK_INT(vxs_hvlink_take(&stream, &frame), 1);
    CHECK_INT(vxs_hvlink_take(&stream, &frame), 0);
    CHECK_INT(stream.dropped, 0);
    CHECK_INT(vxs_hvlink_encode(&frame, again, size), size);
    CHECK(memcmp(bytes, again, size) == 0);
    CHECK_INT(vxs_hvlink_encode(&frame, again, size - 1), 0);
    return frame;
}

static void check_packed(const vxs_hvlink_frame *packed, const vxs_hvlink_frame *frame)
{
    CHECK_INT(packed->type, frame->type);
    CHECK_INT(packed->size, frame->size);
    CHECK(memcmp(packed->payload, frame->payload, frame->size) == 0);
}

static void check_golden(void)
{
    vxs_hvlink_frame frame, packed;
    CHECK_INT(vxs_hvlink_crc((const uint8_t *)"123456789", 9), 0xE3069283);

    frame = golden("A5 5A 04 01 00 00 E8 03 00 00 01 00 00 00 A9 F1 AC 7D");
    CHECK_INT(frame.time_us, 1000);
    vxs_hvlink_pack_hello(&packed);
    check_packed(&packed, &frame);

    frame = golden("A5 5A 04 02 01 00 D0 07 00 00 78 56 34 12 14 B5 18 43");
    uint32_t session;
    CHECK(vxs_hvlink_unpack_arm(&frame, &session) && session == 0x12345678);
    vxs_hvlink_pack_arm(session, &packed);
    check_packed(&packed, &frame);

    frame = golden("A5 5A 00 03 02 00 B8 0B 00 00 C8 96 7B A7");
    CHECK(frame.type == VXS_HVLINK_DISARM && frame.size == 0);

    frame =
        golden("A5 5A 10 04 03 00 A0 0F 00 00 0A 00 03 00 00 00 00 3F 00 00 A0 BF 00 00 00 40 98 0B 0B DC");
    vxs_hvlink_command command;
    CHECK(vxs_hvlink_unpack_command(&frame, &command));
    CHECK(frame.sequence == 3 && command.ttl_ms == 10 && command.count == 3 && command.value[1] == -1.25f);
    vxs_hvlink_pack_command(&command, &packed);
    check_packed(&packed, &frame);

    golden("A5 5A 08 05 04 00 88 13 00 00 00 01 02 03 04 05 06 07 53 23 FB C2");
    golden("A5 5A 08 85 0A 00 64 00 00 00 00 01 02 03 04 05 06 07 DF 03 14 8B");

    frame = golden("A5 5A 26 81 00 00 07 00 00 00 01 00 00 00 78 56 34 12 00 03 03 00 E8 03 0A 00 00 00 80 "
                   "40 00 00 00 00 AC "
                   "C5 27 37 01 04 6B 6E 6F 62 02 02 41 37 4E B6 4B 63");
    vxs_hvlink_caps caps;
    CHECK(vxs_hvlink_unpack_caps(&frame, &caps));
    CHECK(caps.session == 0x12345678 && caps.sensed == 3 && caps.rate_hz == 1000 && caps.peak_force == 4);
    CHECK_TEXT(caps.name, "knob");
    CHECK_TEXT(caps.serial, "A7");
    vxs_hvlink_pack_caps(&caps, &packed);
    check_packed(&packed, &frame);

    frame = golden("A5 5A 24 82 FF FF FF FF FF FF 02 00 03 01 05 00 00 00 03 00 01 00 0A D7 23 3C 0A D7 A3 "
                   "BC 8F C2 F5 3C CD "
                   "CC CC 3D 00 00 00 00 00 00 00 BF 40 29 71 7B");
    vxs_hvlink_state state;
    CHECK(vxs_hvlink_unpack_state(&frame, &state));
    CHECK(frame.sequence == 0xFFFF && frame.time_us == 0xFFFFFFFF && state.state == VXS_HVLINK_ARMED);
    CHECK(state.buttons == 5 && state.value[2] == 0.03f && state.velocity[2] == -0.5f);
    vxs_hvlink_pack_state(&state, &packed);
    check_packed(&packed, &frame);

    frame = golden("A5 5A 01 83 09 00 63 00 00 00 03 84 E2 2A F1");
    uint8_t fault;
    CHECK(vxs_hvlink_unpack_fault(&frame, &fault) && fault == 3);
    vxs_hvlink_pack_fault(fault, &packed);
    check_packed(&packed, &frame);
    CHECK(!vxs_hvlink_unpack_state(&frame, &state) && !vxs_hvlink_unpack_caps(&frame, &caps));
}

/* Any one byte of a frame damaged: it is lost, what follows is not. Cut anywhere: the same. */
static void check_damage(void)
{
    uint8_t bytes[3 * VXS_HVLINK_MAX_FRAME];
    vxs_hvlink_command command = {.ttl_ms = 5, .count = 8};
    vxs_hvlink_frame frame = {.sequence = 7}, taken;
    for (int n = 0; n < 8; n++) command.value[n] = (float)n;
    vxs_hvlink_pack_command(&command, &frame);
    size_t size = vxs_hvlink_encode(&frame, bytes, sizeof bytes);
    memcpy(bytes + size, bytes, size);
    memcpy(bytes + 2 * size, bytes, size);
    for (size_t at = 0; at < size; at++) {
        for (int bit = 0; bit < 8; bit++) {
            vxs_hvlink_stream stream = {.count = 0};
            int taken_count = 0;
            for (size_t n = 0; n < 3 * size; n++) {
                vxs_hvlink_put(&stream, (uint8_t)(n == at ? bytes[n] ^ 1 << bit : bytes[n]));
                while (vxs_hvlink_take(&stream, &taken)) taken_count++;
            }
            /* A size that grew may swallow the second frame until the third completes it: nothing is lost for
             * good. */
            for (int n = 0; n < VXS_HVLINK_MAX_FRAME; n++)
                vxs_hvlink_put(&stream, 0), taken_count += vxs_hvlink_take(&stream, &taken);
            CHECK_INT(taken_count, 2);
        }
        vxs_hvlink_stream stream = {.count = 0};
        int taken_count = 0;
        for (size_t n = at; n < 3 * size; n++) {
            vxs_hvlink_put(&stream, bytes[n]);
            while (vxs_hvlink_take(&stream, &taken)) taken_count++;
        }
        CHECK_INT(taken_count, at == 0 ? 3 : 2);
    }
}

static vxs_hvlink_device device;
static uint8_t reply[VXS_HVLINK_MAX_FRAME];
static uint16_t next_sequence;

static size_t tell(vxs_hvlink_frame *frame, uint32_t now_us)
{
    uint8_t bytes[VXS_HVLINK_MAX_FRAME];
    size_t size = vxs_hvlink_encode(frame, bytes, sizeof bytes), answer = 0;
    for (size_t n = 0; n < size; n++) answer = vxs_hvlink_device_receive(&device, bytes[n], now_us, reply);
    return answer;
}

static void command(float force, uint16_t ttl_ms, uint16_t sequence, uint32_t now_us)
{
    vxs_hvlink_command wanted = {.ttl_ms = ttl_ms, .count = 1, .value = {force}};
    vxs_hvlink_frame frame = {.sequence = sequence};
    vxs_hvlink_pack_command(&wanted, &frame);
    tell(&frame, now_us);
}

static float output(uint32_t now_us)
{
    float value[VXS_HVLINK_VALUES];
    vxs_hvlink_device_output(&device, now_us, value);
    return value[0];
}

static void arm(uint32_t session, uint32_t now_us)
{
    vxs_hvlink_frame frame = {.sequence = next_sequence++};
    vxs_hvlink_pack_arm(session, &frame);
    tell(&frame, now_us);
}

static void disarm(void)
{
    vxs_hvlink_frame frame = {.type = VXS_HVLINK_DISARM};
    tell(&frame, 0);
}

static void check_device(void)
{
    vxs_hvlink_caps caps = {
        .session = 42, .sensed = 1, .actuated = 1, .rate_hz = 1000, .ttl_ms = 10, .name = "knob"};
    vxs_hvlink_device_init(&device, &caps);
    vxs_hvlink_frame frame = {.sequence = 0};
    vxs_hvlink_pack_hello(&frame);
    CHECK(tell(&frame, 5) > 0 && reply[3] == VXS_HVLINK_CAPS);

    command(1, 10, 1, 0);
    CHECK(output(0) == 0); /* not armed */
    arm(41, 0);
    command(1, 10, 2, 0);
    CHECK(output(0) == 0); /* another session: a device that was plugged in again */
    arm(42, 0);
    CHECK(output(0) == 0); /* nothing from before arming acts */
    command(1, 10, 65535, 1000);
    CHECK(output(1000) == 1 && output(10999) == 1 && output(11000) == 0); /* ttl */
    command(2, 10, 0, 20000);                                             /* ahead, through the wrap */
    CHECK(output(20000) == 2);
    command(3, 10, 0, 21000);     /* doubled */
    command(4, 10, 65535, 21000); /* late */
    CHECK(output(21000) == 2);
    command(5, 60000, 1, 22000); /* no longer than the device's own */
    CHECK(output(22000) == 5 && output(31999) == 5 && output(32000) == 0);
    CHECK(output(122000) == 0 && device.state == VXS_HVLINK_ARMED);
    CHECK(output(122001) == 0 && device.state == VXS_HVLINK_FAULTED && device.fault == 3);
    command(1, 10, 2, 130000);
    arm(42, 130000);
    command(1, 10, 3, 130000);
    CHECK(output(130000) == 0); /* from READY only */
    disarm();
    command(1, 10, 4, 130000);
    CHECK(output(130000) == 0); /* never by itself */
    arm(42, 131000);
    command(1, 10, 5, 131000);
    CHECK(output(131000) == 1);
    command(NAN, 10, 6, 131000);
    CHECK(output(131000) == 0 && device.state == VXS_HVLINK_FAULTED && device.fault == 4);
    disarm();
    arm(42, 0xFFFFFFF0u);
    command(1, 10, 7, 0xFFFFFFF0u);
    CHECK(output(5) == 1); /* the clock wraps */

    float value = 0.25f;
    size_t size = vxs_hvlink_device_state(&device, &value, NULL, 1, 5, reply);
    vxs_hvlink_stream stream = {.count = 0};
    for (size_t n = 0; n < size; n++) vxs_hvlink_put(&stream, reply[n]);
    vxs_hvlink_state state;
    CHECK(vxs_hvlink_take(&stream, &frame) && vxs_hvlink_unpack_state(&frame, &state));
    CHECK(state.state == VXS_HVLINK_ARMED && state.value[0] == 0.25f && state.command_sequence == 7);
    vxs_hvlink_device_fail(&device, 6);
    CHECK(output(5) == 0);
}

/* Structs that claim more than a frame holds, frames of another type, a stream that nobody reads. */
static void check_limits(void)
{
    uint8_t bytes[VXS_HVLINK_MAX_FRAME], fault = 9;
    uint32_t session = 9;
    float value[VXS_HVLINK_VALUES + 2], velocity[VXS_HVLINK_VALUES] = {1, 2, 3, 4, 5, 6, 7, 8};
    vxs_hvlink_stream stream = {.count = 0};
    vxs_hvlink_frame frame = {.type = VXS_HVLINK_PING, .size = VXS_HVLINK_MAX_PAYLOAD + 1}, taken;
    CHECK_INT(vxs_hvlink_encode(&frame, bytes, sizeof bytes), 0);
    frame.size = 0;
    CHECK(!vxs_hvlink_unpack_arm(&frame, &session) && !vxs_hvlink_unpack_fault(&frame, &fault));
    frame.type = VXS_HVLINK_FAULT;
    frame.size = 2;
    CHECK(!vxs_hvlink_unpack_fault(&frame, &fault) && session == 9 && fault == 9);
    vxs_hvlink_caps caps = {.session = 3, .sensed = 3, .actuated = 3, .rate_hz = 1000, .ttl_ms = 10}, heard;
    memset(caps.name, 'x', sizeof caps.name); /* without an end */
    vxs_hvlink_pack_caps(&caps, &frame);
    CHECK(vxs_hvlink_unpack_caps(&frame, &heard) && strlen(heard.name) == VXS_HVLINK_TEXT - 1);
    frame.size = VXS_HVLINK_MAX_PAYLOAD + 1;
    CHECK(!vxs_hvlink_unpack_caps(&frame, &heard));
    vxs_hvlink_command command = {.ttl_ms = 5, .count = 200};
    vxs_hvlink_pack_command(&command, &frame);
    CHECK(vxs_hvlink_unpack_command(&frame, &command) && command.count == VXS_HVLINK_VALUES);

    /* The newest bytes stay: the frame is whole, what was before it is counted. */
    vxs_hvlink_pack_hello(&frame);
    size_t size = vxs_hvlink_encode(&frame, bytes, sizeof bytes);
    for (int n = 0; n < 300; n++) vxs_hvlink_put(&stream, 0x11);
    for (size_t n = 0; n < size; n++) vxs_hvlink_put(&stream, bytes[n]);
    CHECK(vxs_hvlink_take(&stream, &taken) && taken.type == VXS_HVLINK_HELLO);
    CHECK_INT(stream.dropped, 300);

    /* A device with more values than there are, and one that does not know its place: DISARM does not give it one. */
    vxs_hvlink_device_init(&device, &caps);
    device.caps.sensed = device.caps.actuated = VXS_HVLINK_VALUES + 2;
    for (int n = 0; n < VXS_HVLINK_VALUES + 2; n++) value[n] = 7;
    vxs_hvlink_device_output(&device, 0, value);
    CHECK(value[VXS_HVLINK_VALUES - 1] == 0 && value[VXS_HVLINK_VALUES] == 7);
    vxs_hvlink_state state;
    size = vxs_hvlink_device_state(&device, value, velocity, 0, 0, bytes);
    for (size_t n = 0; n < size; n++) vxs_hvlink_put(&stream, bytes[n]);
    CHECK(vxs_hvlink_take(&stream, &taken) && vxs_hvlink_unpack_state(&taken, &state));
    CHECK(state.count == VXS_HVLINK_VALUES && state.has_velocity && state.velocity[7] == 8);
    device.state = VXS_HVLINK_UNCALIBRATED;
    frame.type = VXS_HVLINK_DISARM;
    frame.size = 0;
    tell(&frame, 0);
    CHECK_INT(device.state, VXS_HVLINK_UNCALIBRATED);
}

int main(void)
{
    check_golden();
    check_damage();
    check_device();
    check_limits();
    printf("a device takes %zu bytes\n", sizeof(vxs_hvlink_device));
    CHECK(sizeof(vxs_hvlink_device) <= 512);
    return 0;
}
