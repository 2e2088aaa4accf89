// SPDX-License-Identifier: GPL-3.0-or-later
// What a fuzz target of an importer does: reads, and holds the importer to what scene.hpp and failure.hpp
// promise.
#pragma once

#include "fence/fence.hpp"
#include "fuzz_target.h"
#include "import/importers.hpp"

#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

namespace voxshell::fuzz {

/// Small, repeatable dice for a mutator.
class Dice {
  public:
    explicit Dice(unsigned seed) : state_((seed + 1ull) * 0x9E3779B97F4A7C15u) {}
    std::size_t below(std::size_t end)
    {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 7;
        state_ ^= state_ << 17;
        return end ? (state_ >> 16) % end : 0;
    }

  private:
    std::uint64_t state_;
};

/// A refusal names the file, with an exit code of 2 to 5.
inline void check(const Failure &failure)
{
    FUZZ_CHECK(failure.what()[0] != 0 && !failure.file.empty());
    FUZZ_CHECK(failure.code >= ExitCode::system && failure.code <= ExitCode::unsupported);
}

inline void check(const Scene &scene)
{
    for (const Mesh &mesh : scene.meshes) {
        for (const Triangle &t : mesh.triangles)
            for (const std::uint32_t corner : t) FUZZ_CHECK(corner < mesh.vertices.size());
        for (const Point &p : mesh.vertices)
            for (const double x : p) FUZZ_CHECK(std::isfinite(x));
    }
    for (const Instance &instance : scene.instances) FUZZ_CHECK(instance.mesh < scene.meshes.size());
}

/// A list of bytes in the place of a child process.
class Said : public Answers {
  public:
    explicit Said(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    bool read(void *data, std::size_t size) override
    {
        const bool is_there = size <= bytes_.size();
        if (is_there && size > 0) std::memcpy(data, bytes_.data(), size);
        bytes_ = bytes_.subspan(is_there ? size : bytes_.size());
        return is_there;
    }
    std::string obituary() override { return "it is gone"; }

  private:
    std::span<const std::uint8_t> bytes_;
};

/// Text changed where JSON has something to say: a number for another, a word for another of the same
/// document. `text` has room for `most` bytes; returns its length.
inline std::size_t change_json(char *text, std::size_t size, std::size_t most, Dice &dice)
{
    static constexpr std::string_view numbers[] = {"0",
                                                   "1",
                                                   "-1",
                                                   "2",
                                                   "3",
                                                   "4",
                                                   "5",
                                                   "255",
                                                   "256",
                                                   "5120",
                                                   "5121",
                                                   "5123",
                                                   "5125",
                                                   "5126",
                                                   "65535",
                                                   "65536",
                                                   "2147483647",
                                                   "4294967295",
                                                   "4294967296",
                                                   "1e400",
                                                   "-0.0",
                                                   "1e-400",
                                                   "0.5",
                                                   "18446744073709551615",
                                                   "9007199254740993",
                                                   "null",
                                                   "\"\"",
                                                   "[]",
                                                   "{}",
                                                   "true"};
    if (size == 0 || dice.below(4) == 0)
        return LLVMFuzzerMutate(reinterpret_cast<std::uint8_t *>(text), size, most);
    std::string_view all(text, size);
    const bool is_number = dice.below(3) != 0;
    std::size_t at = dice.below(size), end;
    if (is_number) {
        at = all.find_first_of("-0123456789", at);
        if (at == all.npos) return size;
        end = std::min(all.find_first_not_of("-+.eE0123456789", at), size);
    } else {
        at = all.find('"', at);
        if (at == all.npos) return size;
        end = std::min(all.find('"', at + 1), size - 1) + 1;
    }
    std::string put(numbers[dice.below(std::size(numbers))]);
    if (!is_number) { // another word
        std::size_t from = all.find('"', dice.below(size));
        if (from != all.npos && from + 1 < size)
            put = all.substr(from, std::min(all.find('"', from + 1), size - 1) + 1 - from);
    }
    const std::size_t longer = size - (end - at) + put.size();
    if (longer > most) return size;
    std::memmove(text + at + put.size(), text + end, size - end);
    std::memcpy(text + at, put.data(), put.size());
    return longer;
}

} // namespace voxshell::fuzz
