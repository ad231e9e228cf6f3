// Curves of camera paths: they meet every key, have the shape of closed forms, and their
// speed does not jump; walks by arc length.
#include "support/scene_files.h"
#include "support/test.h"

#include "math/quat.h"
#include "scene/camera_path/curve.h"

#define PI 3.14159265358979323846

// Uneven in time and space, with a turn back and a stop.
static const double s_times[] = { 0.0, 0.1, 1.5, 1.7, 4.0, 5.0, 5.5 };
static const double s_points[] = { 0, 0, 0, 2, 1, 0, 2.1, 1.2, 0.1, 9, -3, 2, 8, -3, 1, 8, -3, 1, 0, 0, 5 };
#define COUNT 7

static RfCurve make( RfCurveKind kind, bool linear, int count, const double* times, const double* values )
{
    RfCurve curve;
    RfError error = { 0 };
    if ( rf_create_curve( kind, linear, count, times, values, &curve, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return curve;
}

static double distance( const double* a, const double* b )
{
    return sqrt( ( a[0] - b[0] ) * ( a[0] - b[0] ) + ( a[1] - b[1] ) * ( a[1] - b[1] ) + ( a[2] - b[2] ) * ( a[2] - b[2] ) );
}

TEST( test_curves_meet_their_keys )
{
    for ( int linear = 0; linear < 2; ++linear )
    {
        AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_POINT, linear == 1, COUNT, s_times, s_points );
        double got[3];
        for ( int i = 0; i < COUNT; ++i )
        {
            const double* p = s_points + 3 * i;
            rf_sample_curve( &curve, s_times[i], got );
            assert_three( got, p[0], p[1], p[2], 1e-12 );
            rf_sample_curve( &curve, s_times[i] + 1e-9, got );
            assert_three( got, p[0], p[1], p[2], 1e-6 );
        }
        rf_sample_curve( &curve, -5.0, got );
        assert_three( got, 0, 0, 0, 0 );
        rf_sample_curve( &curve, 99.0, got );
        assert_three( got, 0, 0, 5, 0 );
        rf_sample_curve( &curve, 4.5, got ); // between two equal keys
        assert_three( got, 8, -3, 1, 0 );
    }
}

// Equal steps in time and space: the plain Catmull-Rom spline.
TEST( test_even_keys_give_catmull_rom )
{
    static const double times[] = { 0, 1, 2, 3 }, points[] = { 0, 0, 0, 1, 1, 0, 2, 0, 0, 3, 1, 0 };
    AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_POINT, false, 4, times, points );
    double got[3];
    rf_sample_curve( &curve, 1.5, got ); // ( −p0 + 9 p1 + 9 p2 − p3 ) / 16
    assert_three( got, 1.5, 0.5, 0, 1e-12 );
    rf_sample_curve( &curve, 1.25, got );
    double t = 0.25, y = 0.5 * ( 2.0 * 1 + t * ( -0.0 + 0.0 ) + t * t * ( 0 - 5 + 0 - 1 ) + t * t * t * ( 3 - 0 + 1 - 0 ) );
    assert_three( got, 1.25, y, 0, 1e-12 );
}

// Hermite form of the same segment with the tangents of non-uniform Catmull-Rom.
TEST( test_centripetal_shape )
{
    AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_POINT, false, COUNT, s_times, s_points );
    const double *p0 = s_points, *p1 = p0 + 3, *p2 = p0 + 6, *p3 = p0 + 9;
    double k[4] = { 0, sqrt( distance( p0, p1 ) ) };
    k[2] = k[1] + sqrt( distance( p1, p2 ) );
    k[3] = k[2] + sqrt( distance( p2, p3 ) );
    double h = k[2] - k[1];
    for ( double t = 0.0; t <= 1.0; t += 0.125 )
    {
        double point[3], derivative[3], b[3];
        rf_curve_at_knot( &curve, 1, k[1] + t * h, point, derivative );
        for ( int i = 0; i < 3; ++i )
        {
            double m1 = ( p1[i] - p0[i] ) / ( k[1] - k[0] ) - ( p2[i] - p0[i] ) / ( k[2] - k[0] ) + ( p2[i] - p1[i] ) / h;
            double m2 = ( p2[i] - p1[i] ) / h - ( p3[i] - p1[i] ) / ( k[3] - k[1] ) + ( p3[i] - p2[i] ) / ( k[3] - k[2] );
            b[i] = ( 2 * t * t * t - 3 * t * t + 1 ) * p1[i] + ( t * t * t - 2 * t * t + t ) * h * m1 +
                   ( 3 * t * t - 2 * t * t * t ) * p2[i] + ( t * t * t - t * t ) * h * m2;
        }
        assert_three( point, b[0], b[1], b[2], 1e-12 );
        if ( t > 0.0 && t < 1.0 )
        {
            double ahead[3], unused[3];
            rf_curve_at_knot( &curve, 1, k[1] + t * h + 1e-6, ahead, unused );
            for ( int i = 0; i < 3; ++i )
                assert_close( derivative[i], ( ahead[i] - point[i] ) / 1e-6, 1e-3 );
        }
    }
}

