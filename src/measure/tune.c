// Successive halving over trials: the rows of tune, rounds, candidates, workers and the time budget.
#include "measure/tune.h"

#include "base/remedy.h"
#include "base/system.h"
#include "base/try.h"
#include "reframe/plan.h"
#include "render/groups.h"
#include "render/settings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const int s_groups[RF_TUNE_GROUPS] = { 0, 1, 2, 3, 4, 6, 8, 12, 16 };
static const char* const s_tiles[RF_TUNE_TILES] = { "1", "2x2", "3x3", "4x4", "6x6", "8x8", "rooks16" };
static const char* const s_extended_tiles[RF_TUNE_TILES] = {
    "1", "2x2", "3x3", "4x4", "5x5", "6x6", "8x8"
}; // of estimators without groups

static const char s_no_room[] = "does not fit in memory", s_rounded[] = "spp would more than double",
                  s_hopeless[] = "predicted to gain less than a smaller group";

#define BEYOND 0.97  // of the best gain that the plan predicts for a tile: with less a larger group is not tried
#define ROUNDING 2.0 // limit of the samples traced, as a multiple of those requested

bool rf_is_plain_row( const RfTrialRow* row ) { return row->group == 0 && row->tile.kind == RF_TILE_NONE; }

RfRenderSettings rf_tune_settings( const RfTrialRow* row, const RfRenderSettings* common )
{
    RfRenderSettings settings = *common;
    settings.group = row->group;
    settings.tile = row->tile;
    if ( rf_is_plain_row( row ) ) // whatever the estimator of the others is
        settings.estimator = rf_default_render_settings().estimator;
    if ( rf_has_groups( settings.estimator ) )
        settings.aovs &= ~RF_GRADIENT_AOVS;
    return settings;
}

// The cost of rays, in about nanoseconds, as in the plan.
static double cost_of( const RfPlanRow* row )
{
    return ( 100.0 * row->rays_primary + 200.0 * row->rays_path + 100.0 * row->rays_shadow + 40.0 * row->rays_tile +
             30.0 * row->rays_eye ) /
           row->rays_primary;
}

// What a reused path of a tile is worth, roughly: neighbours' paths are alike. It only decides what is tried first.
static double worth_of( const RfTile* tile )
{
    return tile->kind == RF_TILE_NONE ? 1.0 : sqrt( tile->kind == RF_TILE_BLOCK ? tile->width * tile->height : tile->width );
}

static void take_plan( const RfPlanRow* plan, RfTrialRow* row )
{
    row->efficiency = plan->gain * worth_of( &row->tile );
    row->fit = plan->fit;
    row->samples = plan->samples;
    row->predicted_gain = plan->gain;
    row->cost = cost_of( plan );
}

static RfMemoryFit fit_of( const RfTuneJob* job, const RfTrialRow* row )
{
    RfRenderSettings settings = rf_tune_settings( row, job->settings );
    RfMemoryFit fit;
    rf_fit_memory( &job->shot, &settings, &fit, NULL );
    return fit;
}

// Leaves out the groups of a tile, from row `first` on, that are larger than the best one by the plan: their reuse costs
// more than it brings, and the plan overrates large groups, if anything.
static void drop_hopeless( RfTune* tune, int first )
{
    int best = first;
    for ( int i = first; i < tune->count; ++i )
        best = isgreater( tune->rows[i].predicted_gain, tune->rows[best].predicted_gain ) ? i : best;
    for ( int i = best + 1; i < tune->count; ++i )
    {
        RfTrialRow* row = tune->rows + i;
        if ( row->excluded == NULL && !row->usual && isless( row->predicted_gain, BEYOND * tune->rows[best].predicted_gain ) )
            row->excluded = s_hopeless;
    }
}

// What a render takes by itself where it chooses the tile; group −1: it chooses the group alone.
typedef struct Usual
{
    int group;
    RfTile tile;
} Usual;

