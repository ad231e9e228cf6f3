// Sampling: from the sampled direction back to the random numbers, by the distributions of the literature. What comes back
// are the numbers that went in, so the directions have the density that evaluation says.
#include "differential/models.h"

#include <stdio.h>

// Which lobe a case has drawn.
typedef enum Lobe
{
    COSINE,
    PHONG,
    VISIBLE_NORMAL, // of the model's own surface
    COAT_LOBE,
    SHEEN_LOBE,
} Lobe;

// x = n, wo, wi, shape of the lobe, lobe, rounding of the facet along two tangents; y = both random numbers.
enum
{
    X_SHAPE = X_PARAM,
    X_LOBE,
    X_FACET,
    X_FACET_ACROSS,
    SAMPLING_INPUTS,
};

// What a rounding tilts the facet by that u samples. It is the sum of the eye and of a point of the cap, both scaled by alpha
// along the surface, and these cancel where it is seen edge-on.
static double facet_step( const double* x, const double u[2] )
{
    D3 n = d3_unit( d3_at( x + X_N ) ), o = d3_unit( lifted_eye( n, d3_at( x + X_WO ) ) ), t, b;
    d3_basis( n, &t, &b );
    double alpha = x[X_SHAPE];
    D3 v = d3_unit( ( D3 ){ alpha * d3_dot( o, t ), alpha * d3_dot( o, b ), d3_dot( o, n ) } );
    double height = ( 1.0 - u[0] ) * ( 1.0 + v.z ), z = height - v.z, r = sqrt( fmax( 1.0 - z * z, 0.0 ) );
    double angle = 2.0 * 3.14159265358979323846 * u[1];
    D3 facet = { alpha * ( r * cos( angle ) + v.x ), alpha * ( r * sin( angle ) + v.y ), height };
    double length = d3_length( facet );
    return length > alpha * UNIT_ROUNDOFF ? UNIT_ROUNDOFF * alpha / length : 1.0;
}

static void invert( const double* x, double* y )
{
    D3 n = d3_unit( d3_at( x + X_N ) ), i = d3_at( x + X_WI ), o = lifted_eye( n, d3_at( x + X_WO ) );
    Lobe lobe = (Lobe)x[X_LOBE];
    if ( lobe == VISIBLE_NORMAL )
    {
        // what is sampled is the direction, so its own length is no news
        D3 eye = d3_unit( o ), h = d3_unit( d3_sum( eye, 1.0, d3_unit( i ) ) ), s, t;
        d3_basis( n, &s, &t );
        h = d3_unit( d3_sum( d3_sum( h, x[X_FACET], s ), x[X_FACET_ACROSS], t ) );
        invert_visible_normal( n, eye, h, x[X_SHAPE], y );
        return;
    }
    D3 axis = lobe == PHONG ? d3_sum( ( D3 ){ -o.x, -o.y, -o.z }, 2.0 * d3_dot( n, o ), n ) : n;
    double half = sin( 0.5 * d3_angle( axis, i ) );
    if ( lobe == SHEEN_LOBE )
    {
        y[0] = pow( 2.0 * half * half, sheen_power( x[X_SHAPE] ) );
        y[1] = azimuth_of( n, i );
        return;
    }
    double exponent = lobe == PHONG ? x[X_SHAPE] + 1.0 : 2.0;
    y[0] = -expm1( exponent * log1p( -fmin( 2.0 * half * half, 1.0 ) ) );
    y[1] = azimuth_of( d3_unit( axis ), i );
}

static void describe( const double* x, char* text, size_t size )
{
    static const char* s_names[] = { "cosine", "Phong", "visible normal", "coat", "sheen" };
    D3 n = d3_at( x + X_N );
    snprintf( text, size, "%s, θo %.6g°, θi %.6g°, shape %.4g", s_names[(int)x[X_LOBE]],
              57.29577951308232 * d3_angle( n, d3_at( x + X_WO ) ), 57.29577951308232 * d3_angle( n, d3_at( x + X_WI ) ),
              x[X_SHAPE] );
}

// The lobe that u selects; −1 where that is a matter of rounding.
static int lobe_of( RfBsdfKind kind, const Surface* s, const Inputs* in, double u )
{
    double p = 1.0, margin = 1e-5, mo;
    D3 n = d3_unit( d3_at( in->x + X_N ) ), o = lifted_eye( n, d3_at( in->x + X_WO ) );
    const double* param = in->x + X_PARAM;
    mo = d3_dot( n, o );
    bool is_ggx = kind == RF_BSDF_GGX || kind == RF_BSDF_COATED || kind == RF_BSDF_SHEEN;
    if ( is_ggx && schlick( param[1], param[3], mo ) + param[0] * ( 1.0 - schlick( param[4], param[5], mo ) ) < 1e-3 )
        return -1; // black: which lobe has more of nothing
    if ( kind == RF_BSDF_COATED )
    {
        D3 coat = { (double)s->coat_n.x, (double)s->coat_n.y, (double)s->coat_n.z };
        double q = coat_probability_of( param, d3_dot( d3_unit( coat ), lifted_eye( d3_unit( coat ), d3_at( in->x + X_WO ) ) ) );
        if ( fabs( u - q ) < margin || q > 0.999 )
            return -1;
        if ( u < q )
            return COAT_LOBE;
        u = ( u - q ) / ( 1.0 - q );
        margin /= 1.0 - q;
    }
    if ( kind == RF_BSDF_SHEEN )
    {
        double q = sheen_probability_of( param );
        if ( fabs( u - q ) < margin )
            return -1;
        if ( u < q )
            return SHEEN_LOBE;
        u = ( u - q ) / ( 1.0 - q );
        margin /= 1.0 - q;
    }
    p = kind == RF_BSDF_PHONG ? phong_diffuse_probability( param )
                              : ( kind == RF_BSDF_LAMBERT ? 1.0 : ggx_specular_probability( param, mo ) );
    if ( fabs( u - p ) < margin )
        return -1;
    if ( kind == RF_BSDF_PHONG || kind == RF_BSDF_LAMBERT )
        return u < p ? COSINE : PHONG;
    return u < p ? VISIBLE_NORMAL : COSINE;
}

