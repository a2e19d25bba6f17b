#!/usr/bin/env bash
# Builds Tandem and answers its question for one model: what does coupling cost?
#   ./demo.sh [SCENARIO] [--repeat N]     default: examples/lug/scenario.yaml, 3 repeats
#   ./demo.sh --configure-only            installs what is missing and configures; builds nothing
set -euo pipefail
exec </dev/null
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
scenario=$here/examples/lug/scenario.yaml
repeat=3
configure_only=false
while [[ $# -gt 0 ]]; do
  case "$1" in
    -h | --help) sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
    --repeat) repeat=${2:?--repeat needs a number}; shift 2 ;;
    --configure-only) configure_only=true; shift ;;
    -*) echo "demo.sh: unknown option '$1'; there are --repeat N and --configure-only" >&2; exit 2 ;;
    *)
      [[ -f $1 ]] || { echo "demo.sh: there is no scenario '$1'" >&2; exit 2; }
      scenario=$(readlink -f "$1")
      shift
      ;;
  esac
done
cd "$here"
source .ci/install.sh
source .ci/network.sh

install_missing "${build_packages[@]}"
# What runs, without tests and benchmarks.
configure() { cmake --preset release -DTANDEM_TESTS=OFF; }
if $configure_only; then
  configure
  exit 0
fi

# One line for every tenth of the build, of ninja's lines "[done/all] …", with the time that the
# rest takes if it is as long as what is done.
show_progress() {
  local line percent shown=0 begin=$SECONDS rest
  while IFS= read -r line; do
    [[ $line =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    percent=$((100 * BASH_REMATCH[1] / BASH_REMATCH[2]))
    if ((percent >= shown + 10)); then
      shown=$((percent / 10 * 10))
      rest=$(((SECONDS - begin) * (100 - percent) / percent))
      if ((shown < 100)); then echo "  $shown % built, about $rest s to go"; else echo "  built"; fi
    fi
  done
}
build() {
  configure &&
    cmake --build --preset release --target tandem tandem-mbs tandem-fem
}

log=build/release/build.log
mkdir -p build/release
echo "Building tandem, tandem-mbs and tandem-fem (a few minutes the first time; log: $log) …"
if ! build 2>&1 | tee "$log" | show_progress; then
  tail -n 40 "$log" >&2
  echo "The build failed; the whole log is in $PWD/$log" >&2
  exit 1
fi

cat <<TEXT

Running ${scenario#"$here"/} $repeat times in each of three ways, by turns:
  lcm         two processes: rigid bodies (ODE) and finite elements, exchanging over LCM
  inproc      the same scheme in one process: the same bits, without transfer
  monolithic  one coupled system per step: the reference for cost and for coupling error

TEXT
on_loopback build/release/bin/tandem compare "$scenario" --repeat "$repeat"
