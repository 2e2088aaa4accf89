// SPDX-License-Identifier: GPL-3.0-or-later
// What all pages of studies are made with.
#pragma once

#include "study/study_report.hpp"

namespace voxshell {

/// Down to the body's beginning, with the style that all have.
std::string page_head(const std::string &title);
std::string page_text(const std::string &text); ///< as it is to be read, whatever is in it
std::string page_base64(const std::string &bytes);

} // namespace voxshell
