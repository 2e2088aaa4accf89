// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/depfile.hpp"

#include "cli/failure.hpp"
#include "pipeline/output.hpp"

#include <cerrno>
#include <cstring>
#include <set>

#include <fcntl.h>
#include <sys/stat.h>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

/// As compilers write it: what make, ninja and CMake all read as one path.
std::string escaped(const fs::path &path)
{
    std::string out;
    std::size_t backslashes = 0; // before this character: they are doubled where it is escaped by one
    for (const char c : path.string()) {
        if (c == '\n' || c == '\r')
            throw Failure(ExitCode::unsupported, path.string(),
                          "a depfile cannot name a path with a line break");
        if (c == ' ' || c == '\t') out.append(backslashes + 1, '\\');
        if (c == '#') out += '\\';
        if (c == '$') out += '$';
        out += c;
        backslashes = c == '\\' ? backslashes + 1 : 0;
    }
    return out;
}

} // namespace

void Depfile::add(const std::vector<fs::path> &targets, const std::vector<fs::path> &sources)
{
    for (const fs::path &target : targets)
        rules_ += escaped(target) + (&target == &targets.back() ? ":" : " ");
    std::set<fs::path> named;
    for (const fs::path &source : sources) {
        if (!named.insert(source).second) continue;
        const std::string name = escaped(source);
        rules_ += " \\\n " + name;
        sources_ += name + ":\n";
    }
    rules_ += "\n";
    targets_.insert(targets_.end(), targets.begin(), targets.end());
}

void Depfile::write(const fs::path &path, bool is_made) const
{
    Outputs outputs(true); // it says what is so now, whatever it said
    outputs.add(path, rules_ + sources_);
    outputs.commit();
    constexpr timespec long_ago[2] = {{1, 0}, {1, 0}}; // 0 means to ninja that it is not there
    for (const fs::path &target : targets_)
        if (utimensat(AT_FDCWD, target.c_str(), is_made ? nullptr : long_ago, 0) != 0)
            throw Failure(ExitCode::system, target.string(), std::strerror(errno));
}

} // namespace voxshell
