// Prints what `flicker` measured: metrics of all pairs of frames, of those at the borders of groups, and a verdict.
#include "cli/compare/flicker_report.h"

#include "cli/messages.h"
#include "cli/options/options.h"
#include "measure/image_error.h"
#include "measure/flicker.h"
#include "reframe/image.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>

#define MOST_FRAMES 10000000

static bool read_whole( const char* path, const char* name, long long min, long long max, int* value )
{
    char text[32];
    long long whole;
    if ( rf_read_exr_string( path, name, text, sizeof text, NULL ) != RF_OK || !rf_parse_whole( text, min, max, &whole ) )
        return false;
    *value = (int)whole;
    return true;
}

RfSeams rf_read_seams( const char* path, int number, int last )
{
    RfSeams seams = { 0 };
    int group, spp, frame, frames;
    if ( !read_whole( path, "reframe/group", 1, MOST_FRAMES, &group ) || !read_whole( path, "reframe/spp", 1, 1 << 20, &spp ) ||
         !read_whole( path, "reframe/frame", -MOST_FRAMES, MOST_FRAMES, &frame ) )
        return seams;
    seams.first = number - ( frame - 1 );
    if ( !read_whole( path, "reframe/frames", 1, MOST_FRAMES, &frames ) )
        frames = last - seams.first + 1;
    char shot[64];
    int first, end;
    if ( rf_read_exr_string( path, "reframe/shot", shot, sizeof shot, NULL ) == RF_OK &&
         sscanf( shot, "%d-%d", &first, &end ) == 2 )
    {
        seams.first = number - ( frame - first );
        frames = end - first + 1;
        frame = frame - first + 1;
    }
    if ( frames < frame || frame < 1 )
        return seams;
    seams.slides = true;
    seams.plan = rf_plan_groups( frames, group, spp );
    return seams;
}

RfSeams rf_fixed_seams( int period, int first ) { return ( RfSeams ){ .period = period, .first = first }; }

// A number, or a dash where it is not known.
static const char* format( double value, const char* how, char text[32] )
{
    snprintf( text, 32, isfinite( value ) ? how : "-", value );
    return text;
}

void rf_add_flicker_pair( RfFlickerParts* parts, bool border, const RfFlickerSums* pair )
{
    rf_add_flicker( &parts->all, pair );
    rf_add_flicker( border ? &parts->border : &parts->inside, pair );
}

static void print_metrics( const char* name, const RfFlickerMetrics* m, const char* note )
{
    char f1[32], phi[32], rmse[32];
    printf( "%12s  %11s  %7s  %11s  %7.2f %%%s%s\n", name, format( m->f1, "%.4e", f1 ), format( m->phi, "%.4f", phi ),
            format( sqrt( m->mse ), "%.4e", rmse ), 100.0 * m->coverage, note[0] != '\0' ? "  " : "", note );
}

static void print_row( const char* name, const RfFlickerSums* sums, const char* note )
{
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    print_metrics( name, &m, note );
}

// The pairs, as they stand in the JSON.
static void print_pairs( const RfFlickerReport* report )
{
    size_t i;
    const json_t* pair;
    printf( "%12s  %11s  %7s  %11s  %9s\n", "frame", "F1", "phi", "RMSE", "coverage" );
    json_array_foreach( report->pairs, i, pair )
    {
        char number[32];
        RfFlickerMetrics m = { .f1 = rf_json_number_of( pair, "f1" ),
                               .phi = rf_json_number_of( pair, "phi" ),
                               .mse = rf_json_number_of( pair, "mse" ),
                               .coverage = rf_json_number_of( pair, "coverage" ) };
        snprintf( number, sizeof number, "%lld", (long long)json_integer_value( json_object_get( pair, "frame" ) ) );
        print_metrics( number, &m, json_is_true( json_object_get( pair, "border" ) ) ? "border" : "" );
    }
}

