// SPDX-License-Identifier: MIT
// A coupling and an effect of one's own in C++: what the headers promise of them, and what they refuse.
#include <voxshell/voxshell.h>

#include <cstdio>
#include <initializer_list>

namespace {

struct spring {
    double force;
};
VXS_COUPLING_FITS(spring);

void half(vxs_coupling *, const vxs_wrench *contact, const vxs_pose *, vxs_wrench *out)
{
    for (int i = 0; i < 3; i++)
        out->force[i] = contact->force[i] / 2, out->torque[i] = contact->torque[i] / 2;
}

void push(void *self, vxs_tick *tick)
{
    const vxs_wrench wrench = {{*static_cast<double *>(self), 0, 0}, {0, 0, 0}};
    vxs_tick_add_to_hand(tick, &wrench);
}

vxs_coupling_kind a_coupling()
{
    vxs_coupling_kind kind = {};
    kind.struct_size = sizeof kind;
    kind.coupling_size = sizeof(vxs_coupling);
    kind.name = "half";
    kind.step = half;
    return kind;
}

vxs_effect_kind an_effect()
{
    vxs_effect_kind kind = {};
    kind.struct_size = sizeof kind;
    kind.tick_size = sizeof(vxs_tick);
    kind.name = "push";
    kind.size = sizeof(double);
    kind.run = push;
    return kind;
}

int failures = 0;
void check(bool holds, const char *what)
{
    if (!holds) std::printf("%s: does not hold\n", what), failures++;
}

vxs_result checked(const vxs_coupling_kind &kind, uint32_t number = VXS_COUPLING_OWN)
{
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = number;
    config.own = &kind;
    return vxs_coupling_config_check(&config);
}

vxs_result checked(const vxs_effect_kind &kind)
{
    vxs_effect effect;
    return vxs_effect_own(&kind, &effect);
}

void couplings()
{
    vxs_coupling_kind kind = a_coupling();
    check(checked(kind) == VXS_OK, "a coupling");
    check(checked(kind, VXS_COUPLING_PT2) == VXS_PARAM, "an own coupling beside voxshell's number");
    kind.struct_size--;
    check(checked(kind) == VXS_CONFIG, "a coupling of other headers");
    kind = a_coupling(), kind.coupling_size++;
    check(checked(kind) == VXS_CONFIG, "a coupling with another state");
    kind = a_coupling(), kind.step = nullptr;
    check(checked(kind) == VXS_PARAM, "a coupling without step");
    kind = a_coupling(), kind.name = nullptr;
    check(checked(kind) == VXS_PARAM, "a coupling without a name");
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = VXS_COUPLING_OWN;
    check(vxs_coupling_config_check(&config) == VXS_PARAM, "an own coupling without a kind");

    kind = a_coupling();
    config.own = &kind;
    alignas(16) static unsigned char memory[2048];
    vxs_coupling *coupling;
    check(vxs_coupling_init(memory, sizeof memory, &config, &coupling) == VXS_OK, "init");
    const vxs_wrench in = {{2, 0, 0}, {0, 0, 4}};
    const vxs_pose pose = vxs_pose_identity();
    vxs_wrench out;
    check(vxs_coupling_step(coupling, &in, &pose, &out) == 0 && out.force[0] == 1 && out.torque[2] == 2,
          "step");
}

void effects()
{
    vxs_effect_kind kind = an_effect();
    check(checked(kind) == VXS_OK, "an effect");
    kind.tick_size--;
    check(checked(kind) == VXS_CONFIG, "an effect of other headers");
    kind = an_effect(), kind.struct_size++;
    check(checked(kind) == VXS_CONFIG, "an effect's other struct");
    kind = an_effect(), kind.name = nullptr;
    check(checked(kind) == VXS_PARAM, "an effect without a name");
    kind = an_effect(), kind.run = nullptr;
    check(checked(kind) == VXS_PARAM, "an effect that does nothing");
    kind = an_effect(), kind.constant_count = 1;
    check(checked(kind) == VXS_PARAM, "an effect without its constants");
    const vxs_effect_constant many[VXS_EFFECT_MAX_CONSTANTS + 1] = {};
    kind.constants = many, kind.constant_count = VXS_EFFECT_MAX_CONSTANTS + 1;
    check(checked(kind) == VXS_PARAM, "an effect with too many constants");
    for (const char *before : {"contact", "gravity", "torque", "coupling", "passivity"}) {
        kind = an_effect(), kind.before = before;
        check(checked(kind) == VXS_OK, before);
    }
    for (const char *before : {"slew", "clamp", "soft-start", "no-such-stage"}) {
        kind = an_effect(), kind.before = before;
        check(checked(kind) == VXS_PARAM, before);
    }

    kind = an_effect();
    const vxs_effect_constant force = {"force", "N", 1, 0, 10};
    kind.constants = &force, kind.constant_count = 1;
    vxs_effect effect;
    check(vxs_effect_own(&kind, &effect) == VXS_OK && effect.as.constants[0] == 1, "its default");
    check(vxs_effect_check(&effect) == VXS_OK, "check");
    effect.as.constants[0] = 11;
    check(vxs_effect_check(&effect) == VXS_PARAM, "beyond its range");
    effect.as.constants[0] = 1, effect.kind = VXS_EFFECT_SLEW;
    check(vxs_effect_check(&effect) == VXS_PARAM, "an own effect beside voxshell's number");
    effect.kind = VXS_EFFECT_OWN, effect.own = nullptr;
    check(vxs_effect_check(&effect) == VXS_PARAM, "an own effect without a kind");
}

} // namespace

int main()
{
    couplings();
    effects();
    if (!failures) std::printf("own kinds: as they say\n");
    return failures != 0;
}
