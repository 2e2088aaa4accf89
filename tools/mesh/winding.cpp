// SPDX-License-Identifier: GPL-3.0-or-later
// w(q) = 1/(4 pi) * integral over the surface of n.(x - q) / |x - q|^3 dA. Near triangles exactly (van
// Oosterom, Strackee 1983); a far cluster by the expansion about its centre p, with r = p - q, d = x - p:
//   A = integral of n,  S = symmetric part of the integral of n d,  T = symmetric part of that of n d d:
//   4 pi w  ~  A.r / |r|^3  +  tr S / |r|^3 - 3 S(r,r) / |r|^5  -  9/2 (tr T).r / |r|^5 + 15/2 T(r,r,r) /
//   |r|^7
// (Barill et al. 2018, orders one to three; only symmetric parts count, since the kernel is a gradient's
// derivative). A disc seen from twice its radius is 18 % wrong by its dipole, and all discs of a sphere err
// the same way: hence the third order.
#include "mesh/winding.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace voxshell {
namespace {

constexpr std::uint32_t leaf_triangles = 8;
constexpr double beta = 2; // a cluster is far beyond beta times its radius

struct Box {
    Point low, high;
    void add(const Point &p)
    {
        for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
    }
};

struct Node {
    Point center{};
    double reach = 0;                  // (beta * radius)^2
    Point area{};                      // A
    std::array<double, 6> second{};    // S, in the order of `pairs`
    std::array<double, 10> third{};    // T, in the order of `triples`
    std::uint32_t first = 0, last = 0; // triangles
    std::uint32_t right = 0;           // 0: leaf; the left child follows its parent
};

constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
constexpr int pair_of[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
constexpr int triples[10][3] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {0, 0, 1}, {0, 0, 2},
                                {1, 1, 0}, {1, 1, 2}, {2, 2, 0}, {2, 2, 1}, {0, 1, 2}};

struct Shape { // what a node needs of its children while the tree is built
    double area = 0, radius = 0;
    Box box{};
};

// From the eye at 0. On the triangle's own plane it is 0: the mean of both sides.
double half_solid_angle(const Point &a, const Point &b, const Point &c)
{
    const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
    const double det = dot(a, cross(b, c));
    return det == 0 ? 0 : std::atan2(det, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

std::uint64_t spread(std::uint64_t x) // 21 bits to every third
{
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

} // namespace

struct WindingNumber::Tree {
    Point middle{};
    double scale = 1; // to a box of size about one: far from underflow for parts of a micrometre
    std::vector<std::array<Point, 3>> triangles;
    std::vector<Node> nodes;

    void build(const Mesh &mesh);
    void split(const std::vector<std::uint64_t> &codes, std::uint32_t first, std::uint32_t last);
    void leaf(Node &node, Shape &shape) const;
    void join(Node &node, Shape &shape, const Node *const (&child)[2],
              const Shape *const (&child_shape)[2]) const;
    double at(const Point &point) const;
};

void WindingNumber::Tree::build(const Mesh &mesh)
{
    if (mesh.triangles.empty()) return;
    Box box{mesh.vertices[mesh.triangles[0][0]], mesh.vertices[mesh.triangles[0][0]]};
    for (const Triangle &t : mesh.triangles)
        for (const std::uint32_t v : t) box.add(mesh.vertices[v]);
    double size = 0;
    for (int i = 0; i < 3; ++i) {
        middle[i] = box.low[i] / 2 + box.high[i] / 2;
        size = std::max(size, box.high[i] - box.low[i]);
    }
    if (size > 0) scale = std::ldexp(1.0, std::clamp(-std::ilogb(size), -1000, 1000));

    const std::size_t n = mesh.triangles.size();
    std::vector<std::array<Point, 3>> unsorted(n);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(n);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 4096), [&](const auto &range) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
            std::uint64_t code = 0;
            for (int v = 0; v < 3; ++v)
                for (int i = 0; i < 3; ++i)
                    unsorted[t][v][i] = (mesh.vertices[mesh.triangles[t][v]][i] - middle[i]) * scale;
            for (int i = 0; i < 3; ++i) { // coordinates lie in [-1, 1]
                const double x = (unsorted[t][0][i] + unsorted[t][1][i] + unsorted[t][2][i]) / 3;
                code |= spread(static_cast<std::uint64_t>(std::clamp((x + 1) * 0x1p20, 0.0, 0x1.fffffp20)))
                        << i;
            }
            order[t] = {code, static_cast<std::uint32_t>(t)};
        }
    });
    tbb::parallel_sort(order.begin(), order.end());
    triangles.resize(n);
    std::vector<std::uint64_t> codes(n);
    for (std::size_t t = 0; t < n; ++t) {
        triangles[t] = unsorted[order[t].second];
        codes[t] = order[t].first;
    }
    nodes.reserve(n / 2 + 1);
    split(codes, 0, static_cast<std::uint32_t>(n));

    std::vector<Shape> shapes(nodes.size());
    tbb::parallel_for(std::size_t{0}, nodes.size(), [&](std::size_t i) {
        if (!nodes[i].right) leaf(nodes[i], shapes[i]);
    });
    for (std::size_t i = nodes.size(); i-- > 0;)
        if (nodes[i].right)
            join(nodes[i], shapes[i], {&nodes[i + 1], &nodes[nodes[i].right]},
                 {&shapes[i + 1], &shapes[nodes[i].right]});
}

