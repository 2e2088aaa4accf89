// SPDX-License-Identifier: GPL-3.0-or-later
// What is told of the verbs and their options, out of one table: --help, man pages, completion in a shell.
#pragma once

#include <filesystem>
#include <string>

namespace CLI {
class App;
}

namespace voxshell {

/// The page of --help: of a verb, or of the program. The example first, then what the options mean.
std::string help_page(const CLI::App &app);

/// man1/voxshell.1, man1/voxshell-VERB.1 for each verb, and completions/voxshell for bash, into `folder`.
/// Throws Failure(system).
void write_manual(const CLI::App &program, const std::filesystem::path &folder);

} // namespace voxshell
