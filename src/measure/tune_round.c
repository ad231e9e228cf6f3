// What a round tries: decisions from what is known, without a clock of their own.
#include "measure/tune_internal.h"

#include <math.h>
#include <stdlib.h>

#define SITE_FRAMES 15 // about, that small groups are tried on
#define LEAST_PIXELS 1200.0
#define MOST_SITES 24

// Of the time left, for each round.
static const double s_shares[RF_TUNE_ROUNDS] = { 0.3, 0.33, 0.5, 1.0 };
static const int s_sites[RF_TUNE_ROUNDS] = { 2, 2, 3, 4 };
static const int s_passes[RF_TUNE_ROUNDS] = { 2, 4, 4, 4 };

#define FEW 4    // settings, for which a round may take all the time that is left
#define HOPE 0.5 // of the best efficiency, below which a row is not tried again

int rf_tune_groups( int eyes ) { return eyes < SITE_FRAMES ? ( SITE_FRAMES + eyes / 2 ) / eyes : 1; }

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
    double cost = 0.0, pixels = (double)round->width * round->height;
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTuneRow* row = tune->rows + i;
        double sample = row->rounds > 0 ? rf_trial_sample_seconds( &row->trial ) : row->cost * cost_second;
        cost += candidate[i] ? round->sites * pixels * rf_tune_row_samples( row, round->passes ) * sample : 0.0;
    }
    return cost;
}

// A film of about so many pixels, in the render's proportions.
static void size_round( const RfTuneOutlook* o, double pixels, RfTuneRound* round )
{
    double scale = sqrt( pixels / ( (double)o->width * o->height ) );
    round->width = scale < 1.0 ? (int)fmax( 1.0, floor( o->width * scale + 0.5 ) ) : o->width;
    round->height = scale < 1.0 ? (int)fmax( 1.0, floor( o->height * scale + 0.5 ) ) : o->height;
}

// Pixels of a film with which the trials that run at a time, and the sites, fit
// the memory: half of it, for records and work besides.
static double pixels_that_fit( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, int sites )
{
    int eyes = rf_tune_region_frames( tune, candidate );
    double film = 64.0 + 12.0; // both halves with totals, and images
    double bytes =
        (double)rf_test_region_bytes( eyes, 1 ) * sites + o->workers * ( (double)rf_trial_bytes( eyes, 1 ) + film * eyes );
    return 0.5 * (double)o->memory / bytes;
}

static int candidates( const RfTune* tune, const bool* candidate )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += candidate[i];
    return count;
}

bool rf_plan_tune_round( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, RfTuneRound* round )
{
    double all = (double)o->width * o->height,
           seconds = ( candidates( tune, candidate ) > FEW ? s_shares[o->number] : 1.0 ) * o->left;
    *round = ( RfTuneRound ){ .sites = s_sites[o->number], .passes = s_passes[o->number], .width = 1, .height = 1 };
    double each = rf_tune_round_cost( tune, candidate, round, o->cost_second ); // for one pixel
    double pixels = seconds * o->rate / each, most = pixels_that_fit( tune, candidate, o, round->sites );
    most = most < all ? most : all;
    double least = LEAST_PIXELS < most ? LEAST_PIXELS : most;
    for ( ; pixels < least && round->sites > 1; --round->sites ) // fewer places, rather than too small pictures
        pixels *= round->sites / ( round->sites - 1.0 );
    if ( pixels > most ) // more places for what is left
        round->sites = (int)fmin( MOST_SITES, floor( round->sites * pixels / most ) );
    size_round( o, fmax( fmin( pixels, most ), least ), round );
    if ( o->number > 0 && pixels < least )
        return false;
    round->seconds = rf_tune_round_cost( tune, candidate, round, o->cost_second ) / o->rate;
    return true;
}

// Efficiencies, largest first.
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
        candidate[i] = candidate[i] && tune->rows[i].efficiency >= bar;
}

double rf_tune_place( int index )
{
    double place = 0.0, part = 0.5;
    for ( int i = index + 1; i > 0; i /= 2, part /= 2.0 )
        place += i % 2 * part;
    return place;
}
