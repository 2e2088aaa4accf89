// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/compare.hpp"
#include "plan/plan_facts.hpp"

#include <algorithm>

namespace voxshell {
namespace {

const std::string *find(const std::vector<PlanFact> &facts, const std::string &what)
{
    const auto found = std::ranges::find(facts, what, &PlanFact::what);
    return found == facts.end() ? nullptr : &found->value;
}

} // namespace

Comparison compare(const PlanFile &a, const PlanFile &b)
{
    Comparison result;
    const std::vector<PlanFact> of_a = plan_facts(a), of_b = plan_facts(b);
    for (const PlanFact &fact : of_a) {
        const std::string *other = find(of_b, fact.what);
        if (!other || *other != fact.value)
            result.structure.push_back({fact.what, fact.value, other ? *other : "none"});
    }
    for (const PlanFact &fact : of_b) {
        if (!find(of_a, fact.what)) result.structure.push_back({fact.what, "none", fact.value});
    }
    if (a.source_hash != b.source_hash) result.notes.push_back("made from scene files with other bytes");
    if (a.meta != b.meta) result.notes.push_back("META differs");
    return result;
}

} // namespace voxshell
