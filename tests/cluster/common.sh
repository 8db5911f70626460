# Sourced by the tests beside it, which may be called from anywhere.
# shellcheck shell=bash
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
bin=$(cd "${PRT_BIN:-$root/build/release/bin}" 2>/dev/null && pwd) || {
  echo "no programs in ${PRT_BIN:-$root/build/release/bin}: build them, or say where they are with PRT_BIN" >&2
  exit 1
}
scratch=$(mktemp -d "${TMPDIR:-/tmp}/prt_cluster.XXXXXX")

if [ "$(id -u)" = 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
export OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_rmaps_base_oversubscribe=1

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}
# 77 is what CTest's SKIP_RETURN_CODE is set to.
skip() {
  rm -rf "$scratch"
  printf 'SKIPPED: %s\n' "$*"
  exit 77
}

# shellcheck disable=SC2034  # the tests use it
# A bake of some 230 tasks and a few core seconds: long enough to be killed on the way.
tiny_bake=("$bin/prt_bake" "$root/configs/default.yaml"
  --set "scene=$root/configs/scenes/cornell.glb"
  --set samples.count=6000 --set samples.cluster_size=250 --set rays.directions=528
  --set lb.example_lights=80
  --set evaluate.lights=2 --set evaluate.points=100 --set evaluate.spp=4)

finished_tasks() { find "$1/artifacts" -name '*.h5' 2>/dev/null | wc -l; }

# becomes SECONDS COMMAND...: waits until the command succeeds; false if it does not in that time.
becomes() {
  local until=$((SECONDS + $1))
  shift
  until "$@"; do
    [ "$SECONDS" -lt "$until" ] || return 1
    sleep 0.02
  done
}
# wait_until SECONDS WHAT COMMAND...: the same, and the test fails if it takes longer.
wait_until() {
  local seconds=$1 what=$2
  shift 2
  becomes "$seconds" "$@" || fail "$what did not come within $seconds s"
}
has_tasks() { [ "$(finished_tasks "$1")" -ge "$2" ]; }
is_gone() { ! kill -0 "$1" 2>/dev/null; }

# children PID [NAME]: processes whose parent is PID. (/proc, because a bare Debian has no ps; builtins alone, because a bake of
# seconds does not wait.)
children() {
  local file line name=${2:-*}
  for file in /proc/[0-9]*/stat; do
    { read -r line <"$file"; } 2>/dev/null || continue
    # "PID (NAME) STATE PARENT ..."
    [[ ${line##*) } =~ ^[^ZX]" $1 " && $line == *\($name\)* ]] || continue
    echo "${line%% *}"
  done
}

# scratch_processes [NAME]: running programs that this test started: those that name its scratch folder. Not
# this shell itself.
# shellcheck disable=SC2120  # a test passes it
scratch_processes() {
  local file words name
  for file in /proc/[0-9]*/cmdline; do
    { mapfile -d '' -t words <"$file"; } 2>/dev/null || continue
    [[ ${words[*]} == *"$scratch"* ]] || continue
    { read -r name <"${file%cmdline}comm"; } 2>/dev/null || continue
    file=${file#/proc/}
    [ "${file%/cmdline}" = $$ ] || [ "${1:-$name}" != "$name" ] || echo "${file%/cmdline}"
  done
}
kill_scratch_processes() {
  local all
  # shellcheck disable=SC2119
  all=$(scratch_processes)
  # shellcheck disable=SC2086  # one word per process
  [ -z "$all" ] || kill -KILL $all 2>/dev/null || true
}

# What a bake has made: one line per artifact, and the package.
digests() { (cd "$1" && find artifacts -name '*.h5' | sort | xargs sha256sum && sha256sum ./*.prt.glb); }
expect_same_bake() {  # expect_same_bake REFERENCE OTHER
  diff <(digests "$1") <(digests "$2") >"$scratch/difference" ||
    fail "$2 differs from $1: $(head -n 5 "$scratch/difference")"
}
