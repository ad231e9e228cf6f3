#include "reuse/plan_internal.h"

#include <math.h>
#include <stdio.h>

static const int s_groups[RF_PLAN_ROWS] = { 0, 1, 2, 3, 4, 6, 8, 12, 16 };

// Costs of rays relative to each other, that the choice rests on: about
// nanoseconds on one core of a 2.5 GHz Xeon with AVX2.
#define COST_PRIMARY 100.0 // with its records and films
#define COST_PATH 200.0
#define COST_SHADOW 100.0
#define COST_TILE 40.0
#define COST_EYE 30.0      // a test of visibility
#define COST_LANDING 4.0   // of a hit in a film, and
#define COST_LIT 7.0       // for each direction that a glossy one is lit from

static const char s_films[] = "films over half of --memory", s_rounded[] = "--spp rounded up too far";

#define FLAT 0.9    // of the best gain is as good: smaller groups need less memory, and less for a single frame
#define ROUNDING 1.25 // times the samples asked for may be traced

static void list_rows( int eye_count, int spp, RfPlan* plan )
{
    for ( int i = 0; i < RF_PLAN_ROWS; ++i )
    {
        RfGroupPlan groups = rf_plan_groups( eye_count, s_groups[i], spp );
        plan->rows[plan->count++] = ( RfPlanRow ){ .group = groups.eyes / 2, .eyes = groups.eyes, .spp = groups.spp,
                                                   .measured_gain = NAN, .seconds = NAN };
        if ( groups.eyes == eye_count )
            break;
    }
}

double rf_plan_work( const RfGroupPlan* plan, double own, double reuse )
{
    double work = 0.0;
    for ( int w = 0; w < plan->windows; ++w )
    {
        RfWindow window = rf_window( plan, w );
        work += (double)window.passes * window.eyes * ( own + ( window.eyes - 1 ) * reuse );
    }
    return work;
}

// The samples that a frame gets, and what a sample costs on the whole: the gain
// is their quotient, relative to no reuse.
static double gain_of( const RfGroupPlan* plan, double reach, double own, double reuse )
{
    double samples = (double)plan->frames * plan->spp;
    double work = rf_plan_work( plan, own, reuse );
    return work > 0.0 ? reach * samples * own / work : 1.0;
}

// Samples and rays of the frames asked for, over all sweeps.
static void count_rays( const RfGroupPlan* plan, const int* frames, int frame_count, double pixels,
                        const PlanCounts* counts, int index, RfPlanRow* row )
{
    int per_sweep = row->fit.sweeps > 1 ? row->fit.films : frame_count;
    double samples = 0.0, others = 0.0, once = 0.0, unused = 0.0;
    for ( int first = 0; first < frame_count; first += per_sweep )
        rf_add_window_samples( plan, frames, first, first + per_sweep < frame_count ? first + per_sweep : frame_count, &samples, &others );
    rf_add_window_samples( plan, frames, 0, frame_count, &once, &unused );
    double per = pixels / counts->samples;
    row->samples = samples * pixels;
    row->repeated = samples / once;
    row->rays_primary = samples * pixels;
    row->rays_path = samples * per * (double)counts->rays.path;
    row->rays_shadow = samples * per * (double)counts->rays.shadow;
    row->rays_tile = samples * per * (double)counts->rays.tile;
    // own eyes are tested in blended scenes only, and are in these counts then
    row->rays_eye = row->eyes > 1 ? others / ( row->eyes - 1 ) * per * counts->eye_rays[index] : samples * per * counts->eye_rays[index];
}

static void fixed_costs( const PlanCounts* c, const RfBatchShape* shape, int index, int eyes, double* own, double* reuse )
{
    double landing = ( c->hits * COST_LANDING + c->glossy * COST_LIT * rf_direction_count( shape ) ) / c->samples;
    *own = ( COST_PRIMARY * (double)c->rays.primary + COST_PATH * (double)c->rays.path + COST_SHADOW * (double)c->rays.shadow +
             COST_TILE * (double)c->rays.tile ) / c->samples + landing;
    *reuse = eyes > 1 ? COST_EYE * c->eye_rays[index] / c->samples / ( eyes - 1 ) + landing : 0.0;
}

