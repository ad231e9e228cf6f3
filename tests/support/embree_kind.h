// Embree as on other processors than this machine's: with AVX-512 it has packets of 16 rays, without it has not.
#ifndef REFRAME_TESTS_EMBREE_KIND_H
#define REFRAME_TESTS_EMBREE_KIND_H

// The instruction set that Embree uses in tracers made from now on: "avx2", "sse4.2", …; NULL: the best that there is.
void use_embree_for( const char* instruction_set );

#endif
