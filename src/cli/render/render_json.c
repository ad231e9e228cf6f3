// The result of a render as JSON: settings, effects, rays, memory, seconds, each frame and where its error is and what it
// clips; what moves in a scene.
#include "cli/render/render_json.h"

#include "base/file.h"
#include "base/system.h"
#include "base/words.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/render/render_command.h"
#include "image/colour.h"
#include "image/sequence.h"
#include "output/frame_file.h"
#include "output/names.h"
#include "reframe/image.h"
#include "render/estimator.h"
#include "render/sharing.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_JSON_BYTES ( (uint64_t)64 << 20 ) // of a file that is read

#define MAX_NAME 4096

#define MOST_TEXT 160 // characters of a list of frames

void rf_add_clipped( const char* pattern, int number, json_t* row )
{
    char name[MAX_NAME], text[RF_EFFECTS_TEXT_SIZE];
    bool named = rf_sequence_name( pattern, number, name, sizeof name, NULL ) == RF_OK;
    double pixels = named ? rf_read_exr_number( name, rf_key_name( RF_KEY_CLIPPED_PIXELS ) ) : 0.0;
    json_object_set_new( row, "clipped_pixels", json_integer( isgreater( pixels, 0.0 ) ? (json_int_t)pixels : 0 ) );
    if ( !named || rf_read_exr_string( name, rf_key_name( RF_KEY_CLIPPED_LAYERS ), text, sizeof text, NULL ) != RF_OK )
        return;
    json_t* layers = json_array();
    for ( char *layer = text, *end; layer != NULL; layer = end )
    {
        end = strchr( layer, ',' );
        if ( end != NULL )
            *end++ = '\0';
        json_array_append_new( layers, rf_json_text( layer ) );
    }
    json_object_set_new( row, "clipped_layers", layers );
}

static void join_words( const json_t* list, char* text, size_t size )
{
    size_t i;
    const json_t* word;
    json_array_foreach( list, i, word )
    {
        char whole[2 * RF_EFFECTS_TEXT_SIZE], item[RF_EFFECTS_TEXT_SIZE];
        snprintf( whole, sizeof whole, ", %s,", text );
        snprintf( item, sizeof item, ", %s,", json_string_value( word ) );
        if ( strstr( whole, item ) == NULL )
            rf_append( text, size, "%s%s", text[0] != '\0' ? ", " : "", json_string_value( word ) );
    }
}

static json_t* sum_clipped( const json_t* frames )
{
    size_t i;
    const json_t* row;
    json_int_t pixels = 0;
    json_array_foreach( frames, i, row ) pixels += json_integer_value( json_object_get( row, "clipped_pixels" ) );
    return json_integer( pixels );
}

void rf_warn_of_clipped( RfRenderJob* job )
{
    const RfFrameFiles* files = &job->options.settings.files;
    json_t *rows = json_array(), *row;
    char text[MOST_TEXT], layers[256] = "";
    size_t i, rendered = json_array_size( job->frames_json );
    int *numbers = malloc( ( rendered + (size_t)job->kept_count + 1 ) * sizeof *numbers ), count = 0;
    json_int_t pixels = 0;
    json_array_extend( rows, job->frames_json );
    for ( int k = 0; k < job->kept_count; ++k )
    {
        int number = rf_frame_number( &job->path, job->kept[k] );
        row = json_pack( "{s:i}", "frame", number );
        rf_add_clipped( job->options.output, number, row );
        json_array_append_new( rows, row );
    }
    json_array_foreach( rows, i, row )
    {
        json_int_t here = json_integer_value( json_object_get( row, "clipped_pixels" ) );
        if ( here <= 0 || numbers == NULL )
            continue;
        pixels += here;
        numbers[count++] = (int)json_integer_value( json_object_get( row, "frame" ) );
        join_words( json_object_get( row, "clipped_layers" ), layers, sizeof layers );
    }
    if ( count > 0 )
    {
        bool dwa = files->compression == RF_EXR_DWAA || files->compression == RF_EXR_DWAB;
        qsort( numbers, (size_t)count, sizeof *numbers, rf_compare_frames );
        rf_format_frames( numbers, count, text, sizeof text );
        rf_warn( &job->log, "%lld pixel%s of frame%s %s %s beyond the range of %s and clipped there, in %s: %s",
                 (long long)pixels, pixels == 1 ? "" : "s", count == 1 ? "" : "s", text, pixels == 1 ? "is" : "are",
                 dwa ? "DWA (30000; half floats: 65504)" : "half floats (65504)", layers,
                 dwa ? "give --compression zip and --float" : "give --float" );
    }
    free( numbers );
    json_decref( rows );
}

