#include "cli/report/report_data.h"

#include "cli/report/report_cost.h"
#include "cli/report/report_facts.h"
#include "cli/report/report_verdict.h"
#include "cli/report/report_warnings.h"
#include "cli/messages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static json_t* blocks_json( const RfPageTrack* track )
{
    json_t* blocks = json_array();
    char id[32];
    for ( int i = 0; i < track->count; ++i )
    {
        rf_page_block_id( track, track->numbers[i], id );
        json_array_append_new( blocks, track->frames[i].shown ? json_string( id ) : json_null() );
    }
    return blocks;
}

static void set_curves( json_t* object, const RfPageTrack* track )
{
    json_t *relmse = json_array(), *phi = json_array(), *f1 = json_array(), *seconds = json_array(), *samples = json_array(),
           *bad = json_array(), *at_least = json_array();
    for ( int i = 0; i < track->count; ++i )
    {
        const RfPageFrame* frame = track->frames + i;
        json_array_append_new( relmse, rf_json_number( frame->relmse ) );
        json_array_append_new( phi, rf_json_number( frame->phi ) );
        json_array_append_new( f1, rf_json_number( frame->f1 ) );
        json_array_append_new( seconds, rf_json_number( frame->seconds ) );
        json_array_append_new( samples, rf_json_number( frame->samples ) );
        json_array_append_new( bad, json_integer( (json_int_t)frame->bad ) );
        json_array_append_new( at_least, json_boolean( frame->at_least ) );
    }
    json_object_set_new( object, "relmse", relmse );
    json_object_set_new( object, "phi", phi );
    json_object_set_new( object, "f1", f1 );
    json_object_set_new( object, "seconds", seconds );
    json_object_set_new( object, "samples", samples );
    json_object_set_new( object, "bad", bad );
    json_object_set_new( object, "at_least", at_least );
}

static json_t* has_layers_json( const RfPageTrack* track )
{
    json_t* list = json_array();
    for ( int i = 0; i < track->count; ++i )
        json_array_append_new( list, json_boolean( track->frames[i].has_layers ) );
    return list;
}

static json_t* track_json( const RfPageTrack* track )
{
    json_t* object = json_pack( "{s:o, s:o, s:b, s:i, s:i, s:o, s:o}", "name", rf_json_text( track->sequence->name ), "path",
                                rf_json_text( track->sequence->pattern ), "reference", track->sequence->is_reference, "width",
                                track->picture_width, "height", track->picture_height, "blocks", blocks_json( track ), "facts",
                                rf_page_facts_json( track ) );
    json_object_set_new( object, "file_width", json_integer( track->sequence->header.width ) );
    json_object_set_new( object, "file_height", json_integer( track->sequence->header.height ) );
    json_object_set_new( object, "index", json_integer( track->index ) );
    json_object_set_new( object, "layers", rf_page_layers_json( &track->layers ) );
    json_object_set_new( object, "has_layers", has_layers_json( track ) );
    json_object_set_new( object, "value_factor", json_integer( track->value_factor ) );
    json_object_set_new( object, "fine_frame", json_integer( track->fine_frame ) );
    json_object_set_new( object, "fine_factor", json_integer( track->fine_factor ) );
    set_curves( object, track );
    return object;
}

static json_t* notes_json( const RfPageData* data )
{
    bool compensated = false, still = false, variance = false;
    for ( int i = 0; i < data->track_count; ++i )
    {
        compensated |= data->tracks[i].compensated;
        still |= !data->tracks[i].compensated;
        variance |= data->tracks[i].has_variance;
    }
    const char* f1 =
        data->has_reference    ? "How much the error changes from the frame before, root mean square"
        : compensated && still ? "Change from the frame before, root mean square: along the motion layers where there are any"
        : compensated          ? "Change from the frame before along the motion layers, root mean square"
                      : "Change of the picture from the frame before, root mean square: what moves counts too (no motion layers)";
    const char* phi =
        data->has_reference ? "1: the error is new in each frame, 0: it stands still"
        : variance ? "The change over the variance layers; moving edges and highlights count too, a reference takes them out"
                   : "";
    return json_pack( "{s:s, s:s, s:s, s:s, s:s}", "relmse",
                      data->has_reference ? "Against the reference" : "Estimated by the renderer, without a reference", "phi",
                      phi, "f1", f1, "seconds", "Each frame's, as the renderer told", "samples",
                      "Traced per pixel of each frame" );
}

json_t* rf_page_data_json( const RfPageData* data )
{
    json_t *tracks = json_array(), *frames = json_array();
    for ( int i = 0; i < data->track_count; ++i )
        json_array_append_new( tracks, track_json( data->tracks + i ) );
    for ( int i = 0; i < data->count; ++i )
        json_array_append_new( frames, json_integer( data->numbers[i] ) );
    char subtitle[96];
    const RfExrHeader* header = &data->tracks[0].sequence->header;
    snprintf( subtitle, sizeof subtitle, "%d frame%s of %dx%d pixels", data->count, data->count == 1 ? "" : "s", header->width,
              header->height );
    return json_pack( "{s:o, s:s, s:f, s:f, s:o, s:o, s:o, s:o, s:o, s:o}", "title", rf_json_text( data->title ), "subtitle",
                      subtitle, "fps", data->fps, "exposure", data->exposure, "frames", frames, "sequences", tracks, "notes",
                      notes_json( data ), "cost", rf_page_cost_json( data ), "verdict", rf_page_verdict_json( data ), "warnings",
                      rf_page_warnings_json( data ) );
}

json_t* rf_page_result_json( const RfPageData* data, const char* output, uint64_t bytes )
{
    json_t* tracks = json_array();
    for ( int i = 0; i < data->track_count; ++i )
    {
        const RfPageTrack* track = data->tracks + i;
        RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
        bool has_flicker = track->flicker.pairs > 0;
        int shown = 0, lacking;
        int* missing = rf_page_missing_frames( track, &lacking );
        for ( int k = 0; k < track->count; ++k )
            shown += track->frames[k].shown;
        json_array_append_new(
            tracks,
            json_pack( "{s:o, s:o, s:b, s:i, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "name",
                       rf_json_text( track->sequence->name ), "files", rf_json_text( track->sequence->pattern ), "reference",
                       track->sequence->is_reference, "frames", shown, "missing", lacking, "missing_frames",
                       rf_json_frames( missing, lacking ), "picture_bytes", json_integer( (json_int_t)track->picture_bytes ),
                       "value_bytes", json_integer( (json_int_t)track->value_bytes ), "aov_bytes",
                       json_integer( (json_int_t)track->layer_bytes ), "relmse",
                       rf_json_number( track->has_error ? track->error.relmse : NAN ), "relmse_estimate",
                       rf_json_number( track->estimate ), "f1", rf_json_number( has_flicker ? flicker.f1 : NAN ), "phi",
                       rf_json_number( has_flicker ? flicker.phi : NAN ) ) );
        if ( track->sequence->progress != NULL )
            json_object_set( json_array_get( tracks, (size_t)i ), "progress", track->sequence->progress );
        free( missing );
    }
    json_t* verdict = rf_page_verdict_json( data );
    json_t* json = json_pack( "{s:o, s:o, s:i, s:o, s:O, s:O, s:o}", "output", rf_json_text( output ), "bytes",
                              json_integer( (json_int_t)bytes ), "frames", data->count, "sequences", tracks, "verdict",
                              json_object_get( verdict, "text" ), "worst_frame", json_object_get( verdict, "worst_frame" ),
                              "warnings", rf_page_warnings_json( data ) );
    json_decref( verdict );
    return json;
}
