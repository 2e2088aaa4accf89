/* SPDX-License-Identifier: MIT
 *
 * The rules of formats/plan.md, in the order of their ids. Linear time, no memory. Pure.
 */
#include "asset_check.h"
#include "voxshell/format/plan.h"

#include <math.h>
#include <string.h>

enum { PLAN, ASST, EFCT, HAND, MOVE, KNOWN };

static const struct {
    uint32_t id, stride;
} layout[KNOWN] = {
    {VXS_PLAN_SECTION_PLAN, sizeof(vxs_plan_info)},   {VXS_PLAN_SECTION_ASST, sizeof(vxs_plan_asset)},
    {VXS_PLAN_SECTION_EFCT, sizeof(vxs_plan_effect)}, {VXS_PLAN_SECTION_HAND, sizeof(vxs_plan_keyframe)},
    {VXS_PLAN_SECTION_MOVE, sizeof(vxs_plan_motion)},
};

typedef struct plan_check {
    vxsi_check *check;
    const vxs_container_section *section[KNOWN]; /* NULL: not there */
} plan_check;

static const void *element(const plan_check *p, int which, uint64_t n)
{
    return p->check->data + p->section[which]->offset + n * layout[which].stride;
}

/* Refuses a field of element n of a section. */
static vxs_result refuse_at(const plan_check *p, const char *rule, int which, uint64_t n, size_t field,
                            const char *text)
{
    return vxsi_refuse(p->check, VXS_CORRUPT, rule, layout[which].id,
                       p->section[which]->offset + n * layout[which].stride + field, text);
}

static vxs_result check_sections(plan_check *p)
{
    const vxs_container_section *table = vxsi_table(p->check->data);
    uint32_t next = 0;
    for (int n = 0; n < KNOWN; n++) {
        int is_optional = n >= EFCT;
        if (is_optional && !vxsi_find_section(p->check->data, layout[n].id)) continue;
        if (table[next].id != layout[n].id) /* META is last, so a table that is too short fails here */
            return vxsi_refuse_entry(p->check, VXS_CORRUPT, "P101", &table[next],
                                     "not PLAN, ASST and what there is of EFCT, HAND, MOVE in order");
        p->section[n] = &table[next++];
    }
    for (int n = 0; n < KNOWN; n++) {
        const vxs_container_section *entry = p->section[n];
        if (entry && (entry->stride != layout[n].stride || (n == PLAN && entry->count != 1)))
            return vxsi_refuse_entry(p->check, VXS_CORRUPT, "P102", entry, "wrong stride, or not one PLAN");
    }
    return VXS_OK;
}

static int is_positive(double value)
{
    return isfinite(value) && value > 0;
}

/* Not negative, not -0. */
static int is_amount(double value)
{
    return isfinite(value) && !signbit(value);
}

/* Offset of the first byte of size that is not 0; size if there is none. */
static size_t first_byte(const void *bytes, size_t size)
{
    size_t at = 0;
    while (at < size && ((const uint8_t *)bytes)[at] == 0) at++;
    return at;
}

/* Index of the first coordinate that is not finite or beyond 1e15 m; 3 if there is none. */
static size_t far_axis(const double position[3])
{
    size_t axis = 0;
    while (axis < 3 && fabs(position[axis]) <= VXS_PLAN_MAX_COORDINATE) axis++;
    return axis;
}

static int is_unit(const double q[4])
{
    return fabs((((q[0] * q[0] + q[1] * q[1]) + q[2] * q[2]) + q[3] * q[3]) - 1.0) <= 1e-6;
}

static vxs_result check_pose(const plan_check *p, const char *rule, int which, uint64_t n, size_t position,
                             size_t orientation)
{
    const uint8_t *bytes = element(p, which, n);
    double at[3], q[4];
    memcpy(at, bytes + position, sizeof at);
    memcpy(q, bytes + orientation, sizeof q);
    size_t axis = far_axis(at);
    if (axis < 3)
        return refuse_at(p, rule, which, n, position + 8 * axis,
                         "a position is not finite, or beyond 1e15 m");
    if (!is_unit(q)) return refuse_at(p, rule, which, n, orientation, "an orientation has not length 1");
    return VXS_OK;
}

