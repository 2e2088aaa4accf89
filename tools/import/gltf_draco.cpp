// SPDX-License-Identifier: GPL-3.0-or-later
// Draco payloads. The library bounds what it reads but allocates what the payload claims, so the claims
// (Draco bitstream specification, "Header", "Metadata", "Connectivity") are read first. What it counts deeper in a
// payload nobody can see before: it works behind a fence (gltf_draco_fence.cpp).
#include "import/gltf_draco.hpp"
#include "fence/fence.hpp"

#include <cstring>
#include <fmt/core.h>

namespace voxshell {
namespace {

struct Claims {
    std::uint64_t faces = 0, points = 0;
};

/// Little-endian reader that turns false once and for all when the bytes end.
class Cursor {
  public:
    explicit Cursor(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    bool ok() const { return ok_; }
    void skip(std::uint64_t n)
    {
        ok_ = ok_ && n <= bytes_.size();
        if (ok_) bytes_ = bytes_.subspan(n);
    }
    std::uint64_t fixed(std::size_t n)
    {
        ok_ = ok_ && n <= bytes_.size();
        std::uint64_t x = 0;
        for (std::size_t i = 0; ok_ && i < n; ++i) x |= std::uint64_t{bytes_[i]} << 8 * i;
        skip(n);
        return x;
    }
    std::uint64_t varint()
    {
        std::uint64_t x = 0;
        for (int shift = 0; shift < 63; shift += 7) {
            const std::uint64_t byte = fixed(1);
            x |= (byte & 0x7f) << shift;
            if (!(byte & 0x80)) return x;
        }
        ok_ = false;
        return 0;
    }

  private:
    std::span<const std::uint8_t> bytes_;
    bool ok_ = true;
};

/// Metadata: entries, then the number of named children, which follow one after the other in the same form.
void skip_metadata(Cursor &in)
{
    bool named = false;
    for (std::uint64_t pending = 1; pending > 0 && in.ok(); --pending) {
        if (named) in.skip(in.fixed(1));
        named = true;
        for (std::uint64_t entries = in.varint(); entries > 0 && in.ok(); --entries) {
            in.skip(in.fixed(1)); // name
            in.skip(in.varint()); // value
        }
        pending += in.varint();
    }
}

std::optional<Claims> read_claims(std::span<const std::uint8_t> payload)
{
    Cursor in(payload);
    in.skip(5); // "DRACO"
    const std::uint64_t major = in.fixed(1), minor = in.fixed(1), type = in.fixed(1), method = in.fixed(1),
                        flags = in.fixed(2);
    const std::uint64_t version = major << 8 | minor;
    if (!in.ok() || type != 1 || method > 1) return {};
    if (flags & 0x8000) {
        for (std::uint64_t n = in.varint(); n > 0 && in.ok(); --n) {
            in.varint(); // attribute id
            skip_metadata(in);
        }
        skip_metadata(in);
    }
    Claims claims;
    if (method == 1) {                                                    // edgebreaker
        in.skip(1);                                                       // traversal
        if (version < 0x202) version < 0x200 ? in.fixed(4) : in.varint(); // new vertices
        version < 0x200 ? in.fixed(4) : in.varint(); // corner table's vertices, at most 3 a face
        claims.faces = version < 0x200 ? in.fixed(4) : in.varint();
    } else { // sequential
        claims.faces = version < 0x202 ? in.fixed(4) : in.varint();
        claims.points = version < 0x202 ? in.fixed(4) : in.varint();
    }
    if (!in.ok()) return {};
    return claims;
}

} // namespace

DracoMesh receive_draco(Answers &answers, bool has_position, std::uint64_t max_faces,
                        std::uint64_t max_points)
{
    const auto refuse = [](const std::string &what) { throw Failure(ExitCode::invalid, "", what); };
    DracoAnswer answer{};
    if (!answers.read(&answer, sizeof answer)) refuse(answers.obituary());
    if (answer.text > 1000) refuse("Draco's reader sent nonsense");
    DracoMesh out;
    std::string text;
    if (!answers.read_text(text, answer.text)) refuse(answers.obituary());
    if (!text.empty()) refuse(printable(text, 200));
    if (answer.points > max_points) refuse("more vertices than the accessor declares");
    if (answer.faces > max_faces) refuse("more triangles than the accessor declares");
    if (answer.positions != (has_position ? answer.points : 0)) refuse("Draco's reader sent nonsense");
    out.point_count = answer.points;
    if (!answers.read_list(out.points, answer.positions) || !answers.read_list(out.faces, answer.faces))
        refuse(answers.obituary());
    for (const Triangle &face : out.faces)
        for (const std::uint32_t v : face)
            if (v >= out.point_count) refuse("damaged payload: an index beyond the vertices");
    return out;
}

DracoMesh DracoReader::decode(std::span<const std::uint8_t> payload, std::optional<std::uint32_t> position,
                              std::uint64_t max_faces, std::uint64_t max_points, const std::string &where)
{
    if (payload.size() < 5 || std::memcmp(payload.data(), "DRACO", 5) != 0)
        source_.invalid(where + ": not a Draco payload");
    const std::optional<Claims> claims = read_claims(payload);
    if (!claims) source_.invalid(where + ": not a Draco mesh, or cut");
    // A good encoder reaches about 1/2 byte a triangle; flat regular grids much less.
    const std::uint64_t plausible = (std::uint64_t{1} << 16) + 1024 * std::uint64_t{payload.size()};
    if (claims->faces > max_faces || claims->points > max_points || claims->faces > plausible ||
        claims->points > plausible) {
        source_.invalid(
            fmt::format("{}: claims {} triangles and {} vertices, the accessors {} and {}, in {} bytes",
                        where, claims->faces, claims->points, max_faces, max_points, payload.size()));
    }

    try {
        return ask(payload, position, max_faces, max_points);
    } catch (const Failure &failure) {
        source_.refuse(failure.code, where + ": " + failure.what());
    }
}

} // namespace voxshell
