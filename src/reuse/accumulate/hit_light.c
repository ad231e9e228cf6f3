// Adds up layers by film.
#include "reuse/accumulate/hit_light.h"

#include <string.h>

// Sums are numbered by light group and kind of hits; removed light is the last.
static int count_sums( const RfBatchShape* shape )
{
    return shape->layers.base_parts * rf_hit_kinds( &shape->layers ) + shape->layers.removed;
}

RfHitLights* rf_place_hit_lights( const RfBatchShape* shape, RfLayout* layout )
{
    RfHitLights* lights = rf_take( layout, 1, sizeof *lights );
    int sums = count_sums( shape ), pictures = sums - shape->layers.removed;
    bool composed = shape->layers.parts > shape->layers.base_parts;
    if ( lights != NULL )
    {
        lights->shape = shape;
        lights->sum_count = sums;
    }
    RF_PLACE( layout, lights->layers, rf_layer_count( &shape->layers ) );
    RF_PLACE( layout, lights->sums, sums );
    RF_PLACE( layout, lights->radiance, composed || shape->layers.removed ? 4 * RF_LANES * sums : 0 );
    RF_PLACE( layout, lights->glossy, shape->params != 0 ? sums : 0 );
    RF_PLACE( layout, lights->film_radiance, pictures > 1 ? 2 * 4 * RF_LANES : 0 );
    RF_PLACE( layout, lights->film_glossy, pictures > 1 && shape->params != 0 ? 2 : 0 );
    return lights;
}

static void add_layer( const RfLayerLight* light, RfVec3 scale, int sum, RfHitLights* out )
{
    out->layers[out->layer_count++] = ( RfLitLayer ){
        .light = light,
        .scale = { scale.x, scale.y, scale.z },
        .scaled = scale.x != 1.0f || scale.y != 1.0f || scale.z != 1.0f,
        .sum = sum,
    };
}

// The layers that have light of hits in the frame.
static void list_layers( const RfLights* lights, int eye, const RfHitBatch* batch, RfHitLights* out )
{
    const RfBatchShape* shape = out->shape;
    int kinds = rf_hit_kinds( &shape->layers );
    bool removed = shape->layers.removed && rf_film_is_lit( shape, batch, ( RfFilmLayers ){ .removed = true }, eye );
    out->layer_count = 0;
    for ( int part = 0; part < batch->part_count; ++part )
    {
        RfVec3 scale = RF_FAULT( part_scales ) ? rf_vec3( 1, 1, 1 ) : rf_part_scale( lights, part );
        int base = shape->layers.base_parts > 1 ? rf_base_part( lights, part ) : 0;
        if ( !( rf_max_component( scale ) > 0.0f ) )
            continue;
        for ( int kind = 0; kind < kinds; ++kind )
            add_layer( rf_layer_light( batch, part, (RfLayerKind)kind ), scale, base * kinds + kind, out );
        if ( removed && !rf_removed_light( batch, part )->dark )
            add_layer( rf_removed_light( batch, part ), scale, out->sum_count - 1, out );
    }
}

static void add_scaled( const RfLitLayer* layer, int count, float* restrict sum )
{
    const float scale[4] = { layer->scale[0], layer->scale[1], layer->scale[2], 0.0f };
    for ( int i = 0; i < 4 * count; ++i )
        sum[i] += scale[i % 4] * layer->light->radiance[i];
}

// What does not depend on the camera: a sum of one layer at scale 1 is that.
static void sum_radiance( const RfHitBatch* batch, RfHitLights* out )
{
    static const float s_none[4 * RF_LANES];
    for ( int sum = 0; sum < out->sum_count; ++sum )
        out->sums[sum] = ( RfHitLight ){ s_none, out->glossy != NULL ? out->glossy + sum : NULL };
    for ( int k = 0; k < out->layer_count; ++k )
    {
        const RfLitLayer* layer = out->layers + k;
        RfHitLight* sum = out->sums + layer->sum;
        float* own = out->radiance != NULL ? out->radiance + (size_t)layer->sum * 4 * RF_LANES : NULL;
        if ( sum->radiance == s_none && !layer->scaled )
        {
            sum->radiance = layer->light->radiance;
            continue;
        }
        if ( sum->radiance != own )
            memcpy( own, sum->radiance, 4 * (size_t)batch->count * sizeof( float ) );
        sum->radiance = own;
        add_scaled( layer, batch->count, own );
    }
}

// Q of a direction in a sum, by channel; false where none comes by it.
static bool find_q( RfHitLights* lights, int sum, int direction, int count, const float* q[3] )
{
    bool any = false, own = false;
    for ( int k = 0; k < lights->layer_count; ++k )
    {
        const RfLitLayer* layer = lights->layers + k;
        if ( layer->sum != sum || !rf_has_direction( layer->light, direction ) || rf_weighted( layer->light, direction )->dark )
            continue;
        const RfWeightedLanes* more = rf_weighted( layer->light, direction );
        for ( int c = 0; c < 3; ++c )
        {
            float* restrict to = lights->q[c];
            const float* restrict from = more->q[c];
            if ( !any && !layer->scaled )
            {
                q[c] = from;
                continue;
            }
            if ( !any )
                memset( to, 0, (size_t)count * sizeof *to );
            else if ( !own )
                memcpy( to, q[c], (size_t)count * sizeof *to );
            for ( int i = 0; i < count; ++i )
                to[i] += layer->scale[c] * from[i];
            q[c] = to;
        }
        own = any || layer->scaled;
        any = true;
    }
    return any;
}

