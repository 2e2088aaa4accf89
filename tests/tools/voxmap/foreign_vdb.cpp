// SPDX-License-Identifier: GPL-3.0-or-later
// foreign_vdb KIND OUT.vdb: files of other programs for the tests of the command line; without arguments, the
// kinds.
#include "foreign_grids.hpp"

#include <cstdio>
#include <exception>

int main(int argc, char **argv)
{
    try {
        if (argc == 3)
            foreign::save_kind(argv[1], argv[2]);
        else
            for (const std::string &kind : foreign::kinds()) std::puts(kind.c_str());
    } catch (const std::exception &error) {
        std::fprintf(stderr, "foreign_vdb: %s\n", error.what());
        return 1;
    }
    return 0;
}
