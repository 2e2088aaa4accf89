// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_ours.hpp"

#include "pointshell/pointshell_file.hpp"
#include "study/temporary_folder.hpp"
#include "voxmap/classify.hpp"
#include "voxmap/voxmap_file.hpp"

#include "voxshell/contact.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

namespace voxshell::bench {
namespace {

constexpr OurMode states(const char *name, std::uint32_t kernel, std::uint32_t culling,
                         std::uint32_t law = VXS_CONTACT_AVERAGE)
{
    return {name, kernel, culling, law, false, 0};
}
constexpr OurMode distance(const char *name, std::uint32_t kernel, std::uint32_t culling)
{
    return {name, kernel, culling, VXS_CONTACT_GRADIENT, true, 0};
}

constexpr OurMode modes[] = {
    states("voxshell states, brute, scalar", VXS_CONTACT_SCALAR, VXS_CONTACT_BRUTE),
    states("voxshell states, brute, AVX2", VXS_CONTACT_AVX2, VXS_CONTACT_BRUTE),
    states("voxshell states, brute, AVX-512", VXS_CONTACT_AVX512, VXS_CONTACT_BRUTE),
    states("voxshell states, culled, scalar", VXS_CONTACT_SCALAR, VXS_CONTACT_CULLED),
    states("voxshell states, culled, AVX2", VXS_CONTACT_AVX2, VXS_CONTACT_CULLED),
    states("voxshell states, culled, AVX-512", VXS_CONTACT_AVX512, VXS_CONTACT_CULLED),
    states("voxshell states, coherent, AVX2", VXS_CONTACT_AVX2, VXS_CONTACT_COHERENT),
    states("voxshell states, coherent, AVX-512", VXS_CONTACT_AVX512, VXS_CONTACT_COHERENT),
    states("voxshell states, coherent, original law", VXS_CONTACT_FASTEST, VXS_CONTACT_COHERENT,
           VXS_CONTACT_ORIGINAL),
    {"voxshell states, coherent, at most 4000 points", VXS_CONTACT_FASTEST, VXS_CONTACT_COHERENT,
     VXS_CONTACT_AVERAGE, false, 4000},
    distance("voxshell distance, brute, scalar", VXS_CONTACT_SCALAR, VXS_CONTACT_BRUTE),
    distance("voxshell distance, brute, AVX2", VXS_CONTACT_AVX2, VXS_CONTACT_BRUTE),
    distance("voxshell distance, brute, AVX-512", VXS_CONTACT_AVX512, VXS_CONTACT_BRUTE),
    distance("voxshell distance, coherent, AVX2", VXS_CONTACT_AVX2, VXS_CONTACT_COHERENT),
    distance("voxshell distance, coherent, AVX-512", VXS_CONTACT_AVX512, VXS_CONTACT_COHERENT),
};

/// Bytes as an open asset: written to a file, mapped as the servo loop maps it, and the name given up.
class OpenAsset {
  public:
    explicit OpenAsset(const std::vector<std::uint8_t> &bytes)
    {
        const TemporaryFolder folder;
        const auto path = folder.path / "asset";
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        vxs_asset_issue issue{};
        const vxs_result result = vxs_asset_open(path.c_str(), nullptr, &asset, &issue);
        if (result != VXS_OK)
            throw Failure(ExitCode::bug, "", issue.letter ? issue.text : vxs_result_text(result));
    }
    ~OpenAsset() { vxs_asset_close(&asset); }
    OpenAsset(const OpenAsset &) = delete;
    OpenAsset &operator=(const OpenAsset &) = delete;
    vxs_asset asset{};
};

/// The sphere's points as a shell, clusters of 64 in the order that they have.
std::vector<std::uint8_t> shell_bytes(const Points &points)
{
    PointshellFile file;
    Shell &shell = file.shell;
    const double area = 4 * std::numbers::pi * sphere_radius * sphere_radius / points.count;
    for (std::uint32_t i = 0; i < points.count; ++i) {
        shell.points.push_back({{points.x[i], points.y[i], points.z[i]},
                                {points.nx[i], points.ny[i], points.nz[i]},
                                static_cast<float>(area),
                                0,
                                0});
        shell.area += static_cast<double>(shell.points.back().area);
    }
    constexpr double rounding = 1 + 1e-6;
    for (std::uint32_t first = 0; first < points.count; first += VXS_POINTSHELL_CLUSTER_POINTS) {
        const std::uint32_t count =
            std::min<std::uint32_t>(VXS_POINTSHELL_CLUSTER_POINTS, points.count - first);
        Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
        for (std::uint32_t i = first; i < first + count; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                low[axis] = std::min<double>(low[axis], shell.points[i].position[axis]);
                high[axis] = std::max<double>(high[axis], shell.points[i].position[axis]);
            }
        Cluster cluster{{}, 0, first, count};
        for (std::size_t axis = 0; axis < 3; ++axis)
            cluster.center[axis] = static_cast<float>((low[axis] + high[axis]) / 2);
        double radius = 0;
        for (std::uint32_t i = first; i < first + count; ++i) {
            const auto &p = shell.points[i].position;
            radius = std::max<double>(radius, std::hypot(double{p[0]} - cluster.center[0],
                                                         double{p[1]} - cluster.center[1],
                                                         double{p[2]} - cluster.center[2]));
        }
        cluster.radius = static_cast<float>(radius * rounding);
        shell.clusters.push_back(cluster);
    }
    shell.kind = ShellKind::exact;
    shell.voxel = std::sqrt(area);
    shell.gap_max = 2 * shell.voxel;
    shell.radius = sphere_radius * rounding;
    shell.surface_cells = points.count;
    return pointshell_bytes(file);
}

class OurRival : public Rival {
  public:
    OurRival(const OurMode &mode, std::shared_ptr<const OurMap> map, const Points &points);
    Contact tick(const Pose &pose) override;
    double static_mib() const override { return mib_of(*map_); }

