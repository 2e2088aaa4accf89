// SPDX-License-Identifier: GPL-3.0-or-later
// What stands between this machine and a device: permissions, who holds it, power saving, limits, the kernel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

struct Finding {
    std::string what;
    enum class Verdict { ok, notice, trouble } verdict = Verdict::ok;
    std::string fact, fix; ///< fix: a command or a line for a file, empty where nothing is to be done
};

/// A device on a wire that might be ours.
struct Candidate {
    std::string kind;  ///< of hardware.h; of a tty any that speaks over one
    std::string where; ///< "USB 256f:c635 at /dev/bus/usb/001/002", "/dev/ttyACM0"
    std::string node;  ///< in /dev
    bool is_usable = false;
    std::string why_not; ///< and the fix
};

/// `root`: "/" but in tests, where a tree stands for it.
std::vector<Candidate> find_candidates(const std::filesystem::path &root);
std::vector<Finding> examine(const std::vector<Candidate> &candidates, const std::filesystem::path &root);

/// The line for /etc/udev/rules.d/70-voxshell.rules that lets whoever sits at the machine use a device, by its
/// hidraw node or on USB (hardware.h).
std::string udev_rule(std::uint32_t wire, unsigned vendor, unsigned product);

} // namespace voxshell
