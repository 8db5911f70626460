// How many threads a rank may run: the machine's limits shared out between the ranks on it.
#pragma once

#include <string>

namespace prt {

struct CpuShare {
  int cpus = 1;          ///< of this machine that the job may use
  int threads = 1;       ///< of them for this rank
  bool widened = false;  ///< a default one-core binding of Open MPI was undone
};

/// Looks at the affinity mask (so cpusets, taskset and Slurm's binding), CPU quotas of cgroups and
/// Slurm's allotment. Plain mpirun binds each rank to one core, or socket: unless the user asked
/// for a binding, the rank gets back what its launcher may use. Call before any thread is started.
CpuShare share_cpus(int ranks_on_node);

/// CPUs that a cgroup quota stands for, e.g. "150000 100000" (cpu.max) is 2; 0: no limit. Exposed
/// for tests.
int cpus_of_quota(const std::string& cpu_max);

}  // namespace prt