static void judge_sample( Check* check, RfBsdfKind kind, const Surface* s, int lane )
{
    Inputs all, in = { 0 };
    RfVec3 wi = get( WI, lane );
    add_surface( &all, kind, s, wi );
    int lobe = lobe_of( kind, s, &all, (double)s_lanes[U + 2][lane] );
    if ( lobe < 0 )
        return;
    bool is_coat = lobe == COAT_LOBE;
    if ( ( is_coat || lobe == VISIBLE_NORMAL ) && rf_dot( is_coat ? s->coat_n : s->n, wi ) <= 0.0f )
        return; // below the surface, where f is 0
    add_direction( &in, is_coat ? s->coat_n : s->n );
    add_direction( &in, s->wo );
    add_direction( &in, wi );
    add_number( &in, (double)( is_coat ? s->clearcoat_alpha : lobe == SHEEN_LOBE ? s->sheen_alpha : s->shape ) );
    in.x[in.count++] = is_coat ? VISIBLE_NORMAL : lobe;
    double want[2], got[2] = { (double)s_lanes[U][lane], (double)s_lanes[U + 1][lane] };
    for ( int k = 0; k < 2; ++k )
    {
        in.x[in.count] = 0.0;
        in.step[in.count++] = lobe == VISIBLE_NORMAL || is_coat ? facet_step( in.x, got ) : 0.0;
    }
    // azimuths are compared the shorter way round
    invert( in.x, want );
    got[1] += got[1] - want[1] > 0.5 ? -1.0 : got[1] - want[1] < -0.5 ? 1.0 : 0.0;
    judge( check, in.x, in.step, got );
}

int check_sampling( long count )
{
    static Surface s_surface[BATCH];
    static Check s_checks[RF_BSDF_FIRST_SPECULAR] = {
        [RF_BSDF_LAMBERT] = { SAMPLING_INPUTS,
                              2,
                              invert,
                              describe,
                              { { "lambert: sampling, polar", .scale = 1, .limit = 8 },
                                { "lambert: sampling, azimuth", .scale = 1, .limit = 8 } } },
        [RF_BSDF_PHONG] = { SAMPLING_INPUTS,
                            2,
                            invert,
                            describe,
                            { { "phong: sampling, polar", .scale = 1, .limit = 8 },
                              { "phong: sampling, azimuth", .scale = 1, .limit = 8 } } },
        [RF_BSDF_GGX] = { SAMPLING_INPUTS,
                          2,
                          invert,
                          describe,
                          { { "ggx: sampling, polar", .scale = 1, .limit = 32 },
                            { "ggx: sampling, azimuth", .scale = 1, .limit = 32 } } },
        [RF_BSDF_COATED] = { SAMPLING_INPUTS,
                             2,
                             invert,
                             describe,
                             { { "coated: sampling, polar", .scale = 1, .limit = 32 },
                               { "coated: sampling, azimuth", .scale = 1, .limit = 32 } } },
        [RF_BSDF_SHEEN] = { SAMPLING_INPUTS,
                            2,
                            invert,
                            describe,
                            { { "sheen: sampling, polar", .scale = 1, .limit = 32 },
                              { "sheen: sampling, azimuth", .scale = 1, .limit = 32 } } },
    };
    int bad = 0;
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        if ( s_checks[kind].reference == NULL )
            continue;
        uint32_t stream = 11 + (uint32_t)kind;
        for ( long first = 0; first < count; first += BATCH )
        {
            for ( int k = 0; k < BATCH; ++k )
            {
                s_surface[k] = random_surface( (RfBsdfKind)kind, stream, first + k );
                put_lane( k, s_surface + k );
                for ( uint32_t c = 0; c < 3; ++c )
                    s_lanes[U + c][k] = rf_minf( (float)random_between( 0.0, 1.0, stream, first + k, 60 + c ), 1.0f - 0x1p-24f );
            }
            TRAPPED( sample_range( (RfBsdfKind)kind, 0, BATCH ) );
            for ( int k = 0; k < BATCH; ++k )
                judge_sample( s_checks + kind, (RfBsdfKind)kind, s_surface + k, k );
        }
        bad += print_check( s_checks + kind );
    }
    return bad;
}