static RfResult find_usual( const RfTuneJob* job, const RfRenderSettings* settings, Usual* usual, RfError* error )
{
    RfPlan plan;
    *usual = ( Usual ){ -1, settings->tile };
    if ( settings->tile.kind != RF_TILE_AUTO )
        return RF_OK;
    usual->tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
    RfResult result = rf_plan_render( &job->shot, settings, &plan, error );
    const RfPlanRow* row = plan.rows + plan.chosen;
    if ( result == RF_OK )
        *usual = ( Usual ){ row->group, row->tile };
    return result == RF_ERROR_MEMORY ? RF_OK : result; // then it is said what the rows need
}

// Lists the rows of a tile; none fits if the smallest group does not.
static RfResult list_tile( const RfTuneJob* job, const RfTile* tile, const Usual* usual, RfTune* tune, RfError* error )
{
    RfRenderSettings settings = *job->settings;
    settings = rf_tune_settings( &( RfTrialRow ){ .tile = *tile }, &settings );
    RfPlan plan;
    RfResult result = rf_plan_render( &job->shot, &settings, &plan, error );
    if ( result != RF_OK && result != RF_ERROR_MEMORY )
        return result;
    int planned = result == RF_OK ? plan.count : 0, first = tune->count;
    for ( int i = 0; i < RF_TUNE_GROUPS; ++i )
    {
        RfGroupPlan groups = rf_plan_shots( job->shot.eyes, job->shot.eye_count, s_groups[i], settings.spp );
        RfTrialRow* row = tune->rows + tune->count++;
        *row = ( RfTrialRow ){ .group = groups.eyes / 2,
                               .eyes = groups.eyes,
                               .tile = *tile,
                               .spp = groups.spp,
                               .predicted_gain = NAN,
                               .efficiency = NAN,
                               .excluded = s_no_room };
        if ( i >= planned || !rf_plan_row_fits( plan.rows + i ) )
            row->fit = fit_of( job, row );
        else
        {
            take_plan( plan.rows + i, row );
            row->usual = ( usual->group < 0 ? i == plan.chosen : row->group == usual->group ) &&
                         memcmp( tile, &usual->tile, sizeof *tile ) == 0;
            row->excluded = (double)row->spp > ROUNDING * settings.spp && row->group > 0 ? s_rounded : NULL;
        }
        if ( groups.eyes == rf_longest_shot( job->shot.eyes, job->shot.eye_count ) || !rf_has_groups( job->settings->estimator ) )
            break;
    }
    drop_hopeless( tune, first );
    return RF_OK;
}

static RfResult fail_memory( const RfTuneJob* job, const RfTune* tune, size_t memory, RfError* error )
{
    size_t least = tune->rows[0].fit.least;
    for ( int i = 1; i < tune->count; ++i )
        least = tune->rows[i].fit.least < least ? tune->rows[i].fit.least : least;
    char text[RF_BYTES_TEXT_SIZE];
    rf_format_memory( memory, text );
    return rf_advise( rf_fail( error, RF_ERROR_MEMORY,
                               "a budget of %s is too small for frames of %dx%d, whatever the group and the tile", text,
                               job->shot.eyes->width, job->shot.eyes->height ),
                      RF_REMEDY_MEMORY, least, error );
}

RfResult rf_list_tune_rows( const RfTuneJob* job, RfTune* tune, RfRenderSettings* common, RfError* error )
{
    RfRenderSettings asked = rf_trial_settings( job->settings );
    Usual usual;
    RF_TRY( find_usual( job, &asked, &usual, error ) );
    asked.group = 0; // auto would compute a further plan
    asked.tile = usual.tile;
    RfResult result = rf_resolve_settings( &job->shot, &asked, common, error );
    common->spp = asked.spp;
    RfRenderSettings listed = *common; // of the render itself, whose memory is said
    listed.noise = job->settings->noise;
    listed.flicker = job->settings->flicker;
    listed.time = job->settings->time;
    listed.adaptive = job->settings->adaptive;
    listed.clamp = job->settings->clamp;
    listed.clamp_chains = job->settings->clamp_chains;
    listed.aovs = job->settings->aovs;
    int tried = 0;
    for ( int t = 0; t < RF_TUNE_TILES && result == RF_OK; ++t )
    {
        RfTile tile;
        rf_parse_tile( rf_has_groups( common->estimator ) ? s_tiles[t] : s_extended_tiles[t], &tile );
        RfTuneJob resolved = *job;
        resolved.settings = &listed;
        result = list_tile( &resolved, &tile, &usual, tune, error );
    }
    for ( int i = 0; i < tune->count; ++i )
        tried += tune->rows[i].excluded == NULL;
    return result == RF_OK && tried == 0 ? fail_memory( job, tune, common->memory, error ) : result;
}

