#!/bin/bash
# cluster/supervise: goes on after SIGKILL until the bake is complete, and knows when not to.
# shellcheck source=common.sh
source "$(dirname "$0")/common.sh"

supervisor=
clean_up() {
  [ -z "$supervisor" ] || { kill -KILL "$supervisor" && wait "$supervisor"; } 2>/dev/null || true
  kill_scratch_processes
  rm -rf "$scratch"
}
trap clean_up EXIT

# expect CODE NAME COMMAND...: its output goes to $scratch/NAME.log.
expect() {
  local code=$1 name=$2 status=0
  shift 2
  "$@" >"$scratch/$name.log" 2>&1 || status=$?
  [ "$status" = "$code" ] || { cat "$scratch/$name.log" >&2; fail "$name ended with $status, not $code"; }
}
expect_said() { grep -q "$2" "$scratch/$1.log" || { cat "$scratch/$1.log" >&2; fail "$1 did not say \"$2\""; }; }

launcher_of() { children "$1" mpirun; }
has_launcher() { [ -n "$(launcher_of "$1")" ]; }

start() {  # start NAME OPTION... -- COMMAND...
  local name=$1
  shift
  set -m  # else a script's background job ignores SIGINT
  "$root/cluster/supervise" "$@" >"$scratch/$name.log" 2>&1 &
  supervisor=$!
  set +m
}
end_of() {  # end_of NAME: sets `status`
  status=0
  wait "$supervisor" || status=$?
  supervisor=
}

# Once with mpirun and all ranks at one instant, once with a single rank.
survives_two_kills() {
  local name=$1 bake=$scratch/$1/bake launcher ranks
  shift
  start "$name" --stall 5 -- mpirun "$@" -n 2 "${tiny_bake[@]}" --out "$bake"
  wait_until 60 "the first tasks" has_tasks "$bake" 4
  launcher=$(launcher_of "$supervisor")
  ranks=$(children "$launcher")
  # shellcheck disable=SC2086  # one word per rank
  kill -KILL "$launcher" $ranks
  wait_until 60 "a restart" is_gone "$launcher"
  wait_until 60 "a restart" has_launcher "$supervisor"
  wait_until 60 "more tasks" has_tasks "$bake" $(($(finished_tasks "$bake") + 1))
  ranks=$(children "$(launcher_of "$supervisor")")
  [ -n "$ranks" ] || fail "$name: no rank is left to be killed"
  kill -KILL "$(head -n 1 <<<"$ranks")"
  end_of "$name"
  [ "$status" = 0 ] || { cat "$scratch/$name.log" >&2; fail "$name ended with $status"; }
  [ -e "$bake/complete.json" ] || fail "$name: complete without its marker"
  expect_said "$name" 'complete after 3 starts'
  expect_same_bake "$scratch/reference/bake" "$bake"
  echo "ok: $name"
}

"${tiny_bake[@]}" -q --out "$scratch/reference/bake"
survives_two_kills killed
survives_two_kills killed_with_recovery --enable-recovery

for recovery in "" --enable-recovery; do
  # shellcheck disable=SC2086  # none or one word
  expect 2 bad "$root/cluster/supervise" --bake "$scratch/bad" -- \
    mpirun $recovery -n 2 "${tiny_bake[@]}" --set nonsense=1 --out "$scratch/bad"
  expect_said bad 'unknown key "nonsense"'
  expect_said bad 'not started again'
done
echo "ok: bad input is not started again"

expect 1 dying "$root/cluster/supervise" --most-fruitless 2 --bake "$scratch/dying" -- \
  bash -c "echo start >>$scratch/starts; kill -KILL \$\$"
[ "$(wc -l <"$scratch/starts")" = 2 ] || fail "a command that always dies was not started twice"
expect_said dying '2 starts in a row finished no task (last exit code 137)'
echo "ok: given up after fruitless starts"

# A finished bake: checked and left as it is; a failing job on it is not taken for success.
before=$(stat -c '%i %Y' "$scratch/reference/bake/complete.json")
expect 0 finished "$root/cluster/supervise" -- "${tiny_bake[@]}" --out "$scratch/reference/bake"
[ "$before" = "$(stat -c '%i %Y' "$scratch/reference/bake/complete.json")" ] || fail "the marker was written again"
expect 0 finished "$root/cluster/supervise" -- \
  mpirun --enable-recovery -n 2 "${tiny_bake[@]}" --out "$scratch/reference/bake"
for recovery in "" --enable-recovery; do
  # shellcheck disable=SC2086  # none or one word
  expect 1 stale "$root/cluster/supervise" --most-fruitless 1 --bake "$scratch/reference/bake" -- \
    mpirun $recovery -n 1 bash -c 'kill -KILL $$'
done
echo "ok: an old marker proves nothing"

for signal in TERM USR1 INT; do
  bake=$scratch/stopped_by_$signal/bake
  # On a busy machine the signal may come after the end: such a try says nothing.
  for try in 1 2 3 4 5; do
    rm -rf "$bake"
    start stopped -- mpirun -n 2 "${tiny_bake[@]}" --out "$bake"
    wait_until 60 "the first tasks" has_tasks "$bake" 4
    kill -s "$signal" "$supervisor"
    end_of stopped
    [ -e "$bake/complete.json" ] || break
    echo "try $try: the bake was done before SIG$signal came"
  done
  [ "$status" = 3 ] || { cat "$scratch/stopped.log" >&2; fail "stopped by SIG$signal, it ended with $status, not 3"; }
  expect_said stopped "stopped by SIG$signal; the same command goes on"
  [ ! -e "$bake/complete.json" ] || fail "it was stopped too late to tell"
  expect 0 resumed "$root/cluster/supervise" -- mpirun -n 2 "${tiny_bake[@]}" --out "$bake"
  expect_same_bake "$scratch/reference/bake" "$bake"
done
echo "ok: signals are passed on, and the same command goes on"
