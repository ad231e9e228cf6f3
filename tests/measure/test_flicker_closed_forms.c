// Flicker against closed forms.
#include "support/frame_files.h"
#include "support/test.h"

// e_t = ρ e_{t−1} + sqrt(1 − ρ²) n_t has variance 1 and correlation ρ: φ = 1 − ρ
// and F1 = sqrt(2 (1 − ρ)). The correlation of 9216 values has a standard
// deviation of (1 − ρ²) / 96, and the frames' are independent.
TEST( test_correlated_noise )
{
    static const double correlations[] = { 0.0, 0.5, 0.9, -0.5 };
    enum
    {
        FRAMES = 17
    };
    for ( size_t k = 0; k < sizeof correlations / sizeof correlations[0]; ++k )
    {
        double rho = correlations[k];
        RfFlickerFrame frames[2] = { make_frame( 1 ), make_frame( 2 ) };
        RfFlickerSums all = { 0 };
        fill_noise( frames, 77 + (uint32_t)k, 1.0f );
        for ( int t = 1; t < FRAMES; ++t )
        {
            RfFlickerFrame *now = frames + t % 2, *before = frames + ( t - 1 ) % 2;
            fill_noise( now, 1000 * (uint32_t)( k + 1 ) + (uint32_t)t, 1.0f );
            for ( int i = 0; i < VALUES; ++i )
                now->signal.rgb[i] =
                    (float)( rho * (double)before->signal.rgb[i] + sqrt( 1.0 - rho * rho ) * (double)now->signal.rgb[i] );
            RfFlickerSums sums = measure( now, before, false, true );
            rf_add_flicker( &all, &sums );
        }
        RfFlickerMetrics m = rf_flicker_metrics( &all );
        double deviation = ( 1.0 - rho * rho ) / sqrt( (double)VALUES * ( FRAMES - 1 ) );
        check_near( m.phi, 1.0 - rho, 4.0 * deviation );
        check_near( m.f1 * m.f1 / ( 2.0 * ( 1.0 - rho ) ), 1.0, 0.03 );
        check_near( m.mse, 1.0, 0.03 );
        assert_true( m.coverage == 1.0 );
        assert_int_equal( all.pairs, FRAMES - 1 );
        rf_destroy_flicker_frame( frames );
        rf_destroy_flicker_frame( frames + 1 );
    }
}

// Equal errors 0, opposite ones 2, no error at all 0.
TEST( test_frozen_and_alternating )
{
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame a = make_frame( 1 ), b = make_frame( 2 );
    RfFlickerMetrics m = measured( &b, &a, false, true );
    assert_true( m.f1 == 0.0 && m.phi == 0.0 && m.mse == 0.0 );
    fill_noise( &a, 5, 1.0f );
    memcpy( b.signal.rgb, a.signal.rgb, image_bytes( &a.signal ) );
    m = measured( &b, &a, false, true );
    assert_true( m.f1 == 0.0 && m.phi == 0.0 && m.mse > 0.5 );
    for ( int i = 0; i < VALUES; ++i )
        b.signal.rgb[i] = -a.signal.rgb[i];
    m = measured( &b, &a, false, true );
    assert_true( m.phi == 2.0 );
    check_near( m.f1, 2.0 * sqrt( m.mse ), 1e-14 );
    m = measured( &b, &a, false, false ); // pictures: the size of the error is not known
    assert_true( isnan( m.phi ) && isnan( m.mse ) );
    check_near( m.f1 * m.f1, 4.0 * measured( &a, &a, false, true ).mse, 1e-12 );
}

// Relative to the brightness: the mean of both frames, found along the motion.
TEST( test_relative_flicker )
{
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame a = make_frame( 1 ), b = make_frame( 2 );
    fill_noise( &a, 11, 1.0f );
    fill_noise( &b, 12, 1.0f );
    RfFlickerMetrics plain = measured( &b, &a, false, true );
    check_near( plain.f1_relative, plain.f1, 1e-12 );
    a.below = malloc( PIXELS * sizeof( double ) );
    b.below = malloc( PIXELS * sizeof( double ) );
    for ( int i = 0; i < PIXELS; ++i ) // their mean is 9 where the frame before is looked up a pixel to the left
    {
        a.below[i] = 4.0 + i % WIDTH;
        b.below[i] = 15.0 - i % WIDTH;
    }
    set_motion( &b, -1.0f, 0.0f );
    plain = measured( &b, &a, true, true );
    check_near( plain.f1_relative, plain.f1 / 3.0, 1e-12 );
    b.is_finite = false;
    assert_true( isnan( measured( &b, &a, true, true ).f1_relative ) );
    // of a picture: 5 everywhere
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame five = make_frame( 3 );
    for ( int i = 0; i < VALUES; ++i )
        five.signal.rgb[i] = 5.0f;
    assert_int_equal( rf_take_brightness( &five, &five.signal, NULL ), RF_OK );
    check_near( five.below[PIXELS - 1], 25.001, 1e-12 );
}