// What auto leaves out, by the path, the size and the options alone.
static void exclude( const RfScene* scene, const RfEye* eyes, int eye_count, const RfRenderSettings* settings, RfPlanRow* row )
{
    RfGroupPlan plan = rf_plan_groups( eye_count, row->group, settings->spp );
    RenderSizes sizes = rf_render_sizes( scene, eyes, &plan, eye_count, settings );
    if ( row->group > 0 && rf_films_bytes( &sizes ) > settings->memory / 2 )
        row->excluded = s_films;
    else if ( row->group > 0 && (double)row->spp > ROUNDING * settings->spp )
        row->excluded = s_rounded;
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

static void explain( RfPlan* plan, const RfRenderSettings* settings )
{
    const RfPlanRow* row = plan->rows + plan->chosen;
    int films = 0, rounded = 0;
    double best = row->gain;
    for ( int i = 0; i < plan->count; ++i )
    {
        const RfPlanRow* other = plan->rows + i;
        films += other->excluded == s_films;
        rounded += other->excluded == s_rounded;
        best = other->excluded == NULL && other->gain > best ? other->gain : best;
    }
    int used = snprintf( plan->why, sizeof plan->why, "the smallest group within 10 %% of the best gain, %.1f", best );
    if ( films > 0 )
        used += snprintf( plan->why + used, sizeof plan->why - (size_t)used, "; %d row%s left out, films over half of --memory", films,
                          films == 1 ? "" : "s" );
    if ( rounded > 0 )
        snprintf( plan->why + used, sizeof plan->why - (size_t)used,
                  "; %d row%s left out, --spp %d would be rounded up by more than a quarter", rounded, rounded == 1 ? "" : "s",
                  settings->spp );
}

// From counts with one batch of hits at a time.
static RfResult count( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                       const RfPlan* plan, PlanCounts* counts, RfError* error )
{
    PlanProbe probe;
    int group_eyes[RF_PLAN_ROWS], rows = plan->count;
    for ( int i = 0; i < rows; ++i )
        group_eyes[i] = plan->rows[i].eyes;
    RfResult result = rf_begin_probe( tracer, eyes, eye_count, settings, group_eyes[rows - 1], &probe, error );
    if ( result == RF_OK )
        rf_count_plan( &probe, group_eyes, rows, counts );
    rf_end_probe( &probe );
    return result;
}

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
        if ( result != RF_OK )
            plan->count = i;
        if ( result != RF_OK )
            break;
        exclude( scene, eyes, eye_count, settings, row );
    }
    return RF_OK;
}

static void weigh_rows( const RfEye* eyes, int eye_count, const int* frames, int frame_count, const RfRenderSettings* settings,
                        const RfBatchShape* shape, const PlanCounts* counts, RfPlan* plan )
{
    double pixels = (double)eyes->width * eyes->height;
    for ( int i = 0; i < plan->count; ++i )
    {
        RfPlanRow* row = plan->rows + i;
        RfGroupPlan groups = rf_plan_groups( eye_count, row->group, settings->spp );
        double own, reuse;
        fixed_costs( counts, shape, i, row->eyes, &own, &reuse );
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
    list_rows( eye_count, common.spp, plan );
    const RfScene* scene = rf_tracer_scene( tracer );
    result = fit_rows( scene, eyes, eye_count, frame_count, &common, plan, error );
    PlanCounts counts;
    if ( result == RF_OK )
        result = count( tracer, eyes, eye_count, &common, plan, &counts, error );
    if ( result != RF_OK )
        return result;
    RfGroupPlan groups = rf_plan_groups( eye_count, 0, common.spp );
    RenderSizes sizes = rf_render_sizes( scene, eyes, &groups, 1, &common );
    weigh_rows( eyes, eye_count, frames, frame_count, &common, &sizes.shape, &counts, plan );
    plan->hit_share = counts.hits / counts.samples;
    plan->glossy_share = counts.glossy / counts.samples;
    choose_row( plan );
    explain( plan, &common );
    rf_record_bytes( scene, &common, plan->rows[plan->chosen].eyes, &plan->bytes_diffuse, &plan->bytes_glossy );
    return RF_OK;
}

void rf_record_bytes( const RfScene* scene, const RfRenderSettings* settings, int eyes, size_t* diffuse, size_t* glossy )
{
    RfGroupPlan plan = rf_plan_groups( eyes, eyes / 2, 1 );
    RfEye eye = { .width = 1, .height = 1 };
    RfBatchShape shape = rf_render_sizes( scene, &eye, &plan, 1, settings ).shape;
    size_t whole = rf_batch_bytes( &shape );
    shape.glossy = false;
    *diffuse = ( rf_batch_bytes( &shape ) + RF_LANES - 1 ) / RF_LANES;
    *glossy = ( whole + RF_LANES - 1 ) / RF_LANES;
}
