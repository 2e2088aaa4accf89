// SPDX-License-Identifier: GPL-3.0-or-later
// device doctor in a tree that stands for a machine: who holds a device, power saving, the kernel, spacenavd, limits,
// and the udev rules word for word.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "cli/device_doctor.hpp"

#include "voxshell/hardware.h"

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

using namespace voxshell;
namespace fs = std::filesystem;
using Verdict = Finding::Verdict;

namespace {

class Machine {
  public:
    Machine()
    {
        char name[] = "test_device_doctor_XXXXXX";
        root_ = fs::absolute(mkdtemp(name));
        put("proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC Debian");
    }
    ~Machine() { fs::remove_all(root_); }
    Machine(const Machine &) = delete;
    Machine &operator=(const Machine &) = delete;

    void put(const std::string &path, const std::string &text) const
    {
        fs::create_directories((root_ / path).parent_path());
        std::ofstream(root_ / path) << text << "\n";
    }
    void hold(int id, const std::string &name, const std::string &node) const
    {
        const fs::path process = fs::path("proc") / std::to_string(id);
        put(process / "comm", name);
        fs::create_directories(root_ / process / "fd");
        fs::create_symlink(node, root_ / process / "fd/5");
    }
    void plug(const std::string &control) const
    {
        put("sys/bus/usb/devices/1-1/busnum", "1");
        put("sys/bus/usb/devices/1-1/devnum", "2");
        put("sys/bus/usb/devices/1-1/power/control", control);
    }
    const fs::path &root() const { return root_; }

    Finding find(const std::string &what, const std::vector<Candidate> &candidates = {}) const
    {
        for (const Finding &f : examine(candidates, root_))
            if (f.what == what) return f;
        return {"nothing of " + what, Verdict::trouble, "", ""};
    }

  private:
    fs::path root_;
};

const Candidate usb{"spacemouse", "USB 256f:c635 at /dev/bus/usb/001/002", "/dev/bus/usb/001/002", true, ""};

} // namespace

TEST_CASE("the udev rules")
{
    CHECK(udev_rule(VXS_HARDWARE_USB, 0x256F, 0xC635) ==
          R"(SUBSYSTEM=="usb", ATTR{idVendor}=="256f", ATTR{idProduct}=="c635", TAG+="uaccess")");
    CHECK(udev_rule(VXS_HARDWARE_HIDRAW, 0x256F, 0xC635) ==
          R"(SUBSYSTEM=="hidraw", KERNELS=="*:256F:C635.*", TAG+="uaccess")");
}

TEST_CASE("who holds it")
{
    const Machine machine;
    const std::string what = "who has " + usb.where;
    CHECK(machine.find(what, {usb}).what != what);
    machine.hold(812, "spacenavd", usb.node);
    machine.hold(77, "other", "/dev/null");
    const Finding found = machine.find(what, {usb});
    CHECK(found.verdict == Verdict::trouble);
    CHECK(found.fact == "spacenavd (812) has it open");
    CHECK(found.fix == "end that program, or let it go");
}

TEST_CASE("autosuspend")
{
    const Machine machine;
    const std::string what = "power of " + usb.where;
    CHECK(machine.find(what, {usb}).fact == "nothing said of power saving");
    machine.plug("on");
    CHECK(machine.find(what, {usb}).verdict == Verdict::ok);
    machine.plug("auto");
    const Finding found = machine.find(what, {usb});
    CHECK(found.verdict == Verdict::notice);
    CHECK(found.fix == "echo on > " + (machine.root() / "sys/bus/usb/devices/1-1/power/control").string());
}

TEST_CASE("the kernel's preemption")
{
    const Machine machine;
    CHECK(machine.find("kernel").fact.starts_with("preemptible, not PREEMPT_RT"));
    machine.put("proc/version", "Linux version 6.1.0 #1 SMP");
    CHECK(machine.find("kernel").fact.starts_with("does not say"));
    CHECK(machine.find("kernel").fix == "apt install linux-image-rt-amd64");
    machine.put("sys/kernel/realtime", "1");
    CHECK(machine.find("kernel").verdict == Verdict::ok);
}

TEST_CASE("spacenavd's socket")
{
    const Machine machine;
    CHECK(machine.find("spacenavd").what != "spacenavd");
    machine.put("run/spnav.sock", "");
    CHECK(machine.find("spacenavd").fix == "systemctl stop spacenavd");
}

TEST_CASE("limits, of root and of anybody else")
{
    const Machine machine;
    const rlimit none{0, 0}, little{65536, 65536};
    const bool is_root = geteuid() == 0;
    CHECK(setrlimit(RLIMIT_RTPRIO, &none) == 0);
    CHECK(setrlimit(RLIMIT_MEMLOCK, &little) == 0);
    if (is_root) {
        CHECK(machine.find("priority").fact == "rtprio 0, root needs none");
        CHECK(machine.find("memory").verdict == Verdict::ok);
        REQUIRE(seteuid(65534) == 0);
    }
    const Finding priority = machine.find("priority"), memory = machine.find("memory");
    if (is_root) REQUIRE(seteuid(0) == 0);
    CHECK(priority.verdict == Verdict::notice);
    CHECK(priority.fact == "rtprio 0: the servo thread runs like any other");
    CHECK(priority.fix.starts_with("@realtime - rtprio 90 "));
    CHECK(memory.fact == "memlock 65536: the servo's memory may be paged out");
    CHECK(memory.fix.starts_with("@realtime - memlock unlimited "));
}

TEST_CASE("serial devices are listed by their nodes")
{
    const Machine machine;
    machine.put("dev/ttyACM0", "");
    machine.put("dev/tty0", "");
    std::vector<Candidate> serial;
    for (const Candidate &c : find_candidates(machine.root()))
        if (c.kind == "hvlink or haply") serial.push_back(c);
    REQUIRE(serial.size() == 1);
    CHECK(serial[0].where == "/dev/ttyACM0");
    CHECK(serial[0].is_usable);
    CHECK(examine({}, machine.root()).size() >= 7);
    CHECK(machine.find("devices").fact ==
          "none on USB that a kind knows, and no /dev/ttyACM* or /dev/ttyUSB*");
}
