#include "film/aov_film.h"

#include "scene/pinhole.h"

#include <math.h>
#include <string.h>

// Points farther off the film centre of another eye count as behind it, pixels.
#define FARTHEST_MOTION 1e6f

int rf_aov_film_floats( RfAov aov )
{
    switch ( aov )
    {
        case RF_AOV_VARIANCE: // made from the films of the colour
        case RF_AOV_PRIMAL:
        case RF_AOV_DX:
        case RF_AOV_DY: return 0;
        case RF_AOV_DEPTH:
        case RF_AOV_ALPHA: return 2;
        default: return rf_aov_channels( aov );
    }
}

void rf_clear_aov_film( RfAovFilm* film, int width, int height )
{
    size_t pixels = (size_t)width * (size_t)height;
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
    {
        if ( film->mean[l] != NULL )
            memset( film->mean[l], 0, pixels * (size_t)rf_aov_film_floats( (RfAov)l ) * sizeof( float ) );
    }
    if ( film->landed != NULL )
        memset( film->landed, 0, pixels * sizeof *film->landed );
}

// Updates a running mean with a value whose share of the total weight is `share`.
static inline void add_to_mean( float* mean, float value, float share ) { *mean += ( value - *mean ) * share; }

static inline void add_vector( float* mean, RfVec3 value, float share )
{
    add_to_mean( mean + 0, value.x, share );
    add_to_mean( mean + 1, value.y, share );
    add_to_mean( mean + 2, value.z, share );
}

// Where a direction from the eye meets the film, pixels from its centre, +y up; false where it
// points backwards or far outside.
static bool film_position( const RfEye* eye, RfVec3 direction, float at[2] )
{
    float depth = rf_pinhole_position( eye, direction, at );
    return depth > 0.0f && fabsf( at[0] ) < FARTHEST_MOTION && fabsf( at[1] ) < FARTHEST_MOTION;
}

// A point, or with `infinite` a direction.
typedef struct Seen
{
    RfVec3 point;
    bool infinite;
} Seen;

static RfVec3 direction_to( const RfEye* eye, Seen seen )
{
    return seen.infinite ? seen.point : rf_sub( seen.point, rf_pinhole_origin( eye ) );
}

static void add_motion( const RfAovJob* job, float* mean, Seen seen, float share )
{
    const RfEye* others[2] = { job->previous, job->next };
    float own[2], there[2];
    bool known = film_position( job->eye, direction_to( job->eye, seen ), own );
    for ( int k = 0; k < 2; ++k )
    {
        bool moved = known && others[k] != NULL && film_position( others[k], direction_to( others[k], seen ), there );
        for ( int c = 0; c < 2; ++c )
            add_to_mean( mean + 2 * k + c, moved ? there[c] - own[c] : 0.0f, share );
    }
}

static RfVec3 colour_param( const RfVertexLanes* v, uint32_t params, RfBsdfParam param, int i )
{
    return rf_has_param( params, param ) ? rf_vec3( v->param[param][i], v->param[param + 1][i], v->param[param + 2][i] )
                                         : rf_vec3( 0, 0, 0 );
}

// Reflectance at normal incidence: the coat of a dielectric reflects before its
// base does. Transmission counts as well: glass is as bright as what is behind it.
static RfVec3 albedo_of( const RfVertexLanes* v, int i )
{
    int kind = 0;
    while ( i >= v->first[kind + 1] )
        ++kind;
    uint32_t params = rf_bsdf_model( (RfBsdfKind)kind )->params;
    RfVec3 diffuse = colour_param( v, params, RF_PARAM_DIFFUSE, i );
    RfVec3 specular = colour_param( v, params, RF_PARAM_SPECULAR, i );
    RfVec3 tint = colour_param( v, params, RF_PARAM_TINT, i );
    float to_base = rf_has_param( params, RF_PARAM_COAT_F0 ) ? 1.0f - v->param[RF_PARAM_COAT_F0][i] : 1.0f;
    return rf_add( rf_madd( specular, diffuse, to_base ), tint );
}

