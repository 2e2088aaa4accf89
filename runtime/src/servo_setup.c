/* SPDX-License-Identifier: MIT
 *
 * Set-up of the servo.
 */
#include "coupling_table.h"
#include "servo_state.h"

#include <math.h>
#include <string.h>

enum { ALIGNMENT = 16 };

/* Safe by default. */
static const vxs_effect default_effects[] = {
    {.struct_size = sizeof(vxs_effect), .kind = VXS_EFFECT_START_INSIDE},
    {.struct_size = sizeof(vxs_effect), .kind = VXS_EFFECT_TORQUE},
    {.struct_size = sizeof(vxs_effect), .kind = VXS_EFFECT_SOFT_START, .as.soft_start.time = 0.5},
};

void vxs_servo_config_default(vxs_servo_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
    config->mount = config->grip = vxs_pose_identity();
    config->scale = 1;
    vxs_contact_config_default(&config->contact);
    vxs_coupling_config_default(&config->coupling);
    config->max_force = 3;
    config->max_torque = 0.2;
    config->max_speed = 20;
    config->effects = default_effects;
    config->effect_count = sizeof default_effects / sizeof *default_effects;
    config->decay_time = 0.01;
}

static int is_positive(double value)
{
    return isfinite(value) && value > 0;
}
static int is_time(double value)
{
    return value >= 0 && value <= 3600;
}

/* Each effect is sound and there once. */
static vxs_result check_effects(const vxs_servo_config *config)
{
    if (config->effect_count > VXSI_STAGE_MOST || (config->effect_count > 0 && !config->effects))
        return VXS_PARAM;
    uint32_t own = 0;
    for (uint32_t n = 0; n < config->effect_count; n++) {
        const vxs_effect *effect = &config->effects[n];
        vxs_result result = vxs_effect_check(effect);
        if (result != VXS_OK) return result;
        const vxs_effect_kind *stage = vxsi_effect_kind_of(effect);
        own += stage == effect->own;
        if (stage->fits) result = stage->fits(effect, config);
        if (result != VXS_OK) return result;
        for (uint32_t m = 0; m < n; m++)
            if (vxsi_effect_kind_of(&config->effects[m]) == stage) return VXS_PARAM;
    }
    return own + vxsi_servo_table_size <= VXSI_STAGE_MOST ? VXS_OK : VXS_PARAM;
}

/* What 1 N/m at the farthest point of the shell is about the tip: 1 + a^2, a its distance over the shell's
 * radius. */
static double lever_of(const vxs_servo_config *config)
{
    double square = 0;
    vxs_pose center = vxs_pose_identity();
    for (int i = 0; i < 3; i++) center.position[i] = (double)config->shell->center[i];
    vxs_pose_compose(&config->grip, &center, &center);
    for (int i = 0; i < 3; i++) square += center.position[i] * center.position[i];
    double arm = 1 + sqrt(square) / config->shell->radius;
    return 1 + arm * arm;
}

/* One body at most, and one that nothing shakes. */
static vxs_result check_body(const vxs_servo_config *config)
{
    uint32_t bodies = 0;
    double compliance = 0, square = config->coupling.sample_time * config->coupling.sample_time;
    for (uint32_t n = 0; n < config->effect_count; n++) {
        const vxs_effect_kind *stage = vxsi_effect_kind_of(&config->effects[n]);
        if (!stage->pose) continue;
        if (bodies++ || vxsi_coupling_kind_of(&config->coupling)->pose) return VXS_TWO_BODIES;
        compliance = stage->compliance(&config->effects[n], config);
    }
    for (uint32_t n = 0; n < config->effect_count; n++) {
        const vxs_effect_kind *stage = vxsi_effect_kind_of(&config->effects[n]);
        if (stage->stiffness &&
            stage->stiffness(&config->effects[n], config) * lever_of(config) * compliance * square >
                VXSI_EFFECT_SHARE)
            return VXS_TOO_STIFF;
    }
    return VXS_OK;
}

