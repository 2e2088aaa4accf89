// SPDX-License-Identifier: GPL-3.0-or-later
// The onset with the real contact: a body that a hand presses against a floor, law gradient, field distance.
// Points are so stiff that the bound most_stiffness is what acts.
#include "plan/time_domain.hpp"
#include "study/bodies.hpp"
#include "study/open_part.hpp"
#include "study/stability_run.hpp"

#include "voxshell/contact.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace voxshell {
namespace {

constexpr double cell = 1e-3, flat_half = 2e-3, ball_radius = 4e-3; ///< [m]
constexpr double point_stiffness = 1e6;                             ///< [N/m]
constexpr double pressed = 2e-4;                                    ///< into the floor, in balance [m]
constexpr double kick = 0.01; ///< of the push: small motions stay in contact
constexpr double tolerance = 0.02, width = 1.3, periods = 60;
constexpr double rounding = 1e-9;      ///< [m]
constexpr double saturated = 0.95;     ///< of what it was: a bouncing body neither grows nor calms down
constexpr double still_within = 1e-15; ///< [m] a tick
constexpr long still_ticks = 200;

OpenPart part(const char *name, const Mesh &mesh, bool stands, Progress &progress)
{
    PartOptions options;
    options.voxel = cell;
    options.shell = ShellKind::exact;
    options.stands = stands;
    if (stands) options.channels = {0, 4};
    return {name, mesh, options, progress};
}

/// The lowest point of it is at the origin.
Mesh standing_ball()
{
    Mesh mesh = ball(ball_radius, 64);
    for (Point &vertex : mesh.vertices) vertex[2] += ball_radius;
    return mesh;
}

class PressedLoop {
  public:
    PressedLoop(const LoopKey &key, const OpenPart &floor, const OpenPart &body, double bound)
        : device_room_(vxs_simulated_memory()), coupling_room_(vxs_coupling_memory()),
          contact_room_(vxs_contact_memory(&body.shell, 1)), statics_{&floor.map, nullptr},
          target_(pressed * (1 + bound / key.arm->stiffness))
    {
        const vxs_simulated_config device = small_motions(key.device());
        const vxs_coupling_config coupling = key.coupling();
        vxs_contact_config_default(&config_);
        config_.law = VXS_CONTACT_GRADIENT;
        config_.field = VXS_CONTACT_DISTANCE;
        config_.stiffness = point_stiffness;
        config_.most_stiffness = bound;
        if (vxs_simulated_open(device_room_.get(), device_room_.size(), &device, &device_) != VXS_OK ||
            vxs_device_arm(device_) != VXS_OK ||
            vxs_coupling_init(coupling_room_.get(), coupling_room_.size(), &coupling, &coupling_) != VXS_OK ||
            vxs_contact_init(contact_room_.get(), contact_room_.size(), &body.shell, 1, &contact_) != VXS_OK)
            throw Failure(ExitCode::bug, key.profile->name, "the runtime refuses the loop");
    }
    ~PressedLoop() { vxs_device_close(device_); }
    PressedLoop(const PressedLoop &) = delete;
    PressedLoop &operator=(const PressedLoop &) = delete;

    /// Standard deviation of the height over so many ticks, the hand's push going from one share to another.
    double run(double from, double to, long ticks)
    {
        double sum = 0, square = 0, first = 0;
        long still = 0; // at one height, and the hand too: the rest would go on in ever smaller speeds
        for (long n = 0; n < ticks; ++n) {
            const double share = from + (to - from) * static_cast<double>(n + 1) / static_cast<double>(ticks);
            const double hand[3] = {0, 0, -share * target_};
            vxs_simulated_hand(device_, hand, nullptr);
            vxs_device_state state;
            vxs_device_exchange(device_, &command_, &state, nullptr);
            vxs_contact_result result;
            vxs_contact_evaluate(contact_, &statics_, 1, &state.pose, &config_, &result);
            vxs_coupling_step(coupling_, &result.wrench, &state.pose, &command_.wrench);
            command_.sequence++;
            command_.hold_ns = state.time_ns + 1'000'000'000;
            command_.expires_ns = command_.hold_ns + 1'000'000;
            double at[3];
            vxs_simulated_truth(device_, at, nullptr);
            still = from == to && std::abs(at[2] - height_) < still_within ? still + 1 : 0;
            height_ = at[2];
            if (still > still_ticks) break;
            first = n == 0 ? at[2] : first;
            sum += (at[2] - first) / static_cast<double>(ticks);
            square += (at[2] - first) * (at[2] - first) / static_cast<double>(ticks);
        }
        return std::sqrt(std::max(0.0, square - sum * sum));
    }

  private:
    Memory device_room_, coupling_room_, contact_room_;
    vxs_contact_static statics_;
    double target_; ///< of the hand, below the floor [m]
    vxs_contact_config config_{};
    vxs_device *device_ = nullptr;
    vxs_coupling *coupling_ = nullptr;
    vxs_contact *contact_ = nullptr;
    vxs_device_command command_{};
    double height_ = 0; ///< of the tick before [m]
};

/// Pressed slowly, kicked, left alone: whether it is not calming down.
bool stirs(const LoopKey &key, const OpenPart &floor, const OpenPart &body, double bound, long ticks)
{
    PressedLoop loop(key, floor, body, bound);
    loop.run(0, 1, ticks / 2);
    loop.run(1 + kick, 1 + kick, ticks / 4);
    const double before = loop.run(1 + kick, 1 + kick, ticks / 4);
    loop.run(1 + kick, 1 + kick, ticks / 4);
    const double after = loop.run(1 + kick, 1 + kick, ticks / 4);
    return after > rounding && after > saturated * before;
}

} // namespace

std::vector<ContactOnset> run_contact_onsets(std::span<const LoopMap> loops, bool quick, Progress &progress)
{
    const OpenPart floor = part("floor", slab(0.008, 0, 0.006), true, progress),
                   flat = part("flat", slab(flat_half, flat_half, flat_half), false, progress),
                   round = part("ball", standing_ball(), false, progress);
    std::vector<const LoopMap *> pressed_ones;
    for (const LoopMap &map : loops) {
        const bool held = map.key.arm->stiffness > 0;
        const bool asked = (map.key.hertz == 0 || map.key.hertz == 5 || map.key.hertz == 50) &&
                           (!quick || std::string_view(map.key.arm->name) == "hand");
        if (held && asked) pressed_ones.push_back(&map);
    }
    std::vector<ContactOnset> onsets(2 * pressed_ones.size());
    progress.stage("contact", onsets.size());
    tbb::parallel_for(std::size_t{0}, onsets.size(), [&](std::size_t n) {
        const LoopMap &map = *pressed_ones[n / 2];
        const OpenPart &body = n % 2 ? round : flat;
        const long ticks = ticks_of_onset(Loop(map.key.device(), map.key.coupling()), map.largest, periods);
        onsets[n] = {map.key, n % 2 ? "ball" : "flat", map.largest,
                     onset(map.largest, width, tolerance, [&](double bound) {
                         progress.check();
                         return stirs(map.key, floor, body, bound, ticks);
                     })};
        progress.advance(1);
    });
    return onsets;
}

} // namespace voxshell
