// Clocks that say what something took. No result may depend on one.
#pragma once

namespace prt {

/// Seconds on a clock that never runs backwards; its zero means nothing.
double steady_seconds();

/// CPU seconds that the calling thread has used.
double thread_cpu_seconds();

}  // namespace prt
