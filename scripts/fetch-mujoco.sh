#!/usr/bin/env bash
# Fetches MuJoCo 3.17.0 for feature `mujoco-rs` into third_party/mujoco-3.17.0 (git-ignored): library, headers, licences.
# It comes from the wheel on PyPI, whose hash is pinned below. Needs python3 with pip, on x86-64 Linux. Safe to run again.
set -euo pipefail
cd "$(dirname "$0")/.."

version=3.17.0
hash=d66928d86a2d1b601bbaa4dc11db50214d17d5301bb8afd84721313b67ff0874
target=third_party/mujoco-$version

if test -e "$target/lib/libmujoco.so"; then
    echo "MuJoCo $version is already in $target"
    exit
fi
if test "$(uname -sm)" != "Linux x86_64"; then
    echo "this script knows the wheel for x86-64 Linux only; take MuJoCo $version from its own releases" \
        "and set MUJOCO_DYNAMIC_LINK_DIR to its lib folder" >&2
    exit 1
fi

if test -e "$target"; then
    # An empty folder that somebody else made may be removed; anything else is not ours to delete.
    rmdir "$target" 2> /dev/null || { echo "there is a $target without lib/libmujoco.so: move it away" >&2; exit 1; }
fi
mkdir -p third_party
work=$(mktemp -d third_party/fetch.XXXXXX)
trap 'rm -rf "$work"' EXIT
echo "mujoco==$version --hash=sha256:$hash" > "$work/requirements.txt"
python3 -m pip download --quiet --disable-pip-version-check --require-hashes --no-deps --only-binary=:all: \
    --python-version 3.11 --implementation cp --abi cp311 \
    --platform manylinux_2_28_x86_64 --platform manylinux_2_27_x86_64 \
    --requirement "$work/requirements.txt" --dest "$work"
python3 -m zipfile -e "$work"/mujoco-*.whl "$work/wheel"

mkdir -p "$work/mujoco/lib"
cp "$work/wheel/mujoco/libmujoco.so.$version" "$work/mujoco/lib/"
ln -s "libmujoco.so.$version" "$work/mujoco/lib/libmujoco.so"
cp -r "$work/wheel/mujoco/include" "$work/mujoco/include"
cp -r "$work"/wheel/mujoco-$version.dist-info/licenses "$work/mujoco/licenses"
# This comes last and in one step, so that an interrupted run leaves nothing that looks complete.
mv "$work/mujoco" "$target"
echo "MuJoCo $version is in $target"
