// Collects the lights of a scene with their powers, and builds the alias table (Vose) and the light tree of those that do not
// change.
#include "light/changing.h"

#include "base/built_in.h"
#include "base/fault.h"
#include "light/emission.h"
#include "scene/leave_out.h"
#include "scene/movement.h"
#include "scene/placement.h"
#include "scene/pose.h"

#include <stdlib.h>
#include <string.h>

// Lights that move or change.

static bool shines( const RfMaterial* material ) { return rf_emits( material ); }

static bool moves( const RfScene* scene ) { return rf_calls_for( scene->movement != NULL, RF_EFFECT_MOVING ); }

static bool shines_in_part( const RfScene* scene, const RfPlacement* p )
{
    const RfTriangles* t = &scene->meshes[p->mesh].triangles;
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        if ( shines( scene->materials + t->material[i] ) )
            return true;
    }
    return false;
}

uint32_t rf_count_moving_emitters( const RfScene* scene )
{
    uint32_t count = 0;
    for ( int k = scene->still_placement_count; k < scene->placement_count && moves( scene ); ++k )
    {
        const RfTriangles* t = &scene->meshes[scene->placements[k].mesh].triangles;
        for ( uint32_t i = 0; i < t->count; ++i )
            count += shines( scene->materials + t->material[i] );
    }
    return count;
}

bool rf_lights_change( const RfScene* scene )
{
    if ( !moves( scene ) )
        return false;
    bool any = scene->environment.changes || rf_count_moving_emitters( scene ) > 0;
    for ( int i = 0; i < scene->punctual_count && !any; ++i )
        any = scene->punctuals[i].changes;
    for ( uint32_t i = 0; i < scene->material_count && !any; ++i )
        any = scene->materials[i].dims && shines( scene->materials + i );
    return any;
}

static RfResult no_memory( RfError* error ) { return rf_fail( error, RF_ERROR_MEMORY, "out of memory for lights that change" ); }

// `dim_of`: of each material, its index in changing->dim; −1: it is not there.
static RfResult list_materials( const RfScene* scene, RfChangingLights* changing, int32_t* dim_of, RfError* error )
{
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        dim_of[i] = scene->materials[i].dims && shines( scene->materials + i ) ? (int32_t)changing->dim_count++ : -1;
    changing->dim = malloc( ( (size_t)changing->dim_count + 1 ) * sizeof *changing->dim );
    changing->dim_moves = calloc( (size_t)changing->dim_count + 1, sizeof *changing->dim_moves );
    changing->dimmed_end = calloc( (size_t)changing->dim_count + 1, sizeof *changing->dimmed_end );
    if ( changing->dim == NULL || changing->dim_moves == NULL || changing->dimmed_end == NULL )
        return no_memory( error );
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        if ( dim_of[i] >= 0 )
            changing->dim[dim_of[i]] = i;
    }
    return RF_OK;
}

// Sorts those of `light` by their materials: RfChangingLights.dimmed.
static RfResult sort_by_material( RfChangingLights* changing, RfError* error )
{
    uint32_t* end = changing->dimmed_end;
    changing->dimmed = malloc( ( (size_t)changing->count + 1 ) * sizeof *changing->dimmed );
    if ( changing->dimmed == NULL )
        return no_memory( error );
    for ( uint32_t i = 0; i < changing->count; ++i )
        end[changing->light[i].dim + 1] += 1; // one behind: below, they move on by all of their own
    for ( uint32_t k = 0; k < changing->dim_count; ++k )
        end[k + 1] += end[k];
    for ( uint32_t i = 0; i < changing->count; ++i )
        changing->dimmed[end[changing->light[i].dim]++] = i;
    return RF_OK;
}

static RfResult list_still_triangles( const RfScene* scene, const RfLights* lights, const int32_t* dim_of,
                                      RfChangingLights* changing, RfError* error )
{
    for ( uint32_t i = 0; i < changing->still_triangles && changing->dim_count > 0; ++i )
    {
        int32_t dim = dim_of[scene->triangles.material[lights->light[i].triangle]];
        if ( dim >= 0 )
            changing->light[changing->count++] = ( RfChangingLight ){ i, dim, lights->light[i].radiance };
    }
    return sort_by_material( changing, error );
}