vxs_result vxs_servo_config_check(const vxs_servo_config *config)
{
    if (!config) return VXS_PARAM;
    if (config->struct_size != sizeof *config) return VXS_CONFIG;
    if (!config->statics || config->static_count < 1 || config->static_count > VXS_CONTACT_MAX_STATICS ||
        !config->shell)
        return VXS_PARAM;
    double rotation[9];
    for (uint32_t n = 0; n < config->static_count; n++) {
        const vxs_contact_static *at = &config->statics[n];
        if (!at->map || (at->pose && !vxs_pose_rotation(at->pose, rotation))) return VXS_PARAM;
    }
    if (!vxs_pose_rotation(&config->mount, rotation) || !vxs_pose_rotation(&config->grip, rotation))
        return VXS_PARAM;
    if (!is_positive(config->scale) || !is_positive(config->max_force) || !is_positive(config->max_torque))
        return VXS_PARAM;
    if (!(config->max_speed > 0) || !is_time(config->hold_time) || !is_time(config->decay_time) ||
        config->decay_time < 1e-6)
        return VXS_PARAM;
    vxs_result result = check_effects(config);
    if (result == VXS_OK) result = vxs_contact_config_check(&config->contact);
    for (uint32_t n = 0; n < config->static_count && result == VXS_OK; n++) {
        if (!vxs_contact_has_field(config->statics[n].map, config->contact.field)) result = VXS_CHANNEL;
    }
    if (result == VXS_OK && config->contact.weighting == VXS_CONTACT_AREA && !config->shell->area)
        result = VXS_NO_AREA;
    if (result == VXS_OK) result = vxs_coupling_config_check(&config->coupling);
    return result == VXS_OK ? check_body(config) : result;
}

