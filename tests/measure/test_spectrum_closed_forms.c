// Temporal spectrum, seams and slit-scan against closed forms.
#include "support/frame_files.h"
#include "support/test.h"
#include "measure/flicker.h"

#include <omp.h>

typedef struct Film
{
    RfFlickerFrame frames[RF_SPECTRUM_FRAMES];
    const RfFlickerFrame* order[RF_SPECTRUM_FRAMES];
} Film;

static Film* make_film( void )
{
    Film* film = calloc( 1, sizeof *film );
    assert_non_null( film );
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t )
        film->frames[t] = make_frame( t + 1 );
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t )
        film->order[t] = film->frames + t;
    return film;
}

static void destroy_film( Film* film )
{
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t )
        rf_destroy_flicker_frame( film->frames + t );
    free( film );
}

static RfSpectrum split_at( double split, const Film* film, int count, bool compensate )
{
    RfSpectrumSums sums = { 0 };
    RfError error = { 0 };
    if ( rf_add_spectrum_group( &sums, film->order, count, split, compensate, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return rf_spectrum( &sums );
}

static RfSpectrum spectrum_of( const Film* film, int count, bool compensate )
{
    return split_at( 0.125, film, count, compensate );
}

// The same sums to the bit, whatever the number of threads.
TEST( test_threads_change_no_sum )
{
    Film* film = make_film();
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t )
    {
        fill_noise( film->frames + t, 50 + (uint32_t)t, 1.0f );
        set_motion( film->frames + t, 0.3f, -0.2f );
    }
    int threads = omp_get_max_threads();
    RfFlickerSums sums[2];
    RfSpectrum spectra[2];
    for ( int k = 0; k < 2; ++k )
    {
        omp_set_num_threads( 1 + 4 * k );
        sums[k] = measure( film->frames + 1, film->frames, true, true );
        spectra[k] = spectrum_of( film, 6, true );
    }
    omp_set_num_threads( threads );
    assert_true( sums[0].difference > 0.0 && spectra[0].boiling > 0.0 );
    assert_true( sums[0].difference == sums[1].difference && sums[0].square == sums[1].square &&
                 sums[0].pixels == sums[1].pixels );
    assert_memory_equal( spectra, spectra + 1, sizeof spectra[0] );
    destroy_film( film );
}

static void fill_tone( Film* film, double offset, double amplitude, double cycles )
{
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t )
    {
        for ( int i = 0; i < VALUES; ++i )
            film->frames[t].signal.rgb[i] =
                (float)( offset + amplitude * cos( 2.0 * 3.14159265358979323846 * cycles * ( t + 0.5 ) ) );
    }
}

// Tones of the transform lie in one band each, whole; a ramp hardly leaves the
// slow one; independent noise has 1/16, 4/16, 11/16 of its mean square.
TEST( test_tones_lie_in_one_band )
{
    Film* film = make_film();
    fill_tone( film, 3.0, 2.0, 4.0 / 32.0 );
    RfSpectrum s = spectrum_of( film, RF_SPECTRUM_FRAMES, false );
    check_near( s.frozen, 3.0, 1e-6 );
    check_near( s.drift, sqrt( 2.0 ), 1e-6 );
    check_near( s.boiling, 0.0, 1e-6 );
    fill_tone( film, 0.0, 2.0, 5.0 / 32.0 );
    s = spectrum_of( film, RF_SPECTRUM_FRAMES, false );
    check_near( s.drift, 0.0, 1e-6 );
    check_near( s.boiling, sqrt( 2.0 ), 1e-6 );
    s = split_at( 0.2, film, RF_SPECTRUM_FRAMES, false );
    check_near( s.drift, sqrt( 2.0 ), 1e-6 );
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t ) // the mean of the squared brightness is 4
    {
        film->frames[t].below = malloc( PIXELS * sizeof( double ) );
        for ( int i = 0; i < PIXELS; ++i )
            film->frames[t].below[i] = 3.0 + 2.0 * ( t % 2 );
    }
    s = spectrum_of( film, RF_SPECTRUM_FRAMES, false );
    check_near( s.boiling, sqrt( 0.5 ), 1e-6 );
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t )
    {
        free( film->frames[t].below );
        film->frames[t].below = NULL;
        for ( int i = 0; i < VALUES; ++i )
            film->frames[t].signal.rgb[i] = (float)t;
    }
    s = spectrum_of( film, RF_SPECTRUM_FRAMES, false );
    check_near( s.frozen, 7.5, 1e-12 );
    check_near( s.drift * s.drift + s.boiling * s.boiling, 255.0 / 12.0, 1e-9 );
    assert_true( s.boiling * s.boiling < 0.01 * s.drift * s.drift );
    for ( int t = 0; t < RF_SPECTRUM_FRAMES; ++t )
        fill_noise( film->frames + t, 400 + (uint32_t)t, 1.0f );
    s = spectrum_of( film, RF_SPECTRUM_FRAMES, false );
    double deviation = sqrt( 2.0 / VALUES ); // of a mean square of one coefficient
    check_near( 16.0 * s.frozen * s.frozen, 1.0, 4.0 * deviation );
    check_near( 4.0 * s.drift * s.drift, 1.0, 2.0 * deviation );
    check_near( 16.0 / 11.0 * s.boiling * s.boiling, 1.0, 1.3 * deviation );
    s = spectrum_of( film, 3, false ); // too short for a slow band
    assert_true( isnan( s.drift ) && s.boiling > 0.5 && s.coverage == 1.0 );
    assert_false( isnan( spectrum_of( film, 4, false ).drift ) );
    film->frames[2].is_finite = false;
    assert_true( isnan( spectrum_of( film, 3, false ).boiling ) );
    RfSpectrumSums sums = { 0 };
    assert_int_equal( rf_add_spectrum_group( &sums, film->order, 17, 0.125, false, NULL ), RF_ERROR_USAGE );
    destroy_film( film );
}

