// SPDX-License-Identifier: GPL-3.0-or-later
// What is in an asset, for people and for programs: what inspect prints and a page shows.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

/// A first line that answers most questions and rows for the rest; and all of it as JSON
/// (formats/schema/inspect.schema.json).
struct AssetFacts {
    struct Row {
        std::string name, value;
    };
    std::string first;
    std::vector<Row> rows;
    nlohmann::ordered_json as_json;
};

/// Throws as asset_kind() and the reader of its kind.
AssetFacts asset_facts(const std::filesystem::path &path);

} // namespace voxshell
