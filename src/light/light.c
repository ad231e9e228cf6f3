#include "light/light.h"

#include <stdlib.h>
#include <string.h>

static RfVec3 vertex( const RfTriangles* t, uint32_t triangle, int corner )
{
    const float* p = t->positions + 3 * (size_t)t->indices[3 * (size_t)triangle + (size_t)corner];
    return rf_vec3( p[0], p[1], p[2] );
}

static RfLight make_light( const RfScene* scene, uint32_t triangle )
{
    const RfTriangles* t = &scene->triangles;
    const RfMaterial* material = scene->materials + t->material[triangle];
    RfLight light = { .radiance = material->emission, .triangle = triangle, .two_sided = material->double_sided };
    light.p0 = vertex( t, triangle, 0 );
    light.e1 = rf_sub( vertex( t, triangle, 1 ), light.p0 );
    light.e2 = rf_sub( vertex( t, triangle, 2 ), light.p0 );
    RfVec3 cross = rf_cross( light.e1, light.e2 );
    light.area = 0.5f * rf_length( cross );
    light.offset = rf_ray_offset( rf_maxf( rf_largest_coordinate( light.p0 ), rf_maxf( rf_largest_coordinate( vertex( t, triangle, 1 ) ),
                                                                                      rf_largest_coordinate( vertex( t, triangle, 2 ) ) ) ) );
    light.normal = rf_normalize( cross );
    return light;
}

static double power( const RfLight* light )
{
    return (double)rf_luminance( light->radiance ) * (double)light->area * ( light->two_sided ? 2.0 : 1.0 );
}

static bool emits( const RfScene* scene, uint32_t triangle )
{
    return rf_max_component( scene->materials[scene->triangles.material[triangle]].emission ) > 0.0f;
}

// Vose's alias table over `count` weights that sum to `total`.
static RfResult build_alias( RfLights* lights, const double* weight, double total, RfError* error )
{
    uint32_t n = lights->count;
    double* scaled = malloc( n * sizeof *scaled );
    uint32_t* work = malloc( n * sizeof *work );
    lights->alias_share = malloc( n * sizeof *lights->alias_share );
    lights->alias = malloc( n * sizeof *lights->alias );
    if ( scaled == NULL || work == NULL || lights->alias_share == NULL || lights->alias == NULL )
    {
        free( scaled );
        free( work );
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the pick table of %u lights", n );
    }
    // small columns from the left of `work`, large ones from the right
    uint32_t small = 0, large = n;
    for ( uint32_t i = 0; i < n; ++i )
    {
        scaled[i] = weight[i] / total * n;
        lights->alias_share[i] = UINT32_MAX; // its alias is itself
        lights->alias[i] = i;
        if ( scaled[i] < 1.0 )
            work[small++] = i;
        else
            work[--large] = i;
    }
    while ( small > 0 && large < n )
    {
        uint32_t s = work[--small], l = work[large];
        lights->alias_share[s] = (uint32_t)( scaled[s] * 0x1p32 ); // below 1: fits
        lights->alias[s] = l;
        scaled[l] -= 1.0 - scaled[s];
        if ( scaled[l] < 1.0 )
        {
            ++large;
            work[small++] = l;
        }
    }
    free( scaled );
    free( work );
    return RF_OK;
}

static RfResult fill_lights( const RfScene* scene, RfLights* lights, RfError* error )
{
    double* weight = malloc( lights->count * sizeof *weight );
    if ( weight == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for %u lights", lights->count );
    double total = 0.0;
    uint32_t k = 0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        lights->of_triangle[i] = RF_NO_LIGHT;
        if ( !emits( scene, i ) )
            continue;
        RfLight light = make_light( scene, i );
        weight[k] = power( &light );
        if ( !( weight[k] > 0.0 ) )
            continue; // no area: nothing can hit it either
        total += weight[k];
        lights->light[k] = light;
        lights->of_triangle[i] = k++;
    }
    lights->count = k;
    for ( uint32_t i = 0; i < k; ++i )
        lights->light[i].pdf_area = (float)( weight[i] / total / (double)lights->light[i].area );
    RfResult result = k > 0 ? build_alias( lights, weight, total, error ) : RF_OK;
    free( weight );
    return result;
}

RfResult rf_collect_lights( const RfScene* scene, RfLights* lights, RfError* error )
{
    *lights = ( RfLights ){ 0 };
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
        lights->count += emits( scene, i );
    if ( lights->count == 0 )
        return RF_OK;
    lights->light = malloc( lights->count * sizeof *lights->light );
    lights->of_triangle = malloc( scene->triangles.count * sizeof *lights->of_triangle );
    RfResult result = lights->light != NULL && lights->of_triangle != NULL
                          ? fill_lights( scene, lights, error )
                          : rf_fail( error, RF_ERROR_MEMORY, "no memory for %u lights", lights->count );
    if ( result != RF_OK )
        rf_destroy_lights( lights );
    return result;
}

void rf_destroy_lights( RfLights* lights )
{
    free( lights->light );
    free( lights->alias_share );
    free( lights->alias );
    free( lights->of_triangle );
    *lights = ( RfLights ){ 0 };
}
