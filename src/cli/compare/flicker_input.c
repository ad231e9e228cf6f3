#include "cli/compare/flicker_run.h"

#include "cli/messages.h"
#include "cli/options/frame_list.h"
#include "measure/sequences.h"
#include "reframe/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

RfResult rf_flicker_path( const char* pattern, int frame, char path[RF_FLICKER_NAME_SIZE], RfError* error )
{
    return rf_sequence_name( pattern, frame, path, RF_FLICKER_NAME_SIZE, error );
}

// Keeps the frames that --frames names, all of which must exist.
static RfResult choose_frames( RfFlickerRun* flicker, RfError* error )
{
    int *wanted, count, last = flicker->frames[flicker->frame_count - 1];
    RfResult result = rf_parse_frames( flicker->frame_list, last > 0 ? last : 1, &wanted, &count, error );
    for ( int i = 0, from = 0; i < count && result == RF_OK; ++i )
    {
        int number = wanted[i] + 1;
        while ( from < flicker->frame_count && flicker->frames[from] < number )
            ++from;
        if ( from == flicker->frame_count || flicker->frames[from] != number )
            result = rf_fail( error, RF_ERROR_IO, "%s: frame %d is missing", flicker->pattern, number );
    }
    if ( result != RF_OK )
    {
        free( wanted );
        return result;
    }
    free( flicker->frames );
    flicker->frames = wanted;
    flicker->frame_count = count;
    for ( int i = 0; i < count; ++i )
        wanted[i] += 1;
    return RF_OK;
}

static RfResult check_frames( const RfFlickerRun* flicker, RfError* error )
{
    if ( flicker->frame_count < 2 )
        return rf_fail( error, RF_ERROR_IO, "%s: is frame %d alone: flicker wants two neighbouring ones at least",
                        flicker->pattern, flicker->frames[0] );
    int step = rf_sequence_step( flicker->pattern, flicker->frames[0] );
    for ( int i = 1; i < flicker->frame_count; ++i )
    {
        int before = flicker->frames[i - 1], now = flicker->frames[i];
        if ( now != before + step )
            return rf_fail( error, RF_ERROR_IO,
                            "%s: after frame %d comes %d: flicker wants every frame: choose neighbouring ones by --frames",
                            flicker->pattern, before, now );
    }
    return RF_OK;
}

// Checks before the work that the reference has all frames.
static RfResult check_reference( const RfFlickerRun* flicker, RfError* error )
{
    char path[RF_FLICKER_NAME_SIZE];
    for ( int i = 0; i < flicker->frame_count; ++i )
    {
        RfResult result = rf_flicker_path( flicker->reference, flicker->frames[i], path, error );
        if ( result != RF_OK )
            return result;
        if ( access( path, F_OK ) != 0 )
            return rf_fail( error, RF_ERROR_IO, "%.400s: is not there: the reference wants frame %d as %.400s has it", path,
                            flicker->frames[i], flicker->pattern );
    }
    return RF_OK;
}

RfResult rf_find_flicker_frames( RfFlickerRun* flicker, RfError* error )
{
    const char* patterns[2] = { flicker->pattern, flicker->reference };
    for ( int i = 0; i < 2; ++i )
    {
        if ( patterns[i] != NULL && !rf_is_sequence( patterns[i] ) )
            return rf_fail( error, RF_ERROR_USAGE, "%s%s: has no #### for the frame's number: give a sequence",
                            i == 1 ? "--reference: " : "", patterns[i] );
    }
    RfResult result = rf_sequence_frames( flicker->pattern, &flicker->frames, &flicker->frame_count, error );
    if ( result != RF_OK )
        return result;
    flicker->first_frame = flicker->frames[0];
    if ( flicker->frame_list != NULL )
        result = choose_frames( flicker, error );
    if ( result == RF_OK )
        result = check_frames( flicker, error );
    if ( result == RF_OK && flicker->reference != NULL )
        result = check_reference( flicker, error );
    return result;
}

