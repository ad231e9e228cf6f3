// Prints what `flicker` measured: metrics of all pairs of frames, of those at the borders of groups, and a verdict.
#include "cli/compare/flicker_report.h"

#include "base/words.h"
#include "cli/messages.h"

#include <math.h>
#include <stdio.h>

static bool has_variance( const RfFlickerRun* run ) { return run->reference == NULL && run->layers.variance[0] != NULL; }

// A number, or a dash where it is not known.
static const char* format( double value, const char* how, char text[32] )
{
    snprintf( text, 32, isfinite( value ) ? how : "-", value );
    return text;
}

static void print_row( const char* name, const RfFlickerSums* sums, const char* note )
{
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    char f1[32], phi[32], rmse[32];
    printf( "%12s  %11s  %7s  %11s  %7.2f %%%s%s\n", name, format( m.f1, "%.4e", f1 ), format( m.phi, "%.4f", phi ),
            format( sqrt( m.mse ), "%.4e", rmse ), 100.0 * m.coverage, note[0] != '\0' ? "  " : "", note );
}

static void print_rows( const RfFlickerRun* run )
{
    char text[32];
    printf( "%12s  %11s  %7s  %11s  %9s\n", "frame", "F1", "phi", "RMSE", "coverage" );
    for ( int i = 0; i < run->pair_count; ++i )
    {
        snprintf( text, sizeof text, "%d", run->pairs[i].frame );
        print_row( text, &run->pairs[i].sums, run->pairs[i].border ? "border" : "" );
    }
    print_row( "all", &run->plain.all, "" );
    if ( run->cuts > 0 )
        printf( "%d cut%s: no pair of frames is compared across one\n", run->cuts, run->cuts == 1 ? "" : "s" );
    for ( int border = 0; border < 2 && run->has_seams; ++border )
    {
        const RfFlickerSums* sums = border ? &run->plain.border : &run->plain.inside;
        snprintf( text, sizeof text, "%d pairs", sums->pairs );
        print_row( border ? "border" : "inside", sums, text );
    }
    if ( run->follows && run->followed.all.pairs > 0 )
        print_row( "along motion", &run->followed.all, "" );
}

static void print_spectrum( const RfFlickerRun* run )
{
    if ( !run->has_spectrum )
        return;
    RfSpectrum s = rf_spectrum( &run->spectrum );
    char frozen[32], drift[32], boiling[32];
    printf( "spectrum over %d frames, RMS: ", run->window );
    if ( run->reference != NULL )
        printf( "frozen %s, ", format( s.frozen, "%.4e", frozen ) );
    printf( "slow drift (periods of %.0f frames and more) %s, boiling (shorter) %s; coverage %.2f %%\n", 1.0 / RF_SPECTRUM_SPLIT,
            format( s.drift, "%.4e", drift ), format( s.boiling, "%.4e", boiling ), 100.0 * s.coverage );
}

static const char* describe_phi( double phi )
{
    if ( phi < 0.1 )
        return "the error is almost frozen";
    if ( phi < 0.5 )
        return "the error changes slowly from frame to frame";
    if ( phi < 0.85 )
        return "the error flickers less than independent noise";
    return phi <= 1.15 ? "the error flickers like independent noise"
                       : "the error alternates: it flickers more than independent noise";
}

// The same error measured along the motion.
static void print_followed_words( const RfFlickerRun* run, const char* unfollowed )
{
    const RfFlickerSums* sums = &run->followed.all;
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    if ( unfollowed[0] != '\0' )
        printf( "no figures along the motion: %s\n", unfollowed );
    if ( run->follows && isfinite( m.phi ) && m.mse > 0.0 )
        printf( "along the motion, %s: phi %.3f, RMSE %.3e\n", describe_phi( m.phi ), m.phi, sqrt( m.mse ) );
    if ( run->follows && sums->pairs < run->plain.all.pairs )
        printf( "along the motion, %d of %d pairs are measured: the other frames lack the layers\n", sums->pairs,
                run->plain.all.pairs );
}

