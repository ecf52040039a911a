#!/usr/bin/env bash
# Makes the Python environments that tests and experiments/python.toml use, in third_party (git-ignored): third_party/gymnasium with
# Gymnasium, MO-Gymnasium and what reads exported policies; third_party/safety-gymnasium with Safety-Gymnasium, which needs Python 3.8
# to 3.10. Needs PyPI. What cannot be installed is reported and left out, and its tests are skipped. Safe to run again.
set -euo pipefail
cd "$(dirname "$0")/.."

# Prints the first Python, the system's or pyenv's, that is of one of the given versions.
python_of() {
    local version python
    for version in "$@"; do
        for python in "python$version" "${PYENV_ROOT:-$HOME/.pyenv}"/versions/"$version".*/bin/python; do
            if "$python" -c "import sys, venv, ensurepip; assert '%d.%d' % sys.version_info[:2] == '$version'" 2> /dev/null; then
                echo "$python"
                return
            fi
        done
    done
}

environment() {
    local name=$1 python folder=third_party/$1 wanted=scripts/python-worlds/$1.txt
    python=$(python_of "${@:2}")
    if cmp -s "$wanted" "$folder/installed.txt" && "$folder/bin/python" -c ''; then
        echo "$folder is there already"
    elif test -z "$python"; then
        printf '\n!! SKIPPED: %s, for there is no Python %s with venv\n' "$folder" "${*:2}"
    elif rm -rf "$folder" && "$python" -m venv "$folder" && "$folder/bin/pip" install --quiet --requirement "$wanted"; then
        cp "$wanted" "$folder/installed.txt"
        echo "made $folder"
    else
        rm -rf "$folder"
        printf '\n!! SKIPPED: %s, for its packages could not be had\n' "$folder"
    fi
}

mkdir -p third_party
environment gymnasium 3.11 3.12 3.13
environment safety-gymnasium 3.10 3.9 3.8
