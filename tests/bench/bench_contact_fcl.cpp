// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh against mesh: FCL, trees of oriented boxes (OBBRSS), every contact. bench_contact_fcl < JOBS
// (contact_rival.hpp).
#include "contact_rival.hpp"

#include <fcl/fcl.h>

using namespace voxshell;
using namespace voxshell::bench;

namespace {

using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> make_model(const Mesh &mesh)
{
    std::vector<fcl::Vector3d> vertices;
    std::vector<fcl::Triangle> triangles;
    for (const auto &v : mesh.vertices) vertices.emplace_back(v[0], v[1], v[2]);
    for (const auto &t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto model = std::make_shared<Model>();
    model->beginModel();
    model->addSubModel(vertices, triangles);
    model->endModel();
    return model;
}

class FclRival : public Rival {
  public:
    FclRival(std::shared_ptr<const Model> fixed, std::uint32_t triangles)
        : fixed_(std::move(fixed)), moving_(make_model(sphere_mesh(triangles))), request_(1000000, true)
    {
    }
    Contact tick(const Pose &pose) override
    {
        fcl::Transform3d at = fcl::Transform3d::Identity();
        at.translation() = fcl::Vector3d(pose.position[0], pose.position[1], pose.position[2]);
        at.linear() = fcl::Quaterniond(pose.orientation[0], pose.orientation[1], pose.orientation[2],
                                       pose.orientation[3])
                          .toRotationMatrix();
        fcl::CollisionResultd result;
        fcl::collide(fixed_.get(), fcl::Transform3d::Identity(), moving_.get(), at, request_, result);
        Contact contact;
        contact.contacts = result.numContacts();
        for (std::size_t i = 0; i < result.numContacts(); ++i)
            contact.depth = std::max(contact.depth, result.getContact(i).penetration_depth);
        return contact;
    }
    double static_mib() const override // its own memUsage() only prints
    {
        const std::size_t bytes =
            sizeof(fcl::BVNode<fcl::OBBRSSd>) * static_cast<std::size_t>(fixed_->getNumBVs()) +
            sizeof(fcl::Triangle) * static_cast<std::size_t>(fixed_->num_tris) +
            sizeof(fcl::Vector3d) * static_cast<std::size_t>(fixed_->num_vertices);
        return static_cast<double>(bytes) / (1 << 20);
    }

  private:
    std::shared_ptr<const Model> fixed_;
    std::shared_ptr<Model> moving_;
    fcl::CollisionRequestd request_;
};

} // namespace

int main(int argc, char **argv)
{
    std::shared_ptr<Model> cup;
    return run_rivals(argc, argv, {{"FCL, OBBRSS", Kind::mesh, [&](const Job &job, const Points &) {
                                        if (!cup) cup = make_model(static_mesh(job.motion));
                                        return std::make_unique<FclRival>(cup, job.size);
                                    }}});
}
