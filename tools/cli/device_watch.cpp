// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell device watch: what a servo loop in another process does right now.
#include "cli/device_actions.hpp"
#include "cli/run_report.hpp"
#include "study/servo_run.hpp"

#include "voxshell/live.h"

#include <fmt/format.h>

#include <chrono>
#include <thread>

namespace voxshell {
namespace {

using json = nlohmann::json;
using namespace std::chrono_literals;

json vector(const double v[3])
{
    return {v[0], v[1], v[2]};
}

json line(const vxs_servo_trace &row)
{
    json flags = json::array();
    for (unsigned bit = 0; bit < 32; ++bit)
        if (row.flags >> bit & 1 && !flag_name(bit).empty()) flags.push_back(flag_name(bit));
    const double *q = row.pose.orientation;
    return {{"schema", "voxshell-live/1"},
            {"tick", row.tick},
            {"time_s", static_cast<double>(row.time_ns) * 1e-9},
            {"position_m", vector(row.pose.position)},
            {"orientation_wxyz", {q[0], q[1], q[2], q[3]}},
            {"body_m", vector(row.body.position)},
            {"force_n", vector(row.command.force)},
            {"torque_nm", vector(row.command.torque)},
            {"collision_n", vector(row.collision.force)},
            {"depth_m", row.depth},
            {"points", row.points},
            {"gain", row.gain},
            {"flags", flags}};
}

struct Reader {
    explicit Reader(const std::string &path)
    {
        const vxs_result result = vxs_live_open(&live, path.c_str());
        if (result == VXS_OK) return;
        throw Failure(result == VXS_VERSION || result == VXS_MAGIC || result == VXS_TRUNCATED
                          ? ExitCode::invalid
                          : ExitCode::system,
                      path,
                      fmt::format("{}; `voxshell simulate SCENE --realtime --live FILE` makes one",
                                  vxs_result_text(result)));
    }
    ~Reader() { vxs_live_close(&live); }
    Reader(const Reader &) = delete;
    Reader &operator=(const Reader &) = delete;
    vxs_live live{};
};

} // namespace

ExitCode watch_live(const DeviceOptions &o, Progress &progress)
{
    if (o.device.empty())
        throw Failure(ExitCode::usage, "", "device watch: say which file, as /dev/shm/voxshell");
    const Reader reader(o.device);
    std::uint64_t seen = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(o.seconds);
    for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(50ms)) {
        progress.check();
        vxs_servo_trace row;
        const std::uint64_t sequence = vxs_live_get(&reader.live, &row);
        if (sequence == 0 || sequence == seen) continue;
        seen = sequence;
        if (o.json) {
            fmt::print("{}\n", line(row).dump());
        } else {
            const double *p = row.pose.position, *f = row.command.force;
            fmt::print(
                "tick {:>8}  at {:8.2f} {:8.2f} {:8.2f} mm  force {:7.3f} {:7.3f} {:7.3f} N  {} points\n",
                row.tick, 1e3 * p[0], 1e3 * p[1], 1e3 * p[2], f[0], f[1], f[2], row.points);
        }
        std::fflush(stdout);
    }
    if (!seen)
        throw Failure(ExitCode::requirement, o.device, "shows nothing: the loop that made it did not run");
    return ExitCode::ok;
}

} // namespace voxshell
