#include "render/plan_internal.h"
#include "render/settings.h"

#include <math.h>
#include <stdio.h>

static const int s_groups[RF_PLAN_ROWS] = { 0, 1, 2, 3, 4, 6, 8, 12, 16 };

// Relative costs of rays, which the choice of the group rests on: about nanoseconds on one core of
// a 2.5 GHz Xeon with AVX2.
#define COST_PRIMARY 100.0 // including records and films
#define COST_PATH 200.0
#define COST_SHADOW 100.0
#define COST_TILE 40.0
#define COST_EYE 30.0      // a visibility test
#define COST_ADD 4.0       // adding a hit to a film, plus
#define COST_DIRECTION 7.0 // this for each direction of a glossy hit

// Why the automatic choice leaves a row out.
static const char s_no_room[] = "does not fit the memory", s_films[] = "films over half of the memory",
                  s_sweeps[] = "goes through the path several times", s_rounded[] = "samples rounded up too far";

#define FLAT 0.9      // of the best gain is good enough: smaller groups need less memory, and less time for a single frame
#define ROUNDING 1.25 // rounding up may trace so many times the samples asked for

static void list_rows( int eye_count, const RfRenderSettings* settings, RfPlan* plan )
{
    int spp = settings->spp;
    for ( int i = 0; i < RF_PLAN_ROWS; ++i )
    {
        RfGroupPlan groups = rf_plan_samples( eye_count, s_groups[i], spp );
        plan->rows[plan->count++] = ( RfPlanRow ){ .group = groups.eyes / 2,
                                                   .eyes = groups.eyes,
                                                   .spp = groups.spp,
                                                   .samples = NAN,
                                                   .repeated = NAN,
                                                   .rays_primary = NAN,
                                                   .rays_path = NAN,
                                                   .rays_shadow = NAN,
                                                   .rays_tile = NAN,
                                                   .rays_eye = NAN,
                                                   .reach = NAN,
                                                   .gain = NAN,
                                                   .measured_gain = NAN,
                                                   .seconds = NAN };
        if ( groups.eyes == eye_count || !rf_has_groups( settings->estimator ) )
            break;
    }
}

double rf_plan_work( const RfGroupPlan* plan, double own, double reuse )
{
    double work = 0.0;
    for ( int g = 0; g < plan->groups; ++g )
    {
        RfGroup group = rf_group( plan, g );
        work += (double)group.passes * group.eyes * ( own + ( group.eyes - 1 ) * reuse );
    }
    return work;
}

// Gain: samples that land in a frame over the cost of a sample, relative to no reuse.
static double gain_of( const RfGroupPlan* plan, double reach, double own, double reuse )
{
    double samples = (double)plan->frames * plan->spp;
    double work = rf_plan_work( plan, own, reuse );
    return work > 0.0 ? reach * samples * own / work : 1.0;
}

// Samples and rays of the frames asked for, over all sweeps.
static void count_rays( const RfGroupPlan* plan, const int* frames, int frame_count, double pixels, const PlanCounts* counts,
                        int index, RfPlanRow* row )
{
    int per_sweep = row->fit.sweeps > 1 ? row->fit.films : frame_count;
    double samples = 0.0, others = 0.0, once = 0.0, unused = 0.0;
    for ( int first = 0; first < frame_count; first += per_sweep )
        rf_add_group_samples( plan, frames, first, first + per_sweep < frame_count ? first + per_sweep : frame_count, &samples,
                              &others );
    rf_add_group_samples( plan, frames, 0, frame_count, &once, &unused );
    double per = pixels / counts->samples;
    row->samples = samples * pixels;
    row->repeated = samples / once;
    row->rays_primary = samples * pixels;
    row->rays_path = samples * per * (double)counts->rays.path;
    row->rays_shadow = samples * per * (double)counts->rays.shadow;
    row->rays_tile = samples * per * (double)counts->rays.tile;
    // visibility from the own eye is tested in blended scenes only, and counted there
    row->rays_eye =
        row->eyes > 1 ? others / ( row->eyes - 1 ) * per * counts->eye_rays[index] : samples * per * counts->eye_rays[index];
}

static void fixed_costs( const PlanCounts* c, const RfEstimatorSizes* sizes, int index, int eyes, double* own, double* reuse )
{
    double adding = ( c->hits * COST_ADD + c->glossy * COST_DIRECTION * sizes->directions ) / c->samples;
    *own = ( COST_PRIMARY * (double)c->rays.primary + COST_PATH * (double)c->rays.path + COST_SHADOW * (double)c->rays.shadow +
             COST_TILE * (double)c->rays.tile ) /
               c->samples +
           adding;
    *reuse = eyes > 1 ? COST_EYE * c->eye_rays[index] / c->samples / ( eyes - 1 ) + adding : 0.0;
}

