// SPDX-License-Identifier: GPL-3.0-or-later
// STL, binary and ASCII. There is no standard; this follows the 3D Systems description (1989) and
// what programs write: which of the two a file is, its size says, not the word "solid".
#include "import/importers.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

namespace voxshell {
namespace {

constexpr std::size_t header_size = 80, binary_start = header_size + 4, record_size = 50;
constexpr std::uint64_t max_triangles = std::uint64_t{1} << 30; // corners still fit 32-bit indices

bool is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool same_word(std::string_view a, std::string_view lower_case)
{
    return a.size() == lower_case.size() &&
           std::equal(a.begin(), a.end(), lower_case.begin(), [](char x, char y) { return lower(x) == y; });
}

/// Collects triangles, one vertex for all corners at exactly the same place.
class Welder {
  public:
    /// A closed mesh has half as many vertices as triangles: then the table need not grow.
    Welder(Mesh &mesh, std::uint64_t triangles)
        : mesh_(mesh), slots_(std::bit_ceil(std::max<std::uint64_t>(triangles, 1024)), empty)
    {
    }

    std::uint32_t vertex(Point p)
    {
        for (double &x : p) x += 0.0; // -0 and 0 are one place
        if (2 * mesh_.vertices.size() >= slots_.size()) grow();
        std::size_t slot = find(p);
        if (slots_[slot] == empty) {
            slots_[slot] = static_cast<std::uint32_t>(mesh_.vertices.size());
            mesh_.vertices.push_back(p);
        }
        return slots_[slot];
    }

  private:
    static constexpr std::uint32_t empty = 0xffffffffu;

    std::size_t find(const Point &p) const
    {
        std::uint64_t h = 0;
        for (double x : p) {
            h = (h ^ std::bit_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15u;
            h ^= h >> 29;
        }
        std::size_t slot = (h ^ h >> 32) & (slots_.size() - 1);
        while (slots_[slot] != empty && mesh_.vertices[slots_[slot]] != p)
            slot = (slot + 1) & (slots_.size() - 1);
        return slot;
    }

    void grow()
    {
        std::vector<std::uint32_t> old(slots_.size() * 2, empty);
        old.swap(slots_);
        for (std::uint32_t v : old)
            if (v != empty) slots_[find(mesh_.vertices[v])] = v;
    }

    Mesh &mesh_;
    std::vector<std::uint32_t> slots_;
};

void read_binary(const Source &source, double unit, std::uint64_t count, Mesh &mesh)
{
    Welder welder(mesh, count);
    mesh.triangles.reserve(count);
    for (std::uint64_t t = 0; t < count; ++t) {
        // Record: normal (ignored: the winding says the same), three corners, two attribute bytes.
        float corners[9];
        std::memcpy(corners, source.bytes.data() + binary_start + t * record_size + 12, sizeof corners);
        Triangle triangle;
        for (std::size_t c = 0; c < 3; ++c) {
            Point p;
            for (std::size_t a = 0; a < 3; ++a) {
                const double x = corners[3 * c + a];
                if (!std::isfinite(x)) {
                    source.invalid(fmt::format(
                        "triangle {}: coordinate {} of corner {} is not a finite number", t, "xyz"[a], c));
                }
                p[a] = x * unit;
            }
            triangle[c] = welder.vertex(p);
        }
        mesh.triangles.push_back(triangle);
    }
}

/// Words and lines of an ASCII file, without the locale.
class Words {
  public:
    explicit Words(std::string_view text) : rest_(text) {}

    /// The next word, empty at the end of the file.
    std::string_view next()
    {
        skip_space();
        std::size_t n = 0;
        while (n < rest_.size() && !is_space(rest_[n])) ++n;
        return take(n);
    }

    std::string_view peek()
    {
        const Words saved = *this;
        const std::string_view word = next();
        *this = saved;
        return word;
    }