// How many trials may run in parallel so that half of the memory of each is left for films.
static int tune_workers( const RfTuneJob* job, const RfTune* tune, const RfRenderSettings* common )
{
    int workers = common->threads;
    for ( int i = 0; i < tune->count; ++i )
    {
        RfRenderSettings settings = rf_tune_settings( tune->rows + i, common );
        RfMemoryFit fit;
        settings.threads = 1;
        settings.aovs &= RF_PASS_AOVS;
        RfShot group = { job->shot.tracer, job->shot.eyes, tune->rows[i].eyes, NULL, tune->rows[i].eyes };
        RfResult result = rf_fit_memory( &group, &settings, &fit, NULL );
        if ( tune->rows[i].excluded == NULL && result == RF_OK && fit.sweeps == 1 )
            workers = rf_trial_workers( common->memory, &fit, workers );
    }
    return workers;
}

// The error of a sample that the goal is about.
static double tune_error( const RfTune* tune, const RfTrial* trial )
{
    double f1 = rf_trial_f1( trial, 1.0 );
    return tune->goal == RF_TUNE_FLICKER ? f1 * f1 : rf_trial_relmse( trial, 1.0 );
}

static void predict_row( const RfTune* tune, RfTrialRow* row, double pixels, int frames )
{
    bool flicker = tune->goal == RF_TUNE_FLICKER; // what the trials of the other rows correct
    rf_predict_trial_row( row, pixels, frames, flicker ? 1.0 : exp( row->log_error ) );
    row->f1 *= flicker ? exp( 0.5 * row->log_error ) : 1.0;
    row->gain = ( RfInterval ){ (double)NAN, (double)NAN, (double)NAN };
    // of the error as tried, since all rows are tried with about the same samples in a frame (rf_tune_passes)
    double f1 = rf_trial_f1( &row->trial, row->spp ), error = flicker ? f1 * f1 : rf_trial_relmse( &row->trial, row->spp );
    double cost = error * exp( row->log_error ) * row->cpu_seconds;
    row->efficiency = isgreater( cost, 0.0 ) ? frames / cost : NAN; // the efficiency of a black image is undefined
}

// The change from frame to frame is measured over all pieces together: no interval.
static RfInterval flicker_gain( const RfTrial* plain, const RfTrial* row )
{
    double a = rf_trial_f1( plain, 1.0 ), b = rf_trial_f1( row, 1.0 );
    double cost = b * b * rf_trial_sample_seconds( row );
    double gain = isgreater( cost, 0.0 ) ? a * a * rf_trial_sample_seconds( plain ) / cost : (double)NAN;
    return ( RfInterval ){ isgreater( gain, 0.0 ) && isfinite( gain ) ? gain : (double)NAN, (double)NAN, (double)NAN };
}

// Of the render asked for: more samples are traced at the ends of the path, and in several sweeps.
static RfInterval gain_over( RfTuneGoal goal, const RfTrialRow* plain, const RfTrialRow* row )
{
    RfInterval gain =
        goal == RF_TUNE_FLICKER ? flicker_gain( &plain->trial, &row->trial ) : rf_trial_gain( &plain->trial, &row->trial );
    double ends = plain->samples / plain->spp / ( row->samples / row->spp );
    return row == plain ? ( RfInterval ){ 1.0, 1.0, 1.0 }
                        : ( RfInterval ){ gain.value * ends, gain.low * ends, gain.high * ends };
}

