# shellcheck shell=bash
# Sourced by demo.sh and test.sh: runs a command where LCM's multicast works.
#
# A network namespace of its own with nothing but the loopback needs no route, no open firewall and
# no free port on the machine, and nothing gets in or out. Where the kernel does not allow one
# (some containers), the machine's own network serves if it has a route to LCM's group.

# Inside of the namespace: loopback up, multicast to it, then the command.
readonly loopback_only='ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"'

# on_loopback COMMAND…
on_loopback() {
  local options
  for options in -n -rn; do
    [[ $options == -n && $EUID -ne 0 ]] && continue
    if unshare "$options" sh -c "$loopback_only" sh true 2>/dev/null; then
      unshare "$options" sh -c "$loopback_only" sh "$@"
      return
    fi
  done
  echo "No network namespace can be made here: using the machine's own network."
  if command -v ip >/dev/null && ! ip route get 239.255.76.67 >/dev/null 2>&1; then
    echo "This machine has no route for multicast, which LCM needs. Add one, as root:" >&2
    echo "  ip route add 224.0.0.0/4 dev lo" >&2
    return 4
  fi
  "$@"
}