#define MOSTLY 0.5 // of the specks' error

static json_t* part_json( int64_t pixels, double share )
{
    return json_pack( "{s:I, s:o}", "pixels", (json_int_t)pixels, "share", rf_json_number( share ) );
}

static json_t* head_json( int64_t pixels, double share, double rest )
{
    return RF_SET_FIGURES( part_json( pixels, share ), { "rest_relmse", rest },
                           { "rest_noise_percent", rf_noise_percent( rest ) } );
}

// Adds pixels to an object that part_json made.
static void add_to_part( json_t* part, double pixels, double share )
{
    json_object_set_new( part, "pixels", json_integer( (json_int_t)( rf_json_number_of( part, "pixels" ) + pixels ) ) );
    json_object_set_new( part, "share", rf_json_number( rf_json_number_of( part, "share" ) + share ) );
}

static json_t* no_kinds( void )
{
    json_t* kinds = json_object();
    for ( int k = 0; k < RF_SPECK_KINDS; ++k )
        json_object_set_new( kinds, rf_speck_kind_name( (RfSpeckKind)k ), part_json( 0, 0.0 ) );
    return kinds;
}

json_t* rf_specks_json( const RfSpecks* specks, const RfScene* scene )
{
    json_t *json = head_json( specks->pixels, specks->share, specks->rest ), *kinds = no_kinds(), *materials = json_array();
    for ( int p = 0; p < specks->part_count; ++p )
    {
        const RfSpeckPart* part = specks->parts + p;
        json_t* row = part_json( part->pixels, part->share );
        json_object_set_new( row, "kind", json_string( rf_speck_kind_name( part->kind ) ) );
        json_object_set_new( row, "material",
                             part->material >= 0 ? rf_json_text( scene->materials[part->material].name ) : json_null() );
        json_array_append_new( materials, row );
        add_to_part( json_object_get( kinds, rf_speck_kind_name( part->kind ) ), part->pixels, part->share );
    }
    json_object_set_new( json, "kinds", kinds );
    json_object_set_new( json, "materials", materials );
    return json;
}

static double at_least_0( double value ) { return isgreater( value, 0.0 ) ? value : 0.0; }

// The row of the same material and kind, made where there is none.
static json_t* find_row( json_t* materials, const json_t* like )
{
    size_t i;
    json_t* row;
    json_array_foreach( materials, i, row )
    {
        if ( json_equal( json_object_get( row, "kind" ), json_object_get( like, "kind" ) ) &&
             json_equal( json_object_get( row, "material" ), json_object_get( like, "material" ) ) )
            return row;
    }
    row = part_json( 0, 0.0 );
    json_object_set( row, "kind", json_object_get( like, "kind" ) );
    json_object_set( row, "material", json_object_get( like, "material" ) );
    json_array_append_new( materials, row );
    return row;
}

// Adds the rows of a frame with so much of the error of all.
static void add_materials( const json_t* specks, double weight, json_t* kinds, json_t* materials )
{
    size_t i;
    json_t* row;
    json_array_foreach( json_object_get( specks, "materials" ), i, row )
    {
        const char* kind = json_string_value( json_object_get( row, "kind" ) );
        json_t* of_kind = kind != NULL ? json_object_get( kinds, kind ) : NULL;
        double pixels = at_least_0( rf_json_number_of( row, "pixels" ) );
        double share = weight * at_least_0( rf_json_number_of( row, "share" ) );
        if ( of_kind == NULL )
            continue;
        add_to_part( of_kind, pixels, share );
        add_to_part( find_row( materials, row ), pixels, share );
    }
}

static json_t* specks_of( const json_t* frame )
{
    json_t* specks = json_object_get( frame, "specks" );
    bool known = isgreaterequal( rf_json_number_of( frame, "relmse_likely" ), 0.0 ) &&
                 isgreaterequal( rf_json_number_of( specks, "rest_relmse" ), 0.0 );
    return known ? specks : NULL;
}