void rf_predict_tune_rows( RfTune* tune, double pixels, int frames )
{
    const RfTrialRow* plain = NULL;
    int rounds = 0;
    tune->chosen = -1;
    for ( int i = 0; i < tune->count; ++i )
    {
        RfTrialRow* row = tune->rows + i;
        predict_row( tune, row, pixels, frames );
        row->chosen = false;
        rounds = row->rounds > rounds ? row->rounds : rounds;
        plain = rf_is_plain_row( row ) && row->rounds > 0 ? row : plain;
    }
    for ( int i = 0; i < tune->count; ++i )
    {
        RfTrialRow* row = tune->rows + i;
        if ( plain != NULL && row->rounds > 0 )
            row->gain = gain_over( tune->goal, plain, row );
        if ( row->rounds == rounds && rounds > 0 && isfinite( row->efficiency ) &&
             ( tune->chosen < 0 || row->efficiency > tune->rows[tune->chosen].efficiency ) )
            tune->chosen = i;
    }
    if ( tune->chosen >= 0 )
        tune->rows[tune->chosen].chosen = true;
}

// Smooths the results of trials over the rows. Error and time per sample vary smoothly with
// the size of the group, and similarly for all tiles, but the noise of a trial does not: a
// firefly hits one group and not the next, and other load on the machine hits one trial and
// not the next. So the logarithm of each is fitted by
//
//     q(x) + u_tile + v_tile x,    x = log of the frames in a group, q a cubic,
//
// and each row is shrunk towards the fit, the more the larger its own noise (estimated from
// the residuals) is compared to the model error of the fit.

#define MAX_TERMS ( 4 + 2 * ( RF_TUNE_TILES - 1 ) )
#define FIT_ERROR 0.06  // model error: standard deviation of true values about the fit, in logarithms
#define FIRST_NOISE 0.2 // initial guess for a first trial

typedef struct Point
{
    double terms[MAX_TERMS];
    double value;    // logarithm of the measured value
    double evidence; // relative weight of its trials; the smallest is 1
    int row;
} Point;

typedef struct Fit
{
    Point points[RF_TUNE_ROWS];
    int count, terms;
} Fit;

static int tile_number( const RfTune* tune, int row )
{
    int number = 0;
    for ( int i = 1; i <= row; ++i )
        number += memcmp( &tune->rows[i].tile, &tune->rows[i - 1].tile, sizeof tune->rows[i].tile ) != 0;
    return number;
}

// Number of group sizes that have been tried with any tile.
static int count_groups( const RfTune* tune )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
    {
        bool known = tune->rows[i].rounds == 0;
        for ( int k = 0; k < i && !known; ++k )
            known = tune->rows[k].rounds > 0 && tune->rows[k].eyes == tune->rows[i].eyes;
        count += !known;
    }
    return count;
}

static void collect( const RfTune* tune, bool time, Fit* fit )
{
    int groups = count_groups( tune ), powers = groups < 4 ? groups : 4;
    double least = (double)INFINITY;
    fit->count = 0;
    fit->terms = powers + 2 * ( RF_TUNE_TILES - 1 );
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTrial* trial = &tune->rows[i].trial;
        if ( tune->rows[i].rounds == 0 )
            continue;
        double measured = time ? rf_trial_sample_seconds( trial ) : tune_error( tune, trial );
        if ( !isgreater( measured, 0.0 ) || isinf( measured ) )
            continue;
        Point* p = fit->points + fit->count++;
        *p = ( Point ){ .value = log( measured ), .evidence = trial->weight, .row = i };
        least = p->evidence < least ? p->evidence : least;
        double x = log( tune->rows[i].eyes ), power = 1.0;
        for ( int k = 0; k < powers; ++k, power *= x )
            p->terms[k] = power;
        int tile = tile_number( tune, i );
        if ( tile > 0 )
        {
            p->terms[powers + 2 * ( tile - 1 )] = 1.0;
            p->terms[powers + 2 * ( tile - 1 ) + 1] = x;
        }
    }
    for ( int i = 0; i < fit->count; ++i )
        fit->points[i].evidence /= least;
}

// Solves the symmetric, positive definite system m c = v by elimination; v receives c.
static void solve( double m[MAX_TERMS][MAX_TERMS], double v[MAX_TERMS], int n )
{
    for ( int i = 0; i < n; ++i )
    {
        for ( int r = i + 1; r < n; ++r )
        {
            double factor = m[r][i] / m[i][i];
            for ( int c = i; c < n; ++c )
                m[r][c] -= factor * m[i][c];
            v[r] -= factor * v[i];
        }
    }
    for ( int i = n - 1; i >= 0; --i )
    {
        for ( int c = i + 1; c < n; ++c )
            v[i] -= m[i][c] * v[c];
        v[i] /= m[i][i];
    }
}

