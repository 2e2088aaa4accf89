// SPDX-License-Identifier: GPL-3.0-or-later
#include "foreign_grids.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <stdexcept>

namespace foreign {
namespace {

using openvdb::BoolGrid;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::MaskGrid;
using openvdb::math::Transform;

Coord coord(const Cell &at)
{
    return {static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2])};
}

Transform::Ptr transform(const Frame &frame)
{
    auto out = Transform::createLinearTransform(frame.voxel);
    out->postTranslate(openvdb::Vec3d(frame.origin[0], frame.origin[1], frame.origin[2]));
    return out;
}

void save(const std::filesystem::path &file, const openvdb::GridPtrVec &grids)
{
    openvdb::io::File out(file.string());
    out.write(grids);
}

template<typename Visit>
void each(const Cell &low, const Cell &high, Visit visit)
{
    for (std::int64_t i = low[0]; i <= high[0]; ++i)
        for (std::int64_t j = low[1]; j <= high[1]; ++j)
            for (std::int64_t k = low[2]; k <= high[2]; ++k) visit(Cell{i, j, k});
}

FloatGrid::Ptr ball(double radius, double voxel)
{
    auto grid = FloatGrid::create(static_cast<float>(3 * voxel));
    grid->setName("ball");
    grid->setTransform(Transform::createLinearTransform(voxel));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    const auto reach = static_cast<std::int64_t>(radius / voxel) + 3;
    auto accessor = grid->getAccessor();
    each({-reach, -reach, -reach}, {reach, reach, reach}, [&](const Cell &at) {
        const double r =
            voxel * std::sqrt(static_cast<double>(at[0] * at[0] + at[1] * at[1] + at[2] * at[2])) - radius;
        if (r < 3 * voxel) accessor.setValue(coord(at), static_cast<float>(std::max(r, -3 * voxel)));
    });
    return grid;
}

MaskGrid::Ptr slab(const char *name)
{
    auto grid = MaskGrid::create();
    grid->setName(name);
    grid->denseFill(openvdb::CoordBBox(Coord(0), Coord(20, 10, 3)), true);
    return grid;
}

/// A float grid of one tile: level 1 is 8^3, 2 is 128^3, 3 is 4096^3.
FloatGrid::Ptr tile(openvdb::Index level, const Coord &at, float value = -1)
{
    auto grid = FloatGrid::create(1);
    grid->setName("tile");
    grid->tree().addTile(level, at, value, false);
    return grid;
}

FloatGrid::Ptr with_value(float value)
{
    auto grid = ball(0.02, 0.002);
    grid->tree().setValue(Coord(3, 1, 0), value);
    return grid;
}

FloatGrid::Ptr with_transform(const Transform::Ptr &transform)
{
    auto grid = ball(0.02, 0.002);
    grid->setTransform(transform);
    return grid;
}

Transform::Ptr linear(const openvdb::Vec3d &x, const openvdb::Vec3d &y, const openvdb::Vec3d &z)
{
    const double rows[16] = {x[0], x[1], x[2], 0, y[0], y[1], y[2], 0, z[0], z[1], z[2], 0, 0, 0, 0, 1};
    return Transform::createLinearTransform(openvdb::Mat4d(rows));
}

template<typename Grid>
openvdb::GridPtrVec one_of_type(const typename Grid::ValueType &background,
                                const typename Grid::ValueType &value)
{
    auto grid = Grid::create(background);
    grid->setName("field");
    grid->tree().setValue(Coord(1, 2, 3), value);
    return {grid};
}