static void sort_rows( json_t* rows )
{
    for ( size_t i = 1; i < json_array_size( rows ); ++i )
    {
        for ( size_t k = i; k > 0; --k )
        {
            json_t *above = json_array_get( rows, k - 1 ), *row = json_array_get( rows, k );
            if ( rf_json_number_of( above, "share" ) >= rf_json_number_of( row, "share" ) )
                break;
            json_incref( above );
            json_array_set( rows, k - 1, row );
            json_array_set_new( rows, k, above );
        }
    }
}

json_t* rf_sum_specks( const json_t* frames )
{
    double likely = 0.0, rest = 0.0, share = 0.0, pixels = 0.0;
    int count = 0;
    size_t i;
    json_t* frame;
    json_array_foreach( frames, i, frame )
    {
        count += specks_of( frame ) != NULL;
        likely += specks_of( frame ) != NULL ? rf_json_number_of( frame, "relmse_likely" ) : 0.0;
    }
    if ( count == 0 )
        return NULL;
    json_t *kinds = no_kinds(), *materials = json_array();
    json_array_foreach( frames, i, frame )
    {
        const json_t* specks = specks_of( frame );
        if ( specks == NULL )
            continue;
        double weight = likely > 0.0 ? rf_json_number_of( frame, "relmse_likely" ) / likely : 0.0;
        pixels += at_least_0( rf_json_number_of( specks, "pixels" ) );
        share += weight * at_least_0( rf_json_number_of( specks, "share" ) );
        rest += rf_json_number_of( specks, "rest_relmse" ) / count;
        add_materials( specks, weight, kinds, materials );
    }
    sort_rows( materials );
    json_t* sum = head_json( (int64_t)pixels, share, rest );
    json_object_set_new( sum, "kinds", kinds );
    json_object_set_new( sum, "materials", materials );
    json_object_set_new( sum, "frames", json_integer( count ) );
    return sum;
}

static double share_of_kind( const json_t* sum, RfSpeckKind kind )
{
    return rf_json_number_of( json_object_get( json_object_get( sum, "kinds" ), rf_speck_kind_name( kind ) ), "share" );
}

// The kind that most of the specks' error is of; RF_SPECK_OTHER: there is none, or it is that.
static RfSpeckKind main_kind( const json_t* sum )
{
    double all = rf_json_number_of( sum, "share" );
    for ( int k = 0; k < RF_SPECK_OTHER; ++k )
    {
        if ( isgreaterequal( share_of_kind( sum, (RfSpeckKind)k ), MOSTLY * all ) )
            return (RfSpeckKind)k;
    }
    return RF_SPECK_OTHER;
}

// ", mostly on 'steel' (glints)"; the material and the kind only where most of the error has them.
static void format_main_part( const json_t* sum, char* text, size_t size )
{
    static const char* const words[RF_SPECK_KINDS] = { "glints", "caustics found by chance", "" };
    const json_t *first = json_array_get( json_object_get( sum, "materials" ), 0 ), *row;
    const char* kind = words[main_kind( sum )];
    char place[96] = "";
    double share = 0.0;
    size_t i;
    json_array_foreach( json_object_get( sum, "materials" ), i, row )
    {
        if ( json_equal( json_object_get( row, "material" ), json_object_get( first, "material" ) ) )
            share += at_least_0( rf_json_number_of( row, "share" ) );
    }
    const char* name = json_string_value( json_object_get( first, "material" ) );
    if ( first != NULL && isgreaterequal( share, MOSTLY * rf_json_number_of( sum, "share" ) ) )
        snprintf( place, sizeof place, " %s%.60s%s", name != NULL ? "on '" : "in the sky", name != NULL ? name : "",
                  name != NULL ? "'" : "" );
    if ( place[0] != '\0' )
        snprintf( text, size, ", mostly%s%s%s%s", place, kind[0] != '\0' ? " (" : "", kind, kind[0] != '\0' ? ")" : "" );
    else
        snprintf( text, size, "%s%s", kind[0] != '\0' ? ", mostly " : "", kind );
}

