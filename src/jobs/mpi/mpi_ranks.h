// Ranks over MPI; the only place that includes mpi.h is its source file.
#pragma once

#include <memory>

#include "jobs/ranks.h"

namespace prt {

/// True if a launcher (mpirun, srun with PMI) started this process.
bool launched_as_rank();

/// Initialises MPI with MPI_THREAD_FUNNELED: only the calling thread may use the result. Messages
/// travel as bytes with non-blocking sends and probed receives, so nobody ever waits inside MPI.
std::unique_ptr<Ranks> make_mpi_ranks();

}  // namespace prt
