// Mirrors and glass: what sampling returns, direction by direction, and Fresnel's equations.
#include "differential/models.h"

#include <stdio.h>

// x = n, wo, wi, parameters of the model with its rounding, lobe.
enum
{
    X_BASE = X_PARAM,
    X_SPECULAR,
    X_ALPHA,
    X_METAL,
    X_TINT,
    X_IOR,
    X_ROUNDING,
    X_LOBE,
};

typedef enum Lobe
{
    DIFFUSE_LOBE,
    REFLECTED,
    TRANSMITTED,
} Lobe;

static D3 facet_of( const double* x, D3 n, D3 o, D3 i )
{
    double ior = x[X_IOR];
    if ( x[X_ALPHA] == 0.0 )
        return n;
    if ( (Lobe)x[X_LOBE] == REFLECTED )
        return d3_unit( d3_sum( o, 1.0, i ) );
    if ( ior < 0.0 ) // a thin wall: the reflection, turned over
        return d3_unit( d3_sum( o, 1.0, d3_sum( i, -2.0 * d3_dot( i, n ), n ) ) );
    // Walter et al. 2007; on the side of the eye, since on that of n it may lie in the surface by less than a rounding
    D3 h = d3_unit( d3_sum( o, ior, i ) );
    return d3_dot( h, o ) > 0.0 ? h : ( D3 ){ -h.x, -h.y, -h.z };
}

// Where the facet sends the eye's ray: by the law of reflection, or Snell's.
static D3 sent_by( const double* x, D3 n, D3 o, D3 h )
{
    double cos_o = d3_dot( o, h ), ior = x[X_IOR];
    D3 mirror = d3_sum( ( D3 ){ -o.x, -o.y, -o.z }, 2.0 * cos_o, h );
    if ( (Lobe)x[X_LOBE] == REFLECTED )
        return mirror;
    if ( ior < 0.0 )
        return d3_sum( mirror, -2.0 * d3_dot( mirror, n ), n );
    double angle = asin( fmin( sin( acos( fmin( cos_o, 1.0 ) ) ) / ior, 1.0 ) );
    D3 across = d3_sum( o, -cos_o, h ), zero = { 0, 0, 0 };
    double length = d3_length( across );
    D3 down = { -h.x * cos( angle ), -h.y * cos( angle ), -h.z * cos( angle ) };
    return length > 0.0 ? d3_sum( down, -sin( angle ) / length, across ) : d3_sum( zero, 1.0, down );
}

// y = the weight of the sample, its density where that is finite, and wi less what the facet sends, along three axes (0).
static void reference( const double* x, double* y )
{
    const double* p = x + X_PARAM;
    D3 n = d3_unit( d3_at( x + X_N ) ), o = d3_unit( lifted_eye( n, d3_at( x + X_WO ) ) ), i = d3_unit( d3_at( x + X_WI ) );
    D3 h = facet_of( x, n, o, i );
    double mo = d3_dot( n, o ), oh = d3_dot( o, h ), base = glass_base_probability( p, mo );
    double reflect = glass_reflection_probability( p, oh );
    if ( (Lobe)x[X_LOBE] == TRANSMITTED )
    {
        double theta = acos( fmin( oh, 1.0 ) ), ior = fabs( p[X_IOR - X_PARAM] );
        double shadow = p[X_ALPHA - X_PARAM] > 0.0
                            ? 1.0 / ( 1.0 + ggx_lambda( p[X_ALPHA - X_PARAM], acos( fmin( fabs( d3_dot( n, i ) ), 1.0 ) ) ) )
                            : 1.0;
        y[0] = x[X_TINT] * ( 1.0 - fresnel( theta, ior ) ) * shadow * ( x[X_IOR] < 0.0 ? 1.0 : 1.0 / ( ior * ior ) ) /
               ( ( 1.0 - base ) * ( 1.0 - reflect ) );
    }
    else if ( (Lobe)x[X_LOBE] == REFLECTED && x[X_ALPHA] == 0.0 )
        y[0] = glass_reflectance( p, oh ) / ( ( 1.0 - base ) * reflect );
    else
    {
        double s[2];
        reference_glass( x, s );
        y[0] = s[0] * d3_dot( n, i ) / s[1];
    }
    D3 sent = (Lobe)x[X_LOBE] == DIFFUSE_LOBE ? i : sent_by( x, n, o, h );
    y[1] = sent.x - i.x;
    y[2] = sent.y - i.y;
    y[3] = sent.z - i.z;
}

static void describe( const double* x, char* text, size_t size )
{
    static const char* s_names[] = { "base", "reflected", "transmitted" };
    D3 n = d3_at( x + X_N );
    snprintf( text, size, "%s, θo %.6g°, θi %.6g°, alpha %.4g, ior %.6g", s_names[(int)x[X_LOBE]],
              57.29577951308232 * d3_angle( n, d3_at( x + X_WO ) ), 57.29577951308232 * d3_angle( n, d3_at( x + X_WI ) ),
              x[X_ALPHA], x[X_IOR] );
}

