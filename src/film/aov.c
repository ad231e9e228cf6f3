// AOVs: their names, and their sums while a frame is rendered.
#include "film/aov.h"

#include "base/built_in.h"
#include "base/words.h"
#include "scene/projection.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct Aov
{
    const char* name;
    const char* letters;
    bool half;
} Aov;

#define ROW( constant, name, letters, half, first_hit, what ) { name, letters, half },
static const Aov s_aovs[RF_AOV_COUNT] = { RF_AOV_LIST( ROW ){ "alpha", "A", true } };
#undef ROW

#define NAME_BYTES( constant, name, letters, half, first_hit, what ) +sizeof( name ) // with a comma or the end
_Static_assert( sizeof "alpha" RF_AOV_LIST( NAME_BYTES ) <= RF_AOVS_TEXT_SIZE, "all names fit" );
#undef NAME_BYTES

const char* rf_aov_name( RfAov aov ) { return s_aovs[aov].name; }

const char* rf_aov_letters( RfAov aov ) { return s_aovs[aov].letters; }

int rf_aov_channels( RfAov aov ) { return (int)strlen( s_aovs[aov].letters ); }

bool rf_aov_is_half( RfAov aov ) { return s_aovs[aov].half; }

static bool is_word( const char* name, const char* word, size_t length )
{
    return strlen( name ) == length && strncmp( name, word, length ) == 0;
}

// The AOVs called by `length` characters, 0 if there are none.
static unsigned find_aovs( const char* word, size_t length )
{
    if ( is_word( RF_GRADIENT_AOVS_NAME, word, length ) )
        return RF_GRADIENT_AOVS;
    for ( int i = 0; i < RF_AOV_ALPHA; ++i )
    {
        if ( is_word( rf_aov_name( (RfAov)i ), word, length ) )
            return RF_AOV_BIT( i );
    }
    return 0;
}

static RfResult fail_unknown( const char* word, size_t length, RfError* error )
{
    const char* names[RF_AOV_ALPHA + 1] = { [RF_AOV_ALPHA] = RF_GRADIENT_AOVS_NAME };
    for ( int i = 0; i < RF_AOV_ALPHA; ++i )
        names[i] = rf_aov_name( (RfAov)i );
    char copy[32], all[RF_AOVS_TEXT_SIZE];
    snprintf( copy, sizeof copy, "%.*s", (int)( length < 31 ? length : 31 ), word );
    const char* nearest = length > 0 ? rf_nearest_word( copy, names, RF_AOV_ALPHA + 1 ) : NULL;
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "'%s' is no AOV, did you mean %s?", copy, nearest );
    rf_format_aovs( RF_ALL_AOVS, all, sizeof all );
    return rf_fail( error, RF_ERROR_USAGE, "'%s' is no AOV, there are %s", copy, all );
}

