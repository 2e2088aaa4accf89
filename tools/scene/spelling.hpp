// SPDX-License-Identifier: GPL-3.0-or-later
// What somebody may have meant who misspelt a word.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace voxshell {

/// Edits (insert, drop, replace) that turn a into b; one if b says it more fully.
std::size_t distance(std::string_view a, std::string_view b);

/// The word of `words` (one at least) that is nearest to `word`, of which 64 letters count.
std::string_view nearest(std::string_view word, std::span<const std::string_view> words);

/// Whether it is near enough to be asked about where many words are known: a third of its letters at most differ.
bool is_near(std::string_view word, std::string_view meant);

} // namespace voxshell
