// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/manual.hpp"

#include "cli/verb.hpp"
#include "pipeline/output.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace voxshell {
namespace {

struct Exit {
    int code;
    const char *meaning;
};
constexpr Exit exits[] = {{0, "ok"},
                          {1, "usage"},
                          {2, "file or system"},
                          {3, "invalid input"},
                          {4, "requirement not met"},
                          {5, "unsupported"},
                          {6, "differs"},
                          {70, "bug"},
                          {130, "interrupted"}};

/// An argument or an option, as its verb has declared it.
struct Row {
    std::vector<std::string> names; ///< "-j", "--jobs"; of an argument: "FILE..."
    std::string value;              ///< "N"; empty: a flag
    std::string text;
    std::vector<std::string> choices; ///< the values, where only these are let pass
    bool is_argument = false, is_listed = true;
};

std::vector<Row> rows_of(const CLI::App &app)
{
    std::vector<Row> out;
    for (const CLI::Option *option : app.get_options()) {
        Row row;
        row.text = option->get_description();
        row.is_argument = option->get_positional();
        row.is_listed = !option->get_group().empty();     // a footer has the names of those that are not
        const std::string type = option->get_type_name(); // "WHEN:{auto,always}"
        const std::size_t colon = std::min(type.find(':'), type.size());
        if (const std::size_t open = type.find('{', colon); open != type.npos) {
            std::string_view list = std::string_view(type).substr(open + 1);
            list = list.substr(0, list.find('}'));
            for (std::size_t end; !list.empty(); list.remove_prefix(std::min(end + 1, list.size())))
                row.choices.emplace_back(list.substr(0, end = std::min(list.find(','), list.size())));
        }
        if (row.is_argument) {
            row.names = {option->get_name(true) + (option->get_items_expected_max() > 1 ? "..." : "")};
        } else {
            for (const std::string &name : option->get_snames()) row.names.push_back("-" + name);
            for (const std::string &name : option->get_lnames()) row.names.push_back("--" + name);
            if (option->get_items_expected_max() > 0) row.value = type.substr(0, colon);
        }
        out.push_back(std::move(row));
    }
    return out;
}

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

/// Text as roff takes it: no character of it is a command.
std::string roff(const std::string &text)
{
    std::string out;
    for (const char c : text) {
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
            out += std::string("\\&") + c;
        else
            out += c;
    }
    return out;
}

std::string roff_row(const Row &row)
{
    std::string name;
    for (const std::string &each : row.names)
        name += (name.empty() ? "" : ", ") + fmt::format("\\fB{}\\fR", roff(each));
    if (!row.value.empty()) name += fmt::format(" \\fI{}\\fR", roff(row.value));
    return fmt::format(".TP\n{}\n{}\n", name, roff(row.text));
}

std::string man_page(const CLI::App &app, const Verb *verb)
{
    const std::string name = verb ? fmt::format("voxshell-{}", verb->name) : "voxshell";
    std::string title = name;
    std::transform(title.begin(), title.end(), title.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    const std::vector<Row> rows = rows_of(app);
    std::string out =
        fmt::format(".TH {} 1 \"\" \"voxshell " VOXSHELL_VERSION "\" \"voxshell\"\n", roff(title));
    out +=
        fmt::format(".SH NAME\n{} \\- {}\n", roff(name), roff(verb ? verb->summary : app.get_description()));
    out += fmt::format(".SH SYNOPSIS\n\\fBvoxshell {}\\fR [\\fIoptions\\fR]",
                       verb ? verb->name : "\\fIVERB\\fB");
    for (const Row &row : rows)
        if (row.is_argument) out += fmt::format(" \\fI{}\\fR", roff(row.names[0]));
    out += verb ? "\n" : " ...\n";
    out += fmt::format(".SH EXAMPLES\n.nf\n{}\n.fi\n", roff(verb ? verb->example : verbs()[0].example));
    if (!verb) {
        out += ".SH VERBS\n";
        for (const Verb &each : verbs())
            out += fmt::format(".TP\n\\fBvoxshell\\-{}\\fR(1)\n{}\n", each.name, roff(each.summary));
    }
    for (const bool of_arguments : {true, false}) {
        std::string part;
        for (const Row &row : rows)
            if (row.is_argument == of_arguments && row.is_listed) part += roff_row(row);
        if (!part.empty()) out += std::string(of_arguments ? ".SH ARGUMENTS\n" : ".SH OPTIONS\n") + part;
    }
    if (!app.get_footer().empty()) out += ".PP\n" + roff(app.get_footer()) + "\n";
    out += ".SH EXIT STATUS\n";
    for (const Exit &exit : exits) out += fmt::format(".TP\n{}\n{}\n", exit.code, exit.meaning);
    out += ".SH SEE ALSO\n";
    if (verb) out += "\\fBvoxshell\\fR(1). ";
    return out + "The guide and the formats are in /usr/share/doc/voxshell\\-doc.\n";
}

/// A function for bash: the verbs, each one's options, the values that an option takes, else files.
std::string completion(const CLI::App &program)
{
    std::string names, cases;
    for (const Verb &verb : verbs()) {
        names += (names.empty() ? "" : " ") + std::string(verb.name);
        std::string options, words;
        for (const Row &row : rows_of(*program.get_subcommand(verb.name))) {
            const std::string values = fmt::format("{}", fmt::join(row.choices, " "));
            if (row.is_argument) {
                if (!values.empty() && words.empty()) words = values;
                continue;
            }
            for (const std::string &name : row.names) {
                options += " " + name;
                if (!row.value.empty())
                    cases += fmt::format("    '{} {}') values='{}' ;;\n", verb.name, name,
                                         values.empty() ? "FILES" : values);
            }
        }
        cases += fmt::format("    '{} ') options='{}' words='{}' ;;\n", verb.name, options.substr(1), words);
    }
    // A case may be met twice: first what the word before asks for, then what the verb has.
    return fmt::format(R"(# bash completion of voxshell {}; made by voxshell --write-manual
_voxshell_about() {{
    case $1 in
{}    esac
}}
_voxshell() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} verb=${{COMP_WORDS[1]}} before=${{COMP_WORDS[COMP_CWORD-1]}}
    local options= words= values=
    if [ "$COMP_CWORD" = 1 ]; then
        COMPREPLY=($(compgen -W '{} --help --version' -- "$word"))
        return
    fi
    case $before in -*) _voxshell_about "$verb $before" ;; esac
    if [ "$values" = FILES ]; then
        return
    elif [ -n "$values" ]; then
        COMPREPLY=($(compgen -W "$values" -- "$word"))
        return
    fi
    _voxshell_about "$verb "
    case $word in
    -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
    *) [ "$COMP_CWORD" != 2 ] || COMPREPLY=($(compgen -W "$words" -- "$word")) ;;
    esac
}}
complete -o default -o bashdefault -F _voxshell voxshell
)",
                       VOXSHELL_VERSION, cases, names);
}

} // namespace

