// Checks the frame files that exist: whole, damaged or of another render, for --resume and --check.
#include "cli/render/render_files.h"

#include "base/try.h"
#include "base/words.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/render/render_json.h"
#include "image/sequence.h"
#include "output/frame_file.h"
#include "reframe/image.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_NAME 4096

#define MOST_TEXT 160 // characters of a list of frames in a message

typedef enum Kind
{
    MISSING,
    OTHER,
    UNREADABLE,
    DAMAGED,
    FINISHED,
    KINDS
} Kind;

typedef struct Check
{
    int* lists[KINDS]; // numbers of the frames
    int counts[KINDS];
    int *left, *left_eyes; // all but the finished: their numbers and their runs
    int left_count;
    RfFrameFileState* states; // of the frames asked for
} Check;

static bool create( int count, Check* check )
{
    bool good = true;
    *check = ( Check ){ .left = malloc( (size_t)count * sizeof( int ) ),
                        .left_eyes = malloc( (size_t)count * sizeof( int ) ),
                        .states = malloc( (size_t)count * sizeof( RfFrameFileState ) ) };
    for ( int k = 0; k < KINDS; ++k )
    {
        check->lists[k] = malloc( (size_t)count * sizeof( int ) );
        good = good && check->lists[k] != NULL;
    }
    return good && check->left != NULL && check->left_eyes != NULL && check->states != NULL;
}

static void destroy( Check* check )
{
    for ( int k = 0; k < KINDS; ++k )
        free( check->lists[k] );
    free( check->left );
    free( check->left_eyes );
    free( check->states );
}

#define READERS 4 // threads at most: reading is bound by the disk, and each takes memory

static RfResult look_at( const RfOutput* output, int frame, bool inside, RfFrameFileState* state, RfError* error )
{
    char name[MAX_NAME];
    struct stat status;
    if ( inside )
        return rf_check_frame_file( output, frame, state, error );
    RfResult result = rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, error );
    bool is_there = result == RF_OK && stat( name, &status ) == 0;
    *state = is_there ? RF_FRAME_FILE_OTHER : RF_FRAME_FILE_MISSING;
    return is_there && S_ISDIR( status.st_mode ) ? rf_fail( error, RF_ERROR_IO, "%s: is a folder: choose another name", name )
                                                 : result;
}

// The states of the files of frames: all pixels are read, or with `inside` false only whether there is a file.
static RfResult look_at_files( const RfOutput* output, const int* frames, int count, bool inside, RfFrameFileState* states,
                               RfError* error )
{
    RfResult result = RF_OK;
    int threads = output->settings.threads < READERS ? output->settings.threads : READERS;
#pragma omp parallel for schedule( dynamic ) num_threads( threads )
    for ( int i = 0; i < count; ++i )
    {
        rf_set_float_mode();
        RfError reason = { 0 };
        RfResult one = rf_is_interrupted() ? rf_fail( &reason, RF_ERROR_INTERRUPTED, "interrupted before the first frame" )
                                           : look_at( output, frames[i], inside, states + i, &reason );
#pragma omp critical
        if ( one != RF_OK && result == RF_OK )
        {
            result = one;
            *error = reason;
        }
    }
    return result;
}

static RfResult look_at_all( const RfRenderJob* job, Check* check, RfError* error )
{
    static const Kind kinds[] = { [RF_FRAME_FILE_MISSING] = MISSING,
                                  [RF_FRAME_FILE_SAME] = FINISHED,
                                  [RF_FRAME_FILE_OTHER] = OTHER,
                                  [RF_FRAME_FILE_DAMAGED] = DAMAGED,
                                  [RF_FRAME_FILE_UNREADABLE] = UNREADABLE };
    RfResult result = look_at_files( &job->output, job->frames, job->frame_count, true, check->states, error );
    for ( int i = 0; i < job->frame_count && result == RF_OK; ++i )
    {
        int frame = job->frames[i], number = rf_frame_number( &job->path, frame );
        Kind kind = kinds[check->states[i]];
        check->lists[kind][check->counts[kind]++] = number;
        if ( kind == FINISHED )
            continue;
        check->left[check->left_count] = number;
        check->left_eyes[check->left_count++] = job->path.run_of_frame[frame];
    }
    return result;
}

