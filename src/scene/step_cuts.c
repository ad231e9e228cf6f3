// Cuts of cameras that move with their nodes.
#include "scene/animation.h"
#include "base/try.h"
#include "scene/camera.h"
#include "scene/movement.h"

#include <stdlib.h>
#include <string.h>

// A camera that steps on more often is animated in steps, as in stop motion.
#define LEAST_HOLD 0.25 // s

// Does the channel jump with key k, after and before a hold?
static bool is_cut( const RfChannel* channel, int k )
{
    size_t n = (size_t)channel->components;
    const double *values = channel->values + (size_t)k * n, *times = channel->times + k;
    return memcmp( values, values - n, n * sizeof *values ) != 0 && times[0] - times[-1] >= LEAST_HOLD &&
           ( k + 1 == channel->count || times[1] - times[0] >= LEAST_HOLD );
}

static RfResult add_cut( double time, RfCamera* camera, RfError* error )
{
    double* grown = realloc( camera->cuts, ( (size_t)camera->cut_count + 1 ) * sizeof *grown );
    if ( grown == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "camera '%.60s': out of memory for its cuts", camera->name );
    camera->cuts = grown;
    grown[camera->cut_count++] = time;
    return RF_OK;
}

static int compare( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

static void sort_cuts( RfCamera* camera )
{
    int count = 0;
    if ( camera->cut_count > 0 )
        qsort( camera->cuts, (size_t)camera->cut_count, sizeof *camera->cuts, compare );
    for ( int i = 0; i < camera->cut_count; ++i )
    {
        if ( i == 0 || camera->cuts[i] > camera->cuts[count - 1] )
            camera->cuts[count++] = camera->cuts[i];
    }
    camera->cut_count = count;
}

static RfResult add_cuts( const RfChannel* c, RfCamera* camera, RfError* error )
{
    bool steps = c->interpolation == RF_STEP && c->curve == NULL && c->clock.speed == 0.0;
    for ( int k = 1; steps && k < c->count; ++k )
        RF_TRY( is_cut( c, k ) ? add_cut( c->times[k], camera, error ) : RF_OK );
    return RF_OK;
}

RfResult rf_find_step_cuts( const RfScene* scene, RfCamera* camera, RfError* error )
{
    RfResult result = camera->zoom != NULL ? add_cuts( &camera->zoom->channel, camera, error ) : RF_OK;
    for ( int node = camera->node; node >= 0; node = scene->nodes[node].parent )
    {
        int count;
        const RfChannel* channels = rf_node_channels( scene, node, &count );
        for ( int i = 0; result == RF_OK && i < count; ++i )
        {
            if ( channels[i].path == RF_TRANSLATION || channels[i].path == RF_ROTATION )
                result = add_cuts( channels + i, camera, error );
        }
    }
    sort_cuts( camera );
    return result;
}
