// A map is sampled by its pixels: first a cell of them, then a pixel of the cell, then a direction inside the pixel, uniformly by
// solid angle. Within its cell a pixel's probability is proportional to the mean over it of the interpolated luminance
// (rf_sky_radiance), so no direction that emits has density 0. That of a cell is, for light paths, the sum of these; for surfaces
// the sum of these times cosines: of a mixture of three lobes, the cosines with the axes that the normal is between, in proportion
// to its components. These are the sides of an ambient cube (McTaggart, Half-Life 2 / Valve Source Shading, 2004). Their
// mixture is at least the cosine with the normal, and equal to it where the normal is an axis.
#include "light/sky.h"

#include "base/fault.h"
#include "math/fastmath.h"

#include <stdlib.h>
#include <string.h>

static const float* pixel( const RfEnvironment* e, int x, int y )
{
    x = x < 0 ? x + e->width : ( x >= e->width ? x - e->width : x );
    y = y < 0 ? 0 : ( y >= e->height ? e->height - 1 : y );
    return e->map + 3 * ( (size_t)y * (size_t)e->width + (size_t)x );
}

static double luminance_at( const RfEnvironment* e, int x, int y )
{
    const float* p = pixel( e, x, y );
    return (double)rf_luminance( rf_mul( e->radiance, rf_vec3( p[0], p[1], p[2] ) ) );
}

// Mean over a pixel of the interpolated luminance: weights ⅛ ¾ ⅛ along each axis.
static double mean_luminance( const RfEnvironment* e, int x, int y )
{
    double sum = 0.0, side = RF_FAULT( sky_neighbours ) ? 0.0 : 0.125, middle = 1.0 - 2.0 * side;
    for ( int j = -1; j <= 1; ++j )
    {
        for ( int i = -1; i <= 1; ++i )
            sum += ( i == 0 ? middle : side ) * ( j == 0 ? middle : side ) * luminance_at( e, x + i, y + j );
    }
    return sum;
}

static double pixel_solid_angle( const RfSky* sky, const RfEnvironment* e, int y )
{
    return ( sky->row_cosine[y] - sky->row_cosine[y + 1] ) * 2.0 * 3.14159265358979324 / e->width;
}

// Unit vector at azimuth 2π (u − ½) from the centre of the map, and the given height; u in [0, 1].
static inline RfVec3 direction_of( const RfSky* sky, float u, double cos_up )
{
    double across2 = 1.0 - cos_up * cos_up;
    float sine, cosine, across = (float)sqrt( across2 > 0.0 ? across2 : 0.0 );
    rf_sincos_2pi( u, &sine, &cosine );
    float x = -across * sine, z = across * cosine;
    return rf_vec3( x * sky->cos_rotation + z * sky->sin_rotation, (float)cos_up, z * sky->cos_rotation - x * sky->sin_rotation );
}

// Mean of luminance times direction over the sphere.
static RfVec3 luminance_moment( const RfSky* sky, const RfEnvironment* e )
{
    double sum[3] = { 0 };
    for ( int y = 0; y < e->height; ++y )
    {
        double solid_angle = pixel_solid_angle( sky, e, y ), cos_up = cos( ( y + 0.5 ) / e->height * 3.14159265358979324 );
        for ( int x = 0; x < e->width; ++x )
        {
            RfVec3 d = direction_of( sky, ( (float)x + 0.5f ) / (float)e->width, cos_up );
            double light = luminance_at( e, x, y ) * solid_angle / ( 4.0 * 3.14159265358979324 );
            sum[0] += light * (double)d.x;
            sum[1] += light * (double)d.y;
            sum[2] += light * (double)d.z;
        }
    }
    return rf_vec3( (float)sum[0], (float)sum[1], (float)sum[2] );
}

// The last entry from `low` on that is not above u, of those that are followed by a larger one; the next is at `high` at most.
static int find_cell( const uint32_t* sum, int low, int high, uint32_t u )
{
    while ( high - low > 1 )
    {
        int middle = ( low + high ) / 2;
        bool above = sum[middle] > u;
        high = above ? middle : high;
        low = above ? low : middle;
    }
    return low;
}

