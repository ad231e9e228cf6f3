#include "cli/render/render_output.h"

#include "base/file.h"
#include "cli/options/aov_list.h"
#include "image/exr.h"
#include "image/sequence.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAX_NAME 4096

// The folder of a file name, "." where it has none.
static RfResult folder_of( const char* path, char* folder, size_t size, RfError* error )
{
    const char* slash = strrchr( path, '/' );
    size_t length = slash == NULL ? 1 : slash == path ? 1 : (size_t)( slash - path );
    if ( length >= size )
        return rf_fail( error, RF_ERROR_USAGE, "--output: the name is longer than %d characters", MAX_NAME );
    memcpy( folder, slash == NULL ? "." : path, length );
    folder[length] = '\0';
    return RF_OK;
}

// Makes the last part of a folder's name where it is missing, and only that:
// a mistyped path should not leave a tree behind.
static RfResult make_folder( const char* folder, RfError* error )
{
    struct stat status;
    if ( stat( folder, &status ) == 0 )
    {
        if ( S_ISDIR( status.st_mode ) )
            return RF_OK;
        return rf_fail( error, RF_ERROR_IO, "%s: is not a folder, say with -o where the frames go", folder );
    }
    if ( errno == ENOENT && mkdir( folder, 0777 ) == 0 )
        return RF_OK;
    if ( errno == ENOENT )
        return rf_fail( error, RF_ERROR_IO, "%s: this folder cannot be made, the one that it is to be in is missing", folder );
    return rf_fail( error, RF_ERROR_IO, "%s: the folder cannot be used: %s", folder, strerror( errno ) );
}

