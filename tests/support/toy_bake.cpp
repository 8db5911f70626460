// prt_bake with the toy method: real files, real MPI.
#include "support/toy_method.h"

int main(int argc, char** argv) { return prt::bake_main(argc, argv, prt::test::toy_program()); }