void WindingNumber::Tree::split(const std::vector<std::uint64_t> &codes, std::uint32_t first,
                                std::uint32_t last)
{
    const std::size_t me = nodes.size();
    nodes.push_back({});
    nodes[me].first = first;
    nodes[me].last = last;
    if (last - first <= leaf_triangles) return;
    std::uint32_t middle_of = first + (last - first) / 2;
    if (const std::uint64_t differ =
            codes[first] ^ codes[last - 1]) { // where the highest differing bit turns on
        const std::uint64_t bit = std::uint64_t{1} << (63 - __builtin_clzll(differ));
        middle_of = static_cast<std::uint32_t>(
            std::partition_point(codes.begin() + first, codes.begin() + last,
                                 [bit](std::uint64_t code) { return !(code & bit); }) -
            codes.begin());
    }
    split(codes, first, middle_of);
    nodes[me].right = static_cast<std::uint32_t>(nodes.size());
    split(codes, middle_of, last);
}

void WindingNumber::Tree::leaf(Node &node, Shape &shape) const
{
    shape.box = {triangles[node.first][0], triangles[node.first][0]};
    Point weighted{};
    for (std::uint32_t t = node.first; t < node.last; ++t) {
        const auto &[a, b, c] = triangles[t];
        for (const Point &p : triangles[t]) shape.box.add(p);
        const Point twice = cross(minus(b, a), minus(c, a));
        const double area = std::sqrt(dot(twice, twice)) / 2;
        shape.area += area;
        for (int i = 0; i < 3; ++i) {
            node.area[i] += twice[i] / 2;
            weighted[i] += area * (a[i] + b[i] + c[i]) / 3;
        }
    }
    for (int i = 0; i < 3; ++i)
        node.center[i] =
            shape.area > 0 ? weighted[i] / shape.area : (shape.box.low[i] + shape.box.high[i]) / 2;
    double far = 0;
    for (std::uint32_t t = node.first; t < node.last; ++t) {
        const auto &[a, b, c] = triangles[t];
        const Point twice = cross(minus(b, a), minus(c, a));
        const Point d[3] = {minus(a, node.center), minus(b, node.center), minus(c, node.center)};
        Point n{}, sum{}; // n: area vector
        for (int i = 0; i < 3; ++i) n[i] = twice[i] / 2, sum[i] = d[0][i] + d[1][i] + d[2][i];
        double square[6]; // mean of d d over the triangle
        for (int m = 0; m < 6; ++m) {
            const auto [i, j] = pairs[m];
            square[m] = (d[0][i] * d[0][j] + d[1][i] * d[1][j] + d[2][i] * d[2][j] + sum[i] * sum[j]) / 12;
            node.second[m] += (n[i] * sum[j] + n[j] * sum[i]) / 6;
        }
        for (int m = 0; m < 10; ++m) {
            const auto [i, j, k] = triples[m];
            node.third[m] +=
                (n[i] * square[pair_of[j][k]] + n[j] * square[pair_of[i][k]] + n[k] * square[pair_of[i][j]]) /
                3;
        }
        for (const Point &p : triangles[t])
            far = std::max(far, dot(minus(p, node.center), minus(p, node.center)));
    }
    shape.radius = std::sqrt(far);
    node.reach = beta * beta * far;
}

