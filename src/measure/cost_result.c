// What the trials of a measurement of cost say, and what that predicts.
#include "measure/cost_internal.h"

#include "base/system.h"
#include "render/groups.h"

#include <math.h>

static RfInterval slope_of( const RfCostCurve* c )
{
    double seconds[RF_COST_LEVELS], errors[RF_COST_LEVELS];
    for ( int i = 0; i < c->count; ++i )
    {
        seconds[i] = c->rows[i].seconds;
        errors[i] = c->rows[i].relmse;
    }
    return rf_fit_slope( seconds, errors, c->count );
}

// All trials of a curve as one: each weighs as its passes, since more samples determine the error better. The pieces of a
// position are the same in all levels.
static void sum_trials( const RfCostStudy* s, int curve, RfTrial* sum )
{
    *sum = ( RfTrial ){ 0 };
    for ( int i = 0; i < s->unit_count; ++i )
    {
        RfTrial trial = s->trials[i][curve];
        int first = 0, position = i % s->cost->positions;
        for ( int k = 0; k < position; ++k )
            first += s->regions[k].pieces.count;
        for ( int k = 0; k < trial.piece_count; ++k )
        {
            sum->pieces[first + k].weight += s->units[i].passes * trial.pieces[k].weight;
            sum->pieces[first + k].relmse += s->units[i].passes * trial.pieces[k].relmse;
        }
        int pieces = first + trial.piece_count;
        trial.piece_count = 0;
        rf_add_trial( sum, &trial );
        sum->piece_count = pieces > sum->piece_count ? pieces : sum->piece_count;
    }
}

static RfInterval speedup_of( const RfCostStudy* s )
{
    RfTrial sums[2];
    for ( int k = 0; k < 2; ++k )
        sum_trials( s, k, sums + k );
    return rf_trial_gain( sums, sums + 1 );
}

// All trials of a curve together, each weighing as its passes.
static double f1_squared_of( const RfCostStudy* s, int curve )
{
    double sum = 0.0, weights = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        double f1 = rf_trial_f1( &s->trials[i][curve], 1.0 );
        if ( !isfinite( f1 ) )
            continue;
        sum += s->units[i].passes * f1 * f1;
        weights += s->units[i].passes;
    }
    return weights > 0.0 ? sum / weights : (double)NAN;
}

void rf_fit_cost_curves( RfCostStudy* s )
{
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        RfCostPart sum = rf_sum_cost_units( s->units, s->unit_count, k );
        curves[k]->slope = slope_of( curves[k] );
        curves[k]->relmse = sum.relmse;
        curves[k]->f1_squared = f1_squared_of( s, k );
        curves[k]->sample_seconds = sum.wall_seconds;
    }
    s->cost->speedup = speedup_of( s );
    s->cost->seconds = rf_wall_seconds() - s->start;
}

// So many samples, at least two.
static RfCostPrediction predict_samples( const RfCostJob* job, const RfCostCurve* curve, double wanted, int per_sweep )
{
    RfCostPrediction p = { .frame_seconds = (double)NAN, .seconds = (double)NAN };
    if ( !( wanted <= RF_MAX_SPP ) )
        return p;
    RfGroupPlan plan = rf_plan_groups( job->eye_count, curve->group, wanted < 2.0 ? 2 : (int)wanted );
    double samples = 0.0, unused = 0.0;
    for ( int first = 0; first < job->frame_count; first += per_sweep )
    {
        int end = job->frame_count - first < per_sweep ? job->frame_count : first + per_sweep;
        rf_add_group_samples( &plan, job->frames, first, end, &samples, &unused );
    }
    p.spp = plan.spp;
    p.frame_seconds = rf_cost_frame_seconds( job, curve, plan.spp, curve->sample_seconds );
    p.seconds = samples * rf_cost_frame_pixels( job ) * curve->sample_seconds + job->frame_count * curve->finish_seconds;
    return p;
}

RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep )
{
    return predict_samples( job, curve, ceil( curve->relmse / relmse ), per_sweep );
}

RfCostPrediction rf_predict_flicker_cost( const RfCostJob* job, const RfCostCurve* curve, double flicker, int per_sweep )
{
    return predict_samples( job, curve, ceil( curve->f1_squared / ( flicker * flicker ) ), per_sweep );
}
