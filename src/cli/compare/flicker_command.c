// reframe flicker SEQ: how much the error of a sequence changes from frame to frame, against a reference or along the motion layers.
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/shared_options.h"
#include "cli/render/progress.h"
#include "measure/flicker_sequence.h"
#include "page/pass_groups.h"
#include "reframe/image.h"

#include <jansson.h>
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
    char relative[32], f1[32], phi[32], rmse[32];
    printf( "%12s  %8s  %11s  %7s  %11s  %7.2f %%%s%s\n", name, format( 100.0 * m.f1_relative, "%.3g %%", relative ),
            format( m.f1, "%.4e", f1 ), format( m.phi, "%.4f", phi ), format( sqrt( m.mse ), "%.4e", rmse ), 100.0 * m.coverage,
            note[0] != '\0' ? "  " : "", note );
}

static void print_rows( const RfFlickerRun* run )
{
    char text[32];
    printf( "%12s  %8s  %11s  %7s  %11s  %9s\n", "frame", "flicker", "F1", "phi", "RMSE", "coverage" );
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
    printf( "spectrum over %d frames%s, relative RMS: ", run->window, rf_is_compensated( run ) ? ", along the motion" : "" );
    if ( run->reference != NULL )
        printf( "frozen %s, ", format( 100.0 * s.frozen, "%.3g %%", frozen ) );
    printf( "slow drift (below %g Hz) %s, boiling (above) %s; coverage %.2f %%\n", RF_DRIFT_HERTZ,
            format( 100.0 * s.drift, "%.3g %%", drift ), format( 100.0 * s.boiling, "%.3g %%", boiling ), 100.0 * s.coverage );
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

// The pair that flickers most: the number of its second frame.
static int worst_pair( const RfFlickerRun* run, double* most )
{
    int worst = 0;
    *most = -1.0;
    for ( int i = 0; i < run->pair_count; ++i )
    {
        double value = rf_flicker_metrics( &run->pairs[i].sums ).f1_relative;
        if ( !( value > *most ) )
            continue;
        *most = value;
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
    rf_append( text, VERDICT_SIZE,
               "\nFlicker %.2g %% (RMS change of the %s from frame to frame, %s, largest at frame %d: %.2g %%)",
               100.0 * m.f1_relative, is_error ? "error" : "picture", rf_is_compensated( run ) ? "along the motion" : "in place",
               worst, 100.0 * most );
    rf_format_noise( run->errors.relmse, percent );
    if ( is_error )
        rf_append( text, VERDICT_SIZE, "; relMSE %.2g (%s noise per pixel)", run->errors.relmse, percent );
}

// The verdict in two lines, then a row for each pair, and the rest. `unfollowed`: why nothing is followed along the motion where layers
// are there; else empty.
static void print_flicker( const RfFlickerRun* run, const char* unfollowed )
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
    return RF_SET_FIGURES( object, { "f1", m.f1 }, { "f1_relative", m.f1_relative }, { "phi", m.phi }, { "mse", m.mse },
                           { "coverage", m.coverage }, { "motion", m.motion } );
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
                           { "split", run->split }, { "frozen", run->reference != NULL ? s.frozen : (double)NAN },
                           { "drift", s.drift }, { "boiling", s.boiling }, { "coverage", s.coverage } );
}

static json_t* seams_json( const RfFlickerRun* run )
{
    bool follows = run->follows;
    return json_pack( "{s:o, s:o}", "inside", part_json( &run->plain.inside, follows ? &run->followed.inside : NULL ), "border",
                      part_json( &run->plain.border, follows ? &run->followed.border : NULL ) );
}

static json_t* flicker_json( const RfFlickerRun* run )
{
    const RfErrorMetrics* e = &run->errors;
    bool has_reference = run->reference != NULL, masked = run->layers.depth != NULL;
    char verdict[VERDICT_SIZE];
    format_verdict( run, verdict );
    json_t* object = set_metrics( json_pack( "{s:s, s:o}", "verdict", verdict, "pairs", pairs_json( run ) ), &run->plain.all );
    if ( run->follows )
    {
        json_t* followed = part_json( &run->followed.all, NULL );
        json_object_set_new( followed, "masked", json_boolean( masked ) );
        json_object_set_new( object, "followed", followed );
    }
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
    return object;
}

