# SPDX-License-Identifier: MIT
# From a bare Debian 12 to a configured build, once for samples/demo.sh and tests/run.sh (both source this file).
# Sets `root`, the folder of the repository. Expects `set -eu`.
root=$(cd "$(dirname "$0")/.." && pwd)

# A compiler of OpenVDB or CGAL code takes up to 1.5 GB: no more jobs than fit.
jobs=$(awk -v cores="$(nproc)" '/^MemTotal/ { fit = int($2 / 1.5e6); print fit < 1 ? 1 : fit < cores ? fit : cores }' /proc/meminfo)

say() { printf '\n== %s\n' "$*"; }

# install_packages [COMMENT]: what is missing of tests/packages.txt, up to the line that begins with this comment.
install_packages() {
    if ! command -v apt-get >/dev/null; then
        say "no apt-get here: going on with what is installed (tests/packages.txt names what Debian 12 would need)"
        return
    fi
    missing=
    for package in $(sed "${1:+\|^# $1|q}" "$root/tests/packages.txt" | grep -v '^#'); do
        case $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true) in
        installed) ;;
        *) missing="$missing $package" ;;
        esac
    done
    if [ -z "$missing" ]; then
        return
    fi
    say "installing$missing"
    sudo=
    if [ "$(id -u)" != 0 ]; then
        command -v sudo >/dev/null || { echo "voxshell: error: neither root nor sudo: ask for these packages:$missing" >&2; exit 2; }
        sudo=sudo
    fi
    $sudo apt-get update -qq
    # shellcheck disable=SC2086 # a list of packages
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
}

# configure FOLDER PRESET [CMAKE-OPTION...]: build/FOLDER, quietly if nothing is wrong.
configure() {
    folder=$root/build/$1
    preset=$2
    shift 2
    mkdir -p "$folder"
    (cd "$root" && cmake --preset "$preset" -B "$folder" "$@" >"$folder/configure.log" 2>&1) ||
        { cat "$folder/configure.log" >&2; exit 1; }
}

# build FOLDER [TARGET...]: everything, or these.
build() {
    say "building build/$1"
    folder=$root/build/$1
    shift
    cmake --build "$folder" -j "$jobs" ${1:+--target} "$@"
}
