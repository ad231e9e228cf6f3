// Rough glass as the frames of a group share it, whose sides are drawn: both sides together are those of glass, the transmitted light
// is that of Walter et al. (2007) in double precision.
#include "support/bsdf_lanes.h"
#include "support/statistics.h"
#include "support/test.h"

static const double s_pi = 3.14159265358979323846;

static Material random_frosted( uint32_t stream, int i )
{
    float ior = 1.1f + 1.4f * uniform( stream, i, 10 ), base = uniform( stream, i, 11 ) < 0.5f ? 0.0f : 0.5f;
    return ( Material ){ .kind = RF_BSDF_FROSTED,
                         .diffuse = rf_scale( rf_vec3( 0.9f, 0.5f, 0.1f ), base ),
                         .coat_f0 = base,
                         .coat_f90 = uniform( stream, i, 12 ) < 0.5f ? 0.0f : 1.0f,
                         .through = rf_scale( rf_vec3( 1.0f, 0.8f, 0.6f ), 1.0f - base ),
                         .shape = 0.04f + 0.96f * uniform( stream, i, 13 ) * uniform( stream, i, 14 ),
                         .ior = uniform( stream, i, 15 ) < 0.5f ? ior : -ior };
}

static RfVec3 towards( RfVec3 n, uint32_t stream, int i, uint32_t dimension )
{
    RfVec3 t, b;
    rf_basis( n, &t, &b );
    float phi = 2.0f * RF_PI * uniform( stream, i, dimension ), cosine = 0.01f + 0.99f * uniform( stream, i, dimension + 1 );
    RfVec3 across = rf_add( rf_scale( t, cosf( phi ) ), rf_scale( b, sinf( phi ) ) );
    return rf_normalize( rf_madd( rf_scale( across, sqrtf( 1.0f - cosine * cosine ) ), n, cosine ) );
}

static void put_drawn( Material* m, float side, RfVec3 n, RfVec3 wo )
{
    m->side = side;
    put_material( 0, m );
    put( N, 0, rf_scale( n, side ) );
    put( WO, 0, wo );
}

static float through_probability( const Material* m )
{
    put_material( 0, m );
    put( N, 0, rf_vec3( 0, 0, 1 ) );
    RfBsdfLanes lanes = parameters_from( RF_BSDF_FROSTED, 0 );
    return rf_frosted_through_probability( &lanes, 0 );
}

static RfVec3 evaluate_drawn( Material m, float side, RfVec3 n, RfVec3 wo, RfVec3 wi, float* pdf )
{
    put_drawn( &m, side, n, wo );
    put( WI, 0, wi );
    evaluate_range( m.kind, 0, 1 );
    *pdf = s_lanes[PDF][0];
    return get( F, 0 );
}

static RfVec3 evaluate_glass( Material m, RfVec3 n, RfVec3 wo, RfVec3 wi )
{
    put_drawn( &m, 1.0f, n, wo );
    put( WI, 0, wi );
    evaluate_range( RF_BSDF_GLASS, 0, 1 );
    return get( F, 0 );
}

static void assert_close( double value, double expected, double relative, const char* what, int i )
{
    if ( !( fabs( value - expected ) <= relative * fabs( expected ) + 1e-12 ) )
        fail_msg( "%s %d: %.9g instead of %.9g", what, i, value, expected );
}

TEST( test_the_side_that_is_seen_is_that_of_glass )
{
    for ( int i = 0; i < 100000; ++i )
    {
        Material m = random_frosted( 1, i );
        RfVec3 n = uniform_direction( 1, i, 0 ), wo = towards( n, 1, i, 20 ), wi = towards( n, 1, i, 30 );
        double p = (double)through_probability( &m );
        float pdf;
        RfVec3 f = evaluate_drawn( m, 1.0f, n, wo, wi, &pdf ), g = evaluate_glass( m, n, wo, wi );
        assert_true( p > 0.0 && p <= 0.9 );
        assert_close( ( 1.0 - p ) * (double)f.x, (double)g.x, 1e-5, "red", i );
        assert_close( ( 1.0 - p ) * (double)f.z, (double)g.z, 1e-5, "blue", i );
    }
}

typedef struct Double3
{
    double x, y, z;
} Double3;

