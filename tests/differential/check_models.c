// f and density of every scattering model.
#include "differential/models.h"

#include <stdio.h>
#include <string.h>

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
    snprintf( text + used, size - (size_t)used, ", shape %.4g, coat %.2g of %.4g", x[X_PARAM + 2], x[X_PARAM + COAT],
              x[X_PARAM + COAT_ALPHA] );
}

static void describe_sheen( const double* x, char* text, size_t size )
{
    int used = describe_angles( x, text, size );
    snprintf( text + used, size - (size_t)used, ", shape %.4g, sheen %.2g of %.4g", x[X_PARAM + 2], x[X_PARAM + SHEEN_COLOR],
              x[X_PARAM + SHEEN_SHAPE] );
}

static void describe_facets( const double* x, char* text, size_t size )
{
    const double* p = x + X_PARAM;
    int used = describe_angles( x, text, size );
    snprintf( text + used, size - (size_t)used, ", shape %.4g, stretch %.2g, film %.2g of %.4g, %.4g nm", p[2], p[STRETCH],
              p[FILM_STRENGTH], p[FILM_INDEX], p[FILM_NM] );
}

static void describe_layered( const double* x, char* text, size_t size )
{
    const double* p = x + X_PARAM;
    describe_facets( x, text, size );
    size_t used = strlen( text );
    snprintf( text + used, size - used, ", coat %.2g of %.4g, sheen %.2g of %.4g", p[COAT], p[COAT_ALPHA], p[SHEEN_COLOR],
              p[SHEEN_SHAPE] );
}

static void describe_translucent( const double* x, char* text, size_t size )
{
    int used = describe_angles( x, text, size );
    snprintf( text + used, size - (size_t)used, ", shape %.4g, through %.4g, side %g", x[X_PARAM + 2], x[X_PARAM + 7],
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
    if ( random_number( stream, i, 74 ) < 0.3 && axis.x == s->n.x &&
         rf_has_param( rf_bsdf_model( kind )->params, RF_PARAM_ANISOTROPY ) )
        width += ( 1.0f - width ) * s->anisotropy * s->anisotropy;
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
            double got[MAX_OUTPUTS];
            for ( int c = 0; c < check->outputs - 1; ++c )
                got[c] = (double)s_lanes[F + c][k];
            got[check->outputs - 1] = (double)s_lanes[PDF][k];
            check->inputs = in.count;
            judge( check, in.x, in.step, got );
        }
    }
    return print_check( check );
}

int check_models( long count )
{
    static Check s_checks[RF_BSDF_KIND_COUNT] = {
        [RF_BSDF_LAMBERT] = { 0,
                              2,
                              reference_lambert,
                              describe_lambert,
                              { { "lambert: f", .limit = 8 }, { "lambert: density", .limit = 8 } } },
        [RF_BSDF_PHONG] = { 0,
                            2,
                            reference_phong,
                            describe_lobe,
                            { { "phong: f", .limit = 8 }, { "phong: density", .limit = 8 } } },
        [RF_BSDF_GGX] = { 0,
                          2,
                          reference_ggx,
                          describe_lobe,
                          { { "ggx: f", .limit = 1024 }, { "ggx: density", .limit = 1024 } } },
        [RF_BSDF_COATED] = { 0,
                             2,
                             reference_coated,
                             describe_coated,
                             { { "coated: f", .limit = 1024 }, { "coated: density", .limit = 1024 } } },
        [RF_BSDF_SHEEN] = { 0,
                            2,
                            reference_sheen,
                            describe_sheen,
                            { { "sheen: f", .limit = 1024 }, { "sheen: density", .limit = 1024 } } },
        [RF_BSDF_ANISOTROPIC] = { 0,
                                  2,
                                  reference_anisotropic,
                                  describe_facets,
                                  { { "anisotropic: f", .limit = 1024 }, { "anisotropic: density", .limit = 1024 } } },
        [RF_BSDF_IRIDESCENT] = { 0,
                                 4,
                                 reference_iridescent,
                                 describe_facets,
                                 { { "iridescent: red", .limit = 1024 },
                                   { "iridescent: green", .limit = 1024 },
                                   { "iridescent: blue", .limit = 1024 },
                                   { "iridescent: density", .limit = 1024 } } },
        [RF_BSDF_LAYERED] = { 0,
                              4,
                              reference_layered,
                              describe_layered,
                              { { "layered: red", .limit = 1024 },
                                { "layered: green", .limit = 1024 },
                                { "layered: blue", .limit = 1024 },
                                { "layered: density", .limit = 1024 } } },
        [RF_BSDF_TRANSLUCENT] = { 0,
                                  2,
                                  reference_translucent,
                                  describe_translucent,
                                  { { "translucent: f", .limit = 1024 }, { "translucent: density", .limit = 1024 } } },
        [RF_BSDF_GLASS] = { 0,
                            2,
                            reference_glass,
                            describe_glass,
                            { { "glass, rough: f", .limit = 1024 }, { "glass, rough: density", .limit = 1024 } } },
    };
    int bad = 0;
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
        bad += s_checks[kind].reference != NULL ? check_model( s_checks + kind, (RfBsdfKind)kind, count ) : 0;
    return bad;
}
