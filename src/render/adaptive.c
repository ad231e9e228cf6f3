#include "render/adaptive.h"

#include "base/random.h"
#include "base/system.h"
#include "reuse/harvest_internal.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define PILOT_PASSES 2
#define PILOT_WINDOW 0x40000000u // no window has these numbers
#define EXTRA_WINDOW 0x80000000u
#define BINS 64
// Cost of a sample beside that of a path: for each further eye of a group, and
// of an extra one, which comes in broken wavefronts.
#define COST_OF_EYE 0.05
#define COST_OF_EXTRA 1.2
#define LEAST_GAIN 0.02 // by these figures, which are rough

double rf_extra_threshold( const double* counts, int bins, double all, int eyes )
{
    double best = 1.0, least = 0.0, without = 0.0;
    for ( int step = 0; step <= 10 * ( RF_MOST_EXTRA - 1 ); ++step )
    {
        double theta = 1.0 + 0.1 * step, error = 0.0, cost = all * ( 1.0 + COST_OF_EYE * ( eyes - 1 ) );
        for ( int b = 0; b < bins; ++b )
        {
            double info = (double)bins / ( b + 1 );
            error += counts[b] / fmax( info, theta );
            cost += counts[b] * COST_OF_EXTRA * fmax( 0.0, theta - info );
        }
        without = step == 0 ? error * cost : without;
        if ( step > 0 && error * cost >= least )
            continue;
        best = theta;
        least = error * cost;
    }
    if ( least > ( 1.0 - LEAST_GAIN ) * without )
        return 1.0;
    return best;
}

// ρ of the batch's samples into the pixels; what sees nothing has none.
static void note_shares( const RfHitBatch* batch, const RfHarvestScratch* scratch, float* sum )
{
    const float* own = scratch->density + (size_t)batch->eye * RF_LANES;
    for ( int i = 0; i < batch->count; ++i )
        sum[batch->pixel[i]] += own[i] / batch->density_sum[i];
    int natives = scratch->first.count - batch->count, base = batch->miss_count - natives;
    for ( int i = 0; i < natives; ++i )
        sum[rf_miss_pixel( batch )[base + i]] += 1.0f;
}

// From sums of ρ to extra samples for each pass.
static void set_need( LiveFilm* live, int eyes )
{
    double counts[BINS] = { 0 };
    size_t pixels = (size_t)live->film.width * (size_t)live->film.height;
    for ( size_t i = 0; i < pixels; ++i )
    {
        live->need[i] = fminf( live->need[i] / PILOT_PASSES, 1.0f );
        if ( live->need[i] > 0.0f )
            counts[(int)fminf( live->need[i] * BINS, BINS - 1 )] += 1.0;
    }
    float theta = (float)rf_extra_threshold( counts, BINS, (double)pixels, eyes );
    live->most_need = 0.0f;
    for ( size_t i = 0; i < pixels; ++i )
    {
        float need = live->need[i] > 0.0f ? fmaxf( 0.0f, theta - 1.0f / live->need[i] ) : 0.0f;
        live->need[i] = need;
        live->most_need = fmaxf( live->most_need, need );
    }
}

void rf_run_pilot( RfRenderer* r, LiveFilm* live )
{
    memset( live->need, 0, rf_need_bytes( &r->sizes ) );
    live->most_need = 0.0f;
    int eyes = r->plan.eyes, first = live->frame - eyes / 2, last_first = r->plan.frames - eyes;
    if ( eyes == 1 )
        return;
    first = first < last_first ? first : last_first;
    first = first > 0 ? first : 0;
    RfHarvest harvest = {
        .walk = { r->tracer, 1, r->settings.light_samples, r->settings.light_sampling },
        .shape = r->sizes.shape,
        .patches = r->sizes.patches,
        .weights = r->settings.weights,
        .seed = r->settings.seed,
        .eyes = r->eyes + first,
        .first_frame = first,
        .window = (int)PILOT_WINDOW,
    };
    for ( int pass = 0; pass < PILOT_PASSES; ++pass )
    {
#pragma omp parallel num_threads( r->settings.threads )
        {
            rf_set_float_mode();
            RfRayCounts mine = { 0 };
            int thread = omp_get_thread_num();
            RfHarvestScratch* scratch = r->memory.harvest_scratch[thread];
#pragma omp for schedule( dynamic, 1 )
            for ( int slot = 0; slot < r->memory.batch_slots; ++slot )
            {
                // as many at once as there are batches; the patches of a pass share no pixel
                for ( int patch = slot; patch < r->sizes.patches.count; patch += r->memory.batch_slots )
                {
                    RfHarvestJob job = { live->frame - first, patch, pass };
                    rf_harvest_batch( &harvest, job, r->memory.batches + slot, scratch, &mine );
                    note_shares( r->memory.batches + slot, scratch, live->need );
                }
            }
#pragma omp critical
            rf_add_rays( &r->rays, &mine );
        }
    }
    set_need( live, eyes );
}

