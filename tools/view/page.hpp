// SPDX-License-Identifier: GPL-3.0-or-later
// Assets as one page that opens from disk, without a network and without another file.
#pragma once

#include "view/page_data.hpp"

#include <nlohmann/json.hpp>

#include <functional>
#include <string>
#include <string_view>

namespace voxshell {

/// The page's text, piece by piece. `view`: what page/main.js reads (title, bodies, recorded, figures); `data`:
/// the arrays that it names. three.js and the scripts of page/ are in the program, and so in the page.
void write_page(const nlohmann::ordered_json &view, const PageData &data,
                const std::function<void(std::string_view)> &sink);

} // namespace voxshell
