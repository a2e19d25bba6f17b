# shellcheck shell=bash
# shellcheck disable=SC2034  # the lists are used by those who source this
# Sourced by demo.sh and test.sh: the Debian packages that Tandem needs, and install_missing.
# Every find_package, pkg_check_modules, find_library and find_program of the build is served here,
# and every program that scripts and tests call; .ci/fresh-debian checks it where nothing else is.

# To build and to run.
build_packages=(
  g++ cmake ninja-build pkg-config
  libeigen3-dev                                          # linear algebra
  libspectra-dev                                         # eigenvalues
  libode-dev                                             # rigid bodies
  libsuitesparse-dev libopenblas0-pthread libopenblas-dev  # sparse Cholesky
  liblcm-dev liblcm-bin libglib2.0-dev                   # LCM; its pkg-config file needs glib's
  libyaml-cpp-dev nlohmann-json3-dev libcli11-dev libfmt-dev zlib1g-dev
  iproute2                                               # multicast route of the scripts
)
# To test as well, and to check the formatting (Debian 12: clang-format 14).
test_packages=(libgtest-dev libbenchmark-dev clang-format)

# is_installed PACKAGE ARCHITECTURE: dpkg has it unpacked and configured, for this machine or for all.
# dpkg also knows packages that are not there: those that another one merely mentions
# ("not-installed"), removed ones ("config-files"), broken ones. They are apt's to install or to mend.
# Triggers yet to run (caches, indices) do not keep a package from being used; apt leaves them alone.
is_installed() {
  local state architecture
  while read -r state architecture; do
    [[ $architecture == "$2" || $architecture == all ]] || continue
    case $state in installed | triggers-awaited | triggers-pending) return 0 ;; esac
  done < <(dpkg-query -W -f='${db:Status-Status} ${Architecture}\n' "$1" 2>/dev/null)
  return 1
}

# install_missing PACKAGE…: installs those that are not there yet; asks nothing.
install_missing() {
  local package architecture missing=() as_root=()
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "This is not a Debian system: install the counterparts of these packages yourself:"
    echo "  $*"
    return 0
  fi
  architecture=$(dpkg --print-architecture)
  for package in "$@"; do
    is_installed "$package" "$architecture" || missing+=("$package")
  done
  [[ ${#missing[@]} -eq 0 ]] && return 0

  if [[ $(id -u) -ne 0 ]]; then
    if ! command -v sudo >/dev/null; then
      echo "These packages are missing, and there is neither root nor sudo to install them. As root:" >&2
      echo "  apt-get update && apt-get install --no-install-recommends ${missing[*]}" >&2
      return 1
    fi
    as_root=(sudo)
  fi
  echo "Installing ${#missing[@]} packages: ${missing[*]}"
  as_root+=(env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 -qq)
  "${as_root[@]}" update || echo "apt-get update failed: going on with the package lists that are here" >&2
  if ! "${as_root[@]}" install -y --no-install-recommends "${missing[@]}" >/dev/null; then
    echo "The packages could not be installed: apt-get says why above. When that is mended, start again, or:" >&2
    echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
    return 1
  fi
}