  private:
    std::shared_ptr<const OurMap> map_;
    OpenAsset shell_file_;
    vxs_pointshell shell_{};
    vxs_contact_config config_{};
    std::vector<std::uint8_t> memory_, levels_;
    vxs_contact *contact_ = nullptr;
};

} // namespace

class OurMap {
  public:
    explicit OurMap(const std::vector<std::uint8_t> &bytes) : file_(bytes)
    {
        vxs_voxmap_open(&file_.asset, &view);
    }
    double mib() const { return static_cast<double>(file_.asset.size) / (1 << 20); }
    vxs_voxmap view{};

  private:
    OpenAsset file_;
};

double mib_of(const OurMap &map)
{
    return map.mib();
}

std::vector<OurMode> our_modes()
{
    const OpenAsset file(shell_bytes(sphere_points(64)));
    vxs_pointshell shell;
    vxs_pointshell_open(&file.asset, &shell);
    std::vector<std::uint8_t> memory(vxs_contact_memory(&shell, 1));
    vxs_contact *contact = nullptr;
    vxs_contact_init(memory.data(), memory.size(), &shell, 1, &contact);
    std::vector<OurMode> there;
    for (const OurMode &mode : modes)
        if (vxs_contact_use(contact, mode.kernel) == VXS_OK) there.push_back(mode);
    return there;
}

std::shared_ptr<const OurMap> make_our_map(const Mesh &mesh, double voxel, bool distance)
{
    Progress silent;
    const LatticeMesh lattice = snap(mesh, voxel);
    const BrickTriangles binned = bin_triangles(lattice, silent);
    VoxmapFile file;
    file.cells = voxelize(lattice, binned, silent);
    const WindingNumber winding(mesh);
    classify(file.cells, winding, silent);
    if (distance) file.channels = make_channels(file.cells, lattice, binned, winding, true, {0, 3}, silent);
    return std::make_shared<OurMap>(voxmap_bytes(file));
}

namespace {

OurRival::OurRival(const OurMode &mode, std::shared_ptr<const OurMap> map, const Points &points)
    : map_(std::move(map)), shell_file_(shell_bytes(points))
{
    vxs_pointshell_open(&shell_file_.asset, &shell_);
    vxs_contact_config_default(&config_);
    config_.law = mode.law;
    if (mode.law == VXS_CONTACT_GRADIENT) config_.field = VXS_CONTACT_DISTANCE;
    config_.stiffness = 1;
    memory_.resize(vxs_contact_memory(&shell_, 1));
    if (vxs_contact_init(memory_.data(), memory_.size(), &shell_, 1, &contact_) != VXS_OK ||
        vxs_contact_use(contact_, mode.kernel) != VXS_OK ||
        vxs_contact_cull(contact_, mode.culling) != VXS_OK)
        throw Failure(ExitCode::unsupported, mode.name, "not on this processor");
    if (mode.most_points == 0) return;
    // Levels of detail weigh points by area: as stiff as one a point.
    config_.weighting = VXS_CONTACT_AREA;
    config_.stiffness = shell_.point_count / shell_.total_area;
    config_.most_points = mode.most_points;
    levels_.resize(vxs_contact_levels_memory(&shell_));
    if (vxs_contact_add_levels(contact_, levels_.data(), levels_.size()) != VXS_OK)
        throw Failure(ExitCode::bug, mode.name, "no levels of detail");
}

Contact OurRival::tick(const Pose &pose)
{
    vxs_pose place{};
    std::ranges::copy(pose.position, place.position);
    std::ranges::copy(pose.orientation, place.orientation);
    vxs_contact_result found;
    const vxs_contact_static fixed{&map_->view, nullptr};
    vxs_contact_evaluate(contact_, &fixed, 1, &place, &config_, &found);
    Contact contact;
    std::ranges::copy(found.wrench.force, contact.force.begin());
    std::ranges::copy(found.wrench.torque, contact.torque.begin());
    contact.depth = found.depth;
    contact.contacts = found.points;
    contact.touched = found.probed;
    return contact;
}

} // namespace

std::unique_ptr<Rival> make_our_rival(const OurMode &mode, std::shared_ptr<const OurMap> map,
                                      const Points &points)
{
    return std::make_unique<OurRival>(mode, std::move(map), points);
}

} // namespace voxshell::bench
