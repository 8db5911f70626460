// How many tasks a second the real coordinator can see done.
#pragma once

#include <cstddef>

namespace prt::scaling {

struct CoordinatorSpeed {
  double handling = 0.0;  ///< seconds in Coordinator::handle, planning included
  double messages = 0.0;  ///< seconds for reading reports and writing orders
  std::size_t tasks = 0;
  std::size_t inputs = 0;  ///< of all tasks
};

/// `layers` of `width` tasks, each with `inputs` of the layer before, on `workers` workers that
/// answer at once, in a random order.
CoordinatorSpeed measure_coordinator(std::size_t layers, std::size_t width, std::size_t inputs,
                                     int workers);

}  // namespace prt::scaling
