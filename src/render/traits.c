// What a scene and its camera's path call for, and what runs.
#include "render/traits.h"

#include "base/remedy.h"
#include "light/changing.h"
#include "render/estimator.h"
#include "scene/leave_out.h"
#include "scene/light_groups.h"
#include "scene/mirrors.h"
#include "scene/placement.h"
#include "scene/textured.h"

static void add_triangles( const RfScene* scene, RfTriangleList list, RfSceneTraits* traits )
{
    const uint32_t* number = list.triangles->material;
    for ( uint32_t i = 0; i < list.triangles->count && list.uses > 0; ++i )
    {
        const RfMaterial* material = scene->materials + number[i];
        traits->chain_triangles += rf_is_chain_surface( material ) ? list.uses : 0;
        traits->plate_triangles += scene->punctual_count > 0 && rf_is_plate( material ) ? list.uses : 0;
        traits->most_lights += rf_max_component( material->emission ) > 0.0f ? list.uses : 0;
        if ( i > 0 && number[i] == number[i - 1] )
            continue;
        traits->kinds |= 1u << material->kind;
        traits->blended = traits->blended || rf_is_blended( material );
        traits->panes = traits->panes || rf_may_be_pane( material );
        traits->smooth = traits->smooth || rf_may_be_smooth( material );
        traits->without_caustics = traits->without_caustics || rf_may_throw_caustics( material );
        traits->sharp = traits->sharp || rf_may_be_sharp( material );
    }
}

static int count_dimmable( const RfScene* scene )
{
    int count = scene->environment.changes;
    for ( int i = 0; i < scene->punctual_count; ++i )
        count += scene->punctuals[i].changes;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        count += scene->materials[i].dims;
    return count < RF_DIMMED_MOST ? count : RF_DIMMED_MOST;
}

// The lamps without size, and the sky, that may be other than dimmed; none where anything else moves.
static int count_lamps_alone( const RfScene* scene )
{
    int count = scene->environment.changes;
    for ( int i = 0; i < scene->punctual_count; ++i )
        count += scene->punctuals[i].changes;
    return scene->placement_count == scene->still_placement_count ? count : 0;
}

// Settings that ask for none that there are have been refused.
static int count_light_groups( const RfScene* scene, const RfRenderSettings* settings )
{
    RfLightGroups groups;
    if ( settings->light_groups == NULL || rf_find_light_groups( scene, settings->light_groups, &groups, NULL ) != RF_OK )
        return 0;
    int count = groups.count;
    rf_destroy_light_groups( &groups );
    return count;
}

