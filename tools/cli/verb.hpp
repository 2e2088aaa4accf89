// SPDX-License-Identifier: GPL-3.0-or-later
// The verbs of `voxshell`: one file each, one line each in the table of verbs.cpp.
#pragma once

#include "cli/failure.hpp"

#include <functional>
#include <span>

namespace CLI {
class App;
}

namespace voxshell {

/// Adds a verb's options to its subcommand and returns what runs when it was chosen. The action prints
/// results on stdout, everything else on stderr, and throws Failure.
using VerbAction = std::function<ExitCode()>;

struct Verb {
    const char *name;
    const char *summary; ///< one line for --help
    const char *example; ///< one or two command lines, printed first by --help
    VerbAction (*add)(CLI::App &);
    bool leaves = false; ///< at ^C at once: it has no child, and nothing on the disk but Outputs
};

std::span<const Verb> verbs();

VerbAction add_convert(CLI::App &);
VerbAction add_batch(CLI::App &);
VerbAction add_inspect(CLI::App &);
VerbAction add_verify(CLI::App &);
VerbAction add_diff(CLI::App &);
VerbAction add_pack(CLI::App &);
VerbAction add_export(CLI::App &);
VerbAction add_simulate(CLI::App &);
VerbAction add_design(CLI::App &);
VerbAction add_bench(CLI::App &);
VerbAction add_device(CLI::App &);
VerbAction add_study(CLI::App &);
VerbAction add_view(CLI::App &);

} // namespace voxshell