// The largest power of two, as its exponent, of which `parts` fit into `count`; at most 7, so that a cell has no more than 2¹⁴ pixels.
static int bits_of_block( int count, int parts )
{
    int bits = 0;
    while ( bits < 7 && parts << ( bits + 1 ) <= count )
        ++bits;
    return bits;
}

static size_t pixel_index( const RfSky* sky, int x, int y )
{
    size_t cell = (size_t)( y >> sky->row_bits ) * (size_t)sky->cells_across + (size_t)( x >> sky->column_bits );
    size_t row = (size_t)( y & ( ( 1 << sky->row_bits ) - 1 ) ), column = (size_t)( x & ( ( 1 << sky->column_bits ) - 1 ) );
    return ( ( ( cell << sky->row_bits ) + row ) << sky->column_bits ) + column;
}

// The mean over a pixel of the cosine with an axis, 0 where that is negative: above 0 if any of it has a positive one. `cosine`: at
// its middle; `radius`: of a ball around the pixel, rad.
static float mean_cosine( float cosine, float radius )
{
    float above = rf_maxf( cosine + radius, 0.0f );
    return cosine >= radius ? cosine : above * above / ( 4.0f * radius );
}

// Integer probabilities that sum up to `whole`, and are at least 1 for what is not black. `weights` must not all be 0.
static void round_probabilities( const double* weights, double total, uint32_t count, int64_t whole, uint32_t* units )
{
    int64_t left = whole;
    double scale = (double)whole / total;
    uint32_t largest = 0;
    for ( uint32_t i = 0; i < count; ++i )
    {
        double rounded = floor( weights[i] * scale + 0.5 );
        units[i] = weights[i] > 0.0 && rounded < 1.0 ? 1u : (uint32_t)rounded;
        left -= (int64_t)units[i];
        largest = weights[i] > weights[largest] ? i : largest;
    }
    units[largest] = (uint32_t)( (int64_t)units[largest] + left );
}

// Walker's alias table of these probabilities, exact since they are integers. Leaves 2¹⁶ of each. `work`: `count` numbers.
static void fill_alias( RfSkyPixel* pixel, uint32_t count, uint32_t* units, uint32_t* work )
{
    uint32_t small = 0, large = count; // columns that lack something from the front, others from the back
    for ( uint32_t i = 0; i < count; ++i )
    {
        pixel[i].threshold = 0;
        pixel[i].alias = (uint16_t)i;
        if ( units[i] < 1u << 16 )
            work[small++] = i;
        else
            work[--large] = i;
    }
    while ( small > 0 )
    {
        uint32_t s = work[--small], l = work[large];
        pixel[s].threshold = (uint16_t)units[s];
        pixel[s].alias = (uint16_t)l;
        units[l] -= ( 1u << 16 ) - units[s];
        if ( units[l] < 1u << 16 )
        {
            ++large;
            work[small++] = l;
        }
    }
}

// Room for the pixels of a cell while they are listed.
typedef struct CellWork
{
    double* weights;
    uint32_t *units, *list;
} CellWork;