// Why the automatic choice leaves a group out; NULL: it does not. It depends on path, size and settings
// alone, as if the whole path were asked for and one thread had all the memory. Several sweeps
// repeat the tracing, which the gain does not account for.
static const char* reason_against( const RfScene* scene, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                                   const RfPlanRow* row )
{
    RfRenderSettings s = *settings;
    s.group = row->group;
    s.threads = 1;
    if ( s.adaptive == RF_ADAPTIVE_AUTO ) // what may be of use in some frames is no reason for smaller groups in all
        s.adaptive = RF_ADAPTIVE_OFF;
    RfGroupPlan plan = rf_plan_samples( eye_count, row->group, settings->spp );
    RfRenderSizes sizes = rf_render_sizes( scene, eyes, &plan, eye_count, &s );
    RfMemoryFit fit;
    if ( rf_fit_memory( scene, eyes, eye_count, eye_count, &s, &fit, NULL ) != RF_OK )
        return s_no_room;
    if ( rf_films_bytes( &sizes ) > settings->memory / 2 )
        return s_films;
    if ( fit.sweeps > 1 )
        return s_sweeps;
    return (double)row->spp > ROUNDING * settings->spp ? s_rounded : NULL;
}

// The smallest group whose gain is as good as the best.
static void choose_row( RfPlan* plan )
{
    double best = 1.0;
    for ( int i = 0; i < plan->count; ++i )
        best = plan->rows[i].excluded == NULL && plan->rows[i].gain > best ? plan->rows[i].gain : best;
    while ( plan->rows[plan->chosen].excluded != NULL || plan->rows[plan->chosen].gain < FLAT * best )
        plan->chosen += 1;
    plan->rows[plan->chosen].chosen = true;
}

// A group that was chosen for the memory at hand goes without the memory of extra samples, which few frames may
// need, rather than through the path several times.
static RfResult settle_adaptive( const RfScene* scene, const RfEye* eyes, int eye_count, int frame_count,
                                 const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    RfPlanRow* row = plan->rows + plan->chosen;
    RfRenderSettings s = *settings;
    RfMemoryFit fit;
    plan->adaptive = settings->adaptive == RF_ADAPTIVE_AUTO && row->eyes == 1 ? RF_ADAPTIVE_OFF : settings->adaptive;
    s.group = row->group;
    s.threads = 1;
    if ( plan->adaptive != RF_ADAPTIVE_AUTO ||
         ( rf_fit_memory( scene, eyes, eye_count, eye_count, &s, &fit, NULL ) == RF_OK && fit.sweeps == 1 ) )
        return RF_OK;
    plan->adaptive = s.adaptive = RF_ADAPTIVE_OFF;
    s.threads = settings->threads;
    return rf_fit_memory( scene, eyes, eye_count, frame_count, &s, &row->fit, error );
}

static int rows_against( const RfPlan* plan, const char* reason )
{
    int count = 0;
    for ( int i = 0; i < plan->count; ++i )
        count += plan->rows[i].excluded == reason;
    return count;
}

static void explain( RfPlan* plan, const RfRenderSettings* settings )
{
    char rounded[96];
    snprintf( rounded, sizeof rounded, "%d sample%s would be rounded up by more than a quarter", settings->spp,
              settings->spp == 1 ? "" : "s" );
    const char* const reasons[][3] = { { s_films, s_films, s_films },
                                       { s_sweeps, s_sweeps, "go through the path several times" },
                                       { s_rounded, rounded, rounded },
                                       { s_no_room, s_no_room, "do not fit the memory" } };
    const RfPlanRow* best = plan->rows + plan->chosen;
    for ( int i = 0; i < plan->count; ++i )
        best = plan->rows[i].excluded == NULL && plan->rows[i].gain > best->gain ? plan->rows + i : best;
    size_t size = sizeof plan->why;
    if ( !rf_has_groups( settings->estimator ) )
    {
        snprintf( plan->why, size, "the estimator '%s' reuses no frames", settings->estimator->name );
        return;
    }
    size_t used =
        (size_t)snprintf( plan->why, size, "the smallest group within 10 %% of the best gain by fixed costs, %.1f with group %d",
                          best->gain, best->group );
    for ( size_t k = 0; k < sizeof reasons / sizeof reasons[0] && used < size; ++k )
    {
        int rows = rows_against( plan, reasons[k][0] );
        if ( rows > 0 )
            used += (size_t)snprintf( plan->why + used, size - used, "; %d row%s left out, %s", rows, rows == 1 ? "" : "s",
                                      reasons[k][rows == 1 ? 1 : 2] );
    }
    if ( plan->adaptive != settings->adaptive && plan->rows[plan->chosen].eyes > 1 && used < size )
        snprintf( plan->why + used, size - used, "; without extra samples, for which there is no room" );
}

