// The state of a render that the files of the driver share: batches, films, and the finishing of pictures.
#include "render/renderer.h"

#include "render/pieces.h"
#include "trace/trace.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>

RfPass rf_make_pass( const RfEstimatorGroup* estimator_group, const RfGroup* group, int number )
{
    return (
        RfPass ){ .group = estimator_group, .number = number, .half = rf_half_of_pass( group, number ), .weight = group->weight };
}

static float* sky_of_half( const RfRenderer* r, const RfLiveFilm* live, int half )
{
    float* sky = live->aovs.mean[RF_AOV_ALPHA];
    return sky != NULL ? sky + (size_t)half * (size_t)r->setup->sizes.width * (size_t)r->setup->sizes.height : NULL;
}

RfAccumulateJob rf_accumulate_job( const RfRenderer* r, RfLiveFilm* live, const RfPass* pass, int band, int bands )
{
    return ( RfAccumulateJob ){
        .eye = live->frame - pass->group->first_frame,
        .first_row = (int)( (long)r->setup->sizes.height * band / bands ),
        .end_row = (int)( (long)r->setup->sizes.height * ( band + 1 ) / bands ),
        .films = live->films,
        .groups = r->setup->sizes.group_films > 0 ? live->films + r->setup->sizes.film_count - r->setup->sizes.group_films : NULL,
        .passes = r->setup->sizes.pass_films > 0 ? live->films + rf_first_pass_film( &r->setup->sizes ) : NULL,
        .half = pass->half,
        .weight = (float)pass->weight,
        .landed = live->aovs.landed,
        .sky = sky_of_half( r, live, pass->half ),
        .covering = live->covering,
    };
}

// A scene without lights has nothing to sample beyond the first hit.
static int useful_depth( const RfRenderer* r )
{
    return rf_tracer_lights( r->setup->shot.tracer )->count > 0 ? r->setup->settings.max_depth : 1;
}

RfEstimatorGroup rf_frames_as_group( RfRenderer* r, int first_frame, int eye_count, int number )
{
    const RfTracer* const* tracers = rf_open_worlds( &r->worlds, first_frame, eye_count );
    return ( RfEstimatorGroup ){
        .tracer = tracers != NULL && eye_count == 1 ? tracers[0] : r->setup->shot.tracer,
        .tracers = tracers,
        .settings = &r->setup->settings,
        .traits = r->setup->traits,
        .width = r->setup->sizes.width,
        .height = r->setup->sizes.height,
        .max_depth = useful_depth( r ),
        .filter = rf_is_plain_filter( &r->setup->settings ) ? NULL : &r->setup->filter,
        .guide = r->guide,
        .eyes = r->setup->shot.eyes + first_frame,
        .eye_count = eye_count,
        .first_frame = first_frame,
        .clamp = r->clamps != NULL ? r->clamps + first_frame : NULL,
        .number = number,
        .passes_before = -1,
        .compiled = rf_compiled( r, eye_count ),
    };
}

RfResult rf_compile_groups( RfRenderer* r, RfError* error )
{
    size_t each = r->setup->sizes.of_estimator.compiled, all = (size_t)r->setup->plan.eyes;
    char* compiled = each > 0 ? calloc( all, each ) : NULL;
    if ( each > 0 && compiled == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for groups of up to %zu frames", all );
    for ( int eyes = 1; eyes <= (int)all && compiled != NULL; ++eyes )
    {
        RfEstimatorGroup group = rf_frames_as_group( r, 0, eyes, 0 );
        r->setup->settings.estimator->compile( &group, compiled + (size_t)( eyes - 1 ) * each );
    }
    r->compiled = compiled;
    return RF_OK;
}

RfEstimatorGroup rf_estimator_group( RfRenderer* r, int number )
{
    RfGroup group = rf_group( &r->setup->plan, number );
    RfEstimatorGroup out = rf_frames_as_group( r, group.first, group.eyes, number );
    out.passes_before = group.passes_before;
    return out;
}

void rf_add_rays( RfRayCounts* sum, const RfRayCounts* part )
{
    sum->primary += part->primary;
    sum->path += part->path;
    sum->shadow += part->shadow;
    sum->tile += part->tile;
    sum->eye += part->eye;
    sum->thinned += part->thinned;
    sum->kept += part->kept;
}

void rf_trace_batches( RfRenderer* r, const RfPass* pass, int first, int count, RfTracedFn* traced, void* user )
{
    const RfEstimator* estimator = r->setup->settings.estimator;
    int jobs = r->setup->sizes.of_estimator.jobs, of_pass = pass->group->eye_count * jobs;
    RfRayCounts rays = { 0 };
#pragma omp parallel num_threads( r->setup->settings.threads )
    {
        rf_set_float_mode();
        RfRayCounts mine = { 0 };
        void* scratch = r->memory.trace_scratch[omp_get_thread_num()];
#pragma omp for schedule( dynamic, 1 )
        for ( int i = 0; i < count; ++i )
        {
            int number = r->traced_jobs != NULL ? r->traced_jobs[first + i] : first + i;
            RfTraceJob job = { .eye = number % of_pass / jobs, .job = number % jobs, .pass = pass->number + number / of_pass };
            estimator->trace( pass->group, job, r->memory.batches[i], scratch, &mine );
            if ( traced != NULL )
                traced( r, pass, job.eye, r->memory.batches[i], scratch, user );
        }
#pragma omp critical
        rf_add_rays( &rays, &mine );
    }
    rf_add_rays( &r->rays, &rays );
}

RfRelmse rf_finish_picture( const RfRenderer* r, const RfLiveFilm* live, RfPicture* picture )
{
    RfNormalize normalize = r->setup->settings.normalize;
    if ( r->setup->settings.estimator->finish != NULL )
        return r->setup->settings.estimator->finish( &r->setup->settings, live->films, picture, r->memory.finish_scratch );
    if ( r->setup->settings.pieces != NULL )
    {
        rf_combine_traced( r->setup->settings.pieces, live->frame, live->films, normalize, picture->rgb, picture->weight );
        return rf_plain_relmse( (double)NAN );
    }
    rf_combine_film( live->films, normalize, picture->rgb, picture->weight );
    return rf_estimate_relmse( live->films, normalize, picture->rgb );
}

RfLiveFilm* rf_find_film( const RfRenderer* r, int frame )
{
    for ( int i = 0; i < r->memory.film_slots; ++i )
    {
        if ( r->memory.films[i].frame == frame )
            return r->memory.films + i;
    }
    return NULL;
}
