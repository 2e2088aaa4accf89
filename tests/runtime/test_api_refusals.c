/* SPDX-License-Identifier: MIT
 *
 * What set-up says of arguments that the headers do not allow: nothing there, memory that is misaligned or too small,
 * a struct of another size, each field out of its range. Nothing is touched, and the same call with the good argument goes.
 */
#include "servo_bench.h"
#include "voxshell/live.h"
#include "voxshell/plan.h"
#include "voxshell/recorder.h"
#include "voxshell/replay.h"
#include "voxshell/servo_thread.h"

enum { ROOM = 1 << 22 };
static uint8_t room[ROOM] __attribute__((aligned(64)));

/* `change` makes of a copy of a good config a bad one. */
#define REFUSES(good, expected, call, change)                                                                \
    do {                                                                                                     \
        config = (good);                                                                                     \
        change;                                                                                              \
        CHECK_INT(call, expected);                                                                           \
    } while (0)

static void check_servo(servo_bench *b)
{
    vxs_servo_config config;
    vxs_servo *servo = NULL;
    const vxs_contact_static good = *b->servo_config.statics, no_map = {NULL, NULL};
    const vxs_pose broken = {{0, 0, 0}, {0, 0, 0, 0}}, lost = {{NAN, 0, 0}, {1, 0, 0, 0}};
    const vxs_contact_static broken_place = {good.map, &broken}, lost_place = {good.map, &lost};
#define SERVO(expected, change)                                                                              \
    REFUSES(b->servo_config, expected, vxs_servo_init(room, ROOM, &config, &servo), change)
    CHECK_INT(vxs_servo_init(room, ROOM, NULL, &servo), VXS_PARAM);
    SERVO(VXS_CONFIG, config.struct_size--);
    SERVO(VXS_PARAM, config.statics = NULL);
    SERVO(VXS_PARAM, config.static_count = 0);
    SERVO(VXS_PARAM, config.static_count = VXS_CONTACT_MAX_STATICS + 1);
    SERVO(VXS_PARAM, config.shell = NULL);
    SERVO(VXS_PARAM, config.statics = &no_map);
    SERVO(VXS_PARAM, config.statics = &broken_place);
    SERVO(VXS_PARAM, config.statics = &lost_place);
    SERVO(VXS_PARAM, config.mount = broken);
    SERVO(VXS_PARAM, config.grip = lost);
    const double bad[] = {0, -1, NAN, INFINITY};
    for (int n = 0; n < 4; n++) {
        SERVO(VXS_PARAM, config.scale = bad[n]);
        SERVO(VXS_PARAM, config.max_force = bad[n]);
        SERVO(VXS_PARAM, config.max_torque = bad[n]);
        if (n < 3) SERVO(VXS_PARAM, config.max_speed = bad[n]);
        if (n > 0) SERVO(VXS_PARAM, config.hold_time = bad[n]);
        SERVO(VXS_PARAM, config.decay_time = bad[n]);
    }
    SERVO(VXS_PARAM, config.hold_time = 3601);
    SERVO(VXS_PARAM, config.decay_time = 1e-7);
    SERVO(VXS_CHANNEL, config.contact.field = VXS_CONTACT_LAYERS);
    SERVO(VXS_SAMPLE_TIME, config.coupling.sample_time = 1);
    CHECK_INT(vxs_servo_init(NULL, ROOM, &b->servo_config, &servo), VXS_PARAM);
    CHECK_INT(vxs_servo_init(room, ROOM, &b->servo_config, NULL), VXS_PARAM);
    CHECK_INT(vxs_servo_init(room + 1, ROOM - 1, &b->servo_config, &servo), VXS_BUFFER);
    CHECK_INT(vxs_servo_init(room, vxs_servo_memory(&b->servo_config) - 1, &b->servo_config, &servo),
              VXS_BUFFER);
    CHECK(!servo && vxs_servo_memory(NULL) == 0);
    config = b->servo_config;
    config.shell = NULL;
    CHECK(vxs_servo_memory(&config) == 0);
    config.shell = b->servo_config.shell;
    config.static_count = VXS_CONTACT_MAX_STATICS + 1;
    CHECK(vxs_servo_memory(&config) == 0);
    CHECK_INT(vxs_servo_init(room, ROOM, &b->servo_config, &servo), VXS_OK);

    const vxs_device_caps caps = {0};
    vxs_servo_stage stage;
    CHECK_INT(vxs_servo_may_drive(NULL, &caps), VXS_PARAM);
    CHECK_INT(vxs_servo_may_drive(servo, NULL), VXS_PARAM);
    CHECK_INT(vxs_servo_stage_at(0, NULL), VXS_PARAM);
    CHECK_INT(vxs_servo_stage_at(1000, &stage), VXS_PARAM);
    CHECK_INT(vxs_servo_stage_at(0, &stage), VXS_OK);
}