// The definition summed naively; scaling; the order of the two frames.
TEST( test_definition_scaling_and_symmetry )
{
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame a = make_frame( 1 ), b = make_frame( 2 ), c = make_frame( 3 );
    fill_noise( &a, 11, 1.0f );
    fill_noise( &b, 12, 0.25f );
    fill_noise( &c, 13, 3.0f );
    double difference = 0.0, square = 0.0;
    for ( int i = VALUES - 1; i >= 0; --i )
    {
        double x = (double)a.signal.rgb[i], y = (double)b.signal.rgb[i];
        difference += ( y - x ) * ( y - x ) / VALUES;
        square += ( x * x + y * y ) / VALUES;
    }
    RfFlickerMetrics ab = measured( &b, &a, false, true ), ba = measured( &a, &b, false, true );
    check_near( ab.f1, sqrt( difference ), 1e-12 );
    check_near( ab.phi, difference / square, 1e-12 );
    check_near( ab.mse, square / 2.0, 1e-12 );
    assert_true( ab.f1 == ba.f1 && ab.phi == ba.phi );
    // a b c against a c b: the pairs go with their frames, the sums are theirs
    RfFlickerSums first = measure( &b, &a, false, true ), second = measure( &c, &b, false, true );
    RfFlickerSums other = measure( &b, &c, false, true ), across = measure( &c, &a, false, true );
    assert_true( second.difference == other.difference && across.difference != first.difference );
    rf_add_flicker( &first, &second );
    RfFlickerMetrics all = rf_flicker_metrics( &first );
    check_near( all.f1 * all.f1, ( ab.f1 * ab.f1 + second.difference / VALUES ) / 2.0, 1e-12 );
    for ( int i = 0; i < VALUES; ++i )
    {
        a.signal.rgb[i] *= 4.0f;
        b.signal.rgb[i] *= 4.0f;
    }
    RfFlickerMetrics scaled = measured( &b, &a, false, true );
    assert_true( scaled.f1 == 4.0 * ab.f1 && scaled.phi == ab.phi && scaled.mse == 16.0 * ab.mse );
    a.is_finite = false;
    scaled = measured( &b, &a, false, true );
    assert_true( isnan( scaled.f1 ) && isnan( scaled.phi ) );
}

// A texture that moved by whole pixels: nothing is left along the motion, and what
// came in from outside does not count.
TEST( test_whole_shifts_leave_nothing )
{
    enum
    {
        RIGHT = 5,
        DOWN = 3
    };
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame before = make_frame( 1 ), now = make_frame( 2 );
    fill_noise( &before, 3, 1.0f );
    fill_noise( &now, 4, 1.0f );
    for ( int y = DOWN; y < HEIGHT; ++y )
    {
        for ( int x = RIGHT; x < WIDTH; ++x )
            memcpy( now.signal.rgb + 3 * ( y * WIDTH + x ), before.signal.rgb + 3 * ( ( y - DOWN ) * WIDTH + x - RIGHT ), 12 );
    }
    set_motion( &now, -RIGHT, DOWN ); // where it was: to the left and above, +y up
    RfFlickerMetrics m = measured( &now, &before, true, false );
    assert_true( m.f1 == 0.0 );
    check_near( m.coverage, (double)( ( WIDTH - RIGHT ) * ( HEIGHT - DOWN ) ) / PIXELS, 1e-15 );
    check_near( m.motion, hypot( RIGHT, DOWN ), 1e-12 );
    assert_true( measured( &now, &before, false, false ).f1 > 1.0 && isnan( measured( &now, &before, false, false ).motion ) );
    set_motion( &now, -RIGHT, -DOWN );
    assert_true( measured( &now, &before, true, false ).f1 > 1.0 );
    set_motion( &now, NAN, 0.0f );
    m = measured( &now, &before, true, false );
    assert_true( m.coverage == 0.0 && isnan( m.f1 ) && isnan( m.phi ) );
}