    /// The rest of a line that holds a name. Ends early before "facet normal": some write it all in one line.
    std::string_view name()
    {
        std::size_t end = 0;
        while (end < rest_.size() && rest_[end] != '\n' && rest_[end] != '\r') {
            if (end > 0 && is_space(rest_[end - 1])) {
                Words ahead(rest_.substr(end));
                if (same_word(ahead.peek(), "facet") && (ahead.next(), same_word(ahead.peek(), "normal")))
                    break;
            }
            ++end;
        }
        std::string_view text = take(end);
        while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
        while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
        return text;
    }

    std::size_t line() const { return line_; }

  private:
    void skip_space()
    {
        while (!rest_.empty() && is_space(rest_.front())) {
            // CR LF, LF and a lone CR each end one line.
            line_ += rest_[0] == '\n' || (rest_[0] == '\r' && (rest_.size() < 2 || rest_[1] != '\n'));
            rest_.remove_prefix(1);
        }
    }

    std::string_view take(std::size_t n)
    {
        const std::string_view head = rest_.substr(0, n);
        rest_.remove_prefix(n);
        return head;
    }

    std::string_view rest_;
    std::size_t line_ = 1;
};

class AsciiReader {
  public:
    AsciiReader(const Source &source, std::string_view text, double unit, Scene &scene)
        : source_(source), words_(text), unit_(unit), scene_(scene), mesh_(scene.meshes[0]), welder_(mesh_, 0)
    {
    }

    void read()
    {
        bool open = false;
        for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
            if (same_word(word, "solid")) {
                const std::string_view name = words_.name();
                if (mesh_.name.empty()) mesh_.name = printable(name);
                if (!mesh_.solids.empty() && mesh_.solids.back().first == mesh_.triangles.size())
                    mesh_.solids.pop_back(); // it had no triangle
                mesh_.solids.push_back({printable(name), mesh_.triangles.size()});
                open = true;
            } else if (open && same_word(word, "facet")) {
                facet();
            } else if (open && closes(word, "solid")) {
                words_.name();
                open = false;
            } else {
                fail(open ? "facet' or 'endsolid" : "solid", word);
            }
        }
        if (!mesh_.solids.empty() && mesh_.solids.back().first == mesh_.triangles.size())
            mesh_.solids.pop_back();
        if (mesh_.solids.size() < 2) mesh_.solids.clear();
        if (open) {
            scene_.warnings.push_back(
                {"stl-no-endsolid", "the last solid has no 'endsolid': the file may be cut"});
        }
    }

  private:
    [[noreturn]] void fail(const char *wanted, std::string_view got)
    {
        if (got.empty()) {
            source_.invalid(
                fmt::format("line {}: the file ends where '{}' should follow", words_.line(), wanted));
        }
        source_.invalid(fmt::format("line {}: '{}' should stand where '{}' does", words_.line(), wanted,
                                    printable(got, 40)));
    }

    /// "endloop", and "end loop" as some write it.
    bool closes(std::string_view word, std::string_view what)
    {
        if (same_word(word.substr(0, 3), "end") &&
            same_word(word.substr(std::min<std::size_t>(3, word.size())), what))
            return true;
        if (!same_word(word, "end") || !same_word(words_.peek(), what)) return false;
        words_.next();
        return true;
    }

    void expect(const char *what)
    {
        const std::string_view word = words_.next();
        if (!same_word(word, what)) fail(what, word);
    }

    void expect_end(const char *what, const char *whole)
    {
        const std::string_view word = words_.next();
        if (!closes(word, what)) fail(whole, word);
    }

    void facet()
    {
        std::string_view word = words_.next();
        if (same_word(word, "normal")) {
            // The winding says what the normal says; programs write zeros, NaN or nothing here.
            word = words_.next();
            for (int i = 0; i < 3 && !word.empty() && !same_word(word, "outer"); ++i) word = words_.next();
        }
        if (!same_word(word, "outer")) fail("outer loop", word);
        expect("loop");
        Triangle triangle;
        for (std::uint32_t &corner : triangle) corner = vertex();
        if (same_word(words_.peek(), "vertex")) {
            words_.next();
            source_.invalid(fmt::format("line {}: a loop with more than three corners", words_.line()));
        }
        expect_end("loop", "endloop");
        expect_end("facet", "endfacet");
        if (mesh_.triangles.size() >= max_triangles) source_.unsupported("more than 2^30 triangles");
        mesh_.triangles.push_back(triangle);
    }

