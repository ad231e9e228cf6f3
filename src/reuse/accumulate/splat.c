// Adds hits to the pixels in which they landed, or by a pixel filter to those around, and what a batch has for its own frame.
#include "reuse/accumulate/splat.h"

#include <string.h>

typedef float Float4 __attribute__( ( vector_size( 16 ) ) );

// film += weight · value, four lanes at once. Spelled out, since the compiler would go through
// the stack and stall on it.
static inline void add_to_pixel( float* film, float weight, const float* value )
{
    Float4 v, sum;
    memcpy( &v, value, sizeof v );
    memcpy( &sum, film, sizeof sum );
    sum += v * weight;
    memcpy( film, &sum, sizeof sum );
}

// ---- Landings

RfLandedHits* rf_place_landed_hits( int films, bool filtered, bool covering, RfLayout* layout )
{
    RfLandedHits* landing = rf_take( layout, 1, sizeof *landing );
    if ( landing != NULL )
        *landing = ( RfLandedHits ){ 0 };
    RF_PLACE( layout, landing->pixel, RF_LANES );
    RF_PLACE( layout, landing->ratio, covering ? RF_LANES : 0 );
    RF_PLACE( layout, landing->surface, covering ? RF_LANES : 0 );
    for ( int c = 0; c < 2; ++c )
        RF_PLACE( layout, landing->offset[c], filtered ? RF_LANES : 0 );
    for ( int k = 0; k < films; ++k )
        RF_PLACE( layout, landing->value[k], 4 * RF_LANES );
    return landing;
}

// Lists the hits that land, in their order.
static int list_landed( const RfHitBatch* batch, const RfProjectedHits* at, int16_t* restrict listed, RfLandedHits* landing )
{
    const float* restrict ratio = at->ratio;
    const int32_t* restrict pixel = at->pixel;
    int count = 0;
    int32_t low = INT32_MAX, high = -1;
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !( ratio[i] > 0.0f ) )
            continue;
        listed[count++] = (int16_t)i;
        low = pixel[i] < low ? pixel[i] : low;
        high = pixel[i] > high ? pixel[i] : high;
    }
    landing->low = low;
    landing->high = high;
    return count;
}

// out[k] = of[order[k]]; with `all` the order is that of the batch.
static void gather( const void* of, const int16_t* restrict order, int count, bool all, void* out )
{
    const uint32_t* restrict from = of;
    uint32_t* restrict to = out;
    if ( all )
        memcpy( to, from, (size_t)count * sizeof *to );
    for ( int k = 0; k < count && !all; ++k )
        to[k] = from[order[k]];
}

// Where the bins begin; without any hit all are empty.
static void find_bins( const RfProjectedHits* at, const int16_t* listed, RfLandedHits* landing )
{
    int16_t* first = landing->first;
    landing->shift = 0;
    while ( landing->count > 0 && ( landing->high - landing->low ) >> landing->shift >= RF_LANDING_BINS )
        landing->shift += 1;
    memset( first, 0, sizeof landing->first );
    for ( int k = 0; k < landing->count; ++k )
        first[( ( at->pixel[listed[k]] - landing->low ) >> landing->shift ) + 1] += 1;
    for ( int b = 0; b < RF_LANDING_BINS; ++b )
        first[b + 1] = (int16_t)( first[b] + first[b + 1] );
}

void rf_list_landing( const RfHitBatch* batch, int eye, const RfProjectedHits* at, bool sorted, int16_t* order,
                      RfLandedHits* landing )
{
    int16_t listed[RF_LANES], next[RF_LANDING_BINS];
    bool own = eye == batch->eye || batch->surface_seen == NULL;
    const uint32_t* seen = own ? batch->surface : batch->surface_seen + (size_t)eye * RF_LANES;
    landing->sorted = sorted;
    landing->count = list_landed( batch, at, sorted ? listed : order, landing );
    if ( sorted )
    {
        find_bins( at, listed, landing );
        memcpy( next, landing->first, sizeof next );
        for ( int k = 0; k < landing->count; ++k )
            order[next[( at->pixel[listed[k]] - landing->low ) >> landing->shift]++] = listed[k];
    }
    bool all = !sorted && landing->count == batch->count;
    gather( at->pixel, order, landing->count, all, landing->pixel );
    for ( int c = 0; c < 2 && landing->offset[0] != NULL; ++c )
        gather( at->offset[c], order, landing->count, all, landing->offset[c] );
    if ( landing->surface == NULL )
        return;
    gather( seen, order, landing->count, all, landing->surface );
    gather( at->ratio, order, landing->count, all, landing->ratio );
}

void rf_keep_light( const RfHitBatch* batch, const RfProjectedHits* at, RfHitLight light, const int16_t* order, int film,
                    RfLandedHits* landing )
{
    bool views = rf_has_views( batch );
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    float* to = landing->value[film];
    landing->lit[film] = true;
    for ( int k = 0; k < landing->count; ++k )
    {
        int i = order[k];
        Float4 value;
        if ( i < first )
            memcpy( &value, light.radiance + 4 * i, sizeof value );
        else
            value =
                ( Float4 ){ light.glossy->rgb[0][i - first], light.glossy->rgb[1][i - first], light.glossy->rgb[2][i - first] };
        if ( views )
            value *= ( Float4 ){ at->filter[0][i], at->filter[1][i], at->filter[2][i] };
        value[3] = 1.0f;
        value *= at->ratio[i];
        memcpy( to + 4 * k, &value, sizeof value );
    }
}