void WindingNumber::Tree::join(Node &node, Shape &shape, const Node *const (&child)[2],
                               const Shape *const (&child_shape)[2]) const
{
    shape.box = child_shape[0]->box;
    shape.box.add(child_shape[1]->box.low);
    shape.box.add(child_shape[1]->box.high);
    shape.area = child_shape[0]->area + child_shape[1]->area;
    for (int i = 0; i < 3; ++i)
        node.center[i] =
            shape.area > 0
                ? (child_shape[0]->area * child[0]->center[i] + child_shape[1]->area * child[1]->center[i]) /
                      shape.area
                : (shape.box.low[i] + shape.box.high[i]) / 2;
    double radius = 0;
    for (int s = 0; s < 2; ++s) {
        const Point d = minus(child[s]->center, node.center);
        const Point &a = child[s]->area;
        for (int i = 0; i < 3; ++i) node.area[i] += a[i];
        const auto &second = child[s]->second; // all moments are moved from the child's centre to the node's
        for (int m = 0; m < 6; ++m) {
            const auto [i, j] = pairs[m];
            node.second[m] += second[m] + (a[i] * d[j] + a[j] * d[i]) / 2;
        }
        for (int m = 0; m < 10; ++m) {
            const auto [i, j, k] = triples[m];
            node.third[m] +=
                child[s]->third[m] + (2 * (second[pair_of[i][j]] * d[k] + second[pair_of[i][k]] * d[j] +
                                           second[pair_of[j][k]] * d[i]) +
                                      a[i] * d[j] * d[k] + a[j] * d[i] * d[k] + a[k] * d[i] * d[j]) /
                                         3;
        }
        radius = std::max(radius, std::sqrt(dot(d, d)) + child_shape[s]->radius);
    }
    double corner = 0;
    for (int i = 0; i < 3; ++i) {
        const double side = std::max(shape.box.high[i] - node.center[i], node.center[i] - shape.box.low[i]);
        corner += side * side;
    }
    shape.radius = std::min(radius, std::sqrt(corner));
    node.reach = beta * beta * shape.radius * shape.radius;
}

double WindingNumber::Tree::at(const Point &point) const
{
    if (nodes.empty()) return 0;
    Point q{};
    for (int i = 0; i < 3; ++i) q[i] = (point[i] - middle[i]) * scale;
    double near = 0, far = 0; // half solid angles; solid angles
    std::uint32_t stack[128]; // depth: 63 bits of code, then halves of at most 2^32 equal codes
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const std::uint32_t i = stack[--top];
        const Node &node = nodes[i];
        const Point r = minus(node.center, q);
        const double rr = dot(r, r);
        if (rr > node.reach) {
            const double square = 1 / rr, cube = square * std::sqrt(square);
            const auto &S = node.second;
            const auto &T = node.third;
            const double x = r[0], y = r[1], z = r[2];
            const double srr =
                S[0] * x * x + S[1] * y * y + S[2] * z * z + 2 * (S[3] * x * y + S[4] * x * z + S[5] * y * z);
            const double trace =
                (T[0] + T[5] + T[7]) * x + (T[1] + T[3] + T[8]) * y + (T[2] + T[4] + T[6]) * z;
            const double trrr = x * x * (T[0] * x + 3 * (T[3] * y + T[4] * z)) +
                                y * y * (T[1] * y + 3 * (T[5] * x + T[6] * z)) +
                                z * z * (T[2] * z + 3 * (T[7] * x + T[8] * y)) + 6 * T[9] * x * y * z;
            far += cube * (dot(node.area, r) + S[0] + S[1] + S[2] -
                           square * (3 * srr + 4.5 * trace - 7.5 * square * trrr));
        } else if (node.right) {
            stack[top++] = node.right;
            stack[top++] = i + 1;
        } else {
            for (std::uint32_t t = node.first; t < node.last; ++t)
                near += half_solid_angle(minus(triangles[t][0], q), minus(triangles[t][1], q),
                                         minus(triangles[t][2], q));
        }
    }
    return (2 * near + far) / (4 * std::numbers::pi);
}

double winding_of_triangle(const Point &a, const Point &b, const Point &c, const Point &q)
{
    return half_solid_angle(minus(a, q), minus(b, q), minus(c, q)) / (2 * std::numbers::pi);
}

WindingNumber::WindingNumber(const Mesh &mesh) : tree_(new Tree)
{
    try {
        tree_->build(mesh);
    } catch (...) {
        delete tree_;
        throw;
    }
}
WindingNumber::~WindingNumber()
{
    delete tree_;
}
WindingNumber::WindingNumber(WindingNumber &&other) noexcept : tree_(std::exchange(other.tree_, nullptr)) {}
WindingNumber &WindingNumber::operator=(WindingNumber &&other) noexcept
{
    std::swap(tree_, other.tree_);
    return *this;
}
double WindingNumber::at(const Point &point) const
{
    return tree_->at(point);
}

} // namespace voxshell
