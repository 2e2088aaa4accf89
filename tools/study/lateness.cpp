// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/lateness.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <atomic>
#include <chrono>
#include <map>
#include <thread>

namespace voxshell {
namespace {

constexpr std::int64_t second = 1'000'000'000;

std::int64_t now_ns()
{
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * second + time.tv_nsec;
}

void sleep_until(std::int64_t time_ns)
{
    const timespec time{.tv_sec = time_ns / second, .tv_nsec = time_ns % second};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) != 0) {
    }
}

/// Lower ends of the bins that a sample falls into [us].
std::map<std::int64_t, std::uint64_t> bins(const std::vector<float> &ns)
{
    std::map<std::int64_t, std::uint64_t> out;
    for (const float value : ns) {
        const auto us = static_cast<std::int64_t>(value) / 1000;
        ++out[us < 1000 ? us : us / 1000 * 1000];
    }
    return out;
}

} // namespace

Lateness measure_lateness(double rate_hz, std::uint64_t ticks, const std::function<void()> &work,
                          Progress &progress)
{
    Lateness out;
    out.late_ns.resize(ticks);
    out.work_ns.resize(ticks);
    std::atomic<bool> stop = false, done = false;
    std::thread loop([&] {
        const sched_param parameter{.sched_priority = 80};
        out.scheduling = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter) == 0
                             ? "SCHED_FIFO"
                             : "default scheduler: SCHED_FIFO is not allowed (raise rtprio in limits.conf)";
        out.memory = mlockall(MCL_CURRENT) == 0 ? "locked"
                                                : "not locked: over the limit (raise memlock in limits.conf)";
        const auto period = static_cast<std::int64_t>(1e9 / rate_hz + 0.5);
        std::int64_t next = now_ns() + period;
        std::uint64_t tick = 0;
        for (; tick < ticks && !stop; ++tick) {
            sleep_until(next);
            const std::int64_t woken = now_ns();
            work();
            const std::int64_t ended = now_ns();
            out.late_ns[tick] = static_cast<float>(woken - next);
            out.work_ns[tick] = static_cast<float>(ended - woken);
            next += period;
            if (ended > next) {
                const std::int64_t skipped = (ended - next) / period;
                out.missed += static_cast<std::uint64_t>(skipped);
                next += skipped * period;
            }
        }
        out.late_ns.resize(tick);
        out.work_ns.resize(tick);
        munlockall();
        done = true;
    });
    try {
        while (!done) {
            progress.check();
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    } catch (...) {
        stop = true;
        loop.join();
        throw;
    }
    loop.join();
    return out;
}

std::string histogram_csv(const Lateness &lateness)
{
    const auto late = bins(lateness.late_ns), work = bins(lateness.work_ns);
    std::map<std::int64_t, std::pair<std::uint64_t, std::uint64_t>> both;
    for (const auto &[us, count] : late) both[us].first = count;
    for (const auto &[us, count] : work) both[us].second = count;
    std::string out = "from_us,late,work\n";
    for (const auto &[us, counts] : both) out += fmt::format("{},{},{}\n", us, counts.first, counts.second);
    return out;
}

std::vector<std::uint8_t> plot_histogram(const Lateness &lateness, const std::string &title, Picture picture)
{
    std::string script;
    for (const auto &[name, ns] :
         {std::pair("late", &lateness.late_ns), std::pair("work", &lateness.work_ns)}) {
        script += fmt::format("${} << END\n", name);
        for (const auto &[us, count] : bins(*ns)) script += fmt::format("{} {}\n", us + 1, count);
        script += "END\n";
    }
    script += gnuplot_sheet(picture, 900, 480);
    script += "set title " + gnuplot_text(title) +
              " noenhanced\n"
              "set xlabel 'less than [us]'\nset ylabel 'ticks'\nset logscale xy\nset yrange [0.7:*]\nset "
              "xrange [0.8:*]\n"
              "set key top right Left reverse samplen 2 opaque box lc rgb '#d8d8d8'\n"
              "plot $late using 1:2 with impulses lw 3 lc rgb '#1b3f8b' title 'woken late', "
              "$work using 1:2 with points pt 7 ps 1 lc rgb '#d95f02' title 'work of a tick'\n";
    return gnuplot(script);
}

} // namespace voxshell
