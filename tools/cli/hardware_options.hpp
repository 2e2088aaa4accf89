// SPDX-License-Identifier: GPL-3.0-or-later
// What hardware wants to know besides its name: the same options wherever a device is named.
#pragma once

#include "cli/options.hpp"
#include "study/open_device.hpp"

#include <CLI/CLI.hpp>

namespace voxshell {

inline void add_hardware_options(CLI::App &verb, HardwareSettings &h)
{
    verb.add_option("--firmware", h.firmware, "falcon: a file of yours; none is shipped, none is fetched")
        ->type_name("FILE");
    verb.add_flag("--in-place", h.is_in_place,
                  "haply: it stands in its starting pose; without this it is never armed");
    verb.add_option("--haply-setup", h.haply_setup,
                    "haply: which board's motors and encoders, 2 (the default) or 3")
        ->check(CLI::IsMember({2, 3}))
        ->type_name("N");
    verb.add_option_function<std::vector<std::string>>(
            "--haply-links",
            [&h](const std::vector<std::string> &texts) {
                h.haply_links.clear();
                for (const std::string &text : texts) h.haply_links.push_back(parse_length(text, true));
            },
            "haply: the links at the motors, those at the tip, the motors' distance (default 50mm,70mm,20mm)")
        ->delimiter(',')
        ->expected(3)
        ->type_name("A,B,C");
    verb.add_option(
            "--units-per-nm", h.units_per_nm,
            "falcon: motor units a N m (default 2300, the weak end; `voxshell device calibrate` measures it)")
        ->check(CLI::Range(1.0, 1e6))
        ->type_name("N");
    verb.add_option("--torque-gain", h.torque_gain, "haply: what is sent a N m (default 1; as measured)")
        ->check(CLI::Range(1e-6, 1e6))
        ->type_name("N");
}

} // namespace voxshell
