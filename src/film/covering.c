// Numbers of surfaces, and index passes.
#include "film/covering.h"

#include "film/cryptomatte.h"
#include "scene/placement.h"
#include "trace/trace.h"

RfSurfaceKinds rf_surface_kinds( const RfRenderSettings* s )
{
    const unsigned objects = RF_CRYPTOMATTE_OBJECT | RF_CRYPTOMATTE_ASSET;
    return ( RfSurfaceKinds ){
        .objects = ( s->cryptomatte & objects ) != 0 || ( s->aovs & RF_AOV_BIT( RF_AOV_OBJECT_INDEX ) ) != 0,
        .materials = ( s->cryptomatte & RF_CRYPTOMATTE_MATERIAL ) != 0 || ( s->aovs & RF_AOV_BIT( RF_AOV_MATERIAL_INDEX ) ) != 0,
    };
}

RfResult rf_check_surface_numbers( const RfScene* scene, RfSurfaceKinds kinds, RfError* error )
{
    uint64_t objects = kinds.objects ? (uint64_t)scene->node_count + 1 : 1;
    if ( objects * scene->material_count < UINT32_MAX )
        return RF_OK;
    return rf_fail( error, RF_ERROR_UNSUPPORTED,
                    "%d objects of %u materials are too many to tell apart: ask for Cryptomatte of objects or of materials alone",
                    scene->node_count, scene->material_count );
}

uint32_t rf_surface_number( const RfScene* scene, RfSurfaceKinds kinds, uint32_t triangle )
{
    if ( triangle == RF_MISS )
        return 0;
    uint32_t object = kinds.objects ? (uint32_t)( 1 + rf_node_of_triangle( scene, triangle ) ) : 0;
    uint32_t material = kinds.materials ? rf_material_of( scene, triangle ) : 0;
    return 1 + object * scene->material_count + material;
}

// The index that covers most of a pixel; 0 where nothing does.
static float usual_index( const RfCovering* p, const RfScene* scene, bool objects, const float* index_of )
{
    float index[RF_COVERING_MOST], weight[RF_COVERING_MOST], most = p->nothing, usual = 0.0f;
    int listed = 0;
    for ( int k = 0; k < RF_COVERING_MOST && p->surface[k] != 0; ++k )
    {
        uint32_t pair = p->surface[k] - 1;
        float here = index_of[objects ? pair / scene->material_count : pair % scene->material_count];
        int at = 0;
        while ( at < listed && index[at] != here )
            ++at;
        weight[at] = at < listed ? weight[at] + p->weight[k] : p->weight[k];
        index[at] = here;
        listed += at == listed;
    }
    for ( int k = 0; k < listed; ++k )
    {
        usual = weight[k] > most ? index[k] : usual;
        most = weight[k] > most ? weight[k] : most;
    }
    return usual;
}

void rf_finish_index( const RfCovering* pixels, size_t count, const RfScene* scene, RfAov aov, const float* index_of,
                      float* image )
{
#pragma omp parallel
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( size_t i = 0; i < count; ++i )
            image[i] = usual_index( pixels + i, scene, aov == RF_AOV_OBJECT_INDEX, index_of );
    }
}