static void list_moving_triangles( const RfScene* scene, const int32_t* dim_of, RfLights* lights, RfChangingLights* changing )
{
    uint32_t number = changing->still_triangles;
    for ( uint32_t i = changing->first_moving; i < changing->end_moving; ++i )
    {
        RfTriangleAt at = rf_locate_placed_triangle( scene, i );
        const RfMaterial* m = scene->materials + at.triangles->material[at.index];
        changing->of_moving[i - changing->first_moving] = RF_NO_LIGHT;
        if ( !shines( m ) )
            continue;
        RfVec3 mean = m->textured != NULL ? rf_mean_emission( scene, m, i ) : m->emission;
        int32_t dim = dim_of[at.triangles->material[at.index]];
        if ( dim >= 0 )
            changing->dim_moves[dim] = true;
        // until it is posed, it brings nothing
        lights->light[number] =
            ( RfLight ){ .triangle = i, .pdf_area = 1.0f, .two_sided = m->double_sided, .textured = m->textured != NULL };
        changing->light[changing->count++] = ( RfChangingLight ){ number, dim, mean };
        changing->of_moving[i - changing->first_moving] = number++;
    }
}

static RfResult list_moving( const RfScene* scene, const int32_t* dim_of, RfLights* lights, RfChangingLights* changing,
                             RfError* error )
{
    for ( int k = scene->still_placement_count; k < scene->placement_count; ++k )
    {
        const RfPlacement* p = scene->placements + k;
        if ( !shines_in_part( scene, p ) )
            continue;
        changing->first_moving = changing->end_moving > 0 ? changing->first_moving : p->first;
        changing->end_moving = p->first + scene->meshes[p->mesh].triangles.count;
    }
    changing->of_moving =
        malloc( ( (size_t)( changing->end_moving - changing->first_moving ) + 1 ) * sizeof *changing->of_moving );
    if ( changing->of_moving == NULL )
        return no_memory( error );
    list_moving_triangles( scene, dim_of, lights, changing );
    return RF_OK;
}

static RfResult list_lights( const RfScene* scene, int32_t* dim_of, RfLights* lights, RfError* error )
{
    RfChangingLights* changing = lights->changing;
    uint32_t moving = rf_count_moving_emitters( scene );
    changing->still_triangles = lights->triangle_count - moving;
    changing->light = malloc( ( (size_t)lights->triangle_count + (size_t)lights->punctual_count + 1 ) * sizeof *changing->light );
    if ( changing->light == NULL )
        return no_memory( error );
    RfResult result = list_materials( scene, changing, dim_of, error );
    if ( result == RF_OK )
        result = list_still_triangles( scene, lights, dim_of, changing, error );
    if ( result == RF_OK && moving > 0 )
        result = list_moving( scene, dim_of, lights, changing, error );
    for ( int i = 0; i < lights->punctual_count; ++i )
    {
        if ( lights->punctual[i].changes )
            changing->light[changing->count++] = ( RfChangingLight ){ .number = lights->triangle_count + (uint32_t)i, .dim = -1 };
    }
    return result;
}

// Finds what moves or changes among lights of which all but the tree are collected. Fails with RF_ERROR_MEMORY.
static RfResult find_changing_lights( const RfScene* scene, RfLights* lights, RfError* error )
{
    int32_t* dim_of = malloc( ( (size_t)scene->material_count + 1 ) * sizeof *dim_of );
    lights->changing = calloc( 1, sizeof *lights->changing );
    RfResult result =
        dim_of != NULL && lights->changing != NULL ? list_lights( scene, dim_of, lights, error ) : no_memory( error );
    free( dim_of );
    return result;
}

static void destroy_changing_lights( RfChangingLights* changing )
{
    if ( changing == NULL )
        return;
    free( changing->of_moving );
    free( changing->dim );
    free( changing->dim_moves );
    free( changing->dimmed );
    free( changing->dimmed_end );
    free( changing->light );
    free( changing );
}

void rf_note_emission( const RfLights* still, const RfScene* posed, RfVec3* emission )
{
    for ( uint32_t i = 0; i < still->changing->dim_count; ++i )
        emission[i] = posed->materials[still->changing->dim[i]].emission;
}

// All lights.

void rf_shape_light( RfVec3 a, RfVec3 b, RfVec3 c, RfLight* light )
{
    light->p0 = a;
    light->e1 = rf_sub( b, a );
    light->e2 = rf_sub( c, a );
    double twice;
    light->normal = rf_unit_cross( light->e1, light->e2, &twice );
    light->area = (float)( 0.5 * twice );
    light->pdf_area = light->area > 0.0f ? 1.0f / light->area : INFINITY;
    light->offset =
        rf_ray_offset( rf_maxf( rf_largest_coordinate( a ), rf_maxf( rf_largest_coordinate( b ), rf_largest_coordinate( c ) ) ) );
}

