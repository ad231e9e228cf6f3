// Minimises variance times cost over the share of light paths and connections, from a few batches traced ahead.
#include "reuse/harvest/connection_share.h"

#include "reuse/harvest/harvest_scratch.h"

#include <limits.h>
#include <string.h>

#define MOST_JOBS 6
#define LEAST_JOBS 1
#define AHEAD 0.1       // the part of a pass's batches that is traced ahead, twice
#define AT_AHEAD 4      // of rf_connection_shares, with which they are traced
#define LEAST_NEEDED 4  // the same, at least, for lights that need light paths
#define LEAST_REST 0.25 // part of the error, at least, that is assumed to be of other light
#define LEAST_MEAN 0.1  // floor for the square of a batch's mean, in parts of that of all
// costs, in rays that are traced in packets
#define LINK_RAY 5.0
#define SEARCH 3.5           // for light paths around a vertex
#define PASS ( INT_MAX - 2 ) // and the next: their random numbers are no other pass's

// Irradiance found at each hit by a batch, by slot.
typedef struct Found
{
    float light[RF_LANES];
    bool is_hit[RF_LANES]; // else there is no light
    int hits;
    double moment[RF_CONNECTION_SHARES]; // RfConnectionLanes
    RfChanceOctave chance[RF_CHANCE_OCTAVES];
} Found;

struct RfPilot
{
    RfEstimatorGroup group;
    RfRenderSettings settings;
    RfHitBatch* batch;
    RfHarvestScratch* scratch;
    Found *first, *other; // by batch
    uint64_t rays, connection_rays, searched;
};

RfPilot* rf_place_pilot( const RfEstimatorGroup* group, const RfBatchShape* shape, RfLayout* layout )
{
    RfPilot* pilot = rf_take( layout, 1, sizeof *pilot );
    RfHitBatch* batch = rf_place_batch( shape, layout );
    RfHarvestScratch* scratch = rf_place_harvest_scratch( shape, layout );
    if ( pilot != NULL )
        *pilot = ( RfPilot ){ .group = *group, .settings = *group->settings, .batch = batch, .scratch = scratch };
    RF_PLACE( layout, pilot->first, MOST_JOBS );
    RF_PLACE( layout, pilot->other, MOST_JOBS );
    return pilot;
}

static float lane_luminance( float ( *light )[RF_LANES], int i ) { return rf_luminance( RF_GET3( light, i ) ); }

// Traces the batches, `count` of `all`, evenly spread over the frames.
static void trace( RfPilot* pilot, const RfLightPaths* paths, int pass, int count, int all, Found* found, RfRayCounts* rays )
{
    RfHarvestScratch* s = pilot->scratch;
    pilot->group.shared = paths;
    for ( int k = 0; k < count; ++k )
    {
        RfRayCounts now = { 0 };
        int at = (int)( ( (int64_t)2 * k + 1 ) * all / ( 2 * count ) ), jobs = all / pilot->group.eye_count;
        s->connections->all_rays = s->connections->searched = 0;
        memset( s->connections->moment, 0, sizeof s->connections->moment );
        memset( s->connections->chance, 0, sizeof s->connections->chance );
        rf_clear_ray_counts( &s->wavefront );
        rf_harvest_batch( &pilot->group, ( RfTraceJob ){ .eye = at / jobs, .job = at % jobs, .pass = pass }, pilot->batch, s,
                          &now );
        memset( found[k].is_hit, 0, sizeof found[k].is_hit );
        found[k].hits = rf_record_count( s->hits );
        for ( int i = 0; i < found[k].hits; ++i )
        {
            int slot = s->hits->slot[i];
            found[k].is_hit[slot] = true;
            found[k].light[slot] = s->wavefront.lit[i] + RF_PI * lane_luminance( s->wavefront.arrivals.rest, slot ) +
                                   lane_luminance( s->connections->light, i );
        }
        pilot->rays += now.primary + now.path + now.shadow + now.tile + now.eye;
        memcpy( found[k].moment, s->connections->moment, sizeof found[k].moment );
        memcpy( found[k].chance, s->connections->chance, sizeof found[k].chance );
        pilot->connection_rays += s->connections->all_rays;
        pilot->searched += s->connections->searched;
        rays->primary += now.primary;
        rays->path += now.path;
        rays->shadow += now.shadow;
        rays->tile += now.tile;
        rays->eye += now.eye;
    }
}

// Two samples of a batch: half the mean square of their difference, and the square of their mean.
typedef struct Pair
{
    double error, square;
    int count;
} Pair;

static Pair compare( const Found* a, const Found* b )
{
    double squares = 0.0, sum = 0.0;
    int count = 0;
    for ( int i = 0; i < RF_LANES; ++i )
    {
        if ( !a->is_hit[i] || !b->is_hit[i] )
            continue;
        double apart = (double)a->light[i] - (double)b->light[i];
        squares += 0.5 * apart * apart;
        sum += 0.5 * ( (double)a->light[i] + (double)b->light[i] );
        count += 1;
    }
    return count > 0 ? ( Pair ){ squares / count, sum / count * sum / count, count } : ( Pair ){ 0.0, 0.0, 0 };
}

