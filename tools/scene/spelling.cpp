// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/spelling.hpp"

#include <algorithm>
#include <vector>

namespace voxshell {

std::size_t distance(std::string_view a, std::string_view b)
{
    if (a.size() >= 3 && b.find(a) != std::string_view::npos) return 1;
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) {
        row[j] = j;
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0]++;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = std::min({row[j + 1] + 1, row[j] + 1, replaced});
        }
    }
    return row.back();
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> words)
{
    const std::string_view begin = word.substr(0, 64);
    return *std::min_element(words.begin(), words.end(),
                             [&](auto a, auto b) { return distance(begin, a) < distance(begin, b); });
}

bool is_near(std::string_view word, std::string_view meant)
{
    return distance(word.substr(0, 64), meant) * 3 <= meant.size();
}

} // namespace voxshell
