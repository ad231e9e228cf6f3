// Lanes of scattering models for the tests: one batch of arrays, ways to fill
// them and to call the models on a part of them. Included by one file per test
// program.
#ifndef REFRAME_TESTS_BSDF_LANES_H
#define REFRAME_TESTS_BSDF_LANES_H

#include "base/random.h"
#include "bsdf/bsdf.h"

#include <stdint.h>

#define BATCH 1000

enum
{
    N = 0,
    PARAM = 3,
    DIFFUSE = PARAM + RF_PARAM_DIFFUSE,
    SPECULAR = PARAM + RF_PARAM_SPECULAR,
    SHAPE = PARAM + RF_PARAM_SHAPE,
    F90 = PARAM + RF_PARAM_F90,
    COAT_F0 = PARAM + RF_PARAM_COAT_F0,
    COAT_F90 = PARAM + RF_PARAM_COAT_F90,
    CLEARCOAT = PARAM + RF_PARAM_CLEARCOAT,
    CLEARCOAT_ALPHA = PARAM + RF_PARAM_CLEARCOAT_ALPHA,
    COAT_N = PARAM + RF_PARAM_CLEARCOAT_N,
    SHEEN = PARAM + RF_PARAM_SHEEN,
    SHEEN_ALPHA = PARAM + RF_PARAM_SHEEN_ALPHA,
    ANISOTROPY = PARAM + RF_PARAM_ANISOTROPY,
    TANGENT = PARAM + RF_PARAM_TANGENT,
    FILM = PARAM + RF_PARAM_FILM,
    FILM_IOR = PARAM + RF_PARAM_FILM_IOR,
    FILM_THICKNESS = PARAM + RF_PARAM_FILM_THICKNESS,
    THROUGH = PARAM + RF_PARAM_THROUGH,
    TINT = PARAM + RF_PARAM_TINT,
    IOR = PARAM + RF_PARAM_IOR,
    CHOICE = PARAM + RF_PARAM_CHOICE,
    WO = PARAM + RF_PARAM_COUNT,
    WI = WO + 3,
    U = WI + 3,
    F = U + 3,
    PDF = F + 3,
    ARRAYS
};

static float s_lanes[ARRAYS][BATCH];

#define THREE( a )                                                                                                               \
    {                                                                                                                            \
        s_lanes[a], s_lanes[( a ) + 1], s_lanes[( a ) + 2]                                                                       \
    }
#define THREE_FROM( a, first )                                                                                                   \
    {                                                                                                                            \
        s_lanes[a] + first, s_lanes[( a ) + 1] + first, s_lanes[( a ) + 2] + first                                               \
    }

typedef struct Material
{
    RfBsdfKind kind;
    RfVec3 diffuse, specular;
    float shape, f90, coat_f0, coat_f90;
    float clearcoat, clearcoat_alpha;
    RfVec3 sheen;
    float sheen_alpha;
    float anisotropy, grain; // direction of the grain: turns from the first vector of rf_basis
    float film, film_ior, film_thickness;
    RfVec3 through;
    float ior;  // of FROSTED, whose tint is `through`
    float side; // that was drawn: −1, or any other for that of the eye
} Material;

// In initialisers: a colour, the Fresnel terms of a dielectric, a clear coat.
#define GREY( v )                                                                                                                \
    {                                                                                                                            \
        v, v, v                                                                                                                  \
    }
#define COAT( f0 ) .f90 = 1, .coat_f0 = ( f0 ), .coat_f90 = 1
#define CLEARCOAT_OF( strength, alpha ) .clearcoat = ( strength ), .clearcoat_alpha = ( alpha )

static inline void put( int array, int i, RfVec3 v )
{
    s_lanes[array][i] = v.x;
    s_lanes[array + 1][i] = v.y;
    s_lanes[array + 2][i] = v.z;
}

static inline RfVec3 get( int array, int i )
{
    return rf_vec3( s_lanes[array][i], s_lanes[array + 1][i], s_lanes[array + 2][i] );
}

