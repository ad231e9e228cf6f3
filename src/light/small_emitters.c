// Estimates the solid angles of emitters' images in mirrors and glass, at points of a sequence of low discrepancy.
#include "light/small_emitters.h"

#include "light/changing.h"
#include "scene/placement.h"

#define POINTS 64     // of mirrors and glass
#define FEW_POINTS 16 // of an emitter
#define MOST_TRIANGLES 2048
#define MOST_EMITTERS 64 // materials that emit; further ones are not looked at
#define PI 3.14159265358979324

typedef struct Point
{
    RfVec3 p, n;
} Point;

// Points spread evenly over the area of triangles of one kind.
typedef struct Points
{
    double area;
    int count;
    Point point[POINTS];
} Points;

// Which triangles are meant: those of a material, or of all that are, or are not, mirrors and clear glass.
typedef struct Kind
{
    bool of_material, chain;
    uint32_t material;
} Kind;

static bool is_of_kind( const RfScene* scene, uint32_t triangle, Kind kind )
{
    uint32_t material =
        triangle < scene->triangles.count ? scene->triangles.material[triangle] : rf_material_of( scene, triangle );
    return kind.of_material ? material == kind.material : rf_is_chain_surface( scene->materials + material ) == kind.chain;
}

// A triangle's area; `out`: its next point of a sequence of low discrepancy (Roberts, R2).
static double area_of( const RfScene* scene, uint32_t triangle, int number, Point* out )
{
    RfVec3 p[3];
    bool world = triangle < scene->triangles.count;
    for ( int k = 0; k < 3; ++k )
        p[k] = world ? rf_corner( &scene->triangles, triangle, k ) : rf_placed_corner( scene, triangle, k );
    RfVec3 p0 = p[0], e1 = rf_sub( p[1], p0 ), e2 = rf_sub( p[2], p0 );
    double twice, a = ( number + 1 ) * 0.75487766624669276, b = ( number + 1 ) * 0.56984029099805327;
    out->n = rf_unit_cross( e1, e2, &twice );
    float root = sqrtf( (float)( a - floor( a ) ) ), v = (float)( b - floor( b ) ) * root;
    out->p = rf_add( p0, rf_add( rf_scale( e1, 1.0f - root ), rf_scale( e2, v ) ) );
    return 0.5 * twice;
}

// Of many triangles one in so many is looked at. Of emitters all are: their area counts.
static uint32_t stride_of( const RfScene* scene, Kind kind )
{
    return kind.of_material ? 1 : 1 + rf_triangle_count( scene ) / MOST_TRIANGLES;
}

static uint32_t end_of( const RfScene* scene, Kind kind )
{
    return kind.of_material && rf_count_moving_emitters( scene ) == 0 ? scene->triangles.count : rf_triangle_count( scene );
}

static uint64_t after( const RfScene* scene, Kind kind, uint64_t triangle, uint32_t stride )
{
    bool skips =
        kind.of_material && triangle + 1 == scene->triangles.count && scene->still_placement_count < scene->placement_count;
    return skips ? scene->placements[scene->still_placement_count].first : triangle + stride;
}

static void spread_points( const RfScene* scene, Kind kind, int most, Points* points )
{
    Point unused;
    uint32_t stride = stride_of( scene, kind ), end = end_of( scene, kind );
    points->area = 0.0;
    points->count = 0;
    for ( uint64_t i = 0; i < end; i = after( scene, kind, i, stride ) )
        points->area += is_of_kind( scene, (uint32_t)i, kind ) ? area_of( scene, (uint32_t)i, 0, &unused ) : 0.0;
    double run = 0.0;
    for ( uint64_t k = 0; k < end && points->count < POINTS; k = after( scene, kind, k, stride ) )
    {
        uint32_t i = (uint32_t)k;
        if ( !is_of_kind( scene, i, kind ) )
            continue;
        run += area_of( scene, i, 0, &unused );
        while ( points->count < most && run > ( points->count + 0.5 ) / most * points->area )
        {
            area_of( scene, i, points->count, points->point + points->count );
            points->count += 1;
        }
    }
}

