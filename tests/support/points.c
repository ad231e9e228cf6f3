#include "support/points.h"

#include "base/random.h"
#include "path/wavefront.h"

bool find_point( const RfTracer* tracer, RfVec3 o, RfVec3 d, Point* out, Panes* panes )
{
    const float* ro[3] = { &o.x, &o.y, &o.z };
    const float* rd[3] = { &d.x, &d.y, &d.z };
    uint32_t triangle;
    float u, v;
    if ( panes != NULL )
    {
        RfPaneLanes lanes = { &panes->probability, { &panes->weight.x, &panes->weight.y, &panes->weight.z } };
        rf_trace_nearest_past_panes( tracer, 1, ro, rd, &triangle, &u, &v, &lanes );
    }
    else
        rf_trace_nearest( tracer, 1, ro, rd, false, &triangle, &u, &v );
    if ( triangle == RF_MISS )
        return false;
    const RfTriangleRecord* t = rf_tracer_triangles( tracer ) + triangle;
    RfHitPoint hit = rf_hit_point( t, u, v, o, d );
    out->p = hit.p;
    out->wo = rf_scale( d, -1.0f );
    float facing = rf_dot( t->ng, out->wo );
    float side = facing < 0.0f ? -1.0f : 1.0f;
    out->ng = rf_scale( t->ng, side );
    RfVec3 n = rf_add( t->n0, rf_add( rf_scale( t->d1, u ), rf_scale( t->d2, v ) ) );
    float length2 = rf_dot( n, n );
    n = rf_scale( n, side / sqrtf( length2 ) );
    out->n = !t->flat && rf_dot( n, out->ng ) > 0.0f && length2 > 1e-12f ? n : out->ng;
    out->coat_n = out->n;
    const RfScene* scene = rf_tracer_scene( tracer );
    const RfMaterial* material = scene->materials + t->material;
    out->material = *material;
    if ( material->textured != NULL )
    {
        rf_material_at( scene, material, triangle, u, v, &out->material );
        RfVec3 front = rf_scale( out->n, side );
        out->n = rf_scale( rf_normal_at( scene, material, triangle, u, v, front, t->ng ), side );
        out->coat_n = rf_scale( rf_coat_normal_at( scene, material, triangle, u, v, front, t->ng ), side );
    }
    out->inside = facing < 0.0f;
    out->ior = out->material.thin ? -out->material.ior
                                  : ( out->inside && out->material.ior > 0.0f ? 1.0f / out->material.ior : out->material.ior );
    out->emission = rf_vec3( 0, 0, 0 );
    out->offset = hit.offset;
    out->light_pdf = 0.0f;
    out->light = t->light;
    if ( t->light != RF_NO_LIGHT )
    {
        const RfLight* light = rf_tracer_lights( tracer )->light + t->light;
        if ( facing > 0.0f || light->two_sided )
        {
            RfVec3 way = rf_sub( out->p, o );
            out->emission = light->textured ? rf_emission_at( scene, material, triangle, u, v ) : light->radiance;
            out->light_pdf = light->pdf_area * rf_dot( way, way ) / fabsf( facing );
        }
    }
    return true;
}

void fill_point_lane( const Point* x, Lane* lane )
{
    lane->lanes = ( RfBsdfLanes ){ .n = { &x->n.x, &x->n.y, &x->n.z } };
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        lane->param[p] =
            rf_has_param( RF_PARAMS_OF_HIT, (RfBsdfParam)p ) ? 0.0f : *rf_material_param( &x->material, (RfBsdfParam)p );
        lane->lanes.param[p] = lane->param + p;
    }
    lane->param[RF_PARAM_CLEARCOAT_N] = x->coat_n.x;
    lane->param[RF_PARAM_CLEARCOAT_N + 1] = x->coat_n.y;
    lane->param[RF_PARAM_CLEARCOAT_N + 2] = x->coat_n.z;
    lane->param[RF_PARAM_IOR] = x->ior;
}

bool is_native_point( const Point* x ) { return x->material.kind == RF_BSDF_GLASS; }

RfVec3 evaluate_point( const Point* x, RfVec3 wi, float* pdf )
{
    Lane lane;
    fill_point_lane( x, &lane );
    const float* wo[3] = { &x->wo.x, &x->wo.y, &x->wo.z };
    const float* in[3] = { &wi.x, &wi.y, &wi.z };
    RfVec3 f;
    float* out[3] = { &f.x, &f.y, &f.z };
    rf_bsdf_evaluate( x->material.kind, 1, &lane.lanes, wo, in, out, pdf );
    return f;
}

Onward scatter_at( const Point* x, RfRandomKey key, uint32_t dimension )
{
    Lane lane;
    fill_point_lane( x, &lane );
    float random[3];
    for ( uint32_t k = 0; k < 3; ++k )
        random[k] = rf_random( key, dimension + k );
    const float* wo[3] = { &x->wo.x, &x->wo.y, &x->wo.z };
    const float* u[3] = { random, random + 1, random + 2 };
    Onward out = { 0 };
    float* wi[3] = { &out.wi.x, &out.wi.y, &out.wi.z };
    float* weight[3] = { &out.weight.x, &out.weight.y, &out.weight.z };
    if ( is_native_point( x ) )
    {
        rf_bsdf_sample_weighted( x->material.kind, 1, &lane.lanes, wo, u, wi, weight, &out.pdf );
        float cos_g = rf_dot( x->ng, out.wi );
        out.cos_x = rf_dot( x->n, out.wi );
        out.side = out.cos_x * cos_g <= 0.0f || rf_max_component( out.weight ) == 0.0f ? 0.0f : ( cos_g > 0.0f ? 1.0f : -1.0f );
        return out;
    }
    rf_bsdf_sample( x->material.kind, 1, &lane.lanes, wo, u, wi );
    out.f = evaluate_point( x, out.wi, &out.pdf );
    out.cos_x = rf_dot( x->n, out.wi );
    out.side = out.cos_x > 0.0f && rf_dot( x->ng, out.wi ) > 0.0f && out.pdf > 0.0f ? 1.0f : 0.0f;
    return out;
}

RfVec3 onward_start( const Point* x, const Onward* onward ) { return rf_madd( x->p, x->ng, onward->side * x->offset ); }

RfVec3 part_left_at( const Point* x, RfVec3 o )
{
    if ( is_native_point( x ) && x->inside && !x->material.thin && rf_max_component( x->material.absorption ) > 0.0f )
        return rf_transmittance( x->material.absorption, rf_length( rf_sub( x->p, o ) ) );
    return rf_vec3( 1, 1, 1 );
}
