#!/usr/bin/env bash
# Synthesis side by side with Embark's texture-synthesis (an image synthesiser): the same exemplars, the same number of pixels, a
# flat grid of vertices here and an image there. Prints processor seconds and the measures of fidelity of both.
#
#   cargo install texture-synthesis-cli --version 0.8.3 --locked --root /some/where
#   benches/peers/synth.sh /some/where/bin/texture-synthesis IMAGE...
#
# SIDE is the side of the results, 160 by default.
set -euo pipefail
peer="$1"; shift
side="${SIDE:-160}"
here="$(cd "$(dirname "$0")/../.." && pwd)"
images=(); for i in "$@"; do images+=("$(realpath "$i")"); done
work="$(mktemp -d)"; trap 'rm -rf "$work"' EXIT
cd "$work"
bench="${BENCH:-cargo bench --quiet --manifest-path $here/Cargo.toml --bench synth --}"
$bench grid "$side" "${images[@]}"
for image in "${images[@]}"; do
  stem="$(basename "${image%.*}")"
  TIMEFORMAT="peer $image ${side}x${side} %R (%U + %S)"
  time "$peer" --out-size "${side}x${side}" -o "$stem-peer.png" generate "$stem-exemplar.png" >/dev/null 2>&1
  for result in lapped peer; do $bench measure "$stem-$result.png" "$stem-exemplar.png"; done
done
