#include "base/clock.h"

#include <chrono>
#include <ctime>

namespace prt {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double thread_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  constexpr double kNano = 1e-9;
  return static_cast<double>(t.tv_sec) + kNano * static_cast<double>(t.tv_nsec);
}

}  // namespace prt
