#!/usr/bin/env bash
# Installs what is missing, checks formatting, scripts and package lists, builds with warnings as
# errors, runs all tests.
#   ./test.sh                    everything, optimised
#   ./test.sh --sanitize         unit, contract and process tests under address and UB sanitizers
#   ./test.sh --long             everything, and what takes more than half an hour: every advice is run
#   ./test.sh --configure-only   installs what is missing and configures; builds and tests nothing
# The exit code is that of the tests.
set -euo pipefail
exec </dev/null
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")"
source .ci/install.sh
source .ci/network.sh

preset=ci
configure_only=false
for option in "$@"; do
  case "$option" in
    --sanitize) preset=asan-ubsan ;;
    --long) export TANDEM_LONG=1 ;;
    --configure-only) configure_only=true ;;
    -h | --help) sed -n '2,8s/^# //p' test.sh; exit 0 ;;
    *) echo "test.sh: unknown option '$option'; there are --sanitize, --long and --configure-only" >&2; exit 2 ;;
  esac
done

check_format() {
  local version
  version=$(clang-format --version 2>/dev/null | sed -n 's/.*version \([0-9]*\).*/\1/p') || true
  if [[ $version != 14 ]]; then
    echo "Formatting not checked: it is that of clang-format 14, here is ${version:-none}."
    return 0
  fi
  find protocol mbs_process fem_process orchestrator tests \( -name '*.h' -o -name '*.cpp' \) -print0 |
    xargs -0 clang-format --dry-run -Werror
  echo "Formatting: good."
}

check_scripts() {
  if ! command -v shellcheck >/dev/null; then
    echo "Scripts not checked: shellcheck is not installed."
    return 0
  fi
  shellcheck -x demo.sh test.sh .ci/*
  echo "Scripts: good."
}

install_missing "${build_packages[@]}" "${test_packages[@]}"
cmake --preset "$preset"
if $configure_only; then exit 0; fi
check_format
check_scripts
if [[ $preset == ci ]]; then .ci/fresh-debian; fi
cmake --build --preset "$preset"
tests=(ctest --preset "$preset" --no-label-summary)
if ! on_loopback "${tests[@]}" -j "$(nproc)"; then
  # Process tests watch real time-outs, which a busy machine can upset: what failed is run once
  # more, alone, and both results are shown. A defect fails twice.
  echo "Some tests failed: the same ones again, one at a time."
  on_loopback "${tests[@]}" -j 1 --rerun-failed
fi
