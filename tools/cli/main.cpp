// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell VERB ...: finds the verb, runs it, and turns whatever it ends with into one line and an exit code.
#include "cli/manual.hpp"
#include "cli/progress.hpp"
#include "cli/verb.hpp"
#include "pipeline/output.hpp"
#include "scene/spelling.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

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

/// "; did you mean X?", or nothing.
std::string meant(const std::string &word, const std::vector<std::string> &known)
{
    const std::vector<std::string_view> words(known.begin(), known.end());
    if (words.empty()) return "";
    const std::string_view near = nearest(word, words);
    return is_near(word, near) ? fmt::format("; did you mean {}?", near) : "";
}

std::string no_verb(const std::string &word)
{
    std::vector<std::string> known;
    for (const Verb &verb : verbs()) known.push_back(verb.name);
    return fmt::format("'{}' is not a verb{}", word, meant(word, known));
}

/// The first word of a command line that its verb has no use for.
std::string no_use(const CLI::App &verb)
{
    const std::string word = verb.remaining(true).front();
    if (word[0] != '-') return fmt::format("'{}': one argument too many", word);
    std::vector<std::string> known;
    for (const CLI::Option *option : verb.get_options())
        for (const std::string &name : option->get_lnames()) known.push_back("--" + name);
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("{} is not an option{}", name, meant(name, known));
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
            throw Failure(ExitCode::usage, "", no_verb(argv[1]));
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
    } catch (const CLI::ExtrasError &) {
        return complain(
            chosen, Failure(ExitCode::usage, "", no_use(chosen.empty() ? app : *app.get_subcommand(chosen))));
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
