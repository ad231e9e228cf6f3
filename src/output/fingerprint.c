// Which render a frame is of.
#include "reframe/output.h"

#include "base/file.h"
#include "scene/scene.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_NAME 4096

static uint64_t hash_text( uint64_t hash, const char* text ) { return rf_hash_bytes( hash, text, strlen( text ) + 1 ); }

void rf_frame_fingerprint( const RfOutput* output, int frame, char text[RF_FINGERPRINT_SIZE] )
{
    const RfRenderSettings* s = &output->settings;
    const RfCameraPath* path = output->path;
    // Numbers as text: no padding bytes, no byte order, and a new setting cannot
    // be mistaken for an old one. The roulette is a constant part.
    char settings[512], tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &s->tile, tile );
    snprintf( settings, sizeof settings,
              "scene %016llx frame %d of %d fps %d/%d spp %d group %d weights %s normalize %s depth %d lights %d seed %llu "
              "tile %s roulette 0",
              (unsigned long long)rf_tracer_scene( output->tracer )->content_hash, frame, path->count, path->fps.numerator,
              path->fps.denominator, s->spp, s->group, rf_weights_name( s->weights ), rf_normalize_name( s->normalize ),
              s->max_depth, s->light_samples, (unsigned long long)s->seed, tile );
    uint64_t hash = hash_text( hash_text( path->hash, rf_version() ), settings );
    // 0 and 1 as when adaptive sampling was off or on
    static const int adaptive[] = { [RF_ADAPTIVE_OFF] = 0, [RF_ADAPTIVE_ON] = 1, [RF_ADAPTIVE_AUTO] = 2 };
    snprintf( settings, sizeof settings, "noise %.17g time %.17g adaptive %d", s->noise, s->time, adaptive[s->adaptive] );
    if ( s->noise > 0.0 || s->time > 0.0 || s->adaptive != RF_ADAPTIVE_OFF )
        hash = hash_text( hash, settings );
    snprintf( settings, sizeof settings, "flicker %.17g", s->flicker );
    if ( s->flicker > 0.0 ) // a frame without is what it was before it could be asked for
        hash = hash_text( hash, settings );
    snprintf( settings, sizeof settings, "filter %s %.17g", rf_filter_name( s->filter ), s->filter_width );
    if ( s->filter != RF_FILTER_BOX || s->filter_width != 1.0 ) // a box of one pixel is what frames had before there were others
        hash = hash_text( hash, settings );
    char aovs[RF_AOVS_TEXT_SIZE];
    rf_format_aovs( s->aovs, aovs, sizeof aovs );
    snprintf( settings, sizeof settings, "runs %d", path->run_count );
    if ( path->run_count > 0 &&
         path->run_count < path->count ) // a path without is what it was before equal frames were rendered once
        hash = hash_text( hash, settings );
    if ( s->aovs != 0 ) // a frame without any is what it was before there were any
        hash = hash_text( hash, aovs );
    if ( s->estimator != rf_default_render_settings().estimator ) // likewise
        hash = hash_text( hash, rf_estimator_name( s->estimator ) );
    if ( s->reconstruction != RF_RECONSTRUCTION_WEIGHTED )
        hash = hash_text( hash, rf_reconstruction_name( s->reconstruction ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF )
        hash = hash_text( hash_text( hash, rf_light_paths_name( s->light_paths ) ),
                          rf_kernel_normalization_name( s->kernel_normalization ) );
    const RfScene* scene = rf_tracer_scene( output->tracer );
    snprintf( settings, sizeof settings, "effects forced %llx without %llx", (unsigned long long)scene->effects_forced,
              (unsigned long long)scene->effects_left_out );
    if ( ( scene->effects_forced | scene->effects_left_out ) != 0 ) // likewise
        hash = hash_text( hash, settings );
    snprintf( text, RF_FINGERPRINT_SIZE, "%016llx", (unsigned long long)hash );
}

RfResult rf_check_frame_file( const RfOutput* output, int frame, RfFrameFileState* state, RfError* error )
{
    char name[MAX_NAME], found[64], wanted[RF_FINGERPRINT_SIZE];
    struct stat status;
    *state = RF_FRAME_FILE_MISSING;
    RfResult result = rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, error );
    if ( result != RF_OK )
        return result;
    if ( stat( name, &status ) != 0 )
        return errno == ENOENT ? RF_OK : rf_fail( error, RF_ERROR_IO, "%s: cannot be looked at: %s", name, strerror( errno ) );
    if ( S_ISDIR( status.st_mode ) ) // told before the work, and no matter what may be replaced
        return rf_fail( error, RF_ERROR_IO, "%s: is a folder: choose another name", name );
    *state = RF_FRAME_FILE_UNREADABLE;
    if ( rf_read_exr_string( name, "reframe/fingerprint", found, sizeof found, error ) != RF_OK )
        return RF_OK;
    rf_frame_fingerprint( output, frame, wanted );
    *state = strcmp( found, wanted ) == 0 ? RF_FRAME_FILE_SAME : RF_FRAME_FILE_OTHER;
    return RF_OK;
}