// A texture that moves a pixel to the right each frame stands still along its motion.
TEST( test_bands_follow_motion )
{
    Film* film = make_film();
    fill_noise( film->frames, 9, 1.0f );
    for ( int t = 1; t < RF_SPECTRUM_FRAMES; ++t )
    {
        RfFlickerFrame *now = film->frames + t, *before = now - 1;
        set_motion( now, -1.0f, 0.0f );
        for ( int y = 0; y < HEIGHT; ++y )
            memcpy( now->signal.rgb + 3 * ( y * WIDTH + 1 ), before->signal.rgb + 3 * y * WIDTH, 12 * ( WIDTH - 1 ) );
    }
    RfSpectrum s = spectrum_of( film, RF_SPECTRUM_FRAMES, true );
    assert_true( s.frozen > 0.5 && s.drift < 1e-12 && s.boiling < 1e-12 );
    check_near( s.coverage, (double)( WIDTH - 15 ) / WIDTH, 1e-15 );
    assert_true( spectrum_of( film, RF_SPECTRUM_FRAMES, false ).boiling > 0.5 );
    destroy_film( film );
}

TEST( test_windows_by_length_of_the_sequence )
{
    static const int counts[][2] = { { 2, 1 }, { 15, 1 }, { 16, 1 }, { 17, 2 }, { 24, 2 }, { 48, 5 }, { 50, 6 } };
    for ( size_t k = 0; k < sizeof counts / sizeof counts[0]; ++k )
    {
        int windows = 0;
        for ( int i = 0; i < counts[k][0]; ++i )
            windows += rf_ends_group( i, counts[k][0] );
        assert_int_equal( windows, counts[k][1] );
    }
    assert_true( rf_ends_group( 15, 48 ) && rf_ends_group( 23, 48 ) && !rf_ends_group( 16, 48 ) );
}

static int count_seams( const RfSeams* seams, int frames )
{
    int count = 0;
    for ( int frame = seams->first + 1; frame < seams->first + frames; ++frame )
        count += rf_is_seam( seams, frame );
    return count;
}

TEST( test_seams_are_found )
{
    RfSeams seams = { .first = 1, .slides = true, .plan = rf_plan_groups( 48, 3, 28 ) };
    assert_int_equal( count_seams( &seams, 48 ), 12 ); // frames 1 to 6 and 43 to 48, each with a neighbour
    assert_true( rf_is_seam( &seams, 7 ) && !rf_is_seam( &seams, 8 ) && !rf_is_seam( &seams, 42 ) && rf_is_seam( &seams, 43 ) );
    seams.plan = rf_plan_groups( 12, 3, 28 ); // groups are cut at the ends: no frame but these lies in full ones
    assert_int_equal( count_seams( &seams, 12 ), 11 );
    seams.plan = rf_plan_groups( 14, 3, 28 );
    assert_int_equal( count_seams( &seams, 14 ), 12 ); // but 7 and 8
    assert_false( rf_is_seam( &seams, 8 ) );
    seams.plan = rf_plan_groups( 7, 3, 28 ); // one group
    assert_int_equal( count_seams( &seams, 7 ), 0 );
    seams.plan = rf_plan_groups( 48, 0, 28 );
    assert_int_equal( count_seams( &seams, 48 ), 0 );
    seams = ( RfSeams ){ .period = 7, .first = 101 };
    assert_int_equal( count_seams( &seams, 24 ), 3 );
    assert_true( rf_is_seam( &seams, 108 ) && !rf_is_seam( &seams, 107 ) && rf_has_seams( &seams ) );
    seams = ( RfSeams ){ 0 };
    assert_false( rf_has_seams( &seams ) || rf_is_seam( &seams, 3 ) );
}

TEST( test_slit_scan_is_a_column_over_time )
{
    RfSlitScan scan;
    assert_int_equal( rf_create_slit_scan( 200, HEIGHT, 2, &scan, NULL ), RF_OK );
    assert_true( scan.repeat == 3 && scan.image.width == 600 && scan.image.height == 2 * HEIGHT );
    AUTO_BY( rf_destroy_flicker_frame ) RfFlickerFrame frame = make_frame( 1 );
    fill_noise( &frame, 6, 1.0f );
    rf_add_slit( &scan, 199, 1, &frame.signal, 17 );
    for ( int y = 0; y < HEIGHT; ++y )
    {
        const float* row = scan.image.rgb + 3 * 600 * ( HEIGHT + y );
        for ( int x = 597; x < 600; ++x )
            assert_memory_equal( row + 3 * x, frame.signal.rgb + 3 * ( y * WIDTH + 17 ), 12 );
        assert_true( row[3 * 596] == 0.0f && scan.image.rgb[3 * 600 * y + 1799] == 0.0f );
    }
    rf_destroy_slit_scan( &scan );
    assert_int_equal( rf_create_slit_scan( 481, HEIGHT, 1, &scan, NULL ), RF_OK );
    assert_true( scan.repeat == 1 && scan.image.width == 481 );
    rf_destroy_slit_scan( &scan );
}
