// The verdict of a page: compares sequences by the time they need for equal error.
#include "cli/report/report_verdict.h"

#include "cli/messages.h"
#include "cli/render/specks_json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define WIDEST 4.0 // times the lower end of its interval: the upper one of a gain that is told

// Means of a sequence over the frames that all compared sequences have.
typedef struct Mean
{
    double relmse, seconds; // seconds: NaN where they cannot be compared
    int frames;
} Mean;

static bool is_compared( const RfPageTrack* track )
{
    bool has_error = false;
    for ( int i = 0; i < track->count; ++i )
        has_error |= isgreater( track->frames[i].relmse, 0.0 );
    return has_error && !track->sequence->is_reference;
}

// True if every compared sequence has an error in this frame, and with `least` >= 0 seconds of at least that.
static bool is_common( const RfPageData* data, int frame, double least )
{
    for ( int i = 0; i < data->track_count; ++i )
    {
        const RfPageFrame* figures = data->tracks[i].frames + frame;
        if ( is_compared( data->tracks + i ) &&
             ( !isgreater( figures->relmse, 0.0 ) || ( least >= 0.0 && !isgreaterequal( figures->seconds, least ) ) ) )
            return false;
    }
    return true;
}

static Mean mean_of( const RfPageData* data, int track, bool with_seconds )
{
    Mean mean = { .seconds = with_seconds ? 0.0 : (double)NAN };
    for ( int i = 0; i < data->count; ++i )
    {
        if ( !is_common( data, i, with_seconds ? 0.0 : -1.0 ) ) // repeated frames take no time
            continue;
        mean.relmse += data->tracks[track].frames[i].relmse;
        mean.seconds += data->tracks[track].frames[i].seconds;
        ++mean.frames;
    }
    mean.relmse = mean.frames > 0 ? mean.relmse / mean.frames : (double)NAN;
    mean.seconds = mean.frames > 0 ? mean.seconds / mean.frames : (double)NAN;
    return mean;
}

// Wall-clock seconds of different numbers of threads say nothing about each other. 0: they differ, or are not known.
static int common_threads( const RfPageData* data )
{
    double threads = NAN;
    for ( int i = 0; i < data->track_count; ++i )
    {
        if ( !is_compared( data->tracks + i ) )
            continue;
        double here = rf_json_number_of( data->tracks[i].sequence->render, "threads" );
        if ( !isgreaterequal( here, 1.0 ) || ( isfinite( threads ) && here != threads ) )
            return 0;
        threads = here;
    }
    return isfinite( threads ) ? (int)threads : 0;
}

// The sequences that need least and most time for the same error (or have the least and the most error).
typedef struct Contest
{
    int best, worst, compared; // indices of the sequences; how many there are
    Mean means[2];
    bool with_seconds;
    int threads;
} Contest;

static double score( Mean mean ) { return isnan( mean.seconds ) ? mean.relmse : mean.relmse * mean.seconds; }

static Contest hold_contest( const RfPageData* data )
{
    Contest c = { .best = -1, .worst = -1, .threads = common_threads( data ) };
    for ( int i = 0; i < data->count && c.threads > 0; ++i )
        c.with_seconds |= is_common( data, i, 1e-9 );
    for ( int i = 0; i < data->track_count; ++i )
    {
        if ( !is_compared( data->tracks + i ) )
            continue;
        Mean mean = mean_of( data, i, c.with_seconds );
        ++c.compared;
        if ( c.best < 0 || isless( score( mean ), score( c.means[0] ) ) )
        {
            c.best = i;
            c.means[0] = mean;
        }
        if ( c.worst < 0 || isgreaterequal( score( mean ), score( c.means[1] ) ) )
        {
            c.worst = i;
            c.means[1] = mean;
        }
    }
    return c;
}

// Estimates of a sequence that are lower bounds.
static int count_bounds_of( const RfPageData* data, int track )
{
    int count = 0;
    for ( int k = 0; k < data->count; ++k )
        count += data->tracks[track].frames[k].at_least;
    return count;
}

static int count_bounds( const RfPageData* data )
{
    int count = 0;
    for ( int i = 0; i < data->track_count; ++i )
        count += count_bounds_of( data, i );
    return count;
}

// What lower bounds leave of a ratio of errors.
static const char* bound_words( const RfPageData* data, const Contest* c )
{
    bool best = count_bounds_of( data, c->best ) > 0, worst = count_bounds_of( data, c->worst ) > 0;
    return best && worst ? "about " : best ? "at most " : worst ? "at least " : "";
}

static void format_times( double times, char text[32] ) { snprintf( text, 32, times < 9.95 ? "%.2g" : "%.0f", times ); }

