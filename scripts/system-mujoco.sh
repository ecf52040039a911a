#!/usr/bin/env bash
# Makes sure that feature `system` finds a MuJoCo on this machine, and prints what to put into the environment, if anything:
#
#     eval "$(scripts/system-mujoco.sh)"
#
# An installed MuJoCo is used as it is. Otherwise Debian's libmujoco-dev is unpacked into third_party, which needs no root and
# changes nothing else. All other output goes to stderr. The script fails where no MuJoCo can be found or downloaded.
set -euo pipefail
cd "$(dirname "$0")/.."

has_headers() { echo '#include <mujoco/mujoco.h>' | "${CC:-cc}" -E - > /dev/null 2>&1; }

# The packages and what they need beyond a C++ runtime, unpacked side by side.
unpack() {
    local target=third_party/mujoco-debian work packages
    if ! test -e $target/usr/include/mujoco/mujoco.h; then
        work=$(mktemp -d third_party/debian.XXXXXX)
        # A fresh machine may have no package lists yet.
        apt-cache show libmujoco-dev > /dev/null 2>&1 || apt-get update -qq >&2 || true
        packages=$(apt-cache depends --recurse --no-recommends --no-suggests --no-conflicts --no-breaks --no-replaces \
            --no-enhances libmujoco-dev | grep '^lib' | grep -v -e '^libc6' -e '^libgcc' -e '^libstdc++' -e '^libcrypt')
        # shellcheck disable=SC2086 # a list of names
        (cd "$work" && test -n "$packages" && apt-get download -qq $packages && for package in *.deb; do dpkg -x "$package" root || exit 1; done) &&
            rm -rf $target && mv "$work/root" $target || { rm -rf "$work"; return 1; }
        rm -rf "$work"
    fi
    echo "export COPQ_MUJOCO_DIR='$PWD/$target/usr'"
    echo "export LD_LIBRARY_PATH='$(dirname "$(find "$PWD/$target/usr/lib" -name 'libmujoco.so' | head -n 1)")'\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
}

if test -n "${COPQ_MUJOCO_DIR:-}" || has_headers; then
    echo "MuJoCo's headers are there" >&2
elif ! command -v apt-get > /dev/null; then
    echo "no MuJoCo on this machine, and no apt-get to download Debian's libmujoco-dev" >&2
    exit 1
else
    mkdir -p third_party
    unpack || { echo "libmujoco-dev could not be downloaded; perhaps apt-get update helps" >&2; exit 1; }
    echo "unpacked libmujoco-dev into third_party" >&2
fi
