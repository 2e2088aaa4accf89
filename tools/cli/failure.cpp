// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/failure.hpp"

#include "cli/progress.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <new>

#include <unistd.h>

namespace voxshell {
namespace {

void tell(const std::string &verb, const char *kind, const char *colour, const std::string &file,
          std::string what)
{
    for (char &c : what)
        if (c == '\n' || c == '\r') c = ' ';
    const bool coloured = may_colour(STDERR_FILENO);
    fmt::print(stderr, "voxshell{}{}: {}{}:{} {}{}{}\n", verb.empty() ? "" : " ", verb,
               coloured ? colour : "", kind, coloured ? "\033[0m" : "", file, file.empty() ? "" : ": ", what);
}

} // namespace

void tell_failure(const std::string &verb, const Failure &failure)
{
    tell(verb, "error", "\033[1;31m", failure.file, failure.what());
}

void tell_warning(const std::string &verb, const std::string &file, const Warning &warning)
{
    tell(verb, "warning", "\033[1;33m", file, warning.message);
}

Failure current_failure()
{
    try {
        throw;
    } catch (const Failure &failure) {
        return failure;
    } catch (const std::bad_alloc &) {
        return Failure(ExitCode::system, "", "out of memory; a larger --voxel needs less");
    } catch (const std::filesystem::filesystem_error &error) {
        return Failure(ExitCode::system, error.path1().string(), error.code().message());
    } catch (const std::exception &error) {
        return Failure(ExitCode::bug, "", std::string("bug: ") + error.what());
    } catch (...) {
        return Failure(ExitCode::bug, "", "bug: an exception of unknown kind");
    }
}

} // namespace voxshell