static double noise_of( const Point* p, double first ) { return first * first / p->evidence; }

// Weighted least squares; terms without data come out as 0.
static void fit_terms( const Fit* fit, double noise, double terms[MAX_TERMS] )
{
    double m[MAX_TERMS][MAX_TERMS] = { { 0.0 } };
    memset( terms, 0, MAX_TERMS * sizeof *terms );
    for ( int k = 0; k < fit->terms; ++k )
        m[k][k] = 1e-6;
    for ( int i = 0; i < fit->count; ++i )
    {
        const Point* p = fit->points + i;
        double weight = 1.0 / ( FIT_ERROR * FIT_ERROR + noise_of( p, noise ) );
        for ( int r = 0; r < fit->terms; ++r )
        {
            for ( int c = 0; c < fit->terms; ++c )
                m[r][c] += weight * p->terms[r] * p->terms[c];
            terms[r] += weight * p->terms[r] * p->value;
        }
    }
    solve( m, terms, fit->terms );
}

static double fitted( const Fit* fit, const double terms[MAX_TERMS], const Point* p )
{
    double sum = 0.0;
    for ( int k = 0; k < fit->terms; ++k )
        sum += terms[k] * p->terms[k];
    return sum;
}

static void smooth_rows( RfTune* tune, bool time )
{
    Fit fit;
    collect( tune, time, &fit );
    int free_terms = fit.count - fit.terms;
    if ( free_terms <= 0 ) // the fit would interpolate all of them
        return;
    double terms[MAX_TERMS], sum = 0.0;
    fit_terms( &fit, FIRST_NOISE, terms );
    for ( int i = 0; i < fit.count; ++i )
    {
        double away = fit.points[i].value - fitted( &fit, terms, fit.points + i );
        sum += away * away * fit.points[i].evidence;
    }
    double noise = sqrt( sum / free_terms );
    fit_terms( &fit, noise, terms );
    for ( int i = 0; i < fit.count; ++i )
    {
        const Point* p = fit.points + i;
        double by_noise = noise_of( p, noise ), away = fitted( &fit, terms, p ) - p->value;
        double move = away * by_noise / ( by_noise + FIT_ERROR * FIT_ERROR );
        *( time ? &tune->rows[p->row].log_time : &tune->rows[p->row].log_error ) = move;
    }
}

void rf_smooth_tune_rows( RfTune* tune )
{
    for ( int i = 0; i < tune->count; ++i )
        tune->rows[i].log_time = tune->rows[i].log_error = 0.0;
    smooth_rows( tune, false );
    smooth_rows( tune, true );
}

// Plans the rounds. Decisions depend on the arguments only, not on a clock.

#define REGION_FRAMES 7   // of a test region, at least
#define MIN_PIXELS 2500.0 // four pieces, and what is traced around them
#define MAX_REGIONS 24

// Fraction of the remaining time for each round.
static const double s_shares[RF_TUNE_ROUNDS] = { 0.3, 0.33, 0.5, 1.0 };
static const int s_regions[RF_TUNE_ROUNDS] = { 2, 2, 3, 4 };
static const int s_passes[RF_TUNE_ROUNDS] = { 2, 4, 4, 4 };

#define FEW 4    // with this many settings left, a round may use all the remaining time
#define HOPE 0.5 // fraction of the best efficiency below which a row is dropped

int rf_tune_passes( int eyes, int passes )
{
    return eyes < REGION_FRAMES ? passes * ( ( REGION_FRAMES + eyes / 2 ) / eyes ) : passes;
}

// Frames that a test region has: it holds the groups of all candidates.
static int tune_region_frames( const RfTune* tune, const bool* candidate )
{
    int frames = REGION_FRAMES;
    for ( int i = 0; i < tune->count; ++i )
        frames = candidate[i] && tune->rows[i].eyes > frames ? tune->rows[i].eyes : frames;
    return frames;
}

