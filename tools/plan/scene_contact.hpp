// SPDX-License-Identifier: GPL-3.0-or-later
// What the scene's assets tell of its contact: how stiff it gets, and what its hand pushes against.
#pragma once

#include "plan/scene_coupling.hpp"
#include "scene/scene_file.hpp"

#include "voxshell/contact.h"
#include "voxshell/pointshell.h"
#include "voxshell/voxmap.h"

namespace voxshell {

vxs_pose as_runtime(const Pose &pose);

/// The scene's law, field, weighting and stiffness, checked. Throws Failure(invalid).
vxs_contact_config contact_of(const SceneFile &scene);

/// How stiff the scene's contact gets: what its most_stiffness bounds it to, else the largest eigenvalue
/// (contact.h) on the hand's path, where the device would go if nothing held it: deeper than it ever gets.
/// Throws Failure(invalid) if that touches nothing.
ContactStiffness contact_stiffness(const SceneFile &scene, const vxs_voxmap &map,
                                   const vxs_pointshell &shell);

/// The hand's path where contact begins to push (the first 32 times, not where it only turns): straight on
/// from there, as far as cells are in the way of the points that touch, with the scene's contact in between.
/// Walls are known to a cell, their middles to half a cell. None if the path touches nothing.
std::vector<Push> pushes(const SceneFile &scene, const vxs_voxmap &map, const vxs_pointshell &shell);

/// Both, of these assets, which must outlive it.
SceneContact scene_contact(const SceneFile &scene, const vxs_voxmap &map, const vxs_pointshell &shell);

} // namespace voxshell
