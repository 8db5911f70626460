#!/bin/bash
# Three hosts (network namespaces) that bake over TCP: a rank dies, then whole hosts, and the bytes are
# those of a plain bake.
# shellcheck source=common.sh
source "$(dirname "$0")/common.sh"
not_run="three hosts that bake over TCP, a lost rank and lost hosts"
[ "$(id -u)" = 0 ] || skip "$not_run: network namespaces need root"
command -v ip >/dev/null || skip "$not_run: there is no \"ip\" (package iproute2)"
hosts=$root/cluster/hosts
name=prt$$
"$hosts/up" "$name" 3 2>"$scratch/up.log" ||
  skip "$not_run: no network namespaces can be made here: $(tail -n 1 "$scratch/up.log")"

job=
clean_up() {
  [ -z "$job" ] || { kill -KILL "$job" && wait "$job"; } 2>/dev/null || true
  "$hosts/down" "$name"
  kill_scratch_processes
  rm -rf "$scratch"
}
trap clean_up EXIT

# Three ranks of one thread on three hosts.
over_hosts() { "$hosts/mpirun" "$name" -n "$1" "${tiny_bake[@]}" --threads 1 --out "$2"; }

start() {  # start BAKE: until it is well under way; its output goes to $scratch/job.log
  over_hosts 3 "$1" >"$scratch/job.log" 2>&1 &
  job=$!
  wait_until 60 "the first tasks" has_tasks "$1" 4
}

# expect_death BAKE: the job ends by itself, without having finished.
expect_death() {
  wait_until 60 "the end of the job" is_gone "$job"
  local status=0
  { wait "$job" || status=$?; } 2>/dev/null
  job=
  [ "$status" != 0 ] || { cat "$scratch/job.log" >&2; fail "a job that lost a part of itself ended with 0"; }
  [ ! -e "$1/complete.json" ] || fail "the bake was complete before anything could be killed"
  wait_until 30 "the other hosts' ranks to go" no_ranks
  echo "ok: the job ended with $status, $(finished_tasks "$1") tasks are done"
}

ranks_on() {
  local pid comm
  for pid in $(ip netns pids "$1"); do
    { read -r comm <"/proc/$pid/comm"; } 2>/dev/null || continue
    [ "$comm" != prt_bake ] || echo "$pid"
  done
}
no_ranks() { [ -z "$(ranks_on "$name-1")$(ranks_on "$name-2")$(ranks_on "$name-3")" ]; }

# resumed BAKE RANKS: made complete, with the reference's bytes.
resumed() {
  over_hosts "$2" "$1" >"$scratch/job.log" 2>&1 || { cat "$scratch/job.log" >&2; fail "the resumed bake ended with $?"; }
  grep -Eq ' [1-9][0-9]* found' "$scratch/job.log" || fail "the resumed bake found nothing that was done"
  expect_same_bake "$scratch/reference/bake" "$1"
  echo "ok: resumed on $2 hosts, same bytes"
}

"${tiny_bake[@]}" -q --out "$scratch/reference/bake"
over_hosts 3 "$scratch/undisturbed/bake" >"$scratch/job.log" 2>&1 ||
  { cat "$scratch/job.log" >&2; fail "three hosts do not bake"; }
for i in 1 2 3; do
  grep -q "1 rank on $name-$i" "$scratch/job.log" || fail "no rank ran on host $i"
done
expect_same_bake "$scratch/reference/bake" "$scratch/undisturbed/bake"
echo "ok: one rank on each of three hosts, same bytes"

start "$scratch/rank/bake"
victim=$(ranks_on "$name-2")
[ -n "$victim" ] || fail "no rank on host 2"
kill -KILL "$victim"
expect_death "$scratch/rank/bake"
resumed "$scratch/rank/bake" 3

# With --enable-recovery the other hosts go on by themselves. mpirun's exit code says nothing then.
bake=$scratch/recovery/bake
"$hosts/mpirun" "$name" -n 3 --enable-recovery "${tiny_bake[@]}" --set jobs.lease=2 --threads 1 --out "$bake" \
  >"$scratch/job.log" 2>&1 &
job=$!
wait_until 60 "the first tasks" has_tasks "$bake" 4
victim=$(ranks_on "$name-2")
[ -n "$victim" ] || fail "no rank on host 2"
kill -KILL "$victim"
[ ! -e "$bake/complete.json" ] || fail "the bake was complete before a rank could be killed"
wait_until 120 "the end of the bake that lost a rank" is_gone "$job"
wait "$job" || true
job=
[ -e "$bake/complete.json" ] || { cat "$scratch/job.log" >&2; fail "the bake did not survive the loss of a rank"; }
grep -q 'rank(s) are silent' "$scratch/job.log" || fail "nobody noticed that a rank was lost"
expect_same_bake "$scratch/reference/bake" "$bake"
echo "ok: with --enable-recovery the other hosts went on, same bytes"

# Host 3 has a worker; host 1 the coordinator and mpirun itself.
for i in 3 1; do
  bake=$scratch/host$i/bake
  start "$bake"
  "$hosts/kill" "$name-$i"
  expect_death "$bake"
  resumed "$bake" 2
done

# The same, with nobody there to start it again.
bake=$scratch/supervised/bake
"$root/cluster/supervise" -- "$hosts/mpirun" "$name" -n 3 "${tiny_bake[@]}" --threads 1 --out "$bake" \
  >"$scratch/job.log" 2>&1 &
job=$!
wait_until 60 "the first tasks" has_tasks "$bake" 4
"$hosts/kill" "$name-2"
wait_until 120 "the supervised bake" is_gone "$job"
wait "$job" || { cat "$scratch/job.log" >&2; fail "cluster/supervise ended with $?"; }
job=
grep -q 'complete after 2 starts' "$scratch/job.log" || fail "the supervised bake was not started again"
expect_same_bake "$scratch/reference/bake" "$bake"
echo "ok: cluster/supervise brought a bake over a lost host, same bytes"
