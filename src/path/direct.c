// Light samples at the vertices of a wavefront (src/reuse/estimators.md, section 3).
// Emissive triangles are sampled in vector loops; punctual lights and the sky one by one.
#include "path/wavefront.h"

#include "base/fault.h"
#include "light/extent.h"
#include "light/punctual.h"

#include <float.h>
#include <string.h>

// Radiance of punctual lights and of the sky is bounded by this, which leaves room among the floats for scattering models and
// throughputs.
#define MAX_PUNCTUAL_RADIANCE 1e32f

// A sample of a punctual light or of the sky: direction, unoccluded radiance, and the length of the shadow segment. A punctual
// light is a delta: its density is RF_DELTA_PDF and its radiance has the same factor, or both a smaller one where the radiance
// would exceed the bound.
typedef struct NonAreaSample
{
    RfVec3 wi, radiance; // of the sky: 1, to be looked up where nothing is in the way
    float pdf_solid_angle;
    float distance;
    bool sky;
} NonAreaSample;

// Radiance and density in the right ratio, the radiance as large as may be: the density remains far above those
// of scattering models, which it competes with in MIS.
static void set_bright( const RfPunctual* p, double scale, float probability, NonAreaSample* sample )
{
    double most = (double)rf_max_component( p->intensity ), delta = (double)MAX_PUNCTUAL_RADIANCE / ( most * scale );
    if ( !( most * scale > 0.0 ) )
        return;
    sample->radiance = rf_scale( p->intensity, (float)( (double)MAX_PUNCTUAL_RADIANCE / most ) );
    sample->pdf_solid_angle = probability * (float)delta;
}

static NonAreaSample sample_directional( const RfLights* lights, const RfPunctual* p, float probability, const float u[2],
                                         RfVec3 from )
{
    NonAreaSample sample = {
        .wi = rf_scale( p->direction, -1.0f ),
        .radiance = rf_scale( p->intensity, RF_DELTA_PDF ),
        .pdf_solid_angle = probability * RF_DELTA_PDF,
        .distance = 2.0f * ( rf_length( rf_sub( from, lights->center ) ) + lights->reach ),
    };
    if ( p->versine > 0.0f )
    {
        RfExtentSample s = rf_sample_sun( p, u );
        sample.wi = s.wi;
        sample.radiance = rf_scale( sample.radiance, s.weight );
    }
    return sample;
}

// Where the lamp would be brighter than the bound, as bright as that.
static void set_lamp( const RfPunctual* p, float scale, float probability, NonAreaSample* sample )
{
    if ( rf_max_component( p->intensity ) * ( scale * RF_DELTA_PDF ) < MAX_PUNCTUAL_RADIANCE || RF_FAULT( lamp_bright ) ||
         RF_FAULT( lamp_infinite ) )
        sample->radiance = rf_scale( p->intensity, scale * RF_DELTA_PDF );
    else
        set_bright( p, (double)scale, probability, sample );
}

// One of the points of a lamp with size.
static NonAreaSample sample_extent( const RfPunctual* p, float probability, const float u[2], RfVec3 from )
{
    NonAreaSample sample = { .pdf_solid_angle = probability * RF_DELTA_PDF };
    RfExtentSample s = p->kind == RF_PUNCTUAL_PLANE ? rf_sample_plane( p, from, u ) : rf_sample_ball( p, from, u );
    sample.wi = s.wi;
    sample.distance = s.distance;
    float falloff = rf_lamp_falloff( p, rf_scale( s.wi, -1.0f ) ) * rf_range_falloff( s.distance * s.distance, p->range );
    if ( s.weight * falloff > 0.0f )
        set_lamp( p, s.weight * falloff, probability, &sample );
    else
        sample.pdf_solid_angle = 0.0f;
    return sample;
}

