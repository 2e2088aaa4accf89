// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/json_place.hpp"

#include "scene/spelling.hpp"

#include "cli/failure.hpp"
#include "container/container.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

namespace voxshell {
namespace {

constexpr std::size_t max_bytes = 16 << 20;

std::string read_text(const std::filesystem::path &file)
{
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) {
        throw Failure(ExitCode::system, file.string(), "is a folder");
    }
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        throw Failure(ExitCode::system, file.string(), std::string("cannot read: ") + std::strerror(errno));
    }
    std::string text;
    std::array<char, 1 << 14> piece; // a pipe or a device has no size to ask for
    while (text.size() <= max_bytes && stream.read(piece.data(), piece.size()).gcount() > 0)
        text.append(piece.data(), static_cast<std::size_t>(stream.gcount()));
    if (stream.bad()) {
        throw Failure(ExitCode::system, file.string(), "cannot read");
    }
    if (text.size() > max_bytes) {
        throw Failure(ExitCode::invalid, file.string(), "larger than 16 MiB: not a scene");
    }
    return text;
}

/// Printable, short: what a hostile file says goes to a terminal.
std::string shown(std::string_view text, std::size_t most = 60)
{
    std::string out;
    for (const char c : text.substr(0, most)) {
        out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    }
    return out + (text.size() > most ? "..." : "");
}

} // namespace

void JsonPlace::refuse(const std::string &why) const
{
    throw Failure(ExitCode::invalid, file_->string(),
                  shown(pointer_.empty() ? "/" : pointer_, 120) + ": " + why);
}

bool JsonPlace::is_string() const
{
    return value_->is_string();
}

bool JsonPlace::is_object() const
{
    return value_->is_object();
}

double JsonPlace::number() const
{
    if (!value_->is_number() || !std::isfinite(value_->get<double>())) {
        refuse("must be a number");
    }
    return value_->get<double>();
}

bool JsonPlace::boolean() const
{
    if (!value_->is_boolean()) {
        refuse("must be true or false");
    }
    return value_->get<bool>();
}

std::string JsonPlace::string(std::string_view expected) const
{
    if (!value_->is_string()) {
        refuse("must be " + std::string(expected));
    }
    return value_->get<std::string>();
}

double JsonPlace::quantity(Dimension dimension) const
{
    const std::string text = string("a number with its unit in quotes (" + units_of(dimension) + ")");
    const auto value = parse_quantity(text, dimension);
    if (!value) {
        refuse(fmt::format("\"{}\" is not a number with a unit of {}", shown(text), units_of(dimension)));
    }
    return *value;
}

std::size_t JsonPlace::choice(std::span<const std::string_view> names) const
{
    std::string list;
    for (const std::string_view name : names) {
        list += (list.empty() ? "" : name == names.back() ? " or " : ", ") + std::string(name);
    }
    const std::string text = string(list);
    const auto found = std::find(names.begin(), names.end(), text);
    if (found == names.end()) {
        refuse("\"" + shown(text) + "\" is not " + list);
    }
    return static_cast<std::size_t>(found - names.begin());
}

std::vector<JsonPlace> JsonPlace::items(std::size_t least, std::size_t most) const
{
    if (!value_->is_array() || value_->size() < least || value_->size() > most) {
        refuse(least == most ? "must be a list of " + std::to_string(least)
                             : "must be a list of " + std::to_string(least) + " to " + std::to_string(most));
    }
    std::vector<JsonPlace> places;
    for (std::size_t n = 0; n < value_->size(); ++n) {
        places.emplace_back((*value_)[n], pointer_ + "/" + std::to_string(n), *file_);
    }
    return places;
}

JsonObject::JsonObject(JsonPlace place) : place_(std::move(place))
{
    if (!place_.value_->is_object()) {
        place_.refuse("must be an object {...}");
    }
}

JsonObject JsonObject::any(JsonPlace place)
{
    return JsonObject(std::move(place));
}

JsonObject::JsonObject(JsonPlace place, std::span<const std::string_view> keys) : JsonObject(std::move(place))
{
    for (const auto &item : place_.value_->items()) {
        const std::string &key = item.key();
        if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
            JsonPlace(item.value(), place_.pointer_ + "/" + key, *place_.file_)
                .refuse("unknown key; did you mean \"" + std::string(nearest(key, keys)) + "\"?");
        }
    }
}

std::optional<JsonPlace> JsonObject::find(std::string_view key) const
{
    const auto found = place_.value_->find(key);
    if (found == place_.value_->end()) {
        return std::nullopt;
    }
    return JsonPlace(*found, place_.pointer_ + "/" + std::string(key), *place_.file_);
}

JsonPlace JsonObject::get(std::string_view key) const
{
    auto found = find(key);
    if (!found) {
        place_.refuse("lacks \"" + std::string(key) + "\"");
    }
    return *found;
}

JsonDocument::JsonDocument(const std::filesystem::path &file) : JsonDocument(file, read_text(file), "") {}

JsonDocument::JsonDocument(const std::filesystem::path &file, std::string_view text, std::string pointer,
                           int max_depth)
    : file_(file), pointer_(std::move(pointer))
{
    const std::string where = pointer_.empty() ? "" : pointer_ + ": ";
    source_hash_ = sha256({reinterpret_cast<const std::uint8_t *>(text.data()), text.size()});
    std::vector<std::set<std::string>> keys;
    const auto watch = [&](int depth, nlohmann::json::parse_event_t event, nlohmann::json &value) {
        using Event = nlohmann::json::parse_event_t;
        if (depth > max_depth) {
            throw Failure(ExitCode::invalid, file_.string(),
                          where + "nested deeper than " + std::to_string(max_depth));
        }
        if (event == Event::object_start) {
            keys.emplace_back();
        } else if (event == Event::object_end) {
            keys.pop_back();
        } else if (event == Event::key && !keys.back().insert(value.get<std::string>()).second) {
            throw Failure(ExitCode::invalid, file_.string(),
                          where + "key \"" + shown(value.get<std::string>()) +
                              "\" occurs twice in one object");
        }
        return true;
    };
    try {
        json_ = std::make_unique<nlohmann::json>(nlohmann::json::parse(text, watch, true, true));
    } catch (const nlohmann::json::exception &error) {
        std::string what =
            error.what(); // "[json.exception.parse_error.101] parse error at line 1, column 2: ..."
        what.erase(0, what.find("] ") == std::string::npos ? 0 : what.find("] ") + 2);
        throw Failure(ExitCode::invalid, file_.string(), where + "not JSON: " + shown(what));
    }
}

JsonDocument::~JsonDocument() = default;

JsonPlace JsonDocument::root() const
{
    return {*json_, pointer_, file_};
}

} // namespace voxshell
