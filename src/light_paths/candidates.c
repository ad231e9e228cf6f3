// Light paths and particles that may be connected to an eye vertex, and trial connections among them.
#include "light_paths/connections_internal.h"

#include <math.h>

#define EVENLY 0.25f      // of the trial connections, whatever they promise: derivatives err near foci
#define LEAST_SHARE 0.02f // of trial connections, where other light is so much stronger

void rf_begin_candidates( const RfConnectionWork* w, int i, const RfFootprintTree* tree, RfFootprintFound* note, RfCandidates* c )
{
    const RfVertexLanes* v = w->v;
    c->settings = w->settings;
    c->tree = tree;
    c->note = note;
    c->y = rf_start_of( v, i );
    c->ng = rf_lane_of( v->ng, i );
    c->n = rf_lane_of( v->n, i );
    c->spent = w->vertex - 1 + ( w->keys->spent != NULL ? w->keys->spent[v->slot[i]] : 0 );
    c->vertex = w->vertex;
    c->count = c->kept = 0;
    c->next = c->stride = 0.0;
    c->thinned = false;
}

void rf_keep_candidate( RfCandidates* c, uint32_t number, float light )
{
    int k = c->count++;
    if ( c->thinned && (double)k < c->next )
        return;
    if ( c->kept == RF_MOST_CANDIDATES )
        return;
    c->path[c->kept] = number;
    c->light[c->kept++] = light;
    c->next += c->stride;
}

void rf_note_path( void* user, uint32_t number )
{
    RfCandidates* c = user;
    const RfLightPath* path = c->settings->paths->path + number;
    float step[2], miss, spread = 1.0f;
    if ( c->spent + path->length + 2 > c->settings->path->max_depth )
        return;
    RfVec3 apart = rf_sub( c->y, path->at.p );
    if ( c->settings->normalization == RF_KERNEL_DENSITY )
    {
        if ( rf_dot( apart, apart ) > path->at.half.x * path->at.half.x )
            return;
    }
    else if ( !rf_newton_step( &path->end, c->y, c->ng, step, &miss, &spread ) ||
              !( rf_reach_squared( &path->reach, step[0], step[1] ) <= RF_STEP_MARGIN * RF_STEP_MARGIN ) )
        return;
    float light = path->light / spread;
    if ( c->settings->normalization != RF_KERNEL_DENSITY )
        light *= rf_connection_weight( c->settings->paths, path->chance, -rf_dot( c->n, path->end.d ), c->vertex );
    if ( light > 0.0f )
        rf_keep_candidate( c, number, light );
}

float rf_find_candidates( RfCandidates* c, RfRandomKey key )
{
    rf_find_footprints( c->tree, c->y, c->note, c );
    if ( c->count <= RF_MOST_CANDIDATES )
        return 1.0f;
    c->stride = (double)c->count / RF_MOST_CANDIDATES;
    c->next = c->stride * (double)rf_random( key, 0 );
    c->count = c->kept = 0;
    c->thinned = true;
    rf_find_footprints( c->tree, c->y, c->note, c );
    return (float)c->stride;
}

RfAcceptance rf_weigh_candidates( const RfConnectionWork* w, RfRandomKey lane, float scale, int i, const RfCandidates* c )
{
    RfAcceptance a = { .lane = lane, .scale = scale };
    for ( int k = 0; k < c->kept; ++k )
        a.sum += c->light[k];
    float promised = a.sum * scale * RF_INV_PI / (float)w->settings->paths->emitted;
    float share = promised / rf_maxf( promised + w->keys->lit[i], 1e-30f );
    a.trials = rf_trial_connections( w->settings->paths->share, w->vertex ) * rf_maxf( share, LEAST_SHARE );
    return a;
}

float rf_offered( const RfAcceptance* a, const RfCandidates* c, int k )
{
    return ( 1.0f - EVENLY ) * c->light[k] / a->sum + EVENLY / (float)c->kept;
}

float rf_accept( const RfAcceptance* a, const RfCandidates* c, int k, RfRandomKey* key )
{
    *key = rf_pixel_key( (uint64_t)a->lane.a << 32 | a->lane.b, c->path[k] );
    float accepted = rf_minf( a->trials * rf_offered( a, c, k ), 1.0f );
    return rf_random( *key, RF_DIMENSION_ACCEPT ) < accepted ? a->scale / accepted : 0.0f;
}
