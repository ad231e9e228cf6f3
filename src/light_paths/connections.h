// Connections: a camera vertex inside the footprint of a light path connects to it by a manifold walk, divided by
// the probability that such a path is found. src/reuse/estimators.md, section 16.
#ifndef REFRAME_LIGHT_PATHS_CONNECTIONS_H
#define REFRAME_LIGHT_PATHS_CONNECTIONS_H

#include "light_paths/light_paths.h"
#include "light_paths/normalization.h"
#include "path/wavefront.h"

// Shares of light paths and connections to choose from; the first is none.
#define RF_CONNECTION_SHARES 7
extern const float rf_connection_shares[RF_CONNECTION_SHARES];

// Scattered rays that would find connected light by themselves, per octave of its brightness at the first vertex.
#define RF_CHANCE_OCTAVES 48
#define RF_FIRST_OCTAVE ( -16 )
typedef struct RfChanceOctave
{
    double rays;   // that bring it
    double square; // the sum of its squares
} RfChanceOctave;

// What connections bring to each vertex lane, in place of radiance times the cosine over its density.
typedef struct RfConnectionLanes
{
    RF_ALIGN float light[3][RF_LANES]; // the sum over all connections
    RF_ALIGN float wi[3][RF_LANES];    // of one of them, drawn in proportion to its light
    RF_ALIGN float one[3][RF_LANES];   // its light over the probability of drawing it
    float area[RF_LANES];              // its area (rf_own_weight)
    uint32_t found[RF_LANES];          // connections
    uint64_t rays;                     // traced, counted up
    uint64_t all_rays;                 // over all vertices
    uint64_t trials;                   // of the normalisation, counted up
    uint64_t searched;                 // vertices, counted up
    RfTrail trail[RF_LANES];           // by slot
    // Counted up where light paths measure. Of the light that connections and chance bring to first vertices, the sum of the
    // squares that are expected with each of rf_connection_shares.
    double moment[RF_CONNECTION_SHARES];
    RfChanceOctave chance[RF_CHANCE_OCTAVES];
} RfConnectionLanes;

typedef struct RfLightPathConnector
{
    RfConnector connector;
    const RfPathSettings* path;
    const RfLightPaths* paths;
    const RfNormalization* normalization;
    RfConnectionLanes* out;
} RfLightPathConnector;

// A connector with a workspace; all must outlive it.
RfLightPathConnector rf_make_connector( const RfLightPaths* paths, RfKernelNormalization normalization,
                                        const RfPathSettings* path, RfConnectionLanes* lanes );

// Connects non-specular vertices, the `vertex`-th of their paths, to light paths and VPLs: connector->out. Random
// numbers: by the keys of their slots. Adds to keys->path_rays. Given the rays that hit the vertices, connections
// are weighted.
void rf_connect_vertices( const RfLightPathConnector* connector, RfWavefront* keys, const RfRayLanes* rays,
                          const RfVertexLanes* vertices, int vertex );

#endif
