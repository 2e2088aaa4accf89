// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/verb.hpp"

namespace voxshell {

std::span<const Verb> verbs()
{
    static constexpr Verb table[] = {
        {"convert", "CAD files and scenes to assets: .stl .gltf .glb .scene.json -> .vdb .voxmap .pointshell",
         "voxshell convert part.stl --unit mm -o out --voxel 0.5mm", add_convert, true},
        {"batch", "folders, lists and assemblies to assets: each distinct part once, the rest from a cache",
         "voxshell batch parts/ --unit mm -o out --voxel 0.5mm\nvoxshell batch robot.glb --per-part -o out "
         "--voxel "
         "auto",
         add_batch, true},
        {"inspect", "what is in an asset", "voxshell inspect out/part.voxmap", add_inspect},
        {"verify", "every rule of the format, checksums and semantics",
         "voxshell verify out/\nvoxshell verify out/part.pointshell --against part.stl --unit mm",
         add_verify},
        {"diff", "what differs between two assets: structure, then values",
         "voxshell diff old/part.voxmap new/part.voxmap", add_diff},
        {"pack", ".vdb to .voxmap: our own, or a level set or mask of another program",
         "voxshell pack part.vdb -o part.voxmap\nvoxshell pack others.vdb --grid surface --unit mm",
         add_pack},
        {"export", "an asset as .vdb, .nvdb, .ply, .glb or .csv",
         "voxshell export part.pointshell -o part.ply", add_export},
        {"simulate", "the servo loop on a device",
         "voxshell simulate cup.scene.json --seconds 5 --trace trace.csv", add_simulate},
        {"design", "the virtual coupling for a device and a scene: coefficients, margins, plots",
         "voxshell design --device sim:omega-3 --stiffness 500N/m --assume hand -o plots", add_design},
        {"bench", "how long a tick's contact takes on this machine",
         "voxshell bench cup.voxmap sphere.pointshell", add_bench},
        {"device", "devices found, why one is not usable and the exact fix, how late this machine wakes up",
         "voxshell device doctor\nvoxshell device test sim:omega-3 --seconds 5 --plot late.svg", add_device},
        {"study", "what the method is worth, measured: figures, tables and one page",
         "voxshell study paper -o study", add_study},
        {"view", "assets, a scene and its trace as a page that opens from disk",
         "voxshell view part.voxmap part.pointshell -o part.html\nvoxshell view cup.scene.json trace.csv -o "
         "cup.html",
         add_view},
    };
    return table;
}

} // namespace voxshell