// Lists a cell, and adds what its pixels send to surfaces along the axes.
static void fill_cell( RfSky* sky, const RfEnvironment* e, int cell, const CellWork* work, double flux[RF_SKY_LOBES] )
{
    int x0 = cell % sky->cells_across << sky->column_bits, y0 = cell / sky->cells_across << sky->row_bits;
    uint32_t count = 1u << ( sky->column_bits + sky->row_bits );
    RfSkyPixel* pixels = sky->pixel + (size_t)cell * count;
    double total = 0.0;
    sky->cell[cell].x = (uint16_t)( cell % sky->cells_across );
    sky->cell[cell].y = (uint16_t)( cell / sky->cells_across );
    for ( uint32_t i = 0; i < count; ++i )
    {
        int x = x0 + (int)( i & ( ( 1u << sky->column_bits ) - 1 ) ), y = y0 + (int)( i >> sky->column_bits );
        pixels[i] = ( RfSkyPixel ){ 0 };
        work->weights[i] = 0.0;
        if ( x >= e->width || y >= e->height )
            continue;
        double light = mean_luminance( e, x, y ) * pixel_solid_angle( sky, e, y );
        float radius = 0.5f * RF_PI * ( 1.0f / (float)e->height + 2.0f / (float)e->width );
        RfVec3 d =
            direction_of( sky, ( (float)x + 0.5f ) / (float)e->width, 0.5 * ( sky->row_cosine[y] + sky->row_cosine[y + 1] ) );
        const float axis[3] = { d.x, d.y, d.z };
        for ( int k = 0; k < 6; ++k )
            flux[k] += light * (double)mean_cosine( k % 2 == 0 ? axis[k / 2] : -axis[k / 2], radius );
        flux[RF_SKY_SPHERE] += light;
        work->weights[i] = light;
        total += light;
    }
    if ( !( total > 0.0 ) )
        return;
    round_probabilities( work->weights, total, count, (int64_t)count << 16, work->units ); // 2⁻¹⁶ of a column each
    for ( uint32_t i = 0; i < count; ++i )
    {
        int y = y0 + (int)( i >> sky->column_bits );
        if ( work->units[i] > 0 )
            pixels[i].density = (float)( work->units[i] / ( 65536.0 * count * pixel_solid_angle( sky, e, y ) ) );
    }
    fill_alias( pixels, count, work->units, work->list );
}

// The distribution of the cells for a lobe, from what they send, and where searches begin.
static void sum_cells( RfSky* sky, int lobe, const double* flux, uint32_t* units )
{
    uint32_t *sum = sky->sum + (size_t)lobe * ( (size_t)sky->cells + 1 ), run = 0;
    int32_t* guide = sky->guide + (size_t)lobe * ( ( (size_t)1 << sky->guide_bits ) + 1 );
    double total = 0.0;
    for ( int i = 0; i < sky->cells; ++i )
        total += flux[i];
    sky->total[lobe] = (float)total;
    memset( units, 0, (size_t)sky->cells * sizeof *units );
    if ( total > 0.0 )
        round_probabilities( flux, total, (uint32_t)sky->cells, (int64_t)1 << 31, units );
    for ( int i = 0; i <= sky->cells; ++i )
    {
        uint32_t of_cell = i < sky->cells ? units[i] : 0;
        sum[i] = run;
        run += of_cell;
        if ( i < sky->cells )
            sky->cell[i].flux[lobe] = (float)( of_cell * 0x1p-31 * total );
    }
    for ( int i = 0; i <= 1 << sky->guide_bits; ++i )
        guide[i] = find_cell( sum, 0, sky->cells, (uint32_t)i << ( 31 - sky->guide_bits ) );
}

static bool fill_cells( RfSky* sky, const RfEnvironment* e )
{
    size_t count = (size_t)1 << ( sky->column_bits + sky->row_bits ), cells = (size_t)sky->cells;
    size_t most = count > cells ? count : cells;
    CellWork work = { malloc( count * sizeof *work.weights ), malloc( most * sizeof *work.units ),
                      malloc( count * sizeof *work.list ) };
    double* sums = malloc( RF_SKY_LOBES * cells * sizeof *sums );
    bool complete = work.weights != NULL && work.units != NULL && work.list != NULL && sums != NULL;
    for ( int i = 0; i < sky->cells && complete; ++i )
    {
        double flux[RF_SKY_LOBES] = { 0 };
        fill_cell( sky, e, i, &work, flux );
        for ( int k = 0; k < RF_SKY_LOBES; ++k )
            sums[(size_t)k * cells + (size_t)i] = flux[k];
    }
    for ( int k = 0; k < RF_SKY_LOBES && complete; ++k )
        sum_cells( sky, k, sums + (size_t)k * cells, work.units );
    free( work.weights );
    free( work.units );
    free( work.list );
    free( sums );
    return complete;
}