static void print_seams( const RfFlickerReport* report )
{
    if ( !report->has_seams )
        return;
    char note[32];
    snprintf( note, sizeof note, "%d pairs", report->plain.inside.pairs );
    print_row( "inside", &report->plain.inside, note );
    snprintf( note, sizeof note, "%d pairs", report->plain.border.pairs );
    print_row( "border", &report->plain.border, note );
}

static void print_followed( const RfFlickerReport* report )
{
    if ( report->follows && report->followed.all.pairs > 0 )
        print_row( "along motion", &report->followed.all, "" );
}

static void print_spectrum( const RfFlickerReport* report )
{
    if ( !report->has_spectrum )
        return;
    RfSpectrum s = rf_spectrum( &report->spectrum );
    char frozen[32], drift[32], boiling[32];
    printf( "spectrum over %d frames, RMS: ", report->window );
    if ( report->source == RF_ERROR_FROM_REFERENCE )
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
static void print_followed_words( const RfFlickerReport* report )
{
    const RfFlickerSums* sums = &report->followed.all;
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    if ( report->unfollowed[0] != '\0' )
        printf( "no figures along the motion: %s\n", report->unfollowed );
    if ( report->follows && isfinite( m.phi ) && m.mse > 0.0 )
        printf( "along the motion, %s: phi %.3f, RMSE %.3e\n", describe_phi( m.phi ), m.phi, sqrt( m.mse ) );
    if ( report->follows && sums->pairs < report->plain.all.pairs )
        printf( "along the motion, %d of %d pairs are measured: the other frames lack the layers\n", sums->pairs,
                report->plain.all.pairs );
}

static void print_motion_words( const RfFlickerReport* report, const RfFlickerSums* sums )
{
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    if ( isfinite( m.motion ) )
        printf( "average motion: %.2f pixels per frame\n", m.motion );
    if ( !report->masked )
        printf( "%s without depth: disocclusions count as flicker\n",
                report->compensated ? "motion-compensated" : "along the motion" );
    if ( sums->pairs > 0 && !( sums->pixels > 0.0 ) )
        printf( "no pixel is visible in two neighbouring frames: check the motion and depth layers\n" );
}

static void print_words( const RfFlickerReport* report )
{
    RfFlickerMetrics m = rf_flicker_metrics( &report->plain.all );
    if ( isfinite( m.phi ) && m.mse > 0.0 && report->source == RF_ERROR_FROM_VARIANCE )
        printf( "phi %.3f, RMSE %.3e from the variance layers; moving edges and highlights count as flicker unless --reference "
                "is given\n",
                m.phi, sqrt( m.mse ) );
    else if ( isfinite( m.phi ) && m.mse > 0.0 )
        printf( "%s: phi %.3f, RMSE %.3e\n", describe_phi( m.phi ), m.phi, sqrt( m.mse ) );
    else if ( isfinite( m.phi ) )
        printf( "no flicker: there is no error\n" );
    else if ( report->source == RF_ERROR_UNKNOWN && isfinite( m.f1 ) )
        printf( "phi needs the size of the error: give --reference, or render --aov variance\n" );
    else if ( report->source == RF_ERROR_FROM_VARIANCE && isfinite( m.f1 ) )
        printf( "phi is unknown: the variance layers are 0, as after a single pass: give --reference\n" );
    if ( !report->compensated && report->source != RF_ERROR_FROM_REFERENCE )
        printf( "not motion-compensated: motion counts as flicker (render --aov motion,depth, or give --reference)\n" );
    print_followed_words( report );
    if ( report->compensated || report->follows )
        print_motion_words( report, report->compensated ? &report->plain.all : &report->followed.all );
}

// The pair whose F1 is the largest: the number of its second frame.
static long long worst_pair( const RfFlickerReport* report, double* f1 )
{
    size_t i;
    const json_t* pair;
    long long worst = 0;
    *f1 = -1.0;
    json_array_foreach( report->pairs, i, pair )
    {
        double value = rf_json_number_of( pair, "f1" );
        if ( !( value > *f1 ) )
            continue;
        *f1 = value;
        worst = (long long)json_integer_value( json_object_get( pair, "frame" ) );
    }
    return worst;
}

#define VERDICT_SIZE 512

// Two lines: how the error changes, and how much of it there is.
static void format_verdict( const RfFlickerReport* report, char text[VERDICT_SIZE] )
{
    RfFlickerMetrics m = rf_flicker_metrics( &report->plain.all );
    bool is_error = report->source == RF_ERROR_FROM_REFERENCE;
    double most;
    long long worst = worst_pair( report, &most );
    int used;
    if ( !isfinite( m.f1 ) )
        used = snprintf( text, VERDICT_SIZE, "no flicker can be measured" );
    else if ( isfinite( m.phi ) && m.mse > 0.0 && is_error )
        used = snprintf( text, VERDICT_SIZE, "%s (phi %.2f)", describe_phi( m.phi ), m.phi );
    else if ( isfinite( m.phi ) && m.mse > 0.0 )
        used = snprintf( text, VERDICT_SIZE,
                         "phi at most %.2f: without a reference, moving edges and highlights count as flicker", m.phi );
    else if ( isfinite( m.phi ) )
        used = snprintf( text, VERDICT_SIZE, "no flicker: there is no error" );
    else
        used = snprintf( text, VERDICT_SIZE, "phi unknown: the size of the error is not known" );
    char *rest = text + used, changes[96], percent[RF_NOISE_TEXT_SIZE];
    rf_format_noise( report->errors.relmse, percent );
    size_t size = VERDICT_SIZE - (size_t)used;
    snprintf( changes, sizeof changes, "between neighbouring frames, largest at frame %lld: %.2g", worst, most );
    if ( !isfinite( m.f1 ) )
        snprintf( rest, size, "\n%s", "there are NaN or infinite values, or no pixel is visible in two neighbouring frames" );
    else if ( is_error && isfinite( report->errors.relmse ) )
        snprintf( rest, size, "\nF1 %.2g (RMS change of the error %s); relMSE %.2g (%s noise per pixel)", m.f1, changes,
                  report->errors.relmse, percent );
    else
        snprintf( rest, size, "\nF1 %.2g (RMS change of the picture %s)", m.f1, changes );
}

void rf_print_flicker( const RfFlickerReport* report )
{
    char verdict[VERDICT_SIZE];
    format_verdict( report, verdict );
    printf( "%s\n\n", verdict );
    print_pairs( report );
    print_row( "all", &report->plain.all, "" );
    if ( report->cuts > 0 )
        printf( "%d cut%s: no pair of frames is compared across one\n", report->cuts, report->cuts == 1 ? "" : "s" );
    print_seams( report );
    print_followed( report );
    print_spectrum( report );
    if ( report->source == RF_ERROR_FROM_REFERENCE && isfinite( report->errors.relmse ) )
    {
        char percent[RF_NOISE_TEXT_SIZE];
        rf_format_noise( report->errors.relmse, percent );
        printf( "relMSE over all frames: %.4e (%s noise)\n", report->errors.relmse, percent );
    }
    print_words( report );
}

static void set_metrics( json_t* object, const RfFlickerSums* sums )
{
    RfFlickerMetrics m = rf_flicker_metrics( sums );
    json_object_set_new( object, "f1", rf_json_number( m.f1 ) );
    json_object_set_new( object, "phi", rf_json_number( m.phi ) );
    json_object_set_new( object, "mse", rf_json_number( m.mse ) );
    json_object_set_new( object, "coverage", rf_json_number( m.coverage ) );
    json_object_set_new( object, "motion", rf_json_number( m.motion ) );
}

json_t* rf_flicker_pair_json( int frame, bool border, const RfFlickerSums* sums )
{
    json_t* row = json_object();
    json_object_set_new( row, "frame", json_integer( frame ) );
    set_metrics( row, sums );
    json_object_set_new( row, "border", json_boolean( border ) );
    return row;
}

json_t* rf_followed_pair_json( const RfFlickerSums* sums )
{
    if ( sums == NULL )
        return json_null();
    json_t* object = json_object();
    set_metrics( object, sums );
    return object;
}

// `followed` NULL: none.
static json_t* part_json( const RfFlickerSums* sums, const RfFlickerSums* followed )
{
    json_t* object = json_object();
    json_object_set_new( object, "pairs", json_integer( sums->pairs ) );
    set_metrics( object, sums );
    if ( followed != NULL )
        json_object_set_new( object, "followed", part_json( followed, NULL ) );
    return object;
}

static json_t* spectrum_json( const RfFlickerReport* report )
{
    RfSpectrum s = rf_spectrum( &report->spectrum );
    json_t* object = json_object();
    json_object_set_new( object, "frames", json_integer( report->window ) );
    json_object_set_new( object, "windows", json_integer( report->spectrum.groups ) );
    json_object_set_new( object, "split", json_real( RF_SPECTRUM_SPLIT ) );
    bool is_error = report->source == RF_ERROR_FROM_REFERENCE;
    json_object_set_new( object, "frozen", is_error ? rf_json_number( s.frozen ) : json_null() );
    json_object_set_new( object, "drift", rf_json_number( s.drift ) );
    json_object_set_new( object, "boiling", rf_json_number( s.boiling ) );
    json_object_set_new( object, "coverage", rf_json_number( s.coverage ) );
    return object;
}

static json_t* seams_json( const RfFlickerReport* report )
{
    json_t* object = json_object();
    const RfFlickerParts* followed = report->follows ? &report->followed : NULL;
    json_object_set_new( object, "inside", part_json( &report->plain.inside, followed != NULL ? &followed->inside : NULL ) );
    json_object_set_new( object, "border", part_json( &report->plain.border, followed != NULL ? &followed->border : NULL ) );
    return object;
}

json_t* rf_flicker_json( RfFlickerReport* report )
{
    json_t* object = json_object();
    const RfErrorMetrics* e = &report->errors;
    char verdict[VERDICT_SIZE];
    format_verdict( report, verdict );
    json_object_set_new( object, "verdict", json_string( verdict ) );
    json_object_set_new( object, "pairs", report->pairs );
    report->pairs = NULL;
    set_metrics( object, &report->plain.all );
    json_object_set_new( object, "cuts", json_integer( report->cuts ) );
    if ( report->follows )
    {
        json_t* followed = part_json( &report->followed.all, NULL );
        json_object_set_new( followed, "masked", json_boolean( report->masked ) );
        json_object_set_new( object, "followed", followed );
    }
    json_object_set_new( object, "compensated", json_boolean( report->compensated ) );
    json_object_set_new( object, "masked", json_boolean( report->compensated && report->masked ) );
    json_object_set_new( object, "error_from",
                         report->source == RF_ERROR_FROM_REFERENCE  ? json_string( "reference" )
                         : report->source == RF_ERROR_FROM_VARIANCE ? json_string( "variance" )
                                                                    : json_null() );
    bool is_error = report->source == RF_ERROR_FROM_REFERENCE;
    json_object_set_new( object, "relmse", is_error ? rf_json_number( e->relmse ) : json_null() );
    json_object_set_new( object, "groups", report->has_seams ? seams_json( report ) : json_null() );
    json_object_set_new( object, "spectrum", report->has_spectrum ? spectrum_json( report ) : json_null() );
    json_object_set_new( object, "nan", json_integer( (json_int_t)e->nan ) );
    json_object_set_new( object, "inf", json_integer( (json_int_t)e->inf ) );
    json_object_set_new( object, "reference_nan", json_integer( is_error ? (json_int_t)e->reference_nan : 0 ) );
    json_object_set_new( object, "reference_inf", json_integer( is_error ? (json_int_t)e->reference_inf : 0 ) );
    return object;
}
