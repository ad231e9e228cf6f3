// A finished frame as an EXR file.
#include "output/frame_file.h"

#include "base/file.h"
#include "base/try.h"
#include "base/words.h"
#include "film/aov.h"
#include "film/cryptomatte.h"
#include "image/atomic_file.h"
#include "image/colour.h"
#include "image/exr.h"
#include "output/names.h"
#include "render/groups.h"
#include "scene/eye.h"
#include "scene/scene.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

// A pass: some channels of the same pixels.
typedef struct Pass
{
    const char* layer;   // its name, "depth"; NULL: the channels belong to the colour, as A does
    const char* letters; // of its channels
    const float* values; // as many floats a pixel as letters
    bool half;           // 16 bits are enough in a file
    bool zero[4];        // channels that are 0 whatever the values are
} Pass;

// The channels of all passes of a frame but R, G, B. The values stay the frame's.
typedef struct PassChannels
{
    RfExrChannel channels[RF_EXR_MAX_CHANNELS];
    char names[RF_EXR_MAX_CHANNELS][RF_PASS_CHANNEL_SIZE];
    char parts[RF_EXR_MAX_CHANNELS][RF_PASS_CHANNEL_SIZE]; // the layers that they are channels of
    int count;
} PassChannels;

static const float s_zero = 0.0f;

static RfResult add_pass( const Pass* pass, const RfFrameFiles* files, PassChannels* list, RfError* error )
{
    int letters = (int)strlen( pass->letters );
    for ( int c = 0; c < letters; ++c )
    {
        if ( list->count == RF_EXR_MAX_CHANNELS - 3 )
            return rf_fail( error, RF_ERROR_USAGE, "a frame's file cannot have more than %d channels: ask for fewer passes",
                            RF_EXR_MAX_CHANNELS );
        RfPassChannel channel;
        char *name = list->names[list->count], *part = list->parts[list->count];
        if ( pass->layer != NULL && strlen( pass->layer ) > RF_PASS_MOST )
            return rf_fail( error, RF_ERROR_USAGE, "the name of a pass is too long: '%.100s...': at most %d bytes", pass->layer,
                            RF_PASS_MOST );
        rf_name_pass_channel( files->names, pass->layer != NULL ? pass->layer : "alpha", pass->letters, c, &channel );
        strcpy( name, channel.name );
        strcpy( part, name );
        if ( pass->layer != NULL )
            *strrchr( part, '.' ) = '\0';
        bool is_colour = strncmp( pass->letters, "RGB", 3 ) == 0 && channel.component < 3,
             is_variance = pass->layer != NULL && strcmp( pass->layer, rf_aov_name( RF_AOV_VARIANCE ) ) == 0;
        bool zero = pass->zero[channel.component % 4];
        list->channels[list->count++] = ( RfExrChannel ){
            .name = name,
            .values = zero ? &s_zero : pass->values + channel.component,
            .stride = zero ? 0 : letters,
            .half = files->half && pass->half,
            .negated = channel.negated && !zero,
            .lossy = pass->half && is_colour,
            .meaning = !is_colour    ? RF_EXR_DATA
                       : is_variance ? RF_EXR_VARIANCE
                                     : RF_EXR_COLOUR,
            .component = channel.component,
            .part = files->parts == RF_PARTS_EACH && pass->layer != NULL ? part : NULL,
        };
    }
    return RF_OK;
}

// Lists them as `files` asks for. Motion to the frame before and to the frame after is 0 where `still`. Fails with
// RF_ERROR_USAGE where there are more than a file can hold.
static RfResult list_pass_channels( const RfFrameResult* frame, const RfFrameFiles* files, const bool still[2],
                                    PassChannels* list, RfError* error )
{
    RfResult result = RF_OK;
    list->count = 0;
    for ( int i = 0; i < RF_AOV_COUNT && result == RF_OK; ++i )
    {
        Pass pass = {
            .layer = i == RF_AOV_ALPHA ? NULL : rf_aov_name( (RfAov)i ),
            .letters = rf_aov_letters( (RfAov)i ),
            .values = frame->aovs[i],
            .half = rf_aov_is_half( (RfAov)i ),
        };
        for ( int c = 0; c < 4; ++c ) // motion is x and y to the frame before, then to the frame after
            pass.zero[c] = i == RF_AOV_MOTION && still[c / 2];
        if ( pass.values != NULL )
            result = add_pass( &pass, files, list, error );
    }
    for ( int i = 0; i < frame->layer_count && result == RF_OK; ++i )
    {
        const RfLayer* layer = frame->layers + i;
        const Pass pass = { .layer = layer->name, .letters = layer->letters, .values = layer->values, .half = layer->half };
        result = add_pass( &pass, files, list, error );
    }
    return result;
}