#define COMMAND "flicker"

typedef struct Flicker
{
    RfFlickerRun run;       // its pattern, reference, layers of colour, period and spectrum are options
    const char* frame_list; // this and the next two may be NULL
    const char* motion;
    const char* depth;
    bool compensate, compensate_given;
    const char* png; // or NULL
    int column;      // 0: the middle
    bool column_given;
    double exposure;
    bool exposure_given;
    const char* json; // or NULL
    bool quiet;
    RfSequenceInput in;
    char texts[2][RF_PASS_LAYER_SIZE]; // names of both layers of colour, as the first files have them
    RfExrHeader layered;               // of the first frame that has motion layers, where it is followed beside: their names
    char unfollowed[512];              // why nothing is followed where layers are there; else empty
    RfSlitScan slit;
} Flicker;

// Lists the frames, of sequences alone.
static RfResult find_frames( Flicker* flicker, RfError* error )
{
    RfFlickerRun* run = &flicker->run;
    const char* patterns[2] = { run->pattern, run->reference };
    for ( int i = 0; i < 2; ++i )
    {
        if ( patterns[i] != NULL && !rf_is_sequence( patterns[i] ) )
            return rf_fail( error, RF_ERROR_USAGE, "%s%s: has no #### for the frame number: give a sequence",
                            i == 1 ? "--reference: " : "", patterns[i] );
    }
    RfResult result = rf_find_sequence_input( run->pattern, flicker->frame_list, &flicker->in, error );
    run->frames = flicker->in.frames;
    run->frame_count = flicker->in.count;
    run->first_frame = flicker->in.first;
    return result == RF_OK ? rf_open_flicker_run( run, error ) : result;
}

static RfResult fail_no_motion( const Flicker* flicker, RfError* error )
{
    return rf_fail( error, RF_ERROR_FORMAT,
                    "%s: has no motion layer: name its channels by --motion X,Y, or render --aov motion,depth",
                    flicker->run.first_path );
}

// Errors about names that were given, "motion: ...", are errors of the options.
static void name_option( const Flicker* flicker, RfError* error )
{
    bool given = flicker->motion != NULL || flicker->depth != NULL;
    if ( error->remedy == RF_REMEDY_NONE && given )
        rf_fail( error, error->code, "--%s", error->text );
}

// Layers of the main figures: those of the first frame, which all frames must have.
static RfResult find_main_layers( Flicker* flicker, bool compensate, RfFlickerLayers* layers, RfError* error )
{
    const RfFlickerRun* run = &flicker->run;
    RfResult result = RF_OK;
    if ( compensate )
    {
        result = rf_find_flicker_layers( run->first_path, &run->first, flicker->motion, flicker->depth, layers, error );
        if ( result != RF_OK )
            name_option( flicker, error );
    }
    // the variance is the colour's, not that of another layer
    if ( result == RF_OK && run->reference == NULL && run->layers.colour == NULL )
        result = rf_find_variance_layers( run->first_path, &run->first, layers, error );
    if ( result == RF_OK && layers->motion[0] == NULL && ( flicker->compensate || flicker->depth != NULL ) )
        return fail_no_motion( flicker, error );
    return result;
}

// Layers of the additional figures along the motion: those of the first frame that has any. If
// they are ambiguous the figures are left out, with a note.
static RfResult find_layers_beside( Flicker* flicker, RfFlickerLayers* layers, RfError* error )
{
    char path[RF_FLICKER_NAME_SIZE];
    RfFlickerRun* run = &flicker->run;
    RfError unclear = { 0 };
    RfResult result = RF_OK;
    for ( int i = 0; i < run->frame_count && layers->motion[0] == NULL && unclear.code == RF_OK && result == RF_OK; ++i )
    {
        rf_destroy_exr_header( &flicker->layered );
        result = rf_sequence_name( run->pattern, run->frames[i], path, sizeof path, error );
        if ( result == RF_OK )
            result = rf_read_exr_header( path, run->layers.colour, &flicker->layered, error );
        if ( result == RF_OK &&
             rf_find_flicker_layers( path, &flicker->layered, NULL, flicker->depth, layers, &unclear ) != RF_OK )
            *layers = ( RfFlickerLayers ){ 0 };
    }
    if ( result != RF_OK )
        return result;
    if ( flicker->depth != NULL && unclear.code != RF_OK )
    {
        name_option( flicker, &unclear );
        *error = unclear;
        return unclear.code;
    }
    if ( flicker->depth != NULL && layers->motion[0] == NULL )
        return fail_no_motion( flicker, error );
    if ( unclear.code != RF_OK )
        rf_format_error( &unclear, flicker->unfollowed, sizeof flicker->unfollowed );
    run->follows = layers->motion[0] != NULL;
    layers->may_lack = true;
    return RF_OK;
}

