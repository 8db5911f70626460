// Writes the synthetic package, for scripts/validate_package: write_synthetic_package FILE
#include <cstdio>

#include "package/write.h"
#include "unit/package/synthetic_package.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_synthetic_package FILE.prt.glb\n", stderr);
    return 2;
  }
  prt::write_package(prt::test::synthetic_room({.bits = 8}), argv[1]);
  return 0;
}
