// What is made of the options of `reframe render`.
#include "cli/options/render_options.h"

#include "base/try.h"
#include "base/words.h"
#include "cli/options/shared_options.h"
#include "image/colour.h"
#include "image/exr.h"
#include "output/names.h"
#include "render/estimator.h"
#include "scene/light_groups.h"
#include "scene_file/scene_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_KEYS 64

// The key of an option in a file. Names have at most 30 characters.
static const char* key_of( const RfOption* option, char key[32] )
{
    snprintf( key, 32, "%s", option->name );
    for ( char* c = key; *c != 0; ++c )
        *c = *c == '-' ? '_' : *c;
    return key;
}

// A number as it would be written on the command line.
static bool print_number( const json_t* json, char* text, size_t size )
{
    int64_t whole;
    if ( rf_json_integer( json, &whole ) )
        snprintf( text, size, "%lld", (long long)whole );
    else if ( json_is_real( json ) )
        snprintf( text, size, "%.9g", json_real_value( json ) );
    else
        return false;
    return true;
}

static bool print_size( const json_t* json, char* text, size_t size )
{
    char side[2][32];
    if ( json_array_size( json ) != 2 || !print_number( json_array_get( json, 0 ), side[0], sizeof side[0] ) ||
         !print_number( json_array_get( json, 1 ), side[1], sizeof side[1] ) )
        return false;
    snprintf( text, size, "%sx%s", side[0], side[1] );
    return true;
}

static bool is_same( const char* text, const char* word ) { return word != NULL && strcmp( text, word ) == 0; }

// The value as it would be written on the command line; NULL where its JSON type is wrong.
static const char* to_text( const RfOption* option, const json_t* json, char* text, size_t size )
{
    const char* string = json_string_value( json );
    switch ( option->type )
    {
        case RF_OPTION_INT:
        case RF_OPTION_REAL:
            if ( string != NULL && ( is_same( string, option->keyword ) || is_same( string, option->negated ) ) )
                return string;
            return print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_NOISE:
        case RF_OPTION_FLICKER:
            if ( string != NULL && strchr( string, '%' ) != NULL )
                return string;
            return print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_UINT64:
        case RF_OPTION_TIME: return print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_SIZE: return print_size( json, text, size ) ? text : NULL;
        case RF_OPTION_FPS: return string != NULL ? string : print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_CHOICE: return json_is_true( json ) ? option->bare : json_is_false( json ) ? option->negated : string;
        case RF_OPTION_MEMORY:
        case RF_OPTION_STRING: return string;
        case RF_OPTION_BOOL: return NULL;
    }
    return NULL;
}

static RfResult take( const RfOption* option, const RfField* field )
{
    if ( option->type == RF_OPTION_BOOL )
        return rf_field_bool( field, option->value );
    char buffer[80], want[256] = "", side[2][32];
    const char* text = to_text( option, field->json, buffer, sizeof buffer );
    if ( text != NULL && rf_parse_option_value( option, text, NULL ) == RF_OK )
        return RF_OK;
    rf_describe_wanted( option, true, want, sizeof want );
    if ( option->type != RF_OPTION_SIZE || text == NULL )
        return rf_field_must_be( field, want );
    for ( size_t i = 0; i < 2; ++i ) // two numbers
        print_number( json_array_get( field->json, i ), side[i], sizeof side[i] );
    return rf_field_fail( field, "must be %s, got [%s, %s]", want, side[0], side[1] );
}

RfResult rf_fail_file_option( const RfField* field, const RfError* error )
{
    const char* rest = strncmp( error->text, "--", 2 ) == 0 ? strstr( error->text, ": " ) : NULL;
    return rf_field_fail( field, "%s", rest != NULL ? rest + 2 : error->text );
}

// Stores the members of the object in the values of the table's options. A key is
// the name of an option that a file may give (`in_file`), with '_' for '-'. Numbers
// and booleans are those of JSON, also for choices that can be given as --name and --no-name; a size is an array of two numbers, fps a number or
// "24000/1001", all else a string. Ranges are those of the command line; errors name
// the JSON path. Strings point into the JSON.
static RfResult take_file_options( const RfCommandTable* table, const RfField* object )
{
    char names[MAX_KEYS][32];
    const char* keys[MAX_KEYS + 1] = { NULL };
    const RfOption* options[MAX_KEYS];
    int count = 0;
    for ( int i = 0; i < table->option_count; ++i )
    {
        if ( !table->options[i].in_file )
            continue;
        if ( count == MAX_KEYS )
            return rf_field_fail( object, "the table of options has more than %d keys for files", MAX_KEYS );
        keys[count] = key_of( table->options + i, names[count] );
        options[count++] = table->options + i;
    }
    if ( object->json == NULL )
        return RF_OK;
    RfResult result = rf_field_keys( object, keys );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        RfField field = rf_field_member( object, keys[i] );
        if ( field.json != NULL )
            result = take( options[i], &field );
    }
    return result;
}

