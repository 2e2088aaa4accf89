// SPDX-License-Identifier: GPL-3.0-or-later
// What is put is found, what is damaged is not, and many writers of one key leave one entry.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "batch/cache.hpp"

#include "cli/failure.hpp"

#include <doctest/doctest.h>

#include <fstream>
#include <thread>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace voxshell;
namespace fs = std::filesystem;

namespace {

struct Folder {
    fs::path path;
    Folder()
    {
        std::string name = (fs::temp_directory_path() / "voxshell-XXXXXX").string();
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path = name;
    }
    ~Folder() { fs::remove_all(path); }
};

using Bytes = std::vector<std::uint8_t>;

Sha256 key(std::uint8_t n)
{
    return sha256(Bytes{n});
}

std::size_t entries(const fs::path &folder)
{
    std::size_t n = 0;
    for (const auto &each : fs::recursive_directory_iterator(folder))
        n += each.path().filename() == "entry.json";
    return n;
}

std::size_t temporaries(const fs::path &folder)
{
    std::size_t n = 0;
    for (const auto &each : fs::directory_iterator(folder))
        n += each.path().filename().string().starts_with("tmp-");
    return n;
}

Bytes content(const fs::path &path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

TEST_CASE("put, find, damage")
{
    const Folder folder;
    Cache cache(folder.path);
    const Bytes a(1000, 7), b{1, 2, 3};
    CHECK(!cache.find(key(1)));
    const auto put = cache.put(key(1), {{"points", 12}}, {{"vdb", a}, {"voxmap", b}});
    auto found = cache.find(key(1));
    REQUIRE(found);
    CHECK(found->about["points"] == 12);
    REQUIRE(found->files.size() == 2);
    CHECK(found->files[1].name == "voxmap");
    CHECK(content(found->files[1].path) == b);
    CHECK(found->files[1].path == put.files[1].path);
    CHECK(!cache.find(key(2)));

    SUBCASE("a changed byte")
    {
        std::ofstream(found->files[0].path, std::ios::in | std::ios::out) << 'x';
    }
    SUBCASE("a shorter file")
    {
        fs::resize_file(found->files[0].path, 999);
    }
    SUBCASE("a file gone")
    {
        fs::remove(found->files[1].path);
    }
    SUBCASE("half an entry.json")
    {
        fs::resize_file(found->files[0].path.parent_path() / "entry.json", 40);
    }
    SUBCASE("another's entry.json")
    {
        cache.put(key(3), {}, {{"vdb", a}});
        fs::copy_file(cache.find(key(3))->files[0].path.parent_path() / "entry.json",
                      found->files[0].path.parent_path() / "entry.json",
                      fs::copy_options::overwrite_existing);
    }
    CHECK(!cache.find(key(1)));
    CHECK(temporaries(folder.path) == 0);
    cache.put(key(1), {{"points", 13}}, {{"vdb", a}, {"voxmap", b}}); // and made again
    CHECK(cache.find(key(1))->about["points"] == 13);
}

TEST_CASE("many writers of the same keys")
{
    const Folder folder;
    constexpr int writers = 4, keys = 8;
    std::vector<pid_t> children;
    for (int w = 0; w < writers; ++w) {
        const pid_t child = fork();
        if (child == 0) {
            try {
                Cache cache(folder.path);
                for (int round = 0; round < 25; ++round)
                    for (std::uint8_t k = 0; k < keys; ++k) {
                        const Bytes bytes(5000, k);
                        if (const auto found = cache.find(key(k))) {
                            if (content(found->files[0].path) != bytes) _exit(2);
                        } else {
                            cache.put(key(k), {}, {{"vdb", bytes}});
                        }
                    }
                _exit(0);
            } catch (const std::exception &) {
                _exit(3);
            }
        }
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = 0;
        waitpid(child, &status, 0);
        CHECK(WIFEXITED(status));
        CHECK(WEXITSTATUS(status) == 0);
    }
    CHECK(entries(folder.path) == keys);
    CHECK(temporaries(folder.path) == 0);
}

TEST_CASE("what a killed writer left is taken away by the next, what a living one writes is not")
{
    const Folder folder;
    char machine[256] = "";
    gethostname(machine, sizeof machine - 1);
    const pid_t dead = fork();
    if (dead == 0) _exit(0);
    waitpid(dead, nullptr, 0);
    const std::string prefix = std::string("tmp-") + machine + "-";
    fs::create_directory(folder.path / (prefix + std::to_string(dead) + "-0"));
    fs::create_directory(folder.path / (prefix + std::to_string(getppid()) + "-0"));
    fs::create_directory(folder.path / "tmp-elsewhere-1-0");
    const Cache cache(folder.path);
    CHECK(temporaries(folder.path) == 2);
}

TEST_CASE("shrink takes what was not used for longest")
{
    const Folder folder;
    Cache cache(folder.path);
    const Bytes bytes(10000, 1);
    for (std::uint8_t k = 0; k < 4; ++k) {
        const auto made = cache.put(key(k), {}, {{"vdb", bytes}});
        const timespec long_ago[2] = {{1000 + k, 0}, {1000 + k, 0}};
        utimensat(AT_FDCWD, (made.files[0].path.parent_path() / "entry.json").c_str(), long_ago, 0);
    }
    cache.find(key(0)); // used now
    CHECK(cache.shrink(25000) > 20000);
    CHECK(cache.find(key(0)));
    CHECK(!cache.find(key(1)));
    CHECK(!cache.find(key(2)));
    CHECK(cache.find(key(3)));
    CHECK(cache.shrink(1 << 20) == 0);
}

TEST_CASE("a folder that cannot be one")
{
    const Folder folder;
    std::ofstream(folder.path / "file") << "x";
    CHECK_THROWS_AS(Cache(folder.path / "file"), Failure);
}