static int check_samples( long count )
{
    static Surface s_surface[BATCH];
    static float s_weight[3][BATCH];
    static Check s_check = { X_LOBE + 1,
                             4,
                             reference,
                             describe,
                             { { "glass: weight of samples", .limit = 512 },
                               { "glass: direction, x", .scale = 1, .limit = 16 },
                               { "glass: direction, y", .scale = 1, .limit = 16 },
                               { "glass: direction, z", .scale = 1, .limit = 16 } } };
    float* weight[3] = { s_weight[0], s_weight[1], s_weight[2] };
    const float* const wo[3] = THREE( WO );
    const float* const u[3] = THREE( U );
    float* const wi[3] = THREE( WI );
    for ( long first = 0; first < count; first += BATCH )
    {
        for ( int k = 0; k < BATCH; ++k )
        {
            s_surface[k] = random_surface( RF_BSDF_GLASS, 21, first + k );
            put_lane( k, s_surface + k );
            for ( uint32_t c = 0; c < 3; ++c )
                s_lanes[U + c][k] = rf_minf( (float)random_between( 0.0, 1.0, 21, first + k, 60 + c ), 1.0f - 0x1p-24f );
        }
        const RfBsdfLanes lanes = parameters_from( RF_BSDF_GLASS, 0 );
        TRAPPED( rf_bsdf_sample_weighted( RF_BSDF_GLASS, BATCH, &lanes, wo, u, wi, weight, s_lanes[PDF] ) );
        for ( int k = 0; k < BATCH; ++k )
        {
            Inputs in;
            add_surface( &in, RF_BSDF_GLASS, s_surface + k, get( WI, k ) );
            if ( !( s_weight[0][k] > 0.0f ) )
                continue; // nothing is scattered
            D3 n = d3_unit( d3_at( in.x + X_N ) ), o = d3_unit( lifted_eye( n, d3_at( in.x + X_WO ) ) );
            double base = glass_base_probability( in.x + X_PARAM, d3_dot( n, o ) );
            bool below = rf_dot( s_surface[k].n, get( WI, k ) ) < 0.0f;
            Lobe lobe = below ? TRANSMITTED : (double)s_lanes[U + 2][k] < base ? DIFFUSE_LOBE : REFLECTED;
            if ( fabs( (double)s_lanes[U + 2][k] - base ) < 1e-5 && lobe != TRANSMITTED )
                continue;
            in.x[in.count++] = lobe;
            double got[4] = { (double)s_weight[0][k], 0.0, 0.0, 0.0 };
            judge( &s_check, in.x, in.step, got );
        }
    }
    return print_check( &s_check );
}

// x = cosine, ior; y = reflectance.
static void reference_fresnel( const double* x, double* y ) { y[0] = fresnel( acos( x[0] ), x[1] ); }

static void describe_fresnel( const double* x, char* text, size_t size )
{
    snprintf( text, size, "θ %.6g°, ior %.9g", 57.29577951308232 * acos( x[0] ), x[1] );
}

// Fresnel's equations as a mirror of glass has them.
static int check_fresnel( long count )
{
    static Check s_check = { 2, 1, reference_fresnel, describe_fresnel, { { "Fresnel", .scale = 1e-9, .limit = 16 } } };
    static const float s_ior[] = { 1.0f, 1.0001f, 1.5f, 10.0f, 1.0f / 1.5f, 0.1f };
    for ( long k = 0; k < count; ++k )
    {
        int choice = (int)( 8.0 * random_number( 22, k, 0 ) );
        float ior = choice < 6 ? s_ior[choice] : (float)random_wide( 0.1, 10.0, 22, k, 1 );
        double angle = random_number( 22, k, 2 ) < 0.5 ? random_wide( 1e-7, 1.5697, 22, k, 3 )
                                                       : acos( random_between( 1e-3, 1.0, 22, k, 4 ) );
        float cosine = rf_clampf( (float)cos( angle ), RF_MIN_COS, 1.0f );
        RfMaterial glass = { .kind = RF_BSDF_GLASS, .ior = ior, .tint = { 1, 1, 1 } };
        RfVec3 weight;
        double x[2] = { (double)cosine, (double)ior }, step[2] = { UNIT_ROUNDOFF, UNIT_ROUNDOFF * (double)ior };
        step[0] = x[0] + 8.0 * step[0] > 1.0 ? ( 1.0 - x[0] ) / 8.0 : step[0];
        double got;
        TRAPPED( got = (double)rf_glass_reflection( &glass, cosine, &weight ) );
        judge( &s_check, x, step, &got );
    }
    return print_check( &s_check );
}

int check_glass( long count ) { return check_samples( count ) + check_fresnel( count ); }
