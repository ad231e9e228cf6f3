// How a render fits its budget: first with fewer batches at once, then with
// fewer threads or with the films of fewer frames, whichever costs less time.
#include "render/memory.h"

#include "base/remedy.h"
#include "base/system.h"

// Fewest batches that keep all threads busy.
static int batches_needed( const RfRenderSizes* s )
{
    int wanted = rf_batches_wanted( s );
    return s->of_estimator.whole_pass || wanted < s->threads ? wanted : s->threads;
}

static size_t needed_bytes( const RfRenderSizes* s ) { return rf_fixed_bytes( s ) + rf_records_bytes( s, batches_needed( s ) ); }

// Most threads that fit the budget, up to sizes.threads; 0: none.
static int threads_that_fit( size_t budget, RfRenderSizes sizes )
{
    int low = 0, high = sizes.threads;
    while ( low < high )
    {
        sizes.threads = ( low + high + 1 ) / 2;
        if ( needed_bytes( &sizes ) <= budget )
            low = sizes.threads;
        else
            high = sizes.threads - 1;
    }
    return low;
}

// A sweep for k frames renders groups of the 2n frames around them, too.
static double time_of( int films, int threads, int frames, int eyes )
{
    double sweeps = films == frames || films == eyes ? 1.0 : (double)( films + eyes - 1 ) / (double)films;
    return sweeps / (double)threads;
}

static void choose( size_t budget, int frames, RfRenderSizes* sizes )
{
    RfRenderSizes best = *sizes, tried = *sizes;
    best.films = best.threads = 0;
    double least = 0.0;
    for ( tried.films = sizes->films; tried.films > ( sizes->paired ? sizes->films - 1 : 0 ); --tried.films )
    {
        int threads = threads_that_fit( budget, tried );
        double time = threads > 0 ? time_of( tried.films, threads, frames, sizes->eyes ) : 0.0;
        if ( threads == 0 || ( best.threads > 0 && time >= least ) )
            continue;
        best.films = tried.films;
        best.threads = threads;
        least = time;
        if ( tried.films == sizes->films && threads == sizes->threads )
            break;
    }
    *sizes = best;
}

// Rounded up to KiB, so that it can be typed.
static size_t least_budget( RfRenderSizes sizes )
{
    sizes.threads = 1;
    sizes.films = sizes.paired ? sizes.films : 1;
    return ( needed_bytes( &sizes ) + 1023 ) / 1024 * 1024;
}

static int up( int a, int b ) { return ( a + b - 1 ) / b; }

static int batches_that_fit( size_t budget, const RfRenderSizes* s )
{
    int batches = rf_batches_wanted( s );
    size_t room = budget - rf_fixed_bytes( s );
    while ( batches > batches_needed( s ) && rf_records_bytes( s, batches ) > room )
        batches -= 1;
    return batches;
}

static RfResult fail_least( size_t budget, size_t least, const RfRenderSizes* sizes, RfError* error )
{
    char text[RF_BYTES_TEXT_SIZE];
    rf_format_memory( budget, text );
    return rf_advise(
        rf_fail( error, RF_ERROR_MEMORY, "a budget of %s is too small for frames of %dx%d", text, sizes->width, sizes->height ),
        RF_REMEDY_MEMORY, least, error );
}

RfResult rf_fit_sizes( size_t budget, int frames, RfRenderSizes* sizes, RfMemoryFit* fit, RfError* error )
{
    int wanted = sizes->films;
    *fit = ( RfMemoryFit ){ .least = least_budget( *sizes ) };
    choose( budget, frames, sizes );
    if ( sizes->films == 0 )
        return fail_least( budget, fit->least, sizes, error );
    fit->threads = sizes->threads;
    fit->films = sizes->films;
    fit->sweeps = sizes->films == wanted ? 1 : up( frames, sizes->films );
    fit->batches = batches_that_fit( budget, sizes );
    fit->chunks = up( rf_batches_of_pass( sizes ), fit->batches );
    fit->bytes_films = rf_films_bytes( sizes ) + rf_image_bytes( sizes );
    fit->bytes_hits = rf_records_bytes( sizes, fit->batches );
    fit->bytes_lists = rf_scratch_bytes( sizes ) + rf_writer_bytes( sizes );
    return RF_OK;
}

RfResult rf_fit_memory( const RfScene* scene, const RfEye* eyes, int eye_count, int frame_count, const RfRenderSettings* settings,
                        RfMemoryFit* fit, RfError* error )
{
    if ( frame_count < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "a render needs at least one frame" );
    RfGroupPlan plan = rf_plan_groups( eye_count, settings->group, settings->spp );
    RfRenderSizes sizes = rf_render_sizes( scene, eyes, &plan, frame_count, settings );
    return rf_fit_sizes( settings->memory, frame_count, &sizes, fit, error );
}
