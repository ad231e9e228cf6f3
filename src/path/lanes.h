// A wavefront: up to RF_LANES paths that advance together, one vertex at a
// time, as structures of arrays. Lane i of a vertex array belongs to path
// slot[i]. At every vertex, lanes are compacted and sorted by scattering model;
// slots do not change.
#ifndef REFRAME_PATH_LANES_H
#define REFRAME_PATH_LANES_H

#include "base/lattice.h"
#include "base/random.h"
#include "bsdf/bsdf.h"
#include "light/light.h"
#include "path/guide.h"
#include "trace/trace.h"

// A patch of 32 × 32 paths, plus a cache line: arrays at a distance of a power of
// two would compete for the same cache sets.
#define RF_LANES ( 1024 + 16 )
#define RF_ALIGN _Alignas( 64 )

// Rays to the next vertices.
typedef struct RfRayLanes
{
    int count;
    float pixel_width, pixel_spread; // of camera rays: a pixel is pixel_width + pixel_spread · distance wide, in m
    RF_ALIGN float o[3][RF_LANES];
    float d[3][RF_LANES];            // unit
    float throughput[3][RF_LANES];   // of the path since its first vertex
    float pdf_solid_angle[RF_LANES]; // of d
    float n[3][RF_LANES];            // unit shading normal at the origin, which light selection depends on
    int32_t slot[RF_LANES];
} RfRayLanes;

// Path vertices. Lanes [first[k], first[k+1]) scatter by model k.
typedef struct RfVertexLanes
{
    int count;
    int first[RF_BSDF_KIND_COUNT + 1];
    RF_ALIGN float p[3][RF_LANES];
    float ng[3][RF_LANES];                 // unit geometric normal, on the side of wo
    float n[3][RF_LANES];                  // unit shading normal, on the side of ng
    float wo[3][RF_LANES];                 // unit, back along the ray
    float offset[RF_LANES];                // along ng: rays start and end off the surface
    float param[RF_PARAM_COUNT][RF_LANES]; // those in the mask of the lane's model; the others are not set
    float absorption[3][RF_LANES];         // specular lanes only: of the medium that wo runs through, 1/m
    float emission[3][RF_LANES];           // towards wo
    float light_pdf_solid_angle[RF_LANES]; // of a light sample at the ray's origin for this point, given its
                                           // light; 0: light sampling cannot find it
    const RfGuide* guide;                  // that guides paths from here on; NULL: nothing does
    int32_t table[RF_LANES];               // with a guide, of lanes that become records: theirs (rf_guide_table)
    int32_t ray[RF_LANES];                 // lane of the ray that found it
    int32_t material[RF_LANES];            // index into the scene's
    int32_t slot[RF_LANES];
} RfVertexLanes;

// Which points of which surfaces rays hit, by ray lane: triangle numbers (scene/placement.h; RF_MISS: none) and barycentrics.
typedef struct RfSurfaceLanes
{
    RF_ALIGN uint32_t triangle[RF_LANES];
    float u[RF_LANES], v[RF_LANES];
} RfSurfaceLanes;

// Number of lanes that become records; the specular ones follow them.
static inline int rf_record_count( const RfVertexLanes* v ) { return v->first[RF_BSDF_FIRST_SPECULAR]; }

// From this lane on records have drawn the side on which light arrives (rf_draw_sides).
static inline int rf_first_sided( const RfVertexLanes* v ) { return v->first[RF_BSDF_TRANSLUCENT]; }

// 1 where the side that is seen was drawn, −1 where the other was, which n is on then. Of a lane from there on.
static inline float rf_drawn_side( const RfVertexLanes* v, int i ) { return v->param[RF_PARAM_CHOICE][i] < 0.0f ? -1.0f : 1.0f; }

// The model of any lane.
static inline RfBsdfKind rf_kind_of_lane( const RfVertexLanes* v, int i )
{
    int kind = 0;
    while ( i >= v->first[kind + 1] )
        ++kind;
    return (RfBsdfKind)kind;
}

// The model of a specular lane.
static inline RfBsdfKind rf_specular_kind( const RfVertexLanes* v, int i )
{
    return i < v->first[RF_BSDF_SPECTRAL] ? RF_BSDF_GLASS : RF_BSDF_SPECTRAL;
}

// What model `kind` reads of the lanes from `first` on.
static inline RfBsdfLanes rf_vertex_bsdf_lanes( const RfVertexLanes* v, RfBsdfKind kind, int first )
{
    RfBsdfLanes lanes; // set without asking for each parameter, and none of it twice
    for ( int c = 0; c < 3; ++c )
        lanes.n[c] = v->n[c] + first;
    for ( int p = 0; p < RF_PARAM_SHEEN; ++p )
        lanes.param[p] = v->param[p] + first;
    bool layered = rf_bsdf_model( kind )->params >= RF_PARAM_BIT( RF_PARAM_SHEEN );
    for ( int p = RF_PARAM_SHEEN; p < RF_PARAM_COUNT; ++p )
        lanes.param[p] = layered ? v->param[p] + first : NULL;
    return lanes;
}

