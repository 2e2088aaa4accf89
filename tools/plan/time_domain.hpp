// SPDX-License-Identifier: GPL-3.0-or-later
// The loop in the time domain: the runtime's own simulated device and coupling against a spring at the
// origin, on one axis. What loop.hpp foretells, run.
#pragma once

#include "plan/loop.hpp"
#include "plan/memory.hpp"

#include <cmath>
#include <limits>

namespace voxshell {

/// The device without what theory leaves out: friction, encoder steps, the clamp.
vxs_simulated_config small_motions(vxs_simulated_config device);

/// Of a position over some ticks [m].
struct Motion {
    double rms = 0, least = 0, most = 0;
    double amplitude() const { return (most - least) / 2; }
};

class TimeDomain {
  public:
    /// The device begins `start` [m] off the spring's middle, at rest; the hand's target is the middle: a
    /// step. Throws Failure(bug) if the runtime refuses the numbers.
    TimeDomain(vxs_simulated_config device, const vxs_coupling_config &coupling, double start = 1e-3);
    ~TimeDomain();
    TimeDomain(const TimeDomain &) = delete;
    TimeDomain &operator=(const TimeDomain &) = delete;

    /// So many ticks on; where the tip really was in them.
    Motion run(double stiffness, long ticks);

  private:
    Memory device_memory_, coupling_memory_;
    vxs_device *device_ = nullptr;
    vxs_coupling *coupling_ = nullptr;
    vxs_device_command command_{};
};

/// Growth of small motions in e-folds from the second quarter of `ticks` to the last.
double growth(const vxs_simulated_config &device, const vxs_coupling_config &coupling, double stiffness,
              long ticks);

/// Ticks of so many periods of the oscillation at this stiffness, where the loop gain comes nearest to -1,
/// and six thousand.
long ticks_of_onset(const Loop &loop, double stiffness, double periods = 120);

/// The stiffness at which `grows` begins to hold, to a factor 1 + tolerance: it looks from `guess` / width to
/// `guess` width, and further where that does not hold the change. Infinity, or 0, where there is none within
/// a factor of 1000.
template<class F>
double onset(double guess, double width, double tolerance, F grows)
{
    double low = guess / width, high = guess * width;
    while (grows(low)) {
        high = low;
        low /= width;
        if (low < guess / 1000) return 0;
    }
    while (!grows(high)) {
        low = high;
        high *= width;
        if (high > guess * 1000) return std::numeric_limits<double>::infinity();
    }
    while (high / low > 1 + tolerance) {
        const double middle = std::sqrt(low * high);
        (grows(middle) ? high : low) = middle;
    }
    return std::sqrt(low * high);
}

} // namespace voxshell
