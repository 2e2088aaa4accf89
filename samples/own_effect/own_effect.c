/* SPDX-License-Identifier: MIT
 *
 * A laboratory's own effect: a force that a scene of theirs asks for. Here a magnet that draws the tip to a point.
 * From "the effect" to "its use" is all that one has to write. Usage: own_effect SCENE.plan
 */
#include "../scene.h"

#include "voxshell/effect_kind.h"

/* --- the effect: towards a point, strongest at `reach` from it, nothing at the point and far away --- */

static const vxs_effect_constant constants[] = {{"at_x", "m", 0, -1e3, 1e3},
                                                {"at_y", "m", 0, -1e3, 1e3},
                                                {"at_z", "m", 0, -1e3, 1e3},
                                                {"force", "N", 1, 0, 100},
                                                {"reach", "m", 0.01, 1e-6, 1e3}};

typedef struct magnet {
    double at[3], force, reach;
} magnet;

static void set_up(void *self, const vxs_effect *effect, const vxs_servo_config *config)
{
    (void)config;
    memcpy(self, effect->as.constants, sizeof(magnet));
}

/* F = 2 f (r/a) / (1 + (r/a)^2): the slope of an energy, so that nothing is gained on a round trip. */
static void run(void *self, vxs_tick *tick)
{
    const magnet *m = self;
    double way[3], square = 0;
    for (int i = 0; i < 3; i++) {
        way[i] = (m->at[i] - tick->tip.position[i]) / m->reach;
        square += way[i] * way[i];
    }
    vxs_wrench pull = {{0, 0, 0}, {0, 0, 0}};
    for (int i = 0; i < 3; i++) pull.force[i] = 2 * m->force * way[i] / (1 + square);
    vxs_tick_add_to_hand(tick, &pull);
}

static const vxs_effect_kind lab_magnet = {.struct_size = sizeof(vxs_effect_kind),
                                           .tick_size = sizeof(vxs_tick),
                                           .name = "lab-magnet",
                                           .reads = "the tip's position",
                                           .size = sizeof(magnet),
                                           .constants = constants,
                                           .constant_count = sizeof constants / sizeof *constants,
                                           .set_up = set_up,
                                           .run = run};

/* --- its use: the scene's own effects, and the magnet at the cup's wall --- */

int main(int count, char **arguments)
{
    scene s;
    if (count != 2 || !scene_open(&s, arguments[1])) {
        fprintf(stderr, "usage: own_effect SCENE.plan\n");
        return 1;
    }
    vxs_effect effects[8];
    uint32_t most = sizeof effects / sizeof *effects - 1;
    if (s.config.effect_count > most) return 1;
    memcpy(effects, s.config.effects, s.config.effect_count * sizeof *effects);
    vxs_effect *ours = &effects[s.config.effect_count++];
    if (vxs_effect_own(&lab_magnet, ours) != VXS_OK) return 1;
    const double at[3] = {0.065, 0.04, 0};
    memcpy(ours->as.constants, at, sizeof at);
    s.config.effects = effects;
    vxs_servo *servo = scene_servo(&s);
    if (!servo) return 1;

    vxs_device_state state = {.state = VXS_DEVICE_ARMED, .pose = vxs_pose_identity()};
    vxs_device_command command;
    for (int n = 0; n < 1500; n++) { /* past the soft-start, then from 85 to 65 mm */
        state.sequence++;
        state.time_ns = n * INT64_C(1000000);
        state.pose.position[0] = n < 1000 ? 0.085 : 0.085 - 4e-5 * (n - 999);
        state.pose.position[1] = 0.04;
        vxs_servo_tick(servo, &state, &command, NULL);
        if (n >= 999 && (n - 999) % 125 == 0)
            printf("%.1f mm: %.4f N\n", 1e3 * state.pose.position[0], command.wrench.force[0]);
    }
    scene_close(&s);
    return 0;
}