/* Letters up to a zero, zeros after it. */
static int is_name(const uint8_t *text, size_t size, int (*is_letter)(uint8_t))
{
    size_t length = 0;
    while (length < size && is_letter(text[length])) length++; /* 0 is none */
    return length > 0 && length < size && first_byte(text + length, size - length) == size - length;
}

static int is_visible(uint8_t c)
{
    return c > 0x20 && c < 0x7F;
}
static int is_of_file(uint8_t c)
{
    return c >= 0x20 && c != 0x7F && c != '/' && c != '\\';
}
static int is_of_kind(uint8_t c)
{
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
}

#define FIELD(name) offsetof(vxs_plan_info, name)

static vxs_result check_contact(const plan_check *p)
{
    const vxs_plan_info *info = element(p, PLAN, 0);
    if (!(info->rate >= 10 && info->rate <= 1e5))
        return refuse_at(p, "P201", PLAN, 0, FIELD(rate), "rate is not within 10 .. 100000 Hz");
    if (info->law < VXS_PLAN_LAW_ORIGINAL || info->law > VXS_PLAN_LAW_PATCH)
        return refuse_at(p, "P202", PLAN, 0, FIELD(law), "no such law");
    if (info->field < VXS_PLAN_FIELD_SURFACE || info->field > VXS_PLAN_FIELD_DISTANCE)
        return refuse_at(p, "P202", PLAN, 0, FIELD(field), "no such field");
    if (info->law == VXS_PLAN_LAW_GRADIENT && info->field != VXS_PLAN_FIELD_DISTANCE)
        return refuse_at(p, "P202", PLAN, 0, FIELD(field), "the law gradient needs the field distance");
    if (info->weighting < VXS_PLAN_WEIGHT_COUNT || info->weighting > VXS_PLAN_WEIGHT_AREA)
        return refuse_at(p, "P202", PLAN, 0, FIELD(weighting), "no such weighting");
    if (info->flags & ~(uint32_t)VXS_PLAN_FLAG_DESIGNED)
        return refuse_at(p, "P203", PLAN, 0, FIELD(flags), "a flag is not known");
    if (!is_positive(info->stiffness))
        return refuse_at(p, "P204", PLAN, 0, FIELD(stiffness), "stiffness is not finite, or not above 0");
    if (!is_amount(info->most_stiffness))
        return refuse_at(p, "P204", PLAN, 0, FIELD(most_stiffness),
                         "most_stiffness is not finite, or below 0");
    if (!is_amount(info->budget) || (info->budget > 0 && info->weighting != VXS_PLAN_WEIGHT_AREA))
        return refuse_at(p, "P204", PLAN, 0, FIELD(budget), "budget is no time, or not with weighting area");
    return VXS_OK;
}

/* Which kinds of coupling have a number. */
static const struct {
    size_t field;
    uint32_t kinds; /* bit n: kind n */
} coupling_numbers[] = {
    {FIELD(omega0), 1 << VXS_PLAN_COUPLING_PT2},
    {FIELD(damping), 1 << VXS_PLAN_COUPLING_PT2 | 1 << VXS_PLAN_COUPLING_SPRING_DAMPER},
    {FIELD(gain), 1 << VXS_PLAN_COUPLING_PT2},
    {FIELD(coupling_stiffness), 1 << VXS_PLAN_COUPLING_SPRING_DAMPER | 1 << VXS_PLAN_COUPLING_QUASI_STATIC},
    {FIELD(radius), 1 << VXS_PLAN_COUPLING_SPRING_DAMPER | 1 << VXS_PLAN_COUPLING_QUASI_STATIC},
    {FIELD(mass), 1 << VXS_PLAN_COUPLING_SPRING_DAMPER},
};