static json_t* state_json( const RfRenderJob* job, const Check* check, const RfRanges* ranges )
{
    const RfRenderSettings* settings = &job->options.settings;
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &settings->tile, tile );
    json_t* json =
        json_pack( "{s:s, s:o, s:b, s:i, s:i, s:o, s:o, s:o, s:o, s:i, s:i, s:s, s:s}", "version", rf_version(), "scene",
                   rf_json_text( job->options.scene ), "complete", check->left_count == 0, "asked", job->frame_count, "finished",
                   check->counts[FINISHED], "missing", rf_json_frames( check->lists[MISSING], check->counts[MISSING] ), "other",
                   rf_json_frames( check->lists[OTHER], check->counts[OTHER] ), "unreadable",
                   rf_json_frames( check->lists[UNREADABLE], check->counts[UNREADABLE] ), "damaged",
                   rf_json_frames( check->lists[DAMAGED], check->counts[DAMAGED] ), "group", settings->group, "spp",
                   settings->spp, "tile", tile, "adaptive_mode", rf_adaptive_name( settings->adaptive ) );
    if ( ranges->list != NULL )
        json_object_set_new( json, "nodes", rf_ranges_json( ranges ) );
    return json;
}

static void add_list( const Check* check, Kind kind, const char* words, char* text, size_t size )
{
    char frames[MOST_TEXT];
    rf_format_frames( check->lists[kind], check->counts[kind], frames, sizeof frames );
    if ( check->counts[kind] > 0 )
        rf_append( text, size, "; %s: %s", words, frames );
}

static RfResult fail_incomplete( const RfRenderJob* job, const Check* check, RfError* error )
{
    char text[5 * MOST_TEXT] = "";
    bool in_the_way = check->counts[OTHER] + check->counts[UNREADABLE] > 0;
    add_list( check, MISSING, "not there", text, sizeof text );
    add_list( check, OTHER, "of another render", text, sizeof text );
    add_list( check, UNREADABLE, "no frame", text, sizeof text );
    add_list( check, DAMAGED, "damaged", text, sizeof text );
    return rf_fail( error, RF_ERROR_IO, "%.300s: %d of %d frames are finished%s: %s", job->options.output,
                    check->counts[FINISHED], job->frame_count, text,
                    in_the_way ? "--resume --overwrite replaces the rest" : "--resume continues" );
}

static RfResult report_result( const RfRenderJob* job, const Check* check, const RfRanges* ranges, RfError* error )
{
    const char* json = job->options.json;
    bool prints = rf_prints_text( json );
    if ( prints && check->left_count == 0 )
        rf_print( "%d frame%s in %s: all there, whole and of this render\n", job->frame_count, job->frame_count == 1 ? "" : "s",
                  job->options.output );
    if ( prints && ranges->list != NULL )
        rf_print_ranges( ranges );
    RfResult result = json != NULL ? rf_write_json( json, state_json( job, check, ranges ), error ) : rf_flush_output( error );
    return result == RF_OK && check->left_count > 0 ? fail_incomplete( job, check, error ) : result;
}

RfResult rf_check_render( RfRenderJob* job, RfError* error )
{
    Check check;
    RfRanges ranges = { 0 };
    RfResult result = RF_OK;
    if ( !create( job->frame_count, &check ) )
        result = rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %d frames", job->frame_count );
    if ( result == RF_OK )
        result = look_at_all( job, &check, error );
    RfDividedFrames frames = {
        check.left, check.left_eyes, check.left_count, job->path.step, job->path.run_count, job->path.runs
    };
    if ( result == RF_OK && job->options.nodes > 0 && check.left_count > 0 )
        result = rf_cut_ranges( job->options.nodes, &frames, &job->options.settings, &ranges, error );
    if ( result == RF_OK )
        result = report_result( job, &check, &ranges, error );
    rf_free_ranges( &ranges );
    destroy( &check );
    return result;
}

