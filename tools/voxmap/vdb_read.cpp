// SPDX-License-Identifier: GPL-3.0-or-later
// The side of the .vdb reader that must survive: starts the parser in a child process, checks what it sends.
#include "cli/failure.hpp"
#include "container/file_hash.hpp"
#include "voxmap/vdb.hpp"
#include "voxmap/vdb_parse.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/core.h>
#include <fstream>
#include <new>
#include <optional>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace voxshell {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool limit_address_space = false; // a sanitizer maps terabytes of shadow
#else
constexpr bool limit_address_space = true;
#endif

/// What a file of this size may cost. A leaf of 2 KiB takes 128 bytes of a file at the least, an internal
/// node of 260 KiB about 8 KiB; brick lists come on top. What others write is searched for its surface, 0.1
/// ms a leaf.
struct Limits {
    std::uint64_t memory; ///< bytes beyond what the process has
    std::uint64_t seconds;
    Limits(std::uint64_t file_bytes, bool foreign)
        : memory((std::uint64_t{1} << 29) + 64 * file_bytes), seconds(5 + file_bytes / 4'000'000)
    {
        if (!foreign) return;
        memory += std::uint64_t{1} << 29;
        seconds += 5 + file_bytes / 200'000;
    }
};

struct Answer {        ///< what comes through the pipe first
    std::int32_t code; ///< ExitCode; ok: all lists follow, else the error's text as meta
    std::uint32_t closed;
    double voxel;
    Cell origin;
    std::uint64_t bricks, runs, layers, distances, meta;
    Sha256 source_hash;
    std::int32_t layer_count;
    std::uint32_t unsigned_distance;
    double distance_band, distance_step, distance_error;
    std::uint64_t foreign, grid, kind; ///< whether it is another program's, and two texts
    double unit;
    std::array<double, 3> world_origin, moved;
    std::uint64_t distance_left_out;
};

bool send(int pipe, const void *data, std::size_t size)
{
    const char *at = static_cast<const char *>(data);
    while (size) {
        const ssize_t done = ::write(pipe, at, std::min<std::size_t>(size, 1 << 20));
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) return false;
        at += done;
        size -= static_cast<std::size_t>(done);
    }
    return true;
}

template<typename List>
bool send_all(int pipe, const List &list)
{
    return send(pipe, list.data(), list.size() * sizeof(list[0]));
}

void limit(int resource, std::uint64_t value)
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

/// OpenVDB quotes the file in its messages: no control character may reach a terminal.
std::string printable(std::string text)
{
    if (text.size() > 200) text = text.substr(0, 200) + "...";
    for (char &c : text)
        if (c < ' ' || c > '~') c = '?';
    return text;
}

/// The child: limits, parse, send. Never returns into the parent's code, never runs its destructors.
[[noreturn]] void child(int pipe, const std::filesystem::path &path, const ForeignGrid *foreign,
                        const Limits &limits)
{
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTERM, SIGXCPU, SIGPIPE})
        std::signal(signal, SIG_DFL);
    std::signal(SIGINT, SIG_IGN); // ^C is for the parent, which then says so itself
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, limits.seconds);
    if (limit_address_space) limit(RLIMIT_AS, address_space() + limits.memory);
    // OpenVDB logs what it dislikes, and its log flushes what the parent had not printed yet.
    const int null = ::open("/dev/null", O_WRONLY);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(null, stream);

    Answer answer{};
    std::string error;
    try {
        const VdbFile file = parse_vdb(path, foreign);
        const Cells &cells = file.cells;
        answer.closed = cells.closed;
        answer.voxel = cells.voxel;
        answer.origin = cells.origin;
        answer.bricks = cells.bricks.size();
        answer.runs = cells.solid.size();
        answer.layers = file.channels.layer.size();
        answer.distances = file.channels.distance.size();
        answer.meta = file.meta.size();
        answer.source_hash = file.source_hash;
        answer.layer_count = file.channels.layer_count;
        answer.unsigned_distance = file.channels.unsigned_distance;
        answer.distance_band = file.channels.distance_band;
        answer.distance_step = file.channels.distance_step;
        answer.distance_error = file.channels.distance_error;
        const ForeignTaken taken = file.foreign.value_or(ForeignTaken{});
        answer.foreign = file.foreign.has_value();
        answer.grid = taken.grid.size();
        answer.kind = taken.kind.size();
        answer.unit = taken.unit;
        answer.world_origin = taken.origin;
        answer.moved = taken.moved;
        answer.distance_left_out = taken.distance_left_out;
        const bool sent = send(pipe, &answer, sizeof answer) && send_all(pipe, cells.bricks) &&
                          send_all(pipe, cells.solid) && send_all(pipe, file.channels.layer) &&
                          send_all(pipe, file.channels.distance) && send_all(pipe, file.meta) &&
                          send_all(pipe, taken.grid) && send_all(pipe, taken.kind);
        ::_exit(sent ? 0 : 1); // not exit(): the tree's destructor starts threads that a fork has not
    } catch (const Failure &failure) {
        answer.code = static_cast<std::int32_t>(failure.code);
        error = failure.what();
    } catch (const std::bad_alloc &) {
        answer.code = static_cast<std::int32_t>(ExitCode::invalid);
        error =
            fmt::format("needs more than {} MiB to read, too much for a file of its size: damaged or hostile",
                        limits.memory >> 20);
    } catch (const std::exception &other) {
        answer.code = static_cast<std::int32_t>(ExitCode::invalid);
        error = fmt::format("OpenVDB cannot read this file ({})", printable(other.what()));
    }
    answer.meta = error.size();
    ::_exit(send(pipe, &answer, sizeof answer) && send(pipe, error.data(), error.size()) ? 0 : 1);
}

