#include "cli/report/report_values.h"

#include "cli/report/report_blocks.h"
#include "cli/report/report_verdict.h"
#include "page/values.h"

#include <math.h>

#define BLOCK_BYTES 64 // of the markup about a block

// Of the bytes for values each sequence has an equal part. Where not all its frames can have those of each
// pixel, the one with the largest error shall.
static double value_share( const RfPageRun* report ) { return (double)report->values / report->sequence_count; }

static double fine_share( const RfPageRun* report, const RfPageTrack* track )
{
    const RfExrHeader* header = &track->sequence->header;
    double whole = rf_values_page_bytes( header->width, header->height, 1 ) + BLOCK_BYTES, share = value_share( report );
    return report->count * whole <= share ? 0.0 : fmin( whole, 0.7 * share );
}

int rf_page_value_factor( const RfPageRun* report, const RfPageTrack* track )
{
    const RfExrHeader* header = &track->sequence->header;
    double rest = value_share( report ) - fine_share( report, track );
    return rf_values_factor( header->width, header->height, rest / report->count - BLOCK_BYTES );
}

RfResult rf_add_fine_values( RfPageRun* report, const RfPageData* data, RfPage* page, RfError* error )
{
    RfResult result = RF_OK;
    int track_index, worst = rf_worst_page_frame( data, &track_index );
    int number = report->numbers[worst >= 0 ? worst : 0];
    for ( int i = 0; i < report->sequence_count && result == RF_OK; ++i )
    {
        RfPageTrack* track = report->tracks + i;
        const RfExrHeader* header = &track->sequence->header;
        int factor = rf_values_factor( header->width, header->height, fine_share( report, track ) - BLOCK_BYTES );
        bool is_finer = factor > 0 && ( track->value_factor == 0 || factor < track->value_factor );
        if ( is_finer && rf_has_page_frame( track->sequence, number ) )
            result = rf_add_page_fine_values( page, track, number, factor, error );
    }
    return result;
}