// The frames of an older JSON, read in one pass: they are in ascending order.
typedef struct Older
{
    json_t* json; // or NULL
    const json_t* frames;
    size_t next;
} Older;

// Equal up to the last of six digits; two unknown values are equal too.
static bool is_same( double a, double b )
{
    return isnan( a ) || isnan( b ) ? isnan( a ) && isnan( b ) : fabs( a - b ) <= 1e-5 * fabs( b );
}

// The row of the older JSON that describes this very file, or NULL. If the file was replaced since,
// samples or estimate differ.
static const json_t* older_row( Older* older, const RfFrameResult* said, int number )
{
    size_t all = json_array_size( older->frames );
    while ( older->next < all && isless( rf_json_number_of( json_array_get( older->frames, older->next ), "frame" ), number ) )
        ++older->next;
    const json_t* row = json_array_get( older->frames, older->next );
    bool is_it = rf_json_number_of( row, "frame" ) == number &&
                 is_same( rf_json_number_of( row, "relmse_estimate" ), said->relmse_estimate ) &&
                 is_same( rf_json_number_of( row, "native_spp" ), said->native_spp );
    return is_it ? row : NULL;
}

static json_t* kept_frame_json( const RfRenderJob* job, int frame, Older* older )
{
    char name[RF_FILE_NAME_SIZE] = "", text[8];
    int number = rf_frame_number( &job->path, frame );
    rf_sequence_name( job->options.output, number, name, sizeof name, NULL );
    RfFrameResult said = {
        .frame = frame,
        .relmse_is_lower_bound = rf_read_exr_string( name, "reframe/relmse-is-lower-bound", text, sizeof text, NULL ) == RF_OK,
        .relmse_likely = rf_read_exr_number( name, "reframe/relmse-likely" ),
        .worst_ten_share = rf_read_exr_number( name, "reframe/worst-ten-share" ),
        .reached = rf_read_exr_string( name, "reframe/reached", text, sizeof text, NULL ) == RF_OK && text[0] == 'y',
        .relmse_estimate = rf_read_exr_number( name, "reframe/relmse-estimate" ),
        .flicker_estimate = rf_read_exr_number( name, "reframe/flicker-estimate" ),
        .flicker_is_lower_bound = rf_read_exr_string( name, "reframe/flicker-is-lower-bound", text, sizeof text, NULL ) == RF_OK,
        .flicker_likely = rf_read_exr_number( name, "reframe/flicker-likely" ),
        .flicker_worst_ten_share = rf_read_exr_number( name, "reframe/flicker-worst-ten-share" ),
        .native_spp = rf_read_exr_number( name, "reframe/native-spp" ),
        .effective_spp = rf_read_exr_number( name, "reframe/effective-spp" ),
        .clamp = rf_read_exr_number( name, "reframe/clamp-threshold" ),
        .clamp_chains = rf_read_exr_number( name, "reframe/clamp-threshold-chains" ),
        .removed = rf_read_exr_number( name, "reframe/removed-share" ),
    };
    const RfDenoised denoised = { .noisy = (double)NAN,
                                  .denoised = { .relmse = rf_read_exr_number( name, "reframe/denoised-relmse" ),
                                                .low = rf_read_exr_number( name, "reframe/denoised-relmse-low" ),
                                                .high = rf_read_exr_number( name, "reframe/denoised-relmse-high" ) } };
    said.removes = isfinite( said.removed );
    said.denoised = job->options.denoise ? &denoised : NULL;
    const json_t *row = older_row( older, &said, number ), *specks = json_object_get( row, "specks" );
    said.seconds = rf_json_number_of( row, "seconds" );
    json_t* json = rf_frame_json( &said, &job->scene, &job->path, &job->options.settings, -1 );
    json_object_set_new( json, "specks", specks != NULL ? json_deep_copy( specks ) : json_null() );
    json_object_set_new( json, "kept", json_true() );
    rf_add_clipped( job->options.output, number, json );
    return json;
}

