// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_rival.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <sstream>

namespace voxshell::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What this thread has had of a processor.
std::int64_t processor_ns()
{
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return std::int64_t{now.tv_sec} * 1000000000 + now.tv_nsec;
}

struct Options {
    std::string only;
    double budget = 2;
    int count = 0; ///< not 0: no timing, so many ticks
    bool list = false;
};

Options parse(int argc, char **argv)
{
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string_view word = argv[i];
        if (word == "--list")
            options.list = true;
        else if (word == "--only" && i + 1 < argc)
            options.only = argv[++i];
        else if (word == "--budget" && i + 1 < argc)
            options.budget = std::stod(argv[++i]);
        else if (word == "--count" && i + 1 < argc)
            options.count = std::stoi(argv[++i]);
        else
            throw Failure(ExitCode::usage, std::string(word),
                          "not --list, --only TEXT, --budget SECONDS or --count TICKS");
    }
    return options;
}

Job parse_job(const std::string &line)
{
    std::istringstream words(line);
    std::string motion;
    Job job;
    double voxel_mm = 0;
    if (!(words >> motion >> job.size >> voxel_mm) || job.size == 0 || !(voxel_mm > 0))
        throw Failure(ExitCode::usage, line, "a job is MOTION SIZE VOXEL_MM");
    job.motion = motion_named(motion);
    job.voxel = voxel_mm * 1e-3;
    return job;
}

/// The points, the poses and, on first use, the exact forces of a job.
class Workload {
  public:
    explicit Workload(const Job &job) : poses(poses_of(job.motion)), motion_(job.motion), size_(job.size) {}

    const Points &points()
    {
        if (points_.count == 0) points_ = sphere_points(size_);
        return points_;
    }

    /// What the force should be at poses[0], poses[sample], poses[2 sample] ...
    const std::vector<Vec3> &exact()
    {
        if (exact_.empty())
            for (std::size_t p = 0; p < poses.size(); p += sample)
                exact_.push_back(exact_force(motion_, points(), poses[p]));
        return exact_;
    }
    /// Whether there is a force to be compared: none at all (free), or parts that cancel (all), are not.
    bool has_force() const { return motion_ != Motion::all && motion_ != Motion::free; }

    static constexpr std::size_t sample = pose_count / 20;
    std::vector<Pose> poses;

  private:
    Motion motion_;
    std::uint32_t size_;
    Points points_;
    std::vector<Vec3> exact_;
};

/// A rival and what need be measured only once.
struct Contestant {
    const RivalRow *row;
    std::unique_ptr<Rival> rival;
    double setup = 0; ///< [s]
    std::size_t stride = 1;
    std::string facts; ///< JSON members
};

double length(const Vec3 &v)
{
    return std::hypot(v[0], v[1], v[2]);
}

/// Means over some poses as JSON members; of the force the error of its length and the angle to the exact one
/// [rad].
std::string facts(Rival &rival, Kind kind, Workload &workload)
{
    const bool compare = kind == Kind::points && workload.has_force();
    double contacts = 0, touched = 0, depth = 0, found = 0, wanted = 0, angle = 0, ticks = 0;
    for (std::size_t p = 0; p < workload.poses.size(); p += workload.sample, ++ticks) {
        const Contact contact = rival.tick(workload.poses[p]);
        contacts += static_cast<double>(contact.contacts);
        touched += static_cast<double>(contact.touched);
        depth += contact.depth;
        if (!compare) continue;
        const Vec3 &f = contact.force, &x = workload.exact()[p / workload.sample];
        const double a = length(f), b = length(x);
        if (a > 0 && b > 0)
            angle += std::acos(std::clamp((f[0] * x[0] + f[1] * x[1] + f[2] * x[2]) / (a * b), -1.0, 1.0));
        found += a;
        wanted += b;
    }
    std::string members =
        fmt::format("\"contacts\":{:.1f},\"touched\":{},\"depth_mm\":{:.4f}", contacts / ticks,
                    touched < 0 ? "null" : fmt::format("{:.0f}", touched / ticks), depth / ticks * 1e3);
    if (wanted > 0) // a few points may all be out of contact
        members +=
            fmt::format(",\"force_error\":{:.5f},\"force_angle\":{:.5f}", found / wanted - 1, angle / ticks);
    return members;
}

