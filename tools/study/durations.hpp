// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace voxshell {

/// How long something took [ns].
struct Durations {
    double p50 = 0, p99 = 0, p999 = 0, max = 0;
};

/// Reorders `ns`. All 0 for none.
Durations durations(std::vector<float> &ns);

} // namespace voxshell