static bool make_tables( RfSky* sky, const RfEnvironment* e )
{
    sky->column_bits = bits_of_block( e->width, 32 );
    sky->row_bits = bits_of_block( e->height, 16 );
    sky->cells_across = ( e->width + ( 1 << sky->column_bits ) - 1 ) >> sky->column_bits;
    sky->cells = ( ( e->height + ( 1 << sky->row_bits ) - 1 ) >> sky->row_bits ) * sky->cells_across;
    for ( sky->guide_bits = 0; 1 << sky->guide_bits < sky->cells; ++sky->guide_bits )
        ;
    size_t cells = (size_t)sky->cells;
    sky->row_cosine = malloc( ( (size_t)e->height + 1 ) * sizeof *sky->row_cosine );
    sky->pixel = malloc( ( cells << ( sky->column_bits + sky->row_bits ) ) * sizeof *sky->pixel );
    sky->cell = calloc( cells, sizeof *sky->cell );
    sky->sum = malloc( RF_SKY_LOBES * ( cells + 1 ) * sizeof *sky->sum );
    sky->guide = malloc( RF_SKY_LOBES * ( ( (size_t)1 << sky->guide_bits ) + 1 ) * sizeof *sky->guide );
    if ( sky->row_cosine == NULL || sky->pixel == NULL || sky->cell == NULL || sky->sum == NULL || sky->guide == NULL )
        return false;
    for ( int y = 0; y <= e->height; ++y )
        sky->row_cosine[y] = cos( (double)y / e->height * 3.14159265358979324 );
    // in directions of the map, whatever its rotation, which may change
    sky->cos_rotation = 1.0f;
    sky->sin_rotation = 0.0f;
    if ( !fill_cells( sky, e ) )
        return false;
    sky->cos_rotation = cosf( e->rotation );
    sky->sin_rotation = sinf( e->rotation );
    sky->mean_luminance = sky->total[RF_SKY_SPHERE] * 0.25f * RF_INV_PI;
    sky->luminance_moment = luminance_moment( sky, e );
    return true;
}

RfResult rf_make_sky( const RfEnvironment* e, RfSky* sky, RfError* error )
{
    *sky = ( RfSky ){ 0 };
    if ( !( rf_max_component( e->radiance ) > 0.0f ) )
        return RF_OK;
    sky->mean_luminance = rf_luminance( e->radiance );
    sky->cos_rotation = cosf( e->rotation );
    sky->sin_rotation = sinf( e->rotation );
    if ( e->map != NULL && !make_tables( sky, e ) )
    {
        rf_destroy_sky( sky );
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the distribution of an environment of %d x %d pixels",
                        e->width, e->height );
    }
    if ( !( sky->mean_luminance > 0.0f ) )
    {
        rf_destroy_sky( sky );
        return RF_OK;
    }
    sky->environment = e;
    return RF_OK;
}

void rf_destroy_sky( RfSky* sky )
{
    free( sky->row_cosine );
    free( sky->pixel );
    free( sky->cell );
    free( sky->sum );
    free( sky->guide );
    *sky = ( RfSky ){ 0 };
}

// The position of a direction on the map, in pixels.
typedef struct MapPosition
{
    float x, y;
} MapPosition;

static MapPosition position_of( const RfSky* sky, RfVec3 d )
{
    const RfEnvironment* e = sky->environment;
    float x = d.x * sky->cos_rotation - d.z * sky->sin_rotation; // undoes the rotation
    float z = d.x * sky->sin_rotation + d.z * sky->cos_rotation;
    float u = atan2f( x, -z ) * ( 0.5f * RF_INV_PI ) + 0.5f;
    float v = atan2f( sqrtf( x * x + z * z ), d.y ) * RF_INV_PI; // stays accurate at the poles
    return ( MapPosition ){ u * (float)e->width, v * (float)e->height };
}

static int clamp_index( float value, int count )
{
    int i = (int)value;
    return i < 0 ? 0 : ( i >= count ? count - 1 : i );
}

RfVec3 rf_sky_radiance( const RfSky* sky, RfVec3 wi )
{
    const RfEnvironment* e = sky->environment;
    if ( e->map == NULL )
        return e->radiance;
    MapPosition at = position_of( sky, wi );
    float left = floorf( at.x - 0.5f ), top = floorf( at.y - 0.5f );
    float fx = at.x - 0.5f - left, fy = at.y - 0.5f - top;
    const float* p[4];
    for ( int k = 0; k < 4; ++k )
        p[k] = pixel( e, (int)left + k % 2, (int)top + k / 2 );
    float c[3];
    for ( int i = 0; i < 3; ++i )
    {
        float upper = p[0][i] + fx * ( p[1][i] - p[0][i] ), lower = p[2][i] + fx * ( p[3][i] - p[2][i] );
        c[i] = upper + fy * ( lower - upper );
    }
    return rf_mul( e->radiance, rf_vec3( c[0], c[1], c[2] ) );
}