bool rf_format_specks( const json_t* sum, char* text, size_t size )
{
    double pixels = rf_json_number_of( sum, "pixels" ), share = rf_json_number_of( sum, "share" );
    double frames = rf_json_number_of( sum, "frames" ), rest = rf_json_number_of( sum, "rest_relmse" );
    if ( !isgreater( pixels, 0.0 ) || !isgreaterequal( share, RF_SPECKS_STAND_OUT ) )
        return false;
    char noise[RF_NOISE_TEXT_SIZE], in_frames[48] = "", percent[32], part[192];
    rf_format_noise( rest, noise );
    if ( frames > 1.0 )
        snprintf( in_frames, sizeof in_frames, " in %.0f frames", frames );
    snprintf( percent, sizeof percent, "%.0f %%", floor( 100.0 * share ) );
    format_main_part( sum, part, sizeof part );
    snprintf( text, size, "%.0f speck%s%s hold%s %s of the error%s; the rest has about %s noise (relMSE %.3g)", pixels,
              pixels > 1.0 ? "s" : "", in_frames, pixels > 1.0 ? "" : "s", percent, part, noise, rest );
    return true;
}

const char* rf_speck_advice( const json_t* sum, const RfRenderSettings* settings )
{
    bool adapts = settings->estimator->add_own_shares != NULL && settings->group != 0;
    switch ( main_kind( sum ) )
    {
        case RF_SPECK_GLINT: return adapts && settings->adaptive == RF_ADAPTIVE_OFF ? "--adaptive" : "raise --spp";
        case RF_SPECK_CHANCE: return settings->estimator->clamps && settings->clamp == 0.0 ? "--clamp auto" : NULL;
        case RF_SPECK_OTHER: break;
    }
    return NULL;
}

static const char* const s_keys[RF_SHARED_WAYS] = { "shared", "scaled", "own_frame" };

static json_t* change_json( const RfChanging* change, const RfLightSharing* sharing )
{
    json_t *what = json_array(), *frames = json_null();
    for ( int i = 0; i < change->what_count; ++i )
        json_array_append_new( what, json_string( change->what[i] ) );
    if ( sharing != NULL && change->shines )
        frames = json_pack( "{s:i, s:i, s:i}", s_keys[0], sharing->frames[0], s_keys[1], sharing->frames[1], s_keys[2],
                            sharing->frames[2] );
    return json_pack( "{s:s, s:o, s:o, s:o, s:o}", "kind", rf_changing_kind( change->kind ), "name", rf_json_text( change->name ),
                      "what", what, "frames", frames, "share", rf_json_number( sharing != NULL ? sharing->share : (double)NAN ) );
}

static json_t* sharing_json( const RfSharing* sharing )
{
    return RF_SET_FIGURES( json_pack( "{s:i, s:i}", "group", sharing->group, "frames", sharing->frames ),
                           { s_keys[0], sharing->light[RF_SHARED_AS_IT_IS] }, { s_keys[1], sharing->light[RF_SHARED_SCALED] },
                           { s_keys[2], sharing->light[RF_SHARED_NOT] + sharing->moving }, { "moving", sharing->moving } );
}

// The path with the small films of the pilot.
static RfResult look( const RfTracer* tracer, const RfRenderOptions* options, const RfChanging* changing, int count,
                      RfSharing* sharing, RfError* error )
{
    RfLens lens;
    RfCameraPath path = rf_empty_camera_path();
    RfPathOptions asked;
    int lights = 0;
    for ( int i = 0; i < count; ++i )
        lights += changing[i].shines;
    RfResult result = rf_parse_path_options( options, &lens, &asked, error );
    rf_sharing_film( (double)options->size.width / (double)options->size.height, lights, &asked.width, &asked.height );
    asked.overscan = ( RfOverscan ){ .size = 0.0 };
    lens.has_shutter = true; // closed: every light is at one place
    lens.shutter[0] = lens.shutter[1] = 0.0;
    if ( result == RF_OK )
        result = rf_create_camera_path( rf_tracer_scene( tracer ), &asked, &path, error );
    if ( result == RF_OK )
        result = rf_find_sharing( tracer, &path, &options->settings, changing, count, sharing, error );
    rf_destroy_camera_path( &path );
    return result;
}

