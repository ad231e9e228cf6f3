// AOVs: their names, and their sums while a frame is rendered.
#include "film/aov.h"

#include "base/words.h"
#include "path/features.h"
#include "scene/moments.h"
#include "scene/projection.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct Aov
{
    const char* name;
    const char* letters;
    bool half;
} Aov;

#define ROW( constant, name, letters, half, source, what ) { name, letters, half },
static const Aov s_aovs[RF_AOV_COUNT] = { RF_AOV_LIST( ROW ){ "alpha", "A", true } };
#undef ROW

#define NAME_BYTES( constant, name, letters, half, source, what ) +sizeof( name ) // with a comma or the end
_Static_assert( sizeof "alpha" RF_AOV_LIST( NAME_BYTES ) <= RF_AOVS_TEXT_SIZE, "all names fit" );
#undef NAME_BYTES

const char* rf_aov_name( RfAov aov ) { return s_aovs[aov].name; }

const char* rf_aov_letters( RfAov aov ) { return s_aovs[aov].letters; }

int rf_aov_channels( RfAov aov ) { return (int)strlen( s_aovs[aov].letters ); }

bool rf_aov_is_half( RfAov aov ) { return s_aovs[aov].half; }

RfResult rf_parse_aovs( const char* text, unsigned* aovs, RfError* error )
{
    const char* words[RF_AOV_ALPHA + 1] = { [RF_AOV_ALPHA] = RF_GRADIENT_AOVS_NAME };
    unsigned bits[RF_AOV_ALPHA + 1] = { [RF_AOV_ALPHA] = RF_GRADIENT_AOVS };
    char all[RF_AOVS_TEXT_SIZE];
    for ( int i = 0; i < RF_AOV_ALPHA; ++i )
    {
        words[i] = s_aovs[i].name;
        bits[i] = RF_AOV_BIT( i );
    }
    rf_format_aovs( RF_ALL_AOVS, all, sizeof all );
    return rf_parse_words( &( RfWordSet ){ "AOV", "AOV", all, words, bits, RF_AOV_ALPHA + 1 }, text, aovs, error );
}

void rf_format_aovs( unsigned aovs, char* text, size_t size )
{
    text[0] = '\0';
    for ( int i = 0; i < RF_AOV_COUNT; ++i )
    {
        if ( ( aovs & RF_AOV_BIT( i ) ) != 0 )
            rf_append( text, size, "%s%s", text[0] != '\0' ? "," : "", s_aovs[i].name );
    }
}

// Points farther off the film centre of another camera count as behind it, pixels.
#define FARTHEST_MOTION 1e6f

static bool is_filtered( RfAov aov ) { return ( RF_FILTERED_AOVS & RF_AOV_BIT( aov ) ) != 0; }

// A pixel of an AOV that is filtered.
typedef struct FilteredPixel
{
    float *sum, *weight; // over the passes so far
    float* value;        // of the pixel's sample in the pass that is traced
    float* place;        // of this sample in the pixel
} FilteredPixel;

static int filtered_floats( int channels ) { return 2 * channels + 3; }

static FilteredPixel filtered_pixel( float* pixels, int channels, int pixel )
{
    float* at = pixels + (size_t)pixel * (size_t)filtered_floats( channels );
    return ( FilteredPixel ){ at, at + channels, at + channels + 1, at + 2 * channels + 1 };
}

int rf_aov_film_floats( RfAov aov, bool filtered )
{
    int channels = rf_aov_channels( aov );
    if ( ( RF_FIRST_HIT_AOVS & RF_AOV_BIT( aov ) ) != 0 )
        return filtered && is_filtered( aov ) ? filtered_floats( channels ) : channels + ( aov == RF_AOV_DEPTH );
    return aov == RF_AOV_SAMPLES ? channels : aov == RF_AOV_ALPHA ? 2 : 0; // all others are made from films
}

