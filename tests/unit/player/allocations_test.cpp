// A light change in the middle of a frame must not wait for memory.
#include <gtest/gtest.h>

#include <cstdlib>

#include "player/evaluator.h"
#include "unit/package/synthetic_package.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCounts = false;  // their own malloc stays
static const std::size_t allocations = 0;
#else
constexpr bool kCounts = true;
static std::size_t allocations = 0;

extern "C" void* __libc_malloc(std::size_t size);  // NOLINT(bugprone-reserved-identifier)
// The C library's, counted: Eigen and operator new both come here.
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
#endif

namespace prt {
namespace {

TEST(Allocations, ALightChangeMakesNone) {
  if (!kCounts) GTEST_SKIP() << "a sanitizer has its own malloc";
  const Package room = test::synthetic_room({});
  const Evaluator evaluator(room, {.area_samples = 9, .threads = 1});
  std::vector<Light> lights(2);
  lights[0].position = {1, 1, 1};
  lights[1].kind = Light::Kind::kSphere;
  lights[1].radius = 0.1F;
  SampleIrradiance played;
  const std::size_t before = allocations;
  evaluator.evaluate(lights, {}, played);
  const std::size_t first = allocations;
  EXPECT_GT(first, before) << "nothing is counted";
  for (int change = 0; change < 3; ++change) {
    lights[0].position.x() += 0.1F;
    evaluator.evaluate(lights, {}, played);
  }
  EXPECT_EQ(allocations, first);
  EXPECT_GT(played.indirect.sum(), 0.0F);
}

}  // namespace
}  // namespace prt
