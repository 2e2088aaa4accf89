// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell VERB ...: finds the verb, runs it, and turns whatever it ends with into one line and an exit code.
#include "cli/manual.hpp"
#include "cli/progress.hpp"
#include "cli/verb.hpp"
#include "pipeline/output.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include <unistd.h>

namespace voxshell {
namespace {

const Verb *find_verb(const std::string &name)
{
    for (const Verb &verb : verbs())
        if (name == verb.name) return &verb;
    return nullptr;
}

int complain(const std::string &verb, const Failure &failure)
{
    const std::string who = verb.empty() ? "voxshell" : "voxshell " + verb;
    if (failure.code == ExitCode::interrupted)
        fmt::print(stderr, "{}: interrupted\n", who);
    else
        tell_failure(verb, failure);
    if (failure.code == ExitCode::usage) fmt::print(stderr, "see {} --help\n", who);
    return static_cast<int>(failure.code);
}

int run(int argc, char **argv)
{
    CLI::App app{"CAD scenes to haptic assets, and what is done with them"};
    app.formatter_fn([](const CLI::App *of, std::string, CLI::AppFormatMode) { return help_page(*of); });
    app.set_help_flag("-h,--help", "this page");
    app.set_version_flag("--version", "voxshell " VOXSHELL_VERSION, "this program's version");
    std::string manual;
    app.add_option("--write-manual", manual, "man pages and completion into a folder")->group("");
    std::vector<std::pair<CLI::App *, VerbAction>> actions;
    std::string chosen;
    try {
        for (const Verb &verb : verbs()) {
            CLI::App *sub = app.add_subcommand(verb.name, verb.summary);
            sub->set_help_flag("-h,--help", "this page");
            sub->set_version_flag("--version", "voxshell " VOXSHELL_VERSION, "this program's version");
            actions.emplace_back(sub, verb.add(*sub));
        }
        if (argc > 1 && find_verb(argv[1]))
            chosen = argv[1];
        else if (argc > 1 && argv[1][0] != '-')
            throw Failure(ExitCode::usage, "", fmt::format("'{}' is not a verb", argv[1]));
        app.parse(argc, argv);
        for (const auto &[sub, action] : actions) {
            if (!sub->parsed()) continue;
            catch_interrupts();
            if (find_verb(chosen)->leaves)
                leave_when_interrupted([&chosen] {
                    Outputs::abandon_all();
                    _exit(complain(chosen, Failure(ExitCode::interrupted, "", "interrupted")));
                });
            const ExitCode code = action();
            if (std::fflush(stdout) != 0 || std::ferror(stdout))
                throw Failure(ExitCode::system, "standard output", std::strerror(errno));
            return static_cast<int>(code);
        }
        if (!manual.empty()) {
            write_manual(app, manual);
            return 0;
        }
        throw Failure(ExitCode::usage, "", "a verb is missing");
    } catch (const CLI::CallForHelp &) {
        fmt::print("{}", app.help());
        return 0;
    } catch (const CLI::CallForVersion &) {
        fmt::print("voxshell " VOXSHELL_VERSION "\n");
        return 0;
    } catch (const CLI::Success &) {
        return 0; // an option that prints and ends
    } catch (const CLI::ParseError &error) {
        return complain(chosen, Failure(ExitCode::usage, "", error.what()));
    } catch (...) {
        return complain(chosen, current_failure());
    }
}

} // namespace
} // namespace voxshell

int main(int argc, char **argv)
{
    return voxshell::run(argc, argv);
}
