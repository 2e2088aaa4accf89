// SPDX-License-Identifier: GPL-3.0-or-later
// What a tool ends with: the exit codes of the command line, and the exception that carries one.
#pragma once

#include <stdexcept>
#include <string>

namespace voxshell {

/// Exit codes of `voxshell` (pinned; `voxshell --help` prints them).
enum class ExitCode : int {
    ok = 0,
    usage = 1,
    system = 2,      ///< file or system: cannot read, cannot write, no memory
    invalid = 3,     ///< invalid input
    requirement = 4, ///< requirement not met: --strict, a budget, not closed
    unsupported = 5, ///< valid, but a feature that voxshell cannot read
    differs = 6,
    bug = 70,
    interrupted = 130
};

/// The one way a room of the tools gives up. `what()` is one line: the fact and, where there is
/// one, the fix, without the file's name when `file` is given. Caught once, in cli/main.cpp, which
/// prints `voxshell VERB: error: FILE: WHAT` and exits with `code`.
class Failure : public std::runtime_error {
  public:
    Failure(ExitCode exit_code, std::string path, const std::string &what)
        : std::runtime_error(what), code(exit_code), file(std::move(path))
    {
    }
    ExitCode code;
    std::string file; ///< may be empty
};

/// The exception that is being handled as a Failure: itself, or what no memory, a file system error or a bug
/// is called. To be used in a catch block.
Failure current_failure();

/// A thing worth telling that did not stop the work; listed in the report.
struct Warning {
    std::string code; ///< stable, lower-case with dashes: "open-mesh"
    std::string message;
};

/// `voxshell VERB: error: FILE: WHAT` (one line, whatever a library said) on stderr; verb may be empty.
void tell_failure(const std::string &verb, const Failure &failure);

/// `voxshell VERB: warning: FILE: MESSAGE` on stderr.
void tell_warning(const std::string &verb, const std::string &file, const Warning &warning);

} // namespace voxshell
