// SPDX-License-Identifier: GPL-3.0-or-later
// Level sets in sparse grids, read at every point: OpenVDB's accessor, NanoVDB's, and the C header
// PNanoVDB.h. bench_contact_vdb < JOBS (contact_rival.hpp). Values sit at the centres of cells, as everywhere
// here; "trilinear" takes the gradient only at points in contact.
#include "contact_probe.hpp"

#define PNANOVDB_C
#include <nanovdb/PNanoVDB.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

using namespace voxshell;
using namespace voxshell::bench;

namespace {

struct Grids {
    openvdb::FloatGrid::Ptr open;
    nanovdb::GridHandle<nanovdb::HostBuffer> nano;
};

std::shared_ptr<Grids> make_grids(const Job &job)
{
    const Mesh mesh = static_mesh(job.motion);
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    for (const auto &v : mesh.vertices) points.emplace_back(openvdb::Vec3d(v[0], v[1], v[2]));
    for (const auto &t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    const auto transform = openvdb::math::Transform::createLinearTransform(job.voxel);
    transform->postTranslate(openvdb::Vec3d(job.voxel / 2));
    auto grids = std::make_shared<Grids>();
    grids->open = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(*transform, points, triangles, 3.0f);
    grids->nano = nanovdb::openToNanoVDB(*grids->open);
    return grids;
}

class OpenVdb {
  public:
    explicit OpenVdb(const Grids &grids) : accessor_(grids.open->getConstAccessor()) {}
    float nearest(int i, int j, int k) { return accessor_.getValue({i, j, k}); }
    float linear(const std::array<float, 3> &u)
    {
        return openvdb::tools::BoxSampler::sample(accessor_,
                                                  openvdb::Vec3R(openvdb::Vec3s(u[0], u[1], u[2])));
    }
    static double mib(const Grids &grids) { return static_cast<double>(grids.open->memUsage()) / (1 << 20); }

  private:
    openvdb::FloatGrid::ConstAccessor accessor_;
};

class NanoVdb {
  public:
    explicit NanoVdb(const Grids &grids)
        : accessor_(grids.nano.grid<float>()->getAccessor()),
          sampler_(nanovdb::createSampler<1, decltype(accessor_), false>(accessor_))
    {
    }
    float nearest(int i, int j, int k) { return accessor_.getValue({i, j, k}); }
    float linear(const std::array<float, 3> &u) { return sampler_(nanovdb::Vec3f(u[0], u[1], u[2])); }
    static double mib(const Grids &grids) { return static_cast<double>(grids.nano.size()) / (1 << 20); }

  private:
    nanovdb::FloatGrid::AccessorType accessor_;
    nanovdb::SampleFromVoxels<nanovdb::FloatGrid::AccessorType, 1, false> sampler_;
};

class PNanoVdb {
  public:
    explicit PNanoVdb(const Grids &grids)
    {
        // The header's buffer is not const; nothing here writes.
        auto *words = reinterpret_cast<std::uint32_t *>(const_cast<std::uint8_t *>(grids.nano.data()));
        buffer_ = pnanovdb_make_buf(words, grids.nano.size() / 4);
        const pnanovdb_grid_handle_t grid{{0}};
        pnanovdb_readaccessor_init(&accessor_,
                                   pnanovdb_tree_get_root(buffer_, pnanovdb_grid_get_tree(buffer_, grid)));
    }
    float nearest(int i, int j, int k)
    {
        const pnanovdb_coord_t at{i, j, k};
        return pnanovdb_read_float(buffer_, pnanovdb_readaccessor_get_value_address(
                                                PNANOVDB_GRID_TYPE_FLOAT, buffer_, &accessor_, &at));
    }
    float linear(const std::array<float, 3> &u)
    {
        const std::array<float, 3> base{std::floor(u[0]), std::floor(u[1]), std::floor(u[2])};
        const int i = static_cast<int>(base[0]), j = static_cast<int>(base[1]), k = static_cast<int>(base[2]);
        const float ti = u[0] - base[0], tj = u[1] - base[1], tk = u[2] - base[2];
        const auto along_k = [&](int a, int b) {
            const float v = nearest(a, b, k);
            return v + tk * (nearest(a, b, k + 1) - v);
        };
        const auto along_j = [&](int a) {
            const float v = along_k(a, j);
            return v + tj * (along_k(a, j + 1) - v);
        };
        const float v = along_j(i);
        return v + ti * (along_j(i + 1) - v);
    }
    static double mib(const Grids &grids) { return NanoVdb::mib(grids); }

  private:
    pnanovdb_buf_t buffer_{};
    pnanovdb_readaccessor_t accessor_{};
};

enum class Order { nearest, linear };

/// Value and direction from the eight corners, at the few points in contact.
template<typename Look>
Vec3 direction_at(Look &look, const std::array<float, 3> &u)
{
    const std::array<float, 3> base{std::floor(u[0]), std::floor(u[1]), std::floor(u[2])};
    float v[2][2][2];
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b)
            for (int c = 0; c < 2; ++c)
                v[a][b][c] = look.nearest(static_cast<int>(base[0]) + a, static_cast<int>(base[1]) + b,
                                          static_cast<int>(base[2]) + c);
    return Trilinear(v, {u[0] - base[0], u[1] - base[1], u[2] - base[2]}).direction();
}

template<typename Look, Order order>
class VdbRival : public Rival {
  public:
    VdbRival(std::shared_ptr<const Grids> grids, double voxel, const Points &points)
        : grids_(std::move(grids)), look_(*grids_), voxel_(voxel), points_(points)
    {
    }
    Contact tick(const Pose &pose) override
    {
        constexpr double to_index = order == Order::nearest ? 0 : 0.5;
        const CellMotion motion(pose, voxel_, {to_index, to_index, to_index});
        ForceSum sum(points_, pose);
        for (std::uint32_t p = 0; p < points_.count; ++p) {
            const auto u = motion(points_.x[p], points_.y[p], points_.z[p]);
            if constexpr (order == Order::nearest) {
                const float d =
                    look_.nearest(static_cast<int>(std::floor(u[0])), static_cast<int>(std::floor(u[1])),
                                  static_cast<int>(std::floor(u[2])));
                if (d < 0) sum.add(p, sum.normal(p), -static_cast<double>(d));
            } else {
                const float d = look_.linear(u);
                if (d < 0) sum.add(p, direction_at(look_, u), -static_cast<double>(d));
            }
        }
        sum.contact.touched = points_.count;
        return sum.contact;
    }
    double static_mib() const override { return Look::mib(*grids_); }

