// Windows of the picture in which an estimator is tried that makes a picture of all that it traces, and so renders no
// pieces (pieces.h): eyes with a smaller film, in the resolution of the render.
#ifndef REFRAME_MEASURE_CROPS_H
#define REFRAME_MEASURE_CROPS_H

#include "measure/pieces.h"
#include "scene/eye.h"

#define RF_CROPS 7

// Makes RF_CROPS windows in frames spread over `frames`, which trace about `pixels` pixels for each of these frames, and the
// pieces that are measured there: all but a margin, where tiles and differences end. *crops is NULL where the windows would
// be most of the picture; else free it, and the pieces with rf_destroy_test_pieces. Fails with RF_ERROR_MEMORY.
RfResult rf_choose_crops( const RfEye* eyes, int frames, double pixels, uint64_t seed, RfEye** crops, RfTestPieces* pieces,
                          RfError* error );

#endif