int* rf_runs_of_frames( const RfCameraPath* path, const int* frames, int frame_count, int* run_count )
{
    int* runs = malloc( ( (size_t)frame_count + 1 ) * sizeof *runs );
    *run_count = 0;
    for ( int i = 0; i < frame_count && runs != NULL; ++i )
    {
        int run = path->run_of_frame[frames[i]];
        if ( *run_count == 0 || runs[*run_count - 1] != run )
            runs[( *run_count )++] = run;
    }
    return runs;
}

#define LITTLE_LIGHT 0.0005 // of all: JSON and headers alone say it

void rf_take_scene_depth( RfRenderOptions* options, const RfScene* scene )
{
    int* depth = &options->settings.max_depth;
    options->depth_of_scene = *depth == 0 && scene->max_depth > 0;
    if ( *depth == 0 )
        *depth = scene->max_depth > 0 ? scene->max_depth : RF_MAX_DEPTH;
}

RfResult rf_warn_of_depth( const RfShot* shot, const RfRenderOptions* options, RfLog* log, double* share, RfError* error )
{
    bool scenes = options->depth_of_scene;
    RfResult result = rf_find_light_beyond_depth( shot, &options->settings, share, error );
    if ( result == RF_OK && *share >= LITTLE_LIGHT )
        rf_warn( log, "%s %d: about %.2g %% of the light is beyond and missing: %s", scenes ? "max depth" : "--max-depth",
                 options->settings.max_depth, 100.0 * *share,
                 scenes ? "--max-depth none renders it" : "raise it, or leave it out" );
    return result;
}

// What a parse has found so far. Every parse starts from the defaults; the result is copied out.
typedef struct RenderParse
{
    RfRenderOptions options;
    const char* compression; // NULL: the default
    bool is_float, is_float_given, is_half_given;
} RenderParse;

_Static_assert( sizeof( RfWeights ) == sizeof( int ) && sizeof( RfColourSpace ) == sizeof( int ), "RF_ENUM" );

static bool parse_number( const char* text, const char* end, double* number )
{
    char* stop;
    *number = strtod( text, &stop );
    return stop == end && stop > text && isfinite( *number ) != 0;
}

static bool parse_shutter( const char* text, double shutter[2] )
{
    const char *end = text + strlen( text ), *comma = strchr( text, ',' );
    double length;
    if ( comma != NULL )
        return parse_number( text, comma, shutter ) && parse_number( comma + 1, end, shutter + 1 ) && shutter[0] <= shutter[1] &&
               shutter[0] >= -RF_MAX_SHUTTER && shutter[1] <= RF_MAX_SHUTTER;
    if ( !parse_number( text, end, &length ) || length < 0.0 || length > RF_MAX_SHUTTER )
        return false;
    shutter[0] = -0.5 * length;
    shutter[1] = 0.5 * length;
    return true;
}

static RfResult parse_overscan( const char* text, RfOverscan* overscan, RfError* error )
{
    size_t length = strlen( text );
    overscan->relative = length > 0 && text[length - 1] == '%';
    bool right = parse_number( text, text + length - overscan->relative, &overscan->size ) && overscan->size >= 0.0 &&
                 overscan->size <= ( overscan->relative ? 100.0 : RF_MAX_IMAGE_SIDE ) &&
                 ( overscan->relative || overscan->size == floor( overscan->size ) );
    overscan->size *= overscan->relative ? 0.01 : 1.0;
    return right
               ? RF_OK
               : rf_fail( error, RF_ERROR_USAGE,
                          "--overscan: expected pixels on each side, as 32, or a share of the picture from 0%% to 100%%, as 5%%, "
                          "got '%.80s'",
                          text );
}

