// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/output.hpp"

#include "cli/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <mutex>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path &path, int error)
{
    throw Failure(ExitCode::system, path.string(), std::strerror(error));
}

class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() { close(); }
    Descriptor(const Descriptor &) = delete;
    Descriptor &operator=(Descriptor &&other)
    {
        close();
        std::swap(fd_, other.fd_);
        return *this;
    }
    int get() const { return fd_; }
    int close()
    {
        const int fd = fd_;
        fd_ = -1;
        return fd < 0 ? 0 : ::close(fd);
    }

  private:
    int fd_;
};

bool same_content(const fs::path &path, std::span<const std::uint8_t> bytes, Progress &progress)
{
    const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
    struct stat status = {};
    if (file.get() < 0 || fstat(file.get(), &status) != 0 ||
        static_cast<std::uint64_t>(status.st_size) != bytes.size())
        return false;
    std::vector<std::uint8_t> block(std::min<std::size_t>(bytes.size(), 1 << 20));
    for (std::size_t at = 0; at < bytes.size();) {
        progress.check();
        const ssize_t got = read(file.get(), block.data(), std::min(block.size(), bytes.size() - at));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0 || std::memcmp(block.data(), bytes.data() + at, static_cast<std::size_t>(got)) != 0)
            return false;
        at += static_cast<std::size_t>(got);
    }
    return true;
}

bool same_files(const fs::path &one, const fs::path &other)
{
    const Descriptor a(open(one.c_str(), O_RDONLY | O_CLOEXEC)), b(open(other.c_str(), O_RDONLY | O_CLOEXEC));
    struct stat of_a = {}, of_b = {};
    if (a.get() < 0 || b.get() < 0 || fstat(a.get(), &of_a) != 0 || fstat(b.get(), &of_b) != 0 ||
        of_a.st_size != of_b.st_size)
        return false;
    std::vector<std::uint8_t> block(2 << 20);
    const std::size_t half = block.size() / 2;
    for (off_t at = 0; at < of_a.st_size;) {
        const ssize_t got = pread(a.get(), block.data(), half, at);
        if (got <= 0 || pread(b.get(), block.data() + half, static_cast<std::size_t>(got), at) != got ||
            std::memcmp(block.data(), block.data() + half, static_cast<std::size_t>(got)) != 0)
            return false;
        at += got;
    }
    return true;
}

void write_all(const fs::path &path, int fd, std::span<const std::uint8_t> bytes, Progress &progress)
{
    for (std::size_t at = 0; at < bytes.size();) {
        progress.check();
        const ssize_t put = write(fd, bytes.data() + at, std::min<std::size_t>(bytes.size() - at, 1 << 24));
        if (put < 0 && errno != EINTR) fail(path, errno);
        if (put > 0) at += static_cast<std::size_t>(put);
    }
}

void sync_folder(const fs::path &folder)
{
    const Descriptor fd(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd.get() >= 0) fsync(fd.get()); // some file systems cannot; the rename is in order all the same
}

fs::path folder_of(const fs::path &path)
{
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

std::mutex living_mutex; ///< of `living`, and of what each of them has made and not committed
std::vector<Outputs *> living;

} // namespace

Outputs::Outputs(bool force) : force_(force)
{
    const std::lock_guard lock(living_mutex);
    living.push_back(this);
}

/// Makes the folders above `path`; whether a regular file is there already.
bool Outputs::make_way(const fs::path &path)
{
    const std::lock_guard lock(living_mutex);
    const fs::path folder = folder_of(path);
    std::vector<fs::path> missing;
    for (fs::path at = folder; !at.empty() && !fs::exists(at); at = at.parent_path()) missing.push_back(at);
    for (auto at = missing.rbegin(); at != missing.rend(); ++at) {
        if (mkdir(at->c_str(), 0777) == 0)
            made_folders_.push_back(*at);
        else if (errno != EEXIST)
            fail(*at, errno);
    }
    if (!fs::is_directory(folder)) throw Failure(ExitCode::system, folder.string(), "is not a folder");

    std::error_code ignored;
    const fs::file_status there = fs::status(path, ignored);
    if (!fs::exists(there)) return false;
    if (!fs::is_regular_file(there))
        throw Failure(ExitCode::system, path.string(), "exists and is not a file");
    return true;
}

/// A temporary file beside `path`, pending; its descriptor.
int Outputs::create(const fs::path &path)
{
    static unsigned serial = 0;
    const std::lock_guard lock(living_mutex);
    const fs::path temporary =
        folder_of(path) / fmt::format(".{}.{}-{}.tmp", path.filename().string(), getpid(), serial++);
    const int file = open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) fail(path, errno);
    pending_.push_back({temporary, path});
    return file;
}

