// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/embedded.hpp"

// The assembler copies a file's bytes as they are: no generated source, and nothing to look for when the program
// runs. VOXSHELL_PAGE and VOXSHELL_THREE are folders, from the build.
#define EMBED(name, path)                                                                                    \
    asm(".pushsection .rodata\n"                                                                             \
        "voxshell_embedded_" #name ":\n"                                                                     \
        ".incbin \"" path "\"\n"                                                                             \
        "voxshell_embedded_" #name "_end:\n"                                                                 \
        ".byte 0\n"                                                                                          \
        ".popsection\n");                                                                                    \
    extern "C" const char voxshell_embedded_##name[], voxshell_embedded_##name##_end[];

EMBED(style, VOXSHELL_PAGE "/page.css")
EMBED(body, VOXSHELL_PAGE "/page.html")
EMBED(licence, VOXSHELL_PAGE "/three-licence.txt")
EMBED(library, VOXSHELL_THREE "/three.min.js")
EMBED(controls, VOXSHELL_THREE "/examples/js/controls/OrbitControls.js")
EMBED(arrays, VOXSHELL_PAGE "/arrays.js")
EMBED(blocks, VOXSHELL_PAGE "/blocks.js")
EMBED(faces, VOXSHELL_PAGE "/faces.js")
EMBED(cells, VOXSHELL_PAGE "/cells.js")
EMBED(slices, VOXSHELL_PAGE "/slices.js")
EMBED(bodies, VOXSHELL_PAGE "/bodies.js")
EMBED(motion, VOXSHELL_PAGE "/motion.js")
EMBED(panel, VOXSHELL_PAGE "/panel.js")
EMBED(main, VOXSHELL_PAGE "/main.js")

#define TEXT(name)                                                                                           \
    std::string_view(voxshell_embedded_##name,                                                               \
                     static_cast<std::size_t>(voxshell_embedded_##name##_end - voxshell_embedded_##name))

namespace voxshell::embedded {

const std::string_view style = TEXT(style), body = TEXT(body), library = TEXT(library),
                       controls = TEXT(controls), library_licence = TEXT(licence);
const std::array<std::string_view, 9> scripts = {TEXT(arrays), TEXT(blocks), TEXT(faces),
                                                 TEXT(cells),  TEXT(slices), TEXT(bodies),
                                                 TEXT(motion), TEXT(panel),  TEXT(main)};

} // namespace voxshell::embedded