static void check_thread(servo_bench *b)
{
    vxs_servo_thread_config good, config;
    vxs_servo_thread *thread = NULL;
    vxs_servo_thread_config_default(&good);
    good.device = b->device;
    good.servo = b->servo;
#define THREAD(expected, change)                                                                             \
    REFUSES(good, expected, vxs_servo_thread_start(room, ROOM, &config, &thread), change)
    THREAD(VXS_CONFIG, config.struct_size++);
    THREAD(VXS_PARAM, config.device = NULL);
    THREAD(VXS_PARAM, config.servo = NULL);
    THREAD(VXS_PARAM, config.rate_hz = 99);
    THREAD(VXS_PARAM, config.rate_hz = 10001);
    THREAD(VXS_PARAM, config.rate_hz = NAN);
    THREAD(VXS_PARAM, config.priority = -1);
    THREAD(VXS_PARAM, config.priority = 100);
    CHECK_INT(vxs_servo_thread_start(room, ROOM, NULL, &thread), VXS_PARAM);
    CHECK_INT(vxs_servo_thread_start(NULL, ROOM, &good, &thread), VXS_PARAM);
    CHECK_INT(vxs_servo_thread_start(room, ROOM, &good, NULL), VXS_PARAM);
    CHECK_INT(vxs_servo_thread_start(room + 8, ROOM - 8, &good, &thread), VXS_BUFFER);
    CHECK_INT(vxs_servo_thread_start(room, vxs_servo_thread_memory() - 1, &good, &thread), VXS_BUFFER);
    CHECK(!thread);
}