static void compare_words( const RfPageData* data, const Contest* c, char* text, size_t size )
{
    const char *best = data->tracks[c->best].sequence->name, *worst = data->tracks[c->worst].sequence->name;
    double times = score( c->means[1] ) / score( c->means[0] );
    char number[32];
    format_times( times, number );
    if ( times < 1.05 )
        snprintf( text, size,
                  c->with_seconds ? "%.200s and %.200s are about equally fast at equal noise"
                                  : "%.200s and %.200s are about equally noisy",
                  best, worst );
    else if ( c->with_seconds )
        snprintf( text, size, "%.200s is %s%s times faster than %.200s at equal noise", best, bound_words( data, c ), number,
                  worst );
    else
        snprintf( text, size, "%.200s has %s%s times the relMSE of %.200s", worst, bound_words( data, c ), number, best );
}

// The cost that a page of one sequence has.
static const json_t* single_cost( const RfPageData* data, const Contest* c )
{
    return data->cost != NULL ? data->cost : data->tracks[c->best].sequence->cost;
}

// One sequence: how noisy it is, and what `cost` found.
static void single_words( const RfPageData* data, const Contest* c, char* text, size_t size )
{
    bool at_least = count_bounds( data ) > 0;
    double relmse = c->means[0].relmse;
    char percent[RF_NOISE_TEXT_SIZE];
    rf_format_noise( relmse, percent );
    json_t* specks =
        data->has_reference ? NULL : rf_sum_specks( json_object_get( data->tracks[c->best].sequence->render, "frames" ) );
    if ( !rf_format_specks( specks, text, size ) )
        snprintf( text, size, "%s %s noise (relMSE %.3g)", at_least ? "At least" : "About", percent, relmse );
    json_decref( specks );
    double speedup = rf_json_number_of( single_cost( data, c ), "speedup_at_equal_error" );
    double low = rf_json_number_of( single_cost( data, c ), "speedup_low" ),
           high = rf_json_number_of( single_cost( data, c ), "speedup_high" );
    char number[32];
    size_t used = strlen( text );
    if ( !isgreater( speedup, 0.0 ) || isgreater( high, WIDEST * low ) )
        return;
    double times = speedup < 1.0 ? 1.0 / speedup : speedup;
    format_times( times, number );
    if ( times < 1.05 )
        snprintf( text + used, size - used, "; reuse is about as fast as path tracing at equal noise" );
    else
        snprintf( text + used, size - used, "; reuse is %s times %s than path tracing at equal noise", number,
                  speedup < 1.0 ? "slower" : "faster" );
}

static void basis_words( const RfPageData* data, const Contest* c, char* text, size_t size )
{
    int bounds = count_bounds( data ), frames = c->means[0].frames;
    size_t used = (size_t)snprintf( text, size, "%s, mean of %d frame%s",
                                    data->has_reference ? "relMSE against the reference" : "relMSE estimated by the renderer",
                                    frames, frames == 1 ? "" : "s" );
    if ( c->compared > 1 && c->with_seconds )
        used += (size_t)snprintf( text + used, size - used, "; wall-clock time, %d thread%s each", c->threads,
                                  c->threads == 1 ? "" : "s" );
    else if ( c->compared > 1 )
        used += (size_t)snprintf( text + used, size - used,
                                  "; times are not compared: that needs render --json with the same number of threads" );
    else if ( isgreater( rf_json_number_of( single_cost( data, c ), "speedup_at_equal_error" ), 0.0 ) )
        used += (size_t)snprintf( text + used, size - used, "; times measured by cost" );
    if ( bounds > 0 )
        snprintf( text + used, size - used, "; %d estimate%s a lower bound: --reference gives the true error", bounds,
                  bounds == 1 ? " is" : "s are" );
}

int rf_worst_page_frame( const RfPageData* data, int* track )
{
    Contest c = hold_contest( data );
    int worst = -1;
    *track = c.best;
    for ( int i = 0; i < data->count && c.best >= 0; ++i )
    {
        const RfPageFrame* frames = data->tracks[c.best].frames;
        if ( isgreater( frames[i].relmse, 0.0 ) && ( worst < 0 || frames[i].relmse > frames[worst].relmse ) )
            worst = i;
    }
    return worst;
}

json_t* rf_page_verdict_json( const RfPageData* data )
{
    char text[768], basis[512];
    Contest c = hold_contest( data );
    int track, worst = rf_worst_page_frame( data, &track );
    if ( c.compared == 0 || c.means[0].frames == 0 )
    {
        snprintf( text, sizeof text, "The error is unknown" );
        snprintf( basis, sizeof basis, "--reference measures it; render writes its estimate into the frames and its JSON" );
        worst = -1;
    }
    else
    {
        ( c.compared > 1 ? compare_words : single_words )( data, &c, text, sizeof text );
        basis_words( data, &c, basis, sizeof basis );
    }
    bool prints = worst >= 0 && data->count > 1;
    return json_pack( "{s:o, s:s, s:o, s:o}", "text", rf_json_text( text ), "basis", basis, "worst_frame",
                      prints ? json_integer( data->numbers[worst] ) : json_null(), "worst_sequence",
                      prints ? json_integer( track ) : json_null() );
}
