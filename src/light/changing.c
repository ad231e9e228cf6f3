// Finds the lights of a scene that move or change.
#include "light/changing.h"

#include "base/built_in.h"
#include "scene/placement.h"

#include <stdlib.h>
#include <string.h>

static bool shines( const RfMaterial* material ) { return rf_max_component( material->emission ) > 0.0f; }

static bool moves( const RfScene* scene ) { return rf_calls_for( scene->movement != NULL, RF_EFFECT_MOVING ); }

// Of a placement.
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

RfResult rf_find_changing_lights( const RfScene* scene, RfLights* lights, RfError* error )
{
    int32_t* dim_of = malloc( ( (size_t)scene->material_count + 1 ) * sizeof *dim_of );
    lights->changing = calloc( 1, sizeof *lights->changing );
    RfResult result =
        dim_of != NULL && lights->changing != NULL ? list_lights( scene, dim_of, lights, error ) : no_memory( error );
    free( dim_of );
    return result;
}

void rf_destroy_changing_lights( RfChangingLights* changing )
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