json_t* rf_join_kept_frames( const RfRenderJob* job )
{
    json_t *frames = json_array(), *rendered = job->frames_json;
    Older older = { 0 };
    size_t next = 0, all = json_array_size( rendered );
    if ( job->kept_count > 0 && rf_load_render_json( job->options.json, "--json", &older.json, NULL ) == RF_OK )
        older.frames = json_object_get( older.json, "frames" );
    for ( int i = 0; i < job->kept_count; ++i )
    {
        int number = rf_frame_number( &job->path, job->kept[i] );
        while ( next < all && isless( rf_json_number_of( json_array_get( rendered, next ), "frame" ), number ) )
            json_array_append( frames, json_array_get( rendered, next++ ) );
        json_array_append_new( frames, kept_frame_json( job, job->kept[i], &older ) );
    }
    while ( next < all )
        json_array_append( frames, json_array_get( rendered, next++ ) );
    json_decref( older.json );
    return frames;
}

// "--spp 28 (here 56), --seed 1 (here 2)"; empty where no setting differs.
static void format_differences( const RfOutput* output, int frame, char* text, size_t size )
{
    static const char* const facts[] = { "version", "pictures", "frame", "frames" }; // no options, or not in this sense
    static const char* const words[] = { "version", "version of the pictures", "frame", "frames in the path" };
    RfFrameDifference list[RF_MAX_DIFFERENCES];
    int count = rf_list_frame_differences( output, frame, list );
    text[0] = '\0';
    for ( int i = 0; i < count; ++i )
    {
        char option[48];
        snprintf( option, sizeof option, "--%s", list[i].name );
        for ( size_t k = 0; k < sizeof facts / sizeof facts[0]; ++k )
        {
            if ( strcmp( list[i].name, facts[k] ) == 0 )
                snprintf( option, sizeof option, "%s", words[k] );
        }
        rf_append( text, size, "%s%s %s (here %s)", i > 0 ? ", " : "", option, list[i].there, list[i].here );
    }
}

static RfResult refuse_other( const RfOutput* output, int frame, const char* name, RfError* error )
{
    char differences[512];
    format_differences( output, frame, differences, sizeof differences );
    if ( differences[0] != '\0' )
        return rf_fail( error, RF_ERROR_IO,
                        "--resume: %.300s: is of another render, of %s: give the same, or add --overwrite to replace such frames",
                        name, differences );
    return rf_fail( error, RF_ERROR_IO,
                    "--resume: %s: was rendered with these settings, but from another scene or camera path, or one that has "
                    "changed since, or with another --fps, --animation, --variant or --freeze: give those, or add --overwrite to "
                    "replace such frames",
                    name );
}

static RfResult refuse( RfFrameFileState state, const RfRenderOptions* options, const RfOutput* output, int frame,
                        const char* name, const RfError* reason, RfError* error )
{
    if ( !options->resume )
        return rf_fail( error, RF_ERROR_IO, "%s: already exists: --resume continues, --overwrite replaces", name );
    if ( state == RF_FRAME_FILE_UNREADABLE )
        return rf_fail( error, RF_ERROR_IO, "--resume: not a frame of this render, add --overwrite to replace it: %.900s",
                        reason->text );
    return refuse_other( output, frame, name, error );
}

// Why a file that is there may not be replaced.
static RfResult refuse_state( RfFrameFileState state, const RfRenderOptions* options, const RfOutput* output, int frame,
                              RfError* error )
{
    char name[MAX_NAME];
    RfError reason = { 0 };
    RfResult result = rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, error );
    if ( result == RF_OK && state == RF_FRAME_FILE_UNREADABLE )
        result = rf_check_frame_file( output, frame, &state, &reason ); // for the reason
    return result == RF_OK ? refuse( state, options, output, frame, name, &reason, error ) : result;
}

