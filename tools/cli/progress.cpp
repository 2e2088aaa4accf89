// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/progress.hpp"

#include "cli/failure.hpp"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>

#include <unistd.h>

namespace voxshell {
namespace {

volatile std::sig_atomic_t interrupted = 0;
std::function<void()> leave;

extern "C" void remember_interrupt(int)
{
    interrupted = 1;
}

class Watched : public Progress {
  public:
    void check() override
    {
        if (!interrupted) return;
        if (leave) {
            wipe();
            leave();
        }
        throw Failure(ExitCode::interrupted, "", "interrupted");
    }

  protected:
    virtual void wipe() {} ///< what is shown
};

class Shown final : public Watched {
  public:
    explicit Shown(bool json) : json_(json) {}
    ~Shown() override { Shown::wipe(); }

    void stage(std::string_view name, std::uint64_t total) override
    {
        check();
        const std::lock_guard lock(mutex_);
        name_ = name;
        total_ = total;
        done_ = 0;
        begin_ = Clock::now();
        show();
    }

    void advance(std::uint64_t units) override
    {
        done_ += units;
        const std::int64_t now = Clock::now().time_since_epoch().count();
        if (now < next_.load(std::memory_order_relaxed)) return;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock.owns_lock()) show();
    }

  private:
    using Clock = std::chrono::steady_clock;

    void show() // with the lock held
    {
        next_ = (Clock::now() + std::chrono::milliseconds(200)).time_since_epoch().count();
        const std::uint64_t done = done_;
        if (json_) {
            fmt::print(stderr, "{{\"stage\":\"{}\",\"done\":{},\"total\":{}}}\n", name_, done, total_);
            return;
        }
        const double part =
            total_ ? std::min(1.0, static_cast<double>(done) / static_cast<double>(total_)) : 0;
        std::string line = fmt::format("\r\033[K{:<12} [{:<24}] {:3.0f}%", name_,
                                       std::string(static_cast<std::size_t>(part * 24), '='), part * 100);
        const double spent = std::chrono::duration<double>(Clock::now() - begin_).count();
        if (part > 0.02 && spent > 1) line += fmt::format("  {:.0f} s left", spent * (1 - part) / part);
        std::fputs(line.c_str(), stderr);
        std::fflush(stderr);
        drawn_ = true;
    }

    void wipe() override
    {
        if (drawn_) std::fputs("\r\033[K", stderr);
    }

    const bool json_;
    bool drawn_ = false;
    std::mutex mutex_;
    std::string name_;
    std::uint64_t total_ = 0;
    std::atomic<std::uint64_t> done_{0};
    std::atomic<std::int64_t> next_{0};
    Clock::time_point begin_{};
};

} // namespace

std::unique_ptr<Progress> make_progress(ProgressMode mode, bool quiet)
{
    if (mode == ProgressMode::automatic)
        mode = !quiet && isatty(STDERR_FILENO) ? ProgressMode::always : ProgressMode::never;
    if (mode == ProgressMode::never) return std::make_unique<Watched>();
    return std::make_unique<Shown>(mode == ProgressMode::json);
}

void catch_interrupts()
{
    struct sigaction action = {};
    action.sa_handler = remember_interrupt;
    // Once: the next signal ends the process, should a stage be deaf.
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

void leave_when_interrupted(std::function<void()> how)
{
    leave = std::move(how);
}

bool interruption_requested()
{
    return interrupted;
}

bool may_colour(int descriptor)
{
    const char *no = std::getenv("NO_COLOR");
    return isatty(descriptor) && !(no && *no);
}

} // namespace voxshell
