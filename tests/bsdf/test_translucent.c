// The model of surfaces that scatter to both sides, whose sides are drawn: against both hemispheres in double precision, from both sides,
// up to grazing angles; reciprocal through the surface.
#include "support/bsdf_lanes.h"
#include "support/test.h"

static const double s_pi = 3.14159265358979323846;

static Material random_translucent( uint32_t stream, int i )
{
    float coat = uniform( stream, i, 10 ) < 0.3f ? 0.0f : 0.2f * uniform( stream, i, 11 );
    float through = uniform( stream, i, 12 ), colour = uniform( stream, i, 13 ), base = uniform( stream, i, 14 );
    through = through < 0.1f ? 1e-6f : through > 0.9f ? 1.0f : through;
    return ( Material ){ .kind = RF_BSDF_TRANSLUCENT,
                         .diffuse = rf_scale( rf_vec3( base, 1.0f, 0.5f * base ), 1.0f - through ),
                         .through = rf_scale( rf_vec3( colour, 0.0f, 1.0f - colour ), through ),
                         .specular = grey( coat ),
                         .shape = rf_maxf( RF_MIN_ALPHA, uniform( stream, i, 15 ) ),
                         .f90 = coat > 0.0f,
                         .coat_f0 = coat,
                         .coat_f90 = coat > 0.0f };
}

// Within an angle of the horizon, on either side of it: mostly small.
static RfVec3 towards( RfVec3 n, uint32_t stream, int i, uint32_t dimension )
{
    RfVec3 t, b;
    rf_basis( n, &t, &b );
    float phi = 2.0f * RF_PI * uniform( stream, i, dimension ), pick = uniform( stream, i, dimension + 1 );
    float cosine =
        pick < 0.5f ? RF_MIN_COS * exp2f( 10.0f * uniform( stream, i, dimension + 2 ) ) : uniform( stream, i, dimension + 2 );
    cosine = rf_minf( rf_maxf( cosine, RF_MIN_COS ), 1.0f ) * ( uniform( stream, i, dimension + 3 ) < 0.5f ? -1.0f : 1.0f );
    RfVec3 across = rf_add( rf_scale( t, cosf( phi ) ), rf_scale( b, sinf( phi ) ) );
    return rf_normalize( rf_madd( rf_scale( across, sqrtf( 1.0f - cosine * cosine ) ), n, cosine ) );
}

// f with the side that wi is on drawn, and the density given that: n is the normal on the side of wo.
static RfVec3 evaluate_drawn( Material m, RfVec3 n, RfVec3 wo, RfVec3 wi, float* pdf )
{
    bool through = rf_dot( n, wi ) < 0.0f;
    m.side = through ? -1.0f : 1.0f;
    put_material( 0, &m );
    put( N, 0, rf_scale( n, m.side ) );
    put( WO, 0, wo );
    put( WI, 0, wi );
    evaluate_range( m.kind, 0, 1 );
    *pdf = s_lanes[PDF][0];
    return get( F, 0 );
}

// f of both hemispheres, channel by channel, without the lobe of the coat.
static double to_base( const Material* m, double cosine )
{
    return 1.0 - (double)m->coat_f0 - ( (double)m->coat_f90 - (double)m->coat_f0 ) * pow( 1.0 - cosine, 5.0 );
}

static double cosine_of( RfVec3 n, RfVec3 w )
{
    return fabs( (double)n.x * (double)w.x + (double)n.y * (double)w.y + (double)n.z * (double)w.z );
}

// The lesser cosine is the sum of three products, and what the coat lets pass at grazing angles is in proportion to it.
static double tolerance( RfVec3 n, RfVec3 wo, RfVec3 wi ) { return 2e-6 + 1e-6 / fmin( cosine_of( n, wo ), cosine_of( n, wi ) ); }

static void assert_close( double value, double expected, double relative, const char* what, int i )
{
    if ( !( fabs( value - expected ) <= relative * fabs( expected ) ) )
        fail_msg( "%s %d: %.9g instead of %.9g", what, i, value, expected );
}