static void check_contact(const servo_bench *b)
{
    vxs_contact_config good, config;
    vxs_contact_config_default(&good);
#define CONTACT(expected, change) REFUSES(good, expected, vxs_contact_config_check(&config), change)
    CONTACT(VXS_OK, (void)0);
    CONTACT(VXS_CONFIG, config.struct_size = 0);
    CONTACT(VXS_PARAM, config.law = 0);
    CONTACT(VXS_PARAM, config.law = 1000);
    CONTACT(VXS_PARAM, config.field = 0);
    CONTACT(VXS_PARAM, config.field = 1000);
    CONTACT(VXS_PARAM, config.weighting = 0);
    CONTACT(VXS_PARAM, config.weighting = 1000);
    CONTACT(VXS_PARAM, (config.weighting = VXS_CONTACT_COUNT, config.most_points = 5));
    CONTACT(VXS_PARAM, config.reference[1] = NAN);
    CONTACT(VXS_PARAM, config.most_stiffness = -1);
    CONTACT(VXS_PARAM, config.most_stiffness = INFINITY);
    CONTACT(VXS_PARAM, config.stiffness = 0);
    CONTACT(VXS_PARAM, config.stiffness = INFINITY);
    CHECK_INT(vxs_contact_config_check(NULL), VXS_PARAM);
    CHECK(!vxs_contact_has_field(b->servo_config.statics->map, 77));

    vxs_contact *contact = NULL;
    const vxs_pointshell *shell = b->servo_config.shell;
    CHECK(vxs_contact_memory(NULL, 1) == 0 && vxs_contact_levels_memory(NULL) == 0);
    CHECK_INT(vxs_contact_init(NULL, ROOM, shell, 1, &contact), VXS_PARAM);
    CHECK_INT(vxs_contact_init(room, ROOM, NULL, 1, &contact), VXS_PARAM);
    CHECK_INT(vxs_contact_init(room, ROOM, shell, 1, NULL), VXS_PARAM);
    CHECK_INT(vxs_contact_init(room, ROOM, shell, 0, &contact), VXS_PARAM);
    CHECK_INT(vxs_contact_init(room, ROOM, shell, VXS_CONTACT_MAX_STATICS + 1, &contact), VXS_PARAM);
    CHECK_INT(vxs_contact_init(room + 1, ROOM - 1, shell, 1, &contact), VXS_BUFFER);
    CHECK_INT(vxs_contact_init(room, 16, shell, 1, &contact), VXS_BUFFER);
    CHECK(!contact);
    CHECK_INT(vxs_contact_init(room, ROOM / 2, shell, 1, &contact), VXS_OK);
    CHECK_INT(vxs_contact_use(NULL, VXS_CONTACT_SCALAR), VXS_PARAM);
    CHECK_INT(vxs_contact_use(contact, 1000), VXS_PARAM);
    CHECK_INT(vxs_contact_cull(NULL, VXS_CONTACT_BRUTE), VXS_PARAM);
    CHECK_INT(vxs_contact_cull(contact, VXS_CONTACT_CHECKED + 1), VXS_PARAM);
    CHECK_INT(vxs_contact_add_levels(NULL, room + ROOM / 2, ROOM / 2), VXS_PARAM);
    CHECK_INT(vxs_contact_add_levels(contact, NULL, ROOM / 2), VXS_PARAM);
    CHECK_INT(vxs_contact_add_levels(contact, room + ROOM / 2 + 8, ROOM / 2 - 8), VXS_BUFFER);
    CHECK_INT(vxs_contact_add_levels(contact, room + ROOM / 2, 64), VXS_BUFFER);

    /* What an evaluation is not made for gives no force, and says so. */
    const vxs_contact_static statics[2] = {*b->servo_config.statics, *b->servo_config.statics};
    const vxs_pose deep = vxs_pose_identity(), nowhere = {{0, 0, 0}, {0, 0, 0, 0}};
    vxs_contact_result result;
#define INVALID(count, pose, change)                                                                         \
    do {                                                                                                     \
        config = good;                                                                                       \
        change;                                                                                              \
        CHECK_INT(vxs_contact_evaluate(contact, statics, count, pose, &config, &result),                     \
                  VXS_CONTACT_INVALID);                                                                      \
        CHECK(result.points == 0 && result.wrench.force[1] == 0);                                            \
    } while (0)
    good.weighting = VXS_CONTACT_AREA;
    CHECK(!(vxs_contact_evaluate(contact, statics, 1, &deep, &good, &result) & VXS_CONTACT_INVALID));
    CHECK(result.points > 0);
    INVALID(1, &deep, config.law = 1000);
    INVALID(2, &deep, (void)0); /* one static was asked for */
    INVALID(1, &deep, config.most_points = 100);
    INVALID(1, &nowhere, (void)0);
    INVALID(1, &deep, config.field = VXS_CONTACT_LAYERS);
    /* Numbers too large for a double: none of them is given out, and no load. */
    static vxs_contact_loads loads;
    config = good;
    config.stiffness = 1.7e308;
    config.reference[0] = config.reference[2] = 1e250;
    for (int n = 0; n < 2; n++) {
        config.loads = n ? &loads : NULL;
        CHECK(vxs_contact_evaluate(contact, statics, 1, &deep, &config, &result) & VXS_CONTACT_INVALID);
        for (int i = 0; i < 3; i++) CHECK(result.wrench.force[i] == 0 && result.wrench.torque[i] == 0);
        CHECK_INT(loads.count, 0);
    }
    vxs_pointshell bare = *shell;
    bare.area = NULL;
    CHECK_INT(vxs_contact_init(room, ROOM / 2, &bare, 1, &contact), VXS_OK);
    INVALID(1, &deep, (void)0);
}

static void check_coupling(void)
{
    vxs_coupling_config good, config;
    vxs_coupling_coefficients coefficients;
    vxs_coupling *coupling = NULL;
    vxs_coupling_config_default(&good);
#define COUPLING(expected, change) REFUSES(good, expected, vxs_coupling_config_check(&config), change)
    COUPLING(VXS_OK, (void)0);
    COUPLING(VXS_CONFIG, config.struct_size = 1);
    COUPLING(VXS_PARAM, config.kind = 1000);
    COUPLING(VXS_SAMPLE_TIME, config.sample_time = 0);
    COUPLING(VXS_SAMPLE_TIME, config.sample_time = 2 * VXS_COUPLING_MAX_SAMPLE_TIME);
    CHECK(vxs_coupling_config_check(
              (config = good, config.damping = 2 * VXS_COUPLING_MAX_DAMPING, &config)) != VXS_OK);
    good.kind = VXS_COUPLING_SPRING_DAMPER;
    COUPLING(VXS_OK, (void)0);
    CHECK(vxs_coupling_config_check((config = good, config.stiffness = 0, &config)) != VXS_OK);
    CHECK(vxs_coupling_config_check((config = good, config.radius = -1, &config)) != VXS_OK);
    CHECK_INT(vxs_coupling_config_check(NULL), VXS_PARAM);
    CHECK_INT(vxs_coupling_design(NULL, &coefficients), VXS_PARAM);
    CHECK_INT(vxs_coupling_design(&good, NULL), VXS_PARAM);
    CHECK_INT(vxs_coupling_design(&good, &coefficients), VXS_UNSUPPORTED);
    CHECK_INT(vxs_coupling_from_impedance(NULL, 1, 1, 1, 0), VXS_PARAM);
    CHECK_INT(vxs_coupling_from_impedance(&config, 0, 1, 1, 0), VXS_IMPEDANCE);
    CHECK_INT(vxs_coupling_from_impedance(&config, 1, NAN, 1, 0), VXS_IMPEDANCE);
    CHECK_INT(vxs_coupling_from_impedance(&config, 1, 1, -1, 0), VXS_IMPEDANCE);
    config = good;
    CHECK_INT(vxs_coupling_from_impedance(&config, 400, 1, 1, 1), VXS_OK);
    CHECK_NEAR(config.gain, 1.0 / 400, 0);
    CHECK_INT(vxs_coupling_from_impedance(&config, 400, 1, 1, 0), VXS_OK);
    CHECK_NEAR(config.gain, 1, 0);
    CHECK(vxs_coupling_kind_named(NULL) == 0 && vxs_coupling_kind_name(1000) == NULL);
    CHECK_INT(vxs_coupling_init(room, ROOM, NULL, &coupling), VXS_PARAM);
    CHECK_INT(vxs_coupling_init(NULL, ROOM, &good, &coupling), VXS_PARAM);
    CHECK_INT(vxs_coupling_init(room, ROOM, &good, NULL), VXS_PARAM);
    CHECK_INT(vxs_coupling_init(room + 1, ROOM - 1, &good, &coupling), VXS_BUFFER);
    CHECK_INT(vxs_coupling_init(room, vxs_coupling_memory() - 1, &good, &coupling), VXS_BUFFER);
    CHECK(!coupling);
}

