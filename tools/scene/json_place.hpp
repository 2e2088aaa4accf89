// SPDX-License-Identifier: GPL-3.0-or-later
// Strict reading of a JSON file: every refusal names the place, no key is passed over.
#pragma once

#include "scene/quantity.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell {

/// A value of the document and its JSON pointer. Borrows the document.
class JsonPlace {
  public:
    JsonPlace(const nlohmann::json &value, std::string pointer, const std::filesystem::path &file)
        : value_(&value), pointer_(std::move(pointer)), file_(&file)
    {
    }
    [[noreturn]] void refuse(const std::string &why) const; ///< throws Failure(invalid)
    bool is_string() const;
    bool is_object() const;
    double number() const; ///< finite
    bool boolean() const;
    std::string string(std::string_view expected) const;
    double quantity(Dimension dimension) const; ///< a string with a number and its unit
    std::size_t choice(std::span<const std::string_view> names) const; ///< index of the string's value
    std::size_t choice(std::initializer_list<std::string_view> names) const
    {
        return choice(std::span(names.begin(), names.size()));
    }
    std::vector<JsonPlace> items(std::size_t least, std::size_t most) const;

    const std::string &pointer() const { return pointer_; }
    /// The same, which messages call otherwise.
    JsonPlace called(std::string pointer) const
    {
        JsonPlace place = *this;
        place.pointer_ = std::move(pointer);
        return place;
    }

  private:
    friend class JsonObject;
    const nlohmann::json *value_;
    std::string pointer_;
    const std::filesystem::path *file_;
};

/// An object with these keys and no others: the first unknown one is refused, with the nearest that is known.
class JsonObject {
  public:
    JsonObject(JsonPlace place, std::span<const std::string_view> keys);
    JsonObject(JsonPlace place, std::initializer_list<std::string_view> keys)
        : JsonObject(std::move(place), std::span(keys.begin(), keys.size()))
    {
    }
    /// With any keys: for a look at the one that says which others there may be.
    static JsonObject any(JsonPlace place);
    JsonPlace get(std::string_view key) const; ///< refuses if it is not there
    std::optional<JsonPlace> find(std::string_view key) const;

  private:
    explicit JsonObject(JsonPlace place);
    JsonPlace place_;
};

/// A parsed text; comments (// and /* */) are read over. Throws Failure(system) if the file cannot be read;
/// Failure(invalid) for text that is not JSON, doubled keys, nesting deeper than 16 or more than 16 MiB.
class JsonDocument {
  public:
    explicit JsonDocument(const std::filesystem::path &file);
    /// A text that stands in a file at this pointer, nested at most `depth` deep.
    JsonDocument(const std::filesystem::path &file, std::string_view text, std::string pointer,
                 int depth = 16);
    ~JsonDocument();
    JsonPlace root() const;
    const std::array<std::uint8_t, 32> &source_hash() const { return source_hash_; } ///< SHA-256 of the text

  private:
    std::filesystem::path file_;
    std::string pointer_;
    std::array<std::uint8_t, 32> source_hash_;
    std::unique_ptr<nlohmann::json> json_;
};

} // namespace voxshell