static void print_motion_words( const RfFlickerRun* run, const RfFlickerSums* sums )
{
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    if ( isfinite( m.motion ) )
        printf( "average motion: %.2f pixels per frame\n", m.motion );
    if ( run->layers.depth == NULL )
        printf( "%s without depth: disocclusions count as flicker\n",
                rf_is_compensated( run ) ? "motion-compensated" : "along the motion" );
    if ( sums->pairs > 0 && !( sums->pixels > 0.0 ) )
        printf( "no pixel is visible in two neighbouring frames: check the motion and depth layers\n" );
}

// What the verdict does not say: what is missing for more.
static void print_words( const RfFlickerRun* run, const char* unfollowed )
{
    RfFlickerMetrics m = rf_flicker_metrics( &run->plain.all );
    bool is_unknown = run->reference == NULL && !isfinite( m.phi ) && isfinite( m.f1 );
    if ( is_unknown && has_variance( run ) )
        printf( "phi is unknown: the variance layers are 0, as after a single pass: give --reference\n" );
    else if ( is_unknown )
        printf( "phi needs the size of the error: give --reference, or render --aov variance\n" );
    if ( !rf_is_compensated( run ) && run->reference == NULL )
        printf( "not motion-compensated: motion counts as flicker (render --aov motion,depth, or give --reference)\n" );
    print_followed_words( run, unfollowed );
    if ( rf_is_compensated( run ) || run->follows )
        print_motion_words( run, rf_is_compensated( run ) ? &run->plain.all : &run->followed.all );
}

// The pair whose F1 is the largest: the number of its second frame.
static int worst_pair( const RfFlickerRun* run, double* f1 )
{
    int worst = 0;
    *f1 = -1.0;
    for ( int i = 0; i < run->pair_count; ++i )
    {
        double value = rf_flicker_metrics( &run->pairs[i].sums ).f1;
        if ( !( value > *f1 ) )
            continue;
        *f1 = value;
        worst = run->pairs[i].frame;
    }
    return worst;
}

#define VERDICT_SIZE 512

// Two lines: how the error changes, and how much of it there is.
static void format_verdict( const RfFlickerRun* run, char text[VERDICT_SIZE] )
{
    RfFlickerMetrics m = rf_flicker_metrics( &run->plain.all );
    bool is_error = run->reference != NULL, has_phi = isfinite( m.phi ) && m.mse > 0.0;
    double most;
    int worst = worst_pair( run, &most );
    char percent[RF_NOISE_TEXT_SIZE];
    text[0] = '\0';
    if ( !isfinite( m.f1 ) )
    {
        rf_append( text, VERDICT_SIZE,
                   "no flicker can be measured\nthere are NaN or infinite values, or no pixel is visible in two "
                   "neighbouring frames" );
        return;
    }
    if ( has_phi && is_error )
        rf_append( text, VERDICT_SIZE, "%s (phi %.2f)", describe_phi( m.phi ), m.phi );
    else if ( has_phi )
        rf_append( text, VERDICT_SIZE, "phi at most %.2f: without a reference, moving edges and highlights count as flicker",
                   m.phi );
    else
        rf_append( text, VERDICT_SIZE,
                   isfinite( m.phi ) ? "no flicker: there is no error" : "phi unknown: the size of the error is not known" );
    is_error = is_error && isfinite( run->errors.relmse );
    rf_append( text, VERDICT_SIZE, "\nF1 %.2g (RMS change of the %s between neighbouring frames, largest at frame %d: %.2g)",
               m.f1, is_error ? "error" : "picture", worst, most );
    rf_format_noise( run->errors.relmse, percent );
    if ( is_error )
        rf_append( text, VERDICT_SIZE, "; relMSE %.2g (%s noise per pixel)", run->errors.relmse, percent );
}