// Of damaged frames, which hold nothing that is to be kept.
static void warn_of_damaged( const RfOutput* output, int* damaged, int count, RfLog* log )
{
    char frames[MOST_TEXT];
    RfError reason = { 0 };
    RfFrameFileState state;
    if ( count == 0 || rf_check_frame_file( output, damaged[0], &state, &reason ) != RF_OK )
        return;
    for ( int i = 0; i < count; ++i )
        damaged[i] = rf_frame_number( output->path, damaged[i] );
    rf_format_frames( damaged, count, frames, sizeof frames );
    rf_warn( log, "--resume: damaged, rendered again: %s: %.800s", frames, reason.text );
}

// The folder is there, or is made, and files can be made in it.
static RfResult prepare_folder( const char* pattern, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_prepare_output_folder( pattern, &reason );
    if ( result == RF_ERROR_IO )
        return rf_fail( error, result, "%.900s: say with -o where the frames go", reason.text );
    return result == RF_OK ? RF_OK : rf_fail( error, result, "--output: %.1000s", reason.text );
}

RfResult rf_prepare_output( const RfOutput* output, const RfRenderOptions* options, int* frames, int* count, int* kept,
                            RfLog* log, RfError* error )
{
    RfResult result = RF_OK;
    if ( *count > 1 && !rf_is_sequence( output->pattern ) )
        result = rf_fail( error, RF_ERROR_USAGE, "--output: '%s' has no #### for the number, but %d frames are asked for",
                          output->pattern, *count );
    if ( result == RF_OK )
        result = prepare_folder( output->pattern, error );
    size_t room = (size_t)*count;
    RfFrameFileState* states = malloc( room * sizeof *states );
    int *damaged = malloc( room * sizeof *damaged ), left = 0, damaged_count = 0;
    if ( result == RF_OK && ( states == NULL || damaged == NULL ) )
        result = rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %d frames", *count );
    if ( result == RF_OK )
        result = look_at_files( output, frames, *count, options->resume, states, error );
    for ( int i = 0; i < *count && result == RF_OK; ++i )
    {
        bool may_replace = states[i] == RF_FRAME_FILE_MISSING || states[i] == RF_FRAME_FILE_DAMAGED || options->overwrite;
        int frame = frames[i];
        if ( states[i] == RF_FRAME_FILE_DAMAGED )
            damaged[damaged_count++] = frame;
        if ( states[i] == RF_FRAME_FILE_SAME )
            kept[i - left] = frame;
        else if ( may_replace )
            frames[left++] = frame;
        else
            result = refuse_state( states[i], options, output, frame, error );
    }
    if ( result == RF_OK )
        warn_of_damaged( output, damaged, damaged_count, log );
    free( states );
    free( damaged );
    *count = result == RF_OK ? left : *count;
    return result;
}

RfResult rf_find_films( RfFramesLeft* left, const RfRenderOptions* options, RfLog* log, FILE** films, RfError* error )
{
    char name[RF_FILMS_NAME_SIZE];
    RfError reason = { 0 };
    RfFilmsState state = rf_open_films_file( left, films, &reason );
    if ( state == RF_FILMS_MISSING || ( state == RF_FILMS_SAME && options->resume ) )
        return RF_OK;
    if ( *films != NULL )
        fclose( *films );
    *films = NULL;
    if ( options->resume && state == RF_FILMS_OTHER_FRAMES ) // of a range that was cut anew
        rf_warn( log, "--resume: %.900s: not used", reason.text );
    if ( options->overwrite || ( options->resume && state == RF_FILMS_OTHER_FRAMES ) )
        return RF_OK;
    RF_TRY( rf_films_file_name( left->output, left->frames[0], name, error ) );
    if ( !options->resume )
        return rf_fail( error, RF_ERROR_IO,
                        "%s: films of an interrupted render exist: --resume continues from them, --overwrite "
                        "starts over",
                        name );
    return rf_fail( error, RF_ERROR_IO, "--resume: %.900s: %sadd --overwrite to start over", reason.text,
                    state == RF_FILMS_OTHER ? "give the same, or " : "" );
}
