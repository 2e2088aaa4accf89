// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/text_store.hpp"

#include "cli/failure.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <unistd.h>

namespace voxshell {
namespace {

[[noreturn]] void fail(int error)
{
    throw Failure(ExitCode::system, std::filesystem::temp_directory_path().string(),
                  std::string("no temporary file for the report: ") + std::strerror(error));
}

} // namespace

TextStore::~TextStore()
{
    if (file_ >= 0) close(file_);
}

std::uint64_t TextStore::put(std::string_view text)
{
    if (file_ < 0) {
        std::string name = (std::filesystem::temp_directory_path() / "voxshell-XXXXXX").string();
        file_ = mkostemp(name.data(), O_CLOEXEC);
        if (file_ < 0) fail(errno);
        unlink(name.c_str());
    }
    const std::uint64_t at = size_, length = text.size();
    std::string bytes(reinterpret_cast<const char *>(&length), sizeof length);
    bytes += text;
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t put =
            pwrite(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(size_));
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) fail(errno);
        done += static_cast<std::size_t>(put);
        size_ += static_cast<std::uint64_t>(put);
    }
    return at;
}

std::string TextStore::get(std::uint64_t at) const
{
    const auto read = [&](void *to, std::size_t bytes, std::uint64_t from) {
        for (std::size_t done = 0; done < bytes;) {
            const ssize_t got =
                pread(file_, static_cast<char *>(to) + done, bytes - done, static_cast<off_t>(from + done));
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) fail(got < 0 ? errno : EIO);
            done += static_cast<std::size_t>(got);
        }
    };
    std::uint64_t length = 0;
    read(&length, sizeof length, at);
    std::string text(length, '\0');
    read(text.data(), text.size(), at + sizeof length);
    return text;
}

} // namespace voxshell