// Copies `count` lanes from `first` on to the lanes from `at` on of another set of vertices,
// with the parameters in the mask `params`. first[] and count are left alone.
void rf_copy_vertices( const RfVertexLanes* from, int first, int count, RfBsdfParams params, RfVertexLanes* to, int at );

// One light sample per vertex lane.
typedef struct RfLightLanes
{
    RF_ALIGN float wi[3][RF_LANES];  // unit
    float radiance_cos[3][RF_LANES]; // incident radiance times n·wi; 0: unlit
    float pdf_solid_angle[RF_LANES];
    uint8_t touched[RF_LANES]; // 1: kept apart, with RfPathSettings.own (path/own_light.h)
    uint8_t part[RF_LANES];    // with RfPathSettings.parts or grouped: of the light (light/light.h), where touched its base part
} RfLightLanes;

// Workspace; its contents are not kept between calls.
typedef struct RfLaneScratch
{
    RF_ALIGN uint32_t bits[2][RF_LANES];
    RF_ALIGN uint32_t triangle[RF_LANES];
    float u[RF_LANES], v[RF_LANES];
    uint8_t kind[RF_LANES];
    float visible[RF_LANES];
    int32_t index[RF_LANES];
    RF_ALIGN float o[3][RF_LANES];
    float d[3][RF_LANES];
    float random[3][RF_LANES];
    float wi[3][RF_LANES];
    float f[3][RF_LANES]; // after scattering, for specular lanes: the weight f |cos| / density
    float pdf[RF_LANES];
    float pdf_bsdf[RF_LANES]; // after scattering with a guide, for lanes that become records: of the BSDF alone
} RfLaneScratch;

// The dimensions of a path's random numbers (base/random.h): the film first, then
// a block per vertex (numbered from 1).
enum
{
    RF_DIMENSION_FILM_X,
    RF_DIMENSION_FILM_Y,
    RF_DIMENSION_FIRST_VERTEX,
};
enum
{
    RF_DIMENSION_SCATTER, // three
    RF_DIMENSION_ROULETTE = RF_DIMENSION_SCATTER + 3,
    RF_DIMENSION_LIGHTS, // three for each light sample
};
// A light sample with the random numbers of another, each half an interval further: an antithetic sample.
#define RF_DIMENSION_OPPOSITE 0x10000000u
// The sides of translucent vertices: one for each vertex (rf_draw_sides).
#define RF_DIMENSION_SIDES 0x02000000u
// Chain samples (path/chain_samples.h).
#define RF_DIMENSION_CHAIN_SAMPLES 0x08000000u
// The vertices of camera rays' chains, before the vertex numbered 1.
#define RF_DIMENSION_CHAINS 0x20000000u
// Russian roulette on the paths of a tile.
#define RF_DIMENSION_CONNECTIONS 0x40000000u
// The lens and the shutter, three.
#define RF_DIMENSION_LENS 0x01000000u
// The place within a pixel of the sky: of a light sample's second and third number.
#define RF_DIMENSION_WITHIN 0x04000000u
// A second word of a dimension, where 32 bits are not enough.
#define RF_DIMENSION_TWIN 0x80000000u

static inline uint32_t rf_vertex_dimension( int vertex, int light_samples )
{
    return (uint32_t)( RF_DIMENSION_FIRST_VERTEX + ( vertex - 1 ) * ( RF_DIMENSION_LIGHTS + 3 * light_samples ) );
}

// The numbers that stand for random ones where paths begin (src/reuse/estimators.md, section 24), of a pass of a frame.
typedef struct RfLattice
{
    RF_ALIGN uint32_t x[RF_LANES]; // by slot: the pixel
    uint32_t y[RF_LANES];
    uint32_t key_a[RF_LANES]; // of its block of pixels (rf_set_lattice_pixel)
    uint32_t key_b[RF_LANES];
    uint64_t half;        // the key of one half of (E2)
    uint32_t pass, frame; // the pass, of those of its half
    uint32_t vertex;      // dimensions of a vertex; 0: all numbers are random
} RfLattice;

// The pixel of a slot. `half` is set.
static inline void rf_set_lattice_pixel( RfLattice* lattice, int slot, uint32_t x, uint32_t y )
{
    RfRandomKey key = rf_pixel_key( lattice->half, y / RF_LATTICE_BLOCK << 16 | x / RF_LATTICE_BLOCK );
    lattice->x[slot] = x;
    lattice->y[slot] = y;
    lattice->key_a[slot] = key.a;
    lattice->key_b[slot] = key.b;
}

#endif