// A mixture of lobes, the cosines with the axes that a normal is between: `weight` sums up to 1 over what they send.
typedef struct Lobes
{
    int of[3];
    float weight[3];
    float sum; // of what they send; 0: nothing
} Lobes;

static Lobes find_lobes( const RfSky* sky, RfVec3 n )
{
    // in directions of the map
    float c = sky->cos_rotation, s = sky->sin_rotation;
    float x = n.x * c - n.z * s, z = n.x * s + n.z * c;
    Lobes lobes = { .of = { x < 0.0f, 2 + ( n.y < 0.0f ), 4 + ( z < 0.0f ) },
                    .weight = { fabsf( x ), fabsf( n.y ), fabsf( z ) } };
    for ( int k = 0; k < 3; ++k )
        lobes.sum += lobes.weight[k] * sky->total[lobes.of[k]];
    return lobes;
}

// Of the lobes together.
static float cell_probability( const RfSky* sky, const Lobes* lobes, int cell )
{
    const float* flux = sky->cell[cell].flux;
    float sum = 0.0f;
    for ( int k = 0; k < 3; ++k )
        sum += lobes->weight[k] * flux[lobes->of[k]];
    return sum / lobes->sum;
}

float rf_sky_pdf_solid_angle( const RfSky* sky, RfVec3 wi )
{
    const RfEnvironment* e = sky->environment;
    if ( e->map == NULL )
        return 0.25f * RF_INV_PI;
    MapPosition at = position_of( sky, wi );
    size_t pixel = pixel_index( sky, clamp_index( at.x, e->width ), clamp_index( at.y, e->height ) );
    float probability = sky->cell[pixel >> ( sky->column_bits + sky->row_bits )].flux[RF_SKY_SPHERE] / sky->total[RF_SKY_SPHERE];
    return probability * sky->pixel[pixel].density;
}

float rf_sky_pdf_solid_angle_at( const RfSky* sky, RfVec3 n, RfVec3 wi )
{
    const RfEnvironment* e = sky->environment;
    if ( e->map == NULL )
        return rf_maxf( rf_dot( n, wi ), 0.0f ) * RF_INV_PI;
    Lobes lobes = find_lobes( sky, n );
    if ( !( lobes.sum > 0.0f ) )
        return 0.0f;
    MapPosition at = position_of( sky, wi );
    size_t pixel = pixel_index( sky, clamp_index( at.x, e->width ), clamp_index( at.y, e->height ) );
    return cell_probability( sky, &lobes, (int)( pixel >> ( sky->column_bits + sky->row_bits ) ) ) * sky->pixel[pixel].density;
}

// A cell by a lobe; u in units of 2⁻³¹.
static int sample_cell( const RfSky* sky, int lobe, uint32_t u )
{
    const int32_t* guide =
        sky->guide + (size_t)lobe * ( ( (size_t)1 << sky->guide_bits ) + 1 ) + ( u >> ( 31 - sky->guide_bits ) );
    return find_cell( sky->sum + (size_t)lobe * ( (size_t)sky->cells + 1 ), guide[0], guide[1] + 1, u );
}

// Samples of a map on their way from a cell to a direction.
typedef struct SkyBlock
{
    _Alignas( 64 ) float weight[3][RF_SKY_LANES];       // of the lobes
    float sum[RF_SKY_LANES];                            // of what they send; 0: nothing arrives
    int32_t side[3][RF_SKY_LANES], lobe[RF_SKY_LANES];  // the lobes, and the one that the sample is of
    int32_t within[RF_SKY_LANES], length[RF_SKY_LANES]; // place in its distribution, in units of 2⁻³¹; its share, of 2⁻³⁰
    float probability[RF_SKY_LANES];                    // of the cell
    int32_t cell[RF_SKY_LANES];
    uint32_t pixel[RF_SKY_LANES];                   // number in its cell
    uint32_t part[RF_SKY_LANES];                    // decides between it and its alias, in units of 2⁻¹⁶
    _Alignas( 64 ) double x[RF_SKY_LANES];          // column, with the place in it
    double top[RF_SKY_LANES], bottom[RF_SKY_LANES]; // cosines at the ends of the row
} SkyBlock;

