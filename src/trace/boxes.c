#include "trace/boxes.h"

#include "scene/moments.h"

#include <math.h>
#include <string.h>

// Of coordinates: well above the errors of the test, and of Embree.
#define MARGIN 1e-5f

#define LEAST 1e-20f

RfBoxes rf_no_boxes( void )
{
    RfBoxes boxes = { .count = 0 };
    for ( int b = 0; b < RF_MOST_BOXES; ++b )
    {
        for ( int c = 0; c < 3; ++c )
        {
            boxes.low[b][c] = INFINITY;
            boxes.high[b][c] = -INFINITY;
        }
    }
    return boxes;
}

static void add_at( const RfScene* posed, int moment, float scale, RfBoxes* boxes )
{
    int first = posed->still_placement_count, all = posed->placement_count - first;
    int each = ( all + RF_MOST_BOXES - 1 ) / RF_MOST_BOXES;
    for ( int i = 0; i < all; ++i )
    {
        const RfPlacement* p = rf_placements_at( posed, moment ) + first + i;
        const RfMesh* mesh = rf_meshes_at( posed, moment ) + p->mesh;
        const RfVec3 bounds[2] = { mesh->bounds_min, mesh->bounds_max };
        float *low = boxes->low[i / each], *high = boxes->high[i / each];
        for ( int k = 0; k < 8 && p->shown && mesh->triangles.count > 0; ++k )
        {
            RfVec3 at = rf_place_point( &p->matrix, rf_vec3( bounds[k & 1].x, bounds[k >> 1 & 1].y, bounds[k >> 2].z ) );
            const float corner[3] = { scale * at.x, scale * at.y, scale * at.z };
            for ( int c = 0; c < 3; ++c )
            {
                low[c] = fminf( low[c], corner[c] );
                high[c] = fmaxf( high[c], corner[c] );
            }
        }
    }
}

void rf_add_moving_boxes( const RfScene* posed, float scale, RfBoxes* boxes )
{
    for ( int k = 0; k < rf_moment_count( posed ); ++k )
        add_at( posed, k, scale, boxes );
}

void rf_finish_boxes( RfBoxes* boxes )
{
    boxes->count = 0;
    for ( int b = 0; b < RF_MOST_BOXES; ++b )
    {
        float largest = 0.0f, *low = boxes->low[boxes->count], *high = boxes->high[boxes->count];
        for ( int c = 0; c < 3; ++c )
        {
            low[c] = boxes->low[b][c];
            high[c] = boxes->high[b][c];
            largest = fmaxf( largest, fmaxf( fabsf( low[c] ), fabsf( high[c] ) ) );
        }
        if ( low[0] > high[0] )
            continue;
        for ( int c = 0; c < 3; ++c )
        {
            low[c] -= MARGIN * largest;
            high[c] += MARGIN * largest;
        }
        boxes->count += 1;
    }
}

// 1 over a component of a direction. What is next to nothing changes no coordinate on the way to a box.
static inline float inverse( float d ) { return 1.0f / ( fabsf( d ) > LEAST ? d : LEAST ); }

// Where a ray enters the slabs of a box and where it leaves them: Ize, Robust BVH Ray Traversal (JCGT 2013), for the factor.
static inline int meets_box( const float low[3], const float high[3], RfVec3 o, RfVec3 d, float length )
{
    RfVec3 inv = rf_vec3( inverse( d.x ), inverse( d.y ), inverse( d.z ) );
    RfVec3 a = rf_mul( rf_sub( rf_vec3( low[0], low[1], low[2] ), o ), inv );
    RfVec3 b = rf_mul( rf_sub( rf_vec3( high[0], high[1], high[2] ), o ), inv );
    float near = rf_maxf( rf_maxf( rf_minf( a.x, b.x ), rf_minf( a.y, b.y ) ), rf_maxf( rf_minf( a.z, b.z ), 0.0f ) );
    float far = rf_minf( rf_minf( rf_maxf( a.x, b.x ), rf_maxf( a.y, b.y ) ), rf_minf( rf_maxf( a.z, b.z ), length ) );
    return near <= far * ( 1.0f + MARGIN );
}

bool rf_find_near_lanes( const RfBoxes* boxes, const float* const o[3], const float* const d[3], const float* far,
                         const int* valid, int* near )
{
    const float *ox = o[0], *oy = o[1], *oz = o[2], *dx = d[0], *dy = d[1], *dz = d[2];
    int met[RF_BOX_LANES] = { 0 }, any = 0;
    for ( int b = 0; b < boxes->count; ++b )
    {
        const float *low = boxes->low[b], *high = boxes->high[b];
#pragma omp simd
        for ( int i = 0; i < RF_BOX_LANES; ++i )
            met[i] |= -meets_box( low, high, rf_vec3( ox[i], oy[i], oz[i] ), rf_vec3( dx[i], dy[i], dz[i] ), far[i] );
    }
    for ( int i = 0; i < RF_BOX_LANES; ++i )
    {
        near[i] = met[i] & valid[i];
        any |= near[i];
    }
    return any != 0;
}

int rf_list_near_rays( const RfBoxes* boxes, int count, const float* const o[3], const float* const d[3], float length,
                       const uint8_t* touched, int32_t near[RF_BOX_BLOCK] )
{
    const float* restrict ox = o[0], * restrict oy = o[1], * restrict oz = o[2];
    const float* restrict dx = d[0], * restrict dy = d[1], * restrict dz = d[2];
    uint8_t met[RF_BOX_BLOCK];
    for ( int i = 0; i < count; ++i )
        met[i] = 0;
    for ( int b = 0; b < boxes->count; ++b )
    {
        const float low[3] = { boxes->low[b][0], boxes->low[b][1], boxes->low[b][2] };
        const float high[3] = { boxes->high[b][0], boxes->high[b][1], boxes->high[b][2] };
#pragma omp simd
        for ( int i = 0; i < count; ++i )
            met[i] |= (uint8_t)meets_box( low, high, rf_vec3( ox[i], oy[i], oz[i] ), rf_vec3( dx[i], dy[i], dz[i] ), length );
    }
    int listed = 0, i = 0;
    for ( ; i < count; i += 8 ) // most blocks of 8 have none
    {
        int end = i + 8 < count ? i + 8 : count;
        uint64_t eight = 1;
        if ( end == i + 8 )
            memcpy( &eight, met + i, sizeof eight );
        for ( int k = i; eight != 0 && k < end; ++k )
        {
            near[listed] = k;
            listed += met[k] & ( touched[k] == 0 );
        }
    }
    return listed;
}