static void add_direction( const float* const f[3], const float* const q[3], int count, RfGlossyLight* out )
{
    for ( int c = 0; c < 3; ++c )
    {
        float* restrict sum = out->rgb[c];
        const float* restrict of_lobes = f[c], * restrict from = q[c];
#pragma omp simd
        for ( int i = 0; i < count; ++i )
            sum[i] += of_lobes[i] * from[i];
    }
}

// Radiance of the glossy hits towards the camera: emission, and Σ f Q over the directions.
static void sum_glossy( const RfMirrors* mirrors, const RfEye* at, int eye, const RfHitBatch* batch, RfHitLights* out )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    float *wo[3] = { out->wo[0], out->wo[1], out->wo[2] }, *f[3] = { out->f[0], out->f[1], out->f[2] };
    const float *wo_in[3] = { wo[0], wo[1], wo[2] }, *f_in[3] = { f[0], f[1], f[2] };
    for ( int k = 0; k < 3 * out->sum_count; ++k )
    {
        for ( int i = 0; i < count; ++i )
            out->glossy[k / 3].rgb[k % 3][i] = out->sums[k / 3].radiance[4 * ( first + i ) + k % 3];
    }
    rf_directions_to( mirrors, at, eye, batch, wo );
    for ( int d = 0; d < rf_direction_count( out->shape ); ++d )
    {
        const float *wi[3] = { batch->directions[d].wi[0], batch->directions[d].wi[1], batch->directions[d].wi[2] }, *q[3];
        bool evaluated = false;
        for ( int sum = 0; sum < out->sum_count; ++sum )
        {
            if ( !find_q( out, sum, d, count, q ) )
                continue;
            if ( !evaluated )
                rf_evaluate_glossy( batch, wo_in, wi, f, NULL );
            evaluated = true;
            add_direction( f_in, q, count, out->glossy + sum );
        }
    }
}

void rf_light_hits( const RfLights* lights, const RfMirrors* mirrors, const RfEye* at, int eye, const RfHitBatch* batch,
                    RfHitLights* out )
{
    list_layers( lights, eye, batch, out );
    sum_radiance( batch, out );
    if ( rf_glossy_count( batch ) > 0 )
        sum_glossy( mirrors, at, eye, batch, out );
}

bool rf_film_is_lit( const RfBatchShape* shape, const RfHitBatch* batch, RfFilmLayers film, int eye )
{
    bool lit = !film.removed;
    for ( int part = 0; part < batch->part_count && film.removed && ( shape->clamped || eye == batch->eye ); ++part )
        lit = lit || !rf_removed_light( batch, part )->dark;
    return lit;
}

// Adds the light of hits to that of a film; of those with this event alone, but for RF_ALL.
static void add_light( const RfHitBatch* batch, RfHitLight light, int event, float* radiance, RfGlossyLight* glossy )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = 0; i < first; ++i )
    {
        for ( int c = 0; c < 3 && ( event == RF_ALL || batch->event[i] == event ); ++c )
            radiance[4 * i + c] += light.radiance[4 * i + c];
    }
    for ( int k = 3 * first; k < 3 * batch->count; ++k )
    {
        int c = k % 3, i = k / 3;
        if ( event == RF_ALL || batch->event[i] == event )
            glossy->rgb[c][i - first] += light.glossy->rgb[c][i - first];
    }
}

// Hits at the end of a chain are all of what it reflects or transmits.
static int event_of( RfFilmLayers film )
{
    return film.kind == RF_ALL                 ? RF_ALL
           : film.kind == RF_KIND_REFLECTION   ? RF_EVENT_REFLECTION
           : film.kind == RF_KIND_TRANSMISSION ? RF_EVENT_TRANSMISSION
                                               : RF_EVENT_NONE;
}

RfHitLight rf_film_light( const RfHitBatch* batch, RfFilmLayers film, RfHitLights* lights )
{
    const RfBatchShape* shape = lights->shape;
    int bases = shape->layers.base_parts, kinds = rf_hit_kinds( &shape->layers ), event = event_of( film ),
        glossy = rf_glossy_count( batch );
    bool picture = film.base == RF_ALL && film.kind == RF_ALL;
    if ( film.removed )
        return lights->sums[lights->sum_count - 1];
    if ( lights->film_radiance == NULL )
        return lights->sums[0];
    if ( kinds == 1 && film.base != RF_ALL )
        return lights->sums[film.base];
    float* radiance = lights->film_radiance + ( picture ? 0 : 4 * RF_LANES );
    RfGlossyLight* of_glossy = lights->film_glossy != NULL ? lights->film_glossy + !picture : NULL;
    memset( radiance, 0, 4 * (size_t)batch->count * sizeof *radiance );
    for ( int c = 0; c < 3 && glossy > 0; ++c )
        memset( of_glossy->rgb[c], 0, (size_t)glossy * sizeof( float ) );
    if ( event == RF_EVENT_REFLECTION || event == RF_EVENT_TRANSMISSION )
    {
        add_light( batch, ( RfHitLight ){ lights->film_radiance, lights->film_glossy }, event, radiance, of_glossy );
        return ( RfHitLight ){ radiance, of_glossy };
    }
    for ( int sum = 0; sum < bases * kinds; ++sum )
    {
        if ( rf_is_in_film( film, sum / kinds, (RfLayerKind)( sum % kinds ) ) )
            add_light( batch, lights->sums[sum], event, radiance, of_glossy );
    }
    return ( RfHitLight ){ radiance, of_glossy };
}
