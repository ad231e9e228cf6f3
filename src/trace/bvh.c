#include "trace/bvh.h"

#include "base/float_traps.h"
#include "scene/leave_out.h"
#include "scene/textured.h"
#include "trace/far_triangle.h"
#include "trace/filter.h"

#include <stdlib.h>
#include <string.h>

// Embree's geometry ids.
enum
{
    OPAQUE,
    MASKED,
};

static bool is_pane( const RfScene* scene, const RfMaterial* m )
{
    return rf_may_be_pane( m ) && rf_runs( scene, true, RF_EFFECT_PANES );
}

static bool has_filter( const RfBvh* bvh, uint32_t triangle )
{
    const RfMaterial* m = bvh->scene->materials + bvh->scene->triangles.material[triangle];
    return rf_runs( bvh->scene, rf_is_masked( m ), RF_EFFECT_ALPHA_MASK ) || rf_is_blended( m ) || is_pane( bvh->scene, m ) ||
           rf_is_far_triangle( &bvh->scene->triangles, triangle, bvh->far_error );
}

// Masked and blended triangles, panes and far triangles form a geometry of their own, so that the others need no
// filter. Sorts the triangles: unfiltered first.
static RfResult sort_masked( RfBvh* bvh, RfError* error )
{
    const RfScene* scene = bvh->scene;
    const RfTriangles* t = &scene->triangles;
    uint32_t masked = 0;
    bvh->panes = rf_is_forced( scene, RF_EFFECT_PANES );
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        const RfMaterial* m = scene->materials + t->material[i];
        masked += has_filter( bvh, i );
        bvh->any_blended = bvh->any_blended || rf_is_blended( m );
        bvh->panes = bvh->panes || is_pane( scene, m );
        bvh->partial = bvh->partial || rf_is_blended( m ) || is_pane( scene, m );
    }
    bvh->blended = bvh->any_blended || rf_is_forced( scene, RF_EFFECT_ALPHA_BLEND );
    bvh->masked_first = t->count - masked;
    if ( masked == 0 )
        return RF_OK;
    bvh->order = malloc( (size_t)t->count * sizeof *bvh->order );
    if ( bvh->order == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the order of %u triangles", t->count );
    uint32_t next[2] = { 0, bvh->masked_first };
    for ( uint32_t i = 0; i < t->count; ++i )
        bvh->order[next[has_filter( bvh, i )]++] = i;
    return RF_OK;
}

// Shared by both geometries. Embree may read 16 bytes at each vertex of 12, hence the padding.
static RTCBuffer copy_positions( RTCDevice device, const RfTriangles* t, float scale )
{
    size_t bytes = (size_t)t->vertex_count * 12;
    RTCBuffer buffer = rtcNewBuffer( device, bytes + 16 );
    char* memory = buffer != NULL ? rtcGetBufferData( buffer ) : NULL;
    if ( memory == NULL )
        return buffer; // reported by the device's error handler
    float* positions = (float*)(void*)memory;
    for ( size_t i = 0; i < 3 * (size_t)t->vertex_count; ++i )
        positions[i] = scale * t->positions[i];
    memset( memory + bytes, 0, 16 );
    return buffer;
}

static RTCGeometry make_geometry( RTCDevice device, const RfBvh* bvh, RTCBuffer positions, uint32_t first, uint32_t count )
{
    const RfTriangles* t = &bvh->scene->triangles;
    RTCGeometry geometry = rtcNewGeometry( device, RTC_GEOMETRY_TYPE_TRIANGLE );
    rtcSetGeometryBuffer( geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12, t->vertex_count );
    if ( bvh->order == NULL )
    {
        rtcSetSharedGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, t->indices, 0, 12, count );
        return geometry;
    }
    uint32_t* indices = rtcSetNewGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count );
    for ( uint32_t i = 0; indices != NULL && i < count; ++i )
        memcpy( indices + 3 * (size_t)i, t->indices + 3 * (size_t)bvh->order[first + i], 12 );
    return geometry;
}

