/* SPDX-License-Identifier: MIT
 *
 * The stages that every tick has. rt-safe.
 */
#include "servo_state.h"

#include <string.h>

static void evaluate_contact(void *self, vxs_tick *tick)
{
    vxs_servo *servo = self;
    uint32_t flags;
    for (;; tick->evaluation++) {
        vxs_pose object;
        if (servo->pose)
            servo->pose(servo->pose_self, &tick->tip, &tick->body);
        else
            vxs_coupling_pose(servo->coupling, &tick->tip, &tick->body);
        if (!vxs_pose_compose(&tick->body, &servo->config.grip, &object)) {
            tick->flags |= VXS_SERVO_FAULT;
            return;
        }
        flags = vxs_contact_evaluate(servo->contact, servo->config.statics, servo->config.static_count,
                                     &object, &servo->config.contact, &tick->contact);
        tick->wrench = tick->contact.wrench;
        if (flags & VXS_CONTACT_INVALID) break;
        for (const vxsi_adder *a = servo->adders; a < servo->adders + servo->adder_count; a++)
            a->add(a->self, tick);
        if (!servo->is_live ||
            !vxs_coupling_refine(servo->coupling, &tick->wrench, tick->contact.depth, &tick->tip))
            break;
    }
    tick->flags |= flags;
    if (flags & VXS_CONTACT_INVALID)
        tick->flags |= VXS_SERVO_FAULT;
    else if (!tick->is_armed)
        tick->flags |= VXS_SERVO_OFF;
}

static void to_device_frame(const vxs_servo *servo, const double v[3], double out[3])
{
    const double *r = servo->mount;
    for (int i = 0; i < 3; i++) out[i] = (r[i] * v[0] + r[3 + i] * v[1]) + r[6 + i] * v[2];
}

static void couple(void *self, vxs_tick *tick)
{
    vxs_servo *servo = self;
    if (vxs_coupling_step(servo->coupling, &tick->wrench, &tick->tip, &tick->output) & VXS_COUPLING_INVALID)
        tick->flags |= VXS_SERVO_FAULT;
    if (tick->has_field) vxs_wrench_add(&tick->output, &tick->field);
    to_device_frame(servo, tick->output.force, tick->wrench.force);
    if (servo->has_torque) {
        to_device_frame(servo, tick->output.torque, tick->wrench.torque);
    } else {
        memset(tick->output.torque, 0, sizeof tick->output.torque);
        memset(tick->wrench.torque, 0, sizeof tick->wrench.torque);
    }
}

static void reset_coupling(void *self, const vxs_pose *tip)
{
    vxs_servo *servo = self;
    vxs_coupling_reset(servo->coupling, tip);
}

static int clamp(double v[3], double limit)
{
    double factor = vxs_device_clamp_factor(v, limit);
    for (int axis = 0; axis < 3; axis++) v[axis] *= factor;
    return factor < 1;
}

static void clamp_both(void *self, vxs_tick *tick)
{
    const vxs_servo *servo = self;
    if (clamp(tick->wrench.force, servo->config.max_force)) tick->flags |= VXS_SERVO_SATURATED;
    if (servo->has_torque && clamp(tick->wrench.torque, servo->config.max_torque))
        tick->flags |= VXS_SERVO_SATURATED;
}

extern const vxs_effect_kind vxsi_stage_contact, vxsi_stage_coupling, vxsi_stage_clamp;
const vxs_effect_kind vxsi_stage_contact = {
    .name = "contact", .reads = "the object's pose; cells, points, normals", .run = evaluate_contact};
const vxs_effect_kind vxsi_stage_coupling = {.name = "coupling",
                                             .reads = "contact's wrench, the device's pose",
                                             .reset = reset_coupling,
                                             .run = couple};
const vxs_effect_kind vxsi_stage_clamp = {
    .name = "clamp", .reads = "max_force, max_torque", .run = clamp_both};