// Pixels of the cells, by their alias tables. A loop for each step, so that what it needs of large tables comes together.
static void find_pixels( const RfSky* sky, int count, const uint32_t* bits, const float* u, SkyBlock* b, float* pdf_solid_angle )
{
    int pixel_bits = sky->column_bits + sky->row_bits;
    for ( int i = 0; i < count; ++i )
    {
        b->pixel[i] = pixel_bits > 0 ? bits[i] >> ( 32 - pixel_bits ) : 0;
        b->part[i] = bits[i] >> ( 16 - pixel_bits ) & 0xffff;
        __builtin_prefetch( sky->pixel + ( ( (size_t)b->cell[i] << pixel_bits ) + b->pixel[i] ) );
    }
    for ( int i = 0; i < count; ++i )
    {
        const RfSkyPixel* pixels = sky->pixel + ( (size_t)b->cell[i] << pixel_bits );
        const RfSkyPixel* column = pixels + b->pixel[i];
        b->pixel[i] = b->part[i] < column->threshold ? b->pixel[i] : column->alias;
        __builtin_prefetch( pixels + b->pixel[i] );
    }
    for ( int i = 0; i < count; ++i )
    {
        const RfSkyCell* cell = sky->cell + b->cell[i];
        uint32_t pixel = b->pixel[i];
        uint32_t x = ( (uint32_t)cell->x << sky->column_bits ) + ( pixel & ( ( 1u << sky->column_bits ) - 1 ) );
        uint32_t y = ( (uint32_t)cell->y << sky->row_bits ) + ( pixel >> sky->column_bits );
        const double* ends = sky->row_cosine + y;
        b->x[i] = (double)(int32_t)x + (double)u[i];
        b->top[i] = ends[0];
        b->bottom[i] = ends[1];
        pdf_solid_angle[i] = b->probability[i] * sky->pixel[( (size_t)b->cell[i] << pixel_bits ) + pixel].density;
    }
}

// Directions within the pixels.
static void place_directions( const RfSky* sky, int count, const float* restrict v, const SkyBlock* restrict b,
                              float* const wi[3] )
{
    float* restrict x = wi[0], * restrict y = wi[1], * restrict z = wi[2];
    double width = sky->environment->width;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        double cos_up = b->top[i] + ( (double)v[i] + 0x1p-25 ) * ( b->bottom[i] - b->top[i] );
        RfVec3 d = direction_of( sky, (float)( ( b->x[i] + 0x1p-25 ) / width ), cos_up );
        x[i] = d.x;
        y[i] = d.y;
        z[i] = d.z;
    }
}

RfSkySample rf_sample_sky( const RfSky* sky, const uint32_t bits[2], const float u[2] )
{
    RfSkySample sample = { .pdf_solid_angle = 0.25f * RF_INV_PI };
    if ( sky->environment->map != NULL )
    {
        SkyBlock block;
        float* wi[3] = { &sample.wi.x, &sample.wi.y, &sample.wi.z };
        int cell = block.cell[0] = sample_cell( sky, RF_SKY_SPHERE, bits[0] >> 1 );
        block.probability[0] = sky->cell[cell].flux[RF_SKY_SPHERE] / sky->total[RF_SKY_SPHERE];
        find_pixels( sky, 1, bits + 1, u, &block, &sample.pdf_solid_angle );
        place_directions( sky, 1, u + 1, &block, wi );
    }
    else
        sample.wi = direction_of( sky, u[0], 1.0 - 2.0 * (double)u[1] );
    sample.radiance = rf_sky_radiance( sky, sample.wi );
    return sample;
}