// Of point and spot lights.
static NonAreaSample sample_lamp( const RfLights* lights, const RfPunctual* p, float probability, const float u[2], RfVec3 from )
{
    if ( p->radius > 0.0f )
        return sample_extent( p, probability, u, from );
    NonAreaSample sample = { .pdf_solid_angle = probability * RF_DELTA_PDF };
    RfVec3 to_light = rf_sub( p->position, from );
    float d2 = rf_dot( to_light, to_light );
    sample.distance = sqrtf( d2 );
    if ( !( d2 > 0.0f ) )
    {
        sample.pdf_solid_angle = 0.0f;
        return sample;
    }
    sample.wi = rf_scale( to_light, 1.0f / sample.distance );
    // bounds the radiance next to the light
    float least = 1e-5f * lights->radius;
    d2 = rf_maxf( d2, least * least );
    float falloff = rf_lamp_falloff( p, rf_scale( sample.wi, -1.0f ) ) * rf_range_falloff( d2, p->range ),
          scale = falloff / d2 * RF_DELTA_PDF;
    if ( rf_max_component( p->intensity ) * scale < MAX_PUNCTUAL_RADIANCE || RF_FAULT( lamp_bright ) ||
         RF_FAULT( lamp_infinite ) )
        sample.radiance = rf_scale( p->intensity, scale );
    else
        set_bright( p, falloff / (double)d2, probability, &sample );
    return sample;
}

// Samples the light selected at `from`, which must not be a triangle or the sky. `u`: two uniform numbers.
static NonAreaSample sample_punctual( const RfLights* lights, RfLightSelection selection, const float u[2], RfVec3 from )
{
    const RfPunctual* p = rf_punctual_light( lights, selection.light );
    switch ( rf_light_kind( lights, selection.light ) )
    {
        case RF_LIGHT_TRIANGLE: // sampled in the vector loop
        case RF_LIGHT_SKY: break;
        case RF_LIGHT_POINT:
        case RF_LIGHT_SPOT: return sample_lamp( lights, p, selection.probability, u, from );
        case RF_LIGHT_PLANE: return sample_extent( p, selection.probability, u, from );
        case RF_LIGHT_DIRECTIONAL: return sample_directional( lights, p, selection.probability, u, from );
    }
    return ( NonAreaSample ){ 0 };
}

// The sampled points on the lights, gathered for the vector loop.
typedef struct LightPoints
{
    RF_ALIGN float p[3][RF_LANES];
    float n[3][RF_LANES];
    float radiance[3][RF_LANES];
    float pdf_area[RF_LANES];
    float offset[RF_LANES];
    float two_sided[RF_LANES]; // 1 or 0
    RfLightSelection selection[RF_LANES];
    int32_t non_area_count; // lanes whose light is punctual or the environment
    int32_t non_area[RF_LANES];
    bool sky[RF_LANES]; // where non_area_count > 0
} LightPoints;

// Samples of the sky, those alone.
typedef struct SkySamples
{
    RF_ALIGN float n[3][RF_SKY_LANES];
    float u[2][RF_SKY_LANES], wi[3][RF_SKY_LANES], pdf_solid_angle[RF_SKY_LANES];
    uint32_t bits[2][RF_SKY_LANES];
} SkySamples;

// Where scattered rays start as well, so that both techniques of (E3) measure the
// same directions and distances.
static inline RfVec3 start_of( const RfVertexLanes* v, int i )
{
    return rf_madd( RF_GET3( v->p, i ), RF_GET3( v->ng, i ), v->offset[i] );
}

// The tracer of the frame that a light sample is of.
static inline const RfTracer* tracer_of( const RfPathSettings* settings, int frame )
{
    return settings->frames != NULL ? settings->frames[frame] : settings->tracer;
}

static void select_lights( const RfPathSettings* settings, int frame, const RfVertexLanes* restrict v,
                           RfLaneScratch* restrict scratch, RfLightSelection* selection )
{
#pragma omp simd
    for ( int i = 0; i < v->count; ++i )
    {
        RfVec3 from = start_of( v, i );
        RF_PUT3( scratch->o, i, from );
    }
    const float* x[3] = { scratch->o[0], scratch->o[1], scratch->o[2] };
    const float* n[3] = { v->n[0], v->n[1], v->n[2] };
    const uint32_t* bits[2] = { scratch->bits[0], scratch->bits[1] };
    const RfLights* lights = rf_tracer_lights( tracer_of( settings, frame ) );
    rf_select_lights( lights, settings->light_sampling, v->count, x, n, bits, selection );
    if ( settings->frames == NULL || frame == settings->frame )
        return;
    for ( int i = 0; i < v->count; ++i ) // all other light has been sampled in the paths' own frame
    {
        bool taken = selection[i].light != RF_NO_LIGHT && rf_is_own_part( rf_light_part( lights, selection[i].light ) );
        selection[i].light = taken ? selection[i].light : RF_NO_LIGHT;
    }
}

