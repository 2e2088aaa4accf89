// SPDX-License-Identifier: GPL-3.0-or-later
// Free or interior: 6-connected components of the cells that are not surface, decided by winding number.
#pragma once

#include "cli/progress.hpp"
#include "mesh/winding.hpp"
#include "voxmap/cells.hpp"

#include <optional>

namespace voxshell {

struct Leak {
    Point at{}; ///< centre of an outside cell with winding >= 1/2 in magnitude [m]
    double winding = 0;
    std::uint64_t cells = 0; ///< sampled outside cells that say so
};

struct Classification {
    std::uint64_t components = 0; ///< components that do not reach the outside
    std::uint64_t cavities = 0;   ///< of these, free
    std::optional<Leak> leak;     ///< the outside component holds cells of winding >= 1/2
};

/// Fills interior into `cells` (method section 1): a component that does not reach the outside is
/// interior where |winding| >= 1/2 at one of its cell centres. Memory follows the surface: columns
/// without a surface cell are outside. Deterministic for any thread count.
Classification classify(Cells &cells, const WindingNumber &winding, Progress &progress);

/// The remedy for a leaking part: as classify(), but the outside may not pass a gap narrower than `gap` [m].
/// The surface is thickened by gap / 2 (rounded up to cells) for the flood alone; a cell that only the
/// thickening covered is interior where its winding is >= 1/2. Surface cells stay as they are. Throws
/// Failure(usage) for more than 64 cells.
Classification classify_closing(Cells &cells, const WindingNumber &winding, double gap, Progress &progress);

} // namespace voxshell
