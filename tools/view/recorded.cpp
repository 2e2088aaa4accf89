// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/recorded.hpp"

#include "import/importers.hpp"
#include "voxshell/servo.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

namespace voxshell {
namespace {

constexpr std::string_view recording = "VXSREC01";

/// Rows one by one; of each `stride` the one of most force is kept.
class Thinned {
  public:
    Thinned(Recorded &out, std::size_t rows)
        : out_(out), stride_((rows + Recorded::most_rows - 1) / Recorded::most_rows)
    {
        out_.of = rows;
    }
    void add(const Moment &moment)
    {
        const double force = std::max(length(moment.collision_force), length(moment.output_force));
        if (n_++ % stride_ == 0) {
            out_.rows.push_back(moment);
        } else if (force > most_) {
            out_.rows.back() = moment;
        } else {
            return;
        }
        most_ = force;
    }

  private:
    Recorded &out_;
    std::size_t stride_, n_ = 0;
    double most_ = 0;
};

Pose pose_of(const vxs_pose &pose)
{
    const auto &q = pose.orientation;
    const double size = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
    Pose out{{pose.position[0], pose.position[1], pose.position[2]}, {0, 0, 0, 1}};
    if (size > 0) out.rotation = {q[1] / size, q[2] / size, q[3] / size, q[0] / size};
    return out;
}

Point vector_of(const double (&v)[3])
{
    return {v[0], v[1], v[2]};
}

bool finite(const Moment &m)
{
    bool all = std::isfinite(m.t);
    for (const double x : m.body.rotation) all = all && std::isfinite(x);
    for (const Point *p :
         {&m.body.position, &m.device, &m.hand, &m.collision_force, &m.collision_torque, &m.output_force})
        for (const double x : *p) all = all && std::isfinite(x);
    return all;
}

void read_rows(const std::string &name, std::span<const std::uint8_t> bytes, Recorded &out)
{
    std::uint32_t size = 0;
    if (bytes.size() >= 16) std::memcpy(&size, bytes.data() + 8, sizeof size);
    if (size != sizeof(vxs_servo_trace) || (bytes.size() - 16) % size != 0)
        throw Failure(ExitCode::invalid, name, "is no whole recording of this version (recorder.h)");
    const std::size_t rows = (bytes.size() - 16) / size;
    Thinned thinned(out, rows);
    vxs_servo_trace row, first{};
    for (std::size_t n = 0; n < rows; ++n) {
        std::memcpy(&row, bytes.data() + 16 + n * size, size);
        if (n == 0) first = row;
        Moment m;
        m.t = 1e-9 * (static_cast<double>(row.time_ns) - static_cast<double>(first.time_ns));
        // A tick without contact's stage has no body: what the device holds stands where the device is.
        const bool no_body =
            std::all_of(row.body.orientation, row.body.orientation + 4, [](double x) { return x == 0; });
        m.body = pose_of(no_body ? row.pose : row.body);
        m.device = m.hand = vector_of(row.pose.position);
        m.collision_force = vector_of(row.collision.force);
        m.collision_torque = vector_of(row.collision.torque);
        m.output_force = vector_of(row.command.force);
        m.contacts = row.points;
        if (!finite(m)) throw Failure(ExitCode::invalid, name, fmt::format("row {} is not finite", n + 1));
        thinned.add(m);
    }
}

/// The lines of a text without their ends; a last one without an end counts.
template<typename Take>
void for_each_line(std::string_view text, Take &&take)
{
    for (std::size_t line = 1; !text.empty(); ++line) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view one = text.substr(0, end);
        if (!one.empty() && one.back() == '\r') one.remove_suffix(1);
        if (!one.empty()) take(line, one);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
}

/// Where in a Moment each column of a trace goes.
std::vector<double *> columns(std::string_view head, Moment &moment, double &contacts,
                              const std::string &name)
{
    std::vector<std::pair<std::string, double *>> known{{"t_s", &moment.t}, {"contacts", &contacts}};
    const auto vector = [&](const char *format, Point &p) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            known.emplace_back(fmt::format(fmt::runtime(format), "xyz"[axis]), &p[axis]);
    };
    vector("device_{}_m", moment.device);
    vector("hand_{}_m", moment.hand);
    vector("body_{}_m", moment.body.position);
    vector("collision_f{}_n", moment.collision_force);
    vector("collision_t{}_nm", moment.collision_torque);
    vector("output_f{}_n", moment.output_force);
    std::vector<double *> out;
    while (true) {
        const std::size_t comma = head.find(',');
        const auto found = std::ranges::find(known, head.substr(0, comma),
                                             [](const auto &k) { return std::string_view(k.first); });
        out.push_back(found == known.end() ? nullptr : found->second);
        if (found != known.end()) known.erase(found);
        if (comma == head.npos) break;
        head.remove_prefix(comma + 1);
    }
    if (!known.empty())
        throw Failure(
            ExitCode::invalid, name,
            fmt::format("is no trace of voxshell simulate --trace: it has no column {}", known[0].first));
    return out;
}

void read_lines(const std::string &name, std::string_view text, const HandPath *hand, Recorded &out)
{
    std::size_t rows = 0;
    for_each_line(text, [&](std::size_t, std::string_view) { ++rows; });
    if (rows == 0) throw Failure(ExitCode::invalid, name, "is empty");
    Thinned thinned(out, rows - 1);
    Moment moment;
    double contacts = 0;
    std::vector<double *> into;
    for_each_line(text, [&](std::size_t line, std::string_view one) {
        if (into.empty()) {
            into = columns(one, moment, contacts, name);
            return;
        }
        std::size_t column = 0;
        const char *at = one.data(), *const end = at + one.size();
        for (;; ++column, ++at) {
            double value = 0;
            const auto [next, error] = std::from_chars(at, end, value);
            if (column == into.size() || error != std::errc{} || !std::isfinite(value) ||
                (next != end && *next != ','))
                break;
            if (into[column]) *into[column] = value;
            at = next;
            if (at == end) break;
        }
        if (at != end || column + 1 != into.size())
            throw Failure(ExitCode::invalid, name,
                          fmt::format("line {} is not {} finite numbers", line, into.size()));
        moment.contacts = static_cast<std::uint32_t>(std::clamp(contacts, 0.0, 4294967295.0));
        if (hand) moment.body.rotation = hand->at(moment.t).rotation;
        thinned.add(moment);
    });
}

} // namespace

