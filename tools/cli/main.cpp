// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell VERB ...: finds the verb, runs it, and turns whatever it ends with into one line and an exit code.
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

constexpr const char *exit_codes =
    "exit codes: 0 ok, 1 usage, 2 file or system, 3 invalid input, 4 requirement not met,\n"
    "            5 unsupported, 6 differs, 70 bug, 130 interrupted\n";

const Verb *find_verb(const std::string &name)
{
    for (const Verb &verb : verbs())
        if (name == verb.name) return &verb;
    return nullptr;
}

/// Text in lines of at most `width` columns, the second and later ones indented.
std::string wrapped(const std::string &text, std::size_t width, std::size_t indent)
{
    std::string out;
    std::size_t column = 0;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        if (column && column + 1 + (end - at) > width) {
            out += "\n" + std::string(indent, ' ');
            column = 0;
        } else if (column) {
            out += ' ';
            ++column;
        }
        out += text.substr(at, end - at);
        column += end - at;
        at = end + 1;
    }
    return out;
}

/// One screen: the example first, then what the options mean.
std::string help(const CLI::App *app, std::string, CLI::AppFormatMode)
{
    constexpr std::size_t column = 24, width = 100;
    const auto row = [](std::string left, const std::string &text) {
        left = "  " + left;
        if (left.size() + 2 > column)
            left += "\n" + std::string(column, ' ');
        else
            left.resize(column, ' ');
        return left + wrapped(text, width - column, column) + "\n";
    };
    const Verb *verb = find_verb(app->get_name());
    std::string out =
        verb ? fmt::format("{}\n\nvoxshell {}: {}\n", verb->example, verb->name, verb->summary)
             : fmt::format("{}\n\nvoxshell VERB ...: {}\n", verbs()[0].example, app->get_description());
    std::string arguments, options;
    for (const CLI::Option *option : app->get_options()) {
        if (option->get_group().empty()) continue; // the footer has their names
        if (option->get_positional()) {
            arguments += row(option->get_name(true) + (option->get_items_expected_max() > 1 ? "..." : ""),
                             option->get_description());
            continue;
        }
        std::string name = option->get_name(false, true);
        for (std::size_t at; (at = name.find(",--")) != std::string::npos;) name.replace(at, 1, ", ");
        const std::string type = option->get_type_name(); // "AXIS:{y,z}": the text tells the values
        if (option->get_items_expected_max() > 0) name += " " + type.substr(0, type.find(':'));
        options += row(name, option->get_description());
    }
    if (!verb) {
        out += "\nverbs\n";
        for (const Verb &each : verbs()) out += row(each.name, each.summary);
    }
    if (!arguments.empty()) out += "\narguments\n" + arguments;
    out += "\noptions\n" + options;
    if (!app->get_footer().empty()) out += "\n" + wrapped(app->get_footer(), width, 2) + "\n";
    out += verb ? "" : std::string("\nvoxshell VERB --help tells more.\n") + exit_codes;
    return out;
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
    app.formatter_fn(help);
    app.set_help_flag("-h,--help", "this page");
    app.set_version_flag("--version", "voxshell " VOXSHELL_VERSION, "this program's version");
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