// Chooses layers from the header of the first frame. Against a reference, motion is also followed
// in additional figures, where any frame has it.
static RfResult find_layers( Flicker* flicker, RfError* error )
{
    char path[RF_FLICKER_NAME_SIZE];
    RfFlickerRun* run = &flicker->run;
    RfFlickerLayers layers = { 0 };
    const char* reference_layer = run->reference_layer != NULL ? run->reference_layer : run->layers.colour;
    run->layers.colour = rf_layer_of_file( run->first_path, run->layers.colour, flicker->texts[0] );
    RfResult result = rf_read_exr_header( run->first_path, run->layers.colour, &run->first, error );
    if ( result == RF_OK && run->reference != NULL )
    {
        result = rf_sequence_name( run->reference, run->frames[0], path, sizeof path, error );
        run->reference_layer = rf_layer_of_file( path, reference_layer, flicker->texts[1] );
    }
    if ( result != RF_OK )
        return result;
    bool by_default = run->reference == NULL || flicker->motion != NULL;
    bool beside = !by_default && !flicker->compensate_given;
    bool compensate = flicker->compensate_given ? flicker->compensate : by_default;
    result = beside ? find_layers_beside( flicker, &layers, error ) : find_main_layers( flicker, compensate, &layers, error );
    layers.colour = run->layers.colour;
    layers.depth = layers.motion[0] != NULL ? layers.depth : NULL;
    run->layers = layers;
    return result;
}

static RfResult prepare_slit( Flicker* flicker, RfError* error )
{
    RfFlickerRun* run = &flicker->run;
    int width = run->first.width;
    if ( flicker->column > width )
        return rf_fail( error, RF_ERROR_USAGE, "--column: there is no column %d in frames of %d", flicker->column, width );
    if ( flicker->png == NULL )
        return RF_OK;
    run->column = flicker->column > 0 ? flicker->column - 1 : width / 2;
    run->slit = &flicker->slit;
    return rf_create_slit_scan( run->frame_count, run->first.height, run->reference != NULL ? 2 : 1, run->slit, error );
}