/// The parent's end: reads until a deadline; whatever happens, the child is gone afterwards.
class Child {
  public:
    Child(pid_t pid, int pipe, std::uint64_t seconds, Progress &progress)
        : pid_(pid), pipe_(pipe), deadline_(Clock::now() + std::chrono::seconds(seconds)), progress_(progress)
    {
    }
    ~Child()
    {
        ::close(pipe_);
        if (pid_ > 0) {
            ::kill(pid_, SIGKILL);
            wait();
        }
    }
    Child(const Child &) = delete;
    Child &operator=(const Child &) = delete;

    bool read(void *data, std::size_t size)
    {
        char *at = static_cast<char *>(data);
        while (size) {
            pollfd ready{pipe_, POLLIN, 0};
            const auto left =
                std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
            const int polled =
                left <= 0 ? 0 : ::poll(&ready, 1, static_cast<int>(std::min<std::int64_t>(left, 50)));
            progress_.check();
            if (polled < 0 && errno != EINTR) return false;
            if (polled == 0 && Clock::now() >= deadline_) {
                late_ = true;
                return false;
            }
            if (polled <= 0) continue;
            const ssize_t got = ::read(pipe_, at, std::min<std::size_t>(size, 1 << 20));
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) return false;
            at += got;
            size -= static_cast<std::size_t>(got);
        }
        return true;
    }

    /// Why a read() failed, as a sentence.
    std::string obituary()
    {
        if (late_) return "OpenVDB's reader did not finish with this file in time: damaged or hostile";
        const int status = wait();
        if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
            return "OpenVDB's reader did not finish with this file in time: damaged or hostile";
        if (WIFSIGNALED(status))
            return fmt::format("OpenVDB's reader gave up on this file (signal {})", WTERMSIG(status));
        return fmt::format("OpenVDB's reader gave up on this file (status {})", WEXITSTATUS(status));
    }

  private:
    using Clock = std::chrono::steady_clock;
    int wait()
    {
        int status = 0;
        while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        pid_ = -1;
        return status;
    }
    pid_t pid_;
    int pipe_;
    Clock::time_point deadline_;
    Progress &progress_;
    bool late_ = false;
};

std::uint64_t readable_size(const std::filesystem::path &path)
{
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        throw Failure(ExitCode::system, path.string(), "is a folder");
    std::ifstream file(path, std::ios::binary);
    char magic[8] = {};
    if (!file)
        throw Failure(ExitCode::system, path.string(),
                      fmt::format("cannot be read: {}", std::strerror(errno)));
    if (!file.read(magic, sizeof magic) || std::memcmp(magic, " BDV\0\0\0\0", sizeof magic) != 0)
        throw Failure(ExitCode::invalid, path.string(),
                      "is not an OpenVDB file: it does not begin with OpenVDB's magic number");
    const auto size = std::filesystem::file_size(path, error);
    if (error) throw Failure(ExitCode::system, path.string(), error.message());
    return size;
}

