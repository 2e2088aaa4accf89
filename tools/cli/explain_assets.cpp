// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/explain_assets.hpp"

#include "cli/options.hpp"
#include "plan/scene_effects.hpp"

#include "voxshell/format/plan.h"
#include "voxshell/format/pointshell.h"
#include "voxshell/format/voxmap.h"

#include <fmt/format.h>

#include <cstring>

namespace voxshell {
namespace {

std::string distance_readers(const SceneFile &scene)
{
    std::string text;
    const auto add = [&](const std::string &more) { text += (text.empty() ? "" : ", ") + more; };
    if (scene.law == ContactLaw::gradient) add("law gradient");
    if (scene.field == ContactField::distance) add("field distance");
    if (distance_reach(scene) > 0)
        add(fmt::format("an effect that looks {} far", format_length(distance_reach(scene))));
    return text.empty() ? "nothing in this scene: --channels asked for it" : text;
}

/// What reads a section; empty for one that is not known.
std::string reader(const SceneFile &scene, std::uint32_t id)
{
    switch (id) {
    case VXS_VOXMAP_SECTION_GRID:
        return "contact: where cells are";
    case VXS_VOXMAP_SECTION_ROOT:
    case VXS_VOXMAP_SECTION_CHNK:
    case VXS_VOXMAP_SECTION_BRIK:
        return "contact: which cell a point is in";
    case VXS_VOXMAP_SECTION_LAYR:
        return scene.field == ContactField::layers ? "field layers"
                                                   : "nothing in this scene: --channels asked for it";
    case VXS_VOXMAP_SECTION_DIST:
        return distance_readers(scene);
    case VXS_VOXMAP_SECTION_CLRX:
    case VXS_VOXMAP_SECTION_CLRV:
    case VXS_VOXMAP_SECTION_CLRC:
    case VXS_VOXMAP_SECTION_CLRP:
        return "contact: which points need no look";
    case VXS_POINTSHELL_SECTION_SHEL:
        return "contact: how many points there are";
    case VXS_POINTSHELL_SECTION_POSX:
    case VXS_POINTSHELL_SECTION_POSY:
    case VXS_POINTSHELL_SECTION_POSZ:
        return "contact: where points are";
    case VXS_POINTSHELL_SECTION_NRMX:
    case VXS_POINTSHELL_SECTION_NRMY:
    case VXS_POINTSHELL_SECTION_NRMZ:
        return "contact: where points push";
    case VXS_POINTSHELL_SECTION_AREA:
        return "weighting area";
    case VXS_POINTSHELL_SECTION_CLUS:
        return "contact: which points need no look";
    case VXS_PLAN_SECTION_PLAN:
        return "the servo's config";
    case VXS_PLAN_SECTION_ASST:
        return "which assets, and that they are these";
    case VXS_PLAN_SECTION_EFCT:
        return fmt::format("the {} effects that the scene asks for", scene.effects.size());
    case VXS_PLAN_SECTION_MOVE:
        return "the effect motion";
    case VXS_PLAN_SECTION_HAND:
        return "the hand of a simulated run";
    case VXS_SECTION_META:
        return "people";
    default:
        return "";
    }
}

} // namespace

void explain_asset(const SceneFile &scene, const std::string &name, std::span<const std::uint8_t> bytes)
{
    vxs_container_header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    std::uint64_t named = 0;
    for (std::uint32_t n = 0; n < header.section_count; ++n) {
        vxs_container_section entry;
        std::memcpy(&entry, bytes.data() + sizeof header + n * sizeof entry, sizeof entry);
        char id[5] = {};
        std::memcpy(id, &entry.id, 4);
        fmt::print("  {:<24} {} {:>12} bytes  {}\n", n == 0 ? name : "", id, format_count(entry.size),
                   reader(scene, entry.id));
        named += entry.size;
    }
    if (header.required_features & VXS_POINTSHELL_FEATURE_NO_AREA && name.ends_with(".pointshell"))
        fmt::print("  {:<24} AREA {:>12} bytes  left out: no weighting area\n", "", 0);
    fmt::print("  {:<24}      {:>12} bytes  header, table, padding to 64\n", "",
               format_count(bytes.size() - named));
}

} // namespace voxshell