// Own-frame samples per pixel traced that a trial of the row takes.
static double tune_row_samples( const RfTrialRow* row, int passes )
{
    return 2.0 * row->eyes * rf_tune_passes( row->eyes, passes );
}

double rf_tune_round_cost( const RfTune* tune, const bool* candidate, const RfTuneRound* round, double cost_second )
{
    double cost = 0.0;
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTrialRow* row = tune->rows + i;
        double sample = row->rounds > 0 ? rf_trial_sample_seconds( &row->trial ) : row->cost * cost_second;
        cost += candidate[i] ? round->regions * round->pixels * tune_row_samples( row, round->passes ) * sample : 0.0;
    }
    return cost;
}

// Pixels per frame such that what is kept of the test regions and the parallel trials fits in half the memory;
// the other half is for the renders.
static double pixels_that_fit( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, int regions )
{
    int eyes = tune_region_frames( tune, candidate );
    double bytes = (double)rf_test_region_bytes( eyes, RF_CELL_PIXELS ) * regions +
                   (double)o->workers * (double)rf_trial_bytes( eyes, RF_CELL_PIXELS );
    return 0.5 * (double)o->memory / bytes * RF_CELL_PIXELS;
}

static int count_candidates( const RfTune* tune, const bool* candidate )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += candidate[i];
    return count;
}

bool rf_plan_tune_round( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, RfTuneRound* round )
{
    double all = (double)o->width * o->height,
           seconds = ( count_candidates( tune, candidate ) > FEW ? s_shares[o->number] : 1.0 ) * o->left;
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
    if ( !o->must && pixels < least )
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
    double hope = tune->round_count > 0 ? HOPE : 0.0; // before, efficiencies are guesses
    double last = kept > 0 ? sorted[kept < count ? kept - 1 : count - 1] : (double)INFINITY;
    double bar = fmax( hope * sorted[0], last );
    for ( int i = 0; i < tune->count; ++i )
        candidate[i] =
            candidate[i] && ( tune->rows[i].efficiency >= bar || tune->rows[i].usual || rf_is_plain_row( tune->rows + i ) );
}

double rf_tune_position( int index )
{
    double position = 0.0, part = 0.5;
    for ( int i = index + 1; i > 0; i /= 2, part /= 2.0 )
        position += i % 2 * part;
    return position;
}

// Is a row tried sooner than another? A deadline may leave out the last ones.
static bool goes_before( const RfTrialRow* a, const RfTrialRow* b )
{
    int rank[2] = { rf_is_plain_row( a ) ? 2 : a->usual, rf_is_plain_row( b ) ? 2 : b->usual };
    return rank[0] != rank[1] ? rank[0] > rank[1] : a->efficiency > b->efficiency;
}

#define SLACK 0.9           // of the time left for a round without a later one: trials end at different times
#define LEAST_ROWS 3        // path tracing, what is usual and another one
#define FIRST_PIXELS 2500.0 // traced of a frame, to measure the speed

static const int s_kept[RF_TUNE_ROUNDS] = { 16, 8, 4, 1 }; // candidates kept after each round

typedef struct Tuner
{
    const RfTuneJob* job;
    RfTune* tune;
    RfTrialRuns runs;
    RfRenderSettings common; // resolved
    bool candidate[RF_TUNE_ROWS];
    double start;
    int positions;    // positions used for test regions so far
    double cpu, wall; // seconds spent by the rounds so far
    double cost_second;
} Tuner;

