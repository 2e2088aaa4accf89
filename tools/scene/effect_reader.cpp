// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/effect_reader.hpp"

#include "cli/failure.hpp"

#include "voxshell/servo.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace voxshell {
namespace {

constexpr std::size_t most_items = 64;

/// A key of an effect: one constant, or three in a row as a list.
struct Key {
    std::string_view name;
    std::uint32_t first, count;
};

bool is_component(std::string_view name, std::string_view vector, char axis)
{
    return name.size() == vector.size() + 2 && name.starts_with(vector) && name[vector.size()] == '_' &&
           name.back() == axis;
}

std::vector<Key> keys_of(std::span<const vxs_effect_constant> constants)
{
    std::vector<Key> keys;
    for (std::uint32_t n = 0; n < constants.size(); ++n) {
        const std::string_view name = constants[n].name,
                               vector = name.substr(0, name.size() - std::min<std::size_t>(2, name.size()));
        const bool is_vector = n + 2 < constants.size() && is_component(name, vector, 'x') &&
                               is_component(constants[n + 1].name, vector, 'y') &&
                               is_component(constants[n + 2].name, vector, 'z');
        keys.push_back({is_vector ? vector : name, n, is_vector ? 3u : 1u});
        n += keys.back().count - 1;
    }
    return keys;
}

double constant(const JsonPlace &at, const vxs_effect_constant &as)
{
    const std::string_view unit = as.unit;
    double value;
    if (unit.empty()) {
        value = at.number();
    } else {
        const auto dimension = dimension_of(unit);
        if (!dimension)
            throw Failure(ExitCode::bug, "",
                          fmt::format("constant {} has a unit that no scene can say: {}", as.name, unit));
        value = at.quantity(*dimension);
    }
    if (!(value >= as.least && value <= as.most))
        at.refuse(fmt::format("must be {:g}{} to {:g}{}", as.least, unit, as.most, unit));
    return value;
}

SceneEffect effect(const JsonPlace &at, std::uint32_t kind)
{
    SceneEffect result;
    result.place = at.pointer();
    vxs_effect_default(kind, &result.effect);
    std::uint32_t count = 0;
    const vxs_effect_constant *table = vxs_effect_constants(kind, &count);
    const std::span constants(table, count);
    const std::vector<Key> keys = keys_of(constants);
    std::vector<std::string_view> names{"kind"};
    for (const Key &key : keys) names.push_back(key.name);
    const JsonObject object(at, names);
    for (const Key &key : keys) {
        const auto found = object.find(key.name);
        if (!found) continue;
        const std::vector<JsonPlace> values =
            key.count == 1 ? std::vector{*found} : found->items(key.count, key.count);
        for (std::uint32_t n = 0; n < key.count; ++n) {
            result.effect.as.constants[key.first + n] = constant(values[n], constants[key.first + n]);
            result.said |= 1u << (key.first + n);
        }
    }
    return result;
}

/// The kinds that a list may name.
std::vector<std::string_view> kinds(bool guards)
{
    std::vector<std::string_view> names;
    for (std::uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; ++n) {
        if ((vxs_effect_is_guard(kind) != 0) == guards) names.push_back(vxs_effect_kind_name(kind));
    }
    return names;
}

void read_list(const JsonPlace &list, bool guards, std::vector<SceneEffect> &effects)
{
    for (const JsonPlace &item : list.items(0, most_items)) {
        const JsonPlace name = JsonObject::any(item).get("kind");
        const std::uint32_t kind = vxs_effect_kind_named(name.string("the name of a kind").c_str());
        if (kind && (vxs_effect_is_guard(kind) != 0) != guards) {
            name.refuse(guards ? "is an effect: it belongs into \"effects\""
                               : "is a guard: it belongs into \"guards\"");
        }
        if (!kind) {
            const std::vector<std::string_view> known = kinds(guards);
            if (known.empty()) name.refuse("there are no effects but guards");
            name.choice(known);
        }
        if (std::any_of(effects.begin(), effects.end(),
                        [&](const SceneEffect &e) { return e.effect.kind == kind; })) {
            name.refuse("is there already");
        }
        effects.push_back(effect(item, kind));
    }
}

} // namespace

std::vector<SceneEffect> read_effects(const std::optional<JsonPlace> &guards,
                                      const std::optional<JsonPlace> &effects)
{
    std::vector<SceneEffect> result;
    if (guards) {
        read_list(*guards, true, result);
    } else {
        vxs_servo_config standard;
        vxs_servo_config_default(&standard);
        for (const vxs_effect &effect : std::span(standard.effects, standard.effect_count)) {
            if (vxs_effect_is_guard(effect.kind)) result.push_back({effect, 0, "/guards"});
        }
    }
    if (effects) read_list(*effects, false, result);
    return result;
}

} // namespace voxshell
