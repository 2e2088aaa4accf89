// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh against mesh: Coal (once HPP-FCL), trees of oriented boxes (OBBRSS), every contact.
// bench_contact_coal < JOBS (contact_rival.hpp). Its break distance, 1 mm unless told, opens every pair of
// boxes that near: with 1 um it looks only at what touches.
#include "contact_rival.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/collision.h>

using namespace voxshell;
using namespace voxshell::bench;

namespace {

using Model = coal::BVHModel<coal::OBBRSS>;

std::shared_ptr<Model> make_model(const Mesh &mesh)
{
    std::vector<coal::Vec3s> vertices;
    std::vector<coal::Triangle> triangles;
    for (const auto &v : mesh.vertices) vertices.emplace_back(v[0], v[1], v[2]);
    for (const auto &t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto model = std::make_shared<Model>();
    model->beginModel();
    model->addSubModel(vertices, triangles);
    model->endModel();
    return model;
}

class CoalRival : public Rival {
  public:
    CoalRival(std::shared_ptr<const Model> fixed, std::uint32_t triangles, double break_distance)
        : fixed_(std::move(fixed)), moving_(make_model(sphere_mesh(triangles))),
          request_(coal::CONTACT, 1000000)
    {
        if (break_distance > 0) request_.break_distance = break_distance;
    }
    Contact tick(const Pose &pose) override
    {
        const coal::Transform3s at(
            coal::Quatf(pose.orientation[0], pose.orientation[1], pose.orientation[2], pose.orientation[3]),
            coal::Vec3s(pose.position[0], pose.position[1], pose.position[2]));
        coal::CollisionResult result;
        coal::collide(fixed_.get(), coal::Transform3s(), moving_.get(), at, request_, result);
        Contact contact;
        contact.contacts = result.numContacts();
        for (std::size_t i = 0; i < result.numContacts(); ++i)
            contact.depth = std::max(contact.depth, -result.getContact(i).penetration_depth);
        return contact;
    }
    double static_mib() const override { return static_cast<double>(fixed_->memUsage(false)) / (1 << 20); }

  private:
    std::shared_ptr<const Model> fixed_;
    std::shared_ptr<Model> moving_;
    coal::CollisionRequest request_;
};

} // namespace

int main(int argc, char **argv)
{
    std::shared_ptr<Model> cup;
    const auto row = [&](const char *name, double break_distance) {
        return RivalRow{name, Kind::mesh, [&, break_distance](const Job &job, const Points &) {
                            if (!cup) cup = make_model(static_mesh(job.motion));
                            return std::make_unique<CoalRival>(cup, job.size, break_distance);
                        }};
    };
    return run_rivals(argc, argv,
                      {row("Coal, OBBRSS, break distance 1 um", 1e-6), row("Coal, OBBRSS, as it comes", 0)});
}
