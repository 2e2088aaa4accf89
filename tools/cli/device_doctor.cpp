// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/device_doctor.hpp"

#include "voxshell/hardware.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <fstream>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using Verdict = Finding::Verdict;

std::string first_line(const fs::path &path)
{
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

std::vector<fs::path> entries(const fs::path &folder)
{
    std::vector<fs::path> out;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        out.push_back(at->path());
    std::ranges::sort(out);
    return out;
}

bool is_number(const std::string &text)
{
    return !text.empty() && std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// "spacenavd (812)" for each process that has the node open, of those that may be looked at.
std::string holders(const fs::path &root, const std::string &node)
{
    std::string out;
    for (const fs::path &process : entries(root / "proc")) {
        const std::string id = process.filename().string();
        if (!is_number(id) || id == std::to_string(getpid())) continue;
        for (const fs::path &file : entries(process / "fd")) {
            std::error_code error;
            if (fs::read_symlink(file, error) != node || error) continue;
            out += fmt::format("{}{} ({})", out.empty() ? "" : ", ", first_line(process / "comm"), id);
            break;
        }
    }
    return out;
}

Finding limit(const std::string &what, int resource, rlim_t enough, const std::string &name,
              const std::string &meaning)
{
    rlimit now{};
    getrlimit(resource, &now);
    const bool is_enough = now.rlim_cur == RLIM_INFINITY || now.rlim_cur >= enough;
    Finding out{
        what, is_enough ? Verdict::ok : Verdict::notice,
        now.rlim_cur == RLIM_INFINITY ? name + " unlimited" : fmt::format("{} {}", name, now.rlim_cur), ""};
    if (geteuid() == 0 && !is_enough) {
        out.verdict = Verdict::ok;
        out.fact += ", root needs none";
    } else if (!is_enough) {
        out.fact += meaning;
        out.fix = fmt::format("@realtime - {} {}   in /etc/security/limits.d/voxshell.conf, then `adduser "
                              "$USER realtime` and log in anew",
                              name, resource == RLIMIT_RTPRIO ? "90" : "unlimited");
    }
    return out;
}

Finding preemption(const fs::path &root)
{
    const std::string version = first_line(root / "proc/version");
    if (first_line(root / "sys/kernel/realtime") == "1" || version.find("PREEMPT_RT") != std::string::npos)
        return {"kernel", Verdict::ok, "fully preemptible (PREEMPT_RT)", ""};
    const bool is_preemptible = version.find("PREEMPT") != std::string::npos;
    return {"kernel", Verdict::notice,
            is_preemptible ? "preemptible, not PREEMPT_RT: now and then a tick is late by milliseconds"
                           : "does not say that it is preemptible: ticks may be late by milliseconds",
            "apt install linux-image-rt-amd64"};
}

/// Where on sysfs a device node of USB is.
fs::path usb_folder(const fs::path &root, const std::string &node)
{
    for (const fs::path &device : entries(root / "sys/bus/usb/devices")) {
        const std::string bus = first_line(device / "busnum"), number = first_line(device / "devnum");
        if (is_number(bus) && is_number(number) &&
            fmt::format("/dev/bus/usb/{:0>3}/{:0>3}", bus, number) == node)
            return device;
    }
    return {};
}

Finding autosuspend(const fs::path &root, const Candidate &candidate)
{
    const fs::path device = usb_folder(root, candidate.node);
    const std::string control = device.empty() ? "" : first_line(device / "power/control");
    if (control != "auto")
        return {"power of " + candidate.where, Verdict::ok,
                control.empty() ? "nothing said of power saving" : "stays on", ""};
    return {"power of " + candidate.where, Verdict::notice,
            "may be suspended when idle: the first packets after that are late",
            fmt::format("echo on > {}", (device / "power/control").string())};
}

} // namespace

std::string udev_rule(std::uint32_t wire, unsigned vendor, unsigned product)
{
    if (wire == VXS_HARDWARE_HIDRAW) // by the name of its HID device, which it has on Bluetooth, too
        return fmt::format(R"(SUBSYSTEM=="hidraw", KERNELS=="*:{:04X}:{:04X}.*", TAG+="uaccess")", vendor,
                           product);
    return fmt::format(
        R"(SUBSYSTEM=="usb", ATTR{{idVendor}}=="{:04x}", ATTR{{idProduct}}=="{:04x}", TAG+="uaccess")",
        vendor, product);
}

std::vector<Candidate> find_candidates(const fs::path &root)
{
    constexpr std::uint32_t most = 16;
    std::vector<Candidate> out;
    vxs_hardware_found found[most];
    const std::uint32_t here = std::min(vxs_hardware_probe(found, most), most);
    for (const vxs_hardware_found *f = found; f < found + here; ++f) {
        Candidate c{f->kind->name,
                    fmt::format("{} {:04x}:{:04x} at {}", f->wire == VXS_HARDWARE_HIDRAW ? "hidraw" : "USB",
                                f->vendor, f->product, f->node),
                    f->node, f->usable == VXS_OK && f->kind->is_built, ""};
        if (!f->kind->is_built)
            c.why_not = f->kind->lacks_text;
        else if (f->usable == VXS_ACCESS)
            c.why_not = fmt::format("no permission; write {} to /etc/udev/rules.d/70-voxshell.rules, then "
                                    "`udevadm control --reload && "
                                    "udevadm trigger`, and plug it in again",
                                    udev_rule(f->wire, f->vendor, f->product));
        else if (f->usable != VXS_OK)
            c.why_not = vxs_result_text(f->usable);
        out.push_back(c);
    }
    for (const fs::path &path : entries(root / "dev")) {
        const std::string name = path.filename().string();
        if (!name.starts_with("ttyACM") && !name.starts_with("ttyUSB")) continue;
        Candidate c{"hvlink or haply", "/dev/" + name, "/dev/" + name, access(path.c_str(), R_OK | W_OK) == 0,
                    ""};
        if (!c.is_usable)
            c.why_not =
                R"(no permission; write SUBSYSTEM=="tty", KERNEL=="ttyACM*|ttyUSB*", TAG+="uaccess" to )"
                "/etc/udev/rules.d/70-voxshell.rules, then `udevadm control --reload && udevadm trigger`";
        out.push_back(c);
    }
    return out;
}

std::vector<Finding> examine(const std::vector<Candidate> &candidates, const fs::path &root)
{
    std::vector<Finding> out;
    for (std::uint32_t n = 0; const vxs_hardware_kind *kind = vxs_hardware_kind_at(n); ++n) {
        out.push_back({fmt::format("kind {}", kind->name), kind->is_built ? Verdict::ok : Verdict::notice,
                       kind->is_built ? "built; not verified on hardware" : kind->lacks_text, ""});
    }
    if (candidates.empty())
        out.push_back({"devices", Verdict::notice,
                       "none on USB that a kind knows, and no /dev/ttyACM* or /dev/ttyUSB*", ""});
    for (const Candidate &c : candidates) {
        const std::string who = holders(root, c.node);
        out.push_back({c.where, c.is_usable ? Verdict::ok : Verdict::trouble,
                       c.is_usable ? "may be used" : c.why_not, ""});
        if (!who.empty())
            out.push_back({"who has " + c.where, Verdict::trouble, who + " has it open",
                           "end that program, or let it go"});
        if (c.node.starts_with("/dev/bus/usb")) out.push_back(autosuspend(root, c));
    }
    for (const char *socket : {"run/spnav.sock", "var/run/spnav.sock"}) {
        std::error_code error;
        if (!fs::exists(root / socket, error)) continue;
        out.push_back(
            {"spacenavd", Verdict::notice,
             fmt::format("/{} is there: by its hidraw node a six-axis mouse speaks to both it and voxshell; "
                         "over libusb only one can have it",
                         socket),
             "systemctl stop spacenavd"});
        break;
    }
    out.push_back(limit("priority", RLIMIT_RTPRIO, 80, "rtprio", ": the servo thread runs like any other"));
    out.push_back(
        limit("memory", RLIMIT_MEMLOCK, 256u << 20, "memlock", ": the servo's memory may be paged out"));
    out.push_back(preemption(root));
    return out;
}

} // namespace voxshell
