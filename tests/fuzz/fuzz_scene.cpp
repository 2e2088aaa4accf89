// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a scene file: refused in one line, or a scene whose files are all inside its folder.
#include "fuzz_import.hpp"
#include "scene/example_scene.hpp"
#include "scene/scene_file.hpp"

#include <algorithm>
#include <fstream>
#include <unistd.h>

using namespace voxshell;

namespace {

/// A file that is there while the program runs.
struct Place {
    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("fuzz_scene_" + std::to_string(getpid()));
    std::filesystem::path file = folder / "fuzz.scene.json";
    Place() { std::filesystem::create_directories(folder); }
    ~Place()
    {
        std::error_code ignored;
        std::filesystem::remove_all(folder, ignored);
    }
};

void check_part(const ScenePart &part, const std::filesystem::path &folder)
{
    const std::filesystem::path inside = part.file.lexically_normal().lexically_relative(folder);
    FUZZ_CHECK(!inside.empty() && inside.is_relative() && *inside.begin() != ".."); // "..p.glb" is a name
    for (const double x : part.pose.position) FUZZ_CHECK(std::isfinite(x));
    FUZZ_CHECK(part.density >= 0);
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t size)
{
    static const Place place;
    std::ofstream(place.file, std::ios::binary)
        .write(reinterpret_cast<const char *>(bytes), static_cast<std::streamsize>(size));
    try {
        const SceneFile scene = read_scene(place.file);
        for (const ScenePart &part : scene.statics) check_part(part, place.folder);
        check_part(scene.dynamic, place.folder);
        FUZZ_CHECK(scene.voxel > 0 && scene.rate > 0 && scene.stiffness > 0 && !scene.hand.keyframes.empty());
        for (const double x : scene.hand.at(0.5).position) FUZZ_CHECK(!std::isnan(x));
    } catch (const Failure &failure) {
        fuzz::check(failure);
    }
    return 0;
}

std::size_t LLVMFuzzerCustomMutator(std::uint8_t *bytes, std::size_t size, std::size_t most, unsigned seed)
{
    fuzz::Dice dice(seed);
    return fuzz::change_json(reinterpret_cast<char *>(bytes), size, most, dice);
}

std::size_t fuzz_seed(std::uint32_t, std::uint8_t *bytes, std::size_t most)
{
    static const std::string example = example_scene();
    if (example.size() > most) return 0;
    std::memcpy(bytes, example.data(), example.size());
    return example.size();
}
