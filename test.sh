#!/usr/bin/env bash
# Installs what is missing, builds with warnings as errors, checks the formatting, runs all tests.
#   ./test.sh              everything, optimised
#   ./test.sh --sanitize   unit, contract and process tests under address and UB sanitizers
# The exit code is that of the tests.
set -euo pipefail
exec </dev/null
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")"
source .ci/install.sh
source .ci/network.sh

case "${1-}" in
  "") preset=ci ;;
  --sanitize) preset=asan-ubsan ;;
  -h | --help) sed -n '2,5s/^# //p' test.sh; exit 0 ;;
  *) echo "test.sh: unknown option '$1'; there is --sanitize" >&2; exit 2 ;;
esac

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

install_missing "${build_packages[@]}" "${test_packages[@]}"
check_format
cmake --preset "$preset"
cmake --build --preset "$preset"
tests=(ctest --preset "$preset" --no-label-summary)
if ! on_loopback "${tests[@]}" -j "$(nproc)"; then
  # Process tests watch real time-outs, which a busy machine can upset: what failed is run once
  # more, alone, and both results are shown. A defect fails twice.
  echo "Some tests failed: the same ones again, one at a time."
  on_loopback "${tests[@]}" -j 1 --rerun-failed
fi
