// Prints what changes.
#include "cli/render/changes_json.h"

#include "base/words.h"
#include "cli/messages.h"
#include "render/sharing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for what changes in the scene" );
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
