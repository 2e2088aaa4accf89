// SPDX-License-Identifier: GPL-3.0-or-later
// What hardware wants to know besides its name: the same options wherever a device is named.
#pragma once

#include <CLI/CLI.hpp>

namespace voxshell {

/// Of anything with firmware, in_place, units_per_nm and torque_gain.
template<class Options>
void add_hardware_options(CLI::App &verb, Options &o)
{
    verb.add_option("--firmware", o.firmware, "falcon: a file of yours; none is shipped, none is fetched")
        ->type_name("FILE");
    verb.add_flag("--in-place", o.in_place,
                  "haply: it stands in its starting pose; without this it is never armed");
    verb.add_option(
            "--units-per-nm", o.units_per_nm,
            "falcon: motor units a N m (default 2300, the weak end; `voxshell device calibrate` measures it)")
        ->check(CLI::Range(1.0, 1e6))
        ->type_name("N");
    verb.add_option("--torque-gain", o.torque_gain, "haply: what is sent a N m (default 1; as measured)")
        ->check(CLI::Range(1e-6, 1e6))
        ->type_name("N");
}

} // namespace voxshell