RfResult rf_add_changes( const RfScene* scene, const RfTracer* tracer, const RfRenderOptions* options, json_t* to,
                         RfError* error )
{
    RfChanging* changing;
    RfSharing sharing = { 0 };
    int count = rf_list_changing( scene, &changing );
    if ( count < 0 )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory listing what changes" );
    RfResult result = tracer != NULL ? look( tracer, options, changing, count, &sharing, error ) : RF_OK;
    json_t *moving = json_array(), *list = json_array();
    for ( int i = 0; i < scene->moving_count; ++i )
        json_array_append_new( moving, rf_json_text( scene->moving[i] ) );
    json_object_set_new( to, "moving", moving );
    for ( int i = 0; i < count && result == RF_OK; ++i )
        json_array_append_new( list, change_json( changing + i, tracer != NULL ? sharing.of + i : NULL ) );
    json_object_set_new( to, "changing", list );
    json_object_set_new( to, "sharing", tracer != NULL && result == RF_OK ? sharing_json( &sharing ) : json_null() );
    free( changing );
    rf_destroy_sharing( &sharing );
    return result;
}

static void format_share( double share, char text[32] )
{
    double percent = 100.0 * share;
    snprintf( text, 32, percent > 0.0 && percent < 1.0 ? "under 1 %%" : "%.0f %%", percent );
}

// "own-frame", or "scaled in 12 of 48 frames, own-frame in 1, else shared".
static void append_ways( const json_t* frames, char text[RF_CHANGE_TEXT] )
{
    double of[RF_SHARED_WAYS], all = 0.0;
    for ( int k = 0; k < RF_SHARED_WAYS; ++k )
        all += of[k] = rf_json_number_of( frames, s_keys[k] );
    if ( !( all > 0.0 ) )
        return;
    rf_append( text, RF_CHANGE_TEXT, "; " );
    bool begun = false;
    for ( int k = RF_SHARED_WAYS - 1; k >= 0; --k )
    {
        const char* way = rf_shared_name( (RfShared)k );
        if ( of[k] == all )
            rf_append( text, RF_CHANGE_TEXT, "%s", way );
        else if ( of[k] > 0.0 && k == 0 )
            rf_append( text, RF_CHANGE_TEXT, ", else %s", way );
        else if ( of[k] > 0.0 )
        {
            rf_append( text, RF_CHANGE_TEXT, "%s%s in %.0f", begun ? ", " : "", way, of[k] );
            if ( !begun )
                rf_append( text, RF_CHANGE_TEXT, " of %.0f frames", all );
            begun = true;
        }
    }
}

void rf_format_change( const json_t* change, const json_t* sharing, char text[RF_CHANGE_TEXT] )
{
    size_t i;
    const json_t* word;
    char share[32];
    const json_t* frames = json_object_get( change, "frames" );
    text[0] = '\0';
    json_array_foreach( json_object_get( change, "what" ), i, word )
        rf_append( text, RF_CHANGE_TEXT, "%s%s", i > 0 ? ", " : "", json_is_string( word ) ? json_string_value( word ) : "" );
    const char* kind = json_string_value( json_object_get( change, "kind" ) );
    bool grouped = isgreater( rf_json_number_of( sharing, "group" ), 0.0 ),
         material = kind != NULL && strcmp( kind, "material" ) == 0;
    if ( grouped && json_is_object( frames ) )
        append_ways( frames, text );
    else if ( grouped && material )
        rf_append( text, RF_CHANGE_TEXT, "; own-frame" );
    double of_light = rf_json_number_of( change, "share" );
    if ( isfinite( of_light ) && json_is_object( frames ) )
    {
        format_share( of_light, share );
        rf_append( text, RF_CHANGE_TEXT, "; %s of the light", share );
    }
}

