// Images of the cameras in flat mirrors: projection to them, directions, and visibility by way of the mirror.
#include "reuse/chains/mirrored.h"

#include "reuse/harvest/eye_rays.h"
#include "scene/projection.h"

#include <string.h>

// The image of a camera in the mirror of the last lane.
typedef struct Image
{
    const RfMirrors* mirrors;
    const RfEye* eye;
    int view;
    const RfMirror* mirror;
    RfEye image;
    float side; // distance of the camera, or of where its ray starts, from the mirror's plane, m; negative behind it
} Image;

static void turn_to( Image* i, uint8_t view )
{
    i->view = view;
    i->mirror = i->mirrors->mirror + ( view - RF_VIEW_FIRST_MIRROR );
    i->image = rf_mirrored_eye( i->eye, i->mirror );
    i->side = rf_mirror_distance( i->mirror, i->eye->origin );
}

// At a hit at p.
static inline void look_into( Image* i, uint8_t view, RfVec3 p )
{
    if ( i->view != view )
        turn_to( i, view );
    if ( rf_is_parallel( i->eye ) )
        i->side = -rf_mirror_distance( i->mirror, rf_eye_start( &i->image, p ) );
}

static RfVec3 position( const RfHitBatch* batch, int i ) { return RF_GET3( batch->p, i ); }

static RfVec3 normal( const RfHitBatch* batch, int i ) { return RF_GET3( batch->ng, i ); }

// The probability of the reflection between the image and a hit, and its weight. 0 where the shading model would deflect the
// ray, and from inside a body.
static float reflection( const Image* image, RfVec3 way, RfVec3* weight )
{
    float cos_o = fabsf( rf_dot( way, image->mirror->n ) ) / rf_length( way );
    const RfMaterial* m = &image->mirror->material;
    if ( !( cos_o >= RF_MIN_COS ) || ( image->side < 0.0f && m->ior > 0.0f && !m->thin ) )
        return 0.0f;
    return rf_glass_reflection( m, rf_minf( cos_o, 1.0f ), weight );
}

void rf_project_mirrored( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out )
{
    Image image = { .mirrors = mirrors, .eye = eye };
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !rf_is_mirrored( batch->view[i] ) )
            continue;
        RfVec3 p = position( batch, i ), weight = rf_vec3( 0, 0, 0 );
        look_into( &image, batch->view[i], p );
        RfProjection at = rf_project_any( &image.image, p, normal( batch, i ) );
        bool same_side = image.side * rf_mirror_distance( image.mirror, p ) > 0.0f;
        float probability = at.seen && same_side ? reflection( &image, rf_eye_way( &image.image, p ), &weight ) : 0.0f;
        out.pixel[i] = at.y * eye->width + at.x;
        out.density[i] = at.density * probability;
        if ( out.offset[0] != NULL )
        {
            out.offset[0][i] = at.u;
            out.offset[1][i] = at.v;
        }
        if ( out.filter[0] != NULL )
            RF_PUT3( out.filter, i, weight );
    }
}

void rf_own_mirrored_densities( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out )
{
    Image image = { .mirrors = mirrors, .eye = eye };
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !rf_is_mirrored( batch->view[i] ) )
            continue;
        RfVec3 p = position( batch, i ), weight = rf_vec3( 0, 0, 0 );
        look_into( &image, batch->view[i], p );
        float probability = reflection( &image, rf_eye_way( &image.image, p ), &weight );
        // the mirror did reflect, whatever rounding does to its angle
        out.density[i] = rf_maxf( rf_project_any( &image.image, p, normal( batch, i ) ).density * probability, RF_MIN_DENSITY );
        if ( out.filter[0] != NULL )
            RF_PUT3( out.filter, i, weight );
    }
}

void rf_directions_to_image( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, float* const wo[3] )
{
    Image image = { .mirrors = mirrors, .eye = eye };
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = first; i < batch->count; ++i )
    {
        if ( !rf_is_mirrored( batch->view[i] ) )
            continue;
        RfVec3 p = position( batch, i );
        look_into( &image, batch->view[i], p );
        RF_PUT3( wo, i - first, rf_normalize( rf_scale( rf_eye_way( &image.image, p ), -1.0f ) ) );
    }
}

// Mirrored hits on their way, packed.
typedef struct Packed
{
    int count;
    int32_t lane[RF_LANES];
    uint8_t mirror[RF_LANES];
    RF_ALIGN float on_mirror[3][RF_LANES]; // in its plane, later lifted off it
    float way[3][RF_LANES];                // from there to the hit
    float weight[RF_LANES];
    float visible[RF_LANES];
} Packed;

// Where the straight way from the image to a hit crosses the mirror.
static void pack( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, const float* density, Packed* out )
{
    Image image = { .mirrors = mirrors, .eye = eye };
    out->count = 0;
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !rf_is_mirrored( batch->view[i] ) || !( density[i] > 0.0f ) )
            continue;
        RfVec3 p = position( batch, i );
        look_into( &image, batch->view[i], p );
        RfVec3 o = rf_eye_start( &image.image, p );
        float before = fabsf( image.side ), after = fabsf( rf_mirror_distance( image.mirror, p ) );
        RF_PUT3( out->on_mirror, out->count, rf_madd( o, rf_sub( p, o ), before / ( before + after ) ) );
        out->mirror[out->count] = (uint8_t)( batch->view[i] - RF_VIEW_FIRST_MIRROR );
        out->weight[out->count] = density[i];
        out->lane[out->count++] = i;
    }
}

int rf_see_mirrored( const RfTracer* tracer, const RfEye* eye, const RfHitBatch* batch, const float* const lifted[3],
                     uint32_t* triangle, float* density )
{
    Packed packed;
    pack( rf_tracer_mirrors( tracer ), eye, batch, density, &packed );
    if ( packed.count == 0 )
        return 0;
    float* on_mirror[3] = { packed.on_mirror[0], packed.on_mirror[1], packed.on_mirror[2] };
    const float* from[3] = { on_mirror[0], on_mirror[1], on_mirror[2] };
    uint32_t hit[RF_LANES];
    rf_trace_mirrors_from_eye( tracer, eye, packed.count, from, packed.mirror, on_mirror, hit, packed.weight );
    for ( int k = 0; k < packed.count && triangle != NULL; ++k )
        triangle[packed.lane[k]] = packed.weight[k] > 0.0f ? hit[k] : RF_MISS;
    int rays = packed.count + rf_trace_from_eye( tracer, eye, packed.count, from, packed.weight );
    for ( int k = 0; k < packed.count; ++k )
        density[packed.lane[k]] = 0.0f;
    int kept = 0;
    for ( int k = 0; k < packed.count; ++k )
    {
        if ( packed.weight[k] == 0.0f )
            continue;
        for ( int c = 0; c < 3; ++c )
        {
            packed.on_mirror[c][kept] = packed.on_mirror[c][k];
            packed.way[c][kept] = lifted[c][packed.lane[k]] - packed.on_mirror[c][k];
        }
        packed.weight[kept] = packed.weight[k];
        packed.lane[kept++] = packed.lane[k];
    }
    const float* way[3] = { packed.way[0], packed.way[1], packed.way[2] };
    // panes are vertices to camera rays as well, except the holes of blended ones
    rf_trace_segments( tracer, kept, from, way, packed.visible );
    for ( int k = 0; k < kept; ++k )
        density[packed.lane[k]] = packed.weight[k] * packed.visible[k];
    return rays + kept;
}
