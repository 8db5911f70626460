# Sourced by the scripts beside it: they run from the repository's root, wherever they are called.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '\n== %s\n' "$*"; }
fail() {
  printf '%s\n' "$*" >&2
  exit 1
}

# build PRESET [TARGET...]: configures and builds with all cores; all targets unless some are named.
build() {
  local preset=$1
  shift
  cmake --preset "$preset" >/dev/null || fail "cmake --preset $preset failed: run scripts/setup, then see above"
  cmake --build --preset "$preset" ${1:+--target "$@"}
}

# Settings under which plain mpirun works as root and in containers.
prepare_mpi() {
  if [ "$(id -u)" = 0 ]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  fi
  # Copies between ranks through the kernel are often forbidden in containers; our messages are small.
  export OMPI_MCA_btl_vader_single_copy_mechanism=none
  if [ "$(nproc)" -lt 2 ]; then
    export OMPI_MCA_rmaps_base_oversubscribe=1
  fi
}
