// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/gnuplot.hpp"

#include "cli/failure.hpp"
#include "cli/progress.hpp"
#include "study/temporary_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

namespace voxshell {
namespace {

namespace fs = std::filesystem;

/// A signal to the whole group, as ^C is, may end the child before this process knows of it.
bool is_interrupted(int status)
{
    return interruption_requested() ||
           (WIFSIGNALED(status) && (WTERMSIG(status) == SIGINT || WTERMSIG(status) == SIGTERM));
}

/// Runs gnuplot on the script; what it draws goes to `out`. Its exit code.
int run_gnuplot(const fs::path &script, const fs::path &out, const fs::path &err)
{
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    std::string name = "gnuplot", argument = script.string();
    char *arguments[] = {name.data(), argument.data(), nullptr};
    pid_t child = 0;
    const int error = posix_spawnp(&child, "gnuplot", &files, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    if (error == ENOENT) {
        throw Failure(ExitCode::system, "",
                      "gnuplot is not installed; apt-get install gnuplot-nox, or do without pictures");
    }
    if (error) {
        throw Failure(ExitCode::system, "gnuplot", std::strerror(error));
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
    if (code != 0 && is_interrupted(status)) throw Failure(ExitCode::interrupted, "", "interrupted");
    return code;
}

std::string read_all(const fs::path &path)
{
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace

Picture picture_of(const fs::path &file)
{
    if (file.extension() == ".svg") {
        return Picture::svg;
    }
    if (file.extension() == ".png") {
        return Picture::png;
    }
    throw Failure(ExitCode::usage, file.string(), "a picture ends in .svg or .png");
}

std::string gnuplot_sheet(Picture picture, int width, int height)
{
    const std::string terminal =
        picture == Picture::svg
            ? fmt::format("set terminal svg size {},{} dynamic background rgb 'white' font 'sans-serif,15' "
                          "enhanced\n",
                          width, height)
            : fmt::format(
                  "set terminal pngcairo size {},{} background rgb 'white' font 'sans,18' linewidth 1.5\n",
                  3 * width / 2, 3 * height / 2);
    return terminal + "set grid lc rgb '#d8d8d8' lw 0.7\n"
                      "set border 3 lc rgb '#606060'\n"
                      "set tics nomirror\n";
}

std::string gnuplot_panels(int height, int rows, int columns, double across, double title_lines, double left)
{
    const double line = 19.0 / height, tics = 2, foot = 4.8;
    return fmt::format("set multiplot layout {},{} margins {},0.975,{:.4f},{:.4f} spacing {},{:.4f}\n", rows,
                       columns, left, foot * line, 1 - (1.15 + title_lines) * line, across,
                       (tics + 1 + title_lines) * line);
}

std::string gnuplot_command(const std::string &command, int height)
{
    return fmt::format("set label 100 {} at screen 0.012, screen {:.4f} left font ',13' textcolor rgb "
                       "'#505050' noenhanced\n",
                       gnuplot_text(command), 9.0 / height);
}

std::string gnuplot_text(const std::string &text)
{
    std::string out;
    for (const char c : text) {
        out += c == '\'' ? "''" : std::string(1, static_cast<unsigned char>(c) < ' ' ? ' ' : c);
    }
    return "'" + out + "'";
}

std::vector<std::uint8_t> gnuplot(const std::string &script)
{
    const TemporaryFolder folder;
    const fs::path in = folder.path / "plot.gp", out = folder.path / "out", err = folder.path / "err";
    std::ofstream(in, std::ios::binary) << script;
    if (run_gnuplot(in, out, err) != 0) {
        std::string why = read_all(err);
        std::replace(why.begin(), why.end(), '\n', ' ');
        throw Failure(ExitCode::system, "", "gnuplot failed: " + why);
    }
    const std::string bytes = read_all(out);
    if (bytes.empty()) {
        throw Failure(ExitCode::system, "", "gnuplot drew nothing: " + read_all(err));
    }
    return {bytes.begin(), bytes.end()};
}

} // namespace voxshell
