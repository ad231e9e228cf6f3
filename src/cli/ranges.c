#include "cli/ranges.h"

#include "cli/messages.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ENTRY 40 // characters of "-1234567890-1234567890x1234567890,"

RfResult rf_cut_ranges( int nodes, const int* numbers, int step, int eye_count, const int* eyes, int frame_count,
                        const RfRenderSettings* settings, RfRanges* ranges, RfError* error )
{
    int most = nodes < frame_count ? nodes : frame_count;
    *ranges = ( RfRanges ){ .list = malloc( (size_t)most * sizeof( RfPlanRange ) ),
                            .nodes = nodes,
                            .group = settings->group,
                            .numbers = numbers,
                            .step = step };
    if ( ranges->list == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for %d ranges", most );
    return rf_plan_ranges( eye_count, eyes, frame_count, settings, nodes, ranges->list, &ranges->count, error );
}

void rf_free_ranges( RfRanges* ranges )
{
    free( ranges->list );
    *ranges = ( RfRanges ){ 0 };
}

// Numbers from the first on that are evenly spaced; two are no series unless they are neighbours in the path.
static int series( const int* numbers, int count, int step )
{
    int length = count > 1 ? 2 : 1;
    while ( length > 1 && length < count && numbers[length] - numbers[length - 1] == numbers[1] - numbers[0] )
        ++length;
    return length == 2 && numbers[1] - numbers[0] != step ? 1 : length;
}

char* rf_frame_list( const int* numbers, int count, int step )
{
    char* text = malloc( (size_t)( count > 0 ? count : 1 ) * ENTRY );
    size_t used = 0;
    if ( text == NULL )
        return NULL;
    text[0] = '\0';
    for ( int i = 0, length; i < count; i += length )
    {
        length = series( numbers + i, count - i, step );
        int apart = length > 1 ? numbers[i + 1] - numbers[i] : step;
        used += (size_t)snprintf( text + used, ENTRY, "%s%d", i > 0 ? "," : "", numbers[i] );
        if ( length > 1 )
            used += (size_t)snprintf( text + used, ENTRY, "-%d", numbers[i + length - 1] );
        if ( apart != step )
            used += (size_t)snprintf( text + used, ENTRY, "x%d", apart );
    }
    return text;
}

static void sum_up( const RfRanges* r, double* all, double* longest )
{
    *all = *longest = 0.0;
    for ( int i = 0; i < r->count; ++i )
    {
        *all += r->list[i].work;
        *longest = r->list[i].work > *longest ? r->list[i].work : *longest;
    }
}

void rf_print_ranges( const RfRanges* r )
{
    double all, longest;
    sum_up( r, &all, &longest );
    printf( "\n%d range%s for --nodes %d, group %d, and what each traces of the whole:\n", r->count, r->count == 1 ? "" : "s",
            r->nodes, r->group );
    for ( int i = 0; i < r->count; ++i )
    {
        const RfPlanRange* range = r->list + i;
        char* frames = rf_frame_list( r->numbers + range->first, range->end - range->first, r->step );
        printf( "  --frames %-16s %5d frame%s %6.1f %%\n", frames != NULL ? frames : "?", range->end - range->first,
                range->end - range->first == 1 ? " " : "s", 100.0 * range->work );
        free( frames );
    }
    printf(
        "overhead of the halos at the cuts: %.1f %% more samples in all; at best done in %.1f %% of the time of one machine\n",
        100.0 * ( all - 1.0 ), 100.0 * longest );
}

json_t* rf_ranges_json( const RfRanges* r )
{
    double all, longest;
    sum_up( r, &all, &longest );
    json_t* list = json_array();
    for ( int i = 0; i < r->count; ++i )
    {
        const RfPlanRange* range = r->list + i;
        char* frames = rf_frame_list( r->numbers + range->first, range->end - range->first, r->step );
        json_array_append_new( list, json_pack( "{s:s, s:i, s:f}", "frames", frames != NULL ? frames : "", "count",
                                                range->end - range->first, "work", range->work ) );
        free( frames );
    }
    return json_pack( "{s:i, s:i, s:i, s:o, s:f, s:f}", "wanted", r->nodes, "group", r->group, "step", r->step, "ranges", list,
                      "overhead", all - 1.0, "longest", longest );
}