static void attach( RTCDevice device, RfBvh* bvh, RTCBuffer positions, uint32_t first, uint32_t count, unsigned int id )
{
    if ( count == 0 )
        return;
    RTCGeometry geometry = make_geometry( device, bvh, positions, first, count );
    if ( id == MASKED )
    {
        rtcSetGeometryUserData( geometry, bvh );
        rtcSetGeometryIntersectFilterFunction( geometry, rf_filter_hits );
        rtcSetGeometryOccludedFilterFunction( geometry, rf_filter_hits );
    }
    rtcCommitGeometry( geometry );
    rtcAttachGeometryByID( bvh->embree_scene, geometry, id );
    rtcReleaseGeometry( geometry );
}

static void commit( RTCScene scene )
{
    int traps = rf_pause_float_traps(); // see query.c; its threads inherit them
    rtcCommitScene( scene );
    rf_resume_float_traps( traps );
}

// Build quality MEDIUM with ROBUST is deterministic with any number of threads; HIGH is not.
RfResult rf_build_bvh( RTCDevice device, const RfScene* scene, RfBvh* bvh, RfError* error )
{
    float reach = rf_median_reach( &scene->triangles );
    *bvh = ( RfBvh ){ .scene = scene,
                      .scale = rf_embree_scale( reach ),
                      .far_error = rf_far_error( reach ),
                      .halved = rf_halves_packets( device ) };
    RfResult result = sort_masked( bvh, error );
    if ( result != RF_OK )
        return result;
    bvh->embree_scene = rtcNewScene( device );
    rtcSetSceneBuildQuality( bvh->embree_scene, RTC_BUILD_QUALITY_MEDIUM );
    rtcSetSceneFlags( bvh->embree_scene, RTC_SCENE_FLAG_ROBUST );
    RTCBuffer positions = copy_positions( device, &scene->triangles, bvh->scale );
    attach( device, bvh, positions, 0, bvh->masked_first, OPAQUE );
    attach( device, bvh, positions, bvh->masked_first, scene->triangles.count - bvh->masked_first, MASKED );
    if ( positions != NULL )
        rtcReleaseBuffer( positions );
    commit( bvh->embree_scene );
    return RF_OK;
}

RTCScene rf_build_mirror_scene( RTCDevice device, const RfScene* scene, float scale, const RfMirrors* mirrors )
{
    if ( mirrors->triangle_count == 0 )
        return NULL;
    RTCScene out = rtcNewScene( device );
    RTCGeometry geometry = rtcNewGeometry( device, RTC_GEOMETRY_TYPE_TRIANGLE );
    RTCBuffer positions = copy_positions( device, &scene->triangles, scale );
    rtcSetGeometryBuffer( geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12,
                          scene->triangles.vertex_count );
    uint32_t* indices =
        rtcSetNewGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mirrors->triangle_count );
    for ( uint32_t i = 0; indices != NULL && i < mirrors->triangle_count; ++i )
        memcpy( indices + 3 * (size_t)i, scene->triangles.indices + 3 * (size_t)mirrors->triangle[i], 12 );
    rtcSetSceneFlags( out, RTC_SCENE_FLAG_ROBUST );
    rtcCommitGeometry( geometry );
    rtcAttachGeometry( out, geometry );
    rtcReleaseGeometry( geometry );
    if ( positions != NULL )
        rtcReleaseBuffer( positions );
    commit( out );
    return out;
}

void rf_restore_order( const RfBvh* bvh, int count, const unsigned int* geometry, uint32_t* triangle )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( geometry[i] != RTC_INVALID_GEOMETRY_ID )
            triangle[i] = bvh->order[triangle[i] + ( geometry[i] == MASKED ? bvh->masked_first : 0 )];
    }
}

void rf_destroy_bvh( RfBvh* bvh )
{
    if ( bvh->embree_scene != NULL )
        rtcReleaseScene( bvh->embree_scene );
    free( bvh->order );
    *bvh = ( RfBvh ){ 0 };
}
