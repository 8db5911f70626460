// How the numbers of a package's matrix are read: QuadRows::upload.
#ifdef FLOAT_MATRIX
#define MATRIX_BUFFER samplerBuffer
#else
#define MATRIX_BUFFER isamplerBuffer
#endif
