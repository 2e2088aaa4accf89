// SPDX-License-Identifier: GPL-3.0-or-later
#include "import/gltf_json.hpp"

#include <unordered_map>

namespace voxshell {
namespace {

constexpr std::size_t max_depth = 64;

/// A character that stands for itself in JSON: escapes, and what is not allowed, are the parser's to read.
bool plain(char c)
{
    return c >= ' ' && c < 0x7f && c != '\\';
}

/// Follows the strings and the nesting of a JSON text, without judging it.
class Lifter {
  public:
    Lifter(const Source &source, std::string_view text)
        : source_(source), text_(text), first_(static_cast<std::size_t>(text.data() - source.text().data()))
    {
    }

    /// Fills `text` and `uris`; gives the places of `uris` among all strings of the text, names included.
    std::vector<std::size_t> lift(GltfJson &out)
    {
        std::vector<std::size_t> places;
        std::size_t depth = 0, strings = 0, kept = 0;
        bool after_uri = false; // between the name "uri" and its value
        for (std::size_t i = 0; i < text_.size(); ++i) {
            const char c = text_[i];
            if (c == '"') {
                const std::size_t begin = i + 1;
                i = end_of_string(begin);
                const std::string_view string = text_.substr(begin, i - begin);
                if (after_uri && string.starts_with("data:") &&
                    std::all_of(string.begin(), string.end(), plain)) {
                    out.text += text_.substr(kept, begin - kept);
                    out.uris.push_back(source_.bytes.subspan(first_ + begin, string.size()));
                    places.push_back(strings);
                    kept = i;
                }
                ++strings;
                after_uri = string == "uri";
            } else if (c == '{' || c == '[') {
                after_uri = false;
                // Other readers recurse and would overflow the stack.
                if (++depth > max_depth) {
                    source_.invalid(fmt::format("the JSON is nested deeper than {} levels", max_depth));
                }
            } else if (c == '}' || c == ']') {
                depth -= depth > 0;
            } else if (c == ',') {
                after_uri = false; // it was no name, but a value
            }
        }
        out.text += text_.substr(kept);
        return places;
    }

  private:
    std::size_t end_of_string(std::size_t i) const
    {
        while (i < text_.size() && text_[i] != '"') i += text_[i] == '\\' ? 2 : 1;
        return std::min(i, text_.size());
    }

    const Source &source_;
    std::string_view text_;
    std::size_t first_; ///< of text_, in the file
};

} // namespace

GltfJson parse_json(const Source &source, std::string_view text)
{
    if (text.find_first_not_of(" \t\r\n") == text.npos) source.invalid("no JSON in the file");
    GltfJson out;
    const std::vector<std::size_t> places = Lifter(source, text).lift(out);
    std::size_t strings = 0, next = 0;
    const auto put_back = [&](int, Json::parse_event_t event, Json &value) {
        const bool is_name = event == Json::parse_event_t::key;
        if (!is_name && !(event == Json::parse_event_t::value && value.is_string())) return true;
        if (next < places.size() && strings == places[next]) value = Json::binary({}, next++);
        ++strings;
        return true;
    };
    try {
        out.json = Json::parse(out.text, put_back);
    } catch (const Json::exception &e) {
        // "[json.exception.parse_error.101] parse error at line 1, column 2: ..." without the tag.
        std::string_view what = e.what();
        if (const std::size_t tag = what.find("] "); tag != what.npos) what.remove_prefix(tag + 2);
        source.invalid("not valid JSON: " + printable(what, 160));
    }
    return out;
}

void check_side_properties(const Source &source, const Json &value, const std::string &where)
{
    enum Kind { number, integer, text, boolean, array, object };
    static const std::unordered_map<std::string, Kind> kinds = {{"name", text},
                                                                {"uri", text},
                                                                {"mimeType", text},
                                                                {"alphaMode", text},
                                                                {"path", text},
                                                                {"interpolation", text},
                                                                {"type", text},
                                                                {"scale", number},
                                                                {"strength", number},
                                                                {"metallicFactor", number},
                                                                {"roughnessFactor", number},
                                                                {"alphaCutoff", number},
                                                                {"yfov", number},
                                                                {"aspectRatio", number},
                                                                {"znear", number},
                                                                {"zfar", number},
                                                                {"xmag", number},
                                                                {"ymag", number},
                                                                {"index", integer},
                                                                {"texCoord", integer},
                                                                {"bufferView", integer},
                                                                {"source", integer},
                                                                {"magFilter", integer},
                                                                {"minFilter", integer},
                                                                {"wrapS", integer},
                                                                {"wrapT", integer},
                                                                {"inverseBindMatrices", integer},
                                                                {"skeleton", integer},
                                                                {"input", integer},
                                                                {"output", integer},
                                                                {"node", integer},
                                                                {"sampler", integer},
                                                                {"doubleSided", boolean},
                                                                {"joints", array},
                                                                {"baseColorFactor", array},
                                                                {"emissiveFactor", array},
                                                                {"channels", array},
                                                                {"samplers", array},
                                                                {"target", object},
                                                                {"perspective", object},
                                                                {"orthographic", object},
                                                                {"pbrMetallicRoughness", object},
                                                                {"normalTexture", object},
                                                                {"occlusionTexture", object},
                                                                {"emissiveTexture", object},
                                                                {"baseColorTexture", object},
                                                                {"metallicRoughnessTexture", object}};
    if (value.is_array()) {
        for (std::size_t i = 0; i < value.size(); ++i)
            if (value[i].is_structured())
                check_side_properties(source, value[i], fmt::format("{}[{}]", where, i));
        return;
    }
    for (const auto &[key, item] : value.items()) {
        if (key == "extras" || key == "extensions") continue;
        if (const auto kind = kinds.find(key); kind != kinds.end()) {
            const bool right = kind->second == number ? item.is_number()
                               : kind->second == integer
                                   ? item.is_number() && item.get<double>() >= 0 &&
                                         item.get<double>() == std::floor(item.get<double>())
                               : kind->second == text    ? item.is_string() || item.is_binary()
                               : kind->second == boolean ? item.is_boolean()
                               : kind->second == array   ? item.is_array()
                                                         : item.is_object();
            if (!right) source.invalid(fmt::format("{}.{}: a value of the wrong type", where, key));
        }
        if (item.is_structured()) check_side_properties(source, item, where + "." + printable(key, 40));
    }
}

} // namespace voxshell