// x² + y² moved by (u, v) of a pixel: linear interpolation is too large by
// u (1 − u) + v (1 − v), everywhere.
TEST( test_shifts_of_parts_of_a_pixel )
{
    static const float shifts[][2] = { { 0.5f, 0.0f }, { 0.25f, 0.0f }, { 0.0f, 0.75f }, { 0.25f, 0.5f } };
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame before = make_frame( 1 ), now = make_frame( 2 );
    for ( size_t k = 0; k < sizeof shifts / sizeof shifts[0]; ++k )
    {
        float u = shifts[k][0], v = shifts[k][1];
        for ( int i = 0; i < VALUES; ++i )
        {
            float x = (float)( i / 3 % WIDTH ), y = (float)( i / 3 / WIDTH );
            before.signal.rgb[i] = x * x + y * y;
            now.signal.rgb[i] = ( x + u ) * ( x + u ) + ( y + v ) * ( y + v ); // exact
        }
        set_motion( &now, u, -v );
        RfFlickerMetrics m = measured( &now, &before, true, false );
        check_near( m.f1, (double)( u * ( 1.0f - u ) + v * ( 1.0f - v ) ), 1e-12 );
        int wide = u > 0.0f ? WIDTH - 1 : WIDTH, high = v > 0.0f ? HEIGHT - 1 : HEIGHT;
        check_near( m.coverage, (double)( wide * high ) / PIXELS, 1e-15 );
        check_near( m.motion, hypot( u, v ), 1e-6 );
    }
}

// Between pixels independent noise is smaller, and φ stays 1: with the error
// itself, and with the variance of a picture. Mean of two: σ² (1 + 1/2).
TEST( test_noise_between_pixels )
{
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame before = make_frame( 1 ), now = make_frame( 2 );
    fill_noise( &before, 21, 0.5f );
    fill_noise( &now, 22, 0.5f );
    set_motion( &now, 0.5f, 0.0f );
    RfFlickerMetrics m = measured( &now, &before, true, true );
    double deviation = 1.0 / sqrt( (double)VALUES );
    check_near( m.phi, 1.0, 4.0 * deviation );
    check_near( m.f1 * m.f1, 0.25 * 1.5, 8.0 * 0.25 * deviation );
    RfFlickerFrame* frames[2] = { &before, &now };
    for ( int k = 0; k < 2; ++k )
    {
        frames[k]->variance = ( RfImage ){ WIDTH, HEIGHT, make_layer( 3, 0.25f ) };
        for ( int i = 0; i < VALUES; ++i )
            frames[k]->signal.rgb[i] += 7.0f;
    }
    m = measured( &now, &before, true, false );
    check_near( m.mse, 0.25 * 0.75, 1e-7 );
    check_near( m.phi, 1.0, 6.0 * deviation );
    before.variance.rgb[77] = INFINITY; // no number, no φ
    assert_true( isnan( measured( &now, &before, true, false ).phi ) );
}

