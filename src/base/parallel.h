// A parallel loop for the programs that play and evaluate. Baking tasks are single-threaded and
// never call this: there, whole tasks run side by side (jobs/).
#pragma once

#include <cstddef>
#include <functional>

namespace prt {

/// parallel_for() of a body of any type.
void run_ranges(std::size_t count, std::size_t grain, unsigned threads,
                const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Calls body(begin, end) on disjoint ranges of at most `grain` items that cover [0, count), on up
/// to `threads` threads (0: all this process may use). The first exception is rethrown once all
/// threads have ended. Ranges depend on `grain` only, so a result written per item or per range is
/// the same on any number of threads.
template <typename Body>
void parallel_for(std::size_t count, std::size_t grain, unsigned threads, const Body& body) {
  // By reference: however much a body holds, nothing is copied or allocated.
  run_ranges(count, grain, threads, std::cref(body));
}

/// Number of CPUs this process may run on (affinity mask and so cgroup cpusets respected), at
/// least 1.
unsigned available_cpus();

}  // namespace prt