#define RF_MATTE_STRINGS ( 4 * RF_CRYPTOMATTE_KINDS )

// cryptomatte/KEY/name, hash, conversion and manifest of each kind, KEY the first seven digits of the hash of its name.
// The attributes by which compositors find a frame's Cryptomatte and the names in it (Cryptomatte Specification, "Metadata").

typedef struct MatteStrings
{
    RfExrString strings[RF_MATTE_STRINGS];
    int count;
    char names[RF_MATTE_STRINGS][40];
    char layers[RF_CRYPTOMATTE_KINDS][RF_PASS_CHANNEL_SIZE];
    char* manifests[RF_CRYPTOMATTE_KINDS];
} MatteStrings;

static void add( MatteStrings* to, uint32_t key, const char* what, const char* value )
{
    char* name = to->names[to->count];
    snprintf( name, sizeof to->names[0], "cryptomatte/%07x/%s", key, what );
    to->strings[to->count++] = ( RfExrString ){ name, value };
}

static void free_matte_strings( MatteStrings* strings )
{
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        free( strings->manifests[k] );
        strings->manifests[k] = NULL;
    }
}

// Those of the kinds that the settings ask for, which point into `strings`.
static RfResult make_matte_strings( const RfOutput* output, MatteStrings* strings, RfError* error )
{
    strings->count = 0;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
        strings->manifests[k] = NULL;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        char* layer = strings->layers[k];
        if ( ( output->settings.cryptomatte & 1u << k ) == 0 )
            continue;
        strings->manifests[k] = rf_cryptomatte_manifest( rf_tracer_scene( output->tracer ), k );
        if ( strings->manifests[k] == NULL )
        {
            free_matte_strings( strings );
            return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the names of Cryptomatte" );
        }
        rf_name_pass_layer( output->settings.files.names, g_rf_cryptomatte_kinds[k].name, layer );
        uint32_t key = rf_murmur3_32( layer ) >> 4;
        add( strings, key, "name", layer );
        add( strings, key, "hash", "MurmurHash3_32" );
        add( strings, key, "conversion", "uint32_to_float32" );
        add( strings, key, "manifest", strings->manifests[k] );
    }
    return RF_OK;
}

#define MAX_NAME 4096

#define ATTRIBUTE_SIZE RF_EFFECTS_TEXT_SIZE // the longest text that is made here

typedef struct Attributes
{
    const char* values[RF_KEY_COUNT]; // NULL: not there
    char texts[RF_KEY_COUNT][ATTRIBUTE_SIZE];
    RfExrString strings[RF_KEY_COUNT + RF_MATTE_STRINGS]; // those that are there
    int count;
} Attributes;

RfResult rf_prepare_output_folder( const char* pattern, RfError* error )
{
    char name[MAX_NAME];
    size_t length = pattern != NULL ? strlen( pattern ) : 0;
    if ( length == 0 || pattern[length - 1] == '/' )
        return rf_fail( error, RF_ERROR_USAGE, "'%s' names no file", pattern != NULL ? pattern : "" );
    RF_TRY( rf_sequence_name( pattern, 1, name, sizeof name, error ) );
    return rf_try_output_file( pattern, error );
}

void rf_clean_output_folder( const char* pattern )
{
    char folder[MAX_NAME];
    if ( rf_folder_of_file( pattern, folder, sizeof folder, NULL ) == RF_OK )
        rf_remove_leftovers( folder );
}

static uint64_t hash_text( uint64_t hash, const char* text ) { return rf_hash_bytes( hash, text, strlen( text ) + 1 ); }

// Adds a text where it is not what all frames have had since before there was such a setting: an option that is added later leaves the
// fingerprints of frames without it.
__attribute__( ( format( printf, 3, 4 ) ) ) static void add_setting( uint64_t* hash, bool is_set, const char* format, ... )
{
    char text[512];
    va_list args;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    *hash = is_set ? hash_text( *hash, text ) : *hash;
}

