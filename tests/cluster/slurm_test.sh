#!/bin/bash
# cluster/slurm/prt_bake.sbatch under a real Slurm of two nodes, which this test starts: bakes, requeues,
# cancellation. All of Slurm's state lies in the test's scratch folder.
# shellcheck source=common.sh
source "$(dirname "$0")/common.sh"
not_run="bakes as batch jobs on two Slurm nodes, with requeues"
[ "$(id -u)" = 0 ] || skip "$not_run: slurmd and munged are started here as root"
for program in munged slurmctld slurmd sbatch; do
  command -v "$program" >/dev/null ||
    skip "$not_run: there is no $program (packages slurm-wlm and munge)"
done

daemons=()
clean_up() {
  local i
  # Last started, first killed. A node's processes all go with its first one (--kill-child).
  for ((i = ${#daemons[@]} - 1; i >= 0; --i)); do
    { kill -KILL "${daemons[i]}" && wait "${daemons[i]}"; } 2>/dev/null || true
  done
  kill_scratch_processes
  rm -rf "$scratch"
}
trap clean_up EXIT

daemon() {  # daemon NAME COMMAND...: runs it; it stays in the foreground, its output goes to log/NAME
  local name=$1
  shift
  "$@" </dev/null >"$scratch/log/$name" 2>&1 &
  daemons+=($!)
}

write_configuration() {
  local port=$((20000 + $$ % 9000 * 4))
  mkdir "$scratch/log" "$scratch/state" "$scratch/pmix" "$scratch/munge"
  cat >"$scratch/slurm.conf" <<END
ClusterName=prt
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort=$port
AuthType=auth/munge
CredType=cred/munge
# A requeued job waits until its old credential has expired (2 minutes, if nothing is said).
AuthInfo=socket=$scratch/munge/socket,cred_expire=10
SlurmctldPidFile=$scratch/slurmctld.pid
SlurmdPidFile=$scratch/slurmd.%n.pid
StateSaveLocation=$scratch/state
SlurmdSpoolDir=$scratch/spool.%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=pmix
ReturnToService=2
KillWait=10
MinJobAge=600
SchedulerParameters=batch_sched_delay=0,sched_interval=1
NodeName=n[1-2] NodeAddr=127.0.0.1 Port=[$((port + 1))-$((port + 2))] CPUs=$(nproc) State=UNKNOWN
PartitionName=bake Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
  echo "PMIxCliTmpDirBase=$scratch/pmix" >"$scratch/mpi.conf"
  export SLURM_CONF=$scratch/slurm.conf
}

start_munge() {
  dd if=/dev/urandom of="$scratch/munge/key" bs=128 count=1 status=none
  chmod 400 "$scratch/munge/key"
  daemon munged munged --foreground --force --key-file="$scratch/munge/key" --socket="$scratch/munge/socket" \
    --pid-file="$scratch/munge/pid" --log-file="$scratch/log/munged.log" --seed-file="$scratch/munge/seed"
  wait_until 30 "munged" test -S "$scratch/munge/socket"
}

# A node: processes, host name and PMIx's temporary folder of its own.
# shellcheck disable=SC2016  # expanded there
start_node() {
  daemon "$1" unshare --pid --fork --kill-child --mount-proc --uts --mount --propagation private \
    bash -c 'hostname "$1" && mount -t tmpfs none "$2/pmix" && exec slurmd -D -N "$1"' _ "$1" "$scratch"
}
nodes_are_idle() {
  sleep 0.3
  [ "$(sinfo -h -N -o %T 2>/dev/null | sort -u)" = idle ]
}

start_slurm() {
  write_configuration
  start_munge
  daemon slurmctld slurmctld -D
  start_node n1
  start_node n2
  becomes 60 nodes_are_idle && return 0
  tail -n 5 "$scratch"/log/* >&2
  fail "Slurm did not start"
}

submit() {  # submit BAKE OPTION...: sets `job` and `bake`; the log is BAKE.log
  bake=$1
  shift
  mkdir -p "$(dirname "$bake")"
  job=$(PRT_ROOT=$root PRT_BIN=$bin sbatch --parsable --output="$bake.log" "$@" \
    "$root/cluster/slurm/prt_bake.sbatch" "${tiny_bake[@]:1}" --threads 1 --out "$bake")
}
job_field() { scontrol --oneliner show job "$job" | tr ' ' '\n' | sed -n "s/^$1=//p"; }
has_state() { [[ " $1 " == *" $(job_field JobState) "* ]]; }
# Slurm need not be asked fifty times a second.
ended() {
  sleep 0.3
  has_state "COMPLETED FAILED CANCELLED TIMEOUT NODE_FAIL"
}

# expect_complete RESTARTS NAME
expect_complete() {
  local node
  wait_until 180 "$2" ended
  if [ "$(job_field JobState)" != COMPLETED ] || [ "$(job_field Restarts)" != "$1" ]; then
    cat "$bake.log" >&2
    fail "$2: $(job_field JobState) after $(job_field Restarts) restarts"
  fi
  for node in n1 n2; do
    grep -q "1 rank on $node" "$bake.log" || { cat "$bake.log" >&2; fail "$2: no rank ran on $node"; }
  done
  expect_same_bake "$scratch/reference/bake" "$bake"
  echo "ok: $2, $(job_field Restarts) restarts, same bytes"
}

"${tiny_bake[@]}" -q --out "$scratch/reference/bake"
start_slurm

submit "$scratch/plain/bake"
expect_complete 0 "a batch job on two nodes"
submit "$scratch/warned/bake"
wait_until 60 "the first tasks" has_tasks "$bake" 4
scancel --batch --signal=USR1 "$job"
expect_complete 1 "a job that was warned"
grep -q 'queued again' "$bake.log" || fail "the job did not queue itself again"

submit "$scratch/killed/bake"
wait_until 60 "the first tasks" has_tasks "$bake" 4
ranks=$(scratch_processes prt_bake)
[ -n "$ranks" ] || fail "no rank is left to be killed"
kill -KILL "${ranks##*$'\n'}"
expect_complete 0 "a job that lost a rank"
grep -q 'complete after 2 starts' "$bake.log" || fail "the job step was not started again"

PRT_LAUNCHER='mpirun --bind-to none' submit "$scratch/mpirun/bake"
expect_complete 0 "a job whose ranks mpirun starts"

submit "$scratch/requeued/bake"
wait_until 60 "the first tasks" has_tasks "$bake" 4
scontrol requeue "$job"
expect_complete 1 "a job that Slurm queued again"

submit "$scratch/cancelled/bake"
wait_until 60 "the first tasks" has_tasks "$bake" 4
scancel "$job"
wait_until 60 "the end of a cancelled job" ended
[ "$(job_field JobState) $(job_field Restarts)" = "CANCELLED 0" ] ||
  fail "a cancelled job: $(job_field JobState) after $(job_field Restarts) restarts"
[ ! -e "$bake/complete.json" ] || fail "the job was cancelled too late to tell"
echo "ok: a cancelled job stays cancelled"