static RfResult parse_lens( const RfRenderOptions* options, RfLens* lens, RfError* error )
{
    *lens = ( RfLens ){ .has_shutter = options->shutter != NULL,
                        .has_fstop = options->fstop_given,
                        .fstop = options->fstop,
                        .blur_steps = options->blur_steps };
    if ( options->shutter != NULL && !parse_shutter( options->shutter, lens->shutter ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "--shutter %.80s: expected frames, 0 to %g, as 0.5, or when it opens and closes, as -0.25,0.25",
                        options->shutter, RF_MAX_SHUTTER );
    if ( options->focus == NULL )
        return RF_OK;
    bool number = parse_number( options->focus, options->focus + strlen( options->focus ), &lens->focus );
    if ( number && !( lens->focus > 0.0 && lens->focus <= RF_MAX_FOCUS ) )
        return rf_fail( error, RF_ERROR_USAGE, "--focus %.80s: expected metres above 0, or the name of a node", options->focus );
    if ( !number )
        lens->focus = 0.0;
    lens->focus_node = number ? NULL : options->focus;
    return RF_OK;
}

RfResult rf_parse_path_options( const RfRenderOptions* options, RfLens* lens, RfPathOptions* path, RfError* error )
{
    *path = ( RfPathOptions ){
        .camera = options->camera, .lens = lens, .fps = options->fps, .width = options->size.width, .height = options->size.height
    };
    RfResult result = parse_lens( options, lens, error );
    return result == RF_OK && options->overscan != NULL ? parse_overscan( options->overscan, &path->overscan, error ) : result;
}

static void warn_of_aspect( const RfCameraPath* path, RfLog* log )
{
    int width = path->eyes->width - 2 * path->overscan[0], height = path->eyes->height - 2 * path->overscan[1];
    double aspect = path->unmet_aspect, fit = fmax( round( height * aspect ), 1.0 );
    if ( aspect > 0.0 )
        rf_warn(
            log,
            "camera '%.60s' is for pictures of an aspect ratio of %.4g, and %dx%d has %.4g: %s is kept, and the sides show %s "
            "(--size %.0fx%d has the camera's)",
            path->name, aspect, width, height, (double)width / height,
            path->eyes->projection == RF_ORTHOGRAPHIC ? "ymag" : "the vertical field of view",
            (double)width / height > aspect ? "more" : "less", fit, height );
}

RfResult rf_create_asked_path( const RfRenderOptions* options, const RfScene* scene, RfCameraPath* path, RfLog* log,
                               RfError* error )
{
    RfLens lens;
    RfPathOptions asked;
    RfResult result = rf_parse_path_options( options, &lens, &asked, error );
    if ( result == RF_OK )
        result = rf_create_camera_path( scene, &asked, path, error );
    if ( result == RF_OK )
        warn_of_aspect( path, log );
    return result;
}

const char* const rf_effects_words[] = { "auto", "all", NULL };

// What decides on effects that cannot be left out of a scene, and what to type instead.
typedef struct Instead
{
    const char* option;
    const char* type;
} Instead;

static const Instead s_instead[RF_EFFECT_COUNT] = {
    [RF_EFFECT_CAMERA_ANIMATION] = { NULL, "render a still with --frames 1" },
    [RF_EFFECT_MOVING] = { NULL, "give --freeze" },
    [RF_EFFECT_SMOOTH_GLOSS] = { NULL, "give --no-effect chains" },
    [RF_EFFECT_LIGHT_PATHS] = { "--light-paths", "give --light-paths off" },
    [RF_EFFECT_FRAME_GROUPS] = { "--group", "give --group 0" },
    [RF_EFFECT_TILE_CONNECTIONS] = { "--tile", "give --tile 1" },
    [RF_EFFECT_ADAPTIVE] = { "--adaptive", "give --no-adaptive" },
    [RF_EFFECT_STOP_RULE] = { "--noise, --flicker, --time", "leave --noise, --flicker and --time out" },
    [RF_EFFECT_PIXEL_FILTER] = { "--filter", "give --filter box" },
    [RF_EFFECT_OTHER_PROJECTION] = { NULL, "render with a perspective camera" },
    [RF_EFFECT_GRADIENTS] = { "--estimator", "give --estimator reuse" },
};

const char* rf_effect_option( RfEffectId effect ) { return s_instead[effect].option; }

// Sets options->left_out from --no-effect. Fails with RF_ERROR_USAGE.
static RfResult parse_effect_options( RfRenderOptions* options, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_parse_effects( options->no_effect, &options->left_out, &reason );
    if ( result != RF_OK )
        return rf_fail( error, result, "--no-effect: %.1000s", reason.text );
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        RfEffectId id = (RfEffectId)i;
        if ( ( options->left_out & RF_EFFECT_BIT( i ) ) == 0 || rf_effect_without( id ) != RF_WITHOUT_IMPOSSIBLE )
            continue;
        return rf_fail( error, RF_ERROR_USAGE, "--no-effect: %s cannot be left out of a scene: %s", rf_effect_name( id ),
                        s_instead[i].type != NULL ? s_instead[i].type : rf_effect_without_text( id ) );
    }
    return RF_OK;
}

