// Adds hits to the pixels in which they landed, or by a pixel filter to those around, and what a batch has for its own frame.
#include "reuse/accumulate/splat.h"

#include "reuse/accumulate/reprojection.h"

#include <string.h>

typedef float Float4 __attribute__( ( vector_size( 16 ) ) );

// film += r · (value, 1), four lanes at once. Spelled out, since the compiler would go through
// the stack and stall on it.
static inline void add_to_pixel( float* film, float ratio, const float* value )
{
    Float4 v, sum;
    memcpy( &v, value, sizeof v );
    memcpy( &sum, film, sizeof sum );
    sum += v * ratio;
    memcpy( film, &sum, sizeof sum );
}

// splat_diffuse for batches with views, whose ways to the camera have filters.
static uint64_t splat_filtered( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range )
{
    uint64_t landed = 0;
    for ( int i = 0; i < batch->first[RF_BSDF_FIRST_GLOSSY]; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( !( s->ratio[i] > 0.0f ) || pixel < range.low || pixel >= range.end )
            continue;
        const float* value = batch->radiance + 4 * i;
        float filtered[4] = { value[0] * s->filter[0][i], value[1] * s->filter[1][i], value[2] * s->filter[2][i], 1.0f };
        add_to_pixel( range.film + 4 * (size_t)pixel, s->ratio[i], filtered );
        ++landed;
    }
    return landed;
}

// Hits, by the pixels, ratios and filters of the scratch; glossy ones with its sums. Return how many landed.
static uint64_t splat_diffuse( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range )
{
    if ( rf_has_views( batch ) )
        return splat_filtered( batch, s, range );
    uint64_t landed = 0;
    int count = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = 0; i < count; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( s->ratio[i] > 0.0f && pixel >= range.low && pixel < range.end )
        {
            add_to_pixel( range.film + 4 * (size_t)pixel, s->ratio[i], batch->radiance + 4 * i );
            ++landed;
        }
    }
    return landed;
}

static uint64_t splat_glossy( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range )
{
    uint64_t landed = 0;
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = first; i < batch->count; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( s->ratio[i] > 0.0f && pixel >= range.low && pixel < range.end )
        {
            float value[4] = { s->sum[0][i - first], s->sum[1][i - first], s->sum[2][i - first], 1.0f };
            for ( int c = 0; c < 3 && rf_has_views( batch ); ++c )
                value[c] *= s->filter[c][i];
            add_to_pixel( range.film + 4 * (size_t)pixel, s->ratio[i], value );
            ++landed;
        }
    }
    return landed;
}

static void splat_sky( const RfHitBatch* batch, float weight, RfPixelRange range )
{
    for ( int i = 0; i < batch->sky_count; ++i )
    {
        int32_t pixel = rf_miss_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
            range.sky[pixel] += weight;
    }
}

// Misses and specular hits: weight 1 in their own frame, 0 elsewhere. Returns how many landed.
static uint64_t splat_misses( const RfHitBatch* batch, bool black, float weight, RfPixelRange range )
{
    if ( range.sky != NULL )
        splat_sky( batch, weight, range );
    uint64_t landed = 0;
    for ( int i = 0; i < batch->miss_count; ++i )
    {
        int32_t pixel = rf_miss_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
        {
            if ( black )
                range.film[4 * (size_t)pixel + 3] += weight;
            else
                add_to_pixel( range.film + 4 * (size_t)pixel, weight, rf_miss_radiance( batch ) + 4 * (size_t)i );
            ++landed;
        }
    }
    return landed;
}

// Glints: radiance without a sample of its own.
static void splat_glints( const RfHitBatch* batch, float weight, RfPixelRange range )
{
    for ( int i = 0; i < batch->glint_count; ++i )
    {
        int32_t pixel = rf_glint_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
            add_to_pixel( range.glints + 4 * (size_t)pixel, weight, rf_glint_radiance( batch ) + 4 * (size_t)i );
    }
}

// Bᵒ: hits and misses in their own frame, with weight 1 whatever others see of them.
static void count_own( const RfHitBatch* batch, float weight, RfPixelRange range )
{
    for ( int i = 0; i < batch->count + batch->miss_count; ++i )
    {
        int32_t pixel = batch->pixel[i];
        if ( pixel >= range.low && pixel < range.end )
            range.counted[4 * (size_t)pixel + 3] += weight;
    }
}

