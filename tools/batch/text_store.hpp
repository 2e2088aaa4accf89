// SPDX-License-Identifier: GPL-3.0-or-later
// Texts put aside on disk until they are wanted: what a report says of a million parts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace voxshell {

/// In a file without a name, which goes with it. Throws Failure(system). One thread at a time.
class TextStore {
  public:
    TextStore() = default;
    ~TextStore();
    TextStore(const TextStore &) = delete;
    TextStore &operator=(const TextStore &) = delete;

    std::uint64_t put(std::string_view text); ///< where it is
    std::string get(std::uint64_t at) const;

  private:
    int file_ = -1; ///< made with the first text
    std::uint64_t size_ = 0;
};

} // namespace voxshell
