#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# The tools under ThreadSanitizer: tsan.sh FOLDER [MIRROR]
# TBB hands work from thread to thread within its library, where the sanitizer of another program does not see it and
# reports hundreds of races that are none. So TBB itself is built with it, from Debian's source, and then the tools
# (preset tsan) convert, batch, verify, simulate in real time and study, with several threads. Any report is a failure;
# the assets must be those of build/release. Half an hour the first time; not part of run.sh.
set -eu
[ $# -ge 1 ] || { sed -n '3,7s/^# //p' "$0" >&2; exit 1; }
source=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1/lists/partial" "$1/run"
folder=$(readlink -f "$1")
mirror=${2:-$(apt-get indextargets --format '$(SITE)' | head -n 1)}
cd "$folder"
if [ -z "$(find . -name libtbb.so.12)" ]; then
    echo "deb-src $mirror bookworm main" >sources.list
    from="-o Dir::Etc::sourcelist=$folder/sources.list -o Dir::Etc::sourceparts=- -o Dir::State::lists=$folder/lists"
    # shellcheck disable=SC2086 # a list of options
    apt-get $from update >/dev/null && apt-get $from source onetbb >/dev/null 2>&1
    cmake -S onetbb-* -B tbb -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF \
        -DCMAKE_CXX_FLAGS="-fsanitize=thread -D__TBB_USE_THREADING_TOOLS=1" >/dev/null
    cmake --build tbb --target tbb >/dev/null
fi
(cd "$source" && cmake --preset tsan >/dev/null && cmake --build build/tsan --target voxshell)
LD_LIBRARY_PATH=$(dirname "$(find "$folder" -name libtbb.so.12 | head -n 1)")
# A worker still looks at a loop's task_group_context, on the stack of the thread that waited for the loop, when that has gone
# on: TBB orders the two by a fence, which the sanitizer does not see. So where the access itself is TBB's it does not count.
echo "race_top:tbb::detail::" >suppressions
TSAN_OPTIONS="history_size=4 exitcode=66 suppressions=$folder/suppressions print_suppressions=1"
export LD_LIBRARY_PATH TSAN_OPTIONS
voxshell=$source/build/tsan/bin/voxshell samples=$source/build/release/samples
rm -rf run
mkdir run
run() {
    code=0
    "$voxshell" "$@" >run/said 2>&1 || code=$?
    # A real-time loop is late under the sanitizer, and says so with 4.
    case $1$code in *0 | simulate4) echo "tsan: ok: $1" ;; *) cat run/said; echo "tsan: FAILED: $* ($code)"; exit 1 ;; esac
}
run convert "$samples/cup.glb" "$samples/sphere.glb" -o run/assets --voxel 1mm -j3 --channels layers:3,distance:3
env -u LD_LIBRARY_PATH "$source/build/release/bin/voxshell" convert "$samples/cup.glb" "$samples/sphere.glb" -o run/plain \
    --voxel 1mm --channels layers:3,distance:3 >/dev/null
diff -r run/assets run/plain && echo "tsan: the same bytes"
run batch "$samples/cup.glb" "$samples/sphere.glb" "$samples/pair.glb" --per-part --voxel 1mm -o run/batch -j3
run convert "$samples/cup_hold.scene.json" -o run/scene -j3
run verify run/assets
run simulate "$samples/cup_press.scene.json" --realtime --seconds 2
run study accuracy "$samples/cup_press.scene.json" -o run/study --quick -j3