static void velocity( const RfCurve* curve, double time, double step, double v[3] )
{
    double a[3], b[3];
    rf_sample_curve( curve, time, a );
    rf_sample_curve( curve, time + step, b );
    for ( int i = 0; i < 3; ++i )
        v[i] = ( b[i] - a[i] ) / step;
}

TEST( test_no_jump_of_speed )
{
    AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_POINT, false, COUNT, s_times, s_points );
    for ( int i = 1; i + 1 < COUNT; ++i )
    {
        double before[3], after[3], scale;
        velocity( &curve, s_times[i], -1e-7, before );
        velocity( &curve, s_times[i], 1e-7, after );
        static const double zero[3];
        scale = 1e-4 * ( 1.0 + distance( before, zero ) );
        assert_three( after, before[0], before[1], before[2], scale );
    }
    // a straight curve has jumps there: the test can see them
    AUTO_BY( rf_destroy_curve ) RfCurve straight = make( RF_CURVE_POINT, true, COUNT, s_times, s_points );
    double before[3], after[3];
    velocity( &straight, s_times[1], -1e-7, before );
    velocity( &straight, s_times[1], 1e-7, after );
    assert_true( distance( before, after ) > 1.0 );
}

TEST( test_numbers_stay_between_keys )
{
    static const double times[] = { 0, 1, 1.1, 5 }, fov[] = { 40, 40, 20, 30 };
    AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_NUMBER, false, 4, times, fov );
    for ( int i = 0; i < 4; ++i )
    {
        double got;
        rf_sample_curve( &curve, times[i], &got );
        assert_close( got, fov[i], 1e-12 );
    }
    double last = 40.0;
    for ( double t = 0.0; t <= 5.0; t += 0.01 )
    {
        double got;
        rf_sample_curve( &curve, t, &got );
        assert_true( got >= 20.0 && got <= 40.0 );
        assert_true( t < 1.1 ? got <= last + 1e-12 : t < 1.12 || got >= last - 1e-12 );
        last = got;
    }
}

// Rotations about y by these degrees.
static void yaws( const double* degrees, int count, double* q )
{
    for ( int i = 0; i < count; ++i )
    {
        q[4 * i] = q[4 * i + 2] = 0.0;
        q[4 * i + 1] = sin( 0.5 * degrees[i] * PI / 180.0 );
        q[4 * i + 3] = cos( 0.5 * degrees[i] * PI / 180.0 );
    }
}

static double yaw_at( const RfCurve* curve, double time )
{
    double q[4];
    rf_sample_curve( curve, time, q );
    assert_close( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0, 1e-12 );
    return 2.0 * atan2( q[1], q[3] ) * 180.0 / PI;
}

static double wrapped( double degrees ) { return degrees - 360.0 * floor( degrees / 360.0 + 0.5 ); }

TEST( test_even_turns_are_even )
{
    static const double times[] = { 0, 1, 2, 3 }, degrees[] = { 0, 90, 180, 270 };
    double q[16];
    yaws( degrees, 4, q );
    for ( int i = 0; i < 4; ++i )
        q[8 + i] = -q[8 + i]; // of either sign, the same rotation
    for ( int linear = 0; linear < 2; ++linear )
    {
        AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_ROTATION, linear == 1, 4, times, q );
        for ( double t = 0.0; t <= 3.0; t += 0.125 )
            assert_close( wrapped( yaw_at( &curve, t ) - 90.0 * t ), 0.0, 1e-9 );
    }
}

// Wide turns there and back, uneven in time: slerps of slerps would jump.
TEST( test_turning_back_does_not_jump )
{
    static const double times[] = { 0, 1, 1.3, 4, 5 }, degrees[] = { 0, 170, 0, -160, 15 };
    double q[20], last = 0.0, rate = 0.0;
    yaws( degrees, 5, q );
    AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_ROTATION, false, 5, times, q );
    for ( int i = 0; i < 5; ++i )
        assert_close( wrapped( yaw_at( &curve, times[i] ) - degrees[i] ), 0.0, 1e-9 );
    for ( double t = 0.0; t <= 5.0; t += 0.001 )
    {
        double yaw = yaw_at( &curve, t ), step = wrapped( yaw - last );
        assert_true( fabs( step ) < 2.0 );                      // no jump
        assert_true( t < 0.002 || fabs( step - rate ) < 0.05 ); // nor one of the rate
        rate = step;
        last = yaw;
    }
}