const std::map<std::string, std::function<openvdb::GridPtrVec()>> &makers()
{
    static const std::map<std::string, std::function<openvdb::GridPtrVec()>> table = {
        {"ball", [] { return openvdb::GridPtrVec{ball(0.02, 0.001)}; }},
        {"large", [] { return openvdb::GridPtrVec{ball(0.2, 0.002)}; }},
        {"mask", [] { return openvdb::GridPtrVec{slab("mask")}; }},
        {"mask-4096",
         [] {
             auto grid = MaskGrid::create();
             grid->tree().addTile(3, Coord(0), true, true);
             return openvdb::GridPtrVec{grid};
         }},
        {"mask-1024",
         [] {
             auto grid = MaskGrid::create();
             grid->denseFill(openvdb::CoordBBox(Coord(0), Coord(1023)), true);
             return openvdb::GridPtrVec{grid};
         }},
        {"two",
         [] {
             return openvdb::GridPtrVec{ball(0.02, 0.001), slab("mask")};
         }},
        {"same-names",
         [] {
             return openvdb::GridPtrVec{slab("mask"), slab("mask")};
         }},
        {"own-name", [] { return openvdb::GridPtrVec{slab("state")}; }},
        {"none", [] { return openvdb::GridPtrVec{}; }},
        {"fog",
         [] {
             auto grid = ball(0.02, 0.002);
             grid->setGridClass(openvdb::GRID_FOG_VOLUME);
             return openvdb::GridPtrVec{grid};
         }},
        {"unclassed",
         [] {
             auto grid = ball(0.02, 0.002);
             grid->setGridClass(openvdb::GRID_UNKNOWN);
             return openvdb::GridPtrVec{grid};
         }},
        {"double", [] { return one_of_type<openvdb::DoubleGrid>(1, -1); }},
        {"vector", [] { return one_of_type<openvdb::Vec3SGrid>(openvdb::Vec3s(0), openvdb::Vec3s(1)); }},
        {"ints", [] { return one_of_type<openvdb::Int32Grid>(0, 1); }},
        {"nan", [] { return openvdb::GridPtrVec{with_value(std::numeric_limits<float>::quiet_NaN())}; }},
        {"infinite", [] { return openvdb::GridPtrVec{with_value(std::numeric_limits<float>::infinity())}; }},
        {"nothing", [] { return openvdb::GridPtrVec{FloatGrid::create(1)}; }},
        {"positive", [] { return openvdb::GridPtrVec{tile(2, Coord(0), 0.5f)}; }},
        {"inverted",
         [] {
             auto grid = FloatGrid::create(-1);
             grid->tree().setValue(Coord(0), 1);
             return openvdb::GridPtrVec{grid};
         }},
        {"all-true", [] { return openvdb::GridPtrVec{BoolGrid::create(true)}; }},
        {"active-false",
         [] {
             auto grid = BoolGrid::create(false);
             grid->denseFill(openvdb::CoordBBox(Coord(0), Coord(9)), false, true);
             return openvdb::GridPtrVec{grid};
         }},
        {"tile-8", [] { return openvdb::GridPtrVec{tile(1, Coord(-8, 0, 16))}; }},
        {"tile-128", [] { return openvdb::GridPtrVec{tile(2, Coord(-128, 0, 128))}; }},
        {"tile-4096", [] { return openvdb::GridPtrVec{tile(3, Coord(0))}; }},
        {"tiles-far-apart",
         [] {
             auto grid = tile(1, Coord(0));
             grid->tree().addTile(1, Coord(1 << 21, 0, 0), -1, false);
             return openvdb::GridPtrVec{grid};
         }},
        {"at-the-end", [] { return openvdb::GridPtrVec{tile(3, Coord(0x7ffff000, 0, 0))}; }},
        {"stretched",
         [] {
             return openvdb::GridPtrVec{with_transform(linear({1e-3, 0, 0}, {0, 2e-3, 0}, {0, 0, 1e-3}))};
         }},
        {"turned",
         [] {
             return openvdb::GridPtrVec{with_transform(linear({0, 1e-3, 0}, {-1e-3, 0, 0}, {0, 0, 1e-3}))};
         }},
        {"sheared",
         [] {
             return openvdb::GridPtrVec{with_transform(linear({1e-3, 0, 0}, {1e-4, 1e-3, 0}, {0, 0, 1e-3}))};
         }},
        {"mirrored",
         [] {
             return openvdb::GridPtrVec{with_transform(linear({-1e-3, 0, 0}, {0, -1e-3, 0}, {0, 0, -1e-3}))};
         }},
        {"frustum",
         [] {
             return openvdb::GridPtrVec{with_transform(Transform::createFrustumTransform(
                 openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(100)), 0.5, 10, 1))};
         }},
        {"huge-voxel",
         [] { return openvdb::GridPtrVec{with_transform(Transform::createLinearTransform(2e3))}; }},
        {"far-away",
         [] {
             auto frame = Transform::createLinearTransform(1e-3);
             frame->postTranslate(openvdb::Vec3d(1e10, 0, 0));
             return openvdb::GridPtrVec{with_transform(frame)};
         }},
    };
    return table;
}

} // namespace