Recorded read_recorded(const std::filesystem::path &path, const HandPath *hand)
{
    const std::string name = path.string();
    const Bytes bytes = read_whole_file(path, name);
    Recorded out;
    out.source = path.filename().string();
    const std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    if (text.starts_with(recording))
        read_rows(name, bytes, out);
    else
        read_lines(name, text, hand, out);
    if (out.rows.empty()) throw Failure(ExitCode::invalid, name, "has no row");
    for (std::size_t n = 1; n < out.rows.size(); ++n) {
        if (out.rows[n].t < out.rows[n - 1].t)
            throw Failure(ExitCode::invalid, name, fmt::format("time goes back at {} s", out.rows[n].t));
    }
    return out;
}

Pose on_the_way(const std::vector<Stop> &stops, double t)
{
    const auto next = std::ranges::upper_bound(stops, t, {}, &Stop::t);
    if (next == stops.begin()) return stops.front().pose;
    if (next == stops.end()) return stops.back().pose;
    const Stop &a = next[-1], &b = *next;
    const double share = (t - a.t) / (b.t - a.t);
    double same = 0, size = 0;
    for (std::size_t n = 0; n < 4; ++n) same += a.pose.rotation[n] * b.pose.rotation[n];
    Pose out;
    for (std::size_t n = 0; n < 3; ++n)
        out.position[n] = (1 - share) * a.pose.position[n] + share * b.pose.position[n];
    for (std::size_t n = 0; n < 4; ++n) {
        out.rotation[n] = (1 - share) * a.pose.rotation[n] + (same < 0 ? -share : share) * b.pose.rotation[n];
        size += out.rotation[n] * out.rotation[n];
    }
    for (double &x : out.rotation) x /= std::sqrt(size);
    return out;
}

Recorded planned(const HandPath &hand, double end)
{
    Recorded out;
    out.source = "the hand's path";
    out.forces = false;
    const auto steps = static_cast<std::size_t>(std::clamp(std::ceil(100 * end), 100.0, 20000.0 - 1));
    for (std::size_t n = 0; n <= steps; ++n) {
        Moment m;
        m.t = end * static_cast<double>(n) / static_cast<double>(steps);
        m.body = hand.at(m.t);
        m.device = m.hand = m.body.position;
        out.rows.push_back(m);
    }
    out.of = out.rows.size();
    return out;
}

} // namespace voxshell
