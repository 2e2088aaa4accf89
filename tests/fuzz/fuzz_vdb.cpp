// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as what the process of the .vdb reader answers: refused in one line, or cells that hold together. Bytes that begin as
// a .vdb are read as one: by that process, or, most of them, by one that reads many and is started again when one ends it. With
// VXS_FUZZ_ANSWERS set they are answers, too.
#include "fuzz_import.hpp"
#include "voxmap/vdb_parse.hpp"

#include <cstdlib>
#include <fstream>
#include <optional>
#include <sys/mman.h>
#include <unistd.h>

using namespace voxshell;

namespace {

constexpr char magic[] = {' ', 'B', 'D', 'V', 0, 0, 0, 0};
constexpr std::uint64_t memory = 1 << 14; // an answer that claims more costs time, and finds nothing

/// A file that is there while the program runs.
struct Place {
    std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("fuzz_" + std::to_string(getpid()) + ".vdb");
    ~Place()
    {
        std::error_code ignored;
        std::filesystem::remove(file, ignored);
    }
    void put(const std::uint8_t *bytes, std::size_t size) const
    {
        std::ofstream(file, std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes), static_cast<std::streamsize>(size));
    }
};

const Place &place()
{
    static const Place there;
    return there;
}

/// The reader's process, asked again and again: to start one takes many times as long as to read a small file.
class Reader {
  public:
    Reader() { place(); } // one for both processes, which this one takes away
    VdbFile read(std::span<const std::uint8_t> bytes)
    {
        if (!fence_ || ++asked_ % 4096 == 0)
            fence_.emplace("OpenVDB's reader", "this file", limits, answer_all);
        fence_->restart(limits.seconds);
        const std::uint64_t size = bytes.size();
        try {
            if (!fence_->write(&size, sizeof size) || !fence_->write(bytes.data(), bytes.size()))
                throw Failure(ExitCode::invalid, "", fence_->obituary());
            VdbFile file = receive_vdb(*fence_, limits.memory);
            FUZZ_CHECK(is_at_end());
            return file;
        } catch (const Failure &) {
            if (!is_at_end()) fence_.reset(); // dead, or in the midst of what was not believed
            throw;
        }
    }

  private:
    static constexpr FenceLimits limits{std::uint64_t{1} << 25, 5}; // more takes time, and finds nothing
    static constexpr std::uint64_t end_of_answer = 0x656e64206f662069;

    static bool answer_all(Fenced &parent)
    {
        std::uint64_t size = 0;
        std::vector<std::uint8_t> bytes;
        while (parent.read(&size, sizeof size)) {
            bytes.resize(size);
            if (!parent.read(bytes.data(), size)) return false;
            place().put(bytes.data(), size);
            parent.limit(limits);
            if (!answer_vdb(parent, place().file, nullptr, limits.memory) ||
                !parent.write(&end_of_answer, sizeof end_of_answer))
                return false;
        }
        return true;
    }
    bool is_at_end()
    {
        std::uint64_t word = 0;
        return fence_->read(&word, sizeof word) && word == end_of_answer;
    }

    std::optional<Fence> fence_;
    unsigned asked_ = 0;
};

/// `writes`: as a .vdb again, too, which takes OpenVDB a thousand times as long as all else.
void use(const VdbFile &file, bool writes)
{
    std::uint64_t surface = 0;
    for (const Brick &brick : file.cells.bricks)
        for (int i = 0; i < 8; ++i) {
            FUZZ_CHECK((brick.surface[i] & brick.interior[i]) == 0);
            surface += static_cast<std::uint64_t>(__builtin_popcountll(brick.surface[i]));
        }
    FUZZ_CHECK(surface > 0 && surface == file.cells.surface_cells);
    FUZZ_CHECK(cell_state(file.cells, file.cells.min) >= 0);
    std::int64_t interior = 0;
    for (const SolidRun &run : file.cells.solid) interior += run.last - run.first + 1;
    if (writes && file.cells.bricks.size() < 64 && file.cells.solid.size() < 64 && interior < 4096)
        (void)vdb_bytes(file.cells, file.source_hash, "{}", file.channels);
}

