// SPDX-License-Identifier: GPL-3.0-or-later
// Reads JSON properties strictly: every wrong type, missing property or value out of range is a Failure that
// says where ("nodes[3].mesh: 7 is not below 4").
#pragma once

#include "import/importers.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <set>

namespace voxshell {

using Json = nlohmann::json;

/// The JSON of a document. A data URI can be most of the file: it is not copied but stays where it is in the
/// file's bytes.
struct GltfJson {
    std::string text;                          ///< "" stands where the value of a "uri" was a data URI
    std::vector<std::span<std::uint8_t>> uris; ///< these data URIs, in their order in the file
    Json json; ///< of `text`; a binary value, its subtype a place in `uris`, for each
};

/// Of `text`, which lies in `source.bytes`. Failure(invalid) when it is no JSON, or nested too deeply for
/// readers that recurse.
GltfJson parse_json(const Source &source, std::string_view text);

/// Types of the properties that mean the same all over glTF but have nothing to do with geometry (materials,
/// animations...): a file with a string for a number was not written by something that can be trusted.
void check_side_properties(const Source &source, const Json &value, const std::string &where);

class GltfObject {
  public:
    GltfObject(const Source &source, const Json &json, std::string where)
        : source_(source), json_(json), where_(std::move(where))
    {
        if (!json.is_object())
            source_.invalid(fmt::format("{} is not an object", where_.empty() ? "the JSON" : where_));
    }

    [[noreturn]] void fail(const char *key, const std::string &what) const
    {
        source_.invalid(fmt::format("{}: {}", at(key), what));
    }

    std::string at(const char *key) const { return where_.empty() ? key : where_ + "." + key; }
    const std::string &where() const { return where_; }
    const Json &json() const { return json_; }

    const Json *find(const char *key) const
    {
        const auto it = json_.find(key);
        return it == json_.end() ? nullptr : &*it;
    }
    bool has(const char *key) const { return find(key) != nullptr; }

    /// An integer in [low, high]; "3.0" is one too, as JSON has no integers of its own.
    std::optional<std::uint64_t> integer(const char *key, std::uint64_t low, std::uint64_t high) const
    {
        const Json *value = find(key);
        if (!value) return {};
        return integer_of(*value, key, low, high);
    }

    std::uint64_t required_integer(const char *key, std::uint64_t low, std::uint64_t high) const
    {
        const auto value = integer(key, low, high);
        if (!value) fail(key, "missing");
        return *value;
    }

    /// Index into a collection of `size` elements.
    std::optional<std::uint64_t> reference(const char *key, std::size_t size) const
    {
        const auto value = integer(key, 0, std::numeric_limits<std::int32_t>::max());
        if (value && *value >= size) fail(key, fmt::format("{} does not exist, there are {}", *value, size));
        return value;
    }

    std::uint64_t required_reference(const char *key, std::size_t size) const
    {
        const auto value = reference(key, size);
        if (!value) fail(key, "missing");
        return *value;
    }

    std::vector<std::uint64_t> references(const char *key, std::size_t size) const
    {
        std::vector<std::uint64_t> out;
        std::set<std::uint64_t> seen;
        for (const Json &value : array(key)) {
            const std::uint64_t index = integer_of(value, key, 0, std::numeric_limits<std::int32_t>::max());
            if (index >= size) fail(key, fmt::format("{} does not exist, there are {}", index, size));
            if (!seen.insert(index).second) fail(key, fmt::format("{} is listed twice", index));
            out.push_back(index);
        }
        return out;
    }

    std::optional<std::string> text(const char *key) const
    {
        const Json *value = find(key);
        if (!value) return {};
        if (!value->is_string()) fail(key, "not a string");
        return value->get<std::string>();
    }

    bool flag(const char *key) const
    {
        const Json *value = find(key);
        if (value && !value->is_boolean()) fail(key, "neither true nor false");
        return value && value->get<bool>();
    }

    /// Exactly `size` numbers; empty when the property is absent.
    std::vector<double> numbers(const char *key, std::size_t size) const
    {
        if (!has(key)) return {};
        std::vector<double> out;
        for (const Json &value : array(key)) {
            if (!value.is_number()) fail(key, "not an array of numbers");
            out.push_back(value.get<double>());
            if (!std::isfinite(out.back())) fail(key, "not finite");
        }
        if (out.size() != size) fail(key, fmt::format("{} numbers instead of {}", out.size(), size));
        return out;
    }

    /// The array at `key`; an empty one when the property is absent.
    const Json &array(const char *key) const
    {
        static const Json none = Json::array();
        const Json *value = find(key);
        if (value && !value->is_array()) fail(key, "not an array");
        return value ? *value : none;
    }

    std::optional<GltfObject> object(const char *key) const
    {
        const Json *value = find(key);
        if (!value) return {};
        return GltfObject(source_, *value, at(key));
    }

    GltfObject required_object(const char *key) const
    {
        auto value = object(key);
        if (!value) fail(key, "missing");
        return *value;
    }

    std::optional<GltfObject> extension(const char *name) const
    {
        const auto all = object("extensions");
        return all ? all->object(name) : std::nullopt;
    }

    std::vector<GltfObject> objects(const char *key) const
    {
        std::vector<GltfObject> out;
        for (const Json &value : array(key))
            out.emplace_back(source_, value, fmt::format("{}[{}]", at(key), out.size()));
        return out;
    }

  private:
    std::uint64_t integer_of(const Json &value, const char *key, std::uint64_t low, std::uint64_t high) const
    {
        constexpr double exact = 9007199254740992.0; // 2^53
        if (!value.is_number()) fail(key, "not a number");
        const double x = value.get<double>();
        if (x != std::floor(x)) fail(key, "not an integer");
        if (x < static_cast<double>(low) || x > exact || x > static_cast<double>(high)) {
            fail(key, fmt::format("{} is out of range", value.dump()));
        }
        return static_cast<std::uint64_t>(x);
    }

    const Source &source_;
    const Json &json_;
    std::string where_;
};

} // namespace voxshell
