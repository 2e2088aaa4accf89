// SPDX-License-Identifier: GPL-3.0-or-later
#include "fence/fence.hpp"

#include "cli/failure.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fmt/core.h>
#include <fstream>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace voxshell {
namespace {

#if defined(__has_feature)
#define VXS_HAS_FEATURE(name) __has_feature(name)
#else
#define VXS_HAS_FEATURE(name) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || VXS_HAS_FEATURE(address_sanitizer) ||   \
    VXS_HAS_FEATURE(thread_sanitizer)
constexpr bool limit_address_space = false; // a sanitizer maps terabytes of shadow
#else
constexpr bool limit_address_space = true;
#endif

constexpr std::size_t piece = 1 << 20;
constexpr int child_stream = 3; ///< the first after stdin, stdout and stderr

void set_limit(int resource, std::uint64_t value)
{
    rlimit limits{};
    ::getrlimit(static_cast<__rlimit_resource>(resource), &limits);
    limits.rlim_cur = std::min<rlim_t>(value, limits.rlim_max);
    ::setrlimit(static_cast<__rlimit_resource>(resource), &limits);
}

std::uint64_t address_space()
{
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Never returns into the parent's code, never runs its destructors.
[[noreturn]] void child(int stream, const FenceLimits &limits, const std::function<bool(Fenced &)> &work)
{
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTERM, SIGXCPU, SIGPIPE})
        std::signal(signal, SIG_DFL);
    std::signal(SIGINT, SIG_IGN); // ^C is for the parent, which then says so itself
    // A library logs what it dislikes, and its log flushes what the parent had not printed yet.
    const int null = ::open("/dev/null", O_RDWR);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null, standard);
    // Another fence's stream, held open here, would hide that its child has died.
    if (stream != child_stream) ::dup2(stream, child_stream);
    ::closefrom(child_stream + 1);
    set_limit(RLIMIT_CORE, 0);
    Fenced fenced(child_stream, address_space());
    fenced.limit(limits);
    ::_exit(work(fenced) ? 0 : 1); // not exit(): destructors start threads and join those that a fork has not
}

} // namespace

bool Fenced::read(void *data, std::size_t size)
{
    char *at = static_cast<char *>(data);
    while (size) {
        const ssize_t got = ::read(stream_, at, std::min(size, piece));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += got;
        size -= static_cast<std::size_t>(got);
    }
    return true;
}

bool Fenced::write(const void *data, std::size_t size)
{
    const char *at = static_cast<const char *>(data);
    while (size) {
        const ssize_t done = ::write(stream_, at, std::min(size, piece));
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) return false;
        at += done;
        size -= static_cast<std::size_t>(done);
    }
    return true;
}

void Fenced::limit(const FenceLimits &limits)
{
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto spent = static_cast<std::uint64_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
    set_limit(RLIMIT_CPU, spent + 1 + limits.seconds);
    if (limit_address_space) set_limit(RLIMIT_AS, base_ + limits.memory);
}

Fence::Fence(std::string who, std::string what, const FenceLimits &limits,
             const std::function<bool(Fenced &)> &work)
    : who_(std::move(who)), what_(std::move(what))
{
    int ends[2];
    const auto cannot = [&](int reason) {
        return Failure(ExitCode::system, "", fmt::format("cannot start {}: {}", who_, std::strerror(reason)));
    };
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) throw cannot(errno);
    const pid_t pid = ::fork();
    if (pid == 0) child(ends[1], limits, work);
    const int reason = errno;
    ::close(ends[1]);
    if (pid < 0) {
        ::close(ends[0]);
        throw cannot(reason);
    }
    pid_ = pid;
    stream_ = ends[0];
    restart(limits.seconds);
}

Fence::~Fence()
{
    ::close(stream_);
    if (pid_ > 0) {
        ::kill(pid_, SIGKILL);
        wait();
    }
}

void Fence::restart(std::uint64_t seconds)
{
    deadline_ = Clock::now() + std::chrono::seconds(10 * std::max<std::uint64_t>(seconds, 1));
}

/// Whether the stream takes or gives something before the deadline.
bool Fence::ready(short event)
{
    while (!dead_) {
        pollfd wanted{stream_, event, 0};
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
        const int polled =
            left <= 0 ? 0 : ::poll(&wanted, 1, static_cast<int>(std::min<std::int64_t>(left, 50)));
        if (progress_) progress_->check();
        if (polled > 0) return true;
        late_ = polled == 0 && Clock::now() >= deadline_;
        dead_ = late_ || (polled < 0 && errno != EINTR);
    }
    return false;
}

bool Fence::read(void *data, std::size_t size)
{
    char *at = static_cast<char *>(data);
    while (size && ready(POLLIN)) {
        const ssize_t got = ::recv(stream_, at, std::min(size, piece), MSG_DONTWAIT);
        if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        dead_ = got <= 0;
        if (dead_) break;
        at += got;
        size -= static_cast<std::size_t>(got);
    }
    return size == 0;
}

bool Fence::write(const void *data, std::size_t size)
{
    const char *at = static_cast<const char *>(data);
    while (size && ready(POLLOUT)) {
        const ssize_t done = ::send(stream_, at, std::min(size, piece), MSG_DONTWAIT | MSG_NOSIGNAL);
        if (done < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        dead_ = done <= 0;
        if (dead_) break;
        at += done;
        size -= static_cast<std::size_t>(done);
    }
    return size == 0;
}

int Fence::wait()
{
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
}

std::string Fence::obituary()
{
    const std::string in_vain =
        fmt::format("{} did not finish with {} in time: damaged or hostile", who_, what_);
    if (late_ || pid_ < 0) return in_vain;
    ::shutdown(stream_, SHUT_RDWR); // one that is still there finds nobody to answer
    const int status = wait();
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return in_vain;
    if (WIFSIGNALED(status))
        return fmt::format("{} gave up on {} (signal {})", who_, what_, WTERMSIG(status));
    return fmt::format("{} gave up on {} (status {})", who_, what_, WEXITSTATUS(status));
}

} // namespace voxshell
