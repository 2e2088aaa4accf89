// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/plan_file.hpp"

#include "cli/failure.hpp"
#include "container/asset_file.hpp"

#include "voxshell/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace voxshell {
namespace {

/// The bytes where the runtime takes them from, on a line's boundary.
class Aligned {
  public:
    explicit Aligned(std::span<const std::uint8_t> bytes)
        : bytes_(static_cast<std::uint8_t *>(::operator new(bytes.size(), std::align_val_t(64))))
    {
        std::ranges::copy(bytes, bytes_);
    }
    ~Aligned() { ::operator delete(bytes_, std::align_val_t(64)); }
    Aligned(const Aligned &) = delete;
    Aligned &operator=(const Aligned &) = delete;
    const std::uint8_t *get() const { return bytes_; }

  private:
    std::uint8_t *bytes_;
};

} // namespace

std::vector<std::uint8_t> plan_bytes(const PlanFile &file)
{
    std::vector<Section> sections;
    const auto add = [&]<typename T>(std::uint32_t id, std::span<const T> elements) {
        if (!elements.empty()) sections.push_back(make_section(id, sizeof(T), elements));
    };
    add(VXS_PLAN_SECTION_PLAN, std::span(&file.info, 1));
    add(VXS_PLAN_SECTION_ASST, std::span(file.assets));
    add(VXS_PLAN_SECTION_EFCT, std::span(file.effects));
    add(VXS_PLAN_SECTION_HAND, std::span(file.hand));
    add(VXS_PLAN_SECTION_MOVE, std::span(file.moves));
    sections.push_back(make_section(VXS_SECTION_META, 1, std::span<const char>(file.meta)));
    std::vector<std::uint8_t> bytes = container_bytes(VXS_PLAN_MAGIC, VXS_PLAN_VERSION_MAJOR,
                                                      VXS_PLAN_VERSION_MINOR, file.source_hash, sections);
    const Aligned copy(bytes);
    vxs_asset asset;
    vxs_asset_issue issue;
    if (vxs_asset_from_memory(copy.get(), bytes.size(), nullptr, &asset, &issue) != VXS_OK) {
        throw Failure(
            ExitCode::invalid, "",
            fmt::format("no plan can hold this: rule {}{}: {}", issue.letter, issue.rule, issue.text));
    }
    return bytes;
}

PlanFile read_plan(const std::filesystem::path &path)
{
    const AssetFile file(path, VXS_ASSET_PLAN);
    vxs_plan view;
    if (vxs_plan_open(&file.asset(), &view) != VXS_OK)
        throw Failure(ExitCode::bug, path.string(), "a checked plan has no view");
    PlanFile out;
    out.info = *view.info;
    out.assets.assign(view.assets, view.assets + view.asset_count);
    out.effects.assign(view.effects, view.effects + view.effect_count);
    out.hand.assign(view.hand, view.hand + view.hand_count);
    out.moves.assign(view.moves, view.moves + view.move_count);
    out.source_hash = file.source_hash();
    out.meta = file.meta();
    return out;
}

void put_text(std::span<std::uint8_t> field, std::string_view text)
{
    if (text.size() >= field.size()) {
        throw Failure(ExitCode::invalid, "",
                      fmt::format("\"{}\" is longer than a plan's {} bytes", text, field.size() - 1));
    }
    std::ranges::fill(field, std::uint8_t{0});
    std::ranges::copy(text, field.begin());
}

std::string text_of(std::span<const std::uint8_t> field)
{
    return {field.begin(), std::find(field.begin(), field.end(), 0)};
}

} // namespace voxshell