static void clear_pixels( RfAovFilm* film, size_t first, size_t count )
{
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
    {
        size_t floats = (size_t)rf_aov_film_floats( (RfAov)l, film->filter != NULL );
        if ( film->mean[l] != NULL )
            memset( film->mean[l] + floats * first, 0, floats * count * sizeof( float ) );
    }
    if ( film->landed != NULL )
        memset( film->landed + first, 0, count * sizeof *film->landed );
}

void rf_clear_aov_film( RfAovFilm* film, int width, int height )
{
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < height; ++y )
    {
        rf_set_float_mode();
        clear_pixels( film, (size_t)y * (size_t)width, (size_t)width );
    }
}

// A point, or with `infinite` a direction.
typedef struct Seen
{
    RfVec3 point;
    bool infinite;
    const RfPlacement* moving; // what it lies on, of the job's scene; NULL: that stands still
    RfTriangleAt at;           // and where on it, with barycentrics
    float u, v;
} Seen;

// Where barycentrics of a triangle of `at` are in the world, on what a placement makes of it in a scene, in the middle of its
// shutter. The corners are those that the triangle has in the job's scene: deformation may turn it over, or take it out.
static void place( const RfScene* scene, const RfPlacement* placement, const RfTriangleAt* at, float u, float v, double out[3] )
{
    const double share[3] = { 1.0 - (double)u - (double)v, (double)u, (double)v };
    const uint32_t* corners = at->triangles->indices + 3 * (size_t)at->index;
    RfTriangles t = scene->meshes[placement->mesh].triangles;
    RfTriangleAt there = { &t, at->index, placement };
    RfBetween between;
    double sum[3] = { 0 };
    t.indices = at->triangles->indices;
    bool blurred = rf_is_between( scene, placement );
    if ( blurred )
        there = rf_triangle_between( scene, &there, &between );
    for ( int k = 0; k < 3; ++k )
    {
        const float* p = blurred ? between.positions + 3 * k : t.positions + 3 * (size_t)corners[k];
        for ( int c = 0; c < 3; ++c )
            sum[c] += share[k] * (double)p[c];
    }
    rf_mat4_apply( &there.placement->matrix, sum, 1.0, out );
}

// The same point of its surface at another frame; false where what it lies on is not shown there. By how much the surface has
// moved, so that what rests gets the same point.
static bool follow( const RfScene* scene, const RfScene* other, Seen* seen )
{
    if ( seen->moving == NULL )
        return true;
    const RfPlacement *own = seen->moving, *there = other->placements + ( own - scene->placements );
    double from[3], to[3];
    if ( !there->shown )
        return false;
    place( scene, own, &seen->at, seen->u, seen->v, from );
    place( other, there, &seen->at, seen->u, seen->v, to );
    seen->point =
        rf_add( seen->point, rf_vec3( (float)( to[0] - from[0] ), (float)( to[1] - from[1] ), (float)( to[2] - from[2] ) ) );
    return true;
}

// Where something is seen, pixels from the film's centre, +y up; false where it is behind the camera or far outside.
static bool film_position( const RfEye* eye, Seen seen, float at[2] )
{
    return rf_eye_position( eye, seen.point, seen.infinite, at ) && fabsf( at[0] ) < FARTHEST_MOTION &&
           fabsf( at[1] ) < FARTHEST_MOTION;
}

static void motion_of( const RfAovJob* job, Seen seen, float* value )
{
    float own[2], there[2];
    bool known = film_position( job->eye, seen, own );
    for ( int k = 0; k < 2; ++k )
    {
        Seen then = seen;
        bool moved = known && job->others[k] != NULL && follow( job->scene, job->scenes[k], &then ) &&
                     film_position( job->others[k], then, there );
        value[2 * k] = moved ? rf_film_difference( job->eye, there[0] - own[0] ) : 0.0f;
        value[2 * k + 1] = moved ? there[1] - own[1] : 0.0f;
    }
}

static void store( float* value, RfVec3 v )
{
    value[0] = v.x;
    value[1] = v.y;
    value[2] = v.z;
}

#define MOST_CHANNELS 4
#define CHANNELS_FIT( constant, name, letters, half, source, what ) &&sizeof( letters ) - 1 <= MOST_CHANNELS
_Static_assert( true RF_AOV_LIST( CHANNELS_FIT ), "channels of an AOV" );
#undef CHANNELS_FIT

