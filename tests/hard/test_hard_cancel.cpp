// SPDX-License-Identifier: GPL-3.0-or-later
// Long work stops when it is asked to: the time from the request to the exception, at many places of every
// step.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "../bench/cup.hpp"
#include "mesh/orient.hpp"
#include "mesh/report.hpp"
#include "pointshell/pointshell_file.hpp"
#include "pointshell/shell.hpp"
#include "voxmap/channels.hpp"
#include "voxmap/classify.hpp"
#include "voxmap/vdb.hpp"
#include "voxmap/voxmap_file.hpp"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>

using namespace voxshell;

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double slower = 20;
#elif defined(VXS_COUNTING)
constexpr double slower = 4;
#else
constexpr double slower = 1;
#endif

/// Processor time of all threads [s]: what a machine that others use too does not stretch.
double worked()
{
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double seconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Asks for the end once the process has worked until `when`.
class Stop : public Progress {
  public:
    explicit Stop(double when) : when_(when) {}
    void check() override
    {
        if (worked() >= when_) throw Failure(ExitCode::interrupted, "", "interrupted");
    }

  private:
    double when_;
};

struct Worst {
    double whole = 0, work = 0, wall = 0;
    int stopped = 0;
};

/// Runs `work` to its end, then stops it at `places` places.
Worst stop(const char *name, const std::function<void(Progress &)> &work, int places = 8)
{
    Worst worst;
    Progress silent;
    const double begin = worked(), begin_wall = seconds();
    work(silent);
    worst.whole = worked() - begin;
    const double pace = (seconds() - begin_wall) / worst.whole; // wall per work
    for (int n = 0; n < places; ++n) {
        const double from = worked(), wall = seconds(), after = worst.whole * (n + 0.5) / places;
        try {
            Stop progress(from + after);
            work(progress);
        } catch (const Failure &failure) {
            CHECK(failure.code == ExitCode::interrupted);
            ++worst.stopped;
        }
        // Done all the same, if the request came after the last check: then the rest is what it cost.
        worst.work = std::max(worst.work, worked() - from - after);
        if (std::getenv("VXS_CANCEL_CELLS"))
            std::printf("  at %.2f s: %.0f ms of work\n", after, 1e3 * (worked() - from - after));
        worst.wall = std::max(worst.wall, seconds() - wall - after * pace);
    }
    std::printf("%-14s %6.2f s of work, stopped %d of %d times, after at most %.0f ms of work (about %.0f ms "
                "by the clock)\n",
                name, worst.whole, worst.stopped, places, 1e3 * worst.work, 1e3 * worst.wall);
    return worst;
}

} // namespace

TEST_CASE("every long step ends soon after it is asked to")
{
    const char *asked = std::getenv("VXS_CANCEL_CELLS"); // by hand: larger steps, longer waits
    const Mesh mesh = bench_cup();
    const LatticeMesh lattice = snap(mesh, 0.090 / (asked ? std::atoi(asked) : 400));
    Progress silent;
    const BrickTriangles binned = bin_triangles(lattice, silent);
    const Cells surface = voxelize(lattice, binned, silent);
    const WindingNumber winding(mesh);
    Cells solid = surface;
    classify(solid, winding, silent);
    // 100 ms of the work of all threads: on a machine of one's own at most as much by the clock, and other
    // people's work stretches it little. Sanitizers multiply it, and counters.
    const double bar = 0.1 * slower;
    const auto check = [&](const Worst &w) { CHECK(w.work < bar); };
    check(stop("bin", [&](Progress &p) { bin_triangles(lattice, p); }));
    check(stop("voxelize", [&](Progress &p) { voxelize(lattice, binned, p); }));
    check(stop("classify", [&](Progress &p) {
        Cells cells = surface;
        classify(cells, winding, p);
    }));
    const LatticeMesh coarse = snap(mesh, 0.090 / 128);
    const Cells coarse_surface = voxelize(coarse, bin_triangles(coarse, silent), silent);
    check(stop("close gaps", [&](Progress &p) {
        Cells cells = coarse_surface;
        classify_closing(cells, winding, 4 * coarse.voxel, p);
    }));
    check(stop("points", [&](Progress &p) { make_shell(lattice, binned, solid, ShellKind::exact, p); }));
    const PointshellFile shell{make_shell(lattice, binned, solid, ShellKind::exact, silent)};
    check(stop("channels", [&](Progress &p) {
        Cells cells = solid;
        make_channels(cells, lattice, binned, winding, true, {3, 3}, p);
    }));
    VoxmapFile file;
    file.channels = make_channels(solid, lattice, binned, winding, true, {3, 3}, silent);
    file.cells = std::move(solid);
    check(stop(".voxmap", [&](Progress &p) { voxmap_bytes(file, &p); }));
    check(stop(".pointshell", [&](Progress &p) { pointshell_bytes(shell, &p); }));
    check(stop(".vdb", [&](Progress &p) { vdb_bytes(file.cells, {}, "{}", file.channels, &p); }));
}

TEST_CASE("what takes no Progress is short by itself: 10^5 triangles")
{
    const Mesh mesh = bench_cup();
    const auto time = [](const char *name, const std::function<void()> &work) {
        const double begin = worked();
        work();
        const double took = worked() - begin;
        std::printf("%-14s %6.0f ms for 102600 triangles\n", name, 1e3 * took);
        return took;
    };
    CHECK(time("snap", [&] { snap(mesh, 1e-4); }) < 0.2);
    CHECK(time("winding tree", [&] { const WindingNumber tree(mesh); }) < 0.5);
    time("report", [&] { report(mesh); });
    time("orient", [&] {
        Mesh copy = mesh;
        orient(copy);
    });
}