// ---- Where samples go

// The pixels of the range that a sample counts in by a pixel filter, and how much.
typedef struct Footprint
{
    int left, columns; // the first one, and how many
    int top, rows;
    float across[RF_FILTER_TAPS]; // by column
    float down[RF_FILTER_TAPS];   // by row
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
static bool find_footprint( const RfSplat* s, int32_t pixel, float u, float v, Footprint* f )
{
    int reach = s->filter->reach, y = pixel / s->width, x = pixel - y * s->width;
    int low = s->low / s->width, end = s->end / s->width;
    if ( y + reach < low || y - reach >= end )
        return false;
    rf_filter_weights( s->filter, x, u, s->width, f->across );
    rf_filter_weights( s->filter, y, v, s->height, f->down );
    f->left = clip_footprint( x, reach, 0, s->width, f->across, &f->columns );
    f->top = clip_footprint( y, reach, low, end, f->down, &f->rows );
    return true;
}

static bool is_in_range( const RfSplat* s, int32_t pixel ) { return pixel >= s->low && pixel < s->end; }

// sums += weight · value in each pixel.
static void add_to_footprint( const RfSplat* s, const Footprint* f, float weight, const float* value, float* sums )
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

static void add_sky_to_footprint( const RfSplat* s, const Footprint* f, float weight )
{
    for ( int row = 0; row < f->rows; ++row )
    {
        float* sky = s->sky + (size_t)( f->top + row ) * (size_t)s->width + (size_t)f->left;
        for ( int k = 0; k < f->columns; ++k )
            sky[k] += weight * f->down[row] * f->across[k];
    }
}

// ---- Hits

static int bin_of( const RfLandedHits* landing, int32_t pixel )
{
    int bin = pixel > landing->low ? ( pixel - landing->low ) >> landing->shift : 0;
    return bin < RF_LANDING_BINS ? bin : RF_LANDING_BINS - 1;
}

// Adds hit i to all films, of which the first is the picture; `films`: how many there are.
static inline __attribute__( ( always_inline ) ) void add_hit( const RfSplat* s, const RfLandedHits* landing, int i,
                                                               bool filtered, int films )
{
    int32_t pixel = landing->pixel[i];
    Footprint f;
    if ( filtered && !find_footprint( s, pixel, landing->offset[0][i], landing->offset[1][i], &f ) )
        return;
    for ( int k = 0; k < films; ++k )
    {
        const float* value = landing->value[k] + 4 * i;
        if ( k > 0 && !landing->lit[k] )
            continue;
        float* film = s->films[k].film->half[s->half];
        if ( filtered )
            add_to_footprint( s, &f, 1.0f, value, film );
        else
            add_to_pixel( film + 4 * (size_t)pixel, 1.0f, value );
    }
}

// Returns how many landed in the range itself.
static inline __attribute__( ( always_inline ) ) uint64_t add_hits( const RfSplat* s, const RfLandedHits* landing, bool filtered,
                                                                    int films )
{
    uint64_t landed = 0;
    int32_t beyond = filtered ? s->filter->reach * s->width : 0;
    bool out_of_reach = landing->low - beyond >= s->end || landing->high + beyond < s->low;
    int first = landing->sorted ? landing->first[bin_of( landing, s->low )] : 0;
    int end = landing->sorted ? landing->first[bin_of( landing, s->end - 1 ) + 1] : landing->count;
    for ( int i = first; i < end && !out_of_reach; ++i )
    {
        int32_t pixel = landing->pixel[i];
        if ( pixel < s->low - beyond || pixel >= s->end + beyond )
            continue;
        bool within = is_in_range( s, pixel );
        add_hit( s, landing, i, filtered, films );
        landed += within;
        if ( s->landed != NULL && within )
            s->landed[pixel] += 1;
    }
    return landed;
}

// Most frames have one film.
static uint64_t splat_hits( const RfSplat* s, const RfLandedHits* landing )
{
    if ( s->count == 1 )
        return rf_has_filter( s->filter ) ? add_hits( s, landing, true, 1 ) : add_hits( s, landing, false, 1 );
    return add_hits( s, landing, rf_has_filter( s->filter ), s->count );
}

// ---- The batch's own frame

// Misses and specular hits have the weight 1 in their own frame, 0 elsewhere. Glints are radiance without a sample of their own.
static void splat_other( const RfSplat* s, const RfHitBatch* batch, int item, const Footprint* f )
{
    const RfLayerSet* set = &batch->layers;
    bool miss = item < batch->count + batch->miss_count;
    int kinds = rf_kinds( set );
    for ( int k = 0; k < s->count; ++k )
    {
        const RfSplatFilm* film = s->films + k;
        for ( int layer = 0; layer < set->base_parts * ( film->layers.removed ? 1 : kinds ); ++layer )
        {
            const RfLayerLight* light = film->layers.removed ? rf_removed_light( batch, layer ) : batch->light + layer;
            const float* value = light->radiance + 4 * (size_t)item;
            bool has = film->layers.removed ? !light->dark
                                            : rf_is_in_film( film->layers, layer / kinds, (RfLayerKind)( layer % kinds ) );
            if ( !has || film->film == NULL )
                continue;
            bool own = !miss && s->splits && film->film->split;
            float* to = own ? rf_film_own( film->film, s->half ) : film->film->half[s->half];
            if ( rf_has_filter( s->filter ) )
                add_to_footprint( s, f, s->weight, value, to );
            else
                add_to_pixel( to + 4 * (size_t)batch->pixel[item], s->weight, value );
        }
    }
}

// Returns how many samples landed in the range itself.
static uint64_t splat_others( const RfSplat* s, const RfHitBatch* batch )
{
    uint64_t landed = 0;
    bool filtered = rf_has_filter( s->filter );
    Footprint f = { .rows = 0 };
    for ( int i = batch->count; i < rf_listed( batch ); ++i )
    {
        int32_t pixel = batch->pixel[i];
        bool miss = i < batch->count + batch->miss_count, sky = i < batch->count + batch->sky_count && s->sky != NULL;
        if ( filtered ? !find_footprint( s, pixel, batch->offset[0][i], batch->offset[1][i], &f ) : !is_in_range( s, pixel ) )
            continue;
        splat_other( s, batch, i, &f );
        if ( sky && filtered )
            add_sky_to_footprint( s, &f, s->weight );
        else if ( sky )
            s->sky[pixel] += s->weight;
        landed += miss && is_in_range( s, pixel );
        if ( s->landed != NULL && miss && is_in_range( s, pixel ) )
            s->landed[pixel] += 1;
    }
    return landed;
}

// Bᵒ: hits and misses in their own frame, with weight 1 whatever others see of them.
static void count_own( const RfSplat* s, const RfHitBatch* batch )
{
    static const float one[4] = { 0.0f, 0.0f, 0.0f, 1.0f };
    Footprint f;
    for ( int i = 0; i < batch->count + batch->miss_count; ++i )
    {
        int32_t pixel = batch->pixel[i];
        if ( !rf_has_filter( s->filter ) && is_in_range( s, pixel ) )
            s->counted[4 * (size_t)pixel + 3] += s->weight;
        if ( rf_has_filter( s->filter ) && find_footprint( s, pixel, batch->offset[0][i], batch->offset[1][i], &f ) )
            add_to_footprint( s, &f, s->weight, one, s->counted );
    }
}

// ---- The surfaces that cover pixels, by the weights and the filter of the colour, as `alpha`

static void cover( const RfSplat* s, int32_t pixel, float u, float v, uint32_t surface, float weight )
{
    int y = pixel / s->width, x = pixel - y * s->width, first_row = s->low / s->width, end_row = s->end / s->width;
    if ( !rf_has_filter( s->filter ) )
    {
        if ( y >= first_row && y < end_row )
            rf_add_covering( s->covering + pixel, surface, weight );
        return;
    }
    int reach = s->filter->reach;
    float across[RF_FILTER_TAPS], down[RF_FILTER_TAPS];
    if ( y + reach < first_row || y - reach >= end_row )
        return;
    rf_filter_weights( s->filter, x, u, s->width, across );
    rf_filter_weights( s->filter, y, v, s->height, down );
    for ( int row = 0; row < s->filter->taps; ++row )
    {
        int to_y = y + row - reach;
        for ( int k = 0; k < s->filter->taps && to_y >= first_row && to_y < end_row; ++k )
        {
            float share = weight * across[k] * down[row]; // 0 outside the film
            if ( share > 0.0f )
                rf_add_covering( s->covering + (size_t)to_y * (size_t)s->width + (size_t)( x + k - reach ), surface, share );
        }
    }
}

// The hits of a batch that landed, and in its `own` frame its misses.
static void cover_rows( const RfSplat* s, const RfHitBatch* batch, bool own, const RfLandedHits* landing )
{
    bool filtered = rf_has_filter( s->filter );
    for ( int i = 0; i < landing->count; ++i )
        cover( s, landing->pixel[i], filtered ? landing->offset[0][i] : 0.0f, filtered ? landing->offset[1][i] : 0.0f,
               landing->surface[i], landing->ratio[i] );
    for ( int i = batch->count; own && i < batch->count + batch->miss_count; ++i )
        cover( s, batch->pixel[i], filtered ? batch->offset[0][i] : 0.0f, filtered ? batch->offset[1][i] : 0.0f,
               batch->surface[i], s->weight );
}

uint64_t rf_splat( const RfSplat* splat, const RfHitBatch* batch, bool own, const RfLandedHits* landing )
{
    uint64_t landed = splat_hits( splat, landing );
    if ( own )
        landed += splat_others( splat, batch );
    if ( own && splat->counted != NULL )
        count_own( splat, batch );
    if ( splat->covering != NULL )
        cover_rows( splat, batch, own, landing );
    return landed;
}