void rf_format_sharing( const json_t* sharing, char text[RF_CHANGE_TEXT] )
{
    char share[RF_SHARED_WAYS + 1][32];
    double group = rf_json_number_of( sharing, "group" ), moving = rf_json_number_of( sharing, "moving" );
    text[0] = '\0';
    if ( !isfinite( moving ) )
        return;
    for ( int k = 0; k < RF_SHARED_WAYS; ++k )
        format_share( rf_json_number_of( sharing, s_keys[k] ), share[k] );
    format_share( moving, share[RF_SHARED_WAYS] );
    double frames = rf_json_number_of( sharing, "frames" ); // no group has more than the path
    if ( group > 0.0 )
        rf_append( text, RF_CHANGE_TEXT, "in groups of %.0f frames %s of the light is shared, %s scaled, %s own-frame",
                   fmin( 2.0 * group + 1.0, frames ), share[0], share[1], share[2] );
    else
        rf_append( text, RF_CHANGE_TEXT, "frames share no light: groups of one frame" );
    if ( moving > 0.0 && group > 0.0 )
        rf_append( text, RF_CHANGE_TEXT, " (%s on what moves)", share[RF_SHARED_WAYS] );
}

json_t* rf_frame_json( const RfFrameResult* result, const RfScene* scene, const RfCameraPath* path,
                       const RfRenderSettings* settings, int same_as )
{
    int steps = path->eyes[result->frame].blur_steps;
    bool stops = settings->noise > 0.0 || settings->flicker > 0.0;
    json_t* json = json_pack( "{s:i, s:o, s:o, s:b, s:o, s:o, s:o, s:o, s:b, s:o, s:o, s:s*, s:o*, s:o*}", "frame",
                              rf_frame_number( path, result->frame ), "seconds", rf_json_number( result->seconds ),
                              "relmse_estimate", rf_json_number( result->relmse_estimate ), "relmse_is_lower_bound",
                              result->relmse_is_lower_bound, "relmse_likely", rf_json_number( result->relmse_likely ),
                              "worst_ten_share", rf_json_number( result->worst_ten_share ), "native_spp",
                              rf_json_number( result->native_spp ), "effective_spp", rf_json_number( result->effective_spp ),
                              "kept", 0, "noise_percent", rf_json_number( rf_noise_percent( result->relmse_estimate ) ), "specks",
                              rf_specks_json( &result->specks, scene ), "reconstruction",
                              result->solved == RF_SOLVED       ? NULL
                              : result->solved == RF_SOLVED_NOT ? "failed"
                                                                : "not converged",
                              "blur_steps", steps > 0 ? json_integer( steps ) : NULL, "same_as",
                              same_as >= 0 ? json_integer( rf_frame_number( path, same_as ) ) : NULL );
    if ( settings->flicker > 0.0 )
        rf_json_add( json, "{s:o, s:b, s:o, s:o}", "flicker_estimate", rf_json_number( result->flicker_estimate ),
                     "flicker_is_lower_bound", result->flicker_is_lower_bound, "flicker_likely",
                     rf_json_number( result->flicker_likely ), "flicker_worst_ten_share",
                     rf_json_number( result->flicker_worst_ten_share ) );
    if ( result->denoised != NULL )
        json_object_set_new( json, "denoised", rf_denoised_json( result->denoised->noisy, &result->denoised->denoised ) );
    if ( settings->clamp != 0.0 )
        RF_SET_FIGURES( json, { "clamp_threshold", result->clamp }, { "clamp_threshold_chains", result->clamp_chains } );
    return rf_json_add( json, "{s:o*, s:o*}", "removed_share", result->removes ? rf_json_number( result->removed ) : NULL,
                        "reached", stops ? json_boolean( result->reached ) : NULL );
}

// The names of effects that are on, left out or forced.
static json_t* names_json( const RfRenderJob* job, bool on, bool left_out, bool forced )
{
    json_t* names = json_array();
    for ( int i = 0; i < job->effect_count; ++i )
    {
        const RfEffect* e = job->effects + i;
        if ( ( on && e->on ) || ( left_out && e->left_out ) || ( forced && e->forced ) )
            json_array_append_new( names, json_string( e->name ) );
    }
    return names;
}

json_t* rf_effects_json( const RfScene* scene, const RfRenderSettings* settings )
{
    RfEffect effects[RF_MAX_EFFECTS];
    int count = rf_list_render_effects( scene, NULL, 0, settings, effects );
    json_t* list = json_array();
    for ( int i = 0; i < count; ++i )
    {
        const RfEffect* e = effects + i;
        const char* option = rf_effect_option( e->id );
        json_array_append_new( list, json_pack( "{s:s, s:b, s:o, s:b, s:b, s:o}", "name", e->name, "on", e->on, "why",
                                                rf_json_text( e->why ), "left_out", e->left_out, "forced", e->forced, "option",
                                                option != NULL ? json_string( option ) : json_null() ) );
    }
    return list;
}

