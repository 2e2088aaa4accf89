// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/scene_shelf.hpp"

#include <algorithm>

namespace voxshell {
namespace {

std::uint64_t size_of(const Scene &scene)
{
    std::uint64_t bytes = scene.instances.size() * sizeof(Instance) + scene.nodes.size() * sizeof(SceneNode);
    for (const Mesh &mesh : scene.meshes)
        bytes += mesh.vertices.size() * sizeof(Point) + mesh.triangles.size() * sizeof(Triangle);
    return bytes;
}

} // namespace

std::shared_ptr<const Scene> SceneShelf::get(std::size_t number, const std::function<Scene()> &read)
{
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(kept_.begin(), kept_.end(), [&](const Kept &each) { return each.number == number; });
    if (found != kept_.end()) {
        kept_.splice(kept_.begin(), kept_, found);
        return kept_.front().scene;
    }
    auto scene = std::make_shared<const Scene>(read());
    kept_.push_front({number, size_of(*scene), scene});
    bytes_ += kept_.front().bytes;
    while (bytes_ > limit_ && kept_.size() > 1) {
        bytes_ -= kept_.back().bytes;
        kept_.pop_back();
    }
    return scene;
}

void SceneShelf::drop(std::size_t number)
{
    const std::lock_guard lock(mutex_);
    std::erase_if(kept_, [&](const Kept &each) {
        if (each.number == number) bytes_ -= each.bytes;
        return each.number == number;
    });
}

} // namespace voxshell
