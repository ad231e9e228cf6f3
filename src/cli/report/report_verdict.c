// The verdict of a page: compares sequences by the time they need for equal error.
#include "cli/report/report_verdict.h"

#include "cli/messages.h"
#include "cli/render/specks_json.h"

#include <math.h>
#include <stdio.h>

static bool is_compared( const RfPageTrack* track )
{
    bool has_error = false;
    for ( int i = 0; i < track->page->count; ++i )
        has_error |= isgreater( track->frames[i].relmse, 0.0 );
    return has_error && !track->sequence->is_reference;
}

// True if every compared sequence has an error in this frame, and with `least` >= 0 seconds of at least that.
static bool is_common( const RfPageRun* report, int frame, double least )
{
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        const RfPageFrame* figures = report->tracks[i].frames + frame;
        if ( is_compared( report->tracks + i ) &&
             ( !isgreater( figures->relmse, 0.0 ) || ( least >= 0.0 && !isgreaterequal( figures->seconds, least ) ) ) )
            return false;
    }
    return true;
}

// A sequence over the frames that all compared sequences have.
typedef struct Entry
{
    int index;
    double relmse, score; // means: of the error, and where times can be compared of error times seconds
    int bounds;           // estimates of its error that are lower bounds
} Entry;

// The sequences that need least and most time for the same error, or have the least and the most error.
typedef struct Contest
{
    Entry best, worst;
    int compared, frames; // sequences and frames
    int threads; // of every sequence; 0: they differ, or are not known, and wall-clock seconds say nothing about each other
    bool with_seconds;
} Contest;

static Entry enter( const RfPageRun* report, const Contest* c, int index )
{
    const RfPageFrame* frames = report->tracks[index].frames;
    Entry entry = { .index = index };
    double seconds = 0.0;
    for ( int i = 0; i < report->page.count; ++i )
    {
        entry.bounds += frames[i].at_least;
        if ( !is_common( report, i, c->with_seconds ? 0.0 : -1.0 ) ) // repeated frames take no time
            continue;
        entry.relmse += frames[i].relmse / c->frames;
        seconds += frames[i].seconds / c->frames;
    }
    entry.score = c->with_seconds ? entry.relmse * seconds : entry.relmse;
    return entry;
}

static Contest hold_contest( const RfPageRun* report )
{
    Contest c = { .threads = -1 };
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        double threads = rf_json_number_of( report->tracks[i].sequence->render, "threads" );
        int known = isgreaterequal( threads, 1.0 ) ? (int)threads : 0;
        if ( is_compared( report->tracks + i ) )
            c.threads = c.threads == -1 || c.threads == known ? known : 0;
    }
    for ( int i = 0; i < report->page.count && c.threads > 0; ++i )
        c.with_seconds |= is_common( report, i, 1e-9 );
    for ( int i = 0; i < report->page.count; ++i )
        c.frames += is_common( report, i, c.with_seconds ? 0.0 : -1.0 );
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        if ( !is_compared( report->tracks + i ) )
            continue;
        Entry entry = enter( report, &c, i );
        c.best = c.compared == 0 || entry.score < c.best.score ? entry : c.best;
        c.worst = c.compared == 0 || entry.score >= c.worst.score ? entry : c.worst;
        c.compared += 1;
    }
    return c;
}

static void compare_words( const RfPageRun* report, const Contest* c, char* text, size_t size )
{
    const char *best = report->tracks[c->best.index].sequence->name, *worst = report->tracks[c->worst.index].sequence->name;
    double times = c->worst.score / c->best.score;
    char ratio[48]; // with what lower bounds leave of it
    snprintf( ratio, sizeof ratio, times < 9.95 ? "%s%.2g" : "%s%.0f",
              c->best.bounds > 0 && c->worst.bounds > 0 ? "about "
              : c->best.bounds > 0                      ? "at most "
              : c->worst.bounds > 0                     ? "at least "
                                                        : "",
              times );
    if ( times < 1.05 )
        snprintf( text, size,
                  c->with_seconds ? "%.200s and %.200s are about equally fast at equal noise"
                                  : "%.200s and %.200s are about equally noisy",
                  best, worst );
    else if ( c->with_seconds )
        snprintf( text, size, "%.200s is %s times faster than %.200s at equal noise", best, ratio, worst );
    else
        snprintf( text, size, "%.200s has %s times the relMSE of %.200s", worst, ratio, best );
}

// One sequence: how noisy it is.
static void single_words( const RfPageRun* report, const Contest* c, char* text, size_t size )
{
    const json_t* frames = json_object_get( report->tracks[c->best.index].sequence->render, "frames" );
    json_t* specks = report->reference != NULL ? NULL : rf_sum_specks( frames );
    char percent[RF_NOISE_TEXT_SIZE];
    rf_format_noise( c->best.relmse, percent );
    if ( !rf_format_specks( specks, text, size ) )
        snprintf( text, size, "%s %s noise (relMSE %.3g)", c->best.bounds > 0 ? "At least" : "About", percent, c->best.relmse );
    json_decref( specks );
}

static void basis_words( const RfPageRun* report, const Contest* c, char* text, size_t size )
{
    int bounds = 0;
    for ( int i = 0; i < report->sequence_count; ++i )
        bounds += enter( report, c, i ).bounds;
    size_t used =
        (size_t)snprintf( text, size, "%s, mean of %d frame%s",
                          report->reference != NULL ? "relMSE against the reference" : "relMSE estimated by the renderer",
                          c->frames, c->frames == 1 ? "" : "s" );
    if ( c->compared > 1 && c->with_seconds )
        used += (size_t)snprintf( text + used, size - used, "; wall-clock time, %d thread%s each", c->threads,
                                  c->threads == 1 ? "" : "s" );
    else if ( c->compared > 1 )
        used += (size_t)snprintf( text + used, size - used,
                                  "; times are not compared: that needs render --json with the same number of threads" );
    if ( bounds > 0 )
        snprintf( text + used, size - used, "; %d estimate%s a lower bound: --reference gives the true error", bounds,
                  bounds == 1 ? " is" : "s are" );
}

// The index of the frame with the largest error of the sequence that the verdict is about; -1: not known.
static int worst_frame( const RfPageRun* report, const Contest* c )
{
    int worst = -1;
    const RfPageFrame* frames = report->tracks[c->best.index].frames;
    for ( int i = 0; i < report->page.count; ++i )
    {
        if ( isgreater( frames[i].relmse, 0.0 ) && ( worst < 0 || frames[i].relmse > frames[worst].relmse ) )
            worst = i;
    }
    return worst;
}

json_t* rf_page_verdict_json( const RfPageRun* report )
{
    char text[768] = "The error is unknown",
         basis[512] = "--reference measures it; render writes its estimate into the frames and its JSON";
    Contest c = hold_contest( report );
    bool known = c.compared > 0 && c.frames > 0;
    int worst = known ? worst_frame( report, &c ) : -1;
    if ( known )
    {
        ( c.compared > 1 ? compare_words : single_words )( report, &c, text, sizeof text );
        basis_words( report, &c, basis, sizeof basis );
    }
    bool names = worst >= 0 && report->page.count > 1;
    return json_pack( "{s:o, s:s, s:o}", "text", rf_json_text( text ), "basis", basis, "worst_frame",
                      names ? json_integer( report->page.numbers[worst] ) : json_null() );
}