RfResult rf_parse_aovs( const char* text, unsigned* aovs, RfError* error )
{
    *aovs = 0;
    while ( text != NULL )
    {
        size_t length = strcspn( text, "," );
        unsigned found = find_aovs( text, length );
        if ( found == 0 )
            return fail_unknown( text, length, error );
        for ( int i = 0; i < RF_AOV_ALPHA; ++i )
        {
            if ( ( *aovs & found & RF_AOV_BIT( i ) ) != 0 )
                return rf_fail( error, RF_ERROR_USAGE, "AOV %s is given twice", rf_aov_name( (RfAov)i ) );
        }
        *aovs |= found;
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}

void rf_format_aovs( unsigned aovs, char* text, size_t size )
{
    size_t used = 0;
    text[0] = '\0';
    for ( int i = 0; i < RF_AOV_COUNT && used < size; ++i )
    {
        if ( ( aovs & RF_AOV_BIT( i ) ) != 0 )
            used += (size_t)snprintf( text + used, size - used, "%s%s", used > 0 ? "," : "", rf_aov_name( (RfAov)i ) );
    }
}

// Points farther off the film centre of another eye count as behind it, pixels.
#define FARTHEST_MOTION 1e6f

// A pixel of an AOV that is filtered.
typedef struct FilteredPixel
{
    float sum[3], weight; // over the passes so far
    float value[3];       // of the pixel's sample in the pass that is traced
    float place[2];       // of this sample in the pixel
} FilteredPixel;

#define FILTERED_FLOATS ( (int)( sizeof( FilteredPixel ) / sizeof( float ) ) )

static bool is_filtered( RfAov aov ) { return ( RF_FILTERED_AOVS & RF_AOV_BIT( aov ) ) != 0; }

static FilteredPixel* filtered_pixels( const RfAovFilm* film, RfAov aov ) { return (FilteredPixel*)(void*)film->mean[aov]; }

int rf_aov_film_floats( RfAov aov, bool filtered )
{
    if ( filtered && is_filtered( aov ) )
        return FILTERED_FLOATS;
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
            memset( film->mean[l], 0, pixels * (size_t)rf_aov_film_floats( (RfAov)l, film->filter != NULL ) * sizeof( float ) );
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

// A point, or with `infinite` a direction.
typedef struct Seen
{
    RfVec3 point;
    bool infinite;
} Seen;

// Where something is seen, pixels from the film's centre, +y up; false where it is behind the eye or far outside.
static bool film_position( const RfEye* eye, Seen seen, float at[2] )
{
    return rf_eye_position( eye, seen.point, seen.infinite, at ) && fabsf( at[0] ) < FARTHEST_MOTION &&
           fabsf( at[1] ) < FARTHEST_MOTION;
}

static void add_motion( const RfAovJob* job, float* mean, Seen seen, float share )
{
    const RfEye* others[2] = { job->previous, job->next };
    float own[2], there[2];
    bool known = film_position( job->eye, seen, own );
    for ( int k = 0; k < 2; ++k )
    {
        bool moved = known && others[k] != NULL && film_position( others[k], seen, there );
        add_to_mean( mean + 2 * k, moved ? rf_film_difference( job->eye, there[0] - own[0] ) : 0.0f, share );
        add_to_mean( mean + 2 * k + 1, moved ? there[1] - own[1] : 0.0f, share );
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
    bool plain = !rf_has_filter( job->film->filter );
    if ( plain && rf_calls_for( mean[RF_AOV_ALBEDO] != NULL, RF_EFFECT_AOV_ALBEDO ) )
        add_vector( mean[RF_AOV_ALBEDO] + 3 * pixel, albedo_of( v, i ), share );
    if ( plain && rf_calls_for( mean[RF_AOV_NORMAL] != NULL, RF_EFFECT_AOV_NORMAL ) )
        add_vector( mean[RF_AOV_NORMAL] + 3 * pixel, rf_vec3( v->n[0][i], v->n[1][i], v->n[2][i] ), share );
    if ( rf_calls_for( mean[RF_AOV_DEPTH] != NULL, RF_EFFECT_AOV_DEPTH ) )
    {
        float* depth = mean[RF_AOV_DEPTH] + 2 * pixel;
        depth[1] += job->weight;
        add_to_mean( depth, rf_eye_depth( job->eye, p ), job->weight / depth[1] );
    }
    if ( rf_calls_for( mean[RF_AOV_MOTION] != NULL, RF_EFFECT_AOV_MOTION ) )
        add_motion( job, mean[RF_AOV_MOTION] + 4 * pixel, ( Seen ){ p, false }, share );
}

static void set_sample( const RfAovFilm* film, RfAov aov, size_t pixel, const float place[2], RfVec3 value )
{
    if ( film->mean[aov] == NULL )
        return;
    FilteredPixel* p = filtered_pixels( film, aov ) + pixel;
    p->value[0] = value.x;
    p->value[1] = value.y;
    p->value[2] = value.z;
    p->place[0] = place[0];
    p->place[1] = place[1];
}

// Samples of AOVs that are spread when the pass is complete; misses have no hit, and 0.
static void set_samples( const RfAovJob* job, RfFirstHits first, const uint8_t* hit )
{
    const RfVertexLanes* v = first.hits;
    for ( int i = 0; i < v->count; ++i )
    {
        int slot = v->slot[i];
        float place[2] = { first.place[0][slot], first.place[1][slot] };
        size_t pixel = (size_t)first.pixel[slot];
        set_sample( job->film, RF_AOV_ALBEDO, pixel, place, albedo_of( v, i ) );
        set_sample( job->film, RF_AOV_NORMAL, pixel, place, rf_vec3( v->n[0][i], v->n[1][i], v->n[2][i] ) );
    }
    for ( int slot = 0; slot < first.rays->count; ++slot )
    {
        float place[2] = { first.place[0][slot], first.place[1][slot] };
        for ( RfAov aov = RF_AOV_ALBEDO; aov <= RF_AOV_NORMAL && !hit[slot]; ++aov )
            set_sample( job->film, aov, (size_t)first.pixel[slot], place, rf_vec3( 0, 0, 0 ) );
    }
}

// A miss has no albedo, normal or depth; its motion is that of a point at infinity.
static void add_miss( const RfAovJob* job, const RfRayLanes* rays, int slot, size_t pixel, float share )
{
    float* const* mean = job->film->mean;
    RfVec3 d = rf_vec3( rays->d[0][slot], rays->d[1][slot], rays->d[2][slot] );
    bool plain = !rf_has_filter( job->film->filter );
    if ( plain && rf_calls_for( mean[RF_AOV_ALBEDO] != NULL, RF_EFFECT_AOV_ALBEDO ) )
        add_vector( mean[RF_AOV_ALBEDO] + 3 * pixel, rf_vec3( 0, 0, 0 ), share );
    if ( plain && rf_calls_for( mean[RF_AOV_NORMAL] != NULL, RF_EFFECT_AOV_NORMAL ) )
        add_vector( mean[RF_AOV_NORMAL] + 3 * pixel, rf_vec3( 0, 0, 0 ), share );
    if ( rf_calls_for( mean[RF_AOV_MOTION] != NULL, RF_EFFECT_AOV_MOTION ) )
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
        if ( first.pixel[slot] >= 0 )
            add_hit( job, v, i, (size_t)first.pixel[slot], share );
    }
    for ( int slot = 0; slot < first.rays->count; ++slot )
    {
        if ( !hit[slot] && first.pixel[slot] >= 0 )
            add_miss( job, first.rays, slot, (size_t)first.pixel[slot], share );
    }
    if ( rf_has_filter( job->film->filter ) )
        set_samples( job, first, hit );
}

// Adds a pixel's sample to those around it, within some rows.
static void spread_sample( const RfPixelFilter* filter, FilteredPixel* pixels, int x, int y, int width, int height, float weight,
                           int first_row, int end_row )
{
    const FilteredPixel* sample = pixels + (size_t)y * (size_t)width + (size_t)x;
    float across[RF_FILTER_TAPS], down[RF_FILTER_TAPS];
    rf_filter_weights( filter, x, sample->place[0], width, across );
    rf_filter_weights( filter, y, sample->place[1], height, down );
    for ( int k = 0; k < filter->taps * filter->taps; ++k )
    {
        int column = k % filter->taps, row = k / filter->taps, px = x + column - filter->reach, py = y + row - filter->reach;
        if ( px < 0 || px >= width || py < first_row || py >= end_row )
            continue;
        FilteredPixel* p = pixels + (size_t)py * (size_t)width + (size_t)px;
        float share = weight * across[column] * down[row];
        p->weight += share;
        for ( int c = 0; c < 3; ++c )
            p->sum[c] += share * sample->value[c];
    }
}

void rf_spread_aovs( const RfAovFilm* film, int width, int height, float weight, int first_row, int end_row )
{
    int reach = film->filter->reach, top = first_row > reach ? first_row - reach : 0;
    int bottom = end_row + reach < height ? end_row + reach : height;
    for ( RfAov aov = RF_AOV_ALBEDO; aov <= RF_AOV_NORMAL; ++aov )
    {
        for ( int y = top; y < bottom && film->mean[aov] != NULL; ++y )
        {
            for ( int x = 0; x < width; ++x )
                spread_sample( film->filter, filtered_pixels( film, aov ), x, y, width, height, weight, first_row, end_row );
        }
    }
}

// Divided by the sum of the weights: a constant stays one.
static void finish_filtered( const RfAovFilm* film, RfAov aov, size_t pixels, float* image )
{
    const FilteredPixel* p = filtered_pixels( film, aov );
    for ( size_t i = 0; i < 3 * pixels; ++i )
        image[i] = p[i / 3].weight > 0.0f ? p[i / 3].sum[i % 3] / p[i / 3].weight : 0.0f;
}

void rf_finish_aov( const RfAovFilm* film, RfAov aov, const RfFilm* colour, RfFilmCombine combine, float* image )
{
    size_t pixels = (size_t)colour->width * (size_t)colour->height;
    const float* mean = film->mean[aov];
    if ( rf_has_filter( film->filter ) && is_filtered( aov ) )
    {
        finish_filtered( film, aov, pixels, image );
        return;
    }
    switch ( aov )
    {
        case RF_AOV_VARIANCE: rf_estimate_variance( colour, combine, image ); break;
        case RF_AOV_PRIMAL: rf_combine_film( colour, RF_FILM_RATIO, image, NULL ); break;
        case RF_AOV_DX:
        case RF_AOV_DY:
            rf_combine_film( colour + ( aov - RF_AOV_PRIMAL ), RF_FILM_RATIO, image, NULL );
            rf_add_film_steps( colour + RF_UNSHARED_FILM, 0, 1, aov == RF_AOV_DY, image );
            break;
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
