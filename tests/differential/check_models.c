// f and density of every scattering model.
#include "differential/models.h"

#include <stdio.h>

static double degrees( D3 a, D3 b ) { return 57.29577951308232 * d3_angle( a, b ); }

// Angles of eye and light to the normal, and of the light to the mirror direction.
static int describe_angles( const double* x, char* text, size_t size )
{
    D3 n = d3_unit( d3_at( x + X_N ) ), o = d3_at( x + X_WO ), i = d3_at( x + X_WI );
    D3 mirror = d3_sum( ( D3 ){ -o.x, -o.y, -o.z }, 2.0 * d3_dot( n, o ), n );
    return snprintf( text, size, "θo %.6g°, θi %.6g°, off mirror %.2g°", degrees( n, o ), degrees( n, i ), degrees( mirror, i ) );
}

static void describe_lambert( const double* x, char* text, size_t size ) { describe_angles( x, text, size ); }

static void describe_lobe( const double* x, char* text, size_t size )
{
    int used = describe_angles( x, text, size );
    snprintf( text + used, size - (size_t)used, ", shape %.4g", x[X_PARAM + 2] );
}

static void describe_coated( const double* x, char* text, size_t size )
{
    int used = describe_angles( x, text, size );
    snprintf( text + used, size - (size_t)used, ", shape %.4g, coat %.2g of %.4g", x[X_PARAM + 2], x[X_PARAM + 7],
              x[X_PARAM + 8] );
}

static void describe_glass( const double* x, char* text, size_t size )
{
    int used = describe_angles( x, text, size );
    snprintf( text + used, size - (size_t)used, ", alpha %.4g, ior %.6g", x[X_PARAM + 2], x[X_PARAM + 5] );
}

// Into the lobe, near it, or anywhere.
static RfVec3 incoming( const Surface* s, RfBsdfKind kind, uint32_t stream, long i )
{
    if ( random_number( stream, i, 50 ) < 0.4 )
        return random_around( s->n, stream, i, 51 );
    RfVec3 axis = random_number( stream, i, 55 ) < 0.5 ? s->coat_n : s->n, eye = s->wo;
    float missing = RF_MIN_COS - rf_dot( axis, eye );
    if ( missing > 0.0f )
        eye = rf_normalize( rf_madd( eye, axis, missing ) );
    RfVec3 mirror = rf_normalize( rf_sub( rf_scale( axis, 2.0f * rf_dot( axis, eye ) ), eye ) );
    float width = kind == RF_BSDF_PHONG ? 1.0f / sqrtf( s->shape + 1.0f )
                                        : rf_maxf( axis.x == s->n.x ? s->shape : s->clearcoat_alpha, RF_MIN_ALPHA );
    width *= (float)random_wide( 1e-3, 10.0, stream, i, 56 );
    return rf_normalize( rf_madd( mirror, random_direction( stream, i, 58 ), width ) );
}

static int check_model( Check* check, RfBsdfKind kind, long count )
{
    static Surface s_surface[BATCH];
    uint32_t stream = 1 + (uint32_t)kind;
    for ( long first = 0; first < count; first += BATCH )
    {
        for ( int k = 0; k < BATCH; ++k )
        {
            s_surface[k] = random_surface( kind, stream, first + k );
            put_lane( k, s_surface + k );
            put( WI, k, incoming( s_surface + k, kind, stream, first + k ) );
        }
        TRAPPED( evaluate_range( kind, 0, BATCH ) );
        for ( int k = 0; k < BATCH; ++k )
        {
            Inputs in;
            add_surface( &in, kind, s_surface + k, get( WI, k ) );
            double got[2] = { (double)s_lanes[F][k], (double)s_lanes[PDF][k] };
            check->inputs = in.count;
            judge( check, in.x, in.step, got );
        }
    }
    return print_check( check );
}

int check_models( long count )
{
    static Check s_checks[RF_BSDF_KIND_COUNT] = {
        { 0, 2, reference_lambert, describe_lambert, { { "lambert: f", .limit = 8 }, { "lambert: density", .limit = 8 } } },
        { 0, 2, reference_phong, describe_lobe, { { "phong: f", .limit = 8 }, { "phong: density", .limit = 8 } } },
        { 0, 2, reference_ggx, describe_lobe, { { "ggx: f", .limit = 1024 }, { "ggx: density", .limit = 1024 } } },
        { 0, 2, reference_coated, describe_coated, { { "coated: f", .limit = 1024 }, { "coated: density", .limit = 1024 } } },
        { 0,
          2,
          reference_glass,
          describe_glass,
          { { "glass, rough: f", .limit = 1024 }, { "glass, rough: density", .limit = 1024 } } },
    };
    int bad = 0;
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
        bad += check_model( s_checks + kind, (RfBsdfKind)kind, count );
    return bad;
}