// Caps the moment of scattered rays alone (moment 0 of each batch) where fewer than one ray of a picture brings more: most
// pictures lack such light, and few have the firefly that stands for it. `samples`: of a picture.
static void cap_chance( RfPilot* pilot, int count, double samples )
{
    double lanes = 0.0, rays = 0.0;
    int cap = RF_CHANCE_OCTAVES;
    for ( int k = 0; k < count; ++k )
        lanes += pilot->first[k].hits + pilot->other[k].hits;
    while ( cap > 0 && lanes > 0.0 && rays * samples / lanes < 1.0 )
    {
        cap -= 1;
        for ( int k = 0; k < count; ++k )
            rays += pilot->first[k].chance[cap].rays + pilot->other[k].chance[cap].rays;
    }
    double most = ldexp( 1.0, cap + RF_FIRST_OCTAVE + 1 );
    for ( int k = 0; k < 2 * count; ++k )
    {
        Found* f = k < count ? pilot->first + k : pilot->other + k - count;
        f->moment[0] = 0.0;
        for ( int o = 0; o < RF_CHANCE_OCTAVES; ++o )
            f->moment[0] += fmin( f->chance[o].square, most * most * f->chance[o].rays );
    }
}

// The relative error of all light, averaged over the batches, and its part that light of connections has with each share.
static double find_errors( const RfPilot* pilot, int count, double* moment )
{
    Pair pair[MOST_JOBS];
    double square = 0.0, all = 0.0;
    for ( int k = 0; k < count; ++k )
    {
        pair[k] = compare( pilot->first + k, pilot->other + k );
        square += LEAST_MEAN * pair[k].square / count;
    }
    for ( int k = 0; k < count && square > 0.0; ++k )
    {
        double scale = 1.0 / ( pair[k].square + square );
        all += pair[k].error * scale;
        for ( int s = 0; s < RF_CONNECTION_SHARES && pair[k].count > 0; ++s )
            moment[s] += 0.5 * ( pilot->first[k].moment[s] + pilot->other[k].moment[s] ) / pair[k].count * scale;
    }
    return all;
}

// The first of rf_connection_shares that may be chosen. Light that nothing else finds needs more than the least, or it shows as
// fireflies.
static int least_share( const RfEstimatorGroup* group, const RfLightPaths* paths )
{
    for ( uint32_t i = 0; i < paths->light_count; ++i )
    {
        if ( rf_needs_light_paths( rf_light_kind( rf_tracer_lights( group->tracer ), paths->light[i] ) ) )
            return LEAST_NEEDED;
    }
    return 1;
}

// In rays, for the batches that were traced ahead.
typedef struct Costs
{
    double per_share, search; // connections, if all are made; finding the light paths near a vertex
    double rest;              // other light
} Costs;

// The share with the least error times cost.
static float best_share( const double* moment, double error, const Costs* costs, int first )
{
    double rest = fmax( error - moment[AT_AHEAD], LEAST_REST * error ), least = INFINITY;
    int best = first;
    for ( int k = first; k < RF_CONNECTION_SHARES; ++k )
    {
        double cost = costs->rest + costs->search + (double)rf_connection_shares[k] * costs->per_share;
        double product = ( rest + moment[k] ) * cost;
        if ( !( product < least ) )
            continue;
        least = product;
        best = k;
    }
    return rf_connection_shares[best];
}

void rf_choose_connection_share( const RfEstimatorGroup* group, RfLightPaths* paths, RfPilot* pilot, RfRayCounts* rays )
{
    pilot->settings.pieces = NULL; // whole frames decide for all of their parts
    pilot->group.settings = &pilot->settings;
    pilot->group.need = NULL;
    int all = rf_reuse_plan( group )->patches.count * group->eye_count, count = (int)fmax( AHEAD * all, LEAST_JOBS );
    count = count > MOST_JOBS ? MOST_JOBS : count > all ? all : count;
    const RfNormalization* normalization = rf_find_normalization( group->settings->kernel_normalization );
    paths->balls = normalization->balls;
    paths->measures = normalization->weighted;
    paths->share = paths->measures ? rf_connection_shares[AT_AHEAD] : 1.0f;
    if ( !paths->measures )
        return;
    rf_draw_light_paths( group, PASS, paths );
    rays->path += paths->rays;
    trace( pilot, paths, PASS, count, all, pilot->first, rays );
    trace( pilot, paths, PASS + 1, count, all, pilot->other, rays );
    paths->measures = false;
    cap_chance( pilot, count, (double)group->settings->spp * group->width * group->height * group->eye_count );
    double moment[RF_CONNECTION_SHARES] = { 0.0 }, error = find_errors( pilot, count, moment );
    double connections = (double)pilot->connection_rays + 2.0 * (double)paths->rays * count / all;
    Costs costs = { LINK_RAY * connections / (double)paths->share, SEARCH * (double)pilot->searched,
                    (double)( pilot->rays - pilot->connection_rays ) };
    paths->share = best_share( moment, error, &costs, least_share( group, paths ) );
}