static vxs_result check_coupling(const plan_check *p)
{
    const vxs_plan_info *info = element(p, PLAN, 0);
    if (info->coupling < VXS_PLAN_COUPLING_NONE || info->coupling > VXS_PLAN_COUPLING_QUASI_STATIC)
        return refuse_at(p, "P205", PLAN, 0, FIELD(coupling), "no such coupling");
    if (info->prewarp > (info->coupling == VXS_PLAN_COUPLING_PT2))
        return refuse_at(p, "P206", PLAN, 0, FIELD(prewarp), "prewarp is neither 0 nor pt2's 1");
    int counts = info->coupling == VXS_PLAN_COUPLING_QUASI_STATIC;
    if (info->evaluations > (counts ? 3 : 0) || (counts && info->evaluations < 1))
        return refuse_at(p, "P206", PLAN, 0, FIELD(evaluations),
                         "evaluations is not within 1 .. 3, or not 0 for another kind than quasi-static");
    for (size_t n = 0; n < sizeof coupling_numbers / sizeof *coupling_numbers; n++) {
        const uint8_t *at = (const uint8_t *)info + coupling_numbers[n].field;
        double value;
        memcpy(&value, at, sizeof value);
        int is_its = coupling_numbers[n].kinds >> info->coupling & 1;
        if (is_its ? !is_positive(value) : first_byte(at, sizeof value) < sizeof value)
            return refuse_at(p, "P206", PLAN, 0, coupling_numbers[n].field,
                             "a number of the coupling is not above 0, or is there and not its kind's");
    }
    return VXS_OK;
}

static vxs_result check_servo(const plan_check *p)
{
    static const size_t above_zero[] = {FIELD(max_force), FIELD(max_torque), FIELD(max_speed), FIELD(scale)};
    const vxs_plan_info *info = element(p, PLAN, 0);
    for (size_t n = 0; n < sizeof above_zero / sizeof *above_zero; n++) {
        double value;
        memcpy(&value, (const uint8_t *)info + above_zero[n], sizeof value);
        if (!is_positive(value))
            return refuse_at(p, "P207", PLAN, 0, above_zero[n], "a limit or the scale is not above 0");
    }
    if (!is_amount(info->hold_time) || info->hold_time > 3600)
        return refuse_at(p, "P207", PLAN, 0, FIELD(hold_time), "hold_time is not within 0 .. 3600 s");
    if (!(info->decay_time >= 1e-6 && info->decay_time <= 3600))
        return refuse_at(p, "P207", PLAN, 0, FIELD(decay_time), "decay_time is not within 1e-6 .. 3600 s");
    vxs_result result = check_pose(p, "P208", PLAN, 0, FIELD(mount_position), FIELD(mount_orientation));
    if (result == VXS_OK)
        result = check_pose(p, "P208", PLAN, 0, FIELD(grip_position), FIELD(grip_orientation));
    if (result != VXS_OK) return result;
    if (!is_name(info->device, sizeof info->device, is_visible))
        return refuse_at(p, "P209", PLAN, 0, FIELD(device), "device is no name");
    if (!is_name(info->arm, sizeof info->arm, is_visible))
        return refuse_at(p, "P209", PLAN, 0, FIELD(arm), "arm is no name");
    if (info->reserved != 0) return refuse_at(p, "P210", PLAN, 0, FIELD(reserved), "reserved is not 0");
    size_t at = first_byte(info->pad, sizeof info->pad);
    if (at < sizeof info->pad)
        return refuse_at(p, "P210", PLAN, 0, FIELD(pad) + at, "a byte of pad is not 0");
    return VXS_OK;
}

#undef FIELD
#define FIELD(name) offsetof(vxs_plan_asset, name)

static vxs_result check_asset(const plan_check *p, uint64_t n, int is_last)
{
    static const double identity[7] = {0, 0, 0, 1, 0, 0, 0};
    const vxs_plan_asset *asset = element(p, ASST, n);
    if (asset->role != (is_last ? VXS_PLAN_ROLE_DYNAMIC : VXS_PLAN_ROLE_STATIC))
        return refuse_at(p, "P302", ASST, n, FIELD(role), "not statics and one dynamic at the end");
    if (!is_name(asset->name, sizeof asset->name, is_of_file) || asset->name[0] == '.')
        return refuse_at(p, "P303", ASST, n, FIELD(name), "name is no file's");
    vxs_result result = check_pose(p, "P304", ASST, n, FIELD(position), FIELD(orientation));
    if (result != VXS_OK) return result;
    if (is_last && memcmp((const uint8_t *)asset + FIELD(position), identity, sizeof identity) != 0)
        return refuse_at(p, "P304", ASST, n, FIELD(position), "the dynamic has a pose of its own");
    if (asset->reserved != 0) return refuse_at(p, "P305", ASST, n, FIELD(reserved), "reserved is not 0");
    size_t at = first_byte(asset->pad, sizeof asset->pad);
    if (at < sizeof asset->pad)
        return refuse_at(p, "P305", ASST, n, FIELD(pad) + at, "a byte of pad is not 0");
    return VXS_OK;
}

