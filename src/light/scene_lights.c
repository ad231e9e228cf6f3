// The counts of a scene, of its lights too (reframe/scene.h).
#include "light/light.h"

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
                             .bounds_min = scene->bounds_min,
                             .bounds_max = scene->bounds_max,
                             .fps = scene->fps,
                             .width = scene->film_width,
                             .height = scene->film_height,
                             .moving = (const char* const*)scene->moving,
                             .moving_count = scene->moving_count };
    for ( uint32_t i = 0; i < lights.triangle_count; ++i )
        info->emitting_area += (double)lights.light[i].area;
    rf_destroy_lights( &lights );
    return RF_OK;
}
