#!/usr/bin/env bash
# The claims of the paper and of this project, judged by the runs in results/: one table for each sweep file.
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-cargo run --release --features mujoco --}
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
for name in default precision-rapier protocol figure-3 figure-4 figure-5 figure-6; do
  # In a separate folder, so that only the runs in results/ count.
  printf 'out = "%s"\nfiles = ["%s"]\n' "$folder/runs" "$PWD/experiments/$name.toml" > "$folder/$name.toml"
  $copq sweep report "$folder/$name.toml" --from results --out "$folder/page.html" --parts "$folder/$name"
  cp "$folder/$name/claims.md" "results/claims/$name.md"
  cp "$folder/$name/claims.csv" "results/claims/$name.csv"
done