// Uniform by area: u ↦ (1 − √u₁, u₂ √u₁) in barycentrics. Punctual lights and the
// environment are only listed; their point is a dummy that emits nothing.
static void sample_points( const RfLights* lights, int count, const RfLaneScratch* scratch, LightPoints* out )
{
    static const RfLight s_none = { .pdf_area = 1.0f };
    out->non_area_count = 0;
    for ( int i = 0; i < count; ++i )
    {
        uint32_t number = out->selection[i].light;
        bool non_area = number >= lights->triangle_count;
        const RfLight* light = non_area ? &s_none : lights->light + number;
        out->non_area[out->non_area_count] = i;
        out->non_area_count += non_area & ( number != RF_NO_LIGHT );
        float root = sqrtf( scratch->random[0][i] );
        float b1 = 1.0f - root, b2 = scratch->random[1][i] * root;
        RfVec3 p = rf_add( light->p0, rf_add( rf_scale( light->e1, b1 ), rf_scale( light->e2, b2 ) ) );
        RF_PUT3( out->p, i, p );
        RF_PUT3( out->n, i, light->normal );
        RF_PUT3( out->radiance, i, light->radiance );
        out->pdf_area[i] = light->pdf_area * out->selection[i].probability;
        out->offset[i] = light->offset;
        out->two_sided[i] = light->two_sided ? 1.0f : 0.0f;
    }
}

// Radiance at the sampled points of textured lights.
static void look_up_radiance( const RfScene* scene, const RfLights* lights, int count, const RfLaneScratch* scratch,
                              LightPoints* out )
{
    for ( int i = 0; i < count; ++i )
    {
        uint32_t number = out->selection[i].light;
        if ( number >= lights->triangle_count || !lights->light[number].textured )
            continue;
        float root = sqrtf( scratch->random[0][i] );
        RfVec3 radiance = rf_light_radiance( scene, lights->light + number, 1.0f - root, scratch->random[1][i] * root );
        RF_PUT3( out->radiance, i, radiance );
    }
}

// Directions, densities and shadow segments; radiance_cos is 0 where the light is
// below the horizon or faces away.
static void connect( const RfVertexLanes* restrict v, const LightPoints* restrict points, RfLightLanes* restrict out,
                     RfLaneScratch* restrict scratch )
{
    int count = v->count;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 ng = RF_GET3( v->ng, i );
        RfVec3 n = RF_GET3( v->n, i );
        RfVec3 z = RF_GET3( points->p, i );
        RfVec3 nz = RF_GET3( points->n, i );
        RfVec3 from = start_of( v, i );
        RfVec3 to_light = rf_sub( z, from );
        float d2 = rf_dot( to_light, to_light );
        RfVec3 wi = rf_scale( to_light, 1.0f / sqrtf( rf_maxf( d2, FLT_MIN ) ) );
        float facing = -rf_dot( nz, wi );
        float side = facing < 0.0f ? -1.0f : 1.0f;
        float cos_light = points->two_sided[i] > 0.0f ? fabsf( facing ) : facing;
        float cos_x = rf_dot( n, wi );
        float pdf = points->pdf_area[i] * d2 / ( cos_light > 0.0f ? cos_light : 1.0f );
        int arrives = ( cos_x > 0.0f ) & ( rf_dot( ng, wi ) > 0.0f || RF_FAULT( below_triangle ) ) & ( cos_light > 0.0f ) &
                      ( pdf < 1e30f ) & ( d2 > 0.0f );
        float scale = arrives ? cos_x : 0.0f;
        // the BSDFs need a valid direction in every lane
        out->wi[0][i] = arrives ? wi.x : n.x;
        out->wi[1][i] = arrives ? wi.y : n.y;
        out->wi[2][i] = arrives ? wi.z : n.z;
        out->pdf_solid_angle[i] = arrives ? pdf : 1.0f;
        out->radiance_cos[0][i] = points->radiance[0][i] * scale;
        out->radiance_cos[1][i] = points->radiance[1][i] * scale;
        out->radiance_cos[2][i] = points->radiance[2][i] * scale;
        // the far end is lifted off the light, on the side facing the vertex, by what covers the rounding of both ends
        float rounding = RF_FAULT( light_rounding ) ? 0.0f : rf_ray_offset( rf_largest_coordinate( from ) );
        float lift = rf_maxf( points->offset[i], rounding );
        RfVec3 to = rf_madd( z, nz, RF_FAULT( light_offset ) ? 0.0f : lift * side );
        RF_PUT3( scratch->o, i, from );
        scratch->d[0][i] = to.x - from.x;
        scratch->d[1][i] = to.y - from.y;
        scratch->d[2][i] = to.z - from.z;
    }
}

