// A strict reader of PLY, the format of 3D scanners and point libraries: ASCII and
// binary of either byte order.
#ifndef REFRAME_CONVERT_PLY_READ_H
#define REFRAME_CONVERT_PLY_READ_H

#include "convert/model.h"

// Reads one mesh at one node, with the default material. Vertex properties: x y z,
// nx ny nz, s t (or u v, texture_u texture_v), red green blue alpha (uchar and ushort
// are sRGB, float and double linear). Faces: vertex_indices (or vertex_index), polygons
// are triangulated. Tristrips: the same list, -1 separates strips. Other properties and
// elements are skipped; nothing may follow the last element. Fails with RF_ERROR_FORMAT
// (giving the line or the byte), RF_ERROR_UNSUPPORTED, RF_ERROR_MEMORY or an error of
// reading the file, and leaves the model empty.
RfResult rf_read_ply( const char* path, RfModel* model, RfLog* log, RfError* error );

#endif