// The pass of one frame alone.
static RfHarvest extra_harvest( const RfRenderer* r, const RfHarvest* harvest, const LiveFilm* live, int round )
{
    RfHarvest extra = *harvest;
    extra.shape.eyes = 1;
    extra.eyes = r->eyes + live->frame;
    extra.first_frame = live->frame;
    extra.window = (int)( EXTRA_WINDOW | (uint32_t)harvest->window );
    extra.need = live->need;
    extra.round = round;
    return extra;
}

static void harvest_extra( RfRenderer* r, const RfHarvest* harvest, LiveFilm* live, RfHarvestJob job, int count, int half,
                           float weight )
{
    RfRayCounts rays = { 0 };
    uint64_t samples = 0;
#pragma omp parallel num_threads( r->settings.threads ) reduction( + : samples )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        RfHarvestScratch* scratch = r->memory.harvest_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            RfHitBatch* batch = r->memory.batches + i;
            rf_harvest_batch( harvest, ( RfHarvestJob ){ 0, job.patch + i, job.pass }, batch, scratch, &mine );
            int all = batch->count + batch->miss_count;
            for ( int k = 0; k < all; ++k )
                live->film.extra[half][batch->pixel[k]] += weight;
            samples += (uint64_t)all;
        }
#pragma omp critical
        rf_add_rays( &rays, &mine );
    }
    rf_add_rays( &r->rays, &rays );
    live->film.extra_samples += samples;
}

static void compute_extra( RfRenderer* r, const RfHarvest* harvest, LiveFilm* live, int count, int half, float weight )
{
    int bands = 2 * r->settings.threads < r->sizes.height ? 2 * r->settings.threads : r->sizes.height;
    RfAccumulate compute = { .eyes = harvest->eyes,
                             .shape = harvest->shape,
                             .weights = r->settings.weights,
                             .weight = weight,
                             .batches = r->memory.batches,
                             .batch_count = count };
#pragma omp parallel for num_threads( r->settings.threads ) schedule( dynamic, 1 )
    for ( int band = 0; band < bands; ++band )
    {
        rf_set_float_mode();
        RfAccumulateJob job = { .eye = 0,
                                .first_row = (int)( (long)r->sizes.height * band / bands ),
                                .end_row = (int)( (long)r->sizes.height * ( band + 1 ) / bands ),
                                .film = &live->film,
                                .half = half,
                                .landed = live->layers.landed };
        uint64_t landed = rf_accumulate_rows( &compute, job, NULL, r->memory.compute_scratch + omp_get_thread_num() );
#pragma omp atomic
        live->film.landed += landed;
    }
}

void rf_render_extra( RfRenderer* r, const RfHarvest* harvest, const RfGroup* window, int pass, int half )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        LiveFilm* live = r->memory.films + i;
        for ( int round = 0; live->frame != -1 && (float)round < live->most_need; ++round )
        {
            RfHarvest extra = extra_harvest( r, harvest, live, round );
            for ( int first = 0; first < r->sizes.patches.count; first += r->memory.batch_slots )
            {
                int left = r->sizes.patches.count - first, count = left < r->memory.batch_slots ? left : r->memory.batch_slots;
                RfHarvestJob job = { 0, first, RF_MOST_EXTRA * pass + round };
                harvest_extra( r, &extra, live, job, count, half, (float)window->weight );
                compute_extra( r, &extra, live, count, half, (float)window->weight );
            }
        }
    }
}