static void check_effects(void)
{
    uint32_t count = 99;
    vxs_effect effect;
    vxs_effect_keyframe frame[2];
    CHECK_INT(vxs_effect_default(1000, &effect), VXS_PARAM);
    CHECK_INT(vxs_effect_default(VXS_EFFECT_TORQUE, NULL), VXS_PARAM);
    CHECK(!vxs_effect_constants(1000, &count) && count == 0 && !vxs_effect_constants(1000, NULL));
    CHECK_INT(vxs_effect_check(NULL), VXS_PARAM);
    CHECK(vxs_effect_kind_named(NULL) == 0 && vxs_effect_kind_name(1000) == NULL &&
          vxs_effect_kind_at(1000) == 0);
    for (uint32_t index = 0; vxs_effect_kind_at(index); index++) {
        const uint32_t kind = vxs_effect_kind_at(index);
        CHECK_INT(vxs_effect_default(kind, &effect), VXS_OK);
        effect.struct_size--;
        CHECK_INT(vxs_effect_check(&effect), VXS_CONFIG);
        effect.struct_size++;
        effect.reserved = 1;
        CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
        effect.reserved = 0;
        effect.as.constants[VXS_EFFECT_MAX_CONSTANTS - 1] = NAN;
        CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
        CHECK_INT(vxs_effect_default(kind, &effect), VXS_OK);
        if (kind == VXS_EFFECT_MOTION) continue;
        effect.keyframe_count = 1;
        CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
    }
    CHECK_INT(vxs_effect_default(VXS_EFFECT_PASSIVITY, &effect), VXS_OK);
    effect.as.passivity.delay = 0.5; /* samples are whole */
    CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
    memset(frame, 0, sizeof frame);
    CHECK_INT(vxs_effect_default(VXS_EFFECT_MOTION, &effect), VXS_OK);
    for (int n = 0; n < 2; n++) frame[n].pose = vxs_pose_identity();
    frame[1].time = 1;
    effect.keyframes = frame;
    effect.keyframe_count = 2;
    CHECK_INT(vxs_effect_check(&effect), VXS_OK);
    frame[1].reserved = 1;
    CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
    frame[1].reserved = 0;
    effect.keyframe_count = VXS_EFFECT_MAX_KEYFRAMES + 1;
    CHECK_INT(vxs_effect_check(&effect), VXS_PARAM);
}

static built_asset golden(const char *name)
{
    char path[512];
    snprintf(path, sizeof path, VXS_TEST_SOURCE_DIR "/tests/golden/valid/%s", name);
    FILE *file = fopen(path, "rb");
    built_asset out = {aligned_alloc(64, 1 << 16), 0};
    CHECK(file && out.data);
    out.size = fread(out.data, 1, 1 << 16, file);
    fclose(file);
    return out;
}

