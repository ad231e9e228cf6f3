// CPU time per lane of every scattering model: f and density, f alone, density
// alone, sampling. Usage: bench_bsdf [lanes per call, 1024]
#include "base/random.h"
#include "bsdf/bsdf.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define MAX_LANES 65536
#define REPEATS 200

enum
{
    N = 0,
    DIFFUSE = 3,
    SPECULAR = 6,
    SHAPE = 9,
    F90,
    COAT_F0,
    COAT_F90,
    WO,
    WI = WO + 3,
    U = WI + 3,
    F = U + 3,
    PDF = F + 3,
    OUT,
    ARRAYS = OUT + 3
};

// The odd cache lines keep the arrays apart: a power of two between them would
// put them all into the same cache sets.
static float s_values[ARRAYS][MAX_LANES + 5 * 16];

static float random_value( int lane, uint32_t dimension )
{
    return rf_random( rf_pixel_key( rf_pass_key( 1, 0, 0, 0 ), (uint32_t)lane ), dimension );
}

static void put( int array, int lane, RfVec3 v )
{
    s_values[array][lane] = v.x;
    s_values[array + 1][lane] = v.y;
    s_values[array + 2][lane] = v.z;
}

static RfVec3 random_direction( int lane, uint32_t dimension )
{
    float z = 2.0f * random_value( lane, dimension ) - 1.0f;
    float phi = 2.0f * RF_PI * random_value( lane, dimension + 1 );
    float r = sqrtf( rf_maxf( 1.0f - z * z, 0.0f ) );
    return rf_vec3( r * cosf( phi ), r * sinf( phi ), z );
}

static RfVec3 random_vector( int lane, uint32_t dimension )
{
    float x = random_value( lane, dimension );
    float y = random_value( lane, dimension + 1 );
    return rf_vec3( x, y, random_value( lane, dimension + 2 ) );
}

static void fill( RfBsdfKind kind, int count )
{
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = random_direction( i, 0 );
        RfVec3 wo = random_direction( i, 2 );
        put( N, i, n );
        put( WO, i, rf_dot( n, wo ) < 0.0f ? rf_scale( wo, -1.0f ) : wo );
        put( WI, i, random_direction( i, 4 ) );
        put( U, i, random_vector( i, 6 ) );
        put( DIFFUSE, i, random_vector( i, 9 ) );
        put( SPECULAR, i, random_vector( i, 12 ) );
        float shape = random_value( i, 15 );
        s_values[SHAPE][i] = kind == RF_BSDF_PHONG ? 200.0f * shape : rf_maxf( shape, RF_MIN_ALPHA );
        s_values[F90][i] = s_values[COAT_F90][i] = 1.0f;
        s_values[COAT_F0][i] = 0.04f;
    }
}

static double cpu_seconds( void )
{
    struct timespec t;
    clock_gettime( CLOCK_PROCESS_CPUTIME_ID, &t );
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void run( RfBsdfKind kind, int what, int count )
{
#define THREE( a )                                                                                                               \
    {                                                                                                                            \
        s_values[a], s_values[( a ) + 1], s_values[( a ) + 2]                                                                    \
    }
    const float* const n[3] = THREE( N );
    const float* const param[RF_PARAM_COUNT] = {
        [RF_PARAM_DIFFUSE] = s_values[DIFFUSE],
        s_values[DIFFUSE + 1],
        s_values[DIFFUSE + 2],
        [RF_PARAM_SPECULAR] = s_values[SPECULAR],
        s_values[SPECULAR + 1],
        s_values[SPECULAR + 2],
        [RF_PARAM_SHAPE] = s_values[SHAPE],
        [RF_PARAM_F90] = s_values[F90],
        [RF_PARAM_COAT_F0] = s_values[COAT_F0],
        [RF_PARAM_COAT_F90] = s_values[COAT_F90],
        [RF_PARAM_CLEARCOAT] = s_values[F90],
        [RF_PARAM_CLEARCOAT_ALPHA] = s_values[COAT_F0],
        [RF_PARAM_CLEARCOAT_N] = s_values[N],
        s_values[N + 1],
        s_values[N + 2],
        [RF_PARAM_SHEEN] = s_values[DIFFUSE],
        s_values[DIFFUSE + 1],
        s_values[DIFFUSE + 2],
        [RF_PARAM_SHEEN_ALPHA] = s_values[SHAPE],
        [RF_PARAM_ANISOTROPY] = s_values[F90],
        [RF_PARAM_TANGENT] = s_values[N], // for time alone
        s_values[N + 1],
        s_values[N + 2],
        [RF_PARAM_FILM] = s_values[F90],
        [RF_PARAM_FILM_IOR] = s_values[F90],
        [RF_PARAM_FILM_THICKNESS] = s_values[SHAPE],
        [RF_PARAM_CHOICE] = s_values[F90],
    };
    const RfBsdfLanes lanes = rf_bsdf_lanes( kind, n, param, 0 );
    const float* const wo[3] = THREE( WO );
    const float* const wi[3] = THREE( WI );
    const float* const u[3] = THREE( U );
    float* const f[3] = THREE( F );
    float* const out[3] = THREE( OUT );
    if ( what == 3 )
        rf_bsdf_sample( kind, count, &lanes, wo, u, out );
    else
        rf_bsdf_evaluate( kind, count, &lanes, wo, wi, what == 2 ? NULL : f, what == 1 ? NULL : s_values[PDF] );
}

// The best of many short runs: the machine is shared.
static double nanoseconds_per_lane( RfBsdfKind kind, int what, int count )
{
    int calls = 1 + 200000 / count;
    double best = 1e30;
    for ( int repeat = 0; repeat < REPEATS; ++repeat )
    {
        double start = cpu_seconds();
        for ( int call = 0; call < calls; ++call )
            run( kind, what, count );
        double time = cpu_seconds() - start;
        best = time < best ? time : best;
    }
    return best * 1e9 / ( (double)calls * count );
}

int main( int argc, char** argv )
{
    int count = argc > 1 ? atoi( argv[1] ) : 1024;
    if ( count < 1 || count > MAX_LANES )
    {
        fprintf( stderr, "bench_bsdf: lanes must be 1 to %d\n", MAX_LANES );
        return 2;
    }
    printf( "model,lanes,f+pdf_ns,f_ns,pdf_ns,sample_ns\n" );
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        fill( (RfBsdfKind)kind, count );
        printf( "%s,%d", rf_bsdf_model( (RfBsdfKind)kind )->name, count );
        for ( int what = 0; what < 4; ++what )
            printf( ",%.2f", nanoseconds_per_lane( (RfBsdfKind)kind, what, count ) );
        printf( "\n" );
    }
    return 0;
}