static RfLight make_light( const RfScene* scene, uint32_t triangle )
{
    const RfTriangles* t = &scene->triangles;
    const RfMaterial* material = scene->materials + t->material[triangle];
    RfLight light = { .radiance = material->emission, .triangle = triangle, .two_sided = material->double_sided };
    rf_shape_light( rf_corner( t, triangle, 0 ), rf_corner( t, triangle, 1 ), rf_corner( t, triangle, 2 ), &light );
    light.textured = material->textured != NULL;
    if ( light.textured )
        light.radiance = rf_mean_emission( scene, material, triangle );
    return light;
}

static bool emits( const RfScene* scene, uint32_t triangle )
{
    return rf_emits( scene->materials + scene->triangles.material[triangle] );
}

RfResult rf_build_alias( RfLights* lights, const double* powers, double total, RfError* error )
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
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the alias table of %u lights", n );
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

static double fill_triangles( const RfScene* scene, RfLights* lights, double* powers )
{
    double total = 0.0;
    uint32_t k = 0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        lights->of_triangle[i] = RF_NO_LIGHT;
        if ( !emits( scene, i ) )
            continue;
        lights->light[k] = make_light( scene, i );
        powers[k] = g_rf_light_models[RF_LIGHT_TRIANGLE].selection_power( lights, k );
        if ( !( powers[k] > 0.0 ) )
            continue; // no area, so nothing hits it; or its texture is black all over
        total += powers[k];
        lights->of_triangle[i] = k++;
    }
    lights->triangle_count = k;
    return total;
}

// Those that move have no power before they are posed.
static void append_moving_triangles( uint32_t count, RfLights* lights, double* powers )
{
    for ( uint32_t i = 0; i < count; ++i )
        powers[lights->triangle_count++] = 0.0;
}

static void find_bounding_ball( const RfScene* scene, RfLights* lights )
{
    RfVec3 half = rf_scale( rf_sub( scene->bounds_max, scene->bounds_min ), 0.5f );
    lights->center = rf_add( scene->bounds_min, half );
    lights->radius = rf_maxf( rf_length( half ), 1e-6f * rf_largest_coordinate( lights->center ) );
    lights->reach = lights->radius;
    lights->inverse_radius = 1.0f / rf_maxf( lights->radius, RF_FAULT( empty_ball ) ? 0.0f : 1e-30f );
}

// Appends the powers of the punctual lights and the sky, black ones included; returns their sum.
static double append_non_area_lights( RfLights* lights, double* powers )
{
    double total = 0.0;
    lights->count = lights->triangle_count + (uint32_t)lights->punctual_count + rf_has_sky( lights );
    for ( uint32_t i = lights->triangle_count; i < lights->count; ++i )
        total += powers[i] = rf_light_model( lights, i )->selection_power( lights, i );
    return total;
}

