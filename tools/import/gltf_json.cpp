// SPDX-License-Identifier: GPL-3.0-or-later
#include "import/gltf_json.hpp"

#include <unordered_map>

namespace voxshell {
namespace {

constexpr std::size_t max_depth = 64;

/// Nesting of the JSON text; other readers recurse and would overflow the stack.
void check_depth(const Source &source, std::string_view text)
{
    std::size_t depth = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                quoted = false;
        } else if (c == '"') {
            quoted = true;
        } else if (c == '{' || c == '[') {
            if (++depth > max_depth) {
                source.invalid(fmt::format("the JSON is nested deeper than {} levels", max_depth));
            }
        } else if ((c == '}' || c == ']') && depth > 0) {
            --depth;
        }
    }
}

} // namespace

Json parse_json(const Source &source, std::string_view text)
{
    if (text.find_first_not_of(" \t\r\n") == text.npos) source.invalid("no JSON in the file");
    check_depth(source, text);
    try {
        return Json::parse(text);
    } catch (const Json::exception &e) {
        // "[json.exception.parse_error.101] parse error at line 1, column 2: ..." without the tag.
        std::string_view what = e.what();
        if (const std::size_t tag = what.find("] "); tag != what.npos) what.remove_prefix(tag + 2);
        source.invalid("not valid JSON: " + printable(what, 160));
    }
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
                               : kind->second == text    ? item.is_string()
                               : kind->second == boolean ? item.is_boolean()
                               : kind->second == array   ? item.is_array()
                                                         : item.is_object();
            if (!right) source.invalid(fmt::format("{}.{}: a value of the wrong type", where, key));
        }
        if (item.is_structured()) check_side_properties(source, item, where + "." + printable(key, 40));
    }
}

} // namespace voxshell
