// SPDX-License-Identifier: GPL-3.0-or-later
// The rival that anyone writes: a plain array over the static part's box, read at every point.
// bench_contact_dense < JOBS (contact_rival.hpp).
#include "contact_probe.hpp"

#include "voxmap/classify.hpp"
#include "voxmap/voxelize.hpp"

#include <immintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

using namespace voxshell;
using namespace voxshell::bench;

namespace {

/// One value per cell of the box, k fastest; outside is free.
template<typename T>
struct Dense {
    explicit Dense(const LatticeMesh &lattice) : voxel(lattice.voxel)
    {
        constexpr int margin = 4; // a trilinear cell beside the last contact must be inside
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] = lattice.min[a] - margin;
            size[a] = static_cast<int>(lattice.max[a] - lattice.min[a]) + 1 + 2 * margin;
            origin[a] = static_cast<double>(low[a]);
        }
        values.assign(std::size_t(size[0]) * size[1] * size[2] + 4,
                      T{}); // a gather of bytes reads three more
    }
    std::size_t index(int i, int j, int k) const { return (std::size_t(i) * size[1] + j) * size[2] + k; }
    bool holds(const std::array<float, 3> &u, float from = 0, float margin = 0) const
    {
        for (std::size_t a = 0; a < 3; ++a)
            if (!(u[a] >= from && u[a] < static_cast<float>(size[a]) - margin)) return false;
        return true;
    }
    double mib() const { return static_cast<double>(values.size() * sizeof(T)) / (1 << 20); }

    double voxel;
    Cell low{};
    std::array<int, 3> size{};
    Vec3 origin{};
    std::vector<T> values;
};

using States = Dense<std::int8_t>;
using Distances = Dense<float>;

std::shared_ptr<States> make_states(const Job &job)
{
    Progress silent;
    const Mesh mesh = static_mesh(job.motion);
    const LatticeMesh lattice = snap(mesh, job.voxel);
    Cells cells = voxelize(lattice, bin_triangles(lattice, silent), silent);
    const WindingNumber winding(mesh);
    classify(cells, winding, silent);
    auto map = std::make_shared<States>(lattice);
    const auto put = [&](std::array<std::int32_t, 3> brick, std::uint32_t c, int state) {
        std::array<int, 3> at{static_cast<int>(c >> 6), static_cast<int>(c >> 3 & 7),
                              static_cast<int>(c & 7)};
        for (std::size_t a = 0; a < 3; ++a)
            at[a] += static_cast<int>(cells.origin[a] - map->low[a]) + 8 * brick[a];
        map->values[map->index(at[0], at[1], at[2])] = static_cast<std::int8_t>(state);
    };
    for (const Brick &brick : cells.bricks)
        for (std::uint32_t c = 0; c < 512; ++c) {
            if (brick.surface[c >> 6] >> (c & 63) & 1) put(brick.at, c, VXS_CELL_SURFACE);
            if (brick.interior[c >> 6] >> (c & 63) & 1) put(brick.at, c, VXS_CELL_INTERIOR);
        }
    for (const SolidRun &run : cells.solid)
        for (std::int32_t k = run.first; k <= run.last; ++k)
            for (std::uint32_t c = 0; c < 512; ++c) put({run.i, run.j, k}, c, VXS_CELL_INTERIOR);
    return map;
}

std::shared_ptr<Distances> make_distances(const Job &job)
{
    auto map = std::make_shared<Distances>(snap(static_mesh(job.motion), job.voxel));
    tbb::parallel_for(tbb::blocked_range<int>(0, map->size[0]), [&](const auto &range) {
        for (int i = range.begin(); i < range.end(); ++i)
            for (int j = 0; j < map->size[1]; ++j)
                for (int k = 0; k < map->size[2]; ++k) {
                    const Vec3 centre{(map->origin[0] + i + 0.5) * job.voxel,
                                      (map->origin[1] + j + 0.5) * job.voxel,
                                      (map->origin[2] + k + 0.5) * job.voxel};
                    map->values[map->index(i, j, k)] =
                        static_cast<float>(static_distance(job.motion, centre));
                }
    });
    return map;
}