Contestant prepare(const RivalRow &row, const Job &job, Workload &workload, double budget)
{
    Contestant c{.row = &row, .rival = nullptr, .facts = {}};
    static const Points none;
    const auto start = Clock::now();
    c.rival = row.make(job, row.kind == Kind::points ? workload.points() : none);
    c.setup = seconds_since(start);
    double tick = HUGE_VAL; // the least of a few: the machine may be busy
    for (std::size_t p = 0; p < 5; ++p) {
        const auto begin = Clock::now();
        c.rival->tick(workload.poses[p]);
        tick = std::min(tick, seconds_since(begin));
    }
    c.stride = std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(tick * pose_count / budget)), 1,
                                       pose_count / 10);
    c.facts = fmt::format("\"setup_s\":{:.2f},\"static_mib\":{:.1f},{}", c.setup, c.rival->static_mib(),
                          facts(*c.rival, row.kind, workload));
    return c;
}

void measure(Contestant &c, const Job &job, const Workload &workload)
{
    std::vector<Pose> poses;
    for (std::size_t p = 0; p < workload.poses.size(); p += c.stride) poses.push_back(workload.poses[p]);
    const auto ns = time_ticks(*c.rival, poses);
    fmt::print("{{\"rival\":\"{}\",\"kind\":\"{}\",\"motion\":\"{}\",\"size\":{},\"voxel_mm\":{},{},"
               "\"stride\":{},\"ns\":[{}]}}\n",
               c.row->name, c.row->kind == Kind::points ? "points" : "mesh",
               motion_names[static_cast<std::size_t>(job.motion)], job.size, job.voxel * 1e3, c.facts,
               c.stride, fmt::join(ns, ","));
}

/// Two meshes that coincide, or a million triangles, are nobody's servo tick.
bool fits_mesh(const Job &job)
{
    return job.motion != Motion::all && job.size <= 100000;
}

void serve(const std::vector<const RivalRow *> &rows, double budget)
{
    Job current;
    std::unique_ptr<Workload> workload;
    std::vector<Contestant> contestants;
    for (std::string line; std::getline(std::cin, line);) {
        const Job job = parse_job(line);
        if (!(job == current)) {
            contestants.clear();
            workload = std::make_unique<Workload>(job);
            for (const RivalRow *row : rows)
                if (row->kind == Kind::points || fits_mesh(job))
                    contestants.push_back(prepare(*row, job, *workload, budget));
            current = job;
        }
        for (Contestant &c : contestants) measure(c, job, *workload);
        fmt::print("\n");
        std::fflush(stdout);
    }
}

/// For an instruction counter: exactly so many ticks for each rival and job, from the first pose on.
void count_ticks(const std::vector<const RivalRow *> &rows, int count)
{
    for (std::string line; std::getline(std::cin, line);) {
        const Job job = parse_job(line);
        Workload workload(job);
        for (const RivalRow *row : rows) {
            const auto rival = row->make(job, workload.points());
            for (int n = 0; n < count; ++n)
                rival->tick(workload.poses[static_cast<std::size_t>(n % pose_count)]);
        }
    }
}

} // namespace

std::vector<std::uint32_t> time_ticks(Rival &rival, std::span<const Pose> poses)
{
    std::vector<std::uint32_t> ns;
    ns.reserve(poses.size());
    // The way to the first pose, so that no tick starts cold and a coherent rival has come from next door.
    double least = HUGE_VAL;
    for (std::size_t p = std::min<std::size_t>(poses.size(), 5); p-- > 0;) {
        const auto start = Clock::now();
        rival.tick(poses[p]);
        least = std::min(least, seconds_since(start));
    }
    const bool slow = least > 1e-4;
    for (const Pose &pose : poses) {
        const std::int64_t busy = slow ? processor_ns() : 0;
        const auto start = Clock::now();
        const Contact contact = rival.tick(pose);
        const auto stop = Clock::now();
        asm volatile("" : : "m"(contact) : "memory"); // the result is wanted
        const auto wall = std::chrono::duration_cast<std::chrono::nanoseconds>(stop - start).count();
        ns.push_back(
            static_cast<std::uint32_t>(slow ? std::min<std::int64_t>(wall, processor_ns() - busy) : wall));
    }
    return ns;
}

int run_rivals(int argc, char **argv, const std::vector<RivalRow> &table)
{
    try {
        const Options options = parse(argc, argv);
        std::vector<const RivalRow *> rows;
        const bool exact =
            std::ranges::any_of(table, [&](const RivalRow &row) { return row.name == options.only; });
        for (const RivalRow &row : table)
            if (exact ? row.name == options.only : row.name.find(options.only) != std::string::npos)
                rows.push_back(&row);
        if (options.list) {
            for (const RivalRow *row : rows)
                fmt::print("{}\t{}\n", row->kind == Kind::points ? "points" : "mesh", row->name);
            return 0;
        }
        if (options.count > 0)
            count_ticks(rows, options.count);
        else
            serve(rows, options.budget);
        return 0;
    } catch (...) {
        const Failure failure = current_failure();
        tell_failure("bench", failure);
        return static_cast<int>(failure.code);
    }
}

} // namespace voxshell::bench
