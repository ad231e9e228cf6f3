#include "support/reference_tracer.h"

#include "light/punctual.h"
#include "base/lattice.h"
#include "base/random.h"
#include "bsdf/bsdf.h"
#include "light/light.h"
#include "path/roulette.h"
#include "path/wavefront.h"
#include "support/statistics.h"
#include "support/select_light.h"

#include <stdlib.h>

bool find_point( const RfTracer* tracer, RfVec3 o, RfVec3 d, Point* out, Panes* panes )
{
    const float* ro[3] = { &o.x, &o.y, &o.z };
    const float* rd[3] = { &d.x, &d.y, &d.z };
    uint32_t triangle;
    float u, v;
    if ( panes != NULL )
    {
        RfPaneLanes lanes = { .probability = &panes->probability,
                              .weight = { &panes->weight.x, &panes->weight.y, &panes->weight.z } };
        rf_trace_nearest_past_panes( tracer, 1, ro, rd, &triangle, &u, &v, &lanes );
    }
    else
        rf_trace_nearest( tracer, 1, ro, rd, false, &triangle, &u, &v );
    if ( triangle == RF_MISS )
        return false;
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, triangle, &place );
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
    out->tangent = rf_vec3( 0.0f, 0.0f, 0.0f );
    if ( rf_has_param( rf_bsdf_model( out->material.kind )->params, RF_PARAM_TANGENT ) )
        out->tangent = rf_stretch_at( scene, &out->material, triangle, u, v, rf_scale( out->n, side ) );
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
    lane->param[RF_PARAM_TANGENT] = x->tangent.x;
    lane->param[RF_PARAM_TANGENT + 1] = x->tangent.y;
    lane->param[RF_PARAM_TANGENT + 2] = x->tangent.z;
    lane->param[RF_PARAM_IOR] = x->ior;
}

bool is_native_point( const Point* x ) { return x->material.kind >= RF_BSDF_FIRST_SPECULAR; }

// ---- translucent surfaces: both hemispheres at once, each sampled half of the time ----

#define SIDE_DIMENSION 0x03000000u // random numbers that nothing else uses

static bool is_translucent( const Point* x ) { return x->material.kind == RF_BSDF_TRANSLUCENT; }

static Point other_side( const Point* x )
{
    Point out = *x;
    out.n = rf_scale( x->n, -1.0f );
    out.ng = rf_scale( x->ng, -1.0f );
    return out;
}

// What the coat lets to the base and back.
static double to_base( const RfMaterial* m, double cosine )
{
    return 1.0 - (double)m->coat_f0 - (double)( m->coat_f90 - m->coat_f0 ) * pow( fmax( 1.0 - cosine, 0.0 ), 5.0 );
}

static RfVec3 evaluate_other_side( const Point* x, RfVec3 wi, float* pdf )
{
    double cos_i = -(double)rf_dot( x->n, wi ), cos_o = (double)rf_dot( x->n, x->wo ), least = (double)RF_MIN_COS;
    if ( cos_o < least ) // lifted to the horizon
        cos_o = least / sqrt( 1.0 - cos_o * cos_o + least * least );
    *pdf = (float)( 0.5 * fmax( cos_i, 0.0 ) * (double)RF_INV_PI );
    double f = cos_i > 0.0 ? (double)RF_INV_PI * to_base( &x->material, cos_i ) * to_base( &x->material, cos_o ) : 0.0;
    return rf_scale( x->material.through, (float)f );
}

RfVec3 evaluate_point( const Point* x, RfVec3 wi, float* pdf )
{
    if ( is_translucent( x ) && rf_dot( x->n, wi ) <= 0.0f )
        return evaluate_other_side( x, wi, pdf );
    if ( is_translucent( x ) )
    {
        Point opaque = *x;
        opaque.material.kind = RF_BSDF_GGX;
        RfVec3 f = evaluate_point( &opaque, wi, pdf );
        *pdf *= 0.5f;
        return f;
    }
    Lane lane;
    fill_point_lane( x, &lane );
    const float* wo[3] = { &x->wo.x, &x->wo.y, &x->wo.z };
    const float* in[3] = { &wi.x, &wi.y, &wi.z };
    RfVec3 f;
    float* out[3] = { &f.x, &f.y, &f.z };
    rf_bsdf_evaluate( x->material.kind, 1, &lane.lanes, wo, in, out, pdf );
    return f;
}

