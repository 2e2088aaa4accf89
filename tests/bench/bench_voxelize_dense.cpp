// SPDX-License-Identifier: GPL-3.0-or-later
// The rival that anyone writes: triangle against box in floats (Schwarz, Seidel 2010) into a dense array of
// bits, surface only. bench_voxelize_dense CELLS [RUNS] [THREADS]. Two threads: bits are set by atomic or.
#include "cup.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fmt/core.h>
#include <memory>
#include <sys/resource.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

namespace {

using V3 = std::array<float, 3>;

struct Grid {
    std::array<int, 3> size{};
    std::unique_ptr<std::atomic<std::uint32_t>[]> words;
    std::size_t count = 0;
    bool shared = false; ///< several threads write

    explicit Grid(const std::array<int, 3> &cells) : size(cells)
    {
        count = (static_cast<std::size_t>(size[0]) * size[1] * size[2] + 31) / 32;
        words = std::make_unique<std::atomic<std::uint32_t>[]>(count); // zero
    }
    void set(int x, int y, int z)
    {
        const std::size_t bit = (static_cast<std::size_t>(x) * size[1] + y) * size[2] + z;
        std::atomic<std::uint32_t> &word = words[bit >> 5];
        const std::uint32_t mask = 1u << (bit & 31), now = word.load(std::memory_order_relaxed);
        if (now & mask) return;
        if (shared)
            word.fetch_or(mask, std::memory_order_relaxed);
        else
            word.store(now | mask, std::memory_order_relaxed);
    }
};

/// Marks the cells that triangle `v` (in cells, >= 0) overlaps: plane and three projections, each set up
/// once.
void mark(Grid &grid, const std::array<V3, 3> &v)
{
    V3 e[3], n;
    for (int a = 0; a < 3; ++a)
        e[0][a] = v[1][a] - v[0][a], e[1][a] = v[2][a] - v[1][a], e[2][a] = v[0][a] - v[2][a];
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        n[a] = e[0][b] * e[1][c] - e[0][c] * e[1][b];
    }
    int low[3], high[3];
    for (int a = 0; a < 3; ++a) {
        low[a] = std::max(0, static_cast<int>(std::min({v[0][a], v[1][a], v[2][a]})));
        high[a] = std::min(grid.size[a] - 1, static_cast<int>(std::max({v[0][a], v[1][a], v[2][a]})));
    }
    float d1 = 0, d2 = 0;
    for (int a = 0; a < 3; ++a) {
        const float critical = n[a] > 0 ? 1.0f : 0.0f;
        d1 += n[a] * (critical - v[0][a]);
        d2 += n[a] * (1.0f - critical - v[0][a]);
    }
    struct Edge {
        float a, b, d;
    } edge[3][3]; // of the planes xy, yz, zx
    for (int plane = 0; plane < 3; ++plane) {
        const int a = plane, b = (plane + 1) % 3, c = (plane + 2) % 3;
        for (int k = 0; k < 3; ++k) {
            const float sign = n[c] < 0 ? -1.0f : 1.0f, na = -e[k][b] * sign, nb = e[k][a] * sign;
            edge[plane][k] = {na, nb,
                              -(na * v[k][a] + nb * v[k][b]) + std::max(0.0f, na) + std::max(0.0f, nb)};
        }
    }
    const auto passes = [&](int plane, float a, float b) {
        for (const Edge &k : edge[plane])
            if (k.a * a + k.b * b + k.d < 0) return false;
        return true;
    };
    for (int x = low[0]; x <= high[0]; ++x)
        for (int y = low[1]; y <= high[1]; ++y) {
            const float fx = static_cast<float>(x), fy = static_cast<float>(y);
            if (!passes(0, fx, fy)) continue;
            for (int z = low[2]; z <= high[2]; ++z) {
                const float fz = static_cast<float>(z), dot = n[0] * fx + n[1] * fy + n[2] * fz;
                if ((dot + d1) * (dot + d2) <= 0 && passes(1, fy, fz) && passes(2, fz, fx)) grid.set(x, y, z);
            }
        }
}

} // namespace

int main(int argc, char **argv)
{
    const int cells = argc > 1 ? std::atoi(argv[1]) : 1024, runs = argc > 2 ? std::atoi(argv[2]) : 3,
              threads = argc > 3 ? std::atoi(argv[3]) : 1;
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    const voxshell::Mesh mesh = bench_cup();
    const double h = 0.090 / cells, low[3] = {-0.040, 0, -0.040};
    for (int run = 0; run < runs; ++run) {
        const auto start = std::chrono::steady_clock::now();
        std::vector<V3> points(mesh.vertices.size());
        for (std::size_t p = 0; p < points.size(); ++p)
            for (int a = 0; a < 3; ++a) points[p][a] = static_cast<float>((mesh.vertices[p][a] - low[a]) / h);
        const int side = static_cast<int>(0.080 / h) + 1;
        Grid grid({side, cells + 1, side});
        grid.shared = threads > 1;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.triangles.size(), 256),
                          [&](const auto &range) {
                              for (std::size_t t = range.begin(); t < range.end(); ++t) {
                                  const auto &[a, b, c] = mesh.triangles[t];
                                  mark(grid, {points[a], points[b], points[c]});
                              }
                          });
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        std::uint64_t surface = 0;
        for (std::size_t w = 0; w < grid.count; ++w)
            surface += static_cast<std::uint64_t>(__builtin_popcount(grid.words[w]));
        rusage used{};
        getrusage(RUSAGE_SELF, &used);
        fmt::print(
            "{{\"what\":\"dense "
            "surface\",\"cells\":{},\"triangles\":{},\"seconds\":{:.4f},\"surface\":{},\"peak_mib\":{}}}\n",
            cells, mesh.triangles.size(), seconds, surface, used.ru_maxrss / 1024);
    }
}
