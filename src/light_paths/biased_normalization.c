// Research: the biased normalisations of connections, for comparison (--kernel-normalization). `disc` takes all of the reach to
// lead to the vertex, without trials. `density` connects nothing: it estimates the photon density by balls (GK 7).
#include "light_paths/connections_internal.h"

static void divide_by_cones( RfConnectionWork* w )
{
    for ( int k = 0; k < w->vpl_count; ++k )
    {
        RfVplConnection* connection = w->vpl_connection + k;
        connection->inverse_probability = 1.0f / ( connection->cone * connection->cosine );
    }
}

const RfNormalization rf_disc_normalization = {
    .weighted = true,
    .note_path = rf_note_path,
    .solve = rf_walk_to_vertices,
    .divide_vpls = divide_by_cones,
    .weigh_chance = rf_weigh_chance,
};

static void note_in_ball( void* user, uint32_t number )
{
    RfCandidates* c = user;
    const RfLightPath* path = c->settings->paths->path + number;
    RfVec3 apart = rf_sub( c->y, path->at.p );
    bool within = c->spent + path->length + 2 <= c->settings->path->max_depth &&
                  !( rf_dot( apart, apart ) > path->at.half.x * path->at.half.x );
    if ( within && path->light > 0.0f )
        rf_keep_candidate( c, number, path->light );
}

// Paths that land near the camera vertex count as landing there.
static void estimate_density( RfConnectionWork* w )
{
    for ( int k = 0; k < w->count; ++k )
    {
        RfConnection* connection = w->connection + k;
        connection->wi = rf_scale( connection->path->end.d, -1.0f );
        connection->light = rf_scale( connection->path->flux, connection->scale );
        connection->reach = ( RfReach ){ { 1.0f, 0.0f }, connection->path->at.half.x, connection->path->at.half.x };
        connection->repeats = 1.0f;
        connection->chance = 0.0f;
        connection->area = INFINITY;
        connection->open = rf_dot( rf_lane_of( w->v->n, connection->lane ), connection->wi ) > 0.0f &&
                           rf_dot( rf_lane_of( w->v->ng, connection->lane ), connection->wi ) > 0.0f;
    }
}

// Scattered rays leave all of this light to the light paths.
static float weigh_chance( const RfConnector* connector, const RfTrail* trail, int length, uint32_t triangle, RfVec3 point )
{
    (void)connector, (void)trail, (void)length, (void)triangle, (void)point;
    return 0.0f;
}

const RfNormalization rf_density_normalization = {
    .balls = true,
    .note_path = note_in_ball,
    .solve = estimate_density,
    .weigh_chance = weigh_chance,
};
