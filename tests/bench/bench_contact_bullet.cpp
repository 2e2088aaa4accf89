// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh against mesh: Bullet's btGImpact. bench_contact_bullet < JOBS (contact_rival.hpp). Its numbers are
// single precision and meant for metres: it gets millimetres.
#include "contact_rival.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

using namespace voxshell;
using namespace voxshell::bench;

namespace {

constexpr double unit = 1e-3; ///< [m] per Bullet's length

/// A mesh, its tree, and the object that carries them.
class Body {
  public:
    explicit Body(const Mesh &mesh)
    {
        for (const auto &v : mesh.vertices)
            for (const double x : v) vertices_.push_back(static_cast<btScalar>(x / unit));
        for (const auto &t : mesh.triangles)
            for (const std::uint32_t v : t) indices_.push_back(static_cast<int>(v));
        array_ = std::make_unique<btTriangleIndexVertexArray>(
            static_cast<int>(mesh.triangles.size()), indices_.data(), 3 * static_cast<int>(sizeof(int)),
            static_cast<int>(mesh.vertices.size()), vertices_.data(), 3 * static_cast<int>(sizeof(btScalar)));
        shape_ = std::make_unique<btGImpactMeshShape>(array_.get());
        shape_->setMargin(0);
        shape_->updateBound();
        object.setCollisionShape(shape_.get());
    }
    /// What its triangles and boxes take: 16 bytes of box and index, twice as many nodes as triangles.
    double mib() const
    {
        const std::size_t triangles = indices_.size() / 3;
        return static_cast<double>(vertices_.size() * sizeof(btScalar) + indices_.size() * sizeof(int) +
                                   2 * triangles * sizeof(BT_QUANTIZED_BVH_NODE)) /
               (1 << 20);
    }
    btCollisionObject object;

  private:
    std::vector<btScalar> vertices_;
    std::vector<int> indices_;
    std::unique_ptr<btTriangleIndexVertexArray> array_;
    std::unique_ptr<btGImpactMeshShape> shape_;
};

/// Keeps what the algorithm finds: count and depth of all contacts, as the others do.
class AllContacts : public btManifoldResult {
  public:
    AllContacts(const btCollisionObjectWrapper *a, const btCollisionObjectWrapper *b) : btManifoldResult(a, b)
    {
    }
    void addContactPoint(const btVector3 &, const btVector3 &, btScalar depth) override
    {
        ++contact.contacts;
        contact.depth = std::max(contact.depth, -static_cast<double>(depth) * unit);
    }
    Contact contact;
};

class BulletRival : public Rival {
  public:
    BulletRival(std::shared_ptr<const Body> fixed, std::uint32_t triangles)
        : fixed_(std::move(fixed)), moving_(sphere_mesh(triangles)), dispatcher_(&configuration_)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
        const btCollisionObjectWrapper a = wrapper(fixed_->object), b = wrapper(moving_.object);
        algorithm_ = dispatcher_.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    }
    ~BulletRival() override
    {
        algorithm_->~btCollisionAlgorithm();
        dispatcher_.freeCollisionAlgorithm(algorithm_);
    }
    Contact tick(const Pose &pose) override
    {
        const auto length = [](double x) { return static_cast<btScalar>(x / unit); };
        const auto number = [](double x) { return static_cast<btScalar>(x); };
        const auto &q = pose.orientation;
        moving_.object.setWorldTransform(btTransform(
            btQuaternion(number(q[1]), number(q[2]), number(q[3]), number(q[0])),
            btVector3(length(pose.position[0]), length(pose.position[1]), length(pose.position[2]))));
        const btCollisionObjectWrapper a = wrapper(fixed_->object), b = wrapper(moving_.object);
        AllContacts found(&a, &b);
        algorithm_->processCollision(&a, &b, info_, &found);
        return found.contact;
    }
    double static_mib() const override { return fixed_->mib(); }

  private:
    static btCollisionObjectWrapper wrapper(const btCollisionObject &object)
    {
        return {nullptr, object.getCollisionShape(), &object, object.getWorldTransform(), -1, -1};
    }
    std::shared_ptr<const Body> fixed_;
    Body moving_;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDispatcherInfo info_;
    btCollisionAlgorithm *algorithm_;
};

} // namespace

int main(int argc, char **argv)
{
    std::shared_ptr<Body> cup;
    return run_rivals(argc, argv, {{"Bullet btGImpact", Kind::mesh, [&](const Job &job, const Points &) {
                                        if (!cup) cup = std::make_shared<Body>(static_mesh(job.motion));
                                        return std::make_unique<BulletRival>(cup, job.size);
                                    }}});
}
