// Internal to this folder: Embree's scenes, in two levels: one of the triangles in world space and of instances, and one for each
// mesh that is placed. Alpha-masked and alpha-blended triangles, thin panes and far triangles (trace/tracer.h) are a geometry with a
// filter function; scenes without any have a single geometry.
#ifndef REFRAME_TRACE_BVH_H
#define REFRAME_TRACE_BVH_H

#include "scene/mirrors.h"
#include "scene/scene.h"
#include "trace/boxes.h"
#include "trace/embree.h"
#include "trace/trace.h"

// Embree's geometry ids within its scenes.
enum
{
    RF_GEOMETRY_OPAQUE,
    RF_GEOMETRY_FILTERED,
    RF_GEOMETRY_PLACEMENTS, // the first placement of the scene; the others follow
};

// Embree's scene of a list of triangles.
typedef struct RfMeshBvh
{
    const RfTriangles* triangles;
    RTCScene embree_scene;
    float scale;           // of Embree's positions over the triangles': a power of two, 1 but for tiny and huge ones
    float far_error;       // triangles beyond this error, in their own space, are checked (trace/tracer.h)
    bool far;              // some are
    bool placed;           // by a matrix
    uint32_t masked_first; // first index in `order` that has the filter: masked, blended, panes and far triangles
    uint32_t* order;       // triangles in the order of the two geometries; NULL: original order
} RfMeshBvh;

// A placement for the errors of Embree, which inverts its matrix in floats, and takes rays into the mesh's space by that.
typedef struct RfPlacedBvh
{
    float side;          // −1: the matrix mirrors
    float inverse[3][3]; // magnitudes that the entries of the inverse are the difference of, by row
} RfPlacedBvh;

typedef struct RfBvh
{
    RfMeshBvh base; // with the instances
    RfMeshBvh* meshes;
    RfPlacedBvh* placed; // by placement; NULL: there is none
    bool blended;        // some triangles are alpha-blended
    bool panes;          // some may be thin panes
    bool any_blended;    // some triangles are blended, and not because it is forced
    bool halved;         // packets are traced in halves (trace/embree.h)
    bool partial;        // one of the two, and not because it is forced
    bool filtered;       // some triangles have the filter
    int mesh_count;
    int shared_meshes; // the first of them, which another BVH owns
    RTCScene moving;   // what moves, at one moment: a second scene, of instances alone; NULL: nothing does, or is there
    RfBoxes boxes;     // around that, in Embree's scene
} RfBvh;

// Builds the BVH. The filter keeps the address of `bvh`, which must not move. Embree's errors
// are reported to the device's error handler.
RfResult rf_build_bvh( RTCDevice device, const RfScene* scene, RfBvh* bvh, RfError* error );

// The same at a moment of a scene that moves: shares all that stands still with `still`, which was built for the scene as it was
// loaded and must outlive this.
RfResult rf_build_posed_bvh( RTCDevice device, const RfBvh* still, const RfScene* posed, RfBvh* bvh, RfError* error );

// Adds what moves in a posed BVH to a scene of instances, not yet committed.
void rf_add_swept( const RfBvh* posed, const RfScene* scene, RTCScene swept );

// Commits a scene, without traps.
void rf_commit_scene( RTCScene scene );

// A scene of the mirrors' triangles alone, in their order; NULL if there are none.
RTCScene rf_build_mirror_scene( RTCDevice device, const RfScene* scene, float scale, const RfMirrors* mirrors );

void rf_destroy_bvh( RfBvh* bvh );
// Those of a posed BVH alone, but not those that it shares.
void rf_destroy_posed_bvh( RfBvh* bvh );

#define RF_PACKET 16

typedef enum RfQueryKind
{
    RF_QUERY_NEAREST,  // find the nearest hit
    RF_QUERY_SEGMENTS, // accumulate transmittance and panes
    RF_QUERY_PANES,    // accumulate the panes before hits that are known
    RF_QUERY_SWEPT,    // find whether anything is there, whatever its opacity
} RfQueryKind;

// The query that a packet belongs to; the ids of its rays are their lanes.
typedef struct RfQuery
{
    RfRayContext context; // first member: Embree passes its address to the filter
    const RfTracer* tracer;
    RfQueryKind kind;
    bool pass_panes; // else panes are surfaces like any others
    bool surely;     // nearest hits: rays pass panes for sure, not by chance
    bool passed;     // some pane was passed
    int traps;       // of the caller (base/float_traps.h)
    // per ray, initially 1
    float transmittance[RF_PACKET];
    float pane_probability[RF_PACKET];
    float pane_weight[3][RF_PACKET];
    // and, where it is asked for, the pane that comes first and where along the segment
    bool notes_first;
    uint32_t first_pane[RF_PACKET];
    float first_at[RF_PACKET];
    uint32_t hit[RF_PACKET]; // RF_QUERY_PANES: the triangle hit, which was not passed
    // where there are placements: origins and directions, which Embree takes into the spaces of meshes
    float world[6][RF_PACKET];
} RfQuery;

// The triangle in its list of a primitive of one of the two geometries.
static inline uint32_t rf_mesh_triangle( const RfMeshBvh* mesh, unsigned int geometry, uint32_t primitive )
{
    return mesh->order != NULL ? mesh->order[primitive + ( geometry == RF_GEOMETRY_FILTERED ? mesh->masked_first : 0 )]
                               : primitive;
}

#endif
