// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/cache.hpp"

#include "cli/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

constexpr const char *entry_name = "entry.json";
constexpr std::string_view temporary_prefix = "tmp-";

[[noreturn]] void fail(const fs::path &path, int error)
{
    throw Failure(ExitCode::system, path.string(), std::strerror(error));
}

std::string text_of(const json &entry)
{
    return entry.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string hash_of_text(const std::string &text)
{
    return hex(sha256({reinterpret_cast<const std::uint8_t *>(text.data()), text.size()}));
}

std::string machine()
{
    char name[256] = "localhost";
    gethostname(name, sizeof name - 1);
    return name;
}

void write_file(const fs::path &path, std::span<const std::uint8_t> bytes)
{
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) fail(path, errno);
    std::size_t at = 0;
    while (at < bytes.size()) {
        const ssize_t put = write(file, bytes.data() + at, std::min<std::size_t>(bytes.size() - at, 1 << 24));
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) break;
        at += static_cast<std::size_t>(put);
    }
    const int error = at < bytes.size() || fsync(file) != 0 ? errno : 0;
    if ((close(file) != 0 && !error) || error) fail(path, error ? error : errno);
}

} // namespace

Cache::Cache(fs::path folder, bool only_read) : folder_(std::move(folder)), only_read_(only_read)
{
    if (only_read_) return;
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw Failure(ExitCode::system, folder_.string(), error.message());
    only_read_ = access(folder_.c_str(), W_OK | X_OK) != 0;
    if (only_read_) return;
    // tmp-MACHINE-PID-SERIAL of a process that is no more.
    const std::string mine = std::string(temporary_prefix) + machine() + "-";
    for (const fs::directory_entry &each : fs::directory_iterator(folder_, error)) {
        const std::string name = each.path().filename().string();
        if (!name.starts_with(mine)) continue;
        pid_t pid = 0;
        std::from_chars(name.data() + mine.size(), name.data() + name.size(), pid);
        if (pid > 0 && kill(pid, 0) != 0 && errno == ESRCH) drop(each.path());
    }
}

fs::path Cache::folder_of(const Sha256 &key) const
{
    const std::string digits = hex(key);
    return folder_ / digits.substr(0, 2) / digits.substr(2);
}

fs::path Cache::unused() const
{
    static std::atomic<unsigned> serial{0};
    return folder_ / fmt::format("{}{}-{}-{}", temporary_prefix, machine(), getpid(), serial++);
}

fs::path Cache::temporary()
{
    const fs::path path = unused();
    if (mkdir(path.c_str(), 0777) != 0) fail(path, errno);
    return path;
}

void Cache::drop(const fs::path &folder)
{
    if (only_read_) return;
    std::error_code ignored;
    const fs::path aside = unused(); // at once, so that nobody meets half of it
    fs::rename(folder, aside, ignored);
    fs::remove_all(ignored ? folder : aside, ignored);
}

std::optional<Cache::Entry> Cache::read(const Sha256 &key, const fs::path &folder) const
{
    std::ifstream file(folder / entry_name, std::ios::binary);
    if (!file) return {};
    const json all = json::parse(file, nullptr, false);
    if (!all.is_object() || !all.contains("entry") || !all.contains("sha256")) return {};
    const json &stored = all["entry"];
    if (all["sha256"] != hash_of_text(text_of(stored)) || stored["key"] != hex(key)) return {};
    Entry entry{stored["about"], {}};
    for (const json &each : stored["files"]) { // as put() wrote it: the hash says so
        File one{each["name"], each["bytes"], *sha256_of_hex(each["sha256"].get<std::string>()), {}};
        one.path = folder / one.name;
        std::error_code error;
        if (fs::file_size(one.path, error) != one.bytes || error) return {};
        if (hash_of_file(one.path) != one.sha256) return {};
        entry.files.push_back(std::move(one));
    }
    return entry;
}

std::optional<Cache::Entry> Cache::find(const Sha256 &key)
{
    const fs::path folder = folder_of(key);
    std::error_code error;
    if (!fs::exists(folder, error)) return {};
    std::optional<Entry> entry = read(key, folder);
    if (!entry)
        drop(folder);
    else if (!only_read_)
        utimensat(AT_FDCWD, (folder / entry_name).c_str(), nullptr, 0); // used now; a reader's may be denied
    return entry;
}

void Cache::forget(const Sha256 &key)
{
    drop(folder_of(key));
}

Cache::Entry Cache::put(const Sha256 &key, const json &about, const std::vector<Content> &files)
{
    const fs::path made = temporary(), folder = folder_of(key);
    try {
        json stored = {{"key", hex(key)}, {"about", about}, {"files", json::array()}};
        Entry entry{about, {}};
        for (const Content &each : files) {
            write_file(made / each.name, each.bytes);
            entry.files.push_back({each.name, each.bytes.size(), sha256(each.bytes), folder / each.name});
            const File &file = entry.files.back();
            stored["files"].push_back(
                {{"name", file.name}, {"bytes", file.bytes}, {"sha256", hex(file.sha256)}});
        }
        const std::string plain = text_of(stored);
        const std::string text =
            fmt::format("{{\"entry\": {},\n \"sha256\": \"{}\"}}\n", plain, hash_of_text(plain));
        write_file(made / entry_name, {reinterpret_cast<const std::uint8_t *>(text.data()), text.size()});
        std::error_code error;
        fs::create_directories(folder.parent_path(), error);
        if (error) throw Failure(ExitCode::system, folder.string(), error.message());
        if (rename(made.c_str(), folder.c_str()) != 0) {
            const int reason = errno;
            if (reason != EEXIST && reason != ENOTEMPTY) fail(folder, reason);
            drop(made); // another program was first; the same key is the same result
        }
        return entry;
    } catch (...) {
        drop(made);
        throw;
    }
}

std::uint64_t Cache::shrink(std::uint64_t limit)
{
    struct Old {
        fs::file_time_type used;
        std::uint64_t bytes;
        fs::path folder;
    };
    std::vector<Old> all;
    std::uint64_t total = 0, gone = 0;
    std::error_code error;
    for (const fs::directory_entry &shelf : fs::directory_iterator(folder_, error)) {
        if (shelf.path().filename().string().size() != 2) continue;
        for (const fs::directory_entry &each : fs::directory_iterator(shelf.path(), error)) {
            Old old{fs::last_write_time(each.path() / entry_name, error), 0, each.path()};
            for (const fs::directory_entry &file : fs::directory_iterator(each.path(), error))
                old.bytes += file.file_size(error);
            total += old.bytes;
            all.push_back(std::move(old));
        }
    }
    std::sort(all.begin(), all.end(), [](const Old &a, const Old &b) { return a.used < b.used; });
    for (const Old &old : all) {
        if (total - gone <= limit) break;
        drop(old.folder);
        gone += old.bytes;
    }
    return gone;
}

} // namespace voxshell