// Whether connections bring what a plate throws of a punctual light to the path's previous vertex (src/light_paths).
static bool leaves_to_connections( const RfPathSettings* settings, const RfWavefront* keys, const RfVertexLanes* v, int i,
                                   float cos_x )
{
    if ( settings->connector == NULL || keys->deltas[v->slot[i]] != 1 ||
         !rf_is_plate( rf_tracer_scene( settings->tracer )->materials + v->material[i] ) )
        return false;
    float cos_o = v->n[0][i] * v->wo[0][i] + v->n[1][i] * v->wo[1][i] + v->n[2][i] * v->wo[2][i];
    return cos_x > RF_MIN_COS && cos_o > RF_MIN_COS;
}

// Lamps that no ray can hit do not shine through glass, rough or smooth: chains, which only follow rays, find none of their light.
static bool is_through_glass( const RfVertexLanes* v, int i )
{
    return i >= v->first[RF_BSDF_FROSTED] && i < v->first[RF_BSDF_FROSTED + 1] && v->param[RF_PARAM_CHOICE][i] < 0.0f;
}

// What connect() leaves of lane i where its light is punctual or the environment.
static void put_sample( const RfPathSettings* settings, const RfWavefront* keys, const RfVertexLanes* v, int i,
                        const NonAreaSample* s, LightPoints* points, RfLightLanes* out, RfLaneScratch* scratch )
{
    float cos_x = rf_dot( RF_GET3( v->n, i ), s->wi );
    bool is_finite = rf_max_component( s->radiance ) <= MAX_PUNCTUAL_RADIANCE || RF_FAULT( lamp_infinite );
    if ( !( cos_x > 0.0f && rf_dot( RF_GET3( v->ng, i ), s->wi ) > 0.0f && s->pdf_solid_angle > 0.0f && is_finite ) ||
         ( !s->sky && ( is_through_glass( v, i ) || leaves_to_connections( settings, keys, v, i, cos_x ) ) ) )
        return;
    float wi[3] = { s->wi.x, s->wi.y, s->wi.z }, radiance[3] = { s->radiance.x, s->radiance.y, s->radiance.z };
    for ( int c = 0; c < 3; ++c )
    {
        out->wi[c][i] = wi[c];
        out->radiance_cos[c][i] = radiance[c] * cos_x;
        scratch->d[c][i] = wi[c] * s->distance;
    }
    out->pdf_solid_angle[i] = s->pdf_solid_angle;
    points->sky[i] = s->sky;
}

