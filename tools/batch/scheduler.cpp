// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/scheduler.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <numeric>
#include <thread>

namespace voxshell {

MemoryBudget::Share::Share(MemoryBudget &budget, std::uint64_t bytes)
    : budget_(budget), bytes_(std::min(bytes, budget.total_))
{
    std::unique_lock lock(budget_.mutex_);
    budget_.freed_.wait(lock, [&] { return budget_.given_ + bytes_ <= budget_.total_; });
    budget_.given_ += bytes_;
    budget_.most_ = std::max(budget_.most_, budget_.given_);
}

MemoryBudget::Share::~Share()
{
    {
        const std::lock_guard lock(budget_.mutex_);
        budget_.given_ -= bytes_;
    }
    budget_.freed_.notify_all();
}

std::vector<std::size_t> heaviest_first(const std::vector<double> &weights)
{
    std::vector<std::size_t> order(weights.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
    return order;
}

void each_heaviest_first(const std::vector<double> &weights, unsigned jobs,
                         const std::function<void(std::size_t)> &work)
{
    if (jobs == 0) jobs = std::max(1u, std::thread::hardware_concurrency());
    const auto threads = static_cast<unsigned>(std::min<std::size_t>(jobs, weights.size()));
    const std::vector<std::size_t> order = heaviest_first(weights);
    std::mutex mutex;
    std::size_t next = 0;
    unsigned busy = threads;
    std::exception_ptr ended;
    // What oneTBB may use is one thread (the caller's) and those of our own that are done.
    std::unique_ptr<tbb::global_control> helpers;
    const auto allow = [&] {
        helpers.reset();
        helpers = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                        1 + jobs - busy);
    };
    const auto worker = [&] {
        tbb::task_arena arena(static_cast<int>(jobs));
        for (;;) {
            std::size_t n = 0;
            {
                const std::lock_guard lock(mutex);
                if (ended || next == order.size()) {
                    --busy;
                    if (busy > 0) allow();
                    return;
                }
                n = order[next++];
            }
            try {
                arena.execute([&] { work(n); });
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (!ended) ended = std::current_exception();
            }
        }
    };
    if (threads == 0) return;
    allow();
    std::vector<std::thread> others;
    for (unsigned t = 1; t < threads; ++t) others.emplace_back(worker);
    worker();
    for (std::thread &thread : others) thread.join();
    if (ended) std::rethrow_exception(ended);
}

} // namespace voxshell