static size_t round_up(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static size_t effect_memory(const vxs_effect *effect, const vxs_servo_config *config)
{
    const vxs_effect_kind *stage = vxsi_effect_kind_of(effect);
    return round_up(stage->size) + (stage->extra ? round_up(stage->extra(effect, config)) : 0);
}

size_t vxs_servo_memory(const vxs_servo_config *config)
{
    if (!config || !config->shell || config->static_count > VXS_CONTACT_MAX_STATICS ||
        check_effects(config) != VXS_OK)
        return 0;
    size_t effects = 0;
    for (uint32_t n = 0; n < config->effect_count; n++) effects += effect_memory(&config->effects[n], config);
    return round_up(sizeof(vxs_servo)) + effects + vxs_coupling_memory() +
           round_up(vxs_contact_memory(config->shell, config->static_count)) +
           (config->contact.most_points ? round_up(vxs_contact_levels_memory(config->shell)) : 0);
}

/* As bits of their kinds. */
static const uint32_t motor_guards = 1u << VXS_EFFECT_START_INSIDE | 1u << VXS_EFFECT_SOFT_START;

static const vxs_effect *find_effect(const vxs_servo_config *config, uint32_t kind)
{
    for (uint32_t n = 0; n < config->effect_count; n++)
        if (config->effects[n].kind == kind && !config->effects[n].own) return &config->effects[n];
    return NULL;
}

/* One more stage of the servo's tick; an effect's memory is at bytes. Returns how many of them it takes. */
static size_t list_step(vxs_servo *servo, const vxs_servo_config *config, const vxs_effect_kind *stage,
                        const vxs_effect *effect, uint32_t row, uint8_t *bytes)
{
    void *self = servo;
    size_t size = effect ? effect_memory(effect, config) : 0;
    if (effect) {
        self = bytes;
        memset(self, 0, size);
        if (stage->set_up) stage->set_up(self, effect, &servo->config);
        if (stage->attach) stage->attach(self, servo);
    }
    if (stage->add) servo->adders[servo->adder_count++] = (vxsi_adder){stage->add, self, row};
    if (stage->pose) {
        servo->pose = stage->pose;
        servo->pose_self = self;
    }
    servo->steps[servo->step_count++] = (vxsi_step){stage->run, self, stage->reset, row};
    return size;
}

/* The table's stages that the config calls for, in the table's order, each behind the own ones that run before
 * it; effects' memory from bytes on. */
static void list_steps(vxs_servo *servo, const vxs_servo_config *config, uint8_t *bytes)
{
    for (uint32_t n = 0; n < vxsi_servo_table_size; n++) {
        for (uint32_t m = 0; m < config->effect_count; m++) {
            const vxs_effect *own = &config->effects[m];
            if (own->own && vxsi_own_place(own->own) == n)
                bytes += list_step(servo, config, own->own, own, vxsi_servo_table_size + m, bytes);
        }
        const vxs_effect_kind *stage = vxsi_servo_table[n];
        const vxs_effect *effect = stage->effect ? find_effect(config, stage->effect) : NULL;
        if (stage->effect && !effect) continue;
        if (effect && effect->kind < 32) servo->guards |= (1u << effect->kind) & motor_guards;
        bytes += list_step(servo, config, stage, effect, n, bytes);
    }
}

/* The device's tip in the shell's frame: -R^T position of the grip. */
static void tip_in_shell(const vxs_pose *grip, double tip[3])
{
    double r[9];
    vxs_pose_rotation(grip, r);
    const double *p = grip->position;
    for (int i = 0; i < 3; i++) tip[i] = -((r[i] * p[0] + r[3 + i] * p[1]) + r[6 + i] * p[2]);
}

vxs_result vxs_servo_init(void *memory, size_t size, const vxs_servo_config *config, vxs_servo **out)
{
    vxs_result result = vxs_servo_config_check(config);
    if (result != VXS_OK) return result;
    if (!memory || !out) return VXS_PARAM;
    if ((uintptr_t)memory % ALIGNMENT != 0 || size < vxs_servo_memory(config)) return VXS_BUFFER;

    uint8_t *bytes = memory;
    vxs_servo *servo = memory;
    memset(servo, 0, sizeof *servo);
    servo->config = *config;
    double sample_time = config->coupling.sample_time;
    servo->config.effects = NULL;
    servo->config.effect_count = 0;
    if (servo->config.hold_time == 0) servo->config.hold_time = 2 * sample_time;
    tip_in_shell(&config->grip, servo->config.contact.reference);
    vxs_pose_rotation(&config->mount, servo->mount);
    servo->sample_ns = (int64_t)(sample_time * 1e9 + 0.5);
    servo->hold_ns = (int64_t)(servo->config.hold_time * 1e9 + 0.5);
    servo->decay_ns = (int64_t)(config->decay_time * 1e9 + 0.5);

    bytes += round_up(sizeof *servo);
    result = vxs_coupling_init(bytes, vxs_coupling_memory(), &config->coupling, &servo->coupling);
    bytes += vxs_coupling_memory();
    if (result == VXS_OK)
        result = vxs_contact_init(bytes, vxs_contact_memory(config->shell, config->static_count),
                                  config->shell, config->static_count, &servo->contact);
    bytes += round_up(vxs_contact_memory(config->shell, config->static_count));
    if (result == VXS_OK && config->contact.most_points)
        result = vxs_contact_add_levels(servo->contact, bytes, vxs_contact_levels_memory(config->shell));
    if (result != VXS_OK) return result;
    if (config->contact.most_points) bytes += round_up(vxs_contact_levels_memory(config->shell));
    servo->coupling->has_torque = 0;
    list_steps(servo, config, bytes);
    servo->has_body = servo->pose || servo->coupling->kind->has_body;
    *out = servo;
    return result;
}

vxs_result vxs_servo_may_drive(const vxs_servo *servo, const vxs_device_caps *caps)
{
    if (!servo || !caps) return VXS_PARAM;
    return caps->has_motors && servo->guards != motor_guards ? VXS_UNGUARDED : VXS_OK;
}

vxs_result vxs_servo_stage_at(uint32_t number, vxs_servo_stage *stage)
{
    if (number >= vxsi_servo_table_size || !stage) return VXS_PARAM;
    const vxs_effect_kind *row = vxsi_servo_table[number];
    *stage = (vxs_servo_stage){row->name, row->reads, row->changes, row->effect, 0};
    return VXS_OK;
}