// Places the regions of a round, at further positions of the path.
static RfResult make_regions( Tuner* t, const RfTuneRound* round, int first, RfError* error )
{
    const RfShot* shot = &t->job->shot;
    RfTestSite* sites = calloc( (size_t)round->regions, sizeof *sites );
    if ( sites == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory trying settings" );
    int frames = tune_region_frames( t->tune, t->candidate );
    for ( int i = 0; i < round->regions; ++i )
        sites[i] =
            ( RfTestSite ){ shot->frames[(int)( rf_tune_position( first + i ) * shot->frame_count )], frames, round->pixels };
    t->runs.first = first;
    RfResult result = rf_make_trial_regions( &t->runs, sites, round->regions, error );
    free( sites );
    return result;
}

// The candidates, those first that are to be tried first.
static int order_candidates( const Tuner* t, int order[RF_TUNE_ROWS] )
{
    const RfTrialRow* rows = t->tune->rows;
    int count = 0;
    for ( int i = 0; i < t->tune->count; ++i )
    {
        int k = t->candidate[i] ? count++ : -1;
        for ( ; k > 0 && goes_before( rows + i, rows + order[k - 1] ); --k )
            order[k] = order[k - 1];
        if ( k >= 0 )
            order[k] = i;
    }
    return count;
}

// Adds the trials of the regions at which all rows were tried, in the first round at least those of the first region; returns
// the number of these regions.
static int take_trials( const RfTrialRuns* runs, const int* order, RfTune* tune )
{
    int complete = 0;
    for ( int s = 0; s < runs->region_count; ++s )
    {
        const bool* here = runs->done + s * runs->task_count;
        int done = 0;
        for ( int k = 0; k < runs->task_count; ++k )
            done += here[k];
        if ( done < runs->task_count && ( done == 0 || tune->round_count > 0 || s > 0 ) )
            continue;
        for ( int k = 0; k < runs->task_count; ++k )
        {
            if ( !here[k] )
                continue;
            rf_add_trial( &tune->rows[order[k]].trial, runs->trials + s * runs->task_count + k );
            tune->rows[order[k]].rounds += complete == 0;
        }
        complete += 1;
    }
    return complete;
}

static RfResult run_round( Tuner* t, const RfTuneRound* round, int* complete, RfError* error )
{
    RfTrialTask tasks[RF_TUNE_ROWS];
    int order[RF_TUNE_ROWS], count = order_candidates( t, order );
    for ( int k = 0; k < count; ++k )
    {
        const RfTrialRow* row = t->tune->rows + order[k];
        tasks[k] = ( RfTrialTask ){ rf_tune_settings( row, &t->runs.pilot ), 1, rf_tune_passes( row->eyes, round->passes ) };
    }
    *complete = 0;
    double start = rf_wall_seconds();
    RfResult result = make_regions( t, round, t->positions, error );
    if ( result == RF_OK )
        result = rf_run_trials( &t->runs, tasks, count, error );
    if ( t->runs.done != NULL && ( result == RF_OK || result == RF_ERROR_INTERRUPTED ) )
        *complete = take_trials( &t->runs, order, t->tune );
    t->cpu += rf_trial_runs_seconds( &t->runs );
    t->wall += rf_wall_seconds() - start;
    t->positions += round->regions;
    return result;
}

// Renders a few pieces to measure the speed of this machine in this scene.
static RfResult calibrate( Tuner* t, RfError* error )
{
    const RfShot* shot = &t->job->shot;
    RfTuneRound round = { .pixels = fmin( FIRST_PIXELS, (double)shot->eyes->width * shot->eyes->height ),
                          .regions = t->common.threads };
    double start = rf_wall_seconds(), cost = 0.0;
    RfResult result = make_regions( t, &round, 0, error );
    double samples = result == RF_OK ? t->runs.regions->samples * round.regions : 1.0;
    t->cpu = rf_trial_runs_seconds( &t->runs );
    t->wall = rf_wall_seconds() - start;
    for ( int i = 0; i < t->tune->count; ++i ) // the most expensive row costs about as much as the pilot image, or more
        cost = t->candidate[i] && t->tune->rows[i].cost > cost ? t->tune->rows[i].cost : cost;
    t->cost_second = 1.5 * t->cpu / ( samples * cost );
    return result;
}

static RfTuneOutlook make_outlook( const Tuner* t, int number )
{
    double left = t->job->budget - ( rf_wall_seconds() - t->start );
    return ( RfTuneOutlook ){
        .number = number,
        .width = t->job->shot.eyes->width,
        .height = t->job->shot.eyes->height,
        .left = left > 0.0 ? SLACK * left : 0.0,
        .rate = t->wall > 0.0 && t->cpu > 0.0 ? t->cpu / t->wall : 1.0,
        .cost_second = t->cost_second,
        .memory = t->common.memory,
        .workers = t->common.threads,
        .passes = rf_usual_passes( &t->common ),
        .must = number == 0 && ( t->job->deadline == 0.0 || count_candidates( t->tune, t->candidate ) < LEAST_ROWS ),
    };
}

static int count_tried( const RfTune* tune )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += tune->rows[i].rounds > 0;
    return count;
}

