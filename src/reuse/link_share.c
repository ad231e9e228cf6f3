#include "reuse/link_share.h"

#include "reuse/harvest_internal.h"

#include <limits.h>
#include <string.h>

#define MOST_JOBS 8
#define LEAST_SHARE 0.03     // a caustic may lie where no batch of these looks
#define PASS ( INT_MAX - 2 ) // and the next: their random numbers are no other pass's

// Irradiance found at each hit by a batch, by slot; negative: there is none.
typedef struct Found
{
    float light[RF_LANES];
} Found;

typedef struct Pilot
{
    RfEstimatorGroup group;
    RfRenderSettings settings;
    RfHitBatch* batch;
    RfHarvestScratch* scratch;
    Found *first, *other_paths, *other_pass; // by batch
    uint64_t rays, link_rays;
} Pilot;

static size_t aligned( size_t bytes ) { return ( bytes + 63 ) / 64 * 64; }

size_t rf_link_share_bytes( const RfEstimatorGroup* group )
{
    RfBatchShape shape = rf_batch_shape( group );
    return aligned( sizeof( Pilot ) ) + aligned( sizeof( RfHitBatch ) ) + aligned( rf_batch_bytes( &shape ) ) +
           aligned( rf_harvest_scratch_bytes( &shape ) ) + 3 * MOST_JOBS * aligned( sizeof( Found ) );
}

static Pilot* lay_out( const RfEstimatorGroup* group, void* memory )
{
    char* at = memory;
    Pilot* pilot = memory;
    RfBatchShape shape = rf_batch_shape( group );
    *pilot = ( Pilot ){ .group = *group, .settings = *group->settings };
    pilot->settings.pieces = NULL; // whole frames decide for all of their parts
    pilot->group.settings = &pilot->settings;
    pilot->group.need = NULL;
    at += aligned( sizeof *pilot );
    pilot->batch = (RfHitBatch*)(void*)at;
    *pilot->batch = rf_lay_out_batch( &shape, at + aligned( sizeof( RfHitBatch ) ) );
    at += aligned( sizeof( RfHitBatch ) ) + aligned( rf_batch_bytes( &shape ) );
    pilot->scratch = rf_lay_out_harvest_scratch( &shape, at );
    at += aligned( rf_harvest_scratch_bytes( &shape ) );
    pilot->first = (Found*)(void*)at;
    pilot->other_paths = (Found*)(void*)( at + MOST_JOBS * aligned( sizeof( Found ) ) );
    pilot->other_pass = (Found*)(void*)( at + 2 * MOST_JOBS * aligned( sizeof( Found ) ) );
    return pilot;
}

static float luminance_of( float ( *light )[RF_LANES], int i )
{
    return rf_luminance( rf_vec3( light[0][i], light[1][i], light[2][i] ) );
}

// Traces the batches, `count` of `all`, evenly spread over the frames.
static void trace( Pilot* pilot, const RfLightPaths* paths, int pass, int count, int all, Found* found, RfRayCounts* rays )
{
    RfHarvestScratch* s = pilot->scratch;
    pilot->group.shared = paths;
    RfHarvest harvest = rf_make_harvest( &pilot->group );
    for ( int k = 0; k < count; ++k )
    {
        RfRayCounts now = { 0 };
        int at = (int)( ( (int64_t)2 * k + 1 ) * all / ( 2 * count ) ), jobs = all / pilot->group.eye_count;
        s->links->all_rays = 0;
        s->wavefront.path_rays = s->wavefront.shadow_rays = 0;
        rf_harvest_batch( &harvest, ( RfTraceJob ){ .eye = at / jobs, .job = at % jobs, .pass = pass }, pilot->batch, s, &now );
        for ( int i = 0; i < RF_LANES; ++i )
            found[k].light[i] = -1.0f;
        for ( int i = 0; i < rf_record_count( s->hits ); ++i )
        {
            int slot = s->hits->slot[i];
            found[k].light[slot] = s->wavefront.lit[i] + RF_PI * luminance_of( s->wavefront.arrivals.rest, slot ) +
                                   luminance_of( s->links->light, i );
        }
        pilot->rays += now.primary + now.path + now.shadow + now.tile + now.eye;
        pilot->link_rays += s->links->all_rays;
        rays->primary += now.primary;
        rays->path += now.path;
        rays->shadow += now.shadow;
        rays->tile += now.tile;
        rays->eye += now.eye;
    }
}

// Half the mean square of the difference of two samples, over the square of their mean.
static double variance( const Found* a, const Found* b )
{
    double squares = 0.0, sum = 0.0;
    int count = 0;
    for ( int i = 0; i < RF_LANES; ++i )
    {
        if ( a->light[i] < 0.0f || b->light[i] < 0.0f )
            continue;
        double apart = (double)a->light[i] - (double)b->light[i];
        squares += 0.5 * apart * apart;
        sum += 0.5 * ( (double)a->light[i] + (double)b->light[i] );
        count += 1;
    }
    return sum > 0.0 ? squares * count / ( sum * sum ) : 0.0;
}

// Variance V/s + W and cost s C + D are least together at s = sqrt( V D / ( W C ) ).
static double best_share( double links, double all, double link_cost, double rest_cost )
{
    double rest = fmax( all - links, 0.0 );
    if ( !( rest > 0.0 ) )
        return 1.0;
    return fmin( fmax( sqrt( links * rest_cost / ( rest * fmax( link_cost, 1.0 ) ) ), LEAST_SHARE ), 1.0 );
}

void rf_choose_link_share( const RfEstimatorGroup* group, RfLightPaths* paths, void* memory, RfRayCounts* rays )
{
    Pilot* pilot = lay_out( group, memory );
    RfHarvest harvest = rf_make_harvest( group );
    int all = harvest.patches.count * group->eye_count, count = all / 3 < 1 ? 1 : all / 3 < MOST_JOBS ? all / 3 : MOST_JOBS;
    paths->share = 1.0f;
    rf_draw_light_paths( group, PASS + 1, paths );
    uint64_t drawn = paths->rays;
    trace( pilot, paths, PASS, count, all, pilot->other_paths, rays );
    rf_draw_light_paths( group, PASS, paths );
    rays->path += drawn + paths->rays;
    trace( pilot, paths, PASS, count, all, pilot->first, rays );
    trace( pilot, paths, PASS + 1, count, all, pilot->other_pass, rays );
    double links = 0.0, both = 0.0;
    for ( int k = 0; k < count; ++k )
    {
        links += variance( pilot->first + k, pilot->other_paths + k );
        both += variance( pilot->first + k, pilot->other_pass + k );
    }
    double link_rays = (double)pilot->link_rays + 3.0 * (double)paths->rays * count / all;
    paths->share = (float)best_share( links, both, link_rays, (double)( pilot->rays - pilot->link_rays ) );
}
