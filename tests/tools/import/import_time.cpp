// SPDX-License-Identifier: GPL-3.0-or-later
// import_time FILE...: what each import gives and how long it takes. STL is read in millimetres.
#include "import/scene.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

int main(int argc, char **argv)
{
    int worst = 0;
    for (int i = 1; i < argc; ++i) {
        const std::filesystem::path path = argv[i];
        voxshell::ImportOptions options;
        std::string ending = path.extension().string();
        std::transform(ending.begin(), ending.end(), ending.begin(),
                       [](char c) { return static_cast<char>(c | 0x20); });
        if (ending == ".stl") options.unit = 1e-3;
        const auto start = std::chrono::steady_clock::now();
        try {
            const voxshell::Scene scene = voxshell::import_scene(path, options);
            const voxshell::Mesh flat = voxshell::flatten(scene);
            const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
            fmt::print("{}: {} meshes, {} instances, {} triangles, {:.3f} s\n", path.string(),
                       scene.meshes.size(), scene.instances.size(), flat.triangles.size(), seconds.count());
            for (const voxshell::Warning &w : scene.warnings)
                fmt::print("  warning {}: {}\n", w.code, w.message);
        } catch (const voxshell::Failure &failure) {
            fmt::print("{}: error {}: {}\n", failure.file, static_cast<int>(failure.code), failure.what());
            worst = std::max(worst, static_cast<int>(failure.code));
        }
    }
    return worst;
}
