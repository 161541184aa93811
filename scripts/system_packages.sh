#!/bin/sh
# Make sure system packages are there: system_packages.sh python|egl|chromium|ffmpeg ...
# Installs with apt where this user may; otherwise says what is missing and how to get it.
set -eu

missing=
need() { missing="$missing $*"; }
has_library() { ldconfig -p 2>/dev/null | grep -q "$1" || [ -e "/usr/lib/x86_64-linux-gnu/$1" ]; }

for what in "$@"; do
    case $what in
    python)
        for candidate in python3.11 python3.12 python3; do
            if command -v "$candidate" >/dev/null 2>&1 &&
                "$candidate" -c 'import sys, ensurepip, venv; sys.exit(not (3, 11) <= sys.version_info < (3, 13))' 2>/dev/null; then
                continue 2
            fi
        done
        need python3 python3-venv
        ;;
    egl)
        has_library libEGL.so.1 || need libegl1
        has_library libGL.so.1 || need libgl1
        [ -n "$(ls /usr/lib/*/dri/swrast_dri.so /usr/lib/*/libgallium*.so 2>/dev/null)" ] || need libgl1-mesa-dri
        ;;
    chromium) command -v chromium >/dev/null 2>&1 || need chromium fonts-dejavu-core ;;
    ffmpeg) command -v ffprobe >/dev/null 2>&1 || need ffmpeg ;;
    esac
done
[ -z "$missing" ] && exit 0

run=
if command -v apt-get >/dev/null 2>&1; then
    if [ "$(id -u)" = 0 ]; then run="env DEBIAN_FRONTEND=noninteractive"
    elif sudo -n true 2>/dev/null; then run="sudo -n env DEBIAN_FRONTEND=noninteractive"
    fi
fi
if [ -n "$run" ]; then
    echo "Installing system packages:$missing"
    $run apt-get update -qq
    # shellcheck disable=SC2086
    $run apt-get install -y -qq --no-install-recommends $missing >/dev/null
else
    echo "These system packages are missing:$missing" >&2
    echo "Install them, for example: sudo apt-get install$missing" >&2
    exit 1
fi
