// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/compare.hpp"

#include "cli/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace voxshell {
namespace {

double distance(const ShellPoint &a, const ShellPoint &b)
{
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double d = double{a.position[axis]} - double{b.position[axis]};
        sum += d * d;
    }
    return std::sqrt(sum);
}

double angle(const ShellPoint &a, const ShellPoint &b) // degrees
{
    double dot = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) dot += double{a.normal[axis]} * double{b.normal[axis]};
    return std::acos(std::clamp(dot, -1.0, 1.0)) * 180 / 3.14159265358979323846;
}

auto value_of(const ShellPoint &p)
{
    return std::tie(p.position, p.normal, p.area);
}

/// The points of a shell in the order of the cells that they lie in.
class PointsByCell {
  public:
    PointsByCell(const Shell &shell, double edge) : edge_(edge)
    {
        for (const ShellPoint &point : shell.points) sorted_.push_back({cell_of(point), &point});
        std::sort(sorted_.begin(), sorted_.end(), [](const Entry &a, const Entry &b) {
            return a.cell != b.cell ? a.cell < b.cell : value_of(*a.point) < value_of(*b.point);
        });
    }

    struct Entry {
        Cell cell;
        const ShellPoint *point;
    };
    const std::vector<Entry> &sorted() const { return sorted_; }

    /// Distance to the nearest point in the cell of `p` and those around it, infinity where there is none.
    double nearest(const ShellPoint &p) const
    {
        double best = std::numeric_limits<double>::infinity();
        const Cell at = cell_of(p);
        for (std::int64_t i = -1; i <= 1; ++i)
            for (std::int64_t j = -1; j <= 1; ++j) {
                const Cell first{at[0] + i, at[1] + j, at[2] - 1}, last{at[0] + i, at[1] + j, at[2] + 1};
                auto entry = std::lower_bound(sorted_.begin(), sorted_.end(), first,
                                              [](const Entry &e, const Cell &cell) { return e.cell < cell; });
                for (; entry != sorted_.end() && entry->cell <= last; ++entry)
                    best = std::min(best, distance(p, *entry->point));
            }
        return best;
    }

  private:
    Cell cell_of(const ShellPoint &p) const
    {
        Cell cell{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            cell[axis] = static_cast<std::int64_t>(std::floor(double{p.position[axis]} / edge_));
        return cell;
    }

    double edge_;
    std::vector<Entry> sorted_;
};

class PointComparison {
  public:
    PointComparison(const PointshellFile &a, const PointshellFile &b, double tolerance, Comparison &out)
        : edge_(std::max(a.shell.voxel, tolerance)), a_(a.shell, edge_), b_(b.shell, edge_),
          tolerance_(tolerance), out_(out)
    {
    }

    void run()
    {
        if (tolerance_ > 0) {
            one_sided(a_, b_, "has no counterpart in B");
            one_sided(b_, a_, "has no counterpart in A");
        } else {
            exact();
        }
    }

  private:
    void one_sided(const PointsByCell &from, const PointsByCell &to, const char *what)
    {
        for (const auto &entry : from.sorted())
            if (const double moved = to.nearest(*entry.point); moved > tolerance_)
                change(*entry.point, moved, what);
    }

    void exact()
    {
        auto a = a_.sorted().begin(), b = b_.sorted().begin();
        const auto end_a = a_.sorted().end(), end_b = b_.sorted().end();
        while (a != end_a || b != end_b) {
            const bool in_a = a != end_a && (b == end_b || a->cell <= b->cell);
            const bool in_b = b != end_b && (a == end_a || b->cell <= a->cell);
            if (in_a && in_b) {
                if (value_of(*a->point) != value_of(*b->point)) moved(*a->point, *b->point);
            } else if (in_a) {
                change(*a->point, b_.nearest(*a->point), "only in A");
            } else {
                change(*b->point, a_.nearest(*b->point), "only in B");
            }
            a += in_a;
            b += in_b;
        }
    }

    void moved(const ShellPoint &a, const ShellPoint &b)
    {
        const double by = distance(a, b);
        std::string what;
        if (by > 0) what = "moved " + format_length(by);
        if (a.normal != b.normal)
            what += fmt::format("{}normal turned {:.3g} degrees", what.empty() ? "" : ", ", angle(a, b));
        if (a.area != b.area)
            what += fmt::format("{}area {:.6g} -> {:.6g} m2", what.empty() ? "" : ", ", a.area, b.area);
        change(a, by, what);
    }

    void change(const ShellPoint &at, double by, const std::string &what)
    {
        ++out_.changed;
        if (!std::isfinite(by)) {
            out_.largest_is_bound = true;
            by = edge_;
        }
        out_.largest = std::max(out_.largest, by);
        if (out_.first.size() < 10)
            out_.first.push_back({{at.position[0], at.position[1], at.position[2]}, what});
    }

    const double edge_; // of the cells that points are sorted by
    const PointsByCell a_, b_;
    const double tolerance_;
    Comparison &out_;
};

} // namespace

Comparison compare(const PointshellFile &a, const PointshellFile &b, double tolerance)
{
    Comparison out;
    out.noun = "points";
    const auto differ = [&out](const char *what, const std::string &left, const std::string &right) {
        if (left != right) out.structure.push_back({what, left, right});
    };
    const auto kind = [](const Shell &shell) { return shell.kind == ShellKind::exact ? "exact" : "naive"; };
    differ("voxel", fmt::format("{} m", a.shell.voxel), fmt::format("{} m", b.shell.voxel));
    differ("kind of shell", kind(a.shell), kind(b.shell));
    if (!(tolerance > 0)) {
        differ("points", format_count(a.shell.points.size()), format_count(b.shell.points.size()));
        differ("clusters", format_count(a.shell.clusters.size()), format_count(b.shell.clusters.size()));
    }
    differ("areas of points", a.areas ? "stored" : "none", b.areas ? "stored" : "none");
    if (a.source_hash != b.source_hash) out.notes.push_back("made from different sources");
    if (a.meta != b.meta)
        out.notes.push_back("made with different options or version: " + a.meta + " / " + b.meta);
    out.compared = a.shell.voxel == b.shell.voxel;
    if (!out.compared) return out;
    if (a.areas == b.areas) {
        PointComparison(a, b, tolerance, out).run();
        return out;
    }
    PointshellFile left = a, right = b; // what one has not got is not compared
    for (PointshellFile *file : {&left, &right})
        for (ShellPoint &point : file->shell.points) point.area = 0;
    PointComparison(left, right, tolerance, out).run();
    return out;
}

} // namespace voxshell