RfResult rf_check_light_groups( const RfScene* scene, const RfRenderSettings* settings, RfError* error )
{
    RfLightGroups groups;
    if ( settings->light_groups == NULL )
        return RF_OK;
    RfResult result = rf_find_light_groups( scene, settings->light_groups, &groups, error );
    if ( result != RF_OK )
        return result;
    rf_destroy_light_groups( &groups );
    if ( !settings->estimator->splits_light )
        return rf_advise(
            rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' cannot split light by groups", settings->estimator->name ),
            RF_REMEDY_ESTIMATOR, 0, error );
    if ( settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE, "light paths cannot split light by groups: --light-paths off or auto" );
    if ( rf_is_left_out( scene, RF_EFFECT_CAUSTICS ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "caustics cannot be left out of light groups: keep them, or render without light groups" );
    return RF_OK;
}

bool rf_may_move( const RfScene* scene ) { return rf_calls_for( scene->movement != NULL, RF_EFFECT_MOVING ); }

RfSceneTraits rf_scene_traits( const RfScene* scene, const RfEye* eyes, int eye_count, const RfRenderSettings* settings )
{
    RfSceneTraits traits = { .sky = rf_may_have_sky( scene ) };
    for ( int k = 0; k < rf_triangle_list_count( scene ); ++k )
        add_triangles( scene, rf_triangle_list( scene, k ), &traits );
    traits.without_caustics = traits.without_caustics && rf_is_left_out( scene, RF_EFFECT_CAUSTICS );
    traits.chains = traits.smooth || rf_has_specular( traits.kinds );
    RfMirrors mirrors;
    if ( rf_find_mirrors( scene, &mirrors, NULL ) == RF_OK )
        traits.mirrors = mirrors.count > 0;
    rf_destroy_mirrors( &mirrors );
    for ( int i = 0; i < eye_count; ++i )
    {
        traits.lens = traits.lens || eyes[i].lens_radius > 0.0f;
        bool blurs = rf_may_move( scene ) && eyes[i].blur_steps > traits.blur_steps;
        traits.blur_steps = blurs ? (int)eyes[i].blur_steps : traits.blur_steps;
        traits.shutter = traits.shutter || eyes[i].moves || traits.blur_steps > 0;
    }
    traits.grouped_chains = traits.mirrors || traits.smooth || traits.panes;
    traits.scattered = traits.lens || traits.shutter;
    traits.moves = rf_may_move( scene );
    traits.dimmable = traits.moves ? count_dimmable( scene ) : 0;
    traits.lamps_alone = traits.moves ? count_lamps_alone( scene ) : 0;
    traits.light_groups = count_light_groups( scene, settings );
    traits.materials = scene->material_count;
    traits.most_lights += (uint32_t)scene->punctual_count + 1;
    traits.moving_lights = traits.moves && rf_count_moving_emitters( scene ) > 0;
    if ( settings->light_paths == RF_LIGHT_PATHS_AUTO && traits.chain_triangles + traits.plate_triangles > 0 && !traits.blended )
        traits.emitters = rf_divide_emitters( scene, NULL );
    return traits;
}

bool rf_wants_light_paths( const RfSceneTraits* traits, const RfRenderSettings* settings )
{
    return rf_calls_for( settings->light_paths != RF_LIGHT_PATHS_OFF && settings->estimator->prepare != NULL &&
                             settings->weights == RF_WEIGHTS_EXACT && traits->chain_triangles + traits->plate_triangles > 0 &&
                             !traits->blended && !( traits->moves && settings->group != 0 ) && traits->blur_steps == 0 &&
                             !traits->without_caustics && traits->light_groups == 0 &&
                             ( settings->light_paths == RF_LIGHT_PATHS_ON || traits->emitters.connected > 0 ),
                         RF_EFFECT_LIGHT_PATHS );
}

RfResult rf_check_moving( const RfSceneTraits* traits, const RfRenderSettings* settings, RfError* error )
{
    if ( traits->blur_steps > 0 && settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE,
                        "light paths are of one moment, but something moves while the shutter is open: --shutter 0, or "
                        "--light-paths auto" );
    if ( !traits->moves || settings->group == 0 )
        return RF_OK;
    if ( settings->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE,
                        "the biased weights cannot tell what moves in a group of frames: exact weights, or a group of 0" );
    if ( settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE,
                        "light paths cannot be shared by frames in which something moves: --group 0, or --light-paths auto" );
    return RF_OK;
}

RfResult rf_check_caustics( const RfSceneTraits* traits, const RfRenderSettings* settings, RfError* error )
{
    if ( !traits->without_caustics )
        return RF_OK;
    if ( !settings->estimator->clamps )
        return rf_advise(
            rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' cannot leave caustics out", settings->estimator->name ),
            RF_REMEDY_ESTIMATOR, 0, error );
    if ( settings->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "the biased weights cannot leave caustics out: exact weights" );
    if ( settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE, "light paths bring caustics, which are left out: --light-paths off or auto" );
    if ( traits->moves && settings->group != 0 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "caustics cannot be left out of groups of frames in which something moves: --group 0, or keep them" );
    return RF_OK;
}

bool rf_wants_chains( const RfSceneTraits* traits, const RfRenderSettings* settings, int tile_pixels )
{
    bool grouped = settings->group != 0 && traits->grouped_chains;
    return traits->chains && settings->weights == RF_WEIGHTS_EXACT &&
           ( tile_pixels > 1 || grouped || rf_wants_light_paths( traits, settings ) ||
             ( settings->aovs & RF_PASS_AOVS ) != 0 ); // which tell what is seen by them
}

// The models that materials with forced effects scatter by.
static unsigned forced_kinds( const RfScene* scene )
{
    unsigned kinds = 0;
    for ( int k = 0; k < RF_BSDF_KIND_COUNT; ++k )
    {
        uint64_t forced = scene->effects_forced & ~RF_EFFECTS_NOT_BUILT & rf_bsdf_model( (RfBsdfKind)k )->forced_by;
        kinds |= forced != 0 ? 1u << k : 0;
    }
    return kinds;
}

RfSceneTraits rf_running_traits( const RfScene* scene, RfSceneTraits called )
{
    RfSceneTraits traits = called;
    traits.kinds |= forced_kinds( scene );
#define RF_TRAIT_RUNS( flag, effect ) traits.flag = rf_runs( scene, called.flag, RF_EFFECT_##effect );
    RF_TRAIT_LIST( RF_TRAIT_RUNS )
#undef RF_TRAIT_RUNS
    bool grouped = ( called.mirrors && traits.mirrors ) || called.smooth || ( called.panes && traits.panes );
    traits.grouped_chains = called.chains ? grouped : traits.chains;
    traits.scattered = ( called.lens && traits.lens ) || ( called.shutter && traits.shutter );
    return traits;
}