void rf_count_landed( const RfHitBatch* batch, const RfAccumulateScratch* s, RfPixelRange range, uint32_t* landed )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        int32_t pixel = s->pixel[i];
        if ( s->ratio[i] > 0.0f && pixel >= range.low && pixel < range.end )
            landed[pixel] += 1;
    }
}

void rf_count_misses( const RfHitBatch* batch, RfPixelRange range, uint32_t* landed )
{
    for ( int i = 0; i < batch->miss_count; ++i )
    {
        int32_t pixel = rf_miss_pixel( batch )[i];
        if ( pixel >= range.low && pixel < range.end )
            landed[pixel] += 1;
    }
}

// Where samples go with a pixel filter.
typedef struct Spread
{
    const RfPixelFilter* filter;
    RfPixelRange range;
    int width, height; // of the film
} Spread;

// The pixels of the range that a sample counts in, and how much.
typedef struct Footprint
{
    int left, columns; // the first one, and how many
    int top, rows;
    float across[RF_FILTER_TAPS]; // by column
    float down[RF_FILTER_TAPS];   // by row
    bool in_range;                // the sample's own pixel
} Footprint;

// Of `reach` pixels around q those within [low, end).
static int clip_footprint( int q, int reach, int low, int end, float* weights, int* count )
{
    int first = q - reach > low ? q - reach : low, last = q + reach < end - 1 ? q + reach : end - 1;
    int skipped = first - ( q - reach );
    *count = last - first + 1;
    for ( int k = 0; k < *count && skipped > 0; ++k )
        weights[k] = weights[k + skipped];
    return first;
}

// False where no pixel of the range is in reach.
static bool find_footprint( const Spread* s, int32_t pixel, float u, float v, Footprint* f )
{
    int reach = s->filter->reach, y = pixel / s->width, x = pixel - y * s->width;
    int low = s->range.low / s->width, end = s->range.end / s->width;
    if ( y + reach < low || y - reach >= end )
        return false;
    rf_filter_weights( s->filter, x, u, s->width, f->across );
    rf_filter_weights( s->filter, y, v, s->height, f->down );
    f->left = clip_footprint( x, reach, 0, s->width, f->across, &f->columns );
    f->top = clip_footprint( y, reach, low, end, f->down, &f->rows );
    f->in_range = y >= low && y < end;
    return true;
}

// sums += weight · (value, 1) in each pixel.
static void add_to_footprint( const Spread* s, const Footprint* f, float weight, const float* value, float* sums )
{
    Float4 v;
    memcpy( &v, value, sizeof v );
    v *= weight;
    for ( int row = 0; row < f->rows; ++row )
    {
        float* film = sums + 4 * ( (size_t)( f->top + row ) * (size_t)s->width + (size_t)f->left );
        Float4 of_row = v * f->down[row];
        for ( int k = 0; k < f->columns; ++k )
        {
            Float4 sum;
            memcpy( &sum, film + 4 * k, sizeof sum );
            sum += of_row * f->across[k];
            memcpy( film + 4 * k, &sum, sizeof sum );
        }
    }
}

static void add_sky_to_footprint( const Spread* s, const Footprint* f, float weight )
{
    for ( int row = 0; row < f->rows; ++row )
    {
        float* sky = s->range.sky + (size_t)( f->top + row ) * (size_t)s->width + (size_t)f->left;
        for ( int k = 0; k < f->columns; ++k )
            sky[k] += weight * f->down[row] * f->across[k];
    }
}

// Hits, by the pixels, offsets, ratios and filters of the scratch; glossy ones with its sums. Returns how many landed in the
// range itself.
static uint64_t spread_hits( const RfHitBatch* batch, const RfAccumulateScratch* scratch, Spread s )
{
    uint64_t landed = 0;
    int first_glossy = batch->first[RF_BSDF_FIRST_GLOSSY];
    Footprint f;
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !( scratch->ratio[i] > 0.0f ) ||
             !find_footprint( &s, scratch->pixel[i], scratch->offset[0][i], scratch->offset[1][i], &f ) )
            continue;
        float value[4] = { 0.0f, 0.0f, 0.0f, 1.0f };
        for ( int c = 0; c < 3; ++c )
        {
            value[c] = i < first_glossy ? batch->radiance[4 * i + c] : scratch->sum[c][i - first_glossy];
            value[c] *= batch->has_views ? scratch->filter[c][i] : 1.0f;
        }
        add_to_footprint( &s, &f, scratch->ratio[i], value, s.range.film );
        landed += f.in_range;
    }
    return landed;
}