static Seen seen_at( const RfAovJob* job, RfFirstHits first, int i )
{
    const RfVertexLanes* v = first.hits;
    Seen seen = { .point = RF_GET3( v->p, i ) };
    if ( job->scene == NULL || first.surfaces == NULL )
        return seen;
    int ray = v->ray[i];
    seen.at = rf_locate_triangle( job->scene, first.surfaces->triangle[ray] );
    seen.u = first.surfaces->u[ray];
    seen.v = first.surfaces->v[ray];
    bool moves = seen.at.placement != NULL && seen.at.placement - job->scene->placements >= job->scene->still_placement_count;
    seen.moving = moves ? seen.at.placement : NULL;
    double middle[3];
    if ( !rf_is_between( job->scene, seen.moving ) )
        return seen;
    place( job->scene, seen.moving, &seen.at, seen.u, seen.v, middle ); // not at the moment at which it was hit
    seen.point = rf_vec3( (float)middle[0], (float)middle[1], (float)middle[2] );
    return seen;
}

// An AOV where a camera ray hits. The switches over AOVs have no default, so that the compiler names those where a new row is
// missing.
static void value_at_hit( const RfAovJob* job, RfAov aov, RfFirstHits first, int i, float value[MOST_CHANNELS] )
{
    const RfVertexLanes* v = first.hits;
    RfVec3 p = RF_GET3( v->p, i );
    switch ( aov )
    {
        case RF_AOV_ALBEDO: store( value, rf_albedo_of_lane( v, i ) ); break;
        case RF_AOV_NORMAL: store( value, rf_seen_normal( v, i ) ); break;
        case RF_AOV_DEPTH: value[0] = rf_eye_depth( job->eye, p ); break;
        case RF_AOV_MOTION: motion_of( job, seen_at( job, first, i ), value ); break;
        case RF_AOV_DENOISE_ALBEDO: // of camera rays, whatever they hit
        case RF_AOV_DENOISE_NORMAL:
        case RF_AOV_OBJECT_INDEX: // not of hits
        case RF_AOV_MATERIAL_INDEX:
        case RF_AOV_REMOVED:
        RF_PASS_AOV_CASES:
        case RF_AOV_VARIANCE:
        case RF_AOV_HALF:
        case RF_AOV_SAMPLES:
        case RF_AOV_PRIMAL:
        case RF_AOV_DX:
        case RF_AOV_DY:
        case RF_AOV_ALPHA:
        case RF_AOV_COUNT: break;
    }
}

// And where it misses: nothing, but the motion is that of a point at infinity.
static void value_at_miss( const RfAovJob* job, RfAov aov, const RfRayLanes* rays, int slot, float value[MOST_CHANNELS] )
{
    memset( value, 0, MOST_CHANNELS * sizeof *value );
    if ( aov == RF_AOV_MOTION )
    {
        RfVec3 d = RF_GET3( rays->d, slot );
        motion_of( job, ( Seen ){ .point = d, .infinite = true }, value );
    }
}

// A batch's first hits.
typedef struct Batch
{
    const RfAovJob* job;
    RfFirstHits first;
    int hit[RF_LANES]; // of each ray, by slot: the index of its hit, −1 for a miss
} Batch;

static void value_of( const Batch* b, RfAov aov, int slot, float value[MOST_CHANNELS] )
{
    const RfFeatures* features = b->first.features;
    if ( aov == RF_AOV_DENOISE_ALBEDO || aov == RF_AOV_DENOISE_NORMAL )
    {
        const float( *of )[RF_LANES] = aov == RF_AOV_DENOISE_ALBEDO ? features->albedo : features->normal;
        for ( int c = 0; c < 3; ++c )
            value[c] = of[c][slot];
    }
    else if ( b->hit[slot] >= 0 )
        value_at_hit( b->job, aov, b->first, b->hit[slot], value );
    else
        value_at_miss( b->job, aov, b->first.rays, slot, value );
}

