#include "methods/lb/effort.h"

#include <array>

namespace prt::lb {

namespace {

struct Effort {
  int samples, directions, visibility_rank, light_rank;
  double near_share, compression_tolerance, transport_tolerance;
  int bits;
};

// Samples and light functions carry most of the error of indirect light, ranks and directions that
// of shadows (results/error.md, results/sweeps.md); each level refines what bounds the one before.
constexpr std::array<Effort, 6> kEfforts{{
    {6000, 1008, 32, 10, 0.006, 0.02, 0.04, 8},
    {12000, 1008, 64, 20, 0.003, 0.01, 0.02, 8},
    {24000, 1008, 64, 20, 0.003, 0.01, 0.02, 8},
    {48000, 2016, 100, 20, 0.003, 0.005, 0.01, 8},
    {90000, 4032, 200, 20, 0.002, 0.005, 0.01, 16},
    {180000, 4032, 200, 25, 0.002, 0.003, 0.005, 16},
}};

}  // namespace

int effort_levels() { return static_cast<int>(kEfforts.size()); }

OptionValues with_effort(OptionValues options, int level) {
  const Effort& e = kEfforts.at(static_cast<std::size_t>(level));
  options.set("samples.spacing", nullptr);
  options.set("samples.count", e.samples);
  options.set("rays.directions", e.directions);
  options.set("lb.visibility_rank", e.visibility_rank);
  options.set("lb.light_rank", e.light_rank);
  options.set("lb.near_share", e.near_share);
  options.set("compression.tolerance", e.compression_tolerance);
  options.set("compression.bits", e.bits);
  options.set("transport.tolerance", e.transport_tolerance);
  return options;
}

}  // namespace prt::lb