/// Trilinear between the centres of cells; nothing outside.
[[gnu::always_inline]] inline bool interpolate(const Distances &map, std::array<float, 3> u, Trilinear &out)
{
    if (!map.holds(u, 0.5f, 0.5f)) return false;
    for (float &x : u) x -= 0.5f;
    const int i = static_cast<int>(u[0]), j = static_cast<int>(u[1]), k = static_cast<int>(u[2]);
    const float *corner = map.values.data() + map.index(i, j, k);
    const int plane = map.size[1] * map.size[2], line = map.size[2];
    float v[2][2][2];
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b)
            for (int c = 0; c < 2; ++c) v[a][b][c] = corner[a * plane + b * line + c];
    out = Trilinear(
        v, {u[0] - static_cast<float>(i), u[1] - static_cast<float>(j), u[2] - static_cast<float>(k)});
    return true;
}

// -- scalar: as anyone writes it
// ---------------------------------------------------------------------------------

Contact states_scalar(const States &map, const Points &points, const Pose &pose)
{
    const CellMotion motion(pose, map.voxel, map.origin);
    ForceSum sum(points, pose);
    for (std::uint32_t p = 0; p < points.count; ++p) {
        const auto u = motion(points.x[p], points.y[p], points.z[p]);
        if (!map.holds(u)) continue;
        const std::array<int, 3> c{static_cast<int>(u[0]), static_cast<int>(u[1]), static_cast<int>(u[2])};
        if (map.values[map.index(c[0], c[1], c[2])] == VXS_CELL_SURFACE)
            sum.add_tangent_plane(p, u, c, map.voxel);
    }
    return sum.contact;
}

Contact trilinear_scalar(const Distances &map, const Points &points, const Pose &pose)
{
    const CellMotion motion(pose, map.voxel, map.origin);
    ForceSum sum(points, pose);
    Trilinear at({}, {});
    for (std::uint32_t p = 0; p < points.count; ++p)
        if (interpolate(map, motion(points.x[p], points.y[p], points.z[p]), at) && at.value < 0)
            sum.add(p, at.direction(), -static_cast<double>(at.value));
    return sum.contact;
}

// -- AVX2: eight points at a time
// ----------------------------------------------------------------------------------

struct Eight {
    __m256 u[3];
    __m256i cell[3];
    __m256 inside;
    int any;
};

__m256 row(const float *m, float b, __m256 x, __m256 y, __m256 z)
{
    return _mm256_fmadd_ps(_mm256_set1_ps(m[0]), x,
                           _mm256_fmadd_ps(_mm256_set1_ps(m[1]), y,
                                           _mm256_fmadd_ps(_mm256_set1_ps(m[2]), z, _mm256_set1_ps(b))));
}

/// Cells of u - shift, where from <= u < size - margin.
template<typename T>
Eight place(const Dense<T> &map, const CellMotion &motion, const Points &points, std::uint32_t p, float shift)
{
    const __m256 x = _mm256_loadu_ps(points.x.data() + p), y = _mm256_loadu_ps(points.y.data() + p),
                 z = _mm256_loadu_ps(points.z.data() + p);
    Eight e;
    e.inside = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    for (int a = 0; a < 3; ++a) {
        e.u[a] = row(motion.m + 3 * a, motion.b[a] - shift, x, y, z);
        const __m256 above = _mm256_cmp_ps(e.u[a], _mm256_setzero_ps(), _CMP_GE_OQ);
        const __m256 below =
            _mm256_cmp_ps(e.u[a], _mm256_set1_ps(static_cast<float>(map.size[a]) - 2 * shift), _CMP_LT_OQ);
        e.inside = _mm256_and_ps(e.inside, _mm256_and_ps(above, below));
        e.cell[a] = _mm256_and_si256(_mm256_cvttps_epi32(e.u[a]), _mm256_castps_si256(e.inside));
    }
    e.any = _mm256_movemask_ps(e.inside);
    if (points.count - p < 8) e.any &= (1 << (points.count - p)) - 1;
    return e;
}

