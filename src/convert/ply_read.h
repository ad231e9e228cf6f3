// PLY, the format of scanners and point libraries: a strict reader, ascii and
// binary of either byte order.
#ifndef REFRAME_CONVERT_PLY_READ_H
#define REFRAME_CONVERT_PLY_READ_H

#include "convert/model.h"

// One mesh at one node, of the default material. Of vertices: x y z, nx ny nz, s t
// (or u v, texture_u texture_v), red green blue alpha (uchar and ushort are sRGB,
// float and double linear); of faces: vertex_indices (or vertex_index), polygons cut into
// triangles; of tristrips: the same list, strips with -1 between them. All else is
// read past; nothing may follow the last element. Fails with RF_ERROR_FORMAT (with the line or
// the byte), RF_ERROR_UNSUPPORTED, RF_ERROR_MEMORY, or as reading files does; the
// model is empty then.
RfResult rf_read_ply( const char* path, RfModel* model, RfLog* log, RfError* error );

#endif
