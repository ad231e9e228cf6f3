#include "image/sequence.h"

#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int smallest_step( const int* frames, int count )
{
    int step = INT_MAX;
    for ( int i = 1; i < count; ++i )
        step = frames[i] - frames[i - 1] < step ? frames[i] - frames[i - 1] : step;
    return step;
}

// Adds the numbers between two neighbours; with `missing` NULL only counts them.
static int add_between( int before, int now, int step, int* missing, int done )
{
    for ( int64_t frame = (int64_t)before + step; frame < now && done < RF_MAX_MISSING; frame += step )
    {
        if ( missing != NULL )
            missing[done] = (int)frame;
        ++done;
    }
    return done;
}

RfResult rf_missing_frames( const int* frames, int count, int** missing, int* missing_count, RfError* error )
{
    int step = smallest_step( frames, count ), all = 0, done = 0;
    *missing = NULL;
    *missing_count = 0;
    for ( int i = 1; i < count; ++i )
        all = add_between( frames[i - 1], frames[i], step, NULL, all );
    if ( all == 0 )
        return RF_OK;
    *missing = malloc( (size_t)all * sizeof( int ) );
    if ( *missing == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d missing frames", all );
    for ( int i = 1; i < count; ++i )
        done = add_between( frames[i - 1], frames[i], step, *missing, done );
    *missing_count = done;
    return RF_OK;
}

void rf_format_frames( const int* frames, int count, char* text, size_t size )
{
    text[0] = '\0';
    for ( int i = 0, next; i < count; i = next )
    {
        char run[32];
        size_t used = strlen( text );
        for ( next = i + 1; next < count && frames[next] == frames[next - 1] + 1; )
            ++next;
        next = next - i < 3 ? i + 1 : next; // a run of two is listed, not written as a range
        if ( next > i + 1 )
            snprintf( run, sizeof run, "%d-%d", frames[i], frames[next - 1] );
        else
            snprintf( run, sizeof run, "%d", frames[i] );
        if ( used + strlen( run ) + 8 > size ) // leave room for ", ..."
        {
            snprintf( text + used, size - used, "%s...", used > 0 ? ", " : "" );
            return;
        }
        snprintf( text + used, size - used, "%s%s", used > 0 ? ", " : "", run );
    }
}