    std::uint32_t vertex()
    {
        expect("vertex");
        Point p;
        for (double &x : p) x = number(words_.next()) * unit_;
        return welder_.vertex(p);
    }

    double number(std::string_view word)
    {
        if (word.empty()) fail("a number", word);
        std::string_view digits = word;
        if (digits.front() == '+') digits.remove_prefix(1);
        double x = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), x);
        if (end != digits.data() + digits.size() || error == std::errc::invalid_argument) {
            source_.invalid(fmt::format("line {}: '{}' is not a number", words_.line(), printable(word, 40)));
        }
        if (error == std::errc::result_out_of_range) { // too small is zero, too large is refused below
            const std::size_t e = digits.find_first_of("eE");
            if (e != digits.npos && digits.substr(e + 1).starts_with('-')) return 0;
            x = HUGE_VAL;
        }
        if (!std::isfinite(x * unit_)) {
            source_.invalid(
                fmt::format("line {}: coordinate '{}' is not finite", words_.line(), printable(word, 40)));
        }
        return x;
    }

    const Source &source_;
    Words words_;
    double unit_;
    Scene &scene_;
    Mesh &mesh_;
    Welder welder_;
};

/// The text without byte order mark and leading blanks if it can be an ASCII STL, else empty. A binary
/// header may begin with "solid" too, but then zero bytes follow: in the padding, the count or the floats.
std::string_view ascii_text(std::string_view text)
{
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    while (text.ends_with('\0') || text.ends_with('\x1a'))
        text.remove_suffix(1); // padding, end mark of old systems
    std::string_view word = text;
    while (!word.empty() && is_space(word.front())) word.remove_prefix(1);
    const bool solid = same_word(word.substr(0, 5), "solid") && (word.size() == 5 || is_space(word[5]));
    return solid && text.find('\0') == text.npos ? text : std::string_view{};
}

} // namespace

Scene import_stl(const Source &source, const ImportOptions &options)
{
    if (!options.unit) source.refuse(ExitCode::usage, "STL has no unit: say --unit mm|cm|m|in");
    const double unit = *options.unit;
    if (!(unit > 0) || !std::isfinite(unit))
        source.refuse(ExitCode::usage, "the unit must be a positive length");

    Scene scene;
    Mesh &mesh = scene.meshes.emplace_back();
    const std::size_t size = source.bytes.size();
    std::uint32_t count = 0;
    if (size >= binary_start) std::memcpy(&count, source.bytes.data() + header_size, sizeof count);
    const std::uint64_t needed = binary_start + record_size * std::uint64_t{count};
    const std::string_view ascii = needed == size ? std::string_view{} : ascii_text(source.text());

    if (!ascii.empty()) {
        AsciiReader(source, ascii, unit, scene).read();
        if (mesh.triangles.empty()) source.invalid("an ASCII STL without a facet");
    } else {
        if (size == 0) source.invalid("the file is empty");
        if (source.text().find('\0') == std::string_view::npos && needed != size) {
            source.invalid("neither a binary STL (its size does not fit) nor an ASCII one (it does not begin "
                           "with 'solid')");
        }
        if (size < binary_start) {
            source.invalid(
                fmt::format("a binary STL has at least {} bytes, the file has {}", binary_start, size));
        }
        if (needed > size) {
            source.invalid(
                fmt::format("triangle count {} needs {} bytes, the file has {}", count, needed, size));
        }
        if (count == 0) source.invalid("a binary STL that declares 0 triangles");
        if (count > max_triangles) source.unsupported("more than 2^30 triangles");
        if (needed < size) {
            scene.warnings.push_back(
                {"stl-trailing-bytes",
                 fmt::format("{} bytes after the last of {} triangles ignored", size - needed, count)});
        }
        read_binary(source, unit, count, mesh);
    }
    scene.instances.push_back({});
    return scene;
}

} // namespace voxshell