static void check_assets(const servo_bench *b)
{
    vxs_asset map, shell, plan_asset, none;
    vxs_voxmap view;
    vxs_pointshell points;
    vxs_plan plan;
    vxs_servo_config config;
    vxs_plan_issue issue;
    vxs_asset_config wrong;
    memset(&none, 0, sizeof none);
    built_asset plan_bytes = golden("bare.plan");
    CHECK_INT(vxs_asset_from_memory(b->map_bytes.data, b->map_bytes.size, NULL, &map, NULL), VXS_OK);
    CHECK_INT(vxs_asset_from_memory(b->shell_bytes.data, b->shell_bytes.size, NULL, &shell, NULL), VXS_OK);
    CHECK_INT(vxs_asset_from_memory(plan_bytes.data, plan_bytes.size, NULL, &plan_asset, NULL), VXS_OK);
    CHECK_INT(vxs_voxmap_open(NULL, &view), VXS_PARAM);
    CHECK_INT(vxs_voxmap_open(&map, NULL), VXS_PARAM);
    CHECK_INT(vxs_voxmap_open(&none, &view), VXS_PARAM);
    CHECK_INT(vxs_voxmap_open(&shell, &view), VXS_KIND);
    CHECK_INT(vxs_pointshell_open(NULL, &points), VXS_PARAM);
    CHECK_INT(vxs_pointshell_open(&shell, NULL), VXS_PARAM);
    CHECK_INT(vxs_pointshell_open(&none, &points), VXS_PARAM);
    CHECK_INT(vxs_pointshell_open(&map, &points), VXS_KIND);
    CHECK_INT(vxs_plan_open(NULL, &plan), VXS_PARAM);
    CHECK_INT(vxs_plan_open(&plan_asset, NULL), VXS_PARAM);
    CHECK_INT(vxs_plan_open(&none, &plan), VXS_PARAM);
    CHECK_INT(vxs_plan_open(&map, &plan), VXS_KIND);
    CHECK_INT(vxs_plan_open(&plan_asset, &plan), VXS_OK);
    const vxs_asset assets[] = {map, shell}, swapped[] = {shell, map};
    vxs_plan empty;
    memset(&empty, 0, sizeof empty);
    CHECK(vxs_plan_memory(NULL) == 0 && vxs_plan_memory(&empty) == 0 && plan.asset_count == 2);
    CHECK_INT(vxs_plan_load(NULL, assets, room, ROOM, &config, &issue), VXS_PARAM);
    CHECK_INT(vxs_plan_load(&empty, assets, room, ROOM, &config, NULL), VXS_PARAM);
    CHECK_INT(vxs_plan_load(&plan, NULL, room, ROOM, &config, &issue), VXS_PARAM);
    CHECK_INT(vxs_plan_load(&plan, assets, NULL, ROOM, &config, &issue), VXS_PARAM);
    CHECK_INT(vxs_plan_load(&plan, assets, room, ROOM, NULL, &issue), VXS_PARAM);
    CHECK_INT(vxs_plan_load(&plan, assets, room + 8, ROOM - 8, &config, &issue), VXS_BUFFER);
    CHECK_INT(vxs_plan_load(&plan, assets, room, vxs_plan_memory(&plan) - 1, &config, &issue), VXS_BUFFER);
    CHECK_INT(vxs_plan_load(&plan, swapped, room, ROOM, &config, &issue), VXS_KIND);
    CHECK_INT(vxs_plan_load(&plan, swapped, room, ROOM, &config, NULL), VXS_KIND);
    const vxs_result other = vxs_plan_load(&plan, assets, room, ROOM, &config, &issue);
    CHECK(other != VXS_OK && issue.text && memcmp(issue.expected, issue.found, sizeof issue.found) != 0);
    CHECK_INT(vxs_plan_load(&plan, assets, room, ROOM, &config, NULL), other);

    vxs_asset_issue said;
    vxs_asset_config_default(&wrong);
    CHECK_INT(vxs_asset_from_memory(NULL, 0, &wrong, &none, &said), VXS_PARAM);
    CHECK(said.text && !none.data);
    wrong.struct_size = 1;
    CHECK_INT(vxs_asset_from_memory(b->map_bytes.data, b->map_bytes.size, &wrong, &none, &said), VXS_CONFIG);
    CHECK(said.text && !none.data);
    vxs_asset_config_default(&wrong);
    CHECK_INT(vxs_asset_from_memory(b->map_bytes.data, b->map_bytes.size, &wrong, NULL, NULL), VXS_PARAM);
    CHECK_INT(vxs_asset_open("/", &wrong, NULL, NULL), VXS_PARAM);
    CHECK_INT(vxs_asset_open(NULL, NULL, &none, NULL), VXS_PARAM);
    wrong.kind = 1000;
    CHECK_INT(vxs_asset_open("/", &wrong, &none, NULL), VXS_PARAM);
    vxs_asset_config_default(&wrong);
    wrong.mode = 1000;
    CHECK_INT(vxs_asset_open("/", &wrong, &none, NULL), VXS_PARAM);
    const char *path = VXS_TEST_SOURCE_DIR "/tests/golden/valid/one_cell.voxmap";
    for (int n = 0; n < 2; n++) { /* what is said to be checked already */
        vxs_asset_config_default(&wrong);
        wrong.skip_checksums = n == 0;
        wrong.trusted = n == 1;
        CHECK_INT(vxs_asset_open(path, &wrong, &none, NULL), VXS_OK);
        vxs_asset_close(&none);
    }
    CHECK_INT(vxs_asset_guard(NULL), VXS_PARAM);
    CHECK_INT(vxs_asset_guard(&none), VXS_PARAM);
    CHECK_INT(vxs_asset_guard(&map), VXS_OK); /* not mapped: nothing to guard */
    free(plan_bytes.data);
}

