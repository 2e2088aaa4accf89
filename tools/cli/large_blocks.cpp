// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays of many megabytes on large pages, where the system leaves that to the program (Debian's kernels take
// them by themselves; others say `madvise` in /sys/kernel/mm/transparent_hugepage/enabled). A gigabyte in
// pages of 4 KiB takes the kernel 40 ms to take back, and ^C waits for it.
#include <cstdint>
#include <cstdlib>
#include <new>

#include <sys/mman.h>

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // which have operators of their own

namespace {

constexpr std::size_t page = std::size_t{1} << 21;

void *large(std::size_t size)
{
    void *block = std::aligned_alloc(page, (size + page - 1) & ~(page - 1));
    if (block) madvise(block, size, MADV_HUGEPAGE); // a wish: without it all is as before
    return block;
}

} // namespace

void *operator new(std::size_t size)
{
    void *block = size >= 2 * page && size <= SIZE_MAX - page ? large(size) : std::malloc(size ? size : 1);
    if (!block) throw std::bad_alloc();
    return block;
}

void operator delete(void *block) noexcept
{
    std::free(block);
}

void operator delete(void *block, std::size_t) noexcept
{
    std::free(block);
}

#endif
