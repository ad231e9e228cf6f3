// Path guiding: densities of directions by which light arrives, learned beforehand (path/guide_learner.h) and fixed while pictures are
// rendered. A density depends on the point and its normal alone, never on the camera, so that (E1) holds with it
// (src/reuse/estimators.md, section 27): scattering draws from the mixture (1 − c) p + c g of the BSDF's density p and the guide's g.
//
// Space is split by one tree for each of the six main directions of normals; a leaf has a table, or none where the BSDF alone does as
// well. A table is a density over a square of RF_GUIDE_SIDE² bins onto which an octahedron maps the sphere (Engelhardt, Dachsbacher,
// Octahedron Environment Maps, 2008).
#ifndef REFRAME_PATH_GUIDE_H
#define REFRAME_PATH_GUIDE_H

#include "math/vec3.h"

#include <stdint.h>

#define RF_GUIDE_AXES 6
#define RF_GUIDE_SIDE 32
#define RF_GUIDE_BINS ( RF_GUIDE_SIDE * RF_GUIDE_SIDE )
#define RF_NOT_GUIDED ( -1 )

typedef struct RfGuideTable
{
    float share;                  // c, above 0 and below 1
    float density[RF_GUIDE_BINS]; // by rows, per unit of the square [−1, 1]²
    float row[RF_GUIDE_SIDE];     // probability of a row or one before it
    float column[RF_GUIDE_BINS];  // by rows: of a bin or one before it, in its row
} RfGuideTable;

// Leaves are their own children, so that all points take `depth` steps.
typedef struct RfGuideNode
{
    float split;  // along `axis`: below it is the child, from it on the next one; of a leaf infinity
    int32_t axis; // of space
    int32_t child;
    int32_t table; // of a leaf: the table, or RF_NOT_GUIDED
} RfGuideNode;

typedef struct RfGuide
{
    RfGuideNode* nodes; // the first RF_GUIDE_AXES are roots
    RfGuideTable* tables;
    int node_count, table_count, depth;
} RfGuide;

// The number of the main direction of a unit normal.
static inline int rf_guide_axis( RfVec3 n )
{
    float x = fabsf( n.x ), y = fabsf( n.y ), z = fabsf( n.z );
    int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    float along = axis == 0 ? n.x : axis == 1 ? n.y : n.z;
    return 2 * axis + ( along < 0.0f );
}

// The tables at `count` points with unit normals, or RF_NOT_GUIDED.
void rf_find_guide_tables( const RfGuide* guide, int count, const float* const p[3], const float* const n[3], int32_t* table );

// The bin of a unit direction, by rows, and the factor from densities over the square to those per solid angle.
static inline int rf_guide_bin( RfVec3 d, float* per_solid_angle )
{
    float s = 1.0f / rf_maxf( fabsf( d.x ) + fabsf( d.y ) + fabsf( d.z ), 0.5f ); // lanes without a direction have any
    float x = d.x * s, y = d.y * s;
    float u = d.z < 0.0f ? copysignf( 1.0f - fabsf( y ), x ) : x, v = d.z < 0.0f ? copysignf( 1.0f - fabsf( x ), y ) : y;
    const float half = 0.5f * RF_GUIDE_SIDE, last = RF_GUIDE_SIDE - 1;
    int column = (int)rf_clampf( ( u + 1.0f ) * half, 0.0f, last ), row = (int)rf_clampf( ( v + 1.0f ) * half, 0.0f, last );
    *per_solid_angle = s * s * s;
    return row * RF_GUIDE_SIDE + column;
}

// g, in 1/sr.
static inline float rf_guide_pdf_solid_angle( const RfGuideTable* table, RfVec3 d )
{
    float per_solid_angle;
    int bin = rf_guide_bin( d, &per_solid_angle );
    return table->density[bin] * per_solid_angle;
}

// A unit direction from two numbers in [0, 1).
RfVec3 rf_sample_guide( const RfGuideTable* table, float u, float v );

// Makes densities of scattering those of the mixture, for `count` directions at points with these tables. A lane's result depends on
// that lane alone.
void rf_mix_guide( const RfGuide* guide, int count, const int32_t* table, const float* const wi[3], float* pdf_solid_angle );

// Fills `row` and `column` of a table from `density`, which becomes one: all bins together have the probability 1.
void rf_finish_guide_table( RfGuideTable* table );

// `guide` may be NULL.
void rf_destroy_guide( RfGuide* guide );

#endif
