// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of assemblies between the planning of their parts and the work on them.
#pragma once

#include "import/scene.hpp"

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>

namespace voxshell {

/// Keeps the scenes that were asked for last, up to `limit` bytes but always one; others are read again when
/// they are wanted. Any thread.
class SceneShelf {
  public:
    explicit SceneShelf(std::uint64_t limit) : limit_(limit) {}

    /// The scene of that number, which `read` gives where it is not here.
    std::shared_ptr<const Scene> get(std::size_t number, const std::function<Scene()> &read);
    void drop(std::size_t number); ///< nobody will ask for it again
    std::uint64_t bytes() const { return bytes_; }

  private:
    struct Kept {
        std::size_t number;
        std::uint64_t bytes;
        std::shared_ptr<const Scene> scene;
    };
    std::mutex mutex_;     ///< held while one is read: who wants the same waits for it
    std::list<Kept> kept_; ///< the last used first
    const std::uint64_t limit_;
    std::uint64_t bytes_ = 0;
};

} // namespace voxshell
