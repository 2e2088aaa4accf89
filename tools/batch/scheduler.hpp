// SPDX-License-Identifier: GPL-3.0-or-later
// Work on many parts at a time: largest first, within a budget of memory and of threads.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

namespace voxshell {

/// Memory that the parts under work share. A part that needs more than there is waits until it is alone.
class MemoryBudget {
  public:
    explicit MemoryBudget(std::uint64_t bytes) : total_(bytes) {}

    /// A share, given back when it goes.
    class Share {
      public:
        Share(MemoryBudget &budget, std::uint64_t bytes);
        ~Share();
        Share(const Share &) = delete;
        Share &operator=(const Share &) = delete;

      private:
        MemoryBudget &budget_;
        std::uint64_t bytes_;
    };

    std::uint64_t total() const { return total_; }
    std::uint64_t most() const { return most_; } ///< that was given out at a time [bytes]

  private:
    std::mutex mutex_;
    std::condition_variable freed_;
    const std::uint64_t total_;
    std::uint64_t given_ = 0, most_ = 0;
};

/// Indices by falling weight, the lighter index among equals.
std::vector<std::size_t> heaviest_first(const std::vector<double> &weights);

/// Calls work(n) once for each n of heaviest_first(), on `jobs` threads (0: one a core). Each call may use
/// oneTBB: threads that have no call left to begin help the others, and there are never more than `jobs` at
/// work. `work` throws nothing but what ends all: the first exception is thrown again when all threads have
/// stopped.
void each_heaviest_first(const std::vector<double> &weights, unsigned jobs,
                         const std::function<void(std::size_t)> &work);

} // namespace voxshell