static void add_hit( const RfAovJob* job, const RfVertexLanes* v, int i, size_t pixel, float share )
{
    float* const* mean = job->film->mean;
    RfVec3 p = rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] );
    if ( mean[RF_AOV_ALBEDO] != NULL )
        add_vector( mean[RF_AOV_ALBEDO] + 3 * pixel, albedo_of( v, i ), share );
    if ( mean[RF_AOV_NORMAL] != NULL )
        add_vector( mean[RF_AOV_NORMAL] + 3 * pixel, rf_vec3( v->n[0][i], v->n[1][i], v->n[2][i] ), share );
    if ( mean[RF_AOV_DEPTH] != NULL )
    {
        float* depth = mean[RF_AOV_DEPTH] + 2 * pixel;
        depth[1] += job->weight;
        add_to_mean( depth, rf_pinhole_depth( job->eye, p ), job->weight / depth[1] );
    }
    if ( mean[RF_AOV_MOTION] != NULL )
        add_motion( job, mean[RF_AOV_MOTION] + 4 * pixel, ( Seen ){ p, false }, share );
}

// A miss has no albedo, normal or depth; its motion is that of a point at infinity.
static void add_miss( const RfAovJob* job, const RfRayLanes* rays, int slot, size_t pixel, float share )
{
    float* const* mean = job->film->mean;
    RfVec3 d = rf_vec3( rays->d[0][slot], rays->d[1][slot], rays->d[2][slot] );
    if ( mean[RF_AOV_ALBEDO] != NULL )
        add_vector( mean[RF_AOV_ALBEDO] + 3 * pixel, rf_vec3( 0, 0, 0 ), share );
    if ( mean[RF_AOV_NORMAL] != NULL )
        add_vector( mean[RF_AOV_NORMAL] + 3 * pixel, rf_vec3( 0, 0, 0 ), share );
    if ( mean[RF_AOV_MOTION] != NULL )
        add_motion( job, mean[RF_AOV_MOTION] + 4 * pixel, ( Seen ){ d, true }, share );
}

void rf_add_to_aovs( const RfAovJob* job, RfFirstHits first )
{
    const RfVertexLanes* v = first.hits;
    float share = job->weight / ( job->weight_before + job->weight );
    uint8_t hit[RF_LANES] = { 0 };
    for ( int i = 0; i < v->count; ++i )
    {
        int slot = v->slot[i];
        hit[slot] = 1;
        add_hit( job, v, i, (size_t)first.pixel[slot], share );
    }
    for ( int slot = 0; slot < first.rays->count; ++slot )
    {
        if ( !hit[slot] )
            add_miss( job, first.rays, slot, (size_t)first.pixel[slot], share );
    }
}

void rf_finish_aov( const RfAovFilm* film, RfAov aov, const RfFilm* colour, RfFilmCombine combine, float* image )
{
    size_t pixels = (size_t)colour->width * (size_t)colour->height;
    const float* mean = film->mean[aov];
    switch ( aov )
    {
        case RF_AOV_VARIANCE: rf_estimate_variance( colour, combine, image ); break;
        case RF_AOV_PRIMAL:
        case RF_AOV_DX:
        case RF_AOV_DY: rf_combine_film( colour + ( aov - RF_AOV_PRIMAL ), RF_FILM_RATIO, image, NULL ); break;
        case RF_AOV_ALPHA: rf_combine_alpha( colour, combine, mean, image ); break;
        case RF_AOV_SAMPLES:
            for ( size_t i = 0; i < pixels; ++i )
                image[i] = (float)film->landed[i];
            break;
        case RF_AOV_DEPTH:
            for ( size_t i = 0; i < pixels; ++i )
                image[i] = mean[2 * i + 1] > 0.0f ? mean[2 * i] : RF_DEPTH_OF_NOTHING;
            break;
        default: memcpy( image, mean, pixels * (size_t)rf_aov_channels( aov ) * sizeof( float ) );
    }
}
