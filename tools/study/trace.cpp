// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/trace.hpp"

#include <charconv>

namespace voxshell {
namespace {

void put(std::string &out, double value)
{
    char digits[32];
    const auto [end, error] =
        std::to_chars(digits, digits + sizeof digits, value); // shortest that reads back the same
    out.append(digits, end);
    out += ',';
}

void put(std::string &out, const Point &point)
{
    for (const double x : point) {
        put(out, x);
    }
}

} // namespace

std::string trace_csv(const std::vector<TraceRow> &rows)
{
    std::string out =
        "t_s,device_x_m,device_y_m,device_z_m,hand_x_m,hand_y_m,hand_z_m,body_x_m,body_y_m,body_z_m,"
        "collision_fx_n,collision_fy_n,collision_fz_n,collision_tx_nm,collision_ty_nm,collision_tz_nm,"
        "output_fx_n,output_fy_n,output_fz_n,contacts,flags,energy_j\n";
    for (const TraceRow &row : rows) {
        put(out, row.t);
        put(out, row.device);
        put(out, row.hand);
        put(out, row.body);
        put(out, row.collision_force);
        put(out, row.collision_torque);
        put(out, row.output_force);
        out += std::to_string(row.contacts) + ',' + std::to_string(row.flags) + ',';
        put(out, row.energy);
        out.back() = '\n';
    }
    return out;
}

} // namespace voxshell