// Plans a round for the candidates, or for the better ones if time is too short; false if it is too short even for two that
// are to be compared. The first round is planned in any case.
static bool plan_round( Tuner* t, int number, RfTuneRound* round )
{
    for ( int kept = count_candidates( t->tune, t->candidate ) - 1;; --kept )
    {
        RfTuneOutlook outlook = make_outlook( t, number );
        if ( rf_plan_tune_round( t->tune, t->candidate, &outlook, round ) )
            return true;
        rf_cut_tune_candidates( t->tune, kept, t->candidate ); // path tracing and what is usual stay besides
        if ( number > 0 && ( count_candidates( t->tune, t->candidate ) < LEAST_ROWS || kept <= 0 ) )
            return false;
    }
}

// Runs a round; work left undone at the deadline is ignored.
static RfResult next_round( Tuner* t, int number, bool* last, RfError* error )
{
    const RfTuneJob* job = t->job;
    RfTuneRound* round = t->tune->rounds + number;
    *last = !plan_round( t, number, round );
    if ( *last )
        return RF_OK;
    if ( job->report != NULL )
        job->report( job->user, t->tune, round, count_candidates( t->tune, t->candidate ) );
    int complete;
    RfResult result = run_round( t, round, &complete, error );
    t->tune->round_count += complete > 0;
    round->regions = complete;
    rf_smooth_tune_rows( t->tune );
    rf_predict_tune_rows( t->tune, (double)job->shot.eyes->width * job->shot.eyes->height, job->shot.frame_count );
    if ( rf_is_late( &t->runs, result ) )
    {
        if ( number == 0 && count_tried( t->tune ) < 2 ) // nothing to compare
            t->tune->needed = 2.0 * fmax( job->budget, rf_wall_seconds() - t->start + round->seconds );
        *last = true;
        return RF_OK;
    }
    rf_cut_tune_candidates( t->tune, s_kept[number], t->candidate );
    return result;
}

RfResult rf_tune( const RfTuneJob* job, RfTune* tune, RfError* error )
{
    Tuner t = { .job = job,
                .tune = tune,
                .runs = { .shot = job->shot, .watch = job->watch, .deadline = job->deadline },
                .start = rf_wall_seconds() };
    *tune = ( RfTune ){ .goal = job->goal, .chosen = -1 };
    RfResult result = rf_list_tune_rows( job, tune, &t.common, error );
    for ( int i = 0; i < tune->count; ++i )
        t.candidate[i] = tune->rows[i].excluded == NULL;
    if ( result == RF_OK )
    {
        t.common.threads = t.runs.workers = tune_workers( job, tune, &t.common );
        t.runs.pilot = t.common;
        t.runs.pilot.threads = 1;
        t.runs.pilot.memory /= (size_t)t.common.threads;
        result = calibrate( &t, error );
    }
    bool last = rf_is_late( &t.runs, result );
    if ( last )
    {
        tune->needed = 4.0 * job->budget;
        result = RF_OK;
    }
    for ( int number = 0;
          number < RF_TUNE_ROUNDS && result == RF_OK && !last && count_candidates( tune, t.candidate ) > ( number > 0 );
          ++number )
        result = next_round( &t, number, &last, error );
    rf_predict_tune_rows( tune, (double)job->shot.eyes->width * job->shot.eyes->height, job->shot.frame_count );
    rf_end_trial_runs( &t.runs );
    if ( tune->needed > 0.0 && tune->chosen >= 0 )
    {
        tune->rows[tune->chosen].chosen = false;
        tune->chosen = -1;
    }
    tune->seconds = rf_wall_seconds() - t.start;
    if ( result == RF_OK && tune->chosen < 0 && tune->needed == 0.0 )
        return rf_fail( error, RF_ERROR_SCENE,
                        "no error can be measured: the test images are black, or have NaN or infinite pixels" );
    return result;
}
