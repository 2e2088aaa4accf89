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

TEST_CASE("parts of a count: what lies between two looks, and what is passed over")
{
    InstructionCount count;
    if (!count.why_not().empty()) return;
#if defined(__x86_64__)
    const auto spin = [](std::uint64_t rounds) {
        __asm__ volatile("1: dec %0\n jnz 1b" : "+r"(rounds)::"cc");
    };
    std::uint64_t looks[4], over = 0;
    const auto work = [&](std::uint64_t first, std::uint64_t second) {
        return count.of([&] {
            looks[0] = count.so_far();
            spin(first);
            looks[1] = count.so_far();
            count.stepping(false);
            spin(second);
            over = count.so_far();
            count.stepping(true);
            looks[2] = count.so_far();
            spin(first);
            looks[3] = count.so_far();
        });
    };
    const std::uint64_t shorter = work(10, 10);
    const std::uint64_t first = looks[1] - looks[0], between = looks[2] - looks[1];
    CHECK(looks[3] - looks[2] == first);
    CHECK(over - looks[1] < 20);
    const std::uint64_t longer = work(1010, 70'000);
    CHECK(longer - shorter == 4000);
    CHECK(looks[1] - looks[0] == first + 2000);
    CHECK(looks[2] - looks[1] == between);
    CHECK(looks[3] - looks[2] == looks[1] - looks[0]);
#endif
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
