#include "apps/bake/memory.h"

#include <malloc.h>

#include <limits>

namespace prt {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kLargestFromHeap = 1 << 30;  // larger ones come from the kernel still
  constexpr int kGrowBy = 64 << 20;
  mallopt(M_MMAP_THRESHOLD, kLargestFromHeap);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, kGrowBy);
#endif
}

void return_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace prt