// Options may call for a lens where no camera of the scene does.
static bool may_be_called_for( const RfEffect* row )
{
    return row->on || row->id == RF_EFFECT_DEPTH_OF_FIELD || row->id == RF_EFFECT_MOTION_BLUR;
}

static void warn_of( const RfEffect* row, RfLog* log )
{
    const char* text = rf_effect_without_text( row->id );
    if ( !may_be_called_for( row ) )
        rf_warn( log, "--no-effect %s: changes nothing: %s", row->name, row->why );
    else if ( rf_effect_without( row->id ) == RF_WITHOUT_OTHER_PICTURE )
        rf_warn( log, "--no-effect %s: changes the picture: %s", row->name, text );
    else
        rf_warn( log, "--no-effect %s: changes only the noise: %s", row->name, text );
}

RfResult rf_take_effect_options( const RfRenderOptions* options, RfScene* scene, RfLog* log, RfError* error )
{
    RfEffect rows[RF_MAX_EFFECTS];
    RfRenderOptions parsed = *options;
    RF_TRY( parse_effect_options( &parsed, error ) );
    uint64_t forced = options->effects == RF_EFFECTS_ALL ? rf_forcible_effects() & ~parsed.left_out : 0;
    int count = parsed.left_out != 0 ? rf_list_render_effects( scene, NULL, 0, &options->settings, rows ) : 0;
    RfResult result = rf_choose_effects( scene, forced, parsed.left_out, error );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        if ( ( parsed.left_out & RF_EFFECT_BIT( rows[i].id ) ) != 0 )
            warn_of( rows + i, log );
    }
    return result;
}

static const char* const s_files[] = { "SCENE" };

static RenderParse render_parse;

