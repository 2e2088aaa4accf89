// SPDX-License-Identifier: GPL-3.0-or-later
// The two processes of the Draco reader, and what the parent believes of the child.
#include "fence/fence.hpp"
#include "import/gltf_draco.hpp"

namespace voxshell {
namespace {

struct Question {
    std::uint64_t bytes, has_position, position, max_points;
    FenceLimits limits;
};

/// Sixteen bytes a vertex and twelve a face of the result, some two hundred a face while the library works;
/// what is in proportion to nothing in the payload gets little.
FenceLimits limits_of(std::uint64_t elements, std::uint64_t bytes)
{
    const std::uint64_t memory = std::min(1024 * elements, (std::uint64_t{1} << 29) + 8192 * bytes);
    return {(std::uint64_t{1} << 28) + memory, 1 + bytes / 20'000};
}

/// In the child: one payload after the other.
bool answer_draco(Fenced &parent)
{
    Question question;
    while (parent.read(&question, sizeof question)) {
        parent.limit(question.limits);
        DracoAnswer answer{};
        DracoMesh mesh;
        std::string text;
        try {
            Bytes payload(question.bytes);
            if (!parent.read(payload.data(), payload.size())) return false;
            const auto position = static_cast<std::uint32_t>(question.position);
            mesh = parse_draco(payload, question.has_position ? std::optional(position) : std::nullopt,
                               question.max_points);
        } catch (const Failure &failure) {
            text = failure.what();
        } catch (const std::exception &) { // bad_alloc, length_error
            text = "damaged payload: asks for more memory than a payload of its size may take";
        }
        answer.text = text.size();
        if (text.empty()) {
            answer.points = mesh.point_count;
            answer.positions = mesh.points.size();
            answer.faces = mesh.faces.size();
        }
        if (!parent.write(&answer, sizeof answer) || !parent.write_list(text)) return false;
        if (text.empty() && (!parent.write_list(mesh.points) || !parent.write_list(mesh.faces))) return false;
    }
    return true;
}

} // namespace

DracoReader::DracoReader(const Source &source) : source_(source) {}
DracoReader::~DracoReader() = default;

DracoMesh DracoReader::ask(std::span<const std::uint8_t> payload, std::optional<std::uint32_t> position,
                           std::uint64_t max_faces, std::uint64_t max_points)
{
    const FenceLimits limits = limits_of(max_faces + max_points, payload.size());
    const Question question{payload.size(), position.has_value(), position.value_or(0), max_points, limits};
    if (!fence_) fence_ = std::make_unique<Fence>("Draco", "this payload", limits, answer_draco);
    fence_->restart(limits.seconds);
    if (!fence_->write(&question, sizeof question) || !fence_->write(payload.data(), payload.size()))
        throw Failure(ExitCode::invalid, "", fence_->obituary());
    return receive_draco(*fence_, position.has_value(), max_faces, max_points);
}

} // namespace voxshell