static vxs_result check_assets(const plan_check *p)
{
    uint64_t count = p->section[ASST]->count;
    if (count < 2 || count > VXS_PLAN_MAX_STATICS + 1)
        return vxsi_refuse_entry(p->check, VXS_LIMIT, "P301", p->section[ASST], "not 2 .. 4097 assets");
    vxs_result result = VXS_OK;
    for (uint64_t n = 0; n < count && result == VXS_OK; n++) result = check_asset(p, n, n == count - 1);
    return result;
}

#undef FIELD
#define FIELD(name) offsetof(vxs_plan_effect, name)

static vxs_result check_effect(const plan_check *p, uint64_t n)
{
    const vxs_plan_effect *effect = element(p, EFCT, n);
    if (!is_name(effect->kind, sizeof effect->kind, is_of_kind))
        return refuse_at(p, "P402", EFCT, n, FIELD(kind), "kind is no name");
    for (uint64_t other = 0; other < n; other++) {
        if (memcmp(((const vxs_plan_effect *)element(p, EFCT, other))->kind, effect->kind,
                   sizeof effect->kind) == 0)
            return refuse_at(p, "P402", EFCT, n, FIELD(kind), "the kind is there already");
    }
    if (effect->constant_count > VXS_PLAN_MAX_CONSTANTS)
        return refuse_at(p, "P403", EFCT, n, FIELD(constant_count), "more than 24 constants");
    for (uint32_t c = 0; c < VXS_PLAN_MAX_CONSTANTS; c++) {
        const double *value = &effect->constants[c];
        if (c < effect->constant_count ? !isfinite(*value) : first_byte(value, sizeof *value) < sizeof *value)
            return refuse_at(p, "P403", EFCT, n, FIELD(constants) + 8 * c,
                             "a constant is not finite, or beyond constant_count");
    }
    if (effect->reserved != 0) return refuse_at(p, "P404", EFCT, n, FIELD(reserved), "reserved is not 0");
    return VXS_OK;
}

static vxs_result check_effects(const plan_check *p)
{
    if (!p->section[EFCT]) return VXS_OK;
    if (p->section[EFCT]->count > VXS_PLAN_MAX_EFFECTS)
        return vxsi_refuse_entry(p->check, VXS_LIMIT, "P401", p->section[EFCT], "more than 64 effects");
    vxs_result result = VXS_OK;
    for (uint64_t n = 0; n < p->section[EFCT]->count && result == VXS_OK; n++) result = check_effect(p, n);
    return result;
}

#undef FIELD
#define FIELD(name) offsetof(vxs_plan_keyframe, name)

static vxs_result check_turn(const plan_check *p, uint64_t n)
{
    const vxs_plan_keyframe *k = element(p, HAND, n);
    if (k->move > VXS_PLAN_MOVE_TURN || (n == 0 && k->move != VXS_PLAN_MOVE_STRAIGHT))
        return refuse_at(p, "P504", HAND, n, FIELD(move), "no such move, or the first keyframe turns");
    if (k->reserved != 0) return refuse_at(p, "P504", HAND, n, FIELD(reserved), "reserved is not 0");
    if (k->move == VXS_PLAN_MOVE_STRAIGHT) {
        size_t size = sizeof *k - FIELD(turn_about),
               at = first_byte((const uint8_t *)k + FIELD(turn_about), size);
        return at < size ? refuse_at(p, "P505", HAND, n, FIELD(turn_about) + at / 8 * 8,
                                     "a turn where there is none")
                         : VXS_OK;
    }
    size_t axis = far_axis(k->turn_about);
    if (axis < 3)
        return refuse_at(p, "P505", HAND, n, FIELD(turn_about) + 8 * axis,
                         "turn_about is not finite, or beyond 1e15 m");
    const double *u = k->turn_axis;
    if (!(fabs(((u[0] * u[0] + u[1] * u[1]) + u[2] * u[2]) - 1.0) <= 1e-6))
        return refuse_at(p, "P505", HAND, n, FIELD(turn_axis), "turn_axis has not length 1");
    if (!(fabs(k->turn_angle) <= 1e6))
        return refuse_at(p, "P505", HAND, n, FIELD(turn_angle), "turn_angle is not within 1e6 rad");
    return VXS_OK;
}

