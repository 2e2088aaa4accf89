// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/archive.hpp"

#include "batch/manifest.hpp"
#include "cli/failure.hpp"
#include "pipeline/output.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <array>
#include <cstring>
#include <fstream>
#include <memory>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view zstd_ending = ".tar.zst", tar_ending = ".tar";
constexpr std::size_t record = 512, chunk = 1 << 20;

/// Bytes on their way to the file, compressed or not.
class Stream {
  public:
    Stream(const Outputs::Sink &sink, bool compress) : sink_(sink)
    {
        if (!compress) return;
        context_.reset(ZSTD_createCCtx());
        if (!context_) throw std::bad_alloc();
        ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, 3);
        ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1);
        out_.resize(ZSTD_CStreamOutSize());
    }

    void write(std::string_view bytes)
    {
        written_ += bytes.size();
        if (context_)
            pass(bytes, ZSTD_e_continue);
        else
            sink_(bytes);
    }

    /// Zeros up to a whole number of `unit` bytes.
    void fill(std::size_t unit)
    {
        static const std::string zeros(20 * record, '\0');
        if (const std::size_t over = written_ % unit; over != 0)
            write(std::string_view(zeros).substr(0, unit - over));
    }

    void end()
    {
        if (context_) pass({}, ZSTD_e_end);
    }

  private:
    void pass(std::string_view bytes, ZSTD_EndDirective how)
    {
        ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
        for (;;) {
            ZSTD_outBuffer out{out_.data(), out_.size(), 0};
            const std::size_t left = ZSTD_compressStream2(context_.get(), &out, &in, how);
            if (ZSTD_isError(left))
                throw Failure(ExitCode::bug, "", std::string("zstd: ") + ZSTD_getErrorName(left));
            sink_({out_.data(), out.pos});
            if (how == ZSTD_e_end ? left == 0 : in.pos == in.size) return;
        }
    }

    struct Free {
        void operator()(ZSTD_CCtx *context) const { ZSTD_freeCCtx(context); }
    };
    const Outputs::Sink &sink_;
    std::unique_ptr<ZSTD_CCtx, Free> context_;
    std::string out_;
    std::uint64_t written_ = 0;
};

/// A header of POSIX ustar. `size` in octal digits; what does not fit is in a pax header before it.
std::string header(std::string_view name, std::uint64_t size, char type)
{
    std::array<char, record> block{};
    const auto put = [&](std::size_t at, std::string_view text) {
        std::memcpy(block.data() + at, text.data(), text.size());
    };
    put(0, name.substr(0, 100));
    put(100, "0000644");
    put(108, "0000000");
    put(116, "0000000");
    put(124, fmt::format("{:011o}", size & 0777'7777'7777));
    put(136, "00000000000");
    put(148, "        ");
    block[156] = type;
    put(257, std::string_view("ustar\00000", 8));
    unsigned sum = 0;
    for (const char c : block) sum += static_cast<unsigned char>(c);
    put(148, std::string_view(fmt::format("{:06o}", sum)));
    block[154] = '\0';
    return {block.data(), block.size()};
}

/// "LENGTH key=value\n", where LENGTH counts itself.
std::string pax(const char *key, std::string_view value)
{
    const std::string rest = fmt::format(" {}={}\n", key, value);
    std::size_t length = rest.size() + 1;
    while (fmt::formatted_size("{}", length) + rest.size() != length)
        length = fmt::formatted_size("{}", length) + rest.size();
    return fmt::format("{}{}", length, rest);
}

void begin_file(Stream &stream, const std::string &name, std::uint64_t size)
{
    std::string more;
    bool plain = name.size() <= 100;
    for (const char c : name) plain &= static_cast<unsigned char>(c) < 0x80; // pax says that it is UTF-8
    if (!plain) more += pax("path", name);
    if (size > 0777'7777'7777) more += pax("size", std::to_string(size));
    if (!more.empty()) {
        stream.write(header("pax", more.size(), 'x'));
        stream.write(more);
        stream.fill(record);
    }
    stream.write(header(name, size, '0'));
}

/// Of the name: what is before the ending; nothing if there is none.
std::string stem_of(const fs::path &archive)
{
    std::string name = archive.filename().string();
    for (const std::string_view ending : {zstd_ending, tar_ending})
        if (name.size() > ending.size() && name.ends_with(ending)) {
            name.resize(name.size() - ending.size());
            return name;
        }
    return {};
}

} // namespace

void check_archive_name(const fs::path &archive)
{
    if (stem_of(archive).empty())
        throw Failure(ExitCode::usage, archive.string(), "an archive is called NAME.tar.zst or NAME.tar");
}

void write_archive(const fs::path &folder, const fs::path &archive, bool force, Progress &progress)
{
    check_archive_name(archive);
    const fs::path manifest_path = folder / "manifest.json";
    const Manifest manifest = Manifest::read(manifest_path);
    std::uint64_t size = 0;
    manifest.write([&](std::string_view piece) { size += piece.size(); });
    const std::string top = stem_of(archive) + "/";
    Outputs outputs(force);
    outputs.add_stream(archive, [&](const Outputs::Sink &sink) {
        Stream stream(sink, archive.filename().string().ends_with(zstd_ending));
        begin_file(stream, top + "manifest.json", size);
        manifest.write([&](std::string_view piece) { stream.write(piece); });
        stream.fill(record);
        std::vector<char> block(chunk);
        for (std::size_t n = 0; n < manifest.size(); ++n) {
            const Manifest::File file = manifest[n];
            const fs::path path = folder / file.path;
            begin_file(stream, top + std::string(file.path), file.bytes);
            std::ifstream in(path, std::ios::binary);
            if (!in) throw Failure(ExitCode::system, path.string(), "cannot read");
            Sha256Stream hash;
            std::uint64_t left = file.bytes;
            while (left > 0) {
                progress.check();
                in.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(chunk, left)));
                const auto got = static_cast<std::size_t>(in.gcount());
                if (got == 0) break;
                hash.update({reinterpret_cast<const std::uint8_t *>(block.data()), got});
                stream.write({block.data(), got});
                left -= got;
            }
            if (left > 0 || in.peek() != std::ifstream::traits_type::eof() || hash.digest() != file.sha256)
                throw Failure(ExitCode::invalid, path.string(),
                              "is not the file that the manifest means: run the batch again");
            stream.fill(record);
        }
        stream.write(std::string(2 * record, '\0'));
        stream.fill(20 * record);
        stream.end();
    });
    outputs.commit();
}

} // namespace voxshell
