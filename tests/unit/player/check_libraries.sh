#!/bin/bash
# check_libraries.sh PROGRAM: fails if it is linked with MPI, Embree or HDF5.
set -euo pipefail
libraries=$(ldd "$1")
grep -q libc.so <<<"$libraries" || { echo "ldd says nothing of $1" >&2; exit 1; }
if grep -E 'libmpi|libembree|libhdf5|libopen-(rte|pal)' <<<"$libraries"; then
  echo "$1 must not need these" >&2
  exit 1
fi
