// SPDX-License-Identifier: GPL-3.0-or-later
// The loop in the time domain: the runtime's own simulated device and coupling against a spring at the
// origin, without friction and with a fine encoder, so that what is small stays linear.
#pragma once

#include "voxshell/coupling.h"
#include "voxshell/simulated.h"

#include <cmath>
#include <stdexcept>
#include <vector>

namespace voxshell {

class TimeDomain {
  public:
    TimeDomain(vxs_simulated_config device, const vxs_coupling_config &coupling, bool ideal = true)
        : device_memory_(vxs_simulated_memory()), coupling_memory_(vxs_coupling_memory())
    {
        if (ideal) device.profile.friction = device.profile.resolution = 0;
        device.profile.peak_force = 1e30;
        device.start.position[0] = 1e-3; // and the hand's target stays there: a step
        if (vxs_simulated_open(device_memory_.data(), device_memory_.size(), &device, &device_) != VXS_OK ||
            vxs_device_arm(device_) != VXS_OK ||
            vxs_coupling_init(coupling_memory_.data(), coupling_memory_.size(), &coupling, &coupling_) !=
                VXS_OK) {
            throw std::runtime_error("time domain: refused");
        }
        const double origin[3] = {0, 0, 0};
        vxs_simulated_hand(device_, origin, nullptr);
    }
    ~TimeDomain() { vxs_device_close(device_); }
    TimeDomain(const TimeDomain &) = delete;
    TimeDomain &operator=(const TimeDomain &) = delete;

    /// So many ticks on; returns the root mean square of the position over them.
    double run(double stiffness, long ticks)
    {
        double sum = 0;
        for (long n = 0; n < ticks; ++n) {
            vxs_device_state state;
            vxs_device_exchange(device_, &command_, &state, nullptr);
            const double x = state.pose.position[0];
            vxs_wrench contact = {{0, 0, 0}, {0, 0, 0}};
            vxs_pose body;
            do {
                vxs_coupling_pose(coupling_, &state.pose, &body);
                contact.force[0] = -stiffness * body.position[0];
            } while (vxs_coupling_refine(coupling_, &contact, std::abs(body.position[0]), &state.pose));
            vxs_coupling_step(coupling_, &contact, &state.pose, &command_.wrench);
            command_.sequence++;
            command_.hold_ns = state.time_ns + 1'000'000'000;
            command_.expires_ns = command_.hold_ns + 1'000'000;
            sum += x * x;
        }
        return std::sqrt(sum / static_cast<double>(ticks));
    }

  private:
    struct alignas(64) Block {
        unsigned char bytes[64];
    };
    struct Room {
        explicit Room(std::size_t size) : blocks(size / sizeof(Block) + 1), size_(size) {}
        void *data() { return blocks.data(); }
        std::size_t size() const { return size_; }
        std::vector<Block> blocks;
        std::size_t size_;
    };
    Room device_memory_, coupling_memory_;
    vxs_device *device_ = nullptr;
    vxs_coupling *coupling_ = nullptr;
    vxs_device_command command_{};
};

/// Growth of the oscillation in e-folds over `ticks`, once the first quarter has passed.
inline double growth(const vxs_simulated_config &device, const vxs_coupling_config &coupling,
                     double stiffness, long ticks)
{
    TimeDomain loop(device, coupling);
    loop.run(stiffness, ticks / 4);
    const double before = loop.run(stiffness, ticks / 4);
    loop.run(stiffness, ticks / 4);
    const double after = loop.run(stiffness, ticks / 4);
    return std::isfinite(after) ? std::log(after / before) : INFINITY;
}

} // namespace voxshell
