// Light paths that may be linked to an eye vertex.
#include "kernel/links_internal.h"

#include <math.h>

static void note( void* user, uint32_t number )
{
    RfCandidates* c = user;
    const RfLightPath* path = c->settings->paths->path + number;
    float step[2], miss, most = RF_STEP_MARGIN * path->reach, spread = 1.0f;
    if ( c->spent + path->length + 2 > c->settings->path->max_depth )
        return;
    if ( c->settings->normalization != RF_KERNEL_DENSITY && ( !rf_newton_step( &path->end, c->y, c->n, step, &miss, &spread ) ||
                                                              !( step[0] * step[0] + step[1] * step[1] <= most * most ) ) )
        return;
    int k = c->count++;
    if ( c->thinned && (double)k < c->next )
        return;
    if ( c->kept == RF_MOST_CANDIDATES )
        return;
    c->path[c->kept] = number;
    c->light[c->kept++] = path->light / spread;
    c->next += c->stride;
}

float rf_find_candidates( RfCandidates* c, RfRandomKey key )
{
    rf_find_footprints( c->settings->paths, c->y, note, c );
    if ( c->count <= RF_MOST_CANDIDATES )
        return 1.0f;
    c->stride = (double)c->count / RF_MOST_CANDIDATES;
    c->next = c->stride * (double)rf_random( key, 0 );
    c->count = c->kept = 0;
    c->thinned = true;
    rf_find_footprints( c->settings->paths, c->y, note, c );
    return (float)c->stride;
}