static void check_watchers(servo_bench *b)
{
    const char *path = "test_api_refusals.tmp";
    char longer[5000];
    memset(longer, 'a', sizeof longer - 1);
    longer[sizeof longer - 1] = 0;
    vxs_trace *trace = NULL;
    CHECK_INT(vxs_trace_init(NULL, ROOM, 16, &trace), VXS_PARAM);
    CHECK_INT(vxs_trace_init(room, ROOM, 16, NULL), VXS_PARAM);
    CHECK_INT(vxs_trace_init(room, ROOM, 0, &trace), VXS_PARAM);
    CHECK_INT(vxs_trace_init(room, ROOM, 17, &trace), VXS_PARAM);
    CHECK_INT(vxs_trace_init(room + 4, ROOM - 4, 16, &trace), VXS_BUFFER);
    CHECK_INT(vxs_trace_init(room, vxs_trace_memory(16) - 1, 16, &trace), VXS_BUFFER);
    CHECK_INT(vxs_trace_init(room, ROOM / 2, 16, &trace), VXS_OK);

    vxs_recorder *recorder = NULL;
    uint8_t *rest = room + ROOM / 2;
    CHECK_INT(vxs_recorder_start(NULL, ROOM / 2, path, trace, &recorder), VXS_PARAM);
    CHECK_INT(vxs_recorder_start(rest, ROOM / 2, NULL, trace, &recorder), VXS_PARAM);
    CHECK_INT(vxs_recorder_start(rest, ROOM / 2, path, NULL, &recorder), VXS_PARAM);
    CHECK_INT(vxs_recorder_start(rest, ROOM / 2, path, trace, NULL), VXS_PARAM);
    CHECK_INT(vxs_recorder_start(rest + 1, ROOM / 2 - 1, path, trace, &recorder), VXS_BUFFER);
    CHECK_INT(vxs_recorder_start(rest, vxs_recorder_memory() - 1, path, trace, &recorder), VXS_BUFFER);
    CHECK_INT(vxs_recorder_start(rest, ROOM / 2, "/nowhere/at/all", trace, &recorder), VXS_IO);
    CHECK(!recorder);
    CHECK_INT(vxs_recorder_start(rest, ROOM / 2, "/dev/full", trace, &recorder), VXS_OK);
    CHECK_INT(vxs_recorder_stop(recorder, NULL), VXS_IO); /* nothing fits on that */

    vxs_live live;
    CHECK_INT(vxs_live_create(NULL, path), VXS_PARAM);
    CHECK_INT(vxs_live_create(&live, NULL), VXS_PARAM);
    CHECK_INT(vxs_live_create(&live, longer), VXS_PARAM);
    CHECK_INT(vxs_live_create(&live, "."), VXS_IO);
    CHECK_INT(vxs_live_create(&live, "/nowhere/at/all"), VXS_IO);
    CHECK_INT(vxs_live_open(NULL, path), VXS_PARAM);
    CHECK_INT(vxs_live_open(&live, NULL), VXS_PARAM);
    CHECK_INT(vxs_live_open(&live, longer), VXS_PARAM);
    vxs_live_close(NULL);

    const vxs_servo_watch watch = {0};
    CHECK_INT(vxs_servo_watch_stages(NULL, rest, ROOM / 2, &watch), VXS_PARAM);
    CHECK_INT(vxs_servo_watch_stages(b->servo, NULL, ROOM / 2, &watch), VXS_PARAM);
    CHECK_INT(vxs_servo_watch_stages(b->servo, rest, ROOM / 2, NULL), VXS_PARAM);
    CHECK_INT(vxs_servo_watch_stages(b->servo, rest, ROOM / 2, &watch), VXS_PARAM);
}

