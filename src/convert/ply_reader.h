// Internal to the PLY reader: its state while reading elements into a mesh.
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
    uint32_t *corners, *cut; // the current polygon and its triangles
    uint32_t corner_room;
    uint64_t cut_steps;        // left, see rf_cut_polygon
    uint64_t dropped, crossed; // faces and strips of fewer than three corners; self-intersecting faces
    uint64_t clamped;          // colours outside [0, 1]
} RfPlyReader;

// Reads the "vertex" element (ply_vertices.c).
RfResult rf_ply_read_vertices( RfPlyReader* r, const RfPlyElement* element );

// Post-processes the vertices after the last element, and warns.
void rf_ply_finish_vertices( RfPlyReader* r );

// Reads the "face" element (ply_faces.c).
RfResult rf_ply_read_faces( RfPlyReader* r, const RfPlyElement* element );

// Reads triangle strips separated by -1; every second triangle of a strip is flipped.
RfResult rf_ply_read_strips( RfPlyReader* r, const RfPlyElement* element );

static inline RfResult rf_ply_no_memory( const RfPlyReader* r )
{
    return rf_fail( r->file.error, RF_ERROR_MEMORY, "%s: no memory left to read it", r->file.path );
}

#endif
