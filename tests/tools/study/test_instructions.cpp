// SPDX-License-Identifier: GPL-3.0-or-later
// Instructions counted one by one: of code whose instructions are written down here.
#include "study/instructions.hpp"

#include <csignal>

#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

using namespace voxshell;

TEST_CASE("a loop of two instructions, a repeated one, nothing")
{
    InstructionCount count;
    if (!count.why_not().empty()) {
        MESSAGE("not counted here: ", count.why_not());
        CHECK(count.of([] {}) == 0);
        return;
    }
#if defined(__x86_64__)
    const auto loop = [&](std::uint64_t rounds) {
        return count.of([rounds] {
            std::uint64_t left = rounds;
            __asm__ volatile("1: dec %0\n jnz 1b" : "+r"(left)::"cc");
        });
    };
    for (const std::uint64_t rounds : {1u, 10u, 1000u, 20000u})
        CHECK(loop(rounds) - loop(1) == 2 * rounds - 2);

    static char from[4096], to[4096];
    const auto copy = [&](std::uint64_t size) {
        return count.of([size] {
            const void *source = from;
            void *target = to;
            std::uint64_t left = size;
            __asm__ volatile("rep movsb" : "+D"(target), "+S"(source), "+c"(left)::"memory");
        });
    };
    CHECK(copy(4096) == copy(1));
    CHECK(copy(4096) < 10);
#endif
    CHECK(count.of([] {}) == 0);
}

TEST_CASE("signals are as they were")
{
    struct sigaction before, after;
    sigaction(SIGTRAP, nullptr, &before);
    {
        InstructionCount count;
        count.of([] {});
    }
    sigaction(SIGTRAP, nullptr, &after);
    CHECK((before.sa_handler == after.sa_handler));
}