static RfResult fail_no_motion( const RfFlickerRun* flicker, RfError* error )
{
    return rf_fail( error, RF_ERROR_FORMAT,
                    "%s: has no motion layer to follow: name its channels by --motion X,Y, or render --aov motion,depth",
                    flicker->first_path );
}

// Errors about names that were given, "motion: ...", are errors of the options.
static void name_option( const RfFlickerRun* flicker, RfError* error )
{
    bool given = flicker->motion != NULL || flicker->depth != NULL;
    if ( error->remedy == RF_REMEDY_NONE && given )
        rf_fail( error, error->code, "--%s", error->text );
}

// Layers of the main figures: those of the first frame, which all frames must have.
static RfResult find_main_layers( RfFlickerRun* flicker, bool compensate, RfError* error )
{
    RfFlickerLayers* layers = &flicker->layers;
    RfResult result = rf_read_exr_header( flicker->first_path, flicker->layer, &flicker->layered, error );
    if ( result == RF_OK && compensate )
    {
        result = rf_find_flicker_layers( flicker->first_path, &flicker->layered, flicker->motion, flicker->depth, layers, error );
        if ( result != RF_OK )
            name_option( flicker, error );
    }
    // the variance is the colour's, not that of another layer
    if ( result == RF_OK && flicker->reference == NULL && flicker->layer == NULL )
        result = rf_find_variance_layers( flicker->first_path, &flicker->layered, layers, error );
    if ( result == RF_OK && layers->motion[0] == NULL && ( flicker->compensate || flicker->depth != NULL ) )
        return fail_no_motion( flicker, error );
    flicker->report.compensated = layers->motion[0] != NULL;
    return result;
}

// Layers of the additional figures along the motion: those of the first frame that has any. If
// they are ambiguous the figures are left out, with a note.
static RfResult find_layers_beside( RfFlickerRun* flicker, RfError* error )
{
    char path[RF_FLICKER_NAME_SIZE];
    RfFlickerLayers* layers = &flicker->layers;
    RfError unclear = { 0 };
    RfResult result = RF_OK;
    for ( int i = 0; i < flicker->frame_count && layers->motion[0] == NULL && unclear.code == RF_OK && result == RF_OK; ++i )
    {
        rf_destroy_exr_header( &flicker->layered );
        result = rf_flicker_path( flicker->pattern, flicker->frames[i], path, error );
        if ( result == RF_OK )
            result = rf_read_exr_header( path, flicker->layer, &flicker->layered, error );
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
        rf_format_error( &unclear, flicker->report.unfollowed, sizeof flicker->report.unfollowed );
    flicker->report.follows = layers->motion[0] != NULL;
    layers->may_lack = true;
    return RF_OK;
}

RfResult rf_find_layers_to_read( RfFlickerRun* flicker, RfError* error )
{
    RfFlickerReport* report = &flicker->report;
    RfFlickerLayers* layers = &flicker->layers;
    RfResult result = rf_flicker_path( flicker->pattern, flicker->frames[0], flicker->first_path, error );
    if ( result == RF_OK )
        result = rf_read_exr_header( flicker->first_path, flicker->layer, &flicker->header, error );
    if ( result != RF_OK )
        return result;
    bool by_default = flicker->reference == NULL || flicker->motion != NULL;
    bool beside = !by_default && !flicker->compensate_given;
    bool compensate = flicker->compensate_given ? flicker->compensate : by_default;
    result = beside ? find_layers_beside( flicker, error ) : find_main_layers( flicker, compensate, error );
    if ( result != RF_OK )
        return result;
    layers->colour = flicker->layer;
    if ( flicker->reference_layer == NULL )
        flicker->reference_layer = flicker->layer;
    layers->depth = layers->motion[0] != NULL ? layers->depth : NULL;
    report->masked = layers->depth != NULL;
    report->source = flicker->reference != NULL    ? RF_ERROR_FROM_REFERENCE
                     : layers->variance[0] != NULL ? RF_ERROR_FROM_VARIANCE
                                                   : RF_ERROR_UNKNOWN;
    return RF_OK;
}