// Steps of equal length of arc along a walk, and its whole length.
static void expect_constant_speed( const RfWaypoints* walk )
{
    enum
    {
        STEPS = 4000
    };
    double last[3], at[3], shortest = INFINITY, longest = 0.0, sum = 0.0;
    rf_waypoint_position( walk, 0.0, last );
    for ( int i = 1; i <= STEPS; ++i )
    {
        rf_waypoint_position( walk, walk->length * i / STEPS, at );
        double step = distance( last, at );
        sum += step;
        shortest = fmin( shortest, step );
        longest = fmax( longest, step );
        memcpy( last, at, sizeof at );
    }
    assert_close( sum / walk->length, 1.0, 1e-4 );
    assert_true( longest / ( walk->length / STEPS ) < 1.0 + 1e-6 ); // chords are shorter than arcs
    assert_true( shortest / ( walk->length / STEPS ) > 1.0 - 1e-3 );
}

TEST( test_walks_keep_their_speed )
{
    // neighbours from 0.3 to 10 apart, none with a hairpin, whose chords tell nothing
    static const double points[] = { 0, 0, 0, 3, 0, 0.5, 3.3, 0, 0.6, 10, 1, 6, 10, 1, 16, 4, 1, 20 };
    RfWaypoints walk;
    RfError error;
    assert_int_equal( rf_create_waypoints( false, 6, points, &walk, &error ), RF_OK );
    expect_constant_speed( &walk );
    double at[3], nearest[6] = { 9, 9, 9, 9, 9, 9 };
    for ( int i = 0; i <= 5000; ++i )
    {
        rf_waypoint_position( &walk, walk.length * i / 5000.0, at );
        for ( int k = 0; k < 6; ++k )
            nearest[k] = fmin( nearest[k], distance( at, points + 3 * k ) );
    }
    for ( int k = 0; k < 6; ++k )
        assert_true( nearest[k] <= 0.51 * walk.length / 5000.0 );
    rf_destroy_waypoints( &walk );
}

TEST( test_straight_walks_stay_straight )
{
    static const double points[] = { 0, 0, 0, 3, 0, 0, 3, 4, 0 };
    RfWaypoints walk;
    RfError error;
    double at[3];
    assert_int_equal( rf_create_waypoints( true, 3, points, &walk, &error ), RF_OK );
    assert_close( walk.length, 7.0, 1e-12 );
    rf_waypoint_position( &walk, 1.5, at );
    assert_three( at, 1.5, 0, 0, 1e-9 );
    rf_waypoint_position( &walk, 5.0, at );
    assert_three( at, 3, 2, 0, 1e-9 );
    rf_waypoint_position( &walk, 9.0, at ); // straight on
    assert_three( at, 3, 6, 0, 1e-9 );
    rf_waypoint_position( &walk, -1.0, at );
    assert_three( at, -1, 0, 0, 1e-9 );
    rf_destroy_waypoints( &walk );
}

// Points far beyond any scene, or all but equal, give numbers.
TEST( test_extreme_points_give_numbers )
{
    static const double sets[][12] = {
        { 1e15, 0, 0, 1e15, 1e-3, 0, -1e15, 0, 0, 1e15, 0, 1 },
        { 0, 0, 0, 1e-300, 0, 0, 2e-300, 0, 0, 1, 0, 0 },
        { 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1 },
    };
    static const double times[] = { 0, 1e-6, 1e6 - 1, 1e6 };
    for ( size_t i = 0; i < sizeof sets / sizeof sets[0]; ++i )
    {
        AUTO_BY( rf_destroy_curve ) RfCurve curve = make( RF_CURVE_POINT, false, 4, times, sets[i] );
        RfWaypoints walk;
        RfError error;
        assert_int_equal( rf_create_waypoints( false, 4, sets[i], &walk, &error ), RF_OK );
        for ( int k = 0; k <= 64; ++k )
        {
            double a[3], b[3];
            rf_sample_curve( &curve, 1e6 * k / 64.0, a );
            rf_waypoint_position( &walk, walk.length * ( k - 8 ) / 48.0, b );
            for ( int c = 0; c < 3; ++c )
                assert_true( isfinite( a[c] ) && isfinite( b[c] ) );
        }
        rf_destroy_waypoints( &walk );
    }
}