static Double3 in_doubles( RfVec3 v )
{
    double l = sqrt( (double)v.x * (double)v.x + (double)v.y * (double)v.y + (double)v.z * (double)v.z );
    return ( Double3 ){ (double)v.x / l, (double)v.y / l, (double)v.z / l };
}

static double dot( Double3 a, Double3 b ) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static double masking( double alpha, double cosine )
{
    double t2 = 1.0 / ( cosine * cosine ) - 1.0;
    return 2.0 / ( 1.0 + sqrt( 1.0 + alpha * alpha * t2 ) );
}

// Fresnel's equations for amplitudes, by angles.
static double reflected( double cosine, double ior )
{
    double a = acos( fmin( cosine, 1.0 ) ), b = asin( sin( a ) / ior );
    double s = ( cos( a ) - ior * cos( b ) ) / ( cos( a ) + ior * cos( b ) );
    double p = ( ior * cos( a ) - cos( b ) ) / ( ior * cos( a ) + cos( b ) );
    return 0.5 * ( s * s + p * p );
}

// f of what an interface of white glass transmits: (21), (33) and (34) of Walter et al.; that of a wall is reflection turned over.
static double transmitted( const Material* m, Double3 n, Double3 o, Double3 i )
{
    double alpha = (double)m->shape, ior = fabs( (double)m->ior ), no = dot( n, o ), ni = -dot( n, i );
    bool wall = m->ior < 0.0f;
    Double3 h = { -o.x - ior * i.x, -o.y - ior * i.y, -o.z - ior * i.z };
    if ( wall )
        h = ( Double3 ){ o.x + i.x + 2.0 * ni * n.x, o.y + i.y + 2.0 * ni * n.y, o.z + i.z + 2.0 * ni * n.z };
    double l = sqrt( dot( h, h ) );
    h = ( Double3 ){ h.x / l, h.y / l, h.z / l };
    double nh = dot( n, h ), oh = dot( o, h ), ih = dot( i, h );
    if ( nh <= 0.0 || oh <= 0.0 || ( !wall && ih >= 0.0 ) )
        return 0.0;
    double c2 = nh * nh, t2 = ( 1.0 - c2 ) / c2, a2 = alpha * alpha;
    double d = a2 / ( s_pi * c2 * c2 * ( a2 + t2 ) * ( a2 + t2 ) );
    double lobe = d * masking( alpha, no ) * masking( alpha, ni ) * ( 1.0 - reflected( oh, ior ) );
    if ( wall )
        return lobe / ( 4.0 * no * ni );
    double sum = oh + ior * ih;
    return oh * -ih / ( no * ni ) * lobe / ( sum * sum );
}

TEST( test_the_other_side_is_that_of_walter )
{
    int lit = 0;
    for ( int i = 0; i < 200000; ++i )
    {
        Material m = random_frosted( 2, i );
        RfVec3 n = uniform_direction( 2, i, 0 ), wo = towards( n, 2, i, 20 ), wi = rf_scale( towards( n, 2, i, 30 ), -1.0f );
        if ( i % 2 == 0 ) // into the lobe
        {
            put_drawn( &m, -1.0f, n, wo );
            for ( int k = 0; k < 3; ++k )
                s_lanes[U + k][0] = uniform( 2, i, 40 + (uint32_t)k );
            sample_range( m.kind, 0, 1 );
            wi = get( WI, 0 );
        }
        if ( rf_dot( n, wi ) > -0.01f )
            continue;
        double p = (double)through_probability( &m ), f = transmitted( &m, in_doubles( n ), in_doubles( wo ), in_doubles( wi ) );
        float pdf;
        RfVec3 got = evaluate_drawn( m, -1.0f, n, wo, wi, &pdf );
        // the rounding of h is that of directions over |o + η i|, and D falls by 4 / α with it at most
        double near = 1e-4 + 4e-6 / ( (double)m.shape * ( fabs( (double)m.ior ) - 1.0 ) );
        if ( f < 1e-4 )
            continue;
        ++lit;
        assert_close( p * (double)got.x, (double)m.through.x * f, near, "red", i );
        assert_close( p * (double)got.z, (double)m.through.z * f, near, "blue", i );
        assert_true( pdf > 0.0f );
    }
    assert_true( lit > 100000 );
}