// Tells before the work, not after it, that frames cannot be written there.
static RfResult probe_folder( const char* folder, RfError* error )
{
    char name[MAX_NAME + 32];
    snprintf( name, sizeof name, "%s/.reframe-probe-XXXXXX", folder );
    int file = mkstemp( name );
    if ( file < 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: no files can be made in this folder: %s", folder, strerror( errno ) );
    close( file );
    unlink( name );
    return RF_OK;
}

// Is the file a frame of this very render?
static RfResult check_fingerprint( const RfRenderSubject* subject, int frame, const char* name, RfError* error )
{
    char found[64], wanted[17];
    RfError reason;
    if ( rf_read_exr_string( name, "reframe/fingerprint", found, sizeof found, &reason ) != RF_OK )
        return rf_fail( error, RF_ERROR_IO, "--resume: not a frame of this render, add --overwrite to replace it: %.900s",
                        reason.text );
    rf_frame_fingerprint( subject, frame, wanted );
    if ( strcmp( found, wanted ) == 0 )
        return RF_OK;
    return rf_fail( error, RF_ERROR_IO,
                    "--resume: %s: was rendered from another scene, path, version or settings: give those, or add "
                    "--overwrite to replace such frames",
                    name );
}

static RfResult keep_or_refuse( const RfRenderSubject* subject, int frame, const char* name, bool* keep, RfError* error )
{
    struct stat status;
    *keep = false;
    if ( stat( name, &status ) != 0 )
    {
        if ( errno == ENOENT )
            return RF_OK;
        return rf_fail( error, RF_ERROR_IO, "%s: cannot be looked at: %s", name, strerror( errno ) );
    }
    if ( S_ISDIR( status.st_mode ) ) // told before the work, and no matter what may be replaced
        return rf_fail( error, RF_ERROR_IO, "%s: is a folder: choose another name", name );
    if ( subject->options->resume )
    {
        RfResult result = check_fingerprint( subject, frame, name, error );
        *keep = result == RF_OK;
        return subject->options->overwrite ? RF_OK : result;
    }
    if ( subject->options->overwrite )
        return RF_OK;
    return rf_fail( error, RF_ERROR_IO, "%s: is there already: --resume goes on, --overwrite replaces", name );
}

static RfResult check_json( const char* name, RfError* error )
{
    struct stat status;
    if ( name != NULL && strcmp( name, "-" ) != 0 && stat( name, &status ) == 0 && S_ISDIR( status.st_mode ) )
        return rf_fail( error, RF_ERROR_IO, "--json: %s: is a folder: choose another name", name );
    return RF_OK;
}

RfResult rf_prepare_output( const RfRenderSubject* subject, int* frames, int* count, int* kept, RfError* error )
{
    const char* pattern = subject->options->output;
    char folder[MAX_NAME], name[MAX_NAME];
    RfResult result = rf_sequence_name( pattern, 1, name, sizeof name, error );
    if ( result == RF_OK && *count > 1 && !rf_is_sequence( pattern ) )
        result = rf_fail( error, RF_ERROR_USAGE, "--output: '%s' has no #### for the number, but %d frames are asked for",
                          pattern, *count );
    if ( result == RF_OK )
        result = folder_of( pattern, folder, sizeof folder, error );
    if ( result == RF_OK )
        result = make_folder( folder, error );
    if ( result == RF_OK )
        result = probe_folder( folder, error );
    if ( result == RF_OK )
        result = check_json( subject->options->json, error );
    int left = 0;
    for ( int i = 0; i < *count && result == RF_OK; ++i )
    {
        bool keep;
        result = rf_sequence_name( pattern, frames[i] + 1, name, sizeof name, error );
        if ( result == RF_OK )
            result = keep_or_refuse( subject, frames[i], name, &keep, error );
        if ( result == RF_OK && keep )
            kept[i - left] = frames[i];
        else if ( result == RF_OK )
            frames[left++] = frames[i];
    }
    *count = result == RF_OK ? left : *count;
    return result;
}

static uint64_t hash_text( uint64_t hash, const char* text ) { return rf_hash_bytes( hash, text, strlen( text ) + 1 ); }

void rf_frame_fingerprint( const RfRenderSubject* subject, int frame, char text[17] )
{
    const RfRenderSettings* s = &subject->options->settings;
    // Numbers as text: no padding bytes, no byte order, and a new setting cannot
    // be mistaken for an old one.
    char settings[512], tile[24];
    rf_tile_name( &s->tile, tile );
    snprintf( settings, sizeof settings,
              "scene %016llx frame %d of %d fps %d/%d spp %d group %d weights %s normalize %s depth %d lights %d seed %llu "
              "tile %s roulette %d",
              (unsigned long long)subject->scene->content_hash, frame, subject->path->count, subject->options->fps.numerator,
              subject->options->fps.denominator, s->spp, s->group, rf_weights_name( s->weights ),
              rf_normalize_name( s->normalize ), s->max_depth, s->light_samples, (unsigned long long)s->seed, tile,
              s->tile_roulette );
    uint64_t hash = hash_text( hash_text( subject->path->hash, REFRAME_VERSION ), settings );
    snprintf( settings, sizeof settings, "noise %.17g time %.17g adaptive %d", s->noise, s->time, s->adaptive );
    if ( s->noise > 0.0 || s->time > 0.0 || s->adaptive )
        hash = hash_text( hash, settings );
    char layers[128];
    rf_format_aovs( s->layers, layers, sizeof layers );
    if ( s->layers != 0 ) // a frame without all these is what it was before there were any
        hash = hash_text( hash, layers );
    snprintf( text, 17, "%016llx", (unsigned long long)hash );
}

void rf_eye_matrices( const RfEye* eye, float world_to_camera[16], float world_to_ndc[16] )
{
    const RfVec3 axes[3] = { eye->right, eye->up, rf_scale( eye->forward, -1.0f ) };
    double camera[4][4] = { { 0 } };
    for ( int j = 0; j < 3; ++j )
    {
        camera[0][j] = axes[j].x;
        camera[1][j] = axes[j].y;
        camera[2][j] = axes[j].z;
        camera[3][j] =
            -( (double)eye->origin.x * axes[j].x + (double)eye->origin.y * axes[j].y + (double)eye->origin.z * axes[j].z );
    }
    camera[3][3] = 1.0;
    const double near = 0.01;
    double x_scale = 2.0 * eye->focal / eye->width, y_scale = 2.0 * eye->focal / eye->height;
    for ( int i = 0; i < 4; ++i )
    {
        const double* row = camera[i];
        for ( int j = 0; j < 4; ++j )
            world_to_camera[4 * i + j] = (float)row[j];
        world_to_ndc[4 * i + 0] = (float)( x_scale * row[0] );
        world_to_ndc[4 * i + 1] = (float)( y_scale * row[1] );
        world_to_ndc[4 * i + 2] = (float)( -row[2] - 2.0 * near * row[3] );
        world_to_ndc[4 * i + 3] = (float)-row[2];
    }
}

#define STRING_COUNT 24
#define TEXT_SIZE 64 // all layers fit

typedef struct Attributes
{
    RfExrString strings[STRING_COUNT];
    char texts[STRING_COUNT][TEXT_SIZE];
    int count;
} Attributes;

static void add_text( Attributes* attributes, const char* name, const char* value )
{
    attributes->strings[attributes->count++] = ( RfExrString ){ name, value };
}

static void add_number( Attributes* attributes, const char* name, const char* format, double value )
{
    char* text = attributes->texts[attributes->count];
    snprintf( text, sizeof attributes->texts[0], format, value );
    add_text( attributes, name, text );
}

static void add_tile( Attributes* attributes, const RfTile* tile )
{
    char* text = attributes->texts[attributes->count];
    rf_tile_name( tile, text );
    add_text( attributes, "reframe/tile", text );
}

static void list_attributes( const RfRenderSubject* subject, const RfFrameResult* result, const char* device,
                             Attributes* attributes )
{
    const RfRenderSettings* s = &subject->options->settings;
    attributes->count = 0;
    add_text( attributes, "reframe/version", REFRAME_VERSION );
    add_text( attributes, "reframe/scene", subject->options->scene );
    add_text( attributes, "reframe/camera", subject->path->name );
    add_number( attributes, "reframe/frame", "%.0f", result->frame + 1 );
    add_number( attributes, "reframe/frames", "%.0f", subject->path->count );
    add_number( attributes, "reframe/group", "%.0f", s->group );
    add_number( attributes, "reframe/spp", "%.0f", s->spp );
    add_tile( attributes, &s->tile );
    add_text( attributes, "reframe/weights", rf_weights_name( s->weights ) );
    add_text( attributes, "reframe/normalize", rf_normalize_name( s->normalize ) );
    char* seed = attributes->texts[attributes->count]; // a double does not hold every seed
    snprintf( seed, sizeof attributes->texts[0], "%llu", (unsigned long long)s->seed );
    add_text( attributes, "reframe/seed", seed );
    add_number( attributes, "reframe/max-depth", "%.0f", s->max_depth );
    add_number( attributes, "reframe/light-samples", "%.0f", s->light_samples );
    if ( s->adaptive )
        add_text( attributes, "reframe/adaptive", "yes" );
    if ( s->noise > 0.0 )
        add_number( attributes, "reframe/noise", "%.9g", s->noise );
    if ( s->time > 0.0 )
        add_number( attributes, "reframe/time", "%.9g", s->time );
    if ( isfinite( result->relmse_estimate ) )
        add_number( attributes, "reframe/relmse-estimate", "%.6g", result->relmse_estimate );
    add_number( attributes, "reframe/native-spp", "%.9g", result->native_spp );
    add_number( attributes, "reframe/effective-spp", "%.6g", result->effective_spp );
    if ( s->layers != 0 )
    {
        char* layers = attributes->texts[attributes->count];
        rf_format_aovs( s->layers, layers, TEXT_SIZE );
        add_text( attributes, "reframe/aov", layers );
    }
    add_text( attributes, "reframe/device", device );
    char* fingerprint = attributes->texts[attributes->count];
    rf_frame_fingerprint( subject, result->frame, fingerprint );
    add_text( attributes, "reframe/fingerprint", fingerprint );
}

RfResult rf_write_frame( const RfRenderSubject* subject, const RfFrameResult* result, const char* device, RfError* error )
{
    const RfRenderOptions* options = subject->options;
    char name[MAX_NAME];
    RfResult named = rf_sequence_name( options->output, result->frame + 1, name, sizeof name, error );
    if ( named != RF_OK )
        return named;
    Attributes attributes;
    list_attributes( subject, result, device, &attributes );
    RfExrOptions exr = rf_default_exr_options();
    exr.compression = options->settings.files.compression;
    exr.half = options->settings.files.half;
    exr.fps_numerator = options->fps.numerator;
    exr.fps_denominator = (unsigned int)options->fps.denominator;
    exr.has_camera = true;
    rf_eye_matrices( subject->path->eyes + result->frame, exr.world_to_camera, exr.world_to_ndc );
    exr.strings = attributes.strings;
    exr.string_count = attributes.count;
    RfAovChannels layers;
    rf_list_aov_channels( result, exr.half, &layers );
    exr.channels = layers.channels;
    exr.channel_count = layers.count;
    // The writer only reads the pixels; RfImage has no const flavour.
    RfImage image = { .width = result->width, .height = result->height, .rgb = (float*)result->rgb };
    return rf_write_exr( name, &image, &exr, error );
}
