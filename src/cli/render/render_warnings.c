#include "cli/render/render_warnings.h"

#include "render/groups.h"
#include "scene/scene.h"

#include <string.h>

void rf_warn_of_variance( const RfRenderSettings* s, const RfCameraPath* path, const int* frames, int frame_count, RfLog* log )
{
    RfGroupPlan plan = rf_plan_groups( path->run_count, s->group, s->spp );
    if ( ( s->aovs & RF_AOV_BIT( RF_AOV_VARIANCE ) ) == 0 || s->noise > 0.0 || s->flicker > 0.0 ||
         s->time > 0.0 ) // never a single pass
        return;
    for ( int i = 0; i < frame_count; ++i )
    {
        if ( rf_frame_passes( &plan, path->run_of_frame[frames[i]] ) > 1 )
            continue;
        rf_warn( log, "--aov variance: will be 0 in frame %d, which has one pass only: raise --spp",
                 rf_frame_number( path, frames[i] ) );
        return;
    }
}

void rf_warn_of_scene( const RfRenderOptions* options, const RfScene* scene, const RfTracer* tracer, RfLog* log )
{
    if ( scene->triangles.count == 0 )
        rf_warn( log, "%s: has no triangles, the picture will be %s", options->scene,
                 rf_tracer_has_light( tracer ) ? "sky alone" : "black" );
    else if ( !rf_tracer_has_light( tracer ) && scene->punctual_count > 0 )
        rf_warn( log, "%s: none of its lamps has any power ('%.60s' is one of %d), no material emits, the picture will be black",
                 options->scene, scene->punctuals[0].name, scene->punctual_count );
    else if ( !rf_tracer_has_light( tracer ) )
        rf_warn( log, "%s: has no lights (no material emits, no lamp, no environment), the picture will be black",
                 options->scene );
}

#define LEAST_WEIGHTED_PASSES 4 // two in each half: src/gradient/picture.c

void rf_warn_of_reconstruction( const RfRenderSettings* s, RfLog* log )
{
    if ( strcmp( rf_estimator_name( s->estimator ), "gradient" ) != 0 )
        return;
    if ( s->reconstruction == RF_RECONSTRUCTION_L1 )
        rf_warn( log, "--reconstruction l1: is biased, and the error estimate does not know by how much" );
    else if ( s->reconstruction == RF_RECONSTRUCTION_WEIGHTED && s->spp < LEAST_WEIGHTED_PASSES )
        rf_warn( log, "--reconstruction weighted: is l2 with less than %d samples: raise --spp", LEAST_WEIGHTED_PASSES );
}

void rf_warn_of_light_paths( const RfRenderSettings* s, const RfEffect* effect, RfLog* log )
{
    if ( s->light_paths == RF_LIGHT_PATHS_ON && !effect->on )
        rf_warn( log, "--light-paths on: there are none: %s", effect->why );
    else if ( effect->on && s->kernel_normalization != RF_KERNEL_EXACT )
        rf_warn( log, "--kernel-normalization %s: is biased, and the error estimate does not know by how much",
                 rf_kernel_normalization_name( s->kernel_normalization ) );
}