void rf_print_flicker( const RfFlickerRun* run, const char* unfollowed )
{
    char verdict[VERDICT_SIZE], percent[RF_NOISE_TEXT_SIZE];
    format_verdict( run, verdict );
    printf( "%s\n\n", verdict );
    print_rows( run );
    print_spectrum( run );
    rf_format_noise( run->errors.relmse, percent );
    if ( run->reference != NULL && isfinite( run->errors.relmse ) )
        printf( "relMSE over all frames: %.4e (%s noise)\n", run->errors.relmse, percent );
    print_words( run, unfollowed );
}

static json_t* set_metrics( json_t* object, const RfFlickerSums* sums )
{
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    return RF_SET_FIGURES( object, { "f1", m.f1 }, { "phi", m.phi }, { "mse", m.mse }, { "coverage", m.coverage },
                           { "motion", m.motion } );
}

static json_t* pairs_json( const RfFlickerRun* run )
{
    json_t* list = json_array();
    for ( int i = 0; i < run->pair_count; ++i )
    {
        const RfFlickerPair* pair = run->pairs + i;
        json_t* row = set_metrics( json_pack( "{s:i}", "frame", pair->frame ), &pair->sums );
        json_object_set_new( row, "border", json_boolean( pair->border ) );
        if ( run->follows )
            json_object_set_new( row, "followed",
                                 pair->is_followed ? set_metrics( json_object(), &pair->followed ) : json_null() );
        json_array_append_new( list, row );
    }
    return list;
}

// `followed` NULL: none.
static json_t* part_json( const RfFlickerSums* sums, const RfFlickerSums* followed )
{
    json_t* object = set_metrics( json_pack( "{s:i}", "pairs", sums->pairs ), sums );
    if ( followed != NULL )
        json_object_set_new( object, "followed", part_json( followed, NULL ) );
    return object;
}

static json_t* spectrum_json( const RfFlickerRun* run )
{
    RfSpectrum s = rf_spectrum( &run->spectrum );
    return RF_SET_FIGURES( json_pack( "{s:i, s:i}", "frames", run->window, "windows", run->spectrum.groups ),
                           { "split", RF_SPECTRUM_SPLIT }, { "frozen", run->reference != NULL ? s.frozen : (double)NAN },
                           { "drift", s.drift }, { "boiling", s.boiling }, { "coverage", s.coverage } );
}

static json_t* seams_json( const RfFlickerRun* run )
{
    bool follows = run->follows;
    return json_pack( "{s:o, s:o}", "inside", part_json( &run->plain.inside, follows ? &run->followed.inside : NULL ), "border",
                      part_json( &run->plain.border, follows ? &run->followed.border : NULL ) );
}

json_t* rf_flicker_json( const RfFlickerRun* run )
{
    const RfErrorMetrics* e = &run->errors;
    bool has_reference = run->reference != NULL, masked = run->layers.depth != NULL;
    char verdict[VERDICT_SIZE];
    format_verdict( run, verdict );
    json_t* object = set_metrics( json_pack( "{s:s, s:o}", "verdict", verdict, "pairs", pairs_json( run ) ), &run->plain.all );
    rf_json_add( object, "{s:i, s:b, s:b, s:s?, s:o, s:o, s:o, s:I, s:I, s:I, s:I}", "cuts", run->cuts, "compensated",
                 rf_is_compensated( run ), "masked", rf_is_compensated( run ) && masked, "error_from",
                 has_reference         ? "reference"
                 : has_variance( run ) ? "variance"
                                       : NULL,
                 "relmse", rf_json_number( has_reference ? e->relmse : (double)NAN ), "groups",
                 run->has_seams ? seams_json( run ) : json_null(), "spectrum",
                 run->has_spectrum ? spectrum_json( run ) : json_null(), "nan", (json_int_t)e->nan, "inf", (json_int_t)e->inf,
                 "reference_nan", (json_int_t)( has_reference ? e->reference_nan : 0 ), "reference_inf",
                 (json_int_t)( has_reference ? e->reference_inf : 0 ) );
    if ( run->follows )
    {
        json_t* followed = part_json( &run->followed.all, NULL );
        json_object_set_new( followed, "masked", json_boolean( masked ) );
        json_object_set_new( object, "followed", followed );
    }
    return object;
}
