// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as an STL, binary or text: refused in one line, or triangles with all corners there.
#include "fuzz_import.hpp"

using namespace voxshell;

namespace {

constexpr std::size_t header = 80, record = 50;
constexpr char text[] =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    "facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1e0 +1.0 0\nvertex 0 1 "
    "-0.0\nendloop\nendfacet\nendsolid a\n"
    "solid b\nfacet normal nan 0 1\nouter loop\nvertex 0 0 9\nvertex 1 0 9\nvertex 0 1 "
    "9\nendloop\nendfacet\nendsolid b\n";

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t size)
{
    Sha256Stream hash;
    std::vector<std::filesystem::path> files;
    Bytes own(bytes, bytes + size);
    const Source source{"fuzz.stl", "fuzz.stl", own, hash, files};
    try {
        const Scene scene = import_stl(source, {.unit = 0.001, .z_up = size % 2 == 0});
        FUZZ_CHECK(scene.meshes.size() == 1 && !scene.meshes[0].triangles.empty());
        FUZZ_CHECK(scene.meshes[0].triangles.size() <= size);
        fuzz::check(scene);
    } catch (const Failure &failure) {
        fuzz::check(failure);
    }
    return 0;
}

/// As many triangles as the size says, mostly.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t *bytes, std::size_t size, std::size_t most, unsigned seed)
{
    fuzz::Dice dice(seed);
    const bool is_text = size > 5 && std::memcmp(bytes, "solid", 5) == 0 && !std::memchr(bytes, 0, size);
    if (is_text && dice.below(2)) return fuzz::change_json(reinterpret_cast<char *>(bytes), size, most, dice);
    size = LLVMFuzzerMutate(bytes, size, most);
    if (!is_text && size >= header + 4 && dice.below(4)) {
        const auto count = static_cast<std::uint32_t>((size - header - 4) / record + (dice.below(8) == 0));
        std::memcpy(bytes + header, &count, sizeof count);
    }
    return size;
}

std::size_t fuzz_seed(std::uint32_t number, std::uint8_t *bytes, std::size_t most)
{
    if (number % 2) {
        std::memcpy(bytes, text, std::min(most, sizeof text - 1));
        return std::min(most, sizeof text - 1);
    }
    const std::uint32_t count = number % 7;
    const std::size_t size = header + 4 + record * count;
    if (size > most) return 0;
    std::memset(bytes, 0, size);
    std::memcpy(bytes + header, &count, sizeof count);
    for (std::uint32_t t = 0; t < count; ++t) {
        for (int n = 0; n < 9; ++n) {
            const float x = static_cast<float>((t + 1) * (n % 4 == 0)) * 0.5f;
            std::memcpy(bytes + header + 4 + record * t + 12 + 4 * n, &x, sizeof x);
        }
    }
    return size;
}