template<typename T>
__m256i index_of(const Dense<T> &map, const Eight &e)
{
    __m256i index =
        _mm256_add_epi32(_mm256_mullo_epi32(e.cell[0], _mm256_set1_epi32(map.size[1])), e.cell[1]);
    return _mm256_add_epi32(_mm256_mullo_epi32(index, _mm256_set1_epi32(map.size[2])), e.cell[2]);
}

Contact states_avx2(const States &map, const Points &points, const Pose &pose)
{
    const CellMotion motion(pose, map.voxel, map.origin);
    ForceSum sum(points, pose);
    for (std::uint32_t p = 0; p < points.count; p += 8) {
        const Eight e = place(map, motion, points, p, 0);
        if (!e.any) continue;
        const __m256i word = _mm256_mask_i32gather_epi32(_mm256_setzero_si256(),
                                                         reinterpret_cast<const int *>(map.values.data()),
                                                         index_of(map, e), _mm256_castps_si256(e.inside), 1);
        const __m256i state = _mm256_and_si256(word, _mm256_set1_epi32(0xff));
        int hits = e.any & _mm256_movemask_ps(_mm256_castsi256_ps(
                               _mm256_cmpeq_epi32(state, _mm256_set1_epi32(VXS_CELL_SURFACE))));
        for (; hits; hits &= hits - 1) {
            const std::uint32_t q =
                p + static_cast<std::uint32_t>(__builtin_ctz(static_cast<unsigned>(hits)));
            const auto u = motion(points.x[q], points.y[q], points.z[q]);
            sum.add_tangent_plane(
                q, u, {static_cast<int>(u[0]), static_cast<int>(u[1]), static_cast<int>(u[2])}, map.voxel);
        }
    }
    return sum.contact;
}

Contact trilinear_avx2(const Distances &map, const Points &points, const Pose &pose)
{
    const CellMotion motion(pose, map.voxel, map.origin);
    ForceSum sum(points, pose);
    const int plane = map.size[1] * map.size[2], line = map.size[2];
    for (std::uint32_t p = 0; p < points.count; p += 8) {
        const Eight e = place(map, motion, points, p, 0.5f);
        if (!e.any) continue;
        const __m256i index = index_of(map, e), mask = _mm256_castps_si256(e.inside);
        __m256 t[3], v[2][2][2];
        for (int a = 0; a < 3; ++a) t[a] = _mm256_sub_ps(e.u[a], _mm256_cvtepi32_ps(e.cell[a]));
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b)
                for (int c = 0; c < 2; ++c)
                    v[a][b][c] = _mm256_mask_i32gather_ps(_mm256_set1_ps(1.0f),
                                                          map.values.data() + a * plane + b * line + c, index,
                                                          _mm256_castsi256_ps(mask), 4);
        const auto mix = [](__m256 from, __m256 slope, __m256 by) {
            return _mm256_fmadd_ps(slope, by, from);
        };
        __m256 value[2][2], slope[2][2];
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b) {
                slope[a][b] = _mm256_sub_ps(v[a][b][1], v[a][b][0]);
                value[a][b] = mix(v[a][b][0], slope[a][b], t[2]);
            }
        const __m256 j0 = _mm256_sub_ps(value[0][1], value[0][0]),
                     j1 = _mm256_sub_ps(value[1][1], value[1][0]);
        const __m256 i0 = mix(value[0][0], j0, t[1]), i1 = mix(value[1][0], j1, t[1]),
                     gi = _mm256_sub_ps(i1, i0);
        const __m256 k0 = mix(slope[0][0], _mm256_sub_ps(slope[0][1], slope[0][0]), t[1]),
                     k1 = mix(slope[1][0], _mm256_sub_ps(slope[1][1], slope[1][0]), t[1]);
        const __m256 distance = mix(i0, gi, t[0]), gj = mix(j0, _mm256_sub_ps(j1, j0), t[0]),
                     gk = mix(k0, _mm256_sub_ps(k1, k0), t[0]);
        const __m256 length =
            _mm256_sqrt_ps(_mm256_fmadd_ps(gi, gi, _mm256_fmadd_ps(gj, gj, _mm256_mul_ps(gk, gk))));
        int hits = e.any & _mm256_movemask_ps(_mm256_cmp_ps(distance, _mm256_setzero_ps(), _CMP_LT_OQ));
        if (!hits) continue;
        alignas(32) float d[8], g[3][8];
        _mm256_store_ps(d, distance);
        _mm256_store_ps(g[0], _mm256_div_ps(gi, length));
        _mm256_store_ps(g[1], _mm256_div_ps(gj, length));
        _mm256_store_ps(g[2], _mm256_div_ps(gk, length));
        for (; hits; hits &= hits - 1) {
            const int n = __builtin_ctz(static_cast<unsigned>(hits));
            sum.add(
                p + static_cast<std::uint32_t>(n),
                {static_cast<double>(g[0][n]), static_cast<double>(g[1][n]), static_cast<double>(g[2][n])},
                -static_cast<double>(d[n]));
        }
    }
    return sum.contact;
}