// Of the way from a to b.
typedef struct Way
{
    double distance, cos_a, cos_b;
} Way;

static Way way_of( const Point* a, const Point* b )
{
    RfVec3 way = rf_sub( b->p, a->p );
    double distance = fmax( (double)rf_length( way ), 1e-12 );
    return ( Way ){ distance, (double)rf_dot( a->n, way ) / distance, -(double)rf_dot( b->n, way ) / distance };
}

// The mean over the ways of light from the emitter by a point of a chain to a receiver, weighted by the light.
static double mean_image( const Points* emitter, bool two_sided, const Points* chain, const Points* receivers )
{
    double sum = 0.0, weights = 0.0;
    for ( int c = 0; c < chain->count; ++c )
    {
        Way in[POINTS];
        double light = 0.0;
        for ( int k = 0; k < emitter->count; ++k )
        {
            in[k] = way_of( emitter->point + k, chain->point + c );
            in[k].cos_a = two_sided ? fabs( in[k].cos_a ) : fmax( in[k].cos_a, 0.0 );
            light += in[k].cos_a * fabs( in[k].cos_b ) / ( in[k].distance * in[k].distance );
        }
        for ( int y = 0; y < receivers->count && light > 0.0; ++y )
        {
            Way out = way_of( chain->point + c, receivers->point + y );
            double weight = light * fabs( out.cos_b ) / ( out.distance * out.distance ), image = 0.0;
            for ( int k = 0; k < emitter->count; ++k )
            {
                double distance = in[k].distance + out.distance;
                image += in[k].cos_a / ( distance * distance );
            }
            sum += weight * fmin( image * emitter->area / emitter->count, 2.0 * PI );
            weights += weight;
        }
    }
    return weights > 0.0 ? sum / weights : 0.0;
}

// The solid angle that a material's emission covers in mirrors and glass, as seen from what these light, sr: an estimate that
// takes them for flat and knows no shadows. 0: it does not shine on them, or has no triangles.
static double image_of( const RfScene* scene, uint32_t material, const Points* chain, const Points* receivers )
{
    Points emitter;
    spread_points( scene, ( Kind ){ .of_material = true, .material = material }, FEW_POINTS, &emitter );
    return mean_image( &emitter, scene->materials[material].double_sided, chain, receivers );
}

// The solid angle of the sky, where a bright part of it counts as the whole; 0: it is black.
static double sky_solid_angle( const RfEnvironment* e )
{
    if ( !( rf_max_component( e->radiance ) > 0.0f ) )
        return 0.0;
    if ( e->map == NULL )
        return 4.0 * PI;
    double sum = 0.0, squares = 0.0;
    for ( int y = 0; y < e->height; ++y )
    {
        double pixel = ( cos( y * PI / e->height ) - cos( ( y + 1 ) * PI / e->height ) ) * 2.0 * PI / e->width;
        for ( int x = 0; x < e->width; ++x )
        {
            const float* rgb = e->map + 3 * ( (size_t)y * (size_t)e->width + (size_t)x );
            double light = (double)rf_luminance( rf_mul( e->radiance, rf_vec3( rgb[0], rgb[1], rgb[2] ) ) );
            sum += light * pixel;
            squares += light * light * pixel;
        }
    }
    return squares > 0.0 ? sum * sum / squares : 0.0;
}

uint32_t rf_count_small_emitters( const RfScene* scene )
{
    Points chain, receivers;
    spread_points( scene, ( Kind ){ .chain = true }, POINTS, &chain );
    spread_points( scene, ( Kind ){ .chain = false }, POINTS, &receivers );
    uint32_t count = (uint32_t)scene->punctual_count, looked_at = 0;
    for ( uint32_t m = 0; m < scene->material_count && looked_at < MOST_EMITTERS; ++m )
    {
        if ( !( rf_max_component( scene->materials[m].emission ) > 0.0f ) )
            continue;
        double image = image_of( scene, m, &chain, &receivers );
        count += image > 0.0 && image <= RF_LARGE_EMITTER;
        ++looked_at;
    }
    double sky = sky_solid_angle( &scene->environment );
    return count + ( sky > 0.0 && sky <= RF_LARGE_EMITTER );
}
