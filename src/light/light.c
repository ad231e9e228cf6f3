#include "light/light.h"

#include "base/fault.h"
#include "light/tree_create.h"
#include "scene/leave_out.h"

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
    light.textured = material->textured != NULL;
    if ( light.textured )
        light.radiance = rf_mean_emission( scene, material, triangle );
    double twice;
    light.normal = rf_unit_cross( light.e1, light.e2, &twice );
    light.area = (float)( 0.5 * twice );
    light.pdf_area = light.area > 0.0f ? 1.0f / light.area : INFINITY;
    light.offset = rf_ray_offset(
        rf_maxf( rf_largest_coordinate( light.p0 ), rf_maxf( rf_largest_coordinate( vertex( t, triangle, 1 ) ),
                                                             rf_largest_coordinate( vertex( t, triangle, 2 ) ) ) ) );
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

// Vose's alias table of `powers`, which sum to `total`.
static RfResult build_alias( RfLights* lights, const double* powers, double total, RfError* error )
{
    uint32_t n = lights->count;
    double* scaled = malloc( n * sizeof *scaled );
    uint32_t* work = malloc( n * sizeof *work );
    lights->alias_threshold = malloc( n * sizeof *lights->alias_threshold );
    lights->alias = malloc( n * sizeof *lights->alias );
    if ( scaled == NULL || work == NULL || lights->alias_threshold == NULL || lights->alias == NULL )
    {
        free( scaled );
        free( work );
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the alias table of %u lights", n );
    }
    // small columns from the front of `work`, large ones from the back
    uint32_t small = 0, large = n;
    for ( uint32_t i = 0; i < n; ++i )
    {
        scaled[i] = powers[i] / total * n;
        lights->alias_threshold[i] = UINT32_MAX; // its alias is itself
        lights->alias[i] = i;
        if ( scaled[i] < 1.0 )
            work[small++] = i;
        else
            work[--large] = i;
    }
    while ( small > 0 && large < n )
    {
        uint32_t s = work[--small], l = work[large];
        lights->alias_threshold[s] = (uint32_t)( scaled[s] * 0x1p32 ); // below 1: fits
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

// The emissive triangles and their powers; returns the sum.
static double fill_triangles( const RfScene* scene, RfLights* lights, double* powers )
{
    double total = 0.0;
    uint32_t k = 0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        lights->of_triangle[i] = RF_NO_LIGHT;
        if ( !emits( scene, i ) )
            continue;
        RfLight light = make_light( scene, i );
        powers[k] = power( &light );
        if ( !( powers[k] > 0.0 ) )
            continue; // no area, so nothing hits it; or its texture is black all over
        total += powers[k];
        lights->light[k] = light;
        lights->of_triangle[i] = k++;
    }
    lights->triangle_count = k;
    return total;
}

static void find_bounding_ball( const RfScene* scene, RfLights* lights )
{
    RfVec3 half = rf_scale( rf_sub( scene->bounds_max, scene->bounds_min ), 0.5f );
    lights->center = rf_add( scene->bounds_min, half );
    lights->radius = rf_maxf( rf_length( half ), 1e-6f * rf_largest_coordinate( lights->center ) );
    lights->inverse_radius = 1.0f / rf_maxf( lights->radius, RF_FAULT( empty_ball ) ? 0.0f : 1e-30f );
}

// Power over π, like that of the triangles. For lights at infinity: the flux
// through the bounding ball of the scene.
static double punctual_power( const RfPunctual* p, double radius )
{
    double luminance = (double)rf_luminance( p->intensity );
    switch ( p->kind )
    {
        case RF_PUNCTUAL_POINT: return 4.0 * luminance;
        case RF_PUNCTUAL_SPOT: return 2.0 * ( 1.0 - 0.5 * (double)( p->cos_inner + p->cos_outer ) ) * luminance;
        case RF_PUNCTUAL_DIRECTIONAL: return radius * radius * luminance;
    }
    return 0.0;
}

static double sky_power( const RfSky* sky, double radius )
{
    return 4.0 * 3.14159265358979324 * radius * radius * (double)sky->mean_luminance;
}

// Appends the powers of the punctual lights and the sky, black ones included; returns their sum.
static double append_non_area_lights( RfLights* lights, double* powers )
{
    double total = 0.0, radius = (double)lights->radius;
    uint32_t k = lights->triangle_count;
    for ( int i = 0; i < lights->punctual_count; ++i )
        total += powers[k++] = punctual_power( lights->punctual + i, radius );
    if ( rf_has_sky( lights ) )
        total += powers[k++] = sky_power( &lights->sky, radius );
    lights->count = k;
    return total;
}

static RfResult fill_lights( const RfScene* scene, RfLights* lights, uint32_t capacity, RfError* error )
{
    double* powers = malloc( capacity * sizeof *powers );
    if ( powers == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for %u lights", capacity );
    double total = lights->of_triangle != NULL ? fill_triangles( scene, lights, powers ) : 0.0;
    total += append_non_area_lights( lights, powers );
    if ( !( total > 0.0 ) && !RF_FAULT( no_power ) )
        lights->count = 0;
    for ( uint32_t i = 0; i < lights->count; ++i )
        lights->power_fraction[i] = (float)( powers[i] / total );
    RfResult result = lights->count > 0 ? build_alias( lights, powers, total, error ) : RF_OK;
    free( powers );
    if ( result == RF_OK && rf_runs( scene, lights->count > RF_FEW_LIGHTS, RF_EFFECT_LIGHT_TREE ) )
        result = rf_create_light_tree( lights, error );
    return result;
}

static RfResult alloc_lights( const RfScene* scene, RfLights* lights, uint32_t emissive, uint32_t capacity, RfError* error )
{
    bool complete = true;
    if ( emissive > 0 )
    {
        lights->light = malloc( emissive * sizeof *lights->light );
        lights->of_triangle = malloc( scene->triangles.count * sizeof *lights->of_triangle );
        complete = lights->light != NULL && lights->of_triangle != NULL;
    }
    lights->power_fraction = malloc( capacity * sizeof *lights->power_fraction );
    if ( !complete || lights->power_fraction == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for %u lights", capacity );
    return RF_OK;
}

RfResult rf_collect_lights( const RfScene* scene, RfLights* lights, RfError* error )
{
    *lights = ( RfLights ){ .punctual_count = scene->punctual_count, .punctual = scene->punctuals };
    find_bounding_ball( scene, lights );
    uint32_t emissive = 0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
        emissive += emits( scene, i );
    RfResult result = rf_make_sky( &scene->environment, &lights->sky, error );
    uint32_t capacity = emissive + (uint32_t)scene->punctual_count + rf_has_sky( lights );
    if ( result != RF_OK || capacity == 0 )
        return result;
    result = alloc_lights( scene, lights, emissive, capacity, error );
    if ( result == RF_OK )
        result = fill_lights( scene, lights, capacity, error );
    if ( result != RF_OK )
        rf_destroy_lights( lights );
    return result;
}

void rf_destroy_lights( RfLights* lights )
{
    rf_destroy_sky( &lights->sky );
    free( lights->light );
    rf_destroy_light_tree( &lights->tree );
    free( lights->power_fraction );
    free( lights->alias_threshold );
    free( lights->alias );
    free( lights->of_triangle );
    *lights = ( RfLights ){ 0 };
}