static RfResult check_finite( const RfFlickerRun* run, RfError* error )
{
    const RfErrorMetrics* m = &run->errors;
    bool image = m->nan > 0 || m->inf > 0;
    if ( !image && ( run->reference == NULL || !rf_has_no_error( m ) ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no flicker can be reported",
                    image ? run->pattern : run->reference, image ? m->nan : m->reference_nan, image ? m->inf : m->reference_inf );
}

static RfResult finish( Flicker* flicker, RfError* error )
{
    const RfFlickerRun* run = &flicker->run;
    if ( rf_prints_text( flicker->json ) )
        print_flicker( run, flicker->unfollowed );
    RfResult result = rf_flush_output( error );
    if ( result == RF_OK && flicker->png != NULL )
        result = rf_write_png( flicker->png, &flicker->slit.image, (float)flicker->exposure, error );
    if ( result == RF_OK && flicker->json != NULL )
        result = rf_write_json( flicker->json, flicker_json( run ), error );
    return result == RF_OK ? check_finite( run, error ) : result;
}

static void show_progress( void* user, int done )
{
    const Flicker* flicker = user;
    rf_show_frame_count( flicker->quiet, done, flicker->run.frame_count );
}

static RfResult check_options( Flicker* flicker, RfError* error )
{
    const char* alone = flicker->motion != NULL ? "motion" : flicker->depth != NULL ? "depth" : NULL;
    if ( alone != NULL && flicker->compensate_given && !flicker->compensate )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: has no effect with --no-compensate", alone );
    if ( flicker->run.reference_layer != NULL && flicker->run.reference == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--reference-layer: needs --reference" );
    if ( flicker->png == NULL && ( flicker->column_given || flicker->exposure_given ) )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: needs --png", flicker->column_given ? "column" : "exposure" );
    return RF_OK;
}

static RfResult run( void* user, RfError* error )
{
    Flicker* flicker = user;
    flicker->run.progress = show_progress;
    flicker->run.user = flicker;
    static RfResult ( *const steps[] )( Flicker*, RfError* ) = { check_options, find_frames, find_layers, prepare_slit };
    RfResult result = RF_OK;
    for ( size_t i = 0; i < sizeof steps / sizeof steps[0] && result == RF_OK; ++i )
        result = steps[i]( flicker, error );
    if ( result == RF_OK )
        result = rf_measure_flicker_run( &flicker->run, error );
    if ( result == RF_OK )
        result = finish( flicker, error );
    rf_close_flicker_run( &flicker->run );
    rf_destroy_exr_header( &flicker->layered );
    rf_destroy_slit_scan( &flicker->slit );
    rf_free_sequence_input( &flicker->in );
    return result;
}

int rf_command_flicker( int argc, char** argv )
{
    static const char* const files[] = { "SEQ" };
    Flicker flicker = { .run.has_spectrum = true };
    const RfOption options[] = {
        RF_TEXT_OPTION( "reference", &flicker.run.reference, "SEQ",
                        "reference sequence: measure the flicker of the error instead of that of the picture", .reads = true ),
        RF_TEXT_OPTION( "frames", &flicker.frame_list, "[@]A-B", "measure only these frames, which must be consecutive",
                        .default_text = "all" ),
        RF_TEXT_OPTION( "layer", &flicker.run.layers.colour, "NAME",
                        "a layer, part or channel of the files, or three channels X,Y,Z", .default_text = "colour" ),
        RF_TEXT_OPTION( "reference-layer", &flicker.run.reference_layer, "NAME",
                        "layer of the reference, if it is named differently", .default_text = "that of --layer" ),
        RF_FLAG_OPTION( "compensate", &flicker.compensate,
                        "measure along the motion layers, masked by depth; --no-compensate: in place only",
                        .given = &flicker.compensate_given,
                        .default_text = "if there are motion layers; with a reference, in addition to the plain figures",
                        .heading = RF_HEADING_MEASUREMENT ),
        RF_TEXT_OPTION( "motion", &flicker.motion, "X,Y",
                        "channels of the motion to the previous frame, in pixels, +x right, +y up; implies --compensate",
                        .default_text = "the layer motion or Vector", .heading = RF_HEADING_MEASUREMENT ),
        RF_TEXT_OPTION( "depth", &flicker.depth, "NAME", "depth channel, to find disocclusions",
                        .default_text = "depth.Z, Depth.Z, Depth.V or Z", .heading = RF_HEADING_MEASUREMENT ),
        RF_INT_OPTION( "border", &flicker.run.period, 2, 1000000, "N",
                       "report separately the borders of groups of N frames, counted from the first frame",
                       .default_text = "Reframe's own groups", .heading = RF_HEADING_MEASUREMENT ),
        RF_FLAG_OPTION( "spectrum", &flicker.run.has_spectrum,
                        "split the error into slow drift and boiling; keeps 16 frames in memory",
                        .heading = RF_HEADING_MEASUREMENT ),
        RF_TEXT_OPTION( "png", &flicker.png, "FILE", "write a slit-scan: one column over time, the reference's below",
                        .writes = ".png", .heading = RF_HEADING_OUTPUT ),
        RF_INT_OPTION( "column", &flicker.column, 1, 1 << 20, "X", "column of the slit-scan; 1 is the leftmost",
                       .default_text = "the middle", .given = &flicker.column_given, .heading = RF_HEADING_OUTPUT ),
        RF_REAL_OPTION( "exposure", &flicker.exposure, -32, 32, "E", "exposure of the slit-scan in stops",
                        .given = &flicker.exposure_given, .heading = RF_HEADING_OUTPUT ),
        RF_RESULT_OPTIONS( flicker, "write the result as JSON; - for standard output, instead of the table", "no progress" ),
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "Measures how much the error of a sequence changes from frame to frame. SEQ is a sequence of EXR files named "
                   "with ####.",
        RF_TABLE_ROWS( files, options )
    };
    return rf_run_command( &table, argc, argv, &flicker.run.pattern, run, &flicker );
}
