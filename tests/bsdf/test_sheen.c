// The directional albedo of sheen, which its base is scaled by, against quadrature of the lobe in double precision; and the lobe
// against the formulas of KHR_materials_sheen.
#include "bsdf/sheen.h"
#include "support/bsdf_lanes.h"
#include "support/test.h"

static const double s_pi = 3.14159265358979323846;

// White sheen alone, seen at this cosine, by its own model.
static void put_eye( float alpha, float cos_o )
{
    Material m = { .kind = RF_BSDF_SHEEN, .shape = 1.0f, .sheen = grey( 1.0f ), .sheen_alpha = alpha };
    RfVec3 n = rf_vec3( 0.0f, 0.0f, 1.0f );
    put_surface( &m, n, rf_vec3( sqrtf( 1.0f - cos_o * cos_o ), 0.0f, cos_o ) );
}

// Midpoints of μ = t⁴ and φ = π (1 − s³): close to the horizon and opposite to the eye, where the lobe is narrow.
static double albedo_by_quadrature( float alpha, float cos_o )
{
    enum
    {
        ROWS = 250,
        COLUMNS = 200
    };
    double sum = 0.0;
    put_eye( alpha, cos_o );
    for ( int row = 0; row < ROWS; ++row )
    {
        double t = ( row + 0.5 ) / ROWS, mu = t * t * t * t, sine = sqrt( 1.0 - mu * mu );
        double slope[COLUMNS];
        for ( int i = 0; i < COLUMNS; ++i )
        {
            double s = ( i + 0.5 ) / COLUMNS, phi = s_pi * ( 1.0 - s * s * s );
            slope[i] = 4.0 * t * t * t / ROWS * 2.0 * s_pi * 3.0 * s * s / COLUMNS;
            put( WI, i, rf_vec3( (float)( sine * cos( phi ) ), (float)( sine * sin( phi ) ), (float)mu ) );
        }
        evaluate_range( RF_BSDF_SHEEN, 0, COLUMNS );
        for ( int i = 0; i < COLUMNS; ++i )
            sum += (double)s_lanes[F][i] * mu * slope[i];
    }
    return sum;
}

TEST( test_albedo )
{
    double worst = 0.0;
    for ( int i = 0; i < 24; ++i )
    {
        float alpha = powf( RF_MIN_SHEEN_ALPHA, (float)i / 23.0f );
        for ( int k = 0; k < 24; ++k )
        {
            float t = (float)( k + 1 ) / 24.0f, cos_o = rf_maxf( t * t * t, RF_MIN_COS );
            double got = (double)rf_sheen_albedo( cos_o, alpha ), want = albedo_by_quadrature( alpha, cos_o );
            worst = fmax( worst, fabs( got - want ) );
            if ( !( fabs( got - want ) < 0.005 ) )
                fail_msg( "albedo %.4f instead of %.4f: alpha %g cos %g", got, want, (double)alpha, (double)cos_o );
        }
    }
    print_message( "albedo: %.4f off at most\n", worst );
}

// As the extension has it, from the angles.
static double exponent( double x, double alpha )
{
    double t = ( 1.0 - alpha ) * ( 1.0 - alpha ), a = 21.5473 * ( 1.0 - t ) + 25.3245 * t,
           b = 3.82987 * ( 1.0 - t ) + 3.32435 * t, c = 0.19823 * ( 1.0 - t ) + 0.16801 * t,
           d = -1.97760 * ( 1.0 - t ) - 1.27393 * t, e = -4.32054 * ( 1.0 - t ) - 4.85967 * t;
    return a / ( 1.0 + b * pow( x, c ) ) + d * x + e;
}

static double lambda( double mu, double alpha )
{
    return mu < 0.5 ? exp( exponent( mu, alpha ) ) : exp( 2.0 * exponent( 0.5, alpha ) - exponent( 1.0 - mu, alpha ) );
}

TEST( test_formula )
{
    int limited = 0;
    for ( int i = 0; i < 4000; ++i )
    {
        float alpha = rf_maxf( uniform( 1, i, 0 ) * uniform( 1, i, 1 ), RF_MIN_SHEEN_ALPHA );
        float cos_o = 0.01f + 0.98f * uniform( 1, i, 2 );
        RfVec3 wi = uniform_direction( 1, i, 3 );
        wi.z = fabsf( wi.z );
        put_eye( alpha, cos_o );
        put( WI, 0, wi );
        evaluate_range( RF_BSDF_SHEEN, 0, 1 );
        RfVec3 wo = get( WO, 0 );
        double x = (double)wo.x + wi.x, y = (double)wo.y + wi.y, z = (double)wo.z + wi.z,
               sine2 = ( x * x + y * y ) / ( x * x + y * y + z * z );
        double d = ( 2.0 + 1.0 / alpha ) * pow( sine2, 0.5 / alpha ) / ( 2.0 * s_pi );
        double want = d / ( 4.0 * wo.z * wi.z * ( 1.0 + lambda( wo.z, alpha ) + lambda( wi.z, alpha ) ) );
        double got = (double)s_lanes[F][0];
        bool below = alpha < 0.28f * 0.28f && ( wo.z < 0.1f || wi.z < 0.1f );
        limited += below && got < 0.99 * want;
        if ( !( fabs( got - want ) <= 2e-4 * want + 1e-6 || ( below && got < want ) ) )
            fail_msg( "f %g instead of %g: alpha %g, cosines %g and %g", got, want, (double)alpha, (double)wo.z, (double)wi.z );
    }
    assert_true( limited > 20 );
}