// The tree over all lights but the sky and those that change, and sky_scale. There is none where all that is left is dark.
static RfResult create_light_tree( RfLights* lights, RfError* error )
{
    const RfChangingLights* changing = lights->changing;
    uint32_t all = lights->count - rf_has_sky( lights ), count = 0, skipped = 0;
    RfTreeLight* leaves = malloc( (size_t)( all + 1 ) * sizeof *leaves );
    if ( leaves == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a tree of %u lights", all );
    double sum = rf_has_sky( lights ) && changing == NULL ? 3.14159265358979324 * (double)lights->sky.mean_luminance : 0.0;
    for ( uint32_t i = 0; i < all; ++i )
    {
        if ( changing != NULL && skipped < changing->count && changing->light[skipped].number == i )
        {
            ++skipped;
            continue;
        }
        leaves[count] = rf_light_model( lights, i )->bound( lights, i );
        sum += leaves[count++].intensity;
    }
    for ( uint32_t i = 0; i < count; ++i )
        leaves[i].intensity /= sum;
    RfResult result = RF_OK;
    if ( changing == NULL || sum > 0.0 )
    {
        lights->sky_scale = rf_has_sky( lights ) ? (float)( 1.0 / sum ) : 0.0f;
        result = rf_build_light_tree( leaves, count, lights->count, &lights->tree, error );
    }
    free( leaves );
    if ( changing == NULL )
        return result;
    // until there is a group: what changes competes with the rest by a tree of its own
    lights->changing->still_sum = sum;
    lights->second = &lights->changing->none;
    lights->tree_scale = 1.0f;
    return result;
}

// `selects`: lights can then be selected; else they are only listed.
static RfResult fill_lights( const RfScene* scene, uint32_t moving, bool selects, RfLights* lights, uint32_t capacity,
                             RfError* error )
{
    double* powers = malloc( capacity * sizeof *powers );
    if ( powers == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %u lights", capacity );
    double total = lights->of_triangle != NULL ? fill_triangles( scene, lights, powers ) : 0.0;
    append_moving_triangles( moving, lights, powers );
    total += append_non_area_lights( lights, powers );
    bool change = rf_lights_change( scene ), dark = !( total > 0.0 ) && !RF_FAULT( no_power );
    if ( dark && !change )
        lights->count = 0;
    for ( uint32_t i = 0; i < lights->count && dark; ++i )
        total += powers[i] = 1.0; // what shines is found out in the lights of a group
    for ( uint32_t i = 0; i < lights->count; ++i )
        lights->power_fraction[i] = (float)( powers[i] / total );
    RfResult result = lights->count > 0 && selects ? rf_build_alias( lights, powers, total, error ) : RF_OK;
    free( powers );
    bool by_tree = selects && rf_runs( scene, lights->count > RF_FEW_LIGHTS, RF_EFFECT_LIGHT_TREE );
    if ( result == RF_OK && change && lights->count > 0 )
        result = find_changing_lights( scene, lights, error );
    if ( result == RF_OK && by_tree )
        result = create_light_tree( lights, error );
    if ( lights->changing != NULL )
        lights->changing->by_tree = by_tree;
    return result;
}

static RfResult alloc_lights( const RfScene* scene, RfLights* lights, uint32_t emissive, uint32_t moving, uint32_t capacity,
                              RfError* error )
{
    bool complete = true;
    if ( emissive + moving > 0 )
    {
        lights->light = malloc( ( (size_t)emissive + moving ) * sizeof *lights->light );
        complete = lights->light != NULL;
    }
    if ( emissive > 0 )
    {
        lights->of_triangle = malloc( scene->triangles.count * sizeof *lights->of_triangle );
        complete = complete && lights->of_triangle != NULL;
    }
    lights->power_fraction = malloc( capacity * sizeof *lights->power_fraction );
    if ( !complete || lights->power_fraction == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %u lights", capacity );
    return RF_OK;
}

// That of a sky which changes is there even if it is dark when loaded.
static RfResult make_sky( const RfScene* scene, RfLights* lights, RfError* error )
{
    const RfEnvironment* e = &scene->environment;
    if ( rf_max_component( e->radiance ) > 0.0f || !e->changes || !rf_lights_change( scene ) )
        return rf_make_sky( e, &lights->sky, error );
    RfEnvironment lit = *e;
    lit.radiance = rf_sky_reference( e );
    RfResult result = rf_make_sky( &lit, &lights->sky, error );
    if ( lights->sky.environment != NULL )
        lights->sky.environment = e;
    return result;
}

static RfResult collect( const RfScene* scene, bool selects, RfLights* lights, RfError* error )
{
    *lights = ( RfLights ){ .punctual_count = scene->punctual_count, .punctual = scene->punctuals };
    find_bounding_ball( scene, lights );
    uint32_t emissive = 0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
        emissive += emits( scene, i );
    RfResult result = make_sky( scene, lights, error );
    uint32_t moving = rf_count_moving_emitters( scene );
    uint32_t capacity = emissive + moving + (uint32_t)scene->punctual_count + rf_has_sky( lights );
    if ( result != RF_OK || capacity == 0 )
        return result;
    result = alloc_lights( scene, lights, emissive, moving, capacity, error );
    if ( result == RF_OK )
        result = fill_lights( scene, moving, selects, lights, capacity, error );
    if ( result != RF_OK )
        rf_destroy_lights( lights );
    return result;
}

RfResult rf_collect_lights( const RfScene* scene, RfLights* lights, RfError* error )
{
    return collect( scene, true, lights, error );
}

RfResult rf_split_lights( const RfScene* scene, const RfLightGroups* groups, RfLights* lights, RfError* error )
{
    lights->part = calloc( (size_t)lights->count + 1, sizeof *lights->part );
    lights->material_part = calloc( (size_t)scene->material_count + 1, sizeof *lights->material_part );
    if ( lights->part == NULL || lights->material_part == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the groups of %u lights", lights->count );
    lights->group_count = groups->count;
    lights->dimmed_count = groups->count - 1;
    for ( int part = 0; part < groups->count; ++part )
    {
        lights->base_part[part] = (uint8_t)part;
        lights->part_scale[part] = rf_vec3( 1, 1, 1 );
    }
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        lights->material_part[i] = (uint8_t)rf_part_of_group( groups->material[i], groups->count );
    for ( uint32_t i = 0; i < lights->count; ++i )
    {
        uint32_t punctual = i - lights->triangle_count;
        if ( i < lights->triangle_count )
            lights->part[i] = lights->material_part[rf_material_of( scene, lights->light[i].triangle )];
        else if ( punctual < (uint32_t)lights->punctual_count )
            lights->part[i] = (uint8_t)rf_part_of_group( groups->punctual[punctual], groups->count );
        else
            lights->part[i] = (uint8_t)rf_part_of_group( groups->sky, groups->count );
    }
    return RF_OK;
}

void rf_join_lights( RfLights* lights )
{
    free( lights->part );
    free( lights->material_part );
    lights->part = lights->material_part = NULL;
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
    destroy_changing_lights( lights->changing );
    *lights = ( RfLights ){ 0 };
}

// The counts of a scene, of its lights too (reframe/scene.h).

static RfVec3 in_world( const RfScene* scene, RfVec3 p )
{
    return rf_vec3( (float)( scene->origin[0] + (double)p.x ), (float)( scene->origin[1] + (double)p.y ),
                    (float)( scene->origin[2] + (double)p.z ) );
}

// Those in world space, and each mesh once.
static uint32_t count_stored( const RfScene* scene )
{
    uint32_t count = 0;
    for ( int k = 0; k < rf_triangle_list_count( scene ); ++k )
        count += rf_triangle_list( scene, k ).triangles->count;
    return count;
}

// The area of the lights that are triangles. Those that move are where they are at the first key; hidden there, they have none.
static RfResult add_areas( const RfScene* scene, const RfLights* lights, double* area, RfError* error )
{
    RfPosedScene pose = { 0 };
    uint32_t moving = rf_count_moving_emitters( scene ), still = lights->triangle_count - moving;
    RfResult result = moving > 0 ? rf_pose_scene( scene, scene->movement->start, &pose, error ) : RF_OK;
    for ( uint32_t i = 0; i < lights->triangle_count && result == RF_OK; ++i )
    {
        RfLight light = lights->light[i];
        if ( i >= still )
        {
            RfTriangleAt at = rf_locate_placed_triangle( &pose.scene, light.triangle );
            if ( !at.placement->shown )
                continue;
            rf_shape_light( rf_placed_corner( &pose.scene, light.triangle, 0 ),
                            rf_placed_corner( &pose.scene, light.triangle, 1 ),
                            rf_placed_corner( &pose.scene, light.triangle, 2 ), &light );
        }
        *area += (double)light.area;
    }
    rf_destroy_pose( &pose );
    return result;
}

RfResult rf_scene_info( const RfScene* scene, RfSceneInfo* info, RfError* error )
{
    RfLights lights = { 0 };
    double area = 0.0;
    RfResult result = collect( scene, false, &lights, error );
    if ( result == RF_OK )
        result = add_areas( scene, &lights, &area, error );
    if ( result != RF_OK )
    {
        rf_destroy_lights( &lights );
        return result;
    }
    *info = ( RfSceneInfo ){ .path = scene->path,
                             .triangles = rf_triangle_count( scene ),
                             .stored_triangles = count_stored( scene ),
                             .instances = scene->instance_count,
                             .materials = scene->material_count,
                             .lights = lights.count,
                             .emitting_triangles = lights.triangle_count,
                             .emitting_area = area,
                             .punctual_lights = scene->punctual_count,
                             .has_sky = rf_has_sky( &lights ),
                             .cameras = scene->camera_count,
                             .bounds_min = in_world( scene, scene->bounds_min ),
                             .bounds_max = in_world( scene, scene->bounds_max ),
                             .origin = { scene->origin[0], scene->origin[1], scene->origin[2] },
                             .fps = scene->fps,
                             .width = scene->film_width,
                             .height = scene->film_height,
                             .alpha = scene->film_alpha,
                             .moving = (const char* const*)scene->moving,
                             .moving_count = scene->moving_count,
                             .frozen = scene->frozen,
                             .unrendered = scene->unrendered,
                             .unrendered_count = scene->unrendered_count,
                             .variant_count = scene->variant_count,
                             .variants = (const char* const*)scene->variants,
                             .light_group_count = scene->light_group_count,
                             .light_groups = (const char* const*)scene->light_groups,
                             .losses = (const char* const*)scene->losses,
                             .loss_count = scene->loss_count,
                             .export_losses = (const char* const*)scene->export_losses,
                             .export_loss_count = scene->export_loss_count,
                             .export_warnings = (const char* const*)scene->export_warnings,
                             .export_warning_count = scene->export_warning_count };
    rf_destroy_lights( &lights );
    return RF_OK;
}