/// The distance at the nearest centre first; trilinear only where it leaves a contact possible.
Contact lazy_avx2(const Distances &map, const Points &points, const Pose &pose)
{
    const CellMotion motion(pose, map.voxel, map.origin);
    ForceSum sum(points, pose);
    Trilinear at({}, {});
    const __m256 near = _mm256_set1_ps(static_cast<float>(map.voxel * 0.867)); // half a cell's diagonal
    for (std::uint32_t p = 0; p < points.count; p += 8) {
        const Eight e = place(map, motion, points, p, 0);
        if (!e.any) continue;
        const __m256 distance =
            _mm256_mask_i32gather_ps(_mm256_set1_ps(1.0f), map.values.data(), index_of(map, e), e.inside, 4);
        int hits = e.any & _mm256_movemask_ps(_mm256_cmp_ps(distance, near, _CMP_LT_OQ));
        for (; hits; hits &= hits - 1) {
            const std::uint32_t q =
                p + static_cast<std::uint32_t>(__builtin_ctz(static_cast<unsigned>(hits)));
            if (interpolate(map, motion(points.x[q], points.y[q], points.z[q]), at) && at.value < 0)
                sum.add(q, at.direction(), -static_cast<double>(at.value));
        }
    }
    return sum.contact;
}

template<typename Map>
using Tick = Contact (*)(const Map &, const Points &, const Pose &);

template<typename Map>
class DenseRival : public Rival {
  public:
    DenseRival(Tick<Map> run, std::shared_ptr<const Map> map, const Points &points)
        : tick_(run), map_(std::move(map)), points_(points)
    {
    }
    Contact tick(const Pose &pose) override
    {
        Contact contact = tick_(*map_, points_, pose);
        contact.touched = points_.count;
        return contact;
    }
    double static_mib() const override { return map_->mib(); }

  private:
    Tick<Map> tick_;
    std::shared_ptr<const Map> map_;
    const Points &points_;
};

using MapKey = std::pair<bool, double>;

template<typename Map, typename Make>
RivalRow row_of(const char *name, Tick<Map> tick, Last<MapKey, Map> &maps, Make make)
{
    return {name, Kind::points, [=, &maps](const Job &job, const Points &points) {
                const auto map = maps.get({job.motion == Motion::all, job.voxel}, [&] { return make(job); });
                return std::make_unique<DenseRival<Map>>(tick, map, points);
            }};
}

} // namespace

int main(int argc, char **argv)
{
    Last<MapKey, States> states;
    Last<MapKey, Distances> distances;
    return run_rivals(
        argc, argv,
        {row_of("dense int8, nearest, scalar", states_scalar, states, make_states),
         row_of("dense int8, nearest, AVX2", states_avx2, states, make_states),
         row_of("dense float, trilinear + gradient, scalar", trilinear_scalar, distances, make_distances),
         row_of("dense float, trilinear + gradient, AVX2", trilinear_avx2, distances, make_distances),
         row_of("dense float, trilinear in the band only, AVX2", lazy_avx2, distances, make_distances)});
}