static inline void put_material( int i, const Material* m )
{
    put( DIFFUSE, i, m->diffuse );
    put( SPECULAR, i, m->specular );
    s_lanes[SHAPE][i] = m->shape;
    s_lanes[F90][i] = m->f90;
    s_lanes[COAT_F0][i] = m->coat_f0;
    s_lanes[COAT_F90][i] = m->coat_f90;
    s_lanes[CLEARCOAT][i] = m->clearcoat;
    s_lanes[CLEARCOAT_ALPHA][i] = m->clearcoat_alpha;
    put( SHEEN, i, m->sheen );
    s_lanes[SHEEN_ALPHA][i] = rf_maxf( m->sheen_alpha, RF_MIN_SHEEN_ALPHA );
    s_lanes[ANISOTROPY][i] = m->anisotropy;
    s_lanes[FILM][i] = m->film;
    s_lanes[FILM_IOR][i] = rf_maxf( m->film_ior, 1.0f );
    s_lanes[FILM_THICKNESS][i] = m->film_thickness;
    if ( m->kind != RF_BSDF_TRANSLUCENT && m->kind != RF_BSDF_FROSTED ) // which have places of glass
        return;
    put( THROUGH, i, m->through );
    s_lanes[IOR][i] = m->ior;
    s_lanes[CHOICE][i] = m->side == -1.0f ? -1.0f : 1.0f;
}

// The normal, and the grain across it.
static inline void put_normal( int i, const Material* m, RfVec3 n )
{
    RfVec3 t, b;
    rf_basis( n, &t, &b );
    float angle = 2.0f * RF_PI * m->grain;
    put( N, i, n );
    put( TANGENT, i, rf_madd( rf_scale( t, cosf( angle ) ), b, sinf( angle ) ) );
}

// How far the coat's normal leans from the surface's; 0: not at all.
static RfVec3 s_coat_lean;

static inline RfVec3 coat_normal( RfVec3 n ) { return rf_normalize( rf_add( n, s_coat_lean ) ); }

static inline void put_surface( const Material* m, RfVec3 n, RfVec3 wo )
{
    for ( int i = 0; i < BATCH; ++i )
    {
        put_material( i, m );
        put_normal( i, m, n );
        put( COAT_N, i, s_coat_lean.x == 0.0f ? n : coat_normal( n ) );
        put( WO, i, wo );
    }
}

// Parameters outside the model's mask are NULL.
static inline RfBsdfLanes parameters_from( RfBsdfKind kind, int first )
{
    const float* const n[3] = THREE( N );
    const float* param[RF_PARAM_COUNT];
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        param[p] = s_lanes[PARAM + p];
    return rf_bsdf_lanes( kind, n, param, first );
}

static inline void evaluate_range( RfBsdfKind kind, int first, int count )
{
    const RfBsdfLanes lanes = parameters_from( kind, first );
    const float* const wo[3] = THREE_FROM( WO, first );
    const float* const wi[3] = THREE_FROM( WI, first );
    float* const f[3] = THREE_FROM( F, first );
    rf_bsdf_evaluate( kind, count, &lanes, wo, wi, f, s_lanes[PDF] + first );
}

static inline void sample_range( RfBsdfKind kind, int first, int count )
{
    const RfBsdfLanes lanes = parameters_from( kind, first );
    const float* const wo[3] = THREE_FROM( WO, first );
    const float* const u[3] = THREE_FROM( U, first );
    float* const wi[3] = THREE_FROM( WI, first );
    rf_bsdf_sample( kind, count, &lanes, wo, u, wi );
}

static inline float uniform( uint32_t stream, int i, uint32_t dimension )
{
    return rf_random( rf_pixel_key( rf_pass_key( 11, stream, 0, 0 ), (uint32_t)i ), dimension );
}

static inline RfVec3 uniform_direction( uint32_t stream, int i, uint32_t dimension )
{
    float z = 2.0f * uniform( stream, i, dimension ) - 1.0f;
    float phi = 2.0f * RF_PI * uniform( stream, i, dimension + 1 );
    float r = sqrtf( rf_maxf( 1.0f - z * z, 0.0f ) );
    return rf_normalize( rf_vec3( r * cosf( phi ), r * sinf( phi ), z ) );
}

static inline RfVec3 grey( float v ) { return rf_vec3( v, v, v ); }

// The direction with this cosine to n, towards some azimuth.
static inline RfVec3 view_direction( RfVec3 n, float cos_o )
{
    RfVec3 t, b;
    rf_basis( n, &t, &b );
    RfVec3 side = rf_add( rf_scale( t, 0.8f ), rf_scale( b, -0.6f ) );
    return rf_normalize( rf_madd( rf_scale( side, sqrtf( 1.0f - cos_o * cos_o ) ), n, cos_o ) );
}

#endif