static const RfOption s_options[] = {
    RF_TEXT_OPTION(
        "output", &render_parse.options.output, "PATTERN",
        "output files, such as out/frame.####.exr; #### (or %04d) is the frame number; the folder is created if missing",
        .writes = "", .letter = 'o' ),
    RF_PATH_OPTIONS(
        render_parse.options,
        "frame numbers follow Blender's, else start at 1; negative ones count from the end, with @ they are the path's own: "
        "@-3-3" ),
    RF_LENS_OPTIONS( render_parse.options ),
    RF_MOVEMENT_OPTIONS( render_parse.options ),
    RF_STOP_OPTIONS(
        render_parse.options,
        "render each frame until its estimated relMSE is at most E, or the noise of a channel in percent: 5.8% is relMSE 0.01; "
        "with --denoise, that of the denoised picture",
        "render until the estimated flicker of each pair of neighbouring frames is at most F, as a relative F1 or in percent "
        "(reframe flicker)",
        "average time per frame: seconds, or 20s, 5m, 1h30m; with --noise or --flicker, whichever is reached first" ),
    RF_ADAPTIVE_OPTION( render_parse.options,
                        "extra samples where other frames contribute few: borders, disocclusions, mirrors, glass; "
                        "auto: only in frames where they pay off" ),
    RF_CLAMP_OPTION( render_parse.options,
                     "against white specks: limit the luminance that one indirect path brings, and report the light removed; "
                     "auto: the limit of least error, which grows with the samples" ),
    RF_CHOICE_OPTION( "light-paths", RF_ENUM( &render_parse.options.settings.light_paths ), rf_light_paths_words,
                      "trace paths from the lights, for caustics and lamps behind glass", .in_file = true,
                      .heading = RF_HEADING_QUALITY ),
    RF_FILTER_OPTIONS( render_parse.options ),
    RF_PATH_TRACING_OPTIONS( render_parse.options ),
    RF_SEED_OPTION( render_parse.options ),
    RF_AOV_OPTION( render_parse.options, "additional layers:" ),
    RF_CRYPTOMATTE_OPTION( render_parse.options, "write Cryptomatte of these kinds:" ),
    RF_LIGHT_GROUPS_OPTION( render_parse.options, "the light of each group as a layer light_NAME, which add up to the picture:" ),
    RF_FLAG_OPTION( "alpha", &render_parse.options.alpha,
                    "write RGBA: alpha is the coverage by anything but sky, colour is premultiplied; on if the scene asks for it",
                    .in_file = true, .given = &render_parse.options.alpha_given, .heading = RF_HEADING_PASSES ),
    RF_FLAG_OPTION(
        "denoise", &render_parse.options.denoise,
        "denoise each frame by Open Image Denoise, tell the error that is left, and keep the picture before as the layer "
        "noisy; by default with --filter box, --tile rooks16 and --aov denoise_albedo,denoise_normal,half",
        .in_file = true, .heading = RF_HEADING_QUALITY ),
    RF_TEXT_OPTION(
        "compression", &render_parse.compression, "zip|zips|piz|none|dwaa|dwab",
        "compression of the EXR files; dwaa and dwab change colours a little and keep the rest; dwaa:45 sets the level, of "
        "which higher is smaller and coarser; with --float they need --parts each",
        .default_text = "zip", .heading = RF_HEADING_OUTPUT ),
    RF_CHOICE_OPTION( "parts", RF_ENUM( &render_parse.options.settings.files.parts ), rf_parts_words,
                      "one part of the EXR files for all channels, or a part for each pass, that of the colour first",
                      .heading = RF_HEADING_OUTPUT ),
    RF_CHOICE_OPTION( "names", RF_ENUM( &render_parse.options.settings.files.names ), rf_pass_names_words,
                      "names of the channels, with the conventions of the program for motion and normals",
                      .heading = RF_HEADING_OUTPUT ),
    RF_TEXT_OPTION(
        "timecode", &render_parse.options.settings.files.time_code, "HH:MM:SS:FF",
        "time code of the first frame of the camera path; HH:MM:SS;FF: drop frame, at 29.97 and 59.94 frames per second",
        .default_text = "frame 0 is 00:00:00:00", .heading = RF_HEADING_OUTPUT ),
    RF_CHOICE_OPTION( "colorspace", RF_ENUM( &render_parse.options.settings.files.colour_space ), rf_colour_space_words,
                      "linear colour space of the colours in the files, in the attribute chromaticities too", .in_file = true,
                      .heading = RF_HEADING_OUTPUT ),
    RF_FLAG_OPTION( "half", &render_parse.options.settings.files.half,
                    "16-bit floats for colour and for AOVs that do not need 32", .given = &render_parse.is_half_given,
                    .heading = RF_HEADING_OUTPUT ),
    RF_FLAG_OPTION( "float", &render_parse.is_float, "32-bit floats for all channels", .given = &render_parse.is_float_given,
                    .heading = RF_HEADING_OUTPUT ),
    RF_TEXT_OPTION(
        "preview", &render_parse.options.preview, "FILE.png|PORT",
        "show the frame in work from its first pass on: in a file, or with all frames on a page at http://127.0.0.1:PORT/",
        .writes = ".png", .heading = RF_HEADING_OUTPUT ),
    RF_TIME_OPTION(
        "autosave", &render_parse.options.autosave, 0, RF_MAX_TIME, "T",
        "save the films of frames in work this often, for --resume after a crash or power cut: seconds, or 20s, 5m, 1h30m; "
        "0: never; more seldom where writing would take more than 1% of the time",
        .in_file = true, .default_text = "5m", .heading = RF_HEADING_OUTPUT ),
    RF_FLAG_OPTION(
        "resume", &render_parse.options.resume,
        "keep finished frames of the same render, and go on from the films of those in work; other existing files are an error",
        .heading = RF_HEADING_OUTPUT ),
    RF_FLAG_OPTION( "overwrite", &render_parse.options.overwrite,
                    "replace existing frames; with --resume, only those of another render", .heading = RF_HEADING_OUTPUT ),
    RF_FLAG_OPTION( "check", &render_parse.options.check,
                    "render nothing; report which frames are finished, with exit status 1 unless all are",
                    .heading = RF_HEADING_OUTPUT ),
    RF_RESULT_OPTIONS( render_parse.options, "write the result as JSON, even if interrupted; - for standard output",
                       "no progress" ),
    RF_FLAG_OPTION( "verbose", &render_parse.options.verbose, "also list the effects in use", .heading = RF_HEADING_OUTPUT ),
    RF_GROUP_OPTION( render_parse.options, "share paths between 2N+1 neighbouring frames; 0: no frame reuse" ),
    RF_TILE_OPTION( render_parse.options ),
    RF_MACHINE_OPTIONS( render_parse.options, "threads; their number does not affect the pictures" ),
    RF_DENOISER_OPTION( render_parse.options.denoiser ),
    RF_NODES_OPTION( render_parse.options, "with --check: split the missing frames into ranges for N machines" ),
    RF_ESTIMATOR_OPTION( render_parse.options ),
    RF_CHOICE_OPTION(
        "reconstruction", RF_ENUM( &render_parse.options.settings.reconstruction ), rf_reconstruction_words,
        "with --estimator gradient: least squares, weighted by variance or plain; l1 (biased); none: the primal picture",
        .in_file = true, .heading = RF_HEADING_RESEARCH ),
    RF_WEIGHT_OPTIONS( render_parse.options ),
    RF_CHOICE_OPTION(
        "kernel-normalization", RF_ENUM( &render_parse.options.settings.kernel_normalization ), rf_kernel_normalization_words,
        "normalisation of connections to light paths; disc (fast) and density (photon mapping) are biased, for comparison",
        .in_file = true, .heading = RF_HEADING_RESEARCH ),
    RF_EFFECT_OPTIONS( render_parse.options ),
};