static const float only_weight[4] = { 0.0f, 0.0f, 0.0f, 1.0f };

// count_own with a pixel filter.
static void spread_own_count( const RfHitBatch* batch, float weight, Spread s )
{
    Footprint f;
    for ( int i = 0; i < batch->count + batch->miss_count; ++i )
    {
        if ( find_footprint( &s, batch->pixel[i], batch->offset[0][i], batch->offset[1][i], &f ) )
            add_to_footprint( &s, &f, weight, only_weight, s.range.counted );
    }
}

// Misses and specular hits, with weight 1 in their own frame, and glints. Returns how many but glints landed in the range.
static uint64_t spread_own_frame( const RfHitBatch* batch, bool black, float weight, Spread s )
{
    uint64_t landed = 0;
    int others = batch->miss_count + batch->glint_count;
    Footprint f;
    for ( int k = 0; k < others; ++k )
    {
        int i = batch->count + k;
        if ( !find_footprint( &s, batch->pixel[i], batch->offset[0][i], batch->offset[1][i], &f ) )
            continue;
        bool miss = k < batch->miss_count;
        add_to_footprint( &s, &f, weight, black && miss ? only_weight : batch->radiance + 4 * (size_t)i,
                          miss ? s.range.film : s.range.glints );
        if ( s.range.sky != NULL && k < batch->sky_count )
            add_sky_to_footprint( &s, &f, weight );
        landed += miss && f.in_range;
    }
    return landed;
}

static Spread make_spread( const RfAccumulation* a, int eye, RfPixelRange range )
{
    return ( Spread ){ .filter = a->filter, .range = range, .width = a->eyes[eye].width, .height = a->eyes[eye].height };
}

// What a batch has for its own frame alone. Returns how many samples landed.
static uint64_t splat_own_frame( const RfAccumulation* a, const RfHitBatch* batch, RfPixelRange range )
{
    bool black = !a->shape.own_frame_light;
    if ( rf_has_filter( a->filter ) )
    {
        Spread s = make_spread( a, batch->eye, range );
        if ( range.counted != NULL )
            spread_own_count( batch, a->weight, s );
        return spread_own_frame( batch, black, a->weight, s );
    }
    uint64_t landed = splat_misses( batch, black, a->weight, range );
    splat_glints( batch, a->weight, range );
    if ( range.counted != NULL )
        count_own( batch, a->weight, range );
    return landed;
}

uint64_t rf_splat( const RfAccumulation* a, int eye, const RfHitBatch* batch, RfPixelRange range,
                   const RfAccumulateScratch* scratch )
{
    uint64_t landed = 0;
    if ( rf_has_filter( a->filter ) )
        landed = spread_hits( batch, scratch, make_spread( a, eye, range ) );
    else
    {
        landed = splat_diffuse( batch, scratch, range );
        if ( rf_glossy_count( batch ) > 0 )
            landed += splat_glossy( batch, scratch, range );
    }
    return eye == batch->eye ? landed + splat_own_frame( a, batch, range ) : landed;
}

// Hits that landed.

RfLandedHits* rf_place_landing( bool filtered, RfLayout* layout )
{
    RfLandedHits* landing = rf_take( layout, 1, sizeof *landing );
    if ( landing != NULL )
        *landing = ( RfLandedHits ){ 0 };
    RF_PLACE( layout, landing->value, 4 * RF_LANES );
    RF_PLACE( layout, landing->pixel, RF_LANES );
    for ( int c = 0; c < 2; ++c )
        RF_PLACE( layout, landing->offset[c], filtered ? RF_LANES : 0 );
    return landing;
}

static Float4 value_of( const RfHitBatch* batch, const RfAccumulateScratch* s, bool views, int i )
{
    int glossy = i - batch->first[RF_BSDF_FIRST_GLOSSY];
    Float4 value = { 0.0f, 0.0f, 0.0f, 1.0f };
    if ( glossy < 0 )
        memcpy( &value, batch->radiance + 4 * i, sizeof value );
    for ( int c = 0; c < 3 && glossy >= 0; ++c )
        value[c] = s->sum[c][glossy];
    for ( int c = 0; c < 3 && views; ++c )
        value[c] *= s->filter[c][i];
    return value * s->ratio[i];
}