// Numbers of samples of the sky, in the order of `lane`: those of the selection select the pixel, as far as they are of the sky.
static void draw_sky_numbers( const RfWavefront* keys, const RfVertexLanes* v, int count, const int32_t* lane, uint32_t dimension,
                              const RfLaneScratch* scratch, SkySamples* sky )
{
    uint32_t own = dimension & ~RF_DIMENSION_OPPOSITE, half = own == dimension ? 0 : 0x80000000u;
#pragma omp simd
    for ( int k = 0; k < count; ++k )
    {
        int i = lane[k];
        RfRandomKey key = { keys->key_a[v->slot[i]], keys->key_b[v->slot[i]] };
        sky->bits[0][k] = (uint32_t)(int32_t)( scratch->random[0][i] * 0x1p24f ) << 8 |
                          rf_random_bits( key, ( own + 1 ) | RF_DIMENSION_TWIN ) >> 24;
        sky->bits[1][k] = rf_random_bits( key, ( own + 2 ) | RF_DIMENSION_TWIN ) ^ half;
        sky->u[0][k] = rf_random( key, ( own + 1 ) | RF_DIMENSION_WITHIN );
        sky->u[1][k] = rf_random( key, ( own + 2 ) | RF_DIMENSION_WITHIN );
        RfVec3 n = RF_GET3( v->n, i );
        RF_PUT3( sky->n, k, n );
    }
}

static void sample_sky( const RfPathSettings* settings, const RfWavefront* keys, const RfVertexLanes* v, LightPoints* points,
                        int count, const int32_t* lane, RfLightSample sample, RfLightLanes* out, RfLaneScratch* scratch )
{
    const RfLights* lights = rf_tracer_lights( tracer_of( settings, sample.frame ) );
    SkySamples sky;
    draw_sky_numbers( keys, v, count, lane, sample.dimension, scratch, &sky );
    for ( int k = 0; k < count && lights->sky.environment->map == NULL; ++k )
    {
        sky.u[0][k] = scratch->random[0][lane[k]];
        sky.u[1][k] = scratch->random[1][lane[k]];
    }
    const RfSkyLanes lanes = { { sky.n[0], sky.n[1], sky.n[2] },
                               { sky.bits[0], sky.bits[1] },
                               { sky.u[0], sky.u[1] },
                               { sky.wi[0], sky.wi[1], sky.wi[2] },
                               sky.pdf_solid_angle };
    rf_sample_sky_directions( &lights->sky, count, &lanes );
    for ( int k = 0; k < count; ++k )
    {
        int i = lane[k];
        const NonAreaSample s = {
            .wi = RF_GET3( sky.wi, k ),
            .radiance = rf_vec3( 1.0f, 1.0f, 1.0f ),
            .pdf_solid_angle = sky.pdf_solid_angle[k] * points->selection[i].probability,
            .distance = 2.0f * ( rf_length( rf_sub( RF_GET3( scratch->o, i ), lights->center ) ) + lights->reach ),
            .sky = true,
        };
        put_sample( settings, keys, v, i, &s, points, out, scratch );
    }
}

// connect() for punctual lights and the environment, whose radiance is still 1.
static void connect_non_area( const RfPathSettings* settings, const RfWavefront* keys, const RfVertexLanes* v,
                              LightPoints* points, RfLightSample sample, RfLightLanes* out, RfLaneScratch* scratch )
{
    const RfLights* lights = rf_tracer_lights( tracer_of( settings, sample.frame ) );
    int32_t lane[RF_LANES];
    int sky_count = 0;
    memset( points->sky, 0, sizeof points->sky );
    for ( int k = 0; k < points->non_area_count; ++k )
    {
        int i = points->non_area[k];
        lane[sky_count] = i;
        if ( rf_light_kind( lights, points->selection[i].light ) == RF_LIGHT_SKY )
        {
            ++sky_count;
            continue;
        }
        float u[2] = { scratch->random[0][i], scratch->random[1][i] };
        NonAreaSample s = sample_punctual( lights, points->selection[i], u, RF_GET3( scratch->o, i ) );
        put_sample( settings, keys, v, i, &s, points, out, scratch );
    }
    for ( int first = 0; first < sky_count; first += RF_SKY_LANES )
    {
        int some = sky_count - first < RF_SKY_LANES ? sky_count - first : RF_SKY_LANES;
        sample_sky( settings, keys, v, points, some, lane + first, sample, out, scratch );
    }
}