void rf_frame_fingerprint( const RfOutput* output, int frame, char text[RF_FINGERPRINT_SIZE] )
{
    static const int adaptive[] = { [RF_ADAPTIVE_OFF] = 0, [RF_ADAPTIVE_ON] = 1, [RF_ADAPTIVE_AUTO] = 2 };
    const RfRenderSettings* s = &output->settings;
    const RfCameraPath* path = output->path;
    const RfScene* scene = rf_tracer_scene( output->tracer );
    char tile[RF_TILE_NAME_SIZE], aovs[RF_AOVS_TEXT_SIZE], kinds[RF_CRYPTOMATTE_TEXT_SIZE];
    rf_tile_name( &s->tile, tile );
    rf_format_aovs( s->aovs, aovs, sizeof aovs );
    rf_format_cryptomatte( s->cryptomatte, kinds );
    // Numbers as text: no padding bytes, no byte order, and a new setting cannot be mistaken for an old one.
    uint64_t hash = hash_text( path->hash, rf_version() );
    add_setting(
        &hash, true,
        "pictures %d scene %016llx frame %d of %d fps %d/%d spp %d group %d weights %s normalize %s depth %d lights %d seed %llu "
        "tile %s",
        rf_pictures(), (unsigned long long)scene->content_hash, frame, path->count, path->fps.numerator, path->fps.denominator,
        s->spp, s->group, rf_weights_name( s->weights ), rf_normalize_name( s->normalize ), s->max_depth, s->light_samples,
        (unsigned long long)s->seed, tile );
    add_setting( &hash, s->noise > 0.0 || s->time > 0.0 || s->adaptive != RF_ADAPTIVE_OFF, "noise %.17g time %.17g adaptive %d",
                 s->noise, s->time, adaptive[s->adaptive] );
    add_setting( &hash, s->flicker > 0.0, "flicker %.17g", s->flicker );
    add_setting( &hash, s->guide != RF_GUIDE_AUTO, "guide %s", rf_guiding_name( s->guide ) );
    add_setting( &hash, s->clamp != 0.0, "clamp %.17g", s->clamp );
    add_setting( &hash, s->clamp_chains > 0.0, "clamp of chains %.17g", s->clamp_chains );
    add_setting( &hash, s->filter != RF_FILTER_BOX || s->filter_width != 1.0, "filter %s %.17g", rf_filter_name( s->filter ),
                 s->filter_width );
    add_setting( &hash, s->files.denoiser != NULL, "denoiser %s", s->files.denoiser != NULL ? s->files.denoiser : "" );
    add_setting( &hash, path->run_count > 0 && path->run_count < path->count, "runs %d", path->run_count );
    if ( s->aovs != 0 )
        hash = hash_text( hash, aovs );
    if ( s->cryptomatte != 0 )
        hash = hash_text( hash_text( hash, "cryptomatte" ), kinds );
    if ( s->light_groups != NULL )
        hash = hash_text( hash_text( hash, "light groups" ), s->light_groups );
    add_setting( &hash, rf_is_other_estimator( s->estimator ), "%s", rf_estimator_name( s->estimator ) );
    add_setting( &hash, s->reconstruction != RF_RECONSTRUCTION_WEIGHTED, "%s", rf_reconstruction_name( s->reconstruction ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF )
        hash = hash_text( hash_text( hash, rf_light_paths_name( s->light_paths ) ),
                          rf_kernel_normalization_name( s->kernel_normalization ) );
    add_setting( &hash, ( path->overscan[0] | path->overscan[1] ) != 0, "overscan %dx%d", path->overscan[0], path->overscan[1] );
    if ( s->files.colour_space != RF_REC709 )
        hash = hash_text( hash_text( hash, "colour space" ), rf_colour_space_words[s->files.colour_space] );
    if ( s->files.names != RF_NAMES_REFRAME ) // one sequence, one naming and one time code
        hash = hash_text( hash, rf_pass_names_words[s->files.names] );
    if ( s->files.time_code != NULL )
        hash = hash_text( hash, s->files.time_code );
    add_setting( &hash, ( scene->effects_forced | scene->effects_left_out ) != 0, "effects forced %llx without %llx",
                 (unsigned long long)scene->effects_forced, (unsigned long long)scene->effects_left_out );
    snprintf( text, RF_FINGERPRINT_SIZE, "%016llx", (unsigned long long)hash );
}

#define RF_KEY_NAME( constant, name, absent ) name,
#define RF_KEY_ABSENT( constant, name, absent ) absent,
static const char* const s_names[RF_KEY_COUNT] = { RF_KEY_LIST( RF_KEY_NAME ) };
static const char* const s_absent[RF_KEY_COUNT] = { RF_KEY_LIST( RF_KEY_ABSENT ) };

const char* rf_key_name( RfKey key ) { return s_names[key]; }

static void put_text( Attributes* a, RfKey key, const char* value ) { a->values[key] = value; }

// Nothing unless `is_set`.
__attribute__( ( format( printf, 4, 5 ) ) ) static void put_if( bool is_set, Attributes* a, RfKey key, const char* format, ... )
{
    va_list args;
    if ( !is_set )
        return;
    va_start( args, format );
    vsnprintf( a->texts[key], ATTRIBUTE_SIZE, format, args );
    va_end( args );
    a->values[key] = a->texts[key];
}

#define put( ... ) put_if( true, __VA_ARGS__ )

static void put_files( Attributes* a, const RfFrameFiles* files )
{
    if ( files->names != RF_NAMES_REFRAME )
        put_text( a, RF_KEY_NAMES, rf_pass_names_words[files->names] );
    put_text( a, RF_KEY_TIMECODE, files->time_code );
    put_text( a, RF_KEY_DENOISER, files->denoiser );
    if ( files->compression != RF_EXR_ZIP )
        put( a, RF_KEY_COMPRESSION, files->compression >= RF_EXR_DWAA ? "%s:%.9g" : "%s",
             rf_compression_words[files->compression], (double)files->dwa_level );
    if ( files->parts != RF_PARTS_ONE )
        put_text( a, RF_KEY_PARTS, rf_parts_words[files->parts] );
    put_text( a, RF_KEY_FLOAT, files->half ? NULL : "yes" );
    if ( files->colour_space != RF_REC709 )
        put_text( a, RF_KEY_COLORSPACE, rf_colour_space_words[files->colour_space] );
}

// Whether the file of a frame has the format asked for, so that no sequence is mixed.
static bool is_same_format( const RfOutput* output, const char* name )
{
    static const RfKey keys[] = { RF_KEY_COMPRESSION, RF_KEY_PARTS, RF_KEY_FLOAT };
    Attributes wanted = { .count = 0 };
    char found[64];
    bool same = true;
    put_files( &wanted, &output->settings.files );
    for ( size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i )
    {
        const char* here = wanted.values[keys[i]];
        bool is_there = rf_read_exr_string( name, s_names[keys[i]], found, sizeof found, NULL ) == RF_OK;
        same = same && is_there == ( here != NULL ) && ( here == NULL || strcmp( found, here ) == 0 );
    }
    return same;
}

RfResult rf_check_frame_file( const RfOutput* output, int frame, RfFrameFileState* state, RfError* error )
{
    char name[MAX_NAME], found[64], wanted[RF_FINGERPRINT_SIZE];
    struct stat status;
    *state = RF_FRAME_FILE_MISSING;
    RF_TRY( rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, error ) );
    if ( stat( name, &status ) != 0 )
        return errno == ENOENT ? RF_OK : rf_fail( error, RF_ERROR_IO, "%s: cannot be looked at: %s", name, strerror( errno ) );
    if ( S_ISDIR( status.st_mode ) ) // reported before the work, and no matter what may be replaced
        return rf_fail( error, RF_ERROR_IO, "%s: is a folder: choose another name", name );
    *state = RF_FRAME_FILE_UNREADABLE;
    if ( rf_read_exr_string( name, "reframe/fingerprint", found, sizeof found, error ) != RF_OK )
        return RF_OK;
    rf_frame_fingerprint( output, frame, wanted );
    *state = RF_FRAME_FILE_OTHER;
    if ( strcmp( found, wanted ) != 0 || !is_same_format( output, name ) )
        return RF_OK;
    bool same;
    RfResult result = rf_verify_exr( name, &same, error );
    *state = result == RF_OK && same ? RF_FRAME_FILE_SAME : RF_FRAME_FILE_DAMAGED;
    return result == RF_ERROR_MEMORY ? result : RF_OK;
}

