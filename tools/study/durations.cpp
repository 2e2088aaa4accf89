// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/durations.hpp"

#include <algorithm>

namespace voxshell {

Durations durations(std::vector<float> &ns)
{
    if (ns.empty()) return {};
    const auto at = [&](double share) {
        const auto n = static_cast<std::size_t>(share * static_cast<double>(ns.size() - 1));
        std::nth_element(ns.begin(), ns.begin() + static_cast<std::ptrdiff_t>(n), ns.end());
        return static_cast<double>(ns[n]);
    };
    return {at(0.5), at(0.99), at(0.999), at(1)};
}

} // namespace voxshell