TEST( test_drawn_sides_are_both_hemispheres )
{
    for ( int i = 0; i < 200000; ++i )
    {
        Material m = random_translucent( 1, i );
        RfVec3 n = uniform_direction( 1, i, 0 ), wo = towards( n, 1, i, 20 ), wi = towards( n, 1, i, 30 );
        n = rf_dot( n, wo ) < 0.0f ? rf_scale( n, -1.0f ) : n;
        double p = (double)rf_through_probability( m.through, m.diffuse, m.specular, m.f90 ), near = tolerance( n, wo, wi );
        float pdf;
        RfVec3 f = evaluate_drawn( m, n, wo, wi, &pdf );
        if ( rf_dot( n, wi ) < 0.0f )
        {
            double base = to_base( &m, cosine_of( n, wo ) ) * to_base( &m, cosine_of( n, wi ) ) / s_pi;
            assert_close( p * (double)f.x, (double)m.through.x * base, near, "through", i );
            assert_close( p * (double)f.y, (double)m.through.y * base, near, "through", i );
            assert_close( p * (double)f.z, (double)m.through.z * base, near, "through", i );
            assert_close( (double)pdf, cosine_of( n, wi ) / s_pi, near, "density", i );
            continue;
        }
        // this side is that of GGX
        Material opaque = m;
        float density;
        opaque.kind = RF_BSDF_GGX;
        RfVec3 g = evaluate_drawn( opaque, n, wo, wi, &density );
        if ( !( p < 1.0 ) )
            continue;
        assert_close( ( 1.0 - p ) * (double)f.x, (double)g.x, near, "this side", i );
        assert_close( ( 1.0 - p ) * (double)f.y, (double)g.y, near, "this side", i );
        assert_close( (double)pdf, (double)density, near, "density of this side", i );
    }
}

TEST( test_reciprocal_through_the_surface )
{
    for ( int i = 0; i < 100000; ++i )
    {
        Material m = random_translucent( 2, i );
        RfVec3 n = uniform_direction( 2, i, 0 ), wo = towards( n, 2, i, 20 ), wi = towards( n, 2, i, 30 );
        RfVec3 of_wo = rf_dot( n, wo ) < 0.0f ? rf_scale( n, -1.0f ) : n,
               of_wi = rf_dot( n, wi ) < 0.0f ? rf_scale( n, -1.0f ) : n;
        float pdf;
        RfVec3 there = evaluate_drawn( m, of_wo, wo, wi, &pdf ), back = evaluate_drawn( m, of_wi, wi, wo, &pdf );
        double most = (double)rf_max_component( there );
        double near = 50.0 * tolerance( n, wo, wi ) * most; // narrow lobes on the same side
        assert_true( fabs( (double)there.x - (double)back.x ) <= near );
        assert_true( fabs( (double)there.z - (double)back.z ) <= near );
    }
}

// An eye below the shading horizon, as normals that are interpolated have it, is lifted to it in both states alike.
TEST( test_eyes_below_the_horizon_are_lifted )
{
    Material m = random_translucent( 3, 0 );
    RfVec3 n = rf_vec3( 0, 0, 1 ), low = rf_normalize( rf_vec3( 1.0f, 0, -0.2f ) );
    RfVec3 lifted = rf_normalize( rf_madd( low, n, RF_MIN_COS - rf_dot( n, low ) ) );
    for ( int side = 0; side < 2; ++side )
    {
        RfVec3 wi = rf_normalize( rf_vec3( 0.3f, 0.4f, side == 0 ? 0.5f : -0.5f ) );
        float pdf, density;
        RfVec3 f = evaluate_drawn( m, n, low, wi, &pdf ), g = evaluate_drawn( m, n, lifted, wi, &density );
        assert_true( fabs( (double)f.x / (double)g.x - 1.0 ) < 1e-3 && fabs( (double)pdf / (double)density - 1.0 ) < 1e-3 );
    }
}

// All of it: nothing is drawn on the other side. None: all is.
TEST( test_probability_has_its_ends )
{
    assert_true( rf_through_probability( grey( 0.0f ), grey( 0.5f ), grey( 0.04f ), 1.0f ) == 0.0f );
    assert_true( rf_through_probability( grey( 0.0f ), grey( 0.0f ), grey( 0.0f ), 0.0f ) == 0.0f );
    assert_true( rf_through_probability( grey( 0.5f ), grey( 0.0f ), grey( 0.0f ), 0.0f ) == 1.0f );
    assert_true( rf_through_probability( grey( 0.5f ), grey( 0.5f ), grey( 0.0f ), 0.0f ) == 0.5f );
}
