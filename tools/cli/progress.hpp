// SPDX-License-Identifier: GPL-3.0-or-later
// Progress of long work, and the way to stop it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

namespace voxshell {

/// Where long work tells how far it is. The base class is silent: libraries take a `Progress &` and
/// never know whether somebody watches. `advance` and `check` are safe from any thread.
class Progress {
  public:
    virtual ~Progress() = default;
    /// A new stage of `total` units of work begins ("voxelise", 102400). Not thread-safe.
    virtual void stage(std::string_view /*name*/, std::uint64_t /*total*/) {}
    /// `units` more units of the stage are done.
    virtual void advance(std::uint64_t /*units*/) {}
    /// Call at least every 50 ms of work: throws Failure(ExitCode::interrupted) after ^C.
    virtual void check() {}
};

enum class ProgressMode { automatic, always, never, json }; ///< automatic: only where stderr is a terminal

/// Progress on stderr: a line that rewrites itself with the time left of the stage, or one JSON object a line
/// (`{"stage":"voxelise","done":512,"total":4096}`). Its check() notices ^C even where nothing is shown.
std::unique_ptr<Progress> make_progress(ProgressMode mode, bool quiet);

/// From now on SIGINT and SIGTERM are remembered for check() instead of ending the process; a second one ends
/// it.
void catch_interrupts();

/// From now on an interrupted check() calls `leave`, which must end the process, instead of throwing: to take
/// apart what fills gigabytes takes longer than somebody who pressed ^C waits.
void leave_when_interrupted(std::function<void()> leave);

/// Whether SIGINT or SIGTERM came since catch_interrupts(): for what has to let go of something first.
bool interruption_requested();

/// True if text on this file descriptor may be coloured: a terminal, and no NO_COLOR.
bool may_colour(int descriptor);

} // namespace voxshell
