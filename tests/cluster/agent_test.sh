#!/bin/bash
# docker/agent in place of a remote shell, between two hosts (network namespaces) that share a folder, as
# two containers do.
# shellcheck source=common.sh
source "$(dirname "$0")/common.sh"
not_run="two hosts that bake through docker/agent, without a remote shell"
[ "$(id -u)" = 0 ] || skip "$not_run: network namespaces need root"
command -v ip >/dev/null || skip "$not_run: there is no \"ip\" (package iproute2)"
hosts=$root/cluster/hosts
name=prta$$
"$hosts/up" "$name" 2 2>"$scratch/up.log" ||
  skip "$not_run: no network namespaces can be made here: $(tail -n 1 "$scratch/up.log")"

server=
clean_up() {
  "$hosts/down" "$name"
  [ -z "$server" ] || { wait "$server" || true; } 2>/dev/null
  kill_scratch_processes
  rm -rf "$scratch"
}
trap clean_up EXIT
export PRT_AGENT_DIR=$scratch/agent

bake() {
  "$hosts/on" "$name-1" mpirun --host "$name-1:1,$name-2:1" --mca plm_rsh_agent "$root/docker/agent" --bind-to none \
    --mca btl self,tcp -n 2 "${tiny_bake[@]}" --threads 1 --out "$scratch/two/bake" >"$scratch/log" 2>&1
}

"${tiny_bake[@]}" -q --out "$scratch/reference/bake"
"$hosts/on" "$name-2" "$root/docker/agent" serve 2>/dev/null &
server=$!
bake || { cat "$scratch/log" >&2; fail "two hosts do not bake"; }
for i in 1 2; do
  grep -q "1 rank on $name-$i" "$scratch/log" || fail "no rank ran on host $i"
done
expect_same_bake "$scratch/reference/bake" "$scratch/two/bake"
echo "ok: one rank on each of two hosts without a remote shell, same bytes"

"$hosts/kill" "$name-2"
{ wait "$server" || true; } 2>/dev/null
server=
export PRT_AGENT_PATIENCE=1
! bake || fail "a bake began though a host did not answer"
grep -q "$name-2 does not answer" "$scratch/log" || { cat "$scratch/log" >&2; fail "nobody said that a host does not answer"; }
echo "ok: a host that does not answer is named"
