// SPDX-License-Identifier: GPL-3.0-or-later
// A simulated device by what people call it: sim:NAME, or
// sim:NAME,noise=20um,delay=3,loss=1%,loss-time=20ms,seed=7.
#pragma once

#include "voxshell/simulated.h"

#include <string>

namespace voxshell {

/// At a rate (0: its own). noise: standard deviation of each axis as measured (a length); delay: samples
/// before a command acts, 1 .. 64; loss: share of samples in which neither side hears the other, 0% .. 90%;
/// loss-time: of each such drop-out, 0s .. 10s; seed: of both, a whole number. Throws Failure(usage): no such
/// device, with the names there are; an option that is none, doubled, or out of range.
vxs_simulated_config simulated_device(const std::string &name, double rate = 0);

} // namespace voxshell