void Outputs::add(const fs::path &path, std::span<const std::uint8_t> bytes, Progress *watched,
                  const std::function<bool()> &may_replace)
{
    Progress silent, &progress = watched ? *watched : silent;
    if (make_way(path)) {
        if (same_content(path, bytes, progress)) {
            const std::lock_guard lock(living_mutex);
            pending_.push_back({{}, path});
            return;
        }
        if (!force_ && !(may_replace && may_replace()))
            throw Failure(ExitCode::system, path.string(), "exists with other content; --force overwrites");
    }
    Descriptor file(create(path));
    write_all(path, file.get(), bytes, progress);
    if (fsync(file.get()) != 0) fail(path, errno);
    if (file.close() != 0) fail(path, errno);
}

void Outputs::add_stream(const fs::path &path, const std::function<void(const Sink &)> &write)
{
    const bool exists = make_way(path);
    Descriptor file(create(path));
    std::uint64_t size = 0;
    Progress silent;    // what gives the pieces looks itself
    bool same = exists; // with what is there, so far
    const Descriptor old(exists ? open(path.c_str(), O_RDONLY | O_CLOEXEC) : -1);
    std::string block;
    write([&](std::string_view piece) {
        write_all(path, file.get(), {reinterpret_cast<const std::uint8_t *>(piece.data()), piece.size()},
                  silent);
        if (same) {
            block.resize(piece.size());
            same = pread(old.get(), block.data(), block.size(), static_cast<off_t>(size)) ==
                       static_cast<ssize_t>(block.size()) &&
                   block == piece;
        }
        size += piece.size();
        if (exists && !same && !force_)
            throw Failure(ExitCode::system, path.string(), "exists with other content; --force overwrites");
    });
    std::error_code ignored;
    if (exists && !(same && fs::file_size(path, ignored) == size) && !force_)
        throw Failure(ExitCode::system, path.string(), "exists with other content; --force overwrites");
    if (fsync(file.get()) != 0) fail(path, errno);
    if (file.close() != 0) fail(path, errno);
}

bool Outputs::link(const fs::path &from, const fs::path &path, const std::function<bool()> &may_replace)
{
    if (make_way(path)) {
        std::error_code ignored;
        if (fs::equivalent(from, path, ignored) || same_files(from, path)) return false;
        if (!force_ && !may_replace())
            throw Failure(ExitCode::system, path.string(), "exists with other content; --force overwrites");
    }
    Descriptor file(create(path));
    const fs::path temporary = pending_.back().temporary;
    const Descriptor source(open(from.c_str(), O_RDONLY | O_CLOEXEC));
    if (source.get() < 0) fail(from, errno);
    if (unlink(temporary.c_str()) == 0 && ::link(from.c_str(), temporary.c_str()) == 0) return true;
    file = Descriptor(open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.get() < 0) fail(path, errno);
    std::vector<std::uint8_t> block(1 << 20);
    Progress silent;
    for (;;) {
        const ssize_t got = read(source.get(), block.data(), block.size());
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(from, errno);
        if (got == 0) break;
        write_all(path, file.get(), {block.data(), static_cast<std::size_t>(got)}, silent);
    }
    if (fsync(file.get()) != 0) fail(path, errno);
    if (file.close() != 0) fail(path, errno);
    return true;
}

void Outputs::add(const fs::path &path, const std::string &text)
{
    add(path, {reinterpret_cast<const std::uint8_t *>(text.data()), text.size()});
}

void Outputs::commit()
{
    const std::lock_guard lock(living_mutex);
    for (Pending &each : pending_) {
        if (each.temporary.empty()) continue;
        if (std::rename(each.temporary.c_str(), each.target.c_str()) != 0) fail(each.target, errno);
        each.temporary.clear();
    }
    std::vector<fs::path> folders;
    for (const Pending &each : pending_) folders.push_back(folder_of(each.target));
    std::sort(folders.begin(), folders.end());
    folders.erase(std::unique(folders.begin(), folders.end()), folders.end());
    for (const fs::path &folder : folders) sync_folder(folder);
    pending_.clear();
    made_folders_.clear();
}

void Outputs::abandon()
{
    for (const Pending &each : pending_)
        if (!each.temporary.empty()) unlink(each.temporary.c_str());
    for (auto at = made_folders_.rbegin(); at != made_folders_.rend(); ++at)
        rmdir(at->c_str()); // only if empty
}

Outputs::~Outputs()
{
    const std::lock_guard lock(living_mutex);
    abandon();
    std::erase(living, this);
}

void Outputs::abandon_all()
{
    living_mutex.lock(); // for good: who else comes waits for the end
    for (Outputs *each : living) each->abandon();
}

} // namespace voxshell
