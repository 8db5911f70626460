#include "base/parallel.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace prt {

unsigned available_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0)
    return std::max(1U, std::thread::hardware_concurrency());
  return static_cast<unsigned>(std::max(1, CPU_COUNT(&set)));
}

void run_ranges(std::size_t count, std::size_t grain, unsigned threads,
                const std::function<void(std::size_t, std::size_t)>& body) {
  if (count == 0) return;
  const std::size_t ranges = (count + grain - 1) / grain;
  if (threads == 0) threads = available_cpus();
  threads = static_cast<unsigned>(std::min<std::size_t>(threads, ranges));
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < ranges; i = next++) {
        body(i * grain, std::min(count, (i + 1) * grain));
      }
    } catch (...) {
      next = ranges;
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  if (threads == 1) {
    work();
  } else {
    std::vector<std::jthread> others;
    for (unsigned t = 1; t < threads; ++t) others.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace prt
