// The counts of a scene, of its lights too (reframe/scene.h).
#include "light/light.h"

static RfVec3 in_world( const RfScene* scene, RfVec3 p )
{
    return rf_vec3( (float)( scene->origin[0] + (double)p.x ), (float)( scene->origin[1] + (double)p.y ),
                    (float)( scene->origin[2] + (double)p.z ) );
}

RfResult rf_scene_info( const RfScene* scene, RfSceneInfo* info, RfError* error )
{
    RfLights lights = { 0 };
    RfResult result = rf_collect_lights( scene, &lights, error );
    if ( result != RF_OK )
        return result;
    *info = ( RfSceneInfo ){ .path = scene->path,
                             .triangles = scene->triangles.count,
                             .instances = scene->instance_count,
                             .materials = scene->material_count,
                             .lights = lights.count,
                             .emitting_triangles = lights.triangle_count,
                             .punctual_lights = scene->punctual_count,
                             .has_sky = rf_has_sky( &lights ),
                             .cameras = scene->camera_count,
                             .bounds_min = in_world( scene, scene->bounds_min ),
                             .bounds_max = in_world( scene, scene->bounds_max ),
                             .origin = { scene->origin[0], scene->origin[1], scene->origin[2] },
                             .fps = scene->fps,
                             .width = scene->film_width,
                             .height = scene->film_height,
                             .moving = (const char* const*)scene->moving,
                             .moving_count = scene->moving_count,
                             .export_warnings = (const char* const*)scene->export_warnings,
                             .export_warning_count = scene->export_warning_count };
    for ( uint32_t i = 0; i < lights.triangle_count; ++i )
        info->emitting_area += (double)lights.light[i].area;
    rf_destroy_lights( &lights );
    return RF_OK;
}
