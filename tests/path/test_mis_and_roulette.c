// Balance weights sum to 1, light in two parts is divided by all densities that find it, and roulette keeps the mean.
#include "support/test.h"
#include "path/mis.h"
#include "path/roulette.h"
#include "reframe/render_settings.h"

#include <math.h>

#define ROUNDING 1e-6f

static void assert_near( float a, float b ) { assert_true( fabsf( a - b ) <= ROUNDING * fabsf( b ) ); }

TEST( test_weights_sum_to_one )
{
    static const float densities[] = { 1e-12f, 0.3f, 1.0f, 7.0f, 2e15f };
    for ( int i = 0; i < 5; ++i )
    {
        for ( int k = 0; k < 5; ++k )
        {
            float p = densities[i], q = densities[k];
            assert_near( rf_balance_weight( p, q ) + rf_balance_weight( q, p ), 1.0f );
            assert_near( rf_mixture_share( p, p + q ) + rf_mixture_share( q, p + q ), 1.0f );
            assert_near( rf_balance_scale( p, q ) * p, rf_balance_weight( p, q ) );
        }
    }
}

// An own density of 0 has the weight 0, and the weight is 1 where nothing else finds the light.
TEST( test_weights_of_one_technique )
{
    assert_true( rf_balance_weight( 0.0f, 2.0f ) == 0.0f );
    assert_true( rf_balance_weight( 2.0f, 0.0f ) == 1.0f );
}

TEST( test_light_in_two_parts )
{
    static RfArrivalLanes s_arrival;
    float q[3];
    s_arrival.a[0][7] = 6.0f;
    s_arrival.b[0][7] = 4.0f;
    s_arrival.light_pdf[7] = 1.0f;
    rf_weigh_arrival( &s_arrival, 7, 2.0f, q );
    assert_near( q[0], 6.0f / ( 1.0f + 2.0f ) + 4.0f / 2.0f );
    assert_true( q[1] == 0.0f && q[2] == 0.0f );
    rf_weigh_arrival( &s_arrival, 7, 0.0f, q ); // scattering cannot go there
    assert_near( q[0], 6.0f );
    s_arrival.light_pdf[7] = 0.0f; // nor light sampling
    rf_weigh_arrival( &s_arrival, 7, 0.0f, q );
    assert_true( q[0] == 0.0f );
}

TEST( test_roulette_keeps_the_mean )
{
    for ( float carried = 1e-6f; carried < 10.0f; carried *= 3.0f )
    {
        float survival = rf_survival( carried, RF_ROULETTE_VERTEX );
        assert_true( survival > 0.0f && survival <= 1.0f && ( survival == 1.0f || carried < 0.25f ) );
        assert_near( carried / survival * survival, carried );
        assert_true( rf_shared_factor( carried ) >= carried && rf_shared_factor( carried ) >= 0.1f );
    }
    assert_true( rf_survival( 0.0f, RF_ROULETTE_VERTEX ) == 0.0f );
    double reached = 1.0, vertices = 0.0; // where throughput never falls
    for ( int vertex = 1; vertex < RF_MAX_DEPTH; ++vertex )
    {
        vertices += reached;
        reached *= (double)rf_survival( 1.0f, vertex );
    }
    assert_true( reached < 1e-5 && vertices < 130.0 );
    for ( float luminance = 0.0f; luminance < 2.0f; luminance += 0.01f )
    {
        float survival = rf_reuse_survival( luminance, 1.0f );
        assert_true( survival >= 0.1f && survival <= 1.0f && ( survival == 1.0f || luminance < 0.1f ) );
    }
    assert_true( rf_reuse_survival( 0.0f, 0.0f ) == 1.0f ); // a dark tile
}
