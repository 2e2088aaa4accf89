// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <new>

namespace voxshell {

/// Memory for the runtime's objects: on a cache line's boundary, whole lines.
class Memory {
  public:
    explicit Memory(std::size_t size)
        : size_((size + 63) / 64 * 64),
          bytes_(static_cast<std::byte *>(::operator new(size_, std::align_val_t(64))))
    {
    }
    ~Memory() { ::operator delete(bytes_, std::align_val_t(64)); }
    Memory(const Memory &) = delete;
    Memory &operator=(const Memory &) = delete;
    void *get() const { return bytes_; }
    std::size_t size() const { return size_; }

  private:
    std::size_t size_;
    std::byte *bytes_;
};

} // namespace voxshell
