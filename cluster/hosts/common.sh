# Sourced by the scripts beside it. A NAME stands for a set of hosts on this machine: network namespaces
# NAME-1, NAME-2, ... with the addresses 10.77.0.1, 10.77.0.2, ... on one Ethernet. The switch between them
# is a bridge in a namespace of its own, NAME-net: the machine's own network is left as it is, and several
# sets can live side by side.
# shellcheck shell=bash
set -euo pipefail
# shellcheck disable=SC2034  # the scripts use it
hosts_subnet=10.77.0

fail() {
  printf '%s\n' "$*" >&2
  exit 1
}

# Kernel interface names have 15 characters; ours are shorter whatever the NAME is.
check_name() { [[ ${1:-} =~ ^[a-z][a-z0-9]*$ ]] || fail "a set of hosts is named with small letters and digits, not \"${1:-}\""; }

namespaces_of() { ip netns list | awk -v start="$1-" 'index($1, start) == 1 {print $1}'; }
hosts_of() { namespaces_of "$1" | sed '/-net$/d' | sort -V; }