// Moves the segments of lanes that may be lit to the front; returns how many there are.
static int compact_segments( const RfLightLanes* lights, int count, RfLaneScratch* scratch )
{
    int kept = 0;
    for ( int i = 0; i < count; ++i )
    {
        float sum = lights->radiance_cos[0][i] + lights->radiance_cos[1][i] + lights->radiance_cos[2][i];
        for ( int c = 0; c < 3; ++c )
        {
            scratch->o[c][kept] = scratch->o[c][i];
            scratch->d[c][kept] = scratch->d[c][i];
        }
        scratch->index[kept] = i;
        kept += sum > 0.0f;
    }
    return kept;
}

// The radiance of the sky where it is visible.
static void look_up_sky( const RfLights* lights, const LightPoints* points, int kept, RfLightLanes* out,
                         const RfLaneScratch* scratch )
{
    for ( int k = 0; k < kept; ++k )
    {
        int i = scratch->index[k];
        if ( !points->sky[i] || scratch->visible[k] == 0.0f )
            continue;
        RfVec3 l = rf_sky_radiance( &lights->sky, RF_GET3( out->wi, i ) );
        float radiance[3] = { l.x, l.y, l.z };
        bool bounded = rf_max_component( l ) <= MAX_PUNCTUAL_RADIANCE;
        for ( int c = 0; c < 3; ++c )
            out->radiance_cos[c][i] = bounded ? radiance[c] * out->radiance_cos[c][i] : 0.0f;
    }
}

// Light behind panes: times κ, and the density over q (src/reuse/estimators.md, section 11).
static void dim_behind_panes( int kept, const RfPaneLanes* panes, RfLightLanes* out, const RfLaneScratch* scratch )
{
    for ( int k = 0; k < kept; ++k )
    {
        int i = scratch->index[k];
        if ( scratch->visible[k] == 0.0f )
            continue;
        out->pdf_solid_angle[i] /= panes->probability[k];
        for ( int c = 0; c < 3; ++c )
            out->radiance_cos[c][i] *= panes->weight[c][k];
    }
}

// Marks the lanes whose path is touched, or whose segment is.
static void touch_lights( const RfPathSettings* settings, const RfTracer* tracer, const RfVertexLanes* v,
                          const LightPoints* points, int kept, RfLightLanes* out, const RfLaneScratch* scratch )
{
    float finite[RF_LANES], endless[RF_LANES]; // visible, unless the path is touched anyway
    uint8_t touched[RF_LANES];
    const float *o[3] = { scratch->o[0], scratch->o[1], scratch->o[2] }, *d[3] = { scratch->d[0], scratch->d[1], scratch->d[2] };
    bool any_sky = false;
    for ( int i = 0; i < v->count; ++i )
        out->touched[i] = settings->own->touched[v->slot[i]];
    for ( int k = 0; k < kept; ++k )
    {
        int i = scratch->index[k];
        bool sky = points->non_area_count > 0 && points->sky[i];
        float open = out->touched[i] ? 0.0f : scratch->visible[k];
        finite[k] = sky ? 0.0f : open;
        endless[k] = sky ? open : 0.0f;
        any_sky = any_sky || sky;
    }
    rf_touch_by_segments( tracer, kept, o, d, 1.0f, finite, touched );
    for ( int k = 0; k < kept; ++k )
        out->touched[scratch->index[k]] |= touched[k];
    if ( any_sky )
        rf_touch_by_segments( tracer, kept, o, d, INFINITY, endless, touched );
    for ( int k = 0; k < kept && any_sky; ++k )
        out->touched[scratch->index[k]] |= touched[k];
}