// Cosine-weighted, for a sky that is the same everywhere.
static void sample_even_sky( int count, const RfSkyLanes* lanes )
{
    for ( int i = 0; i < count; ++i )
    {
        float sine, cosine, up = sqrtf( 1.0f - lanes->u[1][i] ), across = sqrtf( lanes->u[1][i] );
        RfVec3 t, b, n = RF_GET3( lanes->n, i );
        rf_basis( n, &t, &b );
        rf_sincos_2pi( lanes->u[0][i], &sine, &cosine );
        RfVec3 wi = rf_madd( rf_add( rf_scale( t, across * cosine ), rf_scale( b, across * sine ) ), n, up );
        RF_PUT3( lanes->wi, i, wi );
        lanes->pdf_solid_angle[i] = up * RF_INV_PI;
    }
}

// The lobes of a normal (find_lobes), and by a number one of them in proportion to what they send.
static void select_lobes( const RfSky* sky, int count, const float* const n[3], const uint32_t* restrict bits,
                          SkyBlock* restrict b )
{
    const float *nx = n[0], *ny = n[1], *nz = n[2], *total = sky->total;
    float c = sky->cos_rotation, s = sky->sin_rotation;
    float of_x[2] = { total[0], total[1] }, of_y[2] = { total[2], total[3] }, of_z[2] = { total[4], total[5] };
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        float x = nx[i] * c - nz[i] * s, y = ny[i], z = nx[i] * s + nz[i] * c;
        float part_x = fabsf( x ) * ( x < 0.0f ? of_x[1] : of_x[0] );
        float part_y = fabsf( y ) * ( y < 0.0f ? of_y[1] : of_y[0] );
        float part_z = fabsf( z ) * ( z < 0.0f ? of_z[1] : of_z[0] );
        int side_x = x < 0.0f ? 1 : 0, side_y = y < 0.0f ? 3 : 2, side_z = z < 0.0f ? 5 : 4;
        float sum = part_x + part_y + part_z, scale = sum > 0.0f ? 0x1p30f : 0.0f, divisor = sum > 0.0f ? sum : 1.0f;
        // in units of 2⁻³⁰: a lobe that sends nothing is of no length
        int32_t first = (int32_t)( part_x / divisor * scale ), second = (int32_t)( ( part_x + part_y ) / divisor * scale );
        int32_t position = (int32_t)( bits[i] >> 2 );
        int32_t start = position >= first ? first : 0, end = position >= first ? second : first;
        int lobe = position >= first ? side_y : side_x;
        start = position >= second ? second : start;
        end = position >= second ? 1 << 30 : end;
        lobe = position >= second ? side_z : lobe;
        b->weight[0][i] = fabsf( x );
        b->weight[1][i] = fabsf( y );
        b->weight[2][i] = fabsf( z );
        b->side[0][i] = side_x;
        b->side[1][i] = side_y;
        b->side[2][i] = side_z;
        b->sum[i] = sum;
        b->lobe[i] = lobe;
        b->within[i] = position - start;
        b->length[i] = end - start;
    }
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        b->within[i] = (int32_t)( (double)b->within[i] / (double)b->length[i] * 0x1p31 );
}

static void find_cells( const RfSky* sky, int count, SkyBlock* b )
{
    for ( int i = 0; i < count; ++i )
    {
        int cell = b->cell[i] = sample_cell( sky, b->lobe[i], (uint32_t)b->within[i] );
        const float* flux = sky->cell[cell].flux;
        float sent =
            b->weight[0][i] * flux[b->side[0][i]] + b->weight[1][i] * flux[b->side[1][i]] + b->weight[2][i] * flux[b->side[2][i]];
        b->probability[i] = b->sum[i] > 0.0f ? sent / b->sum[i] : 0.0f;
    }
}

void rf_sample_sky_directions( const RfSky* sky, int count, const RfSkyLanes* lanes )
{
    if ( sky->environment->map == NULL )
    {
        sample_even_sky( count, lanes );
        return;
    }
    SkyBlock block;
    select_lobes( sky, count, lanes->n, lanes->bits[0], &block );
    find_cells( sky, count, &block );
    find_pixels( sky, count, lanes->bits[1], lanes->u[0], &block, lanes->pdf_solid_angle );
    place_directions( sky, count, lanes->u[1], &block, lanes->wi );
}