const RfCommandTable rf_render_table = { .command = "render",
                                         .summary = "Renders a camera animation to a sequence of EXR files. SCENE is a .glb, a "
                                                    ".gltf or a scene file (.json), which may set defaults of these options.",
                                         RF_TABLE_ROWS( s_files, s_options ) };

#define RF_DENOISED_ROOKS 16 // of a tile: blocks of 3x3 leave blotches
#define WRITE_QUEUE 2        // frames: one being written, one waiting
#define AUTOSAVE_SECONDS 300.0

RfDefaultTexts rf_default_texts;

// Adds what another estimator has by default, where it differs.
static void add_other( char* text, size_t size, const char* usual, const char* other, const RfEstimator* estimator )
{
    if ( strcmp( other, usual ) != 0 )
        rf_append( text, size, "; %s with --estimator %s", other, rf_estimator_name( estimator ) );
}

// That of the box; and of the filters with others, which are listed side by side.
static void print_filter_widths( char* text, size_t size )
{
    double usual = rf_default_filter_width( RF_FILTER_BOX ), before = usual;
    snprintf( text, size, "%g", usual );
    for ( int i = 0; rf_is_filter( (RfFilter)i ); ++i )
    {
        double width = rf_default_filter_width( (RfFilter)i );
        if ( width != usual && width == before )
            rf_append( text, size, " and %s", rf_filter_words[i] );
        else if ( width != usual )
            rf_append( text, size, "; %g for %s", width, rf_filter_words[i] );
        before = width;
    }
}

static void print_default_texts( const RfRenderSettings* settings )
{
    RfDefaultTexts* t = &rf_default_texts;
    const RfEstimator* estimator;
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &settings->tile, tile );
    const char* filter = rf_filter_name( settings->filter );
    snprintf( t->spp, sizeof t->spp, "%d; %d with --noise or --flicker, %d with --time", settings->spp,
              rf_default_most_spp( 1.0, 0.0 ), rf_default_most_spp( 0.0, 0.0 ) );
    snprintf( t->tile, sizeof t->tile, "%s", tile );
    snprintf( t->filter, sizeof t->filter, "%s", filter );
    for ( int i = 0; ( estimator = rf_estimator_at( i ) ) != NULL; ++i )
    {
        RfTile its = rf_default_tile( estimator );
        char other[RF_TILE_NAME_SIZE];
        rf_tile_name( &its, other );
        add_other( t->tile, sizeof t->tile, tile, other, estimator );
        add_other( t->filter, sizeof t->filter, filter, rf_filter_name( rf_default_filter( estimator ) ), estimator );
    }
    print_filter_widths( t->filter_width, sizeof t->filter_width );
}