// Adds to the running mean over all samples, of depth over the hits.
static void add_means( const Batch* b, RfAov aov )
{
    const RfAovJob* job = b->job;
    float share = job->weight / ( job->weight_before + job->weight ), value[MOST_CHANNELS] = { 0 };
    int channels = rf_aov_channels( aov ), floats = rf_aov_film_floats( aov, false );
    for ( int slot = 0; slot < b->first.rays->count; ++slot )
    {
        if ( b->first.pixel[slot] < 0 || ( aov == RF_AOV_DEPTH && b->hit[slot] < 0 ) )
            continue;
        float* mean = job->film->mean[aov] + (size_t)floats * (size_t)b->first.pixel[slot];
        if ( aov == RF_AOV_DEPTH )
        {
            mean[1] += job->weight;
            share = job->weight / mean[1];
        }
        value_of( b, aov, slot, value );
        for ( int c = 0; c < channels; ++c )
            mean[c] += ( value[c] - mean[c] ) * share;
    }
}

// Keeps the samples of an AOV that is spread when the pass is complete.
static void set_samples( const Batch* b, RfAov aov )
{
    int channels = rf_aov_channels( aov );
    for ( int slot = 0; slot < b->first.rays->count; ++slot )
    {
        if ( b->first.pixel[slot] < 0 )
            continue;
        FilteredPixel p = filtered_pixel( b->job->film->mean[aov], channels, b->first.pixel[slot] );
        p.place[0] = b->first.place[0][slot];
        p.place[1] = b->first.place[1][slot];
        float value[MOST_CHANNELS] = { 0 };
        value_of( b, aov, slot, value );
        memcpy( p.value, value, (size_t)channels * sizeof *value );
    }
}

void rf_add_to_aovs( const RfAovJob* job, RfFirstHits first )
{
    Batch b = { .job = job, .first = first };
    memset( b.hit, -1, sizeof b.hit );
    for ( int i = 0; i < first.hits->count; ++i )
        b.hit[first.hits->slot[i]] = i;
    for ( RfAov aov = 0; aov < RF_AOV_COUNT; ++aov )
    {
        if ( job->film->mean[aov] == NULL || ( RF_FIRST_HIT_AOVS & RF_AOV_BIT( aov ) ) == 0 )
            continue;
        if ( rf_has_filter( job->film->filter ) && is_filtered( aov ) )
            set_samples( &b, aov );
        else
            add_means( &b, aov );
    }
}

// What all samples of a pass are spread with.
typedef struct Spread
{
    const RfPixelFilter* filter;
    float* pixels; // of an AOV
    int channels, width, height;
    float weight;           // of the pass
    int first_row, end_row; // that get something
} Spread;

static void spread_sample( const Spread* s, int x, int y )
{
    const RfPixelFilter* filter = s->filter;
    FilteredPixel sample = filtered_pixel( s->pixels, s->channels, y * s->width + x );
    float across[RF_FILTER_TAPS], down[RF_FILTER_TAPS];
    rf_filter_weights( filter, x, sample.place[0], s->width, across );
    rf_filter_weights( filter, y, sample.place[1], s->height, down );
    for ( int k = 0; k < filter->taps * filter->taps; ++k )
    {
        int column = k % filter->taps, row = k / filter->taps, px = x + column - filter->reach, py = y + row - filter->reach;
        if ( px < 0 || px >= s->width || py < s->first_row || py >= s->end_row )
            continue;
        FilteredPixel p = filtered_pixel( s->pixels, s->channels, py * s->width + px );
        float share = s->weight * across[column] * down[row];
        *p.weight += share;
        for ( int c = 0; c < s->channels; ++c )
            p.sum[c] += share * sample.value[c];
    }
}

