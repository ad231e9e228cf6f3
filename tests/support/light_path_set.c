#include "light_path_set.h"

#include "render_support.h"

#include <stdlib.h>
#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

void draw_light_path_set( const RfScene* scene, int width, int height, LightPathSet* set )
{
    *set = ( LightPathSet ){ .tracer = make_tracer( scene ), .settings = plain_settings() };
    set->settings.threads = 1;
    set->settings.light_paths = RF_LIGHT_PATHS_ON;
    set->group = ( RfEstimatorGroup ){
        .tracer = set->tracer, .settings = &set->settings, .width = width, .height = height, .eye_count = 1
    };
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
        set->group.traits.chain_triangles += rf_is_chain_surface( scene->materials + scene->triangles.material[i] );
    set->group.traits.materials = scene->material_count;
    set->group.traits.most_lights = scene->triangles.count + 1;
    set->path = ( RfPathSettings ){ .tracer = set->tracer, .max_depth = 12, .light_samples = 1 };
    size_t bytes = rf_light_paths_bytes( &set->group );
    set->paths = aligned_alloc( 64, bytes );
    assert_non_null( set->paths );
    memset( set->paths, 0, bytes );
    rf_draw_light_paths( &set->group, 0, set->paths );
}

void free_light_path_set( LightPathSet* set )
{
    free( set->paths );
    rf_destroy_tracer( set->tracer );
}
