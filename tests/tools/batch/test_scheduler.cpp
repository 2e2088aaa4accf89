// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "batch/scheduler.hpp"

#include <doctest/doctest.h>

#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>

using namespace voxshell;

TEST_CASE("each once, the heaviest first")
{
    const std::vector<double> weights{1, 5, 3, 5, 0};
    std::vector<std::size_t> order;
    each_heaviest_first(weights, 1, [&](std::size_t n) { order.push_back(n); });
    CHECK(order == std::vector<std::size_t>{1, 3, 2, 0, 4});
    std::vector<std::atomic<int>> calls(1000);
    each_heaviest_first(std::vector<double>(1000, 1), 7, [&](std::size_t n) { ++calls[n]; });
    for (const auto &n : calls) CHECK(n == 1);
    each_heaviest_first({}, 3, [](std::size_t) { FAIL("there is nothing to do"); });
}

TEST_CASE("never more threads at work than were given, and idle ones help the last part")
{
    constexpr unsigned jobs = 3;
    std::atomic<int> at_work{0}, most{0};
    std::mutex mutex;
    std::set<std::thread::id> helpers; // of the last and longest part
    each_heaviest_first({1, 1, 1, 1, 0.5}, jobs, [&](std::size_t n) {
        const int loops = n == 4 ? 400 : 60;
        tbb::parallel_for(0, loops, [&](int) {
            const int now = ++at_work;
            int seen = most;
            while (seen < now && !most.compare_exchange_weak(seen, now)) {
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            if (n == 4) {
                const std::lock_guard lock(mutex);
                helpers.insert(std::this_thread::get_id());
            }
            --at_work;
        });
    });
    CHECK(most <= static_cast<int>(jobs));
    CHECK(most >= 2);
    CHECK(helpers.size() >= 2);
}

TEST_CASE("an exception ends the work and comes out")
{
    std::atomic<int> calls{0};
    CHECK_THROWS_AS(each_heaviest_first(std::vector<double>(100, 1), 2,
                                        [&](std::size_t) {
                                            ++calls;
                                            throw std::runtime_error("enough");
                                        }),
                    std::runtime_error);
    CHECK(calls <= 2);
}

TEST_CASE("shares of memory never add up to more than there is; one too large is alone")
{
    MemoryBudget budget(100);
    std::atomic<int> together{0}, most{0};
    each_heaviest_first(std::vector<double>(40, 1), 8, [&](std::size_t n) {
        const MemoryBudget::Share share(budget, n % 5 == 0 ? 1000 : 40);
        const int now = together += n % 5 == 0 ? 10 : 1;
        int seen = most;
        while (seen < now && !most.compare_exchange_weak(seen, now)) {
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        together -= n % 5 == 0 ? 10 : 1;
    });
    CHECK(budget.most() <= 100);
    CHECK(most == 10); // the large one alone: 10; two of the others: 2
}
