// SPDX-License-Identifier: GPL-3.0-or-later
// Strict reading of a JSON file: every refusal names the place, no key is passed over.
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell {

/// A value of the document and its JSON pointer. Borrows the document.
class JsonPlace {
public:
    JsonPlace(const nlohmann::json &value, std::string pointer, const std::filesystem::path &file)
        : value_(&value), pointer_(std::move(pointer)), file_(&file) {}
    [[noreturn]] void refuse(const std::string &why) const; ///< throws Failure(invalid)
    double number() const; ///< finite
    bool boolean() const;
    std::string string(std::string_view expected) const;
    std::size_t choice(std::initializer_list<std::string_view> names) const; ///< index of the string's value
    std::vector<JsonPlace> items(std::size_t least, std::size_t most) const;

private:
    friend class JsonObject;
    const nlohmann::json *value_;
    std::string pointer_;
    const std::filesystem::path *file_;
};

/// An object with these keys and no others: the first unknown one is refused, with the nearest that is known.
class JsonObject {
public:
    JsonObject(JsonPlace place, std::initializer_list<std::string_view> keys);
    JsonPlace get(std::string_view key) const; ///< refuses if it is not there
    std::optional<JsonPlace> find(std::string_view key) const;

private:
    JsonPlace place_;
};

/// A parsed file. Throws Failure(system) if it cannot be read; Failure(invalid) for text that is not JSON,
/// doubled keys, nesting deeper than 16 or more than 16 MiB.
class JsonDocument {
public:
    explicit JsonDocument(const std::filesystem::path &file);
    ~JsonDocument();
    JsonPlace root() const;

private:
    std::filesystem::path file_;
    std::unique_ptr<nlohmann::json> json_;
};

} // namespace voxshell
