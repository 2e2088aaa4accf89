// SPDX-License-Identifier: GPL-3.0-or-later
// One way to find the contact of the moving sphere, timed: what each benchmark program implements, and the
// main() that they share.
//
// A program reads jobs from standard input, one a line, `MOTION SIZE VOXEL_MM` ("slide 100000 0.5"), and
// answers each with a line of JSON per rival and then an empty line. What is built for a job stays for the
// next one on the same static part, so that a script can go back and forth between programs and a load on the
// machine hits all alike. Arguments: --list (names, kinds); --only TEXT (the rival of this name, or those
// that contain it);
// --budget SECONDS (about, per rival and job: a slow rival is timed at every n-th pose); --count TICKS (for
// an instruction counter: no timing, so many ticks).
#pragma once

#include "contact_workload.hpp"

#include <chrono>
#include <functional>
#include <memory>
#include <span>

namespace voxshell::bench {

/// What a tick found.
struct Contact {
    Vec3 force{}, torque{};     ///< for 1 N/m a point [N, N m]; torque about the sphere's centre
    double depth = 0;           ///< deepest contact [m]
    std::uint64_t contacts = 0; ///< points or triangle pairs
    std::int64_t touched = -1;  ///< points looked at; -1: not told
};

class Rival {
  public:
    virtual ~Rival() = default;
    virtual Contact tick(const Pose &pose) = 0;
    virtual double static_mib() const = 0; ///< memory of the static part [MiB]
};

struct Job {
    Motion motion{};
    std::uint32_t size = 0; ///< points, or triangles of the moving mesh
    double voxel = 0;       ///< [m]
    bool operator==(const Job &) const = default;
};

enum class Kind { points, mesh };

/// A row of a program's table. `make` gets the sphere's points (empty for Kind::mesh).
struct RivalRow {
    std::string name;
    Kind kind;
    std::function<std::unique_ptr<Rival>(const Job &, const Points &)> make;
};

/// Nanoseconds of each tick at `poses`, in order, after a few that are not timed. From 0.1 ms on it is the
/// thread's own processor time: a long tick on a shared machine never goes uninterrupted.
std::vector<std::uint32_t> time_ticks(Rival &rival, std::span<const Pose> poses);

/// The main() of a benchmark program.
int run_rivals(int argc, char **argv, const std::vector<RivalRow> &table);

/// Keeps what `make` made for the last key, so that rivals on the same static part share it.
template<typename Key, typename Value>
class Last {
  public:
    template<typename Make>
    std::shared_ptr<const Value> get(const Key &key, Make make)
    {
        if (!value_ || !(key == key_)) {
            value_.reset(); // frees the old one first
            value_ = make();
            key_ = key;
        }
        return value_;
    }

  private:
    Key key_{};
    std::shared_ptr<const Value> value_;
};

} // namespace voxshell::bench