  private:
    std::shared_ptr<const Grids> grids_;
    Look look_;
    double voxel_;
    const Points &points_;
};

using MapKey = std::pair<bool, double>;

template<typename Look, Order order>
RivalRow row_of(const char *name, Last<MapKey, Grids> &maps)
{
    return {name, Kind::points, [&maps](const Job &job, const Points &points) {
                const auto grids =
                    maps.get({job.motion == Motion::all, job.voxel}, [&] { return make_grids(job); });
                return std::make_unique<VdbRival<Look, order>>(grids, job.voxel, points);
            }};
}

} // namespace

int main(int argc, char **argv)
{
    openvdb::initialize();
    Last<MapKey, Grids> maps;
    return run_rivals(argc, argv,
                      {row_of<OpenVdb, Order::nearest>("OpenVDB accessor, nearest", maps),
                       row_of<OpenVdb, Order::linear>("OpenVDB accessor, trilinear", maps),
                       row_of<NanoVdb, Order::nearest>("NanoVDB accessor, nearest", maps),
                       row_of<NanoVdb, Order::linear>("NanoVDB accessor, trilinear", maps),
                       row_of<PNanoVdb, Order::nearest>("PNanoVDB.h, nearest", maps),
                       row_of<PNanoVdb, Order::linear>("PNanoVDB.h, trilinear", maps)});
}