// Tells the light of groups, of dimmed lamps, and of lamps that change otherwise.
static void sort_by_part( const RfPathSettings* settings, int frame, const LightPoints* points, int kept, RfLightLanes* out,
                          const RfLaneScratch* scratch )
{
    const RfLights* lights = rf_tracer_lights( tracer_of( settings, frame ) );
    for ( int k = 0; k < kept; ++k )
    {
        int i = scratch->index[k], part = rf_light_part( lights, points->selection[i].light );
        if ( settings->parts && settings->frames != NULL && rf_is_own_part( part ) )
            part = rf_frame_part( settings, part, frame );
        bool of_frame = rf_is_own_part( part );
        if ( settings->own != NULL )
            out->touched[i] |= of_frame;
        bool apart = settings->parts && !of_frame && !( settings->own != NULL && out->touched[i] );
        if ( apart )
        {
            out->part[i] = (uint8_t)part;
            continue;
        }
        if ( settings->grouped )
            out->part[i] = (uint8_t)rf_counts_in( settings, part );
        RfVec3 scale = rf_part_scale( lights, part );
        out->radiance_cos[0][i] *= scale.x;
        out->radiance_cos[1][i] *= scale.y;
        out->radiance_cos[2][i] *= scale.z;
    }
}

int rf_sample_lights( const RfPathSettings* settings, const RfWavefront* keys, const RfVertexLanes* vertices,
                      RfLightSample sample, RfLightLanes* out, RfLaneScratch* scratch )
{
    const RfTracer* tracer = tracer_of( settings, sample.frame );
    const RfLights* lights = rf_tracer_lights( tracer );
    int count = vertices->count;
    if ( lights->count == 0 )
    {
        for ( int c = 0; c < 3; ++c )
        {
            for ( int i = 0; i < count; ++i )
                out->radiance_cos[c][i] = out->wi[c][i] = 0.0f;
        }
        for ( int i = 0; i < count; ++i )
            out->pdf_solid_angle[i] = 1.0f;
        memset( out->touched, 0, sizeof out->touched );
        memset( out->part, 0, sizeof out->part );
        return 0;
    }
    LightPoints points;
    rf_draw_light_numbers( keys, count, vertices->slot, sample.dimension, scratch );
    select_lights( settings, sample.frame, vertices, scratch, points.selection );
    sample_points( lights, count, scratch, &points );
    if ( rf_tracer_is_textured( tracer ) )
        look_up_radiance( rf_tracer_scene( tracer ), lights, count, scratch, &points );
    connect( vertices, &points, out, scratch );
    if ( rf_calls_for( points.non_area_count > 0, RF_EFFECT_PUNCTUAL_LIGHTS ) ||
         rf_calls_for( points.non_area_count > 0, RF_EFFECT_ENVIRONMENT ) )
        connect_non_area( settings, keys, vertices, &points, sample, out, scratch );
    int kept = compact_segments( out, count, scratch );
    const float* o[3] = { scratch->o[0], scratch->o[1], scratch->o[2] };
    const float* d[3] = { scratch->d[0], scratch->d[1], scratch->d[2] };
    RfPaneLanes panes = { .probability = scratch->pdf, .weight = { scratch->f[0], scratch->f[1], scratch->f[2] } };
    bool past_panes = rf_tracer_has_panes( tracer );
    if ( settings->occluders != NULL )
        rf_trace_shadow_rays( tracer, settings->occluders, kept, o, d, scratch->visible, past_panes ? &panes : NULL );
    else if ( past_panes )
        rf_trace_segments_past_panes( tracer, kept, o, d, scratch->visible, &panes );
    else
        rf_trace_segments( tracer, kept, o, d, scratch->visible );
    if ( points.non_area_count > 0 && rf_has_sky( lights ) )
        look_up_sky( lights, &points, kept, out, scratch );
    if ( past_panes )
        dim_behind_panes( kept, &panes, out, scratch );
    if ( settings->own != NULL && settings->own->caustics )
        rf_find_lit_caustics( settings->own, vertices, out->touched );
    else if ( settings->own != NULL )
        touch_lights( settings, tracer, vertices, &points, kept, out, scratch );
    if ( settings->parts || settings->grouped )
        memset( out->part, 0, (size_t)count );
    if ( lights->part != NULL )
        sort_by_part( settings, sample.frame, &points, kept, out, scratch );
    for ( int k = 0; k < kept; ++k )
    {
        int i = scratch->index[k];
        float visible = scratch->visible[k];
        for ( int c = 0; c < 3; ++c )
            out->radiance_cos[c][i] *= visible;
    }
    return kept;
}
