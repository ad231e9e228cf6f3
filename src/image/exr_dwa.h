// Internal to this folder: parts that are compressed by DWA. It changes colours, by a bound that is known, and nothing else.
#ifndef REFRAME_IMAGE_EXR_DWA_H
#define REFRAME_IMAGE_EXR_DWA_H

#include "image/exr_stream.h"

// DWAA and DWAB.
bool rf_is_dwa( RfExrCompression compression );

// The largest size of a colour that DWA is given: it is off by RF_DWA_WORST at most, which then stays in the range of half floats.
#define RF_DWA_MOST 30000.0f

// What DWA compresses in place of a colour: v^(1/2.2) up to 1, 1 + ln v / 2.2 beyond, with the sign. Errors are bounded in this
// scale.
double rf_dwa_scale( double value );

// Bounds of the error in that scale. DWA turns R, G, B into Y', Cb, Cr (Rec. 709) and quantises DCT coefficient k of blocks of 8 by 8
// with an error of up to level / 1e5 times that of JPEG's table over the table's least. The root mean square of these errors
// over 64 coefficients is that over 64 pixels, as the transform is orthonormal: 6.71 and 5.31 level / 1e5 for luma and chroma,
// and in B, which is Y' + 1.8556 Cb, 16.6. `scale` is the root mean square of the colours themselves, which are rounded to half floats
// six times on the way.
double rf_dwa_error_bound( double level, double scale );

// A compress_fn for a part whose channel i may change where `may_change` says so. `level` is DWA's.
exr_result_t rf_compress_dwa_chunk( exr_encode_pipeline_t* pipeline, RfExrStream* stream, const bool* may_change, float level );

// A decompress_fn.
exr_result_t rf_decompress_dwa_chunk( exr_decode_pipeline_t* pipeline, RfExrStream* stream );

#endif