/* A command with a number that is none, at any place of it: an armed device is at fault and stays so until it is
 * disarmed, and renders nothing; one that is not armed does not look at it. */
static void check_commands(uint32_t refused, vxs_result opened, vxs_device **device)
{
    const double bad[] = {NAN, INFINITY, -INFINITY};
    CHECK_INT(opened, VXS_OK);
    for (int n = 0; n < 18; n++) {
        vxs_device_state state;
        vxs_device_report report;
        vxs_device_command command = {.hold_ns = INT64_MAX, .expires_ns = INT64_MAX};
        if (n % 6 < 3)
            command.wrench.force[n % 3] = bad[n / 6];
        else
            command.wrench.torque[n % 3] = bad[n / 6];
        vxs_device_exchange(*device, &command, &state, &report);
        CHECK_INT(state.state, VXS_DEVICE_READY);
        CHECK(vxs_device_arm(*device) == VXS_OK && vxs_device_arm(*device) == VXS_OK);
        for (int i = 0; i < 10; i++) vxs_device_exchange(*device, &command, &state, i == 9 ? NULL : &report);
        CHECK(state.state == VXS_DEVICE_FAULT && state.fault == VXS_DEVICE_FAULT_SOFTWARE);
        for (int i = 0; i < 3; i++) CHECK(report.rendered.force[i] == 0 && report.rendered.torque[i] == 0);
        CHECK((refused == 0 || report.flags == 0 || report.flags == refused) &&
              isfinite(state.pose.position[0]));
        CHECK_INT(vxs_device_arm(*device), VXS_STATE);
        CHECK_INT(vxs_device_disarm(*device), VXS_OK);
        command = (vxs_device_command){.hold_ns = INT64_MAX, .expires_ns = INT64_MAX};
        for (int i = 0; i < 10; i++) vxs_device_exchange(*device, &command, &state, &report);
    }
    /* A torque that the device has no motors for is left out, whichever axis it is about. */
    for (int axis = 0; axis < 3 && refused; axis++) {
        vxs_device_state state;
        vxs_device_report report;
        vxs_device_command command = {.hold_ns = INT64_MAX, .expires_ns = INT64_MAX};
        command.wrench.torque[axis] = 0.1;
        CHECK_INT(vxs_device_arm(*device), VXS_OK);
        for (int i = 0; i < 10; i++) vxs_device_exchange(*device, &command, &state, &report);
        CHECK(report.flags & VXS_DEVICE_INCOMPLETE && report.rendered.torque[axis] == 0);
        CHECK_INT(vxs_device_disarm(*device), VXS_OK);
    }
    vxs_device_close(*device);
}

