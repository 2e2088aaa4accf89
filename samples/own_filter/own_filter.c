/* SPDX-License-Identifier: MIT
 *
 * A laboratory's own coupling: what stands between contact and the hand. Here a low-pass of first order. From
 * "the coupling" to "its use" is all that one has to write. Usage: own_filter SCENE.plan
 */
#include "../scene.h"

#include "voxshell/coupling_kind.h"
#include "voxshell/simulated.h"

/* --- the coupling: six axes, one state each --- */

typedef struct lag {
    double share, axes[6];
} lag;
VXS_COUPLING_FITS(lag);

static vxs_result check(const vxs_coupling_config *config)
{
    return config->omega0 > 0 ? VXS_OK : VXS_FREQUENCY;
}

static void set_up(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    double way = config->omega0 * config->sample_time; /* implicit Euler: stable for any */
    ((lag *)coupling->state)->share = way / (1 + way);
}

static void reset(vxs_coupling *coupling, const vxs_pose *device)
{
    (void)device;
    memset(((lag *)coupling->state)->axes, 0, sizeof(double[6]));
}

static void step(vxs_coupling *coupling, const vxs_wrench *contact, const vxs_pose *device, vxs_wrench *out)
{
    (void)device;
    lag *l = (lag *)coupling->state;
    for (int axis = 0; axis < 6; axis++) {
        double in = axis < 3 ? contact->force[axis] : contact->torque[axis - 3];
        l->axes[axis] = vxs_without_denormals(l->axes[axis] + l->share * (in - l->axes[axis]));
        *(axis < 3 ? &out->force[axis] : &out->torque[axis - 3]) = l->axes[axis];
    }
}

static const vxs_coupling_kind lab_lag = {.struct_size = sizeof(vxs_coupling_kind),
                                          .coupling_size = sizeof(vxs_coupling),
                                          .name = "lab-lag",
                                          .check = check,
                                          .set_up = set_up,
                                          .reset = reset,
                                          .step = step};

/* --- its use: the scene's hand presses the sphere into the wall, the coupling is ours --- */

int main(int count, char **arguments)
{
    scene s;
    if (count != 2 || !scene_open(&s, arguments[1])) {
        fprintf(stderr, "usage: own_filter SCENE.plan\n");
        return 1;
    }
    s.config.coupling.kind = VXS_COUPLING_OWN;
    s.config.coupling.own = &lab_lag;
    s.config.coupling.omega0 = 2 * 3.14159265358979 * 20; /* 20 Hz */
    s.config.contact.most_stiffness = 400; /* a filter alone carries no more (voxshell design) */
    vxs_servo *servo = scene_servo(&s);
    vxs_simulated_config simulated;
    vxs_simulated_config_default(&simulated, NULL);
    simulated.start.position[0] = 0.075;
    simulated.start.position[1] = 0.04;
    void *memory = scene_memory(vxs_simulated_memory());
    vxs_device *device;
    if (!servo || vxs_simulated_open(memory, vxs_simulated_memory(), &simulated, &device) != VXS_OK) return 1;

    vxs_device_arm(device);
    vxs_device_state state;
    vxs_device_command command = {0};
    vxs_servo_trace row;
    uint32_t seen = 0;
    for (int n = 0; n < 3000; n++) {
        double share = n < 800 ? 0 : n < 1200 ? (n - 800) / 400.0 : 1;
        vxs_simulated_hand(device, (double[3]){0.075 - 0.028 * share, 0.04, 0}, NULL);
        vxs_device_exchange(device, &command, &state, NULL);
        seen |= vxs_servo_tick(servo, &state, &command, &row);
    }
    printf("%s: collision %.3f N, the hand feels %.3f N; flags of all ticks %#x\n", lab_lag.name,
           row.collision.force[0], row.output.force[0], (unsigned)seen);
    vxs_device_close(device);
    free(memory);
    scene_close(&s);
    return 0;
}
