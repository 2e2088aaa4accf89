// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/slurm.hpp"

#include "cli/progress.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

namespace voxshell {
namespace {

namespace fs = std::filesystem;

struct Ended {
    int status; ///< exit code; 127: not found
    std::string out;
};

/// A program's standard output, its standard error with it.
Ended run(std::vector<std::string> command)
{
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw Failure(ExitCode::system, command[0], std::strerror(errno));
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    std::vector<char *> arguments;
    for (std::string &each : command) arguments.push_back(each.data());
    arguments.push_back(nullptr);
    pid_t child = 0;
    const int error = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    Ended ended{127, {}};
    char block[4096];
    for (ssize_t got; error == 0 && (got = read(ends[0], block, sizeof block)) != 0;) {
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) break;
        ended.out.append(block, static_cast<std::size_t>(got));
    }
    close(ends[0]);
    if (error != 0) return ended;
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
    while (!ended.out.empty() && ended.out.back() == '\n') ended.out.pop_back();
    return ended;
}

std::string quoted(const std::string &word)
{
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

/// What each task runs: its shard is its index in the array.
void write_script(const fs::path &path, const WorkPlan &plan, const SlurmOptions &o)
{
    std::ofstream script(path, std::ios::binary | std::ios::trunc);
    script << "#!/bin/sh\nexec";
    for (const std::string &word : o.command) script << ' ' << quoted(word);
    script << " -q --shard \"$SLURM_ARRAY_TASK_ID/" << o.shards << ':' << plan.hash << "\"\n";
    script.close();
    if (!script) throw Failure(ExitCode::system, path.string(), "cannot write");
}

std::string submit(const fs::path &script, const std::vector<unsigned> &shards, const WorkPlan &plan,
                   const SlurmOptions &o)
{
    std::vector<std::string> command{"sbatch",
                                     "--parsable",
                                     "--job-name=voxshell",
                                     fmt::format("--array={}", fmt::join(shards, ",")),
                                     "--output=" + (plan.folder / "%a.log").string(),
                                     "--chdir=" + fs::current_path().string()};
    command.insert(command.end(), o.sbatch.begin(), o.sbatch.end());
    command.push_back(script.string());
    const Ended ended = run(command);
    if (ended.status == 127) throw Failure(ExitCode::system, "sbatch", "is not there: is Slurm installed?");
    if (ended.status != 0) throw Failure(ExitCode::system, "sbatch", "refused the job: " + ended.out);
    return ended.out.substr(ended.out.rfind('\n') + 1); // after what a plug-in may say
}

void await(const std::string &job)
{
    const std::unique_ptr<Progress> progress = make_progress(ProgressMode::never, true);
    for (int failures = 0; failures < 60;) { // a controller may be away for a minute
        if (interruption_requested()) {
            run({"scancel", job.substr(0, job.find(';'))});
            progress->check();
        }
        const Ended ended = run({"squeue", "--noheader", "--jobs=" + job.substr(0, job.find(';'))});
        if (ended.status == 0 && ended.out.empty()) return;
        if (ended.status != 0) {
            if (ended.out.find("Invalid job id") != ended.out.npos) return; // forgotten: it has ended
            ++failures;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    throw Failure(ExitCode::system, "squeue",
                  "does not answer; the job goes on, run again to take its results");
}

} // namespace

void run_on_slurm(const WorkPlan &plan, const SlurmOptions &o)
{
    const fs::path script = plan.folder / "shard.sh";
    write_script(script, plan, o);
    std::vector<unsigned> left;
    for (unsigned shard = 0; shard < o.shards; ++shard) left.push_back(shard);
    for (unsigned attempt = 1; attempt <= o.attempts && !left.empty(); ++attempt) {
        const std::string job = submit(script, left, plan, o);
        o.tell(fmt::format("job {}: {} shards{}", job, left.size(), attempt > 1 ? ", again" : ""));
        await(job);
        std::erase_if(left, [&](unsigned shard) {
            std::error_code ignored;
            return fs::exists(plan.done(shard, o.shards), ignored);
        });
    }
    if (!left.empty())
        o.tell(fmt::format("{} shards did not come to their end in {} attempts ({}): their parts are "
                           "converted here",
                           left.size(), o.attempts, (plan.folder / "*.log").string()));
}

} // namespace voxshell