static void check_devices(void)
{
    vxs_simulated_config good, config;
    vxs_device *device = NULL;
    vxs_simulated_config_default(&good, NULL);
#define SIMULATED(expected, change)                                                                          \
    REFUSES(good, expected, vxs_simulated_open(room, ROOM, &config, &device), change)
    CHECK_INT(vxs_simulated_open(room, ROOM, NULL, &device), VXS_PARAM);
    SIMULATED(VXS_CONFIG, config.struct_size--);
    SIMULATED(VXS_PARAM, config.profile.name = NULL);
    SIMULATED(VXS_PARAM, config.arm.name = NULL);
    SIMULATED(VXS_PARAM, config.profile.peak_force = 0);
    SIMULATED(VXS_PARAM, config.profile.mass = -1);
    SIMULATED(VXS_PARAM, config.arm.stiffness = NAN);
    SIMULATED(VXS_PARAM, config.delay_samples = 1u << 20);
    SIMULATED(VXS_PARAM, config.substeps = 0);
    SIMULATED(VXS_PARAM, config.substeps = 1001);
    SIMULATED(VXS_PARAM, config.sample_time = 1e-6);
    SIMULATED(VXS_PARAM, config.sample_time = 1);
    SIMULATED(VXS_PARAM, config.start.orientation[0] = NAN);
    CHECK_INT(vxs_simulated_open(NULL, ROOM, &good, &device), VXS_PARAM);
    CHECK_INT(vxs_simulated_open(room, ROOM, &good, NULL), VXS_PARAM);
    CHECK_INT(vxs_simulated_open(room + 1, ROOM - 1, &good, &device), VXS_BUFFER);
    CHECK_INT(vxs_simulated_open(room, vxs_simulated_memory() - 1, &good, &device), VXS_BUFFER);
    CHECK(!device && !vxs_simulated_arm_named(NULL) && !vxs_simulated_profile_named(NULL));
    CHECK_INT(vxs_simulated_open(room, ROOM, &good, &device), VXS_OK);
    vxs_device_close(device);
    CHECK_INT(vxs_device_arm(device), VXS_STATE);
    CHECK_INT(vxs_device_disarm(device), VXS_STATE);
    CHECK_INT(vxs_device_arm(NULL), VXS_PARAM);
    CHECK_INT(vxs_device_disarm(NULL), VXS_PARAM);
    vxs_device_close(NULL);

    vxs_replay_row row;
    vxs_replay_config said, replay;
    memset(&row, 0, sizeof row);
    row.pose = vxs_pose_identity();
    vxs_replay_config_default(&said);
    said.rows = &row;
    said.row_count = 1;
#define REPLAY(expected, change)                                                                             \
    do {                                                                                                     \
        replay = said;                                                                                       \
        change;                                                                                              \
        CHECK_INT(vxs_replay_open(room, ROOM, &replay, &device), expected);                                  \
    } while (0)
    CHECK_INT(vxs_replay_open(room, ROOM, NULL, &device), VXS_PARAM);
    CHECK_INT(vxs_replay_open(NULL, ROOM, &said, &device), VXS_PARAM);
    CHECK_INT(vxs_replay_open(room, ROOM, &said, NULL), VXS_PARAM);
    REPLAY(VXS_CONFIG, replay.struct_size = 3);
    REPLAY(VXS_PARAM, replay.sample_time = 1e-6);
    REPLAY(VXS_PARAM, replay.sample_time = 1);
    CHECK_INT(vxs_replay_open(room + 1, ROOM - 1, &said, &device), VXS_BUFFER);
    CHECK_INT(vxs_replay_open(room, ROOM, &said, &device), VXS_OK);
    vxs_device_close(device);
    CHECK_INT(vxs_device_disarm(device), VXS_STATE);
    CHECK(!vxs_simulated_arm_named("tentacle") && !vxs_simulated_profile_named("tentacle"));
    vxs_simulated_config_default(&config, vxs_simulated_profile_named("falcon"));
    check_commands(VXS_DEVICE_REFUSED, vxs_simulated_open(room, ROOM, &config, &device), &device);
    check_commands(0, vxs_replay_open(room, ROOM, &said, &device), &device);

    /* What it is told of a hand has to be a place, and is not asked to be there. */
    vxs_device_state state, after;
    const double lost[3] = {0, NAN, 0}, nowhere[4] = {0, 0, 0, 0};
    CHECK_INT(vxs_simulated_open(room, ROOM, &good, &device), VXS_OK);
    vxs_simulated_hand(device, NULL, NULL);
    vxs_simulated_hand(device, lost, nowhere);
    vxs_device_exchange(device, NULL, &state, NULL);
    for (int n = 0; n < 100; n++) vxs_device_exchange(device, NULL, &after, NULL);
    CHECK(memcmp(&state.pose, &after.pose, sizeof state.pose) == 0);
    vxs_device_close(device);

    /* Rows are counted without being kept; where it went wrong need not be asked. */
    size_t count = 9, line = 9;
    static const char script[] = "t_s,x_m,y_m,z_m\n0,1,2,3\n1,1,2,4\n",
                      broken[] = "t_s,x_m,y_m,z_m\n0,1,two,3\n";
    CHECK_INT(vxs_replay_parse(NULL, 4, NULL, 0, &count, &line), VXS_PARAM);
    CHECK_INT(vxs_replay_parse(script, sizeof script - 1, &row, 1, NULL, &line), VXS_PARAM);
    CHECK(count == 9 && line == 9);
    CHECK_INT(vxs_replay_parse(script, sizeof script - 1, NULL, 0, &count, NULL), VXS_OK);
    CHECK_INT(count, 2);
    CHECK_INT(vxs_replay_parse(broken, sizeof broken - 1, &row, 1, &count, NULL), VXS_CORRUPT);
    uint8_t recording[16 + 2 * sizeof(vxs_servo_trace)] = "VXSREC01";
    const uint32_t row_size = sizeof(vxs_servo_trace);
    memcpy(recording + 8, &row_size, sizeof row_size);
    CHECK_INT(vxs_replay_parse(recording, sizeof recording, NULL, 7, &count, &line), VXS_OK);
    CHECK_INT(count, 2);
}

int main(void)
{
    servo_bench b;
    bench_prepare(&b);
    bench_open(&b);
    check_servo(&b);
    check_thread(&b);
    check_contact(&b);
    check_coupling();
    check_effects();
    check_assets(&b);
    check_watchers(&b);
    check_devices();
    bench_close(&b);
    return 0;
}
