// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes that were used last stay, within the limit, and one always does; others are read again.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "batch/scene_shelf.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <thread>

using namespace voxshell;

namespace {

/// A scene of so many vertices, 24 bytes each.
Scene scene_of(std::size_t vertices)
{
    Scene scene;
    scene.meshes.push_back({.name = "", .vertices = std::vector<Point>(vertices), .triangles = {}});
    return scene;
}

} // namespace

TEST_CASE("the last used stay, within the limit")
{
    SceneShelf shelf(2 * 2400 + 100);
    std::vector<std::size_t> read;
    const auto get = [&](std::size_t number) {
        const auto scene = shelf.get(number, [&] {
            read.push_back(number);
            return scene_of(100);
        });
        CHECK(scene->meshes[0].vertices.size() == 100);
    };
    for (const std::size_t number : {1, 2, 1, 2, 1, 3, 1, 2}) get(number);
    CHECK(read == std::vector<std::size_t>{1, 2, 3, 2}); // 3 put 2 out, which had not been used for longest
    CHECK(shelf.bytes() == 2 * 2400);
    shelf.drop(2);
    shelf.drop(7);
    CHECK(shelf.bytes() == 2400);
    get(1);
    CHECK(read.size() == 4);
}

TEST_CASE("one stays however large it is, and who has one keeps it")
{
    SceneShelf shelf(1000);
    int reads = 0;
    const auto get = [&](std::size_t number) {
        return shelf.get(number, [&] {
            ++reads;
            return scene_of(1000 + number);
        });
    };
    const auto first = get(1);
    get(1);
    CHECK(reads == 1);
    get(2);
    CHECK(reads == 2);
    CHECK(shelf.bytes() == 24 * 1002);
    CHECK(first->meshes[0].vertices.size() == 1001);
    CHECK(get(1) != first);
}

TEST_CASE("a scene is read once for all threads that want it, and not at all if reading fails")
{
    SceneShelf shelf(1 << 20);
    std::atomic<int> reads{0};
    std::vector<std::thread> threads;
    for (int n = 0; n < 8; ++n)
        threads.emplace_back([&] {
            for (std::size_t number = 0; number < 20; ++number)
                shelf.get(number, [&] {
                    ++reads;
                    return scene_of(10);
                });
        });
    for (std::thread &thread : threads) thread.join();
    CHECK(reads == 20);
    const std::uint64_t before = shelf.bytes();
    CHECK_THROWS_AS(shelf.get(99, []() -> Scene { throw Failure(ExitCode::system, "", "cannot read"); }),
                    Failure);
    CHECK(shelf.bytes() == before);
}
