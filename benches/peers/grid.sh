#!/usr/bin/env bash
# What Embark's texture-synthesis (an image synthesiser) makes of the exemplars of a comparison: images of 512 pixels a side from
# exemplars of 128, measured as surfaces are. Prints the measures of each, and of the exemplar itself: a verbatim copy.
#
#   cargo install texture-synthesis-cli --version 0.8.3 --locked --root /some/where
#   benches/peers/grid.sh /some/where/bin/texture-synthesis IMAGE...
set -euo pipefail
peer="$1"; shift
here="$(cd "$(dirname "$0")/../.." && pwd)"
images=(); for i in "$@"; do images+=("$(realpath "$i")"); done
work="$(mktemp -d)"; trap 'rm -rf "$work"' EXIT
cd "$work"
bench="${BENCH:-cargo bench --quiet --manifest-path $here/Cargo.toml --bench synth --}"
$bench exemplars 128 "${images[@]}"
for image in "${images[@]}"; do
  stem="$(basename "${image%.*}")"
  "$peer" --out-size 512x512 -o "$stem-peer.png" generate "$stem-exemplar.png" >/dev/null 2>&1
  for result in exemplar peer; do $bench measure "$stem-$result.png" "$stem-exemplar.png"; done
done
