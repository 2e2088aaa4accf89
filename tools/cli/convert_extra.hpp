// SPDX-License-Identifier: GPL-3.0-or-later
// What convert makes only where it is asked for: a shell of another spacing, a thinned one, channels of the
// map.
#pragma once

#include "pipeline/convert_part.hpp"

#include <nlohmann/json.hpp>

#include <string_view>

namespace CLI {
class App;
}

namespace voxshell {

struct ExtraOptions {
    double shell_spacing = 0; ///< [m]; 0: the voxel
    double thin_shell = 0;    ///< [degrees]; 0: not thinned
    ChannelRequest channels;
};

/// --shell-spacing, --thin-shell, --channels.
void add_extra(CLI::App &verb, ExtraOptions &options);

/// "layers:3,distance:2.5". Throws Failure(usage) for anything else, twice the same and values out of range.
ChannelRequest parse_channels(std::string_view text);

/// Members for the report's `options` and `parts[]`: nothing where nothing was asked for.
nlohmann::ordered_json extra_json(const ExtraOptions &options);
nlohmann::ordered_json extra_json(const Part &part);

/// The lines of the summary on points and channels.
void tell_points(const Part &part);

} // namespace voxshell