static void put_settings( Attributes* a, const RfRenderSettings* s )
{
    char tile[RF_TILE_NAME_SIZE], aovs[RF_AOVS_TEXT_SIZE];
    rf_tile_name( &s->tile, tile );
    rf_format_aovs( s->aovs, aovs, sizeof aovs );
    put( a, RF_KEY_GROUP, "%d", s->group );
    put( a, RF_KEY_SPP, "%d", s->spp );
    put( a, RF_KEY_TILE, "%s", tile );
    put_text( a, RF_KEY_WEIGHTS, rf_weights_name( s->weights ) );
    put_text( a, RF_KEY_NORMALIZE, rf_normalize_name( s->normalize ) );
    put( a, RF_KEY_SEED, "%llu", (unsigned long long)s->seed );
    put_if( s->max_depth < RF_MAX_DEPTH, a, RF_KEY_MAX_DEPTH, "%d", s->max_depth );
    put( a, RF_KEY_LIGHT_SAMPLES, "%d", s->light_samples );
    if ( s->filter != RF_FILTER_BOX || s->filter_width != 1.0 )
    {
        put_text( a, RF_KEY_FILTER, rf_filter_name( s->filter ) );
        put( a, RF_KEY_FILTER_WIDTH, "%.9g", s->filter_width );
    }
    if ( s->adaptive != RF_ADAPTIVE_OFF )
        put_text( a, RF_KEY_ADAPTIVE, s->adaptive == RF_ADAPTIVE_ON ? "yes" : rf_adaptive_name( s->adaptive ) );
    if ( s->guide != RF_GUIDE_AUTO )
        put_text( a, RF_KEY_GUIDE, rf_guiding_name( s->guide ) );
    if ( s->clamp == RF_CLAMP_AUTO )
        put_text( a, RF_KEY_CLAMP, "auto" );
    else if ( s->clamp != 0.0 )
        put( a, RF_KEY_CLAMP, "%.9g", s->clamp );
    put_if( s->clamp_chains > 0.0, a, RF_KEY_CLAMP_CHAINS, "%.9g", s->clamp_chains );
    put_if( s->noise > 0.0, a, RF_KEY_NOISE, "%.9g", s->noise );
    put_if( s->flicker > 0.0, a, RF_KEY_FLICKER, "%.9g", s->flicker );
    put_if( s->time > 0.0, a, RF_KEY_TIME, "%.9g", s->time );
    put_if( s->aovs != 0, a, RF_KEY_AOV, "%s", aovs );
    char kinds[RF_CRYPTOMATTE_TEXT_SIZE];
    rf_format_cryptomatte( s->cryptomatte, kinds );
    put_if( s->cryptomatte != 0, a, RF_KEY_CRYPTOMATTE, "%s", kinds );
    put_text( a, RF_KEY_LIGHT_GROUPS, s->light_groups );
    if ( rf_is_other_estimator( s->estimator ) )
        put_text( a, RF_KEY_ESTIMATOR, rf_estimator_name( s->estimator ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF )
        put_text( a, RF_KEY_LIGHT_PATHS, rf_light_paths_name( s->light_paths ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF && s->kernel_normalization != RF_KERNEL_EXACT )
        put_text( a, RF_KEY_KERNEL_NORMALIZATION, rf_kernel_normalization_name( s->kernel_normalization ) );
    if ( s->reconstruction != RF_RECONSTRUCTION_WEIGHTED )
        put_text( a, RF_KEY_RECONSTRUCTION, rf_reconstruction_name( s->reconstruction ) );
    put_files( a, &s->files );
}

// Of options: nothing where none was given.
static void put_effects( Attributes* a, const RfScene* scene )
{
    char names[RF_EFFECTS_TEXT_SIZE];
    rf_format_effects( scene->effects_left_out, names, sizeof names );
    put_if( scene->effects_left_out != 0, a, RF_KEY_NO_EFFECT, "%s", names );
    rf_format_effects( scene->effects_forced, names, sizeof names );
    if ( scene->effects_forced != 0 )
        put( a, RF_KEY_EFFECTS, "%s",
             ( scene->effects_forced | scene->effects_left_out ) == ( rf_forcible_effects() | scene->effects_left_out ) ? "all"
                                                                                                                        : names );
}

// The first and the last frame between two cuts; nothing where the path has none.
static void put_shot( Attributes* a, const RfCameraPath* path, int frame )
{
    int first, end;
    RfGroupPlan plan = rf_plan_shots( path->eyes, path->count, 0, 1 );
    rf_shot_of_frame( &plan, frame, &first, &end );
    put_if( end - first < path->count, a, RF_KEY_SHOT, "%d-%d", rf_frame_number( path, first ),
            rf_frame_number( path, end - 1 ) );
}

// How the scene wants its pictures to be shown.
static void put_view( Attributes* a, const RfViewText* view )
{
    if ( view->transform[0] == '\0' )
        return;
    put_text( a, RF_KEY_VIEW, view->transform );
    put_text( a, RF_KEY_LOOK, view->look[0] != '\0' ? view->look : NULL );
    put( a, RF_KEY_EXPOSURE, "%.9g", view->exposure );
    put( a, RF_KEY_GAMMA, "%.9g", view->gamma );
}

// As many as fit.
static void put_losses( Attributes* a, const RfScene* scene )
{
    char* text = a->texts[RF_KEY_LOSSES];
    for ( int i = 0; i < scene->loss_count; ++i )
        rf_append( text, ATTRIBUTE_SIZE, "%s%s", i > 0 ? "; " : "", scene->losses[i] );
    put_text( a, RF_KEY_LOSSES, scene->loss_count > 0 ? text : NULL );
}

static void put_frame( Attributes* a, const RfOutput* output, const RfFrameResult* frame )
{
    char fingerprint[RF_FINGERPRINT_SIZE];
    rf_frame_fingerprint( output, frame->frame, fingerprint );
    put_text( a, RF_KEY_VERSION, rf_version() );
    put( a, RF_KEY_PICTURES, "%d", rf_pictures() );
    put_text( a, RF_KEY_SCENE, rf_tracer_scene( output->tracer )->path );
    put_losses( a, rf_tracer_scene( output->tracer ) );
    put_text( a, RF_KEY_CAMERA, output->path->name );
    put( a, RF_KEY_FRAME, "%d", rf_frame_number( output->path, frame->frame ) );
    put( a, RF_KEY_FRAMES, "%d", output->path->count );
    put_shot( a, output->path, frame->frame );
    const int* overscan = output->path->overscan;
    put_if( ( overscan[0] | overscan[1] ) != 0, a, RF_KEY_OVERSCAN, "%dx%d", overscan[0], overscan[1] );
    put_if( output->path->step > 1, a, RF_KEY_STEP, "%d", output->path->step );
    put_if( output->path->eyes[frame->frame].blur_steps > 0, a, RF_KEY_BLUR_STEPS, "%d",
            (int)output->path->eyes[frame->frame].blur_steps );
    if ( isfinite( frame->relmse_estimate ) )
    {
        put( a, RF_KEY_RELMSE_ESTIMATE, "%.6g", frame->relmse_estimate );
        put_text( a, RF_KEY_RELMSE_IS_LOWER_BOUND, frame->relmse_is_lower_bound ? "yes" : NULL );
        put( a, RF_KEY_RELMSE_LIKELY, "%.6g", frame->relmse_likely );
        put( a, RF_KEY_WORST_TEN_SHARE, "%.6g", frame->worst_ten_share );
    }
    if ( output->settings.flicker > 0.0 && isfinite( frame->flicker_estimate ) )
    {
        put( a, RF_KEY_FLICKER_ESTIMATE, "%.6g", frame->flicker_estimate );
        put_text( a, RF_KEY_FLICKER_IS_LOWER_BOUND, frame->flicker_is_lower_bound ? "yes" : NULL );
        put( a, RF_KEY_FLICKER_LIKELY, "%.6g", frame->flicker_likely );
        put( a, RF_KEY_FLICKER_WORST_TEN_SHARE, "%.6g", frame->flicker_worst_ten_share );
    }
    if ( output->settings.clamp != 0.0 )
    {
        put( a, RF_KEY_CLAMP_THRESHOLD, "%.6g", frame->clamp );
        put( a, RF_KEY_CLAMP_THRESHOLD_CHAINS, "%.6g", frame->clamp_chains );
    }
    if ( frame->denoised != NULL && isfinite( frame->denoised->denoised.relmse ) )
    {
        put( a, RF_KEY_DENOISED_RELMSE, "%.6g", frame->denoised->denoised.relmse );
        put( a, RF_KEY_DENOISED_LOW, "%.6g", frame->denoised->denoised.low );
        put( a, RF_KEY_DENOISED_HIGH, "%.6g", frame->denoised->denoised.high );
    }
    put_if( frame->removes, a, RF_KEY_REMOVED_SHARE, "%.6g", frame->removed );
    put_if( output->beyond_depth > 0.0, a, RF_KEY_BEYOND_DEPTH_SHARE, "%.6g", output->beyond_depth );
    if ( output->settings.noise > 0.0 || output->settings.flicker > 0.0 )
        put_text( a, RF_KEY_REACHED, frame->reached ? "yes" : "no" );
    put_effects( a, rf_tracer_scene( output->tracer ) );
    put_text( a, RF_KEY_CALLS_FOR, output->calls_for );
    put( a, RF_KEY_NATIVE_SPP, "%.9g", frame->native_spp );
    put( a, RF_KEY_EFFECTIVE_SPP, "%.6g", frame->effective_spp );
    put_view( a, &rf_tracer_scene( output->tracer )->view );
    put_text( a, RF_KEY_DEVICE, rf_tracer_device( output->tracer ) );
    put( a, RF_KEY_FINGERPRINT, "%s", fingerprint );
}

// Fills `attributes` for the file of a frame. They point into `output`.
static void list_attributes( const RfOutput* output, const RfFrameResult* frame, Attributes* a )
{
    for ( int i = 0; i < RF_KEY_COUNT; ++i )
        a->values[i] = NULL;
    a->count = 0;
    put_settings( a, &output->settings );
    put_frame( a, output, frame );
    for ( int i = 0; i < RF_KEY_COUNT; ++i )
    {
        if ( a->values[i] != NULL )
            a->strings[a->count++] = ( RfExrString ){ s_names[i], a->values[i] };
    }
}

// A value as the option takes it: adaptive sampling that is on is "yes" in files.
static const char* option_value( RfKey key, const char* value )
{
    return key == RF_KEY_ADAPTIVE && strcmp( value, "yes" ) == 0 ? rf_adaptive_name( RF_ADAPTIVE_ON ) : value;
}

// What a key that is not in a file stands for.
static const char* absent_value( RfKey key )
{
    return key == RF_KEY_ESTIMATOR ? rf_estimator_name( rf_default_render_settings().estimator ) : s_absent[key];
}

static void add_difference( RfFrameDifference* list, int* count, const char* name, const char* there, const char* here )
{
    if ( *count == RF_MAX_DIFFERENCES || strcmp( there, here ) == 0 )
        return;
    RfFrameDifference* difference = list + ( *count )++;
    difference->name = name;
    snprintf( difference->there, sizeof difference->there, "%s", there );
    snprintf( difference->here, sizeof difference->here, "%s", here );
}

static void add_size( const RfOutput* output, const char* name, RfFrameDifference* list, int* count )
{
    const RfEye* eye = output->path->eyes;
    char there[32], here[32];
    RfImage image;
    if ( rf_read_exr( name, &image, NULL ) != RF_OK )
        return;
    snprintf( there, sizeof there, "%dx%d", image.width, image.height );
    snprintf( here, sizeof here, "%dx%d", eye->width, eye->height );
    rf_destroy_image( &image );
    add_difference( list, count, "size", there, here );
}

int rf_list_frame_differences( const RfOutput* output, int frame, RfFrameDifference list[RF_MAX_DIFFERENCES] )
{
    char name[MAX_NAME], there[RF_DIFFERENCE_SIZE];
    int count = 0;
    Attributes wanted;
    RfFrameResult none = { .frame = frame };
    list_attributes( output, &none, &wanted );
    if ( rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, NULL ) != RF_OK )
        return 0;
    for ( RfKey key = 0; key < RF_KEY_COUNT; ++key )
    {
        const char* here = wanted.values[key];
        if ( s_absent[key] == NULL )
            continue;
        bool is_there = rf_read_exr_string( name, s_names[key], there, sizeof there, NULL ) == RF_OK;
        if ( key == RF_KEY_BLUR_STEPS && is_there != ( here != NULL ) )
            continue; // by another shutter, or another scene
        add_difference( list, &count, s_names[key] + strlen( "reframe/" ),
                        is_there ? option_value( key, there ) : absent_value( key ),
                        here != NULL ? option_value( key, here ) : absent_value( key ) );
    }
    add_size( output, name, list, &count );
    return count;
}

bool rf_is_denoised( const char* path )
{
    char text[4];
    return rf_read_exr_string( path, s_names[RF_KEY_DENOISER], text, sizeof text, NULL ) == RF_OK;
}

RfFrameFiles rf_default_frame_files( void )
{
    return ( RfFrameFiles ){ .written = true, .half = true, .compression = RF_EXR_ZIP, .dwa_level = RF_EXR_DWA_LEVEL };
}

RfOutput rf_default_output( void ) { return ( RfOutput ){ .settings = rf_default_render_settings() }; }

// Frames of one run were rendered as one: there is no motion between them.
static bool has_same_eye( const RfCameraPath* path, int frame, int other )
{
    return path->run_of_frame != NULL && other >= 0 && other < path->count &&
           path->run_of_frame[frame] == path->run_of_frame[other];
}

RfResult rf_check_time_code( const RfOutput* output, RfError* error )
{
    RfTimeCodeRate rate;
    int64_t first;
    const char* text = output->settings.files.time_code;
    return text != NULL ? rf_parse_time_code( text, output->path->fps, &rate, &first, error ) : RF_OK;
}

#define MAX_ATTRIBUTES 2

// The time code; and where the lens is focused, as OpenEXR has it: metres.
static int list_standard_attributes( const RfOutput* output, int frame, RfExrAttribute list[MAX_ATTRIBUTES] )
{
    const RfCameraPath* path = output->path;
    const RfEye* eye = path->eyes + frame;
    RfTimeCodeRate rate = rf_time_code_rate( path->fps );
    int64_t number = rf_frame_number( path, frame ), first = 0;
    int count = 0;
    if ( output->settings.files.time_code != NULL &&
         rf_parse_time_code( output->settings.files.time_code, path->fps, &rate, &first, NULL ) == RF_OK )
        number += first - rf_frame_number( path, 0 );
    if ( rate.frames > 0 )
        list[count++] =
            ( RfExrAttribute ){ .name = "timeCode", .type = RF_EXR_TIMECODE, .timecode = { rf_pack_time_code( rate, number ) } };
    if ( eye->lens_radius > 0.0f )
        list[count++] = ( RfExrAttribute ){ .name = "focus", .type = RF_EXR_FLOAT, .values = { eye->focus } };
    return count;
}

// How many pixels are beyond the range of the file's channels, and in which layers, by their names in the file.
static void add_clipped( const RfImage* image, const RfExrOptions* exr, const PassChannels* passes, Attributes* a )
{
    bool clipped[RF_EXR_MAX_CHANNELS];
    size_t pixels = rf_count_clipped( image, exr, clipped ), used = 0;
    char* text = a->texts[RF_KEY_CLIPPED_LAYERS];
    const char* last = "";
    if ( pixels == 0 )
        return;
    for ( int i = 0; i < 3 + passes->count; ++i )
    {
        const char* layer = i < 3 ? RF_COLOUR_LAYER : passes->parts[i - 3];
        if ( !clipped[i] || strcmp( layer, last ) == 0 )
            continue;
        bool fits = used + strlen( layer ) + 5 < ATTRIBUTE_SIZE; // and "..."
        used += (size_t)snprintf( text + used, ATTRIBUTE_SIZE - used, "%s%s", used > 0 ? "," : "", fits ? layer : "..." );
        last = layer;
        if ( !fits )
            break;
    }
    put( a, RF_KEY_CLIPPED_PIXELS, "%zu", pixels );
    a->strings[a->count++] = ( RfExrString ){ s_names[RF_KEY_CLIPPED_PIXELS], a->values[RF_KEY_CLIPPED_PIXELS] };
    a->strings[a->count++] = ( RfExrString ){ s_names[RF_KEY_CLIPPED_LAYERS], text };
}

RfResult rf_write_frame( const RfOutput* output, const RfFrameResult* frame, RfError* error )
{
    char name[MAX_NAME];
    if ( !output->settings.files.written )
        return rf_fail( error, RF_ERROR_USAGE, "settings.files is not set: start from rf_default_frame_files" );
    RfResult result =
        rf_sequence_name( output->pattern, rf_frame_number( output->path, frame->frame ), name, sizeof name, error );
    if ( result == RF_OK )
        result = rf_check_time_code( output, error );
    if ( result != RF_OK )
        return result;
    Attributes attributes;
    PassChannels passes;
    list_attributes( output, frame, &attributes );
    const bool still[2] = { has_same_eye( output->path, frame->frame, frame->frame - 1 ),
                            has_same_eye( output->path, frame->frame, frame->frame + 1 ) };
    RF_TRY( list_pass_channels( frame, &output->settings.files, still, &passes, error ) );
    MatteStrings mattes;
    RF_TRY( make_matte_strings( output, &mattes, error ) );
    for ( int i = 0; i < mattes.count; ++i )
        attributes.strings[attributes.count++] = mattes.strings[i];
    RfExrOptions exr = rf_default_exr_options();
    exr.compression = output->settings.files.compression;
    exr.dwa_level = output->settings.files.dwa_level;
    exr.half = output->settings.files.half;
    exr.colour_space = output->settings.files.colour_space;
    exr.fps_numerator = output->path->fps.numerator;
    exr.fps_denominator = (unsigned int)output->path->fps.denominator;
    exr.has_camera = true;
    const int* overscan = output->path->overscan;
    RfEye eye = output->path->eyes[frame->frame]; // NDC are those of the display window
    rf_widen_eye( &eye, -overscan[0], -overscan[1] );
    exr.pixel_aspect = eye.focal / eye.focal_x;
    exr.x = -overscan[0];
    exr.y = -overscan[1];
    exr.display = ( RfExrWindow ){ 0, 0, eye.width, eye.height };
    RfExrAttribute standard[MAX_ATTRIBUTES];
    exr.attributes = standard;
    exr.attribute_count = list_standard_attributes( output, frame->frame, standard );
    rf_eye_matrices_around( &eye, output->path->origin, exr.world_to_camera, exr.world_to_ndc );
    if ( output->settings.files.names == RF_NAMES_BLENDER ||
         output->settings.files.names == RF_NAMES_BLENDER_5 ) // a layer of no name would be none
        exr.layer = exr.part = RF_BLENDER_LAYER ".Combined";
    exr.channels = passes.channels;
    exr.channel_count = passes.count;
    // The writer only reads the pixels; RfImage has no const flavour.
    RfImage image = { .width = frame->width, .height = frame->height, .rgb = (float*)frame->rgb };
    add_clipped( &image, &exr, &passes, &attributes );
    exr.strings = attributes.strings;
    exr.string_count = attributes.count;
    result = rf_write_exr( name, &image, &exr, error );
    free_matte_strings( &mattes );
    return result;
}