// One of the words, those of DWA with ":LEVEL" where wanted.
static RfResult parse_compression( const char* text, RfFrameFiles* files, RfError* error )
{
    size_t length = strcspn( text, ":" );
    int c = 0;
    while ( rf_compression_words[c] != NULL &&
            ( strlen( rf_compression_words[c] ) != length || strncmp( rf_compression_words[c], text, length ) != 0 ) )
        ++c;
    bool has_level = text[length] == ':', dwa = c == RF_EXR_DWAA || c == RF_EXR_DWAB;
    double level = (double)RF_EXR_DWA_LEVEL;
    if ( rf_compression_words[c] == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--compression: expected none, zip, zips, piz, dwaa or dwab, got '%.80s'", text );
    if ( has_level && !dwa )
        return rf_fail( error, RF_ERROR_USAGE, "--compression: only dwaa and dwab have a level, got '%.80s'", text );
    if ( has_level && ( !parse_number( text + length + 1, text + strlen( text ), &level ) || level < 0.0 ||
                        level > (double)RF_EXR_MAX_DWA_LEVEL ) )
        return rf_fail( error, RF_ERROR_USAGE, "--compression: expected a level of DWA from 0 to %g, as %.*s:%g, got '%.80s'",
                        (double)RF_EXR_MAX_DWA_LEVEL, (int)length, text, (double)RF_EXR_DWA_LEVEL, text );
    files->compression = (RfExrCompression)c;
    files->dwa_level = (float)level;
    return RF_OK;
}

bool rf_is_port( const char* text, int* port )
{
    const char* digits = text + ( text[0] == ':' );
    size_t length = strspn( digits, "0123456789" );
    if ( length == 0 || length > 5 || digits[length] != '\0' )
        return false;
    *port = atoi( digits );
    return *port <= 65535;
}

static RfResult check( const RfRenderOptions* options, RfError* error )
{
    if ( options->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "-o is missing: say where the frames go, such as -o out/frame.####.exr" );
    if ( !rf_ends_with( options->output, ".exr" ) )
        return rf_fail( error, RF_ERROR_USAGE, "--output: expected a name that ends in .exr, got '%s'", options->output );
    int port;
    if ( options->preview != NULL && !rf_is_port( options->preview, &port ) && !rf_ends_with( options->preview, ".png" ) )
        return rf_fail( error, RF_ERROR_USAGE, "--preview: expected a name that ends in .png or a port from 0 to 65535, got '%s'",
                        options->preview );
    if ( render_parse.is_half_given && render_parse.is_float_given && options->settings.files.half == render_parse.is_float )
        return rf_fail( error, RF_ERROR_USAGE, "--half and --float: only one of the two" );
    if ( options->nodes > 0 && !options->check )
        return rf_fail( error, RF_ERROR_USAGE, "--nodes: needs --check; before a render use reframe tune --nodes" );
    return RF_OK;
}

RfRenderOptions rf_default_render_options( void )
{
    RfRenderOptions options = { .settings = rf_default_render_settings(), .autosave = AUTOSAVE_SECONDS };
    options.settings.files = rf_default_frame_files();
    options.settings.queue = WRITE_QUEUE;
    options.settings.max_depth = 0;
    options.filter = -1;
    options.blur_steps = RF_BLUR_STEPS;
    print_default_texts( &options.settings );
    return options;
}

static void reset( void )
{
    render_parse.options = rf_default_render_options();
    render_parse.is_float = render_parse.is_float_given = render_parse.is_half_given = false;
    render_parse.compression = NULL;
}

void rf_settle_filter( RfRenderOptions* options )
{
    bool given = options->filter >= 0;
    RfFilter usual = options->denoise ? RF_FILTER_BOX : rf_default_filter( options->settings.estimator );
    options->settings.filter = given ? (RfFilter)options->filter : usual;
}

void rf_take_estimator_option( RfRenderOptions* options )
{
    rf_use_estimator( &options->settings, rf_estimator_at( options->estimator ) );
}

RfResult rf_parse_tile_option( RfRenderOptions* options, RfError* error )
{
    if ( options->tile == NULL && options->denoise )
        options->settings.tile = ( RfTile ){ RF_TILE_ROOKS, RF_DENOISED_ROOKS, RF_DENOISED_ROOKS };
    if ( options->tile == NULL )
        return RF_OK;
    if ( rf_parse_tile( options->tile, &options->settings.tile ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE,
                    "--tile: expected auto, 1, WxH such as 3x3, or rooksN such as rooks16, of at most %d pixels, got '%s'",
                    RF_MAX_TILE_PIXELS, options->tile );
}

static RfResult parse_cryptomatte_option( RfRenderOptions* options, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_parse_cryptomatte( options->cryptomatte, &options->settings.cryptomatte, &reason );
    return result == RF_OK ? result : rf_fail( error, result, "--cryptomatte: %.1000s", reason.text );
}

static RfResult parse_aov_option( RfRenderOptions* options, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_parse_aovs( options->aov, &options->settings.aovs, &reason );
    options->settings.aovs |= options->alpha ? RF_AOV_BIT( RF_AOV_ALPHA ) : 0u;
    options->settings.aovs |= options->denoise ? RF_DENOISE_AOVS | RF_AOV_BIT( RF_AOV_HALF ) : 0u;
    return result == RF_OK ? result : rf_fail( error, result, "--aov: %.1000s", reason.text );
}

// Options whose texts have a grammar of their own, by their keys in scene files.
static const struct
{
    const char* key;
    RfResult ( *parse )( RfRenderOptions* options, RfError* error );
} s_grammars[] = { { "tile", rf_parse_tile_option },
                   { "aov", parse_aov_option },
                   { "cryptomatte", parse_cryptomatte_option },
                   { "no_effect", parse_effect_options } };

#define GRAMMARS ( sizeof s_grammars / sizeof s_grammars[0] )

RfResult rf_settle_render_options( RfRenderOptions* options, RfError* error )
{
    RfRenderSettings* settings = &options->settings;
    if ( settings->adaptive == RF_ADAPTIVE_ON && settings->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "--adaptive: needs --weights exact, not %s",
                        rf_weights_name( settings->weights ) );
    rf_take_estimator_option( options );
    rf_settle_filter( options );
    if ( !settings->estimator->has_gradients && settings->reconstruction != RF_RECONSTRUCTION_WEIGHTED )
        return rf_fail( error, RF_ERROR_USAGE, "--reconstruction: needs --estimator gradient" );
    RfResult result = RF_OK;
    for ( size_t i = 0; i < GRAMMARS && result == RF_OK; ++i )
        result = s_grammars[i].parse( options, error );
    if ( ( settings->noise > 0.0 || settings->flicker > 0.0 || settings->time > 0.0 ) && !options->spp_given )
        settings->spp = rf_default_most_spp( settings->noise, settings->flicker );
    return result;
}

// Parses on top of the current values.
static RfResult parse( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &rf_render_table, argc, argv, &render_parse.options.scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    result = check( &render_parse.options, error );
    if ( result == RF_OK && render_parse.compression != NULL )
        result = parse_compression( render_parse.compression, &render_parse.options.settings.files, error );
    if ( render_parse.is_float_given )
        render_parse.options.settings.files.half = !render_parse.is_float;
    *options = render_parse.options;
    return result == RF_OK ? rf_settle_render_options( options, error ) : result;
}

RfResult rf_parse_render_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    reset();
    return parse( argc, argv, options, help, error );
}

RfResult rf_read_render_defaults( const RfField* defaults, RfRenderOptions* options )
{
    reset();
    RfError error = { 0 };
    RfResult result = take_file_options( &rf_render_table, defaults );
    rf_take_estimator_option( &render_parse.options );
    for ( size_t i = 0; i < GRAMMARS && result == RF_OK; ++i )
    {
        RfField field = rf_field_member( defaults, s_grammars[i].key );
        if ( s_grammars[i].parse( &render_parse.options, &error ) != RF_OK )
            result = rf_fail_file_option( &field, &error );
    }
    *options = render_parse.options;
    return result;
}

RfResult rf_check_file_light_groups( const RfRenderOptions* options, const RfSceneFile* file, const RfScene* scene,
                                     RfError* error )
{
    const char* asked = options->settings.light_groups;
    RfField defaults = rf_scene_file_defaults( file, error );
    RfField field = rf_field_member( &defaults, "light_groups" );
    if ( asked == NULL || field.json == NULL || json_string_value( field.json ) != asked )
        return RF_OK;
    RfLightGroups groups;
    RfError fault = { 0 };
    RfResult result = rf_find_light_groups( scene, asked, &groups, &fault );
    if ( result == RF_OK )
        rf_destroy_light_groups( &groups );
    if ( result != RF_ERROR_USAGE )
        return result == RF_OK ? result : rf_fail( error, result, "%.1000s", fault.text );
    size_t path = strlen( scene->path ); // which the field's own error has
    bool named = strncmp( fault.text, scene->path, path ) == 0 && strncmp( fault.text + path, ": ", 2 ) == 0;
    return rf_field_fail( &field, "%.1000s", fault.text + ( named ? path + 2 : 0 ) );
}

RfResult rf_parse_render_options_over( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, RfError* error )
{
    bool help;
    RF_TRY( rf_read_render_defaults( defaults, options ) );
    return parse( argc, argv, options, &help, error );
}