// What glass transmits by its own samples, and both sides of what is drawn: the light of the whole sphere and its mean direction.
TEST( test_both_sides_are_glass_on_the_mean )
{
    enum
    {
        CASES = 24,
        SAMPLES = 40000
    };
    for ( int c = 0; c < CASES; ++c )
    {
        Material m = random_frosted( 3, c );
        m.diffuse = rf_vec3( 0, 0, 0 );
        m.coat_f0 = 0.0f;
        RfVec3 n = rf_vec3( 0, 0, 1 ), wo = towards( n, 3, c, 20 );
        double p = (double)through_probability( &m ), sum[2][3] = { { 0 } }, squares[2][3] = { { 0 } };
        for ( int i = 0; i < SAMPLES; ++i )
        {
            float u[3] = { uniform( 4, i, 0 ), uniform( 4, i, 1 ), uniform( 4, i, 2 ) };
            for ( int drawn = 0; drawn < 2; ++drawn )
            {
                float side = !drawn || (double)uniform( 4, i, 3 ) >= p ? 1.0f : -1.0f;
                put_drawn( &m, side, n, wo );
                for ( int k = 0; k < 3; ++k )
                    s_lanes[U + k][0] = drawn ? uniform( 5, i, (uint32_t)k ) : u[k];
                double weight;
                if ( drawn )
                {
                    sample_range( RF_BSDF_FROSTED, 0, 1 );
                    evaluate_range( RF_BSDF_FROSTED, 0, 1 );
                    double cosine = (double)( side * s_lanes[WI + 2][0] ), pdf = (double)s_lanes[PDF][0];
                    weight = pdf > 0.0 && cosine > 0.0 ? (double)s_lanes[F][0] * cosine / pdf : 0.0;
                }
                else
                {
                    const RfBsdfLanes lanes = parameters_from( RF_BSDF_GLASS, 0 );
                    const float* const eye[3] = THREE( WO );
                    const float* const random[3] = THREE( U );
                    float* const wi[3] = THREE( WI );
                    float* const f[3] = THREE( F );
                    rf_bsdf_sample_weighted( RF_BSDF_GLASS, 1, &lanes, eye, random, wi, f, s_lanes[PDF] );
                    weight = (double)s_lanes[F][0];
                }
                double z = (double)s_lanes[WI + 2][0];
                const double value[3] = { z > 0.0 ? weight : 0.0, z < 0.0 ? weight : 0.0, weight * z };
                for ( int k = 0; k < 3; ++k )
                {
                    sum[drawn][k] += value[k];
                    squares[drawn][k] += value[k] * value[k];
                }
            }
        }
        for ( int k = 0; k < 3; ++k )
        {
            double mean[2], variance = 0.0;
            for ( int d = 0; d < 2; ++d )
            {
                mean[d] = sum[d][k] / SAMPLES;
                variance += ( squares[d][k] / SAMPLES - mean[d] * mean[d] ) / SAMPLES;
            }
            if ( !( fabs( mean[0] - mean[1] ) <= 4.5 * sqrt( variance ) + 1e-6 ) )
                fail_msg( "case %d, moment %d: glass %.5f, drawn %.5f, %.5f", c, k, mean[0], mean[1], sqrt( variance ) );
        }
    }
}

// Eyes below the shading horizon are lifted to it, on both sides alike.
TEST( test_eyes_below_the_horizon_are_lifted )
{
    Material m = random_frosted( 6, 1 );
    RfVec3 n = rf_vec3( 0, 0, 1 ), low = rf_normalize( rf_vec3( 1.0f, 0, -0.2f ) );
    RfVec3 lifted = rf_normalize( rf_madd( low, n, RF_MIN_COS - rf_dot( n, low ) ) );
    for ( int side = 0; side < 2; ++side )
    {
        RfVec3 wi = rf_normalize( rf_vec3( -0.6f, 0.1f, side == 0 ? 0.3f : -0.9f ) );
        float pdf, density;
        RfVec3 f = evaluate_drawn( m, side == 0 ? 1.0f : -1.0f, n, low, wi, &pdf ),
               g = evaluate_drawn( m, side == 0 ? 1.0f : -1.0f, n, lifted, wi, &density );
        assert_true( pdf > 0.0f && fabs( (double)f.x / (double)g.x - 1.0 ) < 1e-3 );
        assert_true( fabs( (double)pdf / (double)density - 1.0 ) < 1e-3 );
    }
}
