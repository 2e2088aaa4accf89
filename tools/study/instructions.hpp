// SPDX-License-Identifier: GPL-3.0-or-later
// How many instructions a piece of code takes, counted one by one: the processor's trap flag stops the
// program after each, as a debugger's step does. Needs no counter of the kernel's and no right; takes 2 to 10
// us for each.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>

namespace voxshell {

/// Counts on the thread that made it, one at a time in a program; SIGTRAP is its own as long as it lives.
class InstructionCount {
  public:
    InstructionCount();
    ~InstructionCount();
    InstructionCount(const InstructionCount &) = delete;
    InstructionCount &operator=(const InstructionCount &) = delete;

    /// Why there is no counting here; empty: there is. Then of(..) is 0.
    const std::string &why_not() const { return why_not_; }

    /// Instructions of work(), those of the call not. A repeated string instruction is one, as counters have
    /// it.
    template<typename Work>
    std::uint64_t of(Work &&work)
    {
        return counted([](void *user) { (*static_cast<std::remove_reference_t<Work> *>(user))(); },
                       const_cast<void *>(static_cast<const void *>(std::addressof(work))));
    }

    /// Within of(): what of it was counted until here. Always the same few instructions.
    std::uint64_t so_far() const;

    /// Within of(): from here on it goes at full speed and is not counted, or is again. Always the same few
    /// instructions.
    void stepping(bool counts);

  private:
    std::uint64_t counted(void (*work)(void *), void *user);
    std::uint64_t steps(void (*work)(void *), void *user);

    std::string why_not_;
    std::uint64_t around_ = 0; ///< steps of an empty call
    struct Before;
    std::unique_ptr<Before> before_; ///< how signals were handled
};

} // namespace voxshell