std::string help_page(const CLI::App &app)
{
    constexpr std::size_t column = 24, width = 100;
    const auto line = [](std::string left, const std::string &text) {
        left = "  " + left;
        if (left.size() + 2 > column)
            left += "\n" + std::string(column, ' ');
        else
            left.resize(column, ' ');
        return left + wrapped(text, width - column, column) + "\n";
    };
    const Verb *verb = find_verb(app.get_name());
    std::string out =
        verb ? fmt::format("{}\n\nvoxshell {}: {}\n", verb->example, verb->name, verb->summary)
             : fmt::format("{}\n\nvoxshell VERB ...: {}\n", verbs()[0].example, app.get_description());
    std::string arguments, options;
    for (const Row &row : rows_of(app)) {
        if (!row.is_listed) continue;
        const std::string name = fmt::format("{}", fmt::join(row.names, ", "));
        (row.is_argument ? arguments : options) +=
            line(row.value.empty() ? name : name + " " + row.value, row.text);
    }
    if (!verb) {
        out += "\nverbs\n";
        for (const Verb &each : verbs()) out += line(each.name, each.summary);
    }
    if (!arguments.empty()) out += "\narguments\n" + arguments;
    out += "\noptions\n" + options;
    if (!app.get_footer().empty()) out += "\n" + wrapped(app.get_footer(), width, 2) + "\n";
    if (verb) return out;
    std::vector<std::string> codes;
    for (const Exit &exit : exits) codes.push_back(fmt::format("{} {}", exit.code, exit.meaning));
    return out + "\nvoxshell VERB --help tells more.\n" +
           wrapped(fmt::format("exit codes: {}\n", fmt::join(codes, ", ")), width, 12);
}

void write_manual(const CLI::App &program, const std::filesystem::path &folder)
{
    Outputs outputs(true);
    outputs.add(folder / "man1/voxshell.1", man_page(program, nullptr));
    for (const Verb &verb : verbs())
        outputs.add(folder / "man1" / fmt::format("voxshell-{}.1", verb.name),
                    man_page(*program.get_subcommand(verb.name), &verb));
    outputs.add(folder / "completions/voxshell", completion(program));
    outputs.commit();
}

} // namespace voxshell