static json_t* count_json( uint64_t count ) { return json_integer( (json_int_t)count ); }

static json_t* rays_json( const RfRayCounts* rays )
{
    return json_pack( "{s:o, s:o, s:o, s:o, s:o}", "primary", count_json( rays->primary ), "path", count_json( rays->path ),
                      "shadow", count_json( rays->shadow ), "tile", count_json( rays->tile ), "eye", count_json( rays->eye ) );
}

// The peak of each entry; they need not coincide.
static json_t* bytes_json( const RfRenderStats* stats )
{
    json_t* bytes = json_object();
    for ( int i = 0; i < stats->entry_count; ++i )
    {
        char key[64];
        snprintf( key, sizeof key, "%s", stats->entries[i].name );
        for ( char* c = key; *c != '\0'; ++c )
            *c = *c == ' ' ? '_' : *c;
        json_object_set_new( bytes, key, json_integer( (json_int_t)stats->entries[i].peak ) );
    }
    return bytes;
}

json_t* rf_render_json( const RfRenderJob* job, json_t* frames, bool interrupted )
{
    const RfRenderOptions* options = &job->options;
    const RfRenderStats* stats = &job->stats;
    const RfScene* scene = &job->scene;
    const RfRenderSettings* s = &options->settings;
    const RfFrameFiles* files = &s->files;
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &s->tile, tile );
    json_t* json = json_pack(
        "{s:s, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:s, s:s, s:s, s:i, s:o, s:i, s:b, s:o, s:o, s:{s:s, s:f}}",
        "version", rf_version(), "pictures", rf_pictures(), "scene", rf_json_text( options->scene ), "frames", frames, "seconds",
        rf_json_number( rf_wall_seconds() - job->start ), "seconds_scene", rf_json_number( job->seconds_scene ), "peak_bytes",
        count_json( stats->peak_bytes ), "budget_bytes", count_json( stats->budget_bytes ), "bytes", bytes_json( stats ), "rays",
        rays_json( &stats->rays ), "group", stats->group, "tile", tile, "weights", rf_weights_name( s->weights ), "normalize",
        rf_normalize_name( s->normalize ), "threads", stats->threads, "effects", names_json( job, true, false, false ),
        "kept_frames", job->kept_count, "interrupted", interrupted, "effects_left_out", names_json( job, false, true, false ),
        "effects_forced", names_json( job, false, false, true ), "filter", "name", rf_filter_name( s->filter ), "width",
        s->filter_width );
    if ( rf_is_other_estimator( s->estimator ) )
        rf_json_add( json, "{s:s, s:s, s:{s:o, s:o}}", "estimator", rf_estimator_name( s->estimator ), "reconstruction",
                     rf_reconstruction_name( s->reconstruction ), "shared_paths", "found", count_json( stats->rays.thinned ),
                     "kept", count_json( stats->rays.kept ) );
    if ( s->light_paths != RF_LIGHT_PATHS_OFF )
        rf_json_add( json, "{s:s, s:s}", "light_paths", rf_light_paths_name( s->light_paths ), "kernel_normalization",
                     rf_kernel_normalization_name( s->kernel_normalization ) );
    rf_json_add( json, "{s:s*, s:s*, s:s*, s:o*, s:o?, s:o, s:i, s:b, s:O, s:s, s:i, s:o, s:o, s:o*, s:s, s:i}", "names",
                 files->names != RF_NAMES_REFRAME ? rf_pass_names_words[files->names] : NULL, "colorspace",
                 files->colour_space != RF_REC709 ? rf_colour_space_words[files->colour_space] : NULL, "overscan",
                 options->overscan, "timecode", files->time_code != NULL ? rf_json_text( files->time_code ) : NULL, "specks",
                 rf_sum_specks( frames ), "clipped_pixels", sum_clipped( frames ), "repeated_frames",
                 job->frame_count - job->run_count, "adaptive", s->adaptive == RF_ADAPTIVE_ON || stats->adaptive_frames > 0,
                 "warnings", job->reported.lines, "adaptive_mode", rf_adaptive_name( s->adaptive ), "adaptive_frames",
                 stats->adaptive_frames, "beyond_depth_share", rf_json_number( job->output.beyond_depth ), "clamp",
                 s->clamp == RF_CLAMP_AUTO ? json_string( "auto" )
                 : s->clamp == 0.0         ? json_string( "off" )
                                           : rf_json_number( s->clamp ),
                 "clamp_chains", s->clamp_chains > 0.0 ? rf_json_number( s->clamp_chains ) : NULL, "guide",
                 rf_guiding_name( s->guide ), "guide_tables", stats->guide_tables );
    if ( job->denoiser != NULL )
    {
        RfErrorEstimate mean = rf_denoised_error( &job->denoised );
        json_t* denoised = rf_denoised_json( job->noisy_sum / job->denoised.frames, &mean );
        rf_json_add( json, "{s:o}", "denoised", rf_json_add( denoised, "{s:s}", "denoiser", rf_denoiser_name( job->denoiser ) ) );
    }
    if ( s->noise > 0.0 )
        rf_json_add( json, "{s:{s:f, s:i}}", "noise", "wanted", s->noise, "missed", stats->missed );
    if ( s->flicker > 0.0 )
        rf_json_add( json, "{s:{s:f, s:i}}", "flicker", "wanted", s->flicker, "missed", stats->flicker_missed );
    if ( s->time > 0.0 )
        rf_json_add( json, "{s:{s:f, s:b}}", "time", "wanted", s->time, "too_short", stats->hurried );
    return rf_json_add( json, "{s:o, s:o, s:o, s:{s:f, s:i, s:f}}", "losses",
                        rf_json_texts( (const char* const*)scene->losses, scene->loss_count ), "export_losses",
                        rf_json_texts( (const char* const*)scene->export_losses, scene->export_loss_count ), "export_warnings",
                        rf_json_texts( (const char* const*)scene->export_warnings, scene->export_warning_count ), "halo", "share",
                        job->halo.share, "group", job->halo.group, "saved", job->halo.saved );
}