void save_mesh(const std::filesystem::path &file, const voxshell::Mesh &mesh, const Frame &frame, bool half)
{
    openvdb::initialize();
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    const auto place = transform(frame);
    for (const auto &v : mesh.vertices) points.emplace_back(openvdb::Vec3d(v[0], v[1], v[2]));
    for (const auto &t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto grid = openvdb::tools::meshToLevelSet<FloatGrid>(*place, points, triangles, 3);
    grid->setName("surface");
    grid->setSaveFloatAsHalf(half);
    save(file, {grid});
}

void save_floats(const std::filesystem::path &file, const Cell &low, const Cell &high, const Sample &value,
                 const Frame &frame, bool level_set)
{
    openvdb::initialize();
    auto grid = FloatGrid::create(1);
    grid->setName("values");
    grid->setTransform(transform(frame));
    if (level_set) grid->setGridClass(openvdb::GRID_LEVEL_SET);
    auto accessor = grid->getAccessor();
    each(low, high, [&](const Cell &at) { accessor.setValue(coord(at), value(at)); });
    save(file, {grid});
}

void save_mask(const std::filesystem::path &file, const Cell &low, const Cell &high, const On &on,
               const Frame &frame)
{
    openvdb::initialize();
    auto grid = MaskGrid::create();
    grid->setName("mask");
    grid->setTransform(transform(frame));
    auto accessor = grid->getAccessor();
    each(low, high, [&](const Cell &at) {
        if (on(at)) accessor.setValueOn(coord(at));
    });
    grid->tree().prune();
    save(file, {grid});
}

void save_bools(const std::filesystem::path &file, const Cell &low, const Cell &high, const On &on,
                const Frame &frame)
{
    openvdb::initialize();
    auto grid = BoolGrid::create(false);
    grid->setName("bools");
    grid->setTransform(transform(frame));
    auto accessor = grid->getAccessor();
    // Active and true are not the same: what is false may be active.
    each(low, high, [&](const Cell &at) { accessor.setValue(coord(at), on(at)); });
    grid->tree().prune();
    save(file, {grid});
}

void save_kind(const std::string &kind, const std::filesystem::path &file)
{
    openvdb::initialize();
    const auto found = makers().find(kind);
    if (found == makers().end()) throw std::invalid_argument("no kind " + kind);
    save(file, found->second());
}

std::vector<std::string> kinds()
{
    std::vector<std::string> names;
    for (const auto &maker : makers()) names.push_back(maker.first);
    return names;
}

struct Reading::Grid {
    openvdb::GridBase::Ptr base;
};

Reading::Reading(const std::filesystem::path &file, const std::string &grid)
{
    openvdb::initialize();
    openvdb::io::File in(file.string());
    in.open(false);
    grid_ = new Grid{in.readGrid(grid)};
}

Reading::~Reading()
{
    delete grid_;
}

double Reading::operator()(const Cell &at) const
{
    if (const auto ints = openvdb::gridPtrCast<openvdb::Int32Grid>(grid_->base))
        return ints->tree().getValue(coord(at));
    if (const auto floats = openvdb::gridPtrCast<FloatGrid>(grid_->base))
        return static_cast<double>(floats->tree().getValue(coord(at)));
    throw std::invalid_argument("neither ints nor floats");
}

std::uint64_t Reading::active() const
{
    return grid_->base->activeVoxelCount();
}

Vector Reading::world(const Cell &at) const
{
    const auto p = grid_->base->transform().indexToWorld(coord(at));
    return {p[0], p[1], p[2]};
}

} // namespace foreign
