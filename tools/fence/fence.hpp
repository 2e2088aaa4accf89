// SPDX-License-Identifier: GPL-3.0-or-later
// A fence: a child process with bounds of memory, processor time and time, in which a library works that may
// crash, hang or take all memory over a hostile file. The parent asks and checks the answers; whatever
// happens to the child becomes one sentence.
#pragma once

#include "cli/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <sys/types.h>
#include <vector>

namespace voxshell {

struct FenceLimits {
    std::uint64_t memory;  ///< [bytes] beyond what the process has when the fence is made
    std::uint64_t seconds; ///< of processor; ten times as much of the clock
};

/// Where answers come from, byte by byte: a fence, or a list of bytes in a test.
class Answers {
  public:
    virtual ~Answers() = default;
    /// All of it, or false once and for all.
    virtual bool read(void *data, std::size_t size) = 0;
    /// Why a read() failed, as a sentence.
    virtual std::string obituary() = 0;

    /// A list of `count` elements, which the caller has found to be plausible.
    template<class T>
    bool read_list(std::vector<T> &list, std::uint64_t count)
    {
        list.reserve(count); // untouched memory costs nothing: what is not sent takes none
        for (std::uint64_t done = 0; done < count; done = list.size()) {
            list.resize(done + std::min<std::uint64_t>(count - done, 1 + (1 << 18) / sizeof(T)));
            if (!read(list.data() + done, (list.size() - done) * sizeof(T))) return false;
        }
        return true;
    }
    bool read_text(std::string &text, std::uint64_t size)
    {
        text.resize(size);
        return read(text.data(), size);
    }
};

/// The child's end of a fence.
class Fenced {
  public:
    Fenced(int stream, std::uint64_t base) : stream_(stream), base_(base) {}
    bool read(void *data, std::size_t size);
    bool write(const void *data, std::size_t size);
    template<class List>
    bool write_list(const List &list)
    {
        return write(list.data(), list.size() * sizeof(list[0]));
    }
    /// From now on: so much more processor time, and so much memory in all.
    void limit(const FenceLimits &limits);

  private:
    int stream_;
    std::uint64_t base_; ///< [bytes] of address space before
};

class Fence : public Answers {
  public:
    /// Runs `work` in a copy of this process, which has all its memory but none of its other threads and no
    /// file open; false for a parent that is gone. `who` begins the sentences ("OpenVDB's reader", of "this
    /// file"). Failure(system) where there cannot be one more process.
    Fence(std::string who, std::string what, const FenceLimits &limits,
          const std::function<bool(Fenced &)> &work);
    ~Fence() override; ///< the child is gone afterwards
    Fence(const Fence &) = delete;
    Fence &operator=(const Fence &) = delete;

    bool write(const void *data, std::size_t size);
    bool read(void *data, std::size_t size) override;
    std::string obituary() override;
    /// A new question: the clock begins again.
    void restart(std::uint64_t seconds);
    void watch(Progress *progress) { progress_ = progress; } ///< asked every 50 ms

  private:
    using Clock = std::chrono::steady_clock;
    bool ready(short event);
    int wait();

    std::string who_, what_;
    pid_t pid_ = -1;
    int stream_ = -1;
    Clock::time_point deadline_;
    Progress *progress_ = nullptr;
    bool late_ = false, dead_ = false;
};

} // namespace voxshell