// Counts a few batches of the path.
static RfResult count( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                       const RfPlan* plan, PlanCounts* counts, RfError* error )
{
    PlanProbe probe;
    int group_eyes[RF_PLAN_ROWS], most = 1;
    for ( int i = 0; i < plan->count; ++i )
    {
        // rows that do not fit have no room for their records here
        group_eyes[i] = rf_plan_row_fits( plan->rows + i ) ? plan->rows[i].eyes : 1;
        most = group_eyes[i] > most ? group_eyes[i] : most;
    }
    RfResult result = rf_begin_probe( tracer, eyes, eye_count, settings, most, &probe, error );
    if ( result == RF_OK )
        rf_count_plan( &probe, group_eyes, plan->count, counts );
    rf_end_probe( &probe );
    return result;
}

// Only the smallest group has to fit.
static RfResult fit_rows( const RfScene* scene, const RfEye* eyes, int eye_count, int frame_count,
                          const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    for ( int i = 0; i < plan->count; ++i )
    {
        RfPlanRow* row = plan->rows + i;
        RfRenderSettings s = *settings;
        s.group = row->group;
        RfResult result = rf_fit_memory( scene, eyes, eye_count, frame_count, &s, &row->fit, error );
        if ( result != RF_OK && i == 0 )
            return result;
        if ( i > 0 )
            row->excluded = result != RF_OK ? s_no_room : reason_against( scene, eyes, eye_count, settings, row );
    }
    return RF_OK;
}

static void weigh_rows( const RfEye* eyes, int eye_count, const int* frames, int frame_count, const RfRenderSettings* settings,
                        const RfEstimatorSizes* sizes, const PlanCounts* counts, RfPlan* plan )
{
    double pixels = (double)eyes->width * eyes->height;
    for ( int i = 0; i < plan->count; ++i )
    {
        RfPlanRow* row = plan->rows + i;
        if ( !rf_plan_row_fits( row ) )
            continue;
        RfGroupPlan groups = rf_plan_samples( eye_count, row->group, settings->spp );
        double own, reuse;
        fixed_costs( counts, sizes, i, row->eyes, &own, &reuse );
        row->reach = counts->share[i] > 0.0 ? counts->hits / counts->share[i] : 1.0;
        row->gain = gain_of( &groups, row->reach, own, reuse );
        count_rays( &groups, frames, frame_count, pixels, counts, i, row );
    }
}

RfResult rf_plan_render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                         const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    RfRenderSettings common;
    *plan = ( RfPlan ){ .c_e = NAN, .c_l = NAN, .c_v = NAN };
    RfResult result = rf_resolve_common( eyes, eye_count, settings, &common, error );
    if ( result != RF_OK )
        return result;
    list_rows( eye_count, &common, plan );
    const RfScene* scene = rf_tracer_scene( tracer );
    result = fit_rows( scene, eyes, eye_count, frame_count, &common, plan, error );
    PlanCounts counts;
    if ( result == RF_OK )
        result = count( tracer, eyes, eye_count, &common, plan, &counts, error );
    if ( result != RF_OK )
        return result;
    RfGroupPlan groups = rf_plan_groups( eye_count, 0, common.spp );
    RfRenderSizes sizes = rf_render_sizes( scene, eyes, &groups, 1, &common );
    weigh_rows( eyes, eye_count, frames, frame_count, &common, &sizes.of_estimator, &counts, plan );
    plan->hit_share = counts.hits / counts.samples;
    plan->glossy_share = counts.glossy / counts.samples;
    choose_row( plan );
    result = settle_adaptive( scene, eyes, eye_count, frame_count, &common, plan, error );
    if ( result != RF_OK )
        return result;
    weigh_rows( eyes, eye_count, frames, frame_count, &common, &sizes.of_estimator, &counts, plan ); // the chosen one's sweeps
    explain( plan, &common );
    rf_record_bytes( scene, &common, plan->rows[plan->chosen].eyes, &plan->bytes_diffuse, &plan->bytes_glossy );
    return RF_OK;
}

void rf_record_bytes( const RfScene* scene, const RfRenderSettings* settings, int eyes, size_t* diffuse, size_t* glossy )
{
    RfEye eye = { .width = 1, .height = 1 };
    RfEstimatorGroup group = rf_size_group( scene, rf_scene_traits( scene, &eye, 1, settings ), &eye, eyes, settings );
    RfEstimatorSizes sizes = settings->estimator->sizes( &group );
    *diffuse = sizes.diffuse_record;
    *glossy = sizes.shiny_record;
}
