// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace voxshell {

/// Sum that loses no more than the last bit (Neumaier), in the order of the calls.
class Sum {
  public:
    void add(double x)
    {
        const double t = sum_ + x;
        lost_ += std::abs(sum_) >= std::abs(x) ? (sum_ - t) + x : (x - t) + sum_;
        sum_ = t;
    }
    double value() const { return sum_ + lost_; }

  private:
    double sum_ = 0, lost_ = 0;
};

} // namespace voxshell
