#include "cli/report/report_run.h"

#include "cli/options/frame_list.h"
#include "cli/report/report_cost.h"
#include "image/sequence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static RfResult open_sequences( RfPageRun* report, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < report->place_count && result == RF_OK; ++i )
        result = rf_open_page_sequence( report->places[i], report->layer, report->sequences + report->sequence_count++, error );
    if ( result == RF_OK && report->reference != NULL )
    {
        RfPageSequence* reference = report->sequences + report->sequence_count++;
        const char* layer = report->reference_layer != NULL ? report->reference_layer : report->layer;
        result = rf_open_page_sequence( report->reference, layer, reference, error );
        reference->is_reference = true;
    }
    if ( result == RF_OK && report->render_file != NULL )
        result = rf_load_render_json( report->render_file, "--render-json", &report->sequences[0].render, error );
    if ( result == RF_OK && report->cost_file != NULL )
        result = rf_load_cost_json( report->cost_file, "--cost", &report->cost, error );
    return result == RF_OK ? rf_check_cost_scene( report, error ) : result;
}

// Folders of the same name are labelled by the paths that were given.
static void tell_names_apart( RfPageRun* report )
{
    for ( int i = 0; i < report->place_count; ++i )
    {
        bool alike = strcmp( report->sequences[i].name, "." ) == 0 || strcmp( report->sequences[i].name, ".." ) == 0;
        for ( int k = 0; k < report->sequence_count; ++k )
            alike |= k != i && strcmp( report->sequences[i].name, report->sequences[k].name ) == 0;
        if ( alike )
            snprintf( report->sequences[i].name, sizeof report->sequences[i].name, "%.255s", report->places[i] );
    }
    if ( report->reference != NULL )
        snprintf( report->sequences[report->place_count].name, sizeof report->sequences[0].name, "reference" );
}

static int compare_ints( const void* a, const void* b )
{
    int x = *(const int*)a, y = *(const int*)b;
    return ( x > y ) - ( x < y );
}

// The frames of all sequences, each once.
static RfResult join_frames( RfPageRun* report, RfError* error )
{
    int room = 0;
    for ( int i = 0; i < report->place_count; ++i )
        room += report->sequences[i].frame_count;
    report->numbers = malloc( (size_t)room * sizeof( int ) );
    if ( report->numbers == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d frames", room );
    int all = 0;
    for ( int i = 0; i < report->place_count; ++i )
    {
        const RfPageSequence* sequence = report->sequences + i;
        memcpy( report->numbers + all, sequence->frames, (size_t)sequence->frame_count * sizeof( int ) );
        all += sequence->frame_count;
    }
    qsort( report->numbers, (size_t)all, sizeof( int ), compare_ints );
    for ( int i = 0; i < all; ++i )
    {
        if ( report->count == 0 || report->numbers[report->count - 1] != report->numbers[i] )
            report->numbers[report->count++] = report->numbers[i];
    }
    return RF_OK;
}

// Keeps those of the ascending numbers that are wanted (indices from 0).
static int keep_wanted( int* numbers, int count, const int* wanted, int wanted_count )
{
    int left = 0;
    for ( int i = 0, k = 0; i < count; ++i )
    {
        while ( k < wanted_count && wanted[k] + 1 < numbers[i] )
            ++k;
        if ( k < wanted_count && wanted[k] + 1 == numbers[i] )
            numbers[left++] = numbers[i];
    }
    return left;
}

static RfResult choose_frames( RfPageRun* report, RfError* error )
{
    int *wanted, count, last = report->numbers[report->count - 1];
    if ( report->frame_list == NULL )
        return RF_OK;
    RfResult result = rf_parse_frames( report->frame_list, last > 0 ? last : 1, &wanted, &count, error );
    if ( result != RF_OK )
        return result;
    report->count = keep_wanted( report->numbers, report->count, wanted, count );
    report->hole_count = keep_wanted( report->holes, report->hole_count, wanted, count );
    free( wanted );
    if ( report->count == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: '%s': none of these is there", report->frame_list );
    return result;
}

static void count_pictures( RfPageRun* report )
{
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        for ( int k = 0; k < report->count; ++k )
            report->all += rf_has_page_frame( report->sequences + i, report->numbers[k] );
    }
}

RfResult rf_prepare_page( RfPageRun* report, RfError* error )
{
    RfResult result = open_sequences( report, error );
    if ( result == RF_OK )
        result = join_frames( report, error );
    if ( result == RF_OK )
        result = rf_missing_frames( report->numbers, report->count, &report->holes, &report->hole_count, error );
    if ( result == RF_OK )
        result = choose_frames( report, error );
    if ( result != RF_OK )
        return result;
    tell_names_apart( report );
    count_pictures( report );
    return RF_OK;
}

void rf_destroy_page_run( RfPageRun* report )
{
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        rf_close_page_sequence( report->sequences + i );
        rf_free_page_track( report->tracks + i );
    }
    json_decref( report->cost );
    free( report->numbers );
    free( report->holes );
}