Cells some_cells(bool with_run)
{
    Cells cells;
    cells.voxel = 0.001;
    cells.closed = with_run;
    Brick brick{{1, 2, 3}, {}, {}};
    brick.surface[2] = 0x00003c3c3c3c0000u;
    brick.interior[3] = 0x0000181818180000u;
    cells.bricks = {brick, Brick{{1, 2, 4}, {1}, {}}};
    if (with_run) cells.solid = {{1, 3, 2, 5}};
    recount(cells);
    return cells;
}

Channels some_channels(const Cells &cells)
{
    Channels channels;
    channels.layer_count = 2;
    channels.distance_step = 0.0001;
    channels.distance_band = 0.002;
    channels.layer.resize(cells.bricks.size());
    channels.distance.resize(cells.bricks.size());
    for (std::size_t b = 0; b < cells.bricks.size(); ++b)
        for (std::size_t c = 0; c < 512; ++c) {
            const bool is_surface = cells.bricks[b].surface[c >> 6] >> (c & 63) & 1;
            const int sign = cells.bricks[b].interior[c >> 6] >> (c & 63) & 1 ? -1 : !is_surface;
            channels.layer[b][c] = static_cast<std::int8_t>(2 * sign);
            channels.distance[b][c] = static_cast<std::int16_t>(7 * sign);
        }
    return channels;
}

/// One of four is a .vdb; the others, what the reader's process says of one. The sixth was found, and is kept: a refusal
/// without a word.
std::vector<std::uint8_t> make_seed(std::uint32_t number)
{
    if (number == 5) {
        std::ifstream file(VXS_TEST_SOURCE_DIR "/tests/fuzz/corpus/refused_without_a_word.vdb_answer",
                           std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    const bool is_vdb = number % 4 == 3, with_run = number & (is_vdb ? 8 : 1),
               with_channels = number & (is_vdb ? 4 : 2);
    const Cells cells = some_cells(with_run);
    const auto vdb =
        vdb_bytes(cells, {}, "{\"tool\":\"fuzz\"}", with_channels ? some_channels(cells) : Channels{});
    std::vector<std::uint8_t> seed(vdb.begin(), vdb.end());
    if (is_vdb) {
        use(Reader().read(seed), false); // it is one, and there is memory enough
        return seed;
    }
    place().put(seed.data(), seed.size());
    const int stream = memfd_create("answer", MFD_CLOEXEC);
    FUZZ_CHECK(stream >= 0);
    Fenced parent(stream, 0);
    FUZZ_CHECK(answer_vdb(parent, place().file, nullptr, memory));
    seed.resize(static_cast<std::size_t>(lseek(stream, 0, SEEK_CUR)));
    FUZZ_CHECK(pread(stream, seed.data(), seed.size(), 0) == static_cast<ssize_t>(seed.size()));
    close(stream);
    return seed;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t size)
{
    const std::string_view all(reinterpret_cast<const char *>(bytes), size);
    static const bool answers_only = std::getenv("VXS_FUZZ_ANSWERS") != nullptr;
    const std::size_t lot = std::hash<std::string_view>()(all);
    const bool writes = lot % 4096 == 0, alone = lot % 256 == 1;
    static Reader reader;
    try {
        if (!answers_only && size >= sizeof magic && std::memcmp(bytes, magic, sizeof magic) == 0) {
            if (alone) place().put(bytes, size);
            use(alone ? read_vdb(place().file) : reader.read({bytes, size}), writes);
        } else {
            fuzz::Said said({bytes, size});
            use(receive_vdb(said, memory), writes);
        }
    } catch (const Failure &failure) {
        FUZZ_CHECK(failure.what()[0] != 0);
        FUZZ_CHECK(failure.code >= ExitCode::usage && failure.code <= ExitCode::unsupported);
    }
    return 0;
}

std::size_t fuzz_seed(std::uint32_t number, std::uint8_t *bytes, std::size_t most)
{
    static const std::vector<std::vector<std::uint8_t>> seeds = [] { // OpenVDB takes its time to write
        std::vector<std::vector<std::uint8_t>> made;
        for (std::uint32_t n = 0; n < 16; ++n) made.push_back(make_seed(n));
        return made;
    }();
    const std::vector<std::uint8_t> &seed = seeds[number % seeds.size()];
    if (seed.size() > most) return 0;
    std::memcpy(bytes, seed.data(), seed.size());
    return seed.size();
}