VdbFile receive(Child &reader, const Limits &limits)
{
    const auto give_up = [&] { throw Failure(ExitCode::invalid, "", reader.obituary()); };
    Answer answer;
    if (!reader.read(&answer, sizeof answer)) give_up();
    const bool sane = answer.meta <= vdb_max_meta && answer.grid <= vdb_max_meta &&
                      answer.kind <= vdb_max_meta && answer.bricks <= limits.memory / sizeof(Brick) &&
                      answer.runs <= limits.memory / sizeof(SolidRun) &&
                      (answer.layers == 0 || answer.layers == answer.bricks) &&
                      (answer.distances == 0 || answer.distances == answer.bricks);
    if (!sane)
        throw Failure(ExitCode::invalid, "", "OpenVDB's reader sent nonsense: damaged or hostile file");
    VdbFile file;
    if (answer.code != 0) {
        file.meta.resize(answer.meta);
        if (!reader.read(file.meta.data(), answer.meta)) give_up();
        throw Failure(static_cast<ExitCode>(answer.code), "", file.meta);
    }
    const auto receive_all = [&](auto &list, std::uint64_t count) {
        list.resize(count);
        if (!reader.read(list.data(), count * sizeof(list[0]))) give_up();
    };
    receive_all(file.cells.bricks, answer.bricks);
    receive_all(file.cells.solid, answer.runs);
    receive_all(file.channels.layer, answer.layers);
    receive_all(file.channels.distance, answer.distances);
    receive_all(file.meta, answer.meta);
    ForeignTaken taken;
    receive_all(taken.grid, answer.grid);
    receive_all(taken.kind, answer.kind);
    taken.unit = answer.unit;
    taken.origin = answer.world_origin;
    taken.moved = answer.moved;
    taken.distance_left_out = answer.distance_left_out != 0;
    if (answer.foreign) file.foreign = taken;
    file.channels.layer_count = answer.layer_count;
    file.channels.unsigned_distance = answer.unsigned_distance != 0;
    file.channels.distance_band = answer.distance_band;
    file.channels.distance_step = answer.distance_step;
    file.channels.distance_error = answer.distance_error;
    file.cells.voxel = answer.voxel;
    file.cells.origin = answer.origin;
    file.cells.closed = answer.closed != 0;
    file.source_hash = answer.source_hash;
    check_cells(file.cells);
    recount(file.cells);
    return file;
}

} // namespace

void check_cells(const Cells &cells)
{
    const auto require = [](bool holds, const char *what) {
        if (!holds) throw Failure(ExitCode::invalid, "", what);
    };
    require(cells.voxel >= 1e-12 && cells.voxel <= 1e3, "the voxel is not within 1e-12 m to 1e3 m");
    constexpr std::int32_t limit = VXS_VOXMAP_MAX_CELLS / VXS_VOXMAP_BRICK_CELLS;
    for (const std::int64_t o : cells.origin)
        require(o % VXS_VOXMAP_CHUNK_CELLS == 0 && std::abs(o) <= vdb_max_index + 1,
                "a cell is beyond the limits");
    std::uint64_t surface = 0;
    auto run = cells.solid.begin();
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        const Brick &brick = cells.bricks[b];
        require(b == 0 || cells.bricks[b - 1].at < brick.at, "grid `state` has two leaves in one place");
        std::uint64_t overlap = 0;
        for (int i = 0; i < 8; ++i) {
            require(brick.at[i % 3] >= 0 && brick.at[i % 3] < limit, "a cell is beyond the limits");
            surface |= brick.surface[i];
            overlap |= brick.surface[i] & brick.interior[i];
        }
        require(overlap == 0, "a cell has two states");
        while (run != cells.solid.end() && BrickAt{run->i, run->j, run->last} < brick.at) ++run;
        require(run == cells.solid.end() || brick.at < BrickAt{run->i, run->j, run->first},
                "grid `state` has a leaf and a tile in one place");
    }
    require(surface != 0, "grid `state` holds no surface cell");
    for (std::size_t r = 0; r < cells.solid.size(); ++r) {
        const SolidRun &s = cells.solid[r];
        require(s.i >= 0 && s.j >= 0 && s.first >= 0 && s.first <= s.last && s.i < limit && s.j < limit &&
                    s.last < limit,
                "a cell is beyond the limits");
        require(r == 0 || BrickAt{cells.solid[r - 1].i, cells.solid[r - 1].j, cells.solid[r - 1].last} <
                              BrickAt{s.i, s.j, s.first},
                "grid `state` has two tiles in one place");
    }
}

VdbFile read_vdb(const std::filesystem::path &path, const ForeignGrid *foreign, Progress *progress)
{
    Progress silent;
    const Limits limits(readable_size(path), foreign != nullptr);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw Failure(ExitCode::system, path.string(), std::strerror(errno));
    const pid_t pid = ::fork();
    if (pid < 0) {
        const int reason = errno;
        ::close(ends[0]);
        ::close(ends[1]);
        throw Failure(ExitCode::system, path.string(),
                      fmt::format("cannot start OpenVDB's reader: {}", std::strerror(reason)));
    }
    if (pid == 0) {
        ::close(ends[0]);
        child(ends[1], path, foreign, limits);
    }
    ::close(ends[1]);
    Child reader(pid, ends[0], 10 * limits.seconds, progress ? *progress : silent);
    try {
        VdbFile file = receive(reader, limits);
        if (file.foreign) {
            const std::optional<Sha256> hash = hash_of_file(path);
            if (!hash) throw Failure(ExitCode::system, "", "cannot be read to its end");
            file.source_hash = *hash;
        }
        return file;
    } catch (const Failure &failure) {
        throw Failure(failure.code, path.string(), failure.what());
    }
}

} // namespace voxshell
