// Plans the rounds. Decisions depend on the arguments only, not on a clock.
#include "measure/tune_internal.h"

#include <math.h>
#include <stdlib.h>

#define REGION_FRAMES 7   // approximately, for trying small groups
#define MIN_PIXELS 2500.0 // four pieces, and what is traced around them
#define MAX_REGIONS 24

// Fraction of the remaining time for each round.
static const double s_shares[RF_TUNE_ROUNDS] = { 0.3, 0.33, 0.5, 1.0 };
static const int s_regions[RF_TUNE_ROUNDS] = { 2, 2, 3, 4 };
static const int s_passes[RF_TUNE_ROUNDS] = { 2, 4, 4, 4 };

#define FEW 4    // with this many settings left, a round may use all the remaining time
#define HOPE 0.5 // fraction of the best efficiency below which a row is dropped

int rf_tune_groups( int eyes ) { return eyes < REGION_FRAMES ? ( REGION_FRAMES + eyes / 2 ) / eyes : 1; }

int rf_tune_region_frames( const RfTune* tune, const bool* candidate )
{
    int frames = 1;
    for ( int i = 0; i < tune->count; ++i )
    {
        int wanted = tune->rows[i].eyes * rf_tune_groups( tune->rows[i].eyes );
        frames = candidate[i] && wanted > frames ? wanted : frames;
    }
    return frames;
}

double rf_tune_row_samples( const RfTuneRow* row, int passes ) { return 2.0 * passes * row->eyes * rf_tune_groups( row->eyes ); }

double rf_tune_round_cost( const RfTune* tune, const bool* candidate, const RfTuneRound* round, double cost_second )
{
    double cost = 0.0;
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTuneRow* row = tune->rows + i;
        double sample = row->rounds > 0 ? rf_trial_sample_seconds( &row->trial ) : row->cost * cost_second;
        cost += candidate[i] ? round->regions * round->pixels * rf_tune_row_samples( row, round->passes ) * sample : 0.0;
    }
    return cost;
}

// Pixels per frame such that what is kept of the test regions and the parallel trials fits in half the memory;
// the other half is for the renders.
static double pixels_that_fit( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, int regions )
{
    int eyes = rf_tune_region_frames( tune, candidate );
    double bytes = (double)rf_test_region_bytes( eyes, RF_CELL_PIXELS ) * regions +
                   (double)o->workers * (double)rf_trial_bytes( eyes, RF_CELL_PIXELS );
    return 0.5 * (double)o->memory / bytes * RF_CELL_PIXELS;
}

static int count_candidates_in( const RfTune* tune, const bool* candidate )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += candidate[i];
    return count;
}

bool rf_plan_tune_round( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, RfTuneRound* round )
{
    double all = (double)o->width * o->height,
           seconds = ( count_candidates_in( tune, candidate ) > FEW ? s_shares[o->number] : 1.0 ) * o->left;
    int passes = s_passes[o->number] > o->passes ? s_passes[o->number] : o->passes;
    *round = ( RfTuneRound ){ .regions = s_regions[o->number], .passes = passes, .pixels = 1.0 };
    double each = rf_tune_round_cost( tune, candidate, round, o->cost_second ); // per pixel
    double pixels = seconds * o->rate / each, most = pixels_that_fit( tune, candidate, o, round->regions );
    most = most < all ? most : all;
    double least = MIN_PIXELS < most ? MIN_PIXELS : most;
    for ( ; pixels < least && round->regions > 1; --round->regions ) // fewer positions rather than too small pieces
        pixels *= round->regions / ( round->regions - 1.0 );
    if ( pixels > most ) // more positions from the time left
        round->regions = (int)fmin( MAX_REGIONS, floor( round->regions * pixels / most ) );
    round->pixels = fmax( fmin( pixels, most ), least );
    if ( o->number > 0 && pixels < least )
        return false;
    round->seconds = rf_tune_round_cost( tune, candidate, round, o->cost_second ) / o->rate;
    return true;
}

// Orders efficiencies, largest first.
static int descending( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x < y ) - ( x > y );
}

void rf_cut_tune_candidates( const RfTune* tune, int kept, bool* candidate )
{
    double sorted[RF_TUNE_ROWS];
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
    {
        candidate[i] = candidate[i] && isfinite( tune->rows[i].efficiency );
        if ( candidate[i] )
            sorted[count++] = tune->rows[i].efficiency;
    }
    if ( count == 0 )
        return;
    qsort( sorted, (size_t)count, sizeof *sorted, descending );
    double bar = fmax( HOPE * sorted[0], sorted[kept < count ? kept - 1 : count - 1] );
    for ( int i = 0; i < tune->count; ++i )
        candidate[i] = candidate[i] && ( tune->rows[i].efficiency >= bar || rf_is_plain_row( tune->rows + i ) );
}

double rf_tune_position( int index )
{
    double position = 0.0, part = 0.5;
    for ( int i = index + 1; i > 0; i /= 2, part /= 2.0 )
        position += i % 2 * part;
    return position;
}