static bool is_render_json( const json_t* json )
{
    return json_is_array( json_object_get( json, "frames" ) ) && json_is_object( json_object_get( json, "rays" ) ) &&
           json_is_number( json_object_get( json, "seconds" ) );
}

static json_t* parse_json( const char* path, RfError* error )
{
    uint8_t* bytes;
    size_t size;
    if ( rf_read_file( path, MOST_JSON_BYTES, &bytes, &size, error ) != RF_OK )
        return NULL;
    json_error_t reason;
    errno = 0;
    json_t* json = json_loadb( (const char*)bytes, size, 0, &reason );
    bool no_memory = errno == ENOMEM;
    free( bytes );
    if ( json == NULL && no_memory )
        rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory: close other programs", path );
    else if ( json == NULL )
        rf_fail( error, RF_ERROR_FORMAT, "%s: line %d: %s", path, reason.line, reason.text );
    return json;
}

RfResult rf_load_render_json( const char* path, const char* option, json_t** json, RfError* error )
{
    RfError reason = { 0 };
    json_t* loaded = parse_json( path, &reason );
    if ( loaded == NULL )
        return rf_fail( error, reason.code, "%s: %.900s", option, reason.text );
    if ( !is_render_json( loaded ) )
    {
        json_decref( loaded );
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %s: is not what reframe render --json writes", option, path );
    }
    json_decref( *json );
    *json = loaded;
    return RF_OK;
}

RfResult rf_find_render_json( const char* folder, json_t** json, RfError* error )
{
    RfFolderList list;
    RfResult result = rf_list_folder( folder, ".json", &list, error );
    for ( int i = 0; i < list.count && result == RF_OK && *json == NULL; ++i )
    {
        char path[RF_FILE_NAME_SIZE];
        if ( snprintf( path, sizeof path, "%s/%s", folder, list.names[i] ) < (int)sizeof path )
            rf_load_render_json( path, "", json, NULL );
    }
    rf_free_folder_list( &list );
    return result;
}
