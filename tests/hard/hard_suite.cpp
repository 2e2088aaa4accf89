// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the hard cases on every pair of law and field, and prints the map of what holds.
//   hard_suite [--case NAME] [--ticks N] [--markdown FILE] [--csv FILE]
#include "hard_case.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iostream>

namespace hard {

// One row each, in the order of METHOD section 5.
#define CASES                                                                                                \
    ROW(peg_in_hole)                                                                                         \
    ROW(slot)                                                                                                \
    ROW(wedge)                                                                                               \
    ROW(one_point)                                                                                           \
    ROW(no_point)                                                                                            \
    ROW(all_points)                                                                                          \
    ROW(knife_edge)                                                                                          \
    ROW(cone_tip)                                                                                            \
    ROW(duplicate_faces)                                                                                     \
    ROW(slivers)                                                                                             \
    ROW(t_junctions)                                                                                         \
    ROW(self_intersection)                                                                                   \
    ROW(open_mesh)                                                                                           \
    ROW(inverted_mesh)                                                                                       \
    ROW(far_away)                                                                                            \
    ROW(any_scale)                                                                                           \
    ROW(grid_planes)                                                                                         \
    ROW(large_triangles)                                                                                     \
    ROW(quaternions)                                                                                         \
    ROW(enter_and_leave)                                                                                     \
    ROW(cell_borders)                                                                                        \
    ROW(tilted_wall)                                                                                         \
    ROW(energy)                                                                                              \
    ROW(energy_guarded)                                                                                      \
    ROW(start_inside)                                                                                        \
    ROW(long_walk)                                                                                           \
    ROW(not_finite)                                                                                          \
    ROW(missed_ticks)                                                                                        \
    ROW(device_gone)

#define ROW(name) extern const Case name;
CASES
#undef ROW
#define ROW(name) &name,
static const Case *const cases[] = {CASES};
#undef ROW

namespace {

enum class Verdict { holds, beyond, refused, broken };

Verdict judge(const Case &c, const Pair &pair, const Measured &m)
{
    if (!m.refused.empty()) return Verdict::refused;
    if (!m.broken.empty()) return Verdict::broken;
    if (m.worst <= c.bound) return Verdict::holds;
    return c.claims(pair) ? Verdict::broken : Verdict::beyond;
}

std::string cell(Verdict verdict, const Measured &m)
{
    switch (verdict) {
    case Verdict::holds:
        return number(m.worst);
    case Verdict::beyond:
        return std::string("*").append(number(m.worst)).append("*");
    case Verdict::refused:
        return "–";
    default:
        return std::string("**FAILS** ").append(m.broken.empty() ? number(m.worst) : m.broken);
    }
}

/// A row of the map as CSV: case,worst,bound,pair,value,verdict.
std::string csv_row(const Case &c, const Pair &pair, Verdict verdict, const Measured &m)
{
    const char *text[] = {"holds", "beyond", "refused", "fails"};
    return std::string(c.name) + ",\"" + c.worst + "\"," + number(c.bound) + "," + pair.name + "," +
           (m.refused.empty() ? number(m.worst) : "") + "," + text[static_cast<int>(verdict)] + "\n";
}

bool written(const std::string &file, const std::string &text)
{
    if (file.empty() || (std::ofstream(file) << text).flush()) return true;
    std::fprintf(stderr, "hard_suite: %s: cannot be written\n", file.c_str());
    return false;
}

int run(const std::string &only, const Options &options, const std::string &markdown, const std::string &csv)
{
    std::string rows = "case,worst,bound,pair,value,verdict\n";
    std::string page =
        "Made by `hard_suite --markdown FILE`. Each number is a case's worst. In italics: beyond the bound, "
        "which this pair does not\nclaim to keep (the case's file and contact.h say why); –: refused, the "
        "asset lacks the channel.\n\n| case | worst, and its bound |";
    for (const Pair &pair : pairs()) page += std::string(" ") + pair.name + " |";
    page += "\n|---|---|";
    for (std::size_t n = 0; n < pairs().size(); ++n) page += "---|";
    page += "\n";
    std::vector<int> holds(pairs().size());
    int failed = 0, ran = 0;
    for (const Case *c : cases) {
        if (!only.empty() && only != c->name) continue;
        ++ran;
        const auto begin = std::chrono::steady_clock::now();
        std::printf("%s: %s\n", c->name, c->what);
        page += std::string("| ") + c->name + " | " + c->worst + ", " + number(c->bound) + " |";
        for (const Pair &pair : pairs()) {
            Measured m;
            try {
                c->run(pair, options, m);
            } catch (const std::exception &error) {
                m.must(false, error.what());
            }
            const Verdict verdict = judge(*c, pair, m);
            failed += verdict == Verdict::broken;
            holds[static_cast<std::size_t>(&pair - pairs().data())] += verdict == Verdict::holds;
            page.append(" ").append(cell(verdict, m)).append(" |");
            rows += csv_row(*c, pair, verdict, m);
            const char *text[] = {"holds", "beyond, not claimed", "refused", "FAILS"};
            std::printf("  %-18s %-10s of %s  %s%s%s%s\n", pair.name,
                        m.refused.empty() ? number(m.worst).c_str() : "-", number(c->bound).c_str(),
                        text[static_cast<int>(verdict)],
                        std::string(" ").append(m.broken).append(m.refused).c_str(),
                        m.where.empty() ? "" : ", worst ", m.where.c_str());
        }
        page += "\n";
        std::printf("  %.1f s\n",
                    std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        std::fflush(stdout);
    }
    if (only.empty()) {
        page += "| **holds** | of " + std::to_string(ran) + " cases |";
        for (const int count : holds) page.append(" **").append(std::to_string(count)).append("** |");
        page += "\n";
    }
    if (!written(markdown, page) || !written(csv, rows)) return 2;
    if (!ran) {
        std::fprintf(stderr, "hard_suite: no case %s\n", only.c_str());
        return 1;
    }
    std::printf("%d cases on %zu pairs: %d fail\n", ran, pairs().size(), failed);
    return failed ? 1 : 0;
}

} // namespace
} // namespace hard

int main(int argc, char **argv)
{
    std::string only, markdown, csv;
    hard::Options options;
    for (int n = 1; n + 1 < argc; n += 2) {
        if (!std::strcmp(argv[n], "--case"))
            only = argv[n + 1];
        else if (!std::strcmp(argv[n], "--markdown"))
            markdown = argv[n + 1];
        else if (!std::strcmp(argv[n], "--csv"))
            csv = argv[n + 1];
        else if (!std::strcmp(argv[n], "--ticks"))
            options.ticks = std::atol(argv[n + 1]);
        else
            argc = 0;
    }
    if (argc % 2 == 0 || options.ticks < 1000) {
        std::cerr << "usage: hard_suite [--case NAME] [--ticks N] [--markdown FILE] [--csv FILE]\n";
        return 1;
    }
    return hard::run(only, options, markdown, csv);
}
