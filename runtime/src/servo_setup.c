/* SPDX-License-Identifier: MIT
 *
 * Set-up of the servo.
 */
#include "servo_state.h"

#include <math.h>
#include <string.h>

enum { ALIGNMENT = 16 };

static const double full_force_time = 0.004; /* [s] of the default slew limit */

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
    config->ramp_time = 0.5;
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
        if (config->contact.law == VXS_CONTACT_GRADIENT && !vxs_contact_has_signed_distance(at->map))
            return VXS_PARAM;
    }
    if (!vxs_pose_rotation(&config->mount, rotation) || !vxs_pose_rotation(&config->grip, rotation))
        return VXS_PARAM;
    if (!is_positive(config->scale) || !is_positive(config->max_force) || !is_positive(config->max_torque))
        return VXS_PARAM;
    if (!(config->max_slew >= 0) || !(config->max_speed > 0) || !is_time(config->ramp_time) ||
        !is_time(config->hold_time) || !is_time(config->decay_time) || config->decay_time < 1e-6)
        return VXS_PARAM;
    vxs_result result = vxs_contact_config_check(&config->contact);
    return result == VXS_OK ? vxs_coupling_config_check(&config->coupling) : result;
}

static size_t round_up(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

size_t vxs_servo_memory(const vxs_servo_config *config)
{
    if (!config || !config->shell || config->static_count > VXS_CONTACT_MAX_STATICS) return 0;
    return round_up(sizeof(vxs_servo)) + vxs_coupling_memory() +
           round_up(vxs_contact_memory(config->shell, config->static_count)) +
           (config->contact.most_points ? vxs_contact_levels_memory(config->shell) : 0);
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
    if (servo->config.max_slew == 0) servo->config.max_slew = config->max_force / full_force_time;
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
    if (result == VXS_OK) *out = servo;
    return result;
}
