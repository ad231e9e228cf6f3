// Inside of the PLY reader: what its elements are read into.
#ifndef REFRAME_CONVERT_PLY_READER_H
#define REFRAME_CONVERT_PLY_READER_H

#include "convert/model.h"
#include "convert/ply_file.h"

typedef struct RfPlyReader
{
    RfPlyFile file;
    RfLog* log;
    RfModelMesh* mesh;
    bool has_vertices;
    size_t triangle_room;
    uint32_t *corners, *cut; // of the polygon at hand
    uint32_t corner_room;
    uint64_t cut_steps;        // left
    uint64_t dropped, crossed; // faces and strips of less than three corners; faces that cross themselves
    uint64_t clamped;          // colours
} RfPlyReader;

// ply_vertices.c
RfResult rf_ply_read_vertices( RfPlyReader* r, const RfPlyElement* element );
// After the last element: what of the vertices needs all of them, and warnings.
void rf_ply_finish_vertices( RfPlyReader* r );

// ply_faces.c
RfResult rf_ply_read_faces( RfPlyReader* r, const RfPlyElement* element );
// Strips of triangles, -1 between them: every corner from the third on makes a
// triangle with the two before it, every second one turned round.
RfResult rf_ply_read_strips( RfPlyReader* r, const RfPlyElement* element );

static inline RfResult rf_ply_no_memory( const RfPlyReader* r )
{
    return rf_fail( r->file.error, RF_ERROR_MEMORY, "%s: no memory left to read it", r->file.path );
}

#endif