// A square in front of a wall, 1 m before 4 m, moves 6 pixels to the right over it.
// Six of its columns uncover the wall; depth takes just those out.
TEST( test_depth_takes_out_what_is_uncovered )
{
    enum
    {
        SIDE = 20,
        LEFT = 10,
        TOP = 12,
        SHIFT = 6
    };
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame before = make_frame( 1 ), now = make_frame( 2 );
    RfFlickerFrame* frames[2] = { &before, &now };
    set_motion( &now, 0.0f, 0.0f );
    for ( int k = 0; k < 2; ++k )
    {
        frames[k]->depth = make_layer( 1, 4.0f );
        fill_noise( frames[k], 31, 1.0f ); // the wall, the same in both
        for ( int y = TOP; y < TOP + SIDE; ++y )
        {
            for ( int x = LEFT; x < LEFT + SIDE; ++x )
            {
                int i = y * WIDTH + x + k * SHIFT;
                for ( int c = 0; c < 3; ++c )
                    frames[k]->signal.rgb[3 * i + c] = (float)( x * y + c );
                frames[k]->depth[i] = 1.0f;
                if ( k == 1 )
                    now.motion[2 * i] = -SHIFT;
            }
        }
    }
    RfFlickerMetrics m = measured( &now, &before, true, false );
    assert_true( m.f1 == 0.0 );
    check_near( m.coverage, 1.0 - (double)( SIDE * SHIFT ) / PIXELS, 1e-15 );
    float* depth = before.depth;
    before.depth = NULL;
    m = measured( &now, &before, true, false );
    assert_true( m.f1 > 1.0 && m.coverage == 1.0 );
    before.depth = depth;
    // nothing there in both is alike, nothing beside something and NaN are not
    set_motion( &now, 0.0f, 0.0f );
    for ( int i = 0; i < PIXELS; ++i )
    {
        before.depth[i] = i % 4 == 1 ? 1e10f : i % 4 == 2 ? NAN : 4.0f;
        now.depth[i] = i % 4 == 1 ? INFINITY : i % 4 == 3 ? 1e10f : 4.0f * 1.015f;
    }
    check_near( measured( &now, &before, true, false ).coverage, 0.5, 1e-15 );
    for ( int i = 0; i < PIXELS; ++i )
        now.depth[i] = 4.0f * 1.03f; // beyond 2 %
    assert_true( measured( &now, &before, true, false ).coverage == 0.0 );
}

// A camera with any axes and position: rows of x·z, y·z, z.
static void set_camera( RfFlickerFrame* frame, uint32_t seed, double forward )
{
    double turn = 0.3 + 0.01 * (double)( seed % 7 ), c = cos( turn ), s = sin( turn );
    const double axes[3][3] = { { c, 0.0, -s }, { 0.1 * s, -1.0, 0.1 * c }, { s, 0.0, c } }; // right, down, ahead
    const double eye[3] = { 0.4 + forward * s, 1.0, -2.0 + forward * c };
    frame->has_camera = true;
    for ( int i = 0; i < 3; ++i )
    {
        const double scale = i < 2 ? 50.0 : 1.0, shift = i == 0 ? 31.5 : i == 1 ? 23.5 : 0.0;
        frame->camera[i][3] = 0.0;
        for ( int j = 0; j < 3; ++j )
        {
            frame->camera[i][j] = scale * axes[i][j] + shift * axes[2][j];
            frame->camera[i][3] -= frame->camera[i][j] * eye[j];
        }
    }
}

// The expected depth against the points themselves, and a dolly of 10 % a frame.
TEST( test_expected_depth_of_a_dolly )
{
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame before = make_frame( 1 ), now = make_frame( 2 );
    set_camera( &before, 1, 0.0 );
    set_camera( &now, 4, 0.5 );
    RfFollow follow = rf_follow( &now, &before, true );
    uint32_t seed = 8;
    for ( int k = 0; k < 50; ++k )
    {
        double p[4] = { 0, 0, 0, 1 }, at[3] = { 0 }, depth = 0.0;
        for ( int j = 0; j < 3; ++j )
            p[j] = 10.0 * next_random( &seed ) * 0x1p-32 - 5.0;
        for ( int j = 0; j < 4; ++j )
        {
            for ( int i = 0; i < 3; ++i )
                at[i] += now.camera[i][j] * p[j];
            depth += before.camera[2][j] * p[j];
        }
        const double* e = follow.expect;
        check_near( e[0] * at[0] + e[1] * at[1] + e[2] * at[2] + e[3], depth, 1e-9 );
    }
    set_camera( &now, 1, 0.5 ); // straight ahead by half a metre
    set_motion( &now, 0.0f, 0.0f );
    now.depth = make_layer( 1, 4.5f );
    before.depth = make_layer( 1, 5.0f );
    assert_true( measured( &now, &before, true, false ).coverage == 1.0 );
    before.has_camera = false;
    assert_true( measured( &now, &before, true, false ).coverage == 0.0 );
}

TEST( test_wrong_input_is_refused )
{
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame a = make_frame( 1 ), b = make_frame( 2 );
    RfFlickerSums sums;
    RfError error;
    assert_int_equal( rf_measure_flicker( &b, &a, true, false, &sums, &error ), RF_ERROR_USAGE );
    b.signal.height -= 1;
    assert_int_equal( rf_measure_flicker( &b, &a, false, false, &sums, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "64x47" ) );
    b.signal.height += 1;
}