void rf_spread_aovs( const RfAovFilm* film, int width, int height, float weight, int first_row, int end_row )
{
    Spread s = {
        .filter = film->filter, .width = width, .height = height, .weight = weight, .first_row = first_row, .end_row = end_row
    };
    int reach = film->filter->reach, top = first_row > reach ? first_row - reach : 0;
    int bottom = end_row + reach < height ? end_row + reach : height;
    for ( RfAov aov = 0; aov < RF_AOV_COUNT; ++aov )
    {
        s.pixels = film->mean[aov];
        s.channels = rf_aov_channels( aov );
        for ( int y = top; y < bottom && s.pixels != NULL && is_filtered( aov ); ++y )
        {
            for ( int x = 0; x < width; ++x )
                spread_sample( &s, x, y );
        }
    }
}

// Divided by the sum of the weights: a constant stays one.
static void finish_filtered( float* pixels, int channels, int count, float* image )
{
#pragma omp parallel
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( int i = 0; i < count; ++i )
        {
            FilteredPixel p = filtered_pixel( pixels, channels, i );
            for ( int c = 0; c < channels; ++c )
                image[(size_t)i * (size_t)channels + (size_t)c] = *p.weight > 0.0f ? p.sum[c] / *p.weight : 0.0f;
        }
    }
}

// Pixels [first, end) of what is asked for as it is kept, or nearly so.
static void finish_pixels( const RfAovFilm* film, RfAov aov, size_t first, size_t end, float* image )
{
    const float* mean = film->mean[aov];
    size_t channels = (size_t)rf_aov_channels( aov );
    if ( aov != RF_AOV_SAMPLES && aov != RF_AOV_DEPTH )
        memcpy( image + channels * first, mean + channels * first, channels * ( end - first ) * sizeof *image );
    for ( size_t i = first; i < end && aov == RF_AOV_SAMPLES; ++i )
        image[i] = (float)film->landed[i];
    for ( size_t i = first; i < end && aov == RF_AOV_DEPTH; ++i )
        image[i] = mean[2 * i + 1] > 0.0f ? mean[2 * i] : RF_DEPTH_OF_NOTHING;
}

static void finish_rows( const RfAovFilm* film, RfAov aov, int width, int height, float* image )
{
#pragma omp parallel for schedule( static )
    for ( int y = 0; y < height; ++y )
    {
        rf_set_float_mode();
        finish_pixels( film, aov, (size_t)y * (size_t)width, ( (size_t)y + 1 ) * (size_t)width, image );
    }
}

void rf_finish_aov( const RfAovFilm* film, RfAov aov, const RfFilm* colour, RfNormalize normalize, float* image )
{
    if ( rf_has_filter( film->filter ) && is_filtered( aov ) )
    {
        finish_filtered( film->mean[aov], rf_aov_channels( aov ), colour->width * colour->height, image );
        return;
    }
    switch ( aov )
    {
        case RF_AOV_VARIANCE: rf_estimate_variance( colour, normalize, image ); break;
        case RF_AOV_HALF: rf_combine_half( colour, normalize, image ); break;
        case RF_AOV_REMOVED: rf_combine_part( colour, colour + 1, normalize, image ); break;
        case RF_AOV_PRIMAL: rf_combine_film( colour, RF_NORMALIZE_RATIO, image, NULL ); break;
        case RF_AOV_DX:
        case RF_AOV_DY:
            rf_combine_film( colour + ( aov - RF_AOV_PRIMAL ), RF_NORMALIZE_RATIO, image, NULL );
            rf_add_film_steps( colour + RF_UNSHARED_FILM, 0, 1, aov == RF_AOV_DY, image );
            break;
        case RF_AOV_ALPHA: rf_combine_alpha( colour, normalize, film->mean[aov], image ); break;
        case RF_AOV_SAMPLES:
        case RF_AOV_DEPTH:
        case RF_AOV_ALBEDO:
        case RF_AOV_NORMAL:
        case RF_AOV_DENOISE_ALBEDO:
        case RF_AOV_DENOISE_NORMAL:
        case RF_AOV_MOTION: finish_rows( film, aov, colour->width, colour->height, image ); break;
        case RF_AOV_OBJECT_INDEX: // rf_finish_index
        case RF_AOV_MATERIAL_INDEX:
        RF_PASS_AOV_CASES: // rf_combine_part makes them
        case RF_AOV_COUNT: break;
    }
}