// A point of the lattice of src/reuse/estimators.md, section 24, for the film and the first vertex.
static uint32_t word( Numbers n, uint32_t dimension )
{
    static const int s_coordinates[] = { 3, 4, 0, 1, 2, -1, 2, 0, 1 }; // film; scattering and its roulette; light
    uint32_t place = dimension < 9 ? dimension : 6 + dimension % 3;
    if ( dimension >= 2 + n.block || s_coordinates[place] < 0 || n.block == 0 )
        return rf_random_bits( n.key, dimension );
    const RfLatticeSteps* step = rf_lattice_steps + s_coordinates[place];
    RfRandomKey block = rf_pixel_key( rf_pass_key( n.seed ^ 0x1a771ce00000u, 0, 0, n.pass % 2 ), n.y / 16 * 65536 + n.x / 16 );
    return rf_random_bits( block, dimension ) + n.pass / 2 * step->pass + n.frame * step->frame + n.x * step->x + n.y * step->y;
}

static float number( Numbers n, uint32_t dimension ) { return (float)( word( n, dimension ) >> 8 ) * 0x1p-24f; }

Onward scatter_at( const Point* x, Numbers key, uint32_t dimension )
{
    Lane lane;
    fill_point_lane( x, &lane );
    float random[3];
    for ( uint32_t k = 0; k < 3; ++k )
        random[k] = number( key, dimension + k );
    const float* wo[3] = { &x->wo.x, &x->wo.y, &x->wo.z };
    const float* u[3] = { random, random + 1, random + 2 };
    Onward out = { 0 };
    float* wi[3] = { &out.wi.x, &out.wi.y, &out.wi.z };
    float* weight[3] = { &out.weight.x, &out.weight.y, &out.weight.z };
    if ( is_translucent( x ) )
    {
        bool through = number( key, dimension + SIDE_DIMENSION ) < 0.5f;
        Point side = through ? other_side( x ) : *x;
        fill_point_lane( &side, &lane );
        rf_bsdf_sample( through ? RF_BSDF_LAMBERT : RF_BSDF_GGX, 1, &lane.lanes, wo, u, wi );
        out.f = evaluate_point( x, out.wi, &out.pdf );
        out.cos_x = rf_dot( side.n, out.wi );
        bool leaves = out.cos_x > 0.0f && rf_dot( side.ng, out.wi ) > 0.0f && out.pdf > 0.0f;
        out.side = !leaves ? 0.0f : through ? -1.0f : 1.0f;
        return out;
    }
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

// The normal that lights were picked by where a ray starts.
static RfVec3 onward_normal( const Point* x, const Onward* onward )
{
    return is_translucent( x ) && onward->side < 0.0f ? rf_scale( x->n, -1.0f ) : x->n;
}

RfVec3 onward_start( const Point* x, const Onward* onward ) { return rf_madd( x->p, x->ng, onward->side * x->offset ); }

RfVec3 part_left_at( const Point* x, RfVec3 o )
{
    if ( is_native_point( x ) && x->inside && !x->material.thin && rf_max_component( x->material.absorption ) > 0.0f )
        return rf_transmittance( x->material.absorption, rf_length( rf_sub( x->p, o ) ) );
    return rf_vec3( 1, 1, 1 );
}

// ---- reference tracer ----

#define LENS_DIMENSION 0x10000000u // random numbers that nothing else uses

// A ray, and the normal where it started: what lights were picked by there.
typedef struct Ray
{
    RfVec3 o, d, n;
} Ray;

static float chance_at_origin( const RfTracer* tracer, const ReferenceSettings* s, const Ray* ray, uint32_t light )
{
    return rf_light_probability( rf_tracer_lights( tracer ), s->light_sampling, light, ray->o, ray->n );
}

static RfVec3 sky_along( const RfTracer* tracer, const ReferenceSettings* s, const Ray* ray, float* light_pdf )
{
    const RfLights* lights = rf_tracer_lights( tracer );
    *light_pdf = 0.0f;
    if ( lights->sky.environment == NULL )
        return rf_vec3( 0, 0, 0 );
    *light_pdf =
        rf_sky_pdf_solid_angle_at( &lights->sky, ray->n, ray->d ) * chance_at_origin( tracer, s, ray, rf_sky_number( lights ) );
    return rf_sky_radiance( &lights->sky, ray->d );
}

// The light of a sample that arrives over a segment. Panes change its density with that of the ray.
static RfVec3 part_open( const RfTracer* tracer, const ReferenceSettings* s, RfVec3 from, RfVec3 segment, RfVec3 light,
                         float* pdf )
{
    const float* o[3] = { &from.x, &from.y, &from.z };
    const float* d[3] = { &segment.x, &segment.y, &segment.z };
    float visible;
    if ( s->panes_are_vertices )
    {
        rf_trace_segments( tracer, 1, o, d, &visible );
        return rf_scale( light, visible );
    }
    Panes panes;
    RfPaneLanes lanes = { .probability = &panes.probability, .weight = { &panes.weight.x, &panes.weight.y, &panes.weight.z } };
    rf_trace_segments_past_panes( tracer, 1, o, d, &visible, &lanes );
    if ( visible == 0.0f )
        return rf_vec3( 0, 0, 0 );
    *pdf /= panes.probability;
    return rf_scale( rf_mul( light, panes.weight ), visible );
}

// Uniform by area on a unit ball, or with `flat` on the half of it about the axis, as it is seen along that.
static RfVec3 on_ball( RfVec3 axis, bool flat, Numbers key, uint32_t dimension )
{
    float u = number( key, dimension + 1 ), phi = 2.0f * RF_PI * number( key, dimension + 2 );
    float along = flat ? sqrtf( 1.0f - u ) : 1.0f - 2.0f * u, across = sqrtf( rf_maxf( 1.0f - along * along, 0.0f ) );
    RfVec3 t, b;
    rf_basis( axis, &t, &b );
    return rf_madd( rf_add( rf_scale( t, across * cosf( phi ) ), rf_scale( b, across * sinf( phi ) ) ), axis, along );
}

// A sample of a punctual light, of those with a size by area and not as the renderer does it, or of the sky.
static RfVec3 sample_other_light( const RfTracer* tracer, const ReferenceSettings* s, const Point* x, RfLightSelection pick,
                                  Numbers key, uint32_t dimension, RfVec3* wi, float* pdf )
{
    const RfLights* lights = rf_tracer_lights( tracer );
    RfVec3 from = rf_madd( x->p, x->ng, x->offset ), radiance;
    float distance = 2.0f * ( rf_length( rf_sub( from, lights->center ) ) + lights->radius );
    int k = (int)( pick.light - lights->triangle_count );
    if ( k == lights->punctual_count )
    {
        uint32_t bits[2] = { ( word( key, dimension + 1 ) & ~255u ) | word( key, ( dimension + 1 ) | RF_DIMENSION_TWIN ) >> 24,
                             word( key, ( dimension + 2 ) | RF_DIMENSION_TWIN ) };
        uint32_t within = lights->sky.environment->map != NULL ? RF_DIMENSION_WITHIN : 0;
        float place[2] = { number( key, ( dimension + 1 ) | within ), number( key, ( dimension + 2 ) | within ) };
        RfSkySample sky = sample_sky_direction_at( &lights->sky, x->n, bits, place );
        *wi = sky.wi;
        *pdf = sky.pdf_solid_angle * pick.probability;
        radiance = rf_sky_radiance( &lights->sky, sky.wi );
    }
    else
    {
        const RfPunctual* p = lights->punctual + k;
        *pdf = pick.probability * RF_DELTA_PDF;
        if ( p->kind == RF_PUNCTUAL_DIRECTIONAL )
        {
            *wi = rf_scale( p->direction, -1.0f );
            radiance = rf_scale( p->intensity, RF_DELTA_PDF );
            if ( p->versine > 0.0f )
            {
                // uniform on the disc that a far surface which faces the sun sees
                RfVec3 n = on_ball( *wi, true, key, dimension );
                RfVec3 aside = rf_scale( rf_madd( n, *wi, -rf_dot( n, *wi ) ), sqrtf( p->versine * ( 2.0f - p->versine ) ) );
                float cosine = sqrtf( 1.0f - rf_dot( aside, aside ) );
                *wi = rf_madd( aside, *wi, cosine );
                radiance = rf_scale( radiance, 1.0f / cosine );
            }
        }
        else
        {
            RfVec3 n = on_ball( rf_vec3( 0, 0, 1 ), false, key, dimension ), way = rf_sub( p->position, from );
            way = p->radius > 0.0f ? rf_madd( way, n, p->radius ) : way;
            float d2 = rf_dot( way, way );
            distance = sqrtf( d2 );
            *wi = rf_scale( way, 1.0f / distance );
            float facing = p->radius > 0.0f ? 4.0f * rf_maxf( -rf_dot( n, *wi ), 0.0f ) : 1.0f;
            float t = ( -rf_dot( p->direction, *wi ) - p->cos_outer ) / ( p->cos_inner - p->cos_outer );
            t = t < 0.0f ? 0.0f : ( t > 1.0f ? 1.0f : t );
            float cone = p->kind == RF_PUNCTUAL_SPOT ? t * t : 1.0f;
            if ( p->profile != NULL )
                cone *= rf_profile_value( p->profile, rf_into_lamp( p, rf_scale( *wi, -1.0f ) ) );
            float r2 = d2 / ( p->range * p->range ), window = 1.0f - r2 * r2 > 0.0f ? 1.0f - r2 * r2 : 0.0f;
            radiance = rf_scale( p->intensity, cone * window / d2 * RF_DELTA_PDF * facing );
        }
    }
    float cos_x = rf_dot( x->n, *wi );
    if ( !( cos_x > 0.0f && rf_dot( x->ng, *wi ) > 0.0f && *pdf > 0.0f ) || rf_max_component( radiance ) == 0.0f )
        return rf_vec3( 0, 0, 0 );
    return part_open( tracer, s, from, rf_scale( *wi, distance ), rf_scale( radiance, cos_x ), pdf );
}

// A light sample at x: direction, density, and what arrives, times the cosine.
static RfVec3 sample_light( const RfTracer* tracer, const ReferenceSettings* s, const Point* x, Numbers key, uint32_t dimension,
                            RfVec3* wi, float* pdf )
{
    RfVec3 black = rf_vec3( 0, 0, 0 );
    const RfLights* lights = rf_tracer_lights( tracer );
    if ( lights->count == 0 )
        return black;
    RfVec3 from = rf_madd( x->p, x->ng, x->offset );
    uint32_t bits[2] = { word( key, dimension ), word( key, dimension | RF_DIMENSION_TWIN ) };
    RfLightSelection pick = select_light( lights, s->light_sampling, from, x->n, bits );
    if ( pick.light == RF_NO_LIGHT )
        return black;
    if ( pick.light >= lights->triangle_count )
        return sample_other_light( tracer, s, x, pick, key, dimension, wi, pdf );
    const RfLight* light = lights->light + pick.light;
    float root = sqrtf( number( key, dimension + 1 ) );
    float b1 = 1.0f - root, b2 = number( key, dimension + 2 ) * root;
    RfVec3 z = rf_add( light->p0, rf_add( rf_scale( light->e1, b1 ), rf_scale( light->e2, b2 ) ) );
    RfVec3 way = rf_sub( z, from );
    float d2 = rf_dot( way, way );
    *wi = rf_scale( way, 1.0f / sqrtf( d2 ) );
    float facing = -rf_dot( light->normal, *wi );
    float cos_light = light->two_sided ? fabsf( facing ) : facing;
    float cos_x = rf_dot( x->n, *wi );
    *pdf = light->pdf_area * pick.probability * d2 / cos_light;
    if ( !( cos_x > 0.0f && rf_dot( x->ng, *wi ) > 0.0f && cos_light > 0.0f && *pdf < 1e30f ) )
        return black;
    RfVec3 to = rf_madd( z, light->normal, facing < 0.0f ? -light->offset : light->offset );
    RfVec3 radiance = rf_light_radiance( rf_tracer_scene( tracer ), light, b1, b2 );
    if ( rf_max_component( radiance ) == 0.0f )
        return black;
    return part_open( tracer, s, from, rf_sub( to, from ), rf_scale( radiance, cos_x ), pdf );
}

// Light samples of a vertex: of a translucent one as many on either side.
static int samples_at( const ReferenceSettings* s, const Point* x ) { return s->light_samples * ( is_translucent( x ) ? 2 : 1 ); }

// Number j of them.
static RfVec3 sample_side( const RfTracer* tracer, const ReferenceSettings* s, const Point* x, Numbers key, int vertex, int j,
                           RfVec3* wi, float* pdf )
{
    int k = s->light_samples;
    uint32_t dimension = rf_vertex_dimension( vertex, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)( j % k );
    Point side = j < k ? *x : other_side( x );
    return sample_light( tracer, s, &side, key, j < k ? dimension : dimension + SIDE_DIMENSION, wi, pdf );
}

// Light that leaves x towards wo by the light samples.
static RfVec3 direct( const RfTracer* tracer, const ReferenceSettings* s, const Point* x, Numbers key, int vertex,
                      RfVec3 throughput, RfVec3 sum )
{
    int k = s->light_samples;
    for ( int j = 0; j < samples_at( s, x ); ++j )
    {
        RfVec3 wi = { 0 };
        float pdf_light = 1.0f, pdf;
        RfVec3 arriving = sample_side( tracer, s, x, key, vertex, j, &wi, &pdf_light );
        if ( rf_max_component( arriving ) == 0.0f )
            continue;
        RfVec3 f = evaluate_point( x, wi, &pdf );
        float scale = 1.0f / ( (float)k * pdf_light + pdf );
        sum = rf_add( sum, rf_scale( rf_mul( rf_mul( throughput, f ), arriving ), scale ) );
    }
    return sum;
}

// The vertices of a path: whether they throw caustics.
typedef struct Course
{
    bool keeps;          // all light counts
    bool matte;          // a vertex before the last is neither native nor throws caustics
    bool throws, native; // the last
} Course;

static bool throws_all( const Point* x )
{
    const RfMaterial* m = &x->material;
    bool black = !( rf_max_component( m->diffuse ) > 0.0f );
    if ( is_native_point( x ) )
        return black || m->ior == 0.0f;
    return m->kind >= RF_BSDF_GGX && m->kind <= RF_BSDF_LAYERED && black && m->alpha <= 0.1f;
}

// Whether light that comes to the last vertex counts: on the way to the camera a surface that throws nothing must not come after
// those that do.
static bool counts( const Course* c )
{
    bool matte = c->matte || !( c->throws || c->native );
    return c->keeps || !matte || !c->throws;
}

// Light that arrives along a ray: emitted by the first point it finds, and the
// rest.
typedef struct Arriving
{
    RfVec3 emitted, rest;
    float light_pdf;
} Arriving;

// A ray that did not pass a pane, which has a probability: only base and reflection are left of it.
static void stop_at_pane( Point* x, RfVec3* throughput )
{
    if ( !is_native_point( x ) )
        return;
    Lane lane;
    fill_point_lane( x, &lane );
    RfPane pane = rf_pane_of_lane( x->material.kind, &lane.lanes, 0, x->wo );
    if ( pane.probability == 0.0f )
        return;
    float stopped = rf_maxf( 1.0f - pane.probability, 0x1p-24f );
    *throughput = rf_vec3( throughput->x / stopped, throughput->y / stopped, throughput->z / stopped );
    x->material.tint = rf_vec3( 0, 0, 0 );
}

// What a ray meets at its end: a surface, or the sky.
static bool meet( const RfTracer* tracer, const ReferenceSettings* s, const Ray* ray, Point* x, RfVec3* throughput, RfVec3* light,
                  float* light_pdf )
{
    Panes panes = { 1.0f, { 1, 1, 1 } };
    bool found = find_point( tracer, ray->o, ray->d, x, s->panes_are_vertices ? NULL : &panes );
    *throughput = rf_mul( *throughput, panes.weight );
    if ( !found )
    {
        *light = sky_along( tracer, s, ray, light_pdf );
        *light_pdf /= panes.probability;
        return false;
    }
    if ( !s->panes_are_vertices )
        stop_at_pane( x, throughput );
    *light = x->emission;
    *light_pdf = x->light_pdf > 0.0f ? x->light_pdf * chance_at_origin( tracer, s, ray, x->light ) : 0.0f;
    *light_pdf /= panes.probability;
    *throughput = rf_mul( *throughput, part_left_at( x, ray->o ) );
    return true;
}

static Arriving arriving_light( const RfTracer* tracer, const ReferenceSettings* s, Numbers key, Ray ray, RfVec3 throughput,
                                float roulette_scale, const Point* first, float first_pdf )
{
    bool native = is_native_point( first );
    Course course = { .keeps = !s->without_caustics,
                      .throws = throws_all( first ) || ( native && first_pdf >= RF_DELTA_PDF ),
                      .native = native };
    Arriving result = { { 0, 0, 0 }, { 0, 0, 0 }, 0.0f };
    float pdf_scatter = 0.0f;
    for ( int vertex = 2; vertex <= s->max_depth; ++vertex )
    {
        Point x;
        RfVec3 light;
        float light_pdf;
        bool surface = meet( tracer, s, &ray, &x, &throughput, &light, &light_pdf );
        if ( vertex == 2 )
        {
            result.emitted = rf_mul( throughput, light );
            result.light_pdf = light_pdf;
        }
        else
        {
            float weight = pdf_scatter / ( pdf_scatter + (float)s->light_samples * light_pdf );
            weight = counts( &course ) ? weight : 0.0f;
            result.rest = rf_add( result.rest, rf_scale( rf_mul( throughput, light ), weight ) );
        }
        if ( !surface || vertex == s->max_depth )
            break;
        course.matte = course.matte || !( course.throws || course.native );
        course.throws = throws_all( &x );
        course.native = is_native_point( &x );
        if ( counts( &course ) )
            result.rest = direct( tracer, s, &x, key, vertex, throughput, result.rest );
        uint32_t dimension = rf_vertex_dimension( vertex, s->light_samples );
        Onward onward = scatter_at( &x, key, dimension + RF_DIMENSION_SCATTER );
        if ( !( onward.pdf > 0.0f ) )
            break;
        pdf_scatter = onward.pdf;
        course.throws = course.throws || ( course.native && onward.pdf >= RF_DELTA_PDF );
        throughput = is_native_point( &x ) ? rf_mul( throughput, onward.weight )
                                           : rf_scale( rf_mul( throughput, onward.f ), onward.cos_x / onward.pdf );
        float q = vertex < RF_ROULETTE_VERTEX ? 1.0f : rf_survival( rf_max_component( throughput ) * roulette_scale, vertex );
        if ( !( onward.side != 0.0f && number( key, dimension + RF_DIMENSION_ROULETTE ) < q ) )
            break;
        throughput = rf_vec3( throughput.x / q, throughput.y / q, throughput.z / q );
        ray = ( Ray ){ onward_start( &x, &onward ), onward.wi, onward_normal( &x, &onward ) };
    }
    return result;
}

// A pane that the camera ray passes does not count in the depth, like those that other rays pass.
static bool passes_pane( const ReferenceSettings* s, const Point* x, const Onward* onward )
{
    Lane lane;
    fill_point_lane( x, &lane );
    return !s->panes_are_vertices && onward->side < 0.0f &&
           rf_pane_of_lane( x->material.kind, &lane.lanes, 0, x->wo ).probability > 0.0f;
}

static RfVec3 scattered_light( const RfTracer* tracer, const ReferenceSettings* s, Numbers key, const Point* x )
{
    Onward onward = scatter_at( x, key, rf_vertex_dimension( 1, s->light_samples ) + RF_DIMENSION_SCATTER );
    if ( onward.side == 0.0f )
        return rf_vec3( 0, 0, 0 );
    Ray ray = { onward_start( x, &onward ), onward.wi, onward_normal( x, &onward ) };
    float k = (float)s->light_samples;
    if ( is_native_point( x ) )
    {
        ReferenceSettings left = *s;
        left.max_depth += passes_pane( s, x, &onward );
        Arriving in = arriving_light( tracer, &left, key, ray, onward.weight, 1.0f, x, onward.pdf );
        return rf_add( rf_scale( in.emitted, onward.pdf / ( onward.pdf + k * in.light_pdf ) ), in.rest );
    }
    float factor = onward.pdf > 0.0f ? rf_max_component( onward.f ) * onward.cos_x / onward.pdf : 0.0f;
    Arriving in = arriving_light( tracer, s, key, ray, rf_vec3( 1, 1, 1 ), rf_shared_factor( factor ), x, onward.pdf );
    RfVec3 emitted = rf_scale( rf_scale( in.emitted, onward.cos_x ), 1.0f / ( k * in.light_pdf + onward.pdf ) );
    return rf_mul( onward.f, rf_add( emitted, rf_scale( rf_scale( in.rest, onward.cos_x ), 1.0f / onward.pdf ) ) );
}

// Through a point of a sphere around the eye, the film of a panorama.
static Ray panoramic_ray( const RfEye* eye, Numbers key, int x, int y )
{
    double longitude = 6.283185307179586 * ( ( x + (double)number( key, RF_DIMENSION_FILM_X ) ) / eye->width - 0.5 );
    double polar = 3.141592653589793 * ( y + (double)number( key, RF_DIMENSION_FILM_Y ) ) / eye->height;
    RfVec3 level = rf_madd( rf_scale( eye->forward, (float)cos( longitude ) ), eye->right, (float)sin( longitude ) );
    RfVec3 d = rf_madd( rf_scale( level, (float)sin( polar ) ), eye->up, (float)cos( polar ) );
    return ( Ray ){ eye->origin, rf_normalize( d ), rf_vec3( 0, 0, 0 ) };
}

// From a point of the plane through the origin.
static Ray parallel_ray( const RfEye* eye, Numbers key, int x, int y )
{
    float right = ( (float)x + number( key, RF_DIMENSION_FILM_X ) - eye->axis_x ) / eye->focal_x;
    float down = ( (float)y + number( key, RF_DIMENSION_FILM_Y ) - eye->axis_y ) / eye->focal;
    return ( Ray ){ rf_madd( rf_madd( eye->origin, eye->right, right ), eye->up, -down ), eye->forward, rf_vec3( 0, 0, 0 ) };
}

static RfVec3 first_direction( const RfEye* eye, Numbers key, int x, int y )
{
    float inverse_x = 1.0f / eye->focal_x, inverse_y = 1.0f / eye->focal;
    float fx = ( (float)x + number( key, RF_DIMENSION_FILM_X ) - eye->axis_x ) * inverse_x;
    float fy = ( eye->axis_y - (float)y - number( key, RF_DIMENSION_FILM_Y ) ) * inverse_y;
    RfVec3 d = rf_madd( rf_madd( eye->forward, eye->right, fx ), eye->up, fy );
    return rf_scale( d, 1.0f / sqrtf( rf_dot( d, d ) ) );
}

static Ray first_ray( const RfEye* eye, Numbers key, int x, int y )
{
    if ( eye->projection == RF_PANORAMIC )
        return panoramic_ray( eye, key, x, y );
    if ( eye->projection == RF_ORTHOGRAPHIC )
        return parallel_ray( eye, key, x, y );
    return ( Ray ){ eye->origin, first_direction( eye, key, x, y ), rf_vec3( 0, 0, 0 ) };
}

// A value on the parabola through three at −1, 0 and 1, by Lagrange.
static RfVec3 on_parabola( RfVec3 first, RfVec3 middle, RfVec3 last, float t )
{
    RfVec3 sum = rf_scale( first, 0.5f * t * ( t - 1.0f ) );
    sum = rf_add( sum, rf_scale( middle, ( 1.0f - t ) * ( 1.0f + t ) ) );
    return rf_add( sum, rf_scale( last, 0.5f * t * ( t + 1.0f ) ) );
}

// The camera at a time of the shutter, drawn for each sample anew.
static RfEye moved_eye( const RfEye* eye, float t )
{
    RfVec3 focal =
        on_parabola( rf_vec3( eye->open.focal, 0, 0 ), rf_vec3( eye->focal, 0, 0 ), rf_vec3( eye->close.focal, 0, 0 ), t );
    RfEye out = rf_make_eye( on_parabola( eye->open.origin, eye->origin, eye->close.origin, t ),
                             on_parabola( eye->open.forward, eye->forward, eye->close.forward, t ),
                             on_parabola( eye->open.up, eye->up, eye->close.up, t ), 1.0, eye->width, eye->height );
    out.focal = focal.x;
    out.focal_x = focal.x * eye->focal_x / eye->focal;
    RfVec3 axis = on_parabola( rf_vec3( eye->open.axis_x, eye->open.axis_y, 0 ), rf_vec3( eye->axis_x, eye->axis_y, 0 ),
                               rf_vec3( eye->close.axis_x, eye->close.axis_y, 0 ), t );
    out.axis_x = axis.x;
    out.axis_y = axis.y;
    out.lens_radius = eye->lens_radius;
    out.focus = eye->focus;
    out.projection = eye->projection;
    return out;
}

// A ray through a round lens: the one through its middle leads to the point in focus.
static void bend_ray( const RfEye* eye, Numbers key, Ray* ray )
{
    RfVec3 sharp = rf_madd( ray->o, ray->d, eye->focus / rf_dot( ray->d, eye->forward ) );
    float radius = eye->lens_radius * sqrtf( number( key, LENS_DIMENSION ) );
    float angle = 6.28318531f * number( key, LENS_DIMENSION + 1 );
    ray->o = rf_madd( rf_madd( ray->o, eye->right, radius * cosf( angle ) ), eye->up, radius * sinf( angle ) );
    ray->d = rf_normalize( rf_sub( sharp, ray->o ) );
}

// Light that leaves a point that the camera sees.
static RfVec3 seen_light( const RfTracer* tracer, const ReferenceSettings* s, Numbers key, const Point* hit );

ReferenceSettings reference_settings_of( const RfRenderSettings* settings, int frame )
{
    return ( ReferenceSettings ){ .spp = settings->spp,
                                  .max_depth = settings->max_depth,
                                  .light_samples = settings->light_samples,
                                  .seed = settings->seed,
                                  .frame = frame,
                                  .light_sampling = settings->light_sampling,
                                  .stratified = true };
}

RfVec3 reference_sample( const RfTracer* tracer, const RfEye* eye, const ReferenceSettings* s, int pass, int x, int y )
{
    uint64_t pass_key = rf_pass_key( s->seed, (uint32_t)s->frame, (uint32_t)s->frame, (uint32_t)pass );
    Numbers key = { .key = rf_pixel_key( pass_key, (uint32_t)( y * eye->width + x ) ),
                    .block = s->stratified ? 4 + 3 * (uint32_t)s->light_samples : 0,
                    .seed = s->seed,
                    .pass = (uint32_t)( s->frame * s->spp + pass ),
                    .frame = (uint32_t)s->frame,
                    .x = (uint32_t)x,
                    .y = (uint32_t)y };
    Point hit;
    RfEye moved;
    if ( eye->moves )
    {
        moved = moved_eye( eye, 2.0f * number( key, LENS_DIMENSION + 2 ) - 1.0f );
        eye = &moved;
    }
    Ray ray = first_ray( eye, key, x, y );
    if ( eye->lens_radius > 0.0f )
        bend_ray( eye, key, &ray );
    if ( !find_point( tracer, ray.o, ray.d, &hit, NULL ) )
    {
        float pdf;
        bool hidden = rf_tracer_scene( tracer )->environment.hidden;
        return hidden ? rf_vec3( 0, 0, 0 ) : sky_along( tracer, s, &ray, &pdf );
    }
    RfVec3 sum = seen_light( tracer, s, key, &hit );
    return rf_mul( sum, part_left_at( &hit, ray.o ) );
}

static RfVec3 seen_light( const RfTracer* tracer, const ReferenceSettings* s, Numbers key, const Point* hit )
{
    RfVec3 sum = hit->emission;
    if ( s->max_depth == 1 )
        return sum;
    for ( int j = 0; j < samples_at( s, hit ); ++j )
    {
        RfVec3 wi = { 0 };
        float pdf_light = 1.0f, pdf;
        RfVec3 arriving = sample_side( tracer, s, hit, key, 1, j, &wi, &pdf_light );
        RfVec3 f = evaluate_point( hit, wi, &pdf );
        sum = rf_add( sum, rf_mul( f, rf_scale( arriving, 1.0f / ( (float)s->light_samples * pdf_light + pdf ) ) ) );
    }
    return rf_add( sum, scattered_light( tracer, s, key, hit ) );
}

void reference_image( const RfTracer* tracer, const RfEye* eye, const ReferenceSettings* settings, float* rgb )
{
    ReferenceSettings of_suite = *settings, *s = &of_suite;
    s->seed += suite_seed();
    s->spp *= suite_samples();
    for ( int y = 0; y < eye->height; ++y )
    {
        for ( int x = 0; x < eye->width; ++x )
        {
            float half[2][3] = { { 0 } };
            for ( int pass = 0; pass < s->spp; ++pass )
            {
                RfVec3 value = reference_sample( tracer, eye, s, pass, x, y );
                float* sum = half[( s->frame * s->spp + pass ) & 1];
                sum[0] += value.x;
                sum[1] += value.y;
                sum[2] += value.z;
            }
            float* out = rgb + 3 * ( (size_t)y * (size_t)eye->width + (size_t)x );
            for ( int c = 0; c < 3; ++c )
                out[c] = (float)( ( (double)half[0][c] + (double)half[1][c] ) / s->spp );
        }
    }
}
