#include "support/walks.h"

#include "path/roulette.h"
#include "path/wavefront.h"

#include <math.h>

#define ROULETTE_AFTER ( RF_ROULETTE_VERTEX - 1 ) // hits
#define DIMENSIONS 4u                             // random numbers of a hit

bool advance_walk( const RfTracer* tracer, Walk* w, Point* x )
{
    if ( !find_point( tracer, w->o, w->d, x, NULL ) )
        return false;
    RfVec3 way = rf_sub( x->p, w->o );
    float cosine = rf_dot( x->ng, x->wo );
    w->throughput = rf_mul( w->throughput, part_left_at( x, w->o ) );
    w->vcm *= rf_dot( way, way ) / cosine;
    w->vc /= cosine;
    ++w->hits;
    return cosine > 0.0f;
}

Point seen_from( const Point* x, RfVec3 wo )
{
    Point other = *x;
    other.wo = wo;
    return other;
}

RfVec3 carried_light( const Point* x, RfVec3 to_eye, float* pdf_reverse )
{
    Point seen = seen_from( x, to_eye );
    RfVec3 f = evaluate_point( &seen, x->wo, pdf_reverse );
    return rf_scale( f, fabsf( rf_dot( x->n, x->wo ) ) / rf_dot( x->ng, x->wo ) );
}

static void pass_delta( Walk* w, const Point* x, const Onward* onward )
{
    float in_n = fabsf( rf_dot( x->n, x->wo ) ), in_g = rf_dot( x->ng, x->wo );
    float out_n = fabsf( onward->cos_x ), out_g = fabsf( rf_dot( x->ng, onward->wi ) );
    float index2 = onward->side < 0.0f ? x->ior * x->ior : 1.0f; // far over near, squared
    w->throughput = rf_mul( w->throughput, onward->weight );
    if ( w->from_light ) // weights are those of radiance
        w->throughput = rf_scale( w->throughput, index2 * in_n * out_g / ( out_n * in_g ) );
    w->vcm = 0.0f;
    w->vc *= out_g * in_n / ( out_n * index2 );
}

static void pass_nonspecular( Walk* w, const Point* x, const Onward* onward )
{
    float reverse, out_g = rf_dot( x->ng, onward->wi );
    RfVec3 f = carried_light( x, onward->wi, &reverse ); // of light paths
    f = w->from_light ? rf_scale( f, out_g ) : rf_scale( onward->f, onward->cos_x );
    w->throughput = rf_scale( rf_mul( w->throughput, f ), 1.0f / onward->pdf );
    w->vc = out_g / onward->pdf * ( w->vc * reverse + w->vcm );
    w->vcm = 1.0f / onward->pdf;
}

bool scatter_walk( Walk* w, const Point* x )
{
    Onward onward = scatter_at( x, w->key, w->dimension );
    uint32_t roulette = w->dimension + 3;
    w->dimension += DIMENSIONS;
    if ( onward.side == 0.0f || !( onward.pdf > 0.0f ) )
        return false;
    if ( is_native_point( x ) )
        pass_delta( w, x, &onward );
    else
        pass_nonspecular( w, x, &onward );
    float bright = rf_max_component( w->throughput ) / w->full;
    float q = w->hits < ROULETTE_AFTER ? 1.0f : rf_survival( bright );
    if ( !( bright > 0.0f ) || rf_random( w->key, roulette ) >= q )
        return false;
    w->throughput = rf_scale( w->throughput, 1.0f / q );
    w->o = onward_start( x, &onward );
    w->d = onward.wi;
    return true;
}