static vxs_result check_hand(const plan_check *p)
{
    if (!p->section[HAND]) return VXS_OK;
    if (p->section[HAND]->count > VXS_PLAN_MAX_KEYFRAMES)
        return vxsi_refuse_entry(p->check, VXS_LIMIT, "P501", p->section[HAND], "more than 2^16 keyframes");
    vxs_result result = VXS_OK;
    double before = -1;
    for (uint64_t n = 0; n < p->section[HAND]->count && result == VXS_OK; n++) {
        const vxs_plan_keyframe *k = element(p, HAND, n);
        if (!(is_amount(k->time) && k->time > before && k->time <= 1e9))
            return refuse_at(p, "P502", HAND, n, FIELD(time), "times are not ascending within 0 .. 1e9 s");
        before = k->time;
        result = check_pose(p, "P503", HAND, n, FIELD(position), FIELD(orientation));
        if (result == VXS_OK) result = check_turn(p, n);
    }
    return result;
}

#undef FIELD
#define FIELD(name) offsetof(vxs_plan_motion, name)

/* The number of the effect whose keyframes MOVE holds, that of effects if there is none. */
static uint64_t find_motion(const plan_check *p)
{
    static const uint8_t kind[sizeof((vxs_plan_effect *)NULL)->kind] = "motion";
    uint64_t n = 0, count = p->section[EFCT] ? p->section[EFCT]->count : 0;
    while (n < count && memcmp(((const vxs_plan_effect *)element(p, EFCT, n))->kind, kind, sizeof kind) != 0)
        n++;
    return n;
}

static vxs_result check_motion(const plan_check *p)
{
    uint64_t effects = p->section[EFCT] ? p->section[EFCT]->count : 0, motion = find_motion(p);
    if (!p->section[MOVE])
        return motion < effects ? refuse_at(p, "P606", EFCT, motion, 0, "a motion without MOVE") : VXS_OK;
    if (p->section[MOVE]->count > VXS_PLAN_MAX_KEYFRAMES)
        return vxsi_refuse_entry(p->check, VXS_LIMIT, "P601", p->section[MOVE], "more than 2^16 keyframes");
    uint32_t asset = 0;
    double before = -1;
    for (uint64_t n = 0; n < p->section[MOVE]->count; n++) {
        const vxs_plan_motion *m = element(p, MOVE, n);
        if (m->asset < asset || m->asset >= p->section[ASST]->count - 1)
            return refuse_at(p, "P602", MOVE, n, FIELD(asset), "no static's number, or out of order");
        if (m->asset > asset) before = -1;
        asset = m->asset;
        if (!(is_amount(m->time) && m->time > before && m->time <= 1e9))
            return refuse_at(p, "P603", MOVE, n, FIELD(time), "times are not ascending within 0 .. 1e9 s");
        before = m->time;
        vxs_result result = check_pose(p, "P604", MOVE, n, FIELD(position), FIELD(orientation));
        if (result != VXS_OK) return result;
        if (m->reserved != 0) return refuse_at(p, "P605", MOVE, n, FIELD(reserved), "reserved is not 0");
    }
    if (motion == effects)
        return vxsi_refuse_entry(p->check, VXS_CORRUPT, "P606", p->section[MOVE], "MOVE without a motion");
    return VXS_OK;
}

vxs_result vxsi_check_plan(vxsi_check *check)
{
    plan_check p = {.check = check};
    vxs_result result = check_sections(&p);
    if (result == VXS_OK) result = check_contact(&p);
    if (result == VXS_OK) result = check_coupling(&p);
    if (result == VXS_OK) result = check_servo(&p);
    if (result == VXS_OK) result = check_assets(&p);
    if (result == VXS_OK) result = check_effects(&p);
    if (result == VXS_OK) result = check_hand(&p);
    if (result == VXS_OK) result = check_motion(&p);
    return result;
}