// Lists the hits that landed, with the range of their pixels.
static void list_landed( const RfHitBatch* batch, const RfAccumulateScratch* s, int16_t* listed, RfLandedHits* landing )
{
    int count = 0;
    int32_t low = INT32_MAX, high = -1;
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !( s->ratio[i] > 0.0f ) )
            continue;
        listed[count++] = (int16_t)i;
        low = s->pixel[i] < low ? s->pixel[i] : low;
        high = s->pixel[i] > high ? s->pixel[i] : high;
    }
    landing->count = count;
    landing->low = low;
    landing->high = high;
}

// Where the bins begin; without any hit all are empty.
static void find_bins( const RfAccumulateScratch* s, const int16_t* listed, RfLandedHits* landing )
{
    int16_t* first = landing->first;
    landing->shift = 0;
    while ( landing->count > 0 && ( landing->high - landing->low ) >> landing->shift >= RF_LANDING_BINS )
        landing->shift += 1;
    memset( first, 0, sizeof landing->first );
    for ( int k = 0; k < landing->count; ++k )
        first[( ( s->pixel[listed[k]] - landing->low ) >> landing->shift ) + 1] += 1;
    for ( int b = 0; b < RF_LANDING_BINS; ++b )
        first[b + 1] = (int16_t)( first[b] + first[b + 1] );
}

void rf_keep_landing( const RfHitBatch* batch, const RfAccumulateScratch* s, RfLandedHits* landing )
{
    int16_t listed[RF_LANES], next[RF_LANDING_BINS];
    bool views = rf_has_views( batch ), sorted = landing->offset[0] == NULL;
    list_landed( batch, s, listed, landing );
    if ( sorted )
    {
        find_bins( s, listed, landing );
        memcpy( next, landing->first, sizeof next );
    }
    for ( int k = 0; k < landing->count; ++k )
    {
        int i = listed[k], at = sorted ? next[( s->pixel[i] - landing->low ) >> landing->shift]++ : k;
        Float4 value = value_of( batch, s, views, i );
        memcpy( landing->value + 4 * at, &value, sizeof value );
        landing->pixel[at] = s->pixel[i];
        for ( int c = 0; c < 2 && !sorted; ++c )
            landing->offset[c][at] = s->offset[c][i];
    }
}

static int bin_of( const RfLandedHits* landing, int32_t pixel )
{
    int bin = pixel > landing->low ? ( pixel - landing->low ) >> landing->shift : 0;
    return bin < RF_LANDING_BINS ? bin : RF_LANDING_BINS - 1;
}

static uint64_t add_landing( const RfLandedHits* landing, RfPixelRange range )
{
    uint64_t landed = 0;
    int end = landing->first[bin_of( landing, range.end - 1 ) + 1];
    for ( int i = landing->first[bin_of( landing, range.low )]; i < end; ++i )
    {
        int32_t pixel = landing->pixel[i];
        if ( pixel < range.low || pixel >= range.end )
            continue;
        add_to_pixel( range.film + 4 * (size_t)pixel, 1.0f, landing->value + 4 * i );
        ++landed;
    }
    return landed;
}

static uint64_t spread_landing( const RfLandedHits* landing, Spread s )
{
    uint64_t landed = 0;
    int32_t beyond = s.filter->reach * s.width;
    Footprint f;
    for ( int i = 0; i < landing->count; ++i )
    {
        if ( landing->pixel[i] < s.range.low - beyond || landing->pixel[i] >= s.range.end + beyond ||
             !find_footprint( &s, landing->pixel[i], landing->offset[0][i], landing->offset[1][i], &f ) )
            continue;
        add_to_footprint( &s, &f, 1.0f, landing->value + 4 * i, s.range.film );
        landed += f.in_range;
    }
    return landed;
}

uint64_t rf_splat_landing( const RfAccumulation* a, int eye, const RfHitBatch* batch, const RfLandedHits* landing,
                           RfPixelRange range )
{
    bool filtered = rf_has_filter( a->filter );
    int32_t beyond = filtered ? a->filter->reach * a->eyes[eye].width : 0;
    uint64_t landed = 0;
    if ( landing->low - beyond < range.end && landing->high + beyond >= range.low )
        landed = filtered ? spread_landing( landing, make_spread( a, eye, range ) ) : add_landing( landing, range );
    return eye == batch->eye ? landed + splat_own_frame( a, batch, range ) : landed;
}

void rf_count_landing( const RfLandedHits* landing, RfPixelRange range, uint32_t* landed )
{
    for ( int i = 0; i < landing->count; ++i )
    {
        if ( landing->pixel[i] >= range.low && landing->pixel[i] < range.end )
            landed[landing->pixel[i]] += 1;
    }
}
