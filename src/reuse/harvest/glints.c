// Foresees glints: pixels in which few first hits bring most of the light, since they mirror a lamp, or show one.
// The spread of the normals around a hit widens its lobe (Kaplanyan, Hill, Patney, Lefohn, Filtering Distributions of Normals
// for Shading Antialiasing, HPG 2016): the light of the wide lobe is the pixel's mean, that of the lobe itself its peak.
#include "reuse/harvest/glints.h"

#include "reuse/harvest/camera_rays.h"

#include "scene/textured.h"

#include <math.h>

#define PART 8       // pixels, the side of a part of a block
#define COPIES 6     // rays of each pixel of a part with thin or curved surfaces
#define SOME 2       // of these, with which hits are compared
#define CURVED 2e-3f // the spread of normals from which a surface is
// Variance of a normal in a pixel over the mean square by which it differs from those of the pixels around it: twice that of
// a place in a pixel, which for a gradient of any direction is half of it.
#define PIXEL_SPREAD 0.3f
#define LONE_SPREAD 0.1f // where no pixel around sees the material
#define LEAST_SPREAD 1e-6f
#define BASE_REFLECTANCE 0.1f // of what a surface is besides its lobe, 1/sr
#define LEAST_FRESNEL 0.04f
#define LEAST_COSINE 0.05f

// Pixels of the first camera, with the lanes of their rays.
typedef struct Block
{
    int x0, y0, width, height, copies;             // rays per pixel
    int16_t lane[RF_GLINT_BLOCK * RF_GLINT_BLOCK]; // of `first`, by slot; −1: the ray hit nothing
} Block;

_Static_assert( PART* PART* COPIES <= RF_GLINT_BLOCK * RF_GLINT_BLOCK && RF_GLINT_BLOCK % PART == 0, "parts of a block" );

static int pixels_of( const Block* b ) { return b->width * b->height; }

static bool is_inside( const Block* b, int x, int y ) { return x >= 0 && y >= 0 && x < b->width && y < b->height; }

static int lane_at( const Block* b, int x, int y, int copy )
{
    if ( !is_inside( b, x, y ) )
        return -1;
    return b->lane[copy * pixels_of( b ) + y * b->width + x];
}

static size_t film_pixel( const Block* b, const RfEye* eye, int slot )
{
    int k = slot % pixels_of( b );
    return (size_t)( b->y0 + k / b->width ) * (size_t)eye->width + (size_t)( b->x0 + k % b->width );
}

static float mean_of( RfVec3 v ) { return ( v.x + v.y + v.z ) * ( 1.0f / 3.0f ); }

static float alpha_of( const RfVertexLanes* v, int i )
{
    return rf_narrowest_alpha( rf_kind_of_lane( v, i ), v->param[RF_PARAM_SHAPE][i], v->param[RF_PARAM_CLEARCOAT_ALPHA][i] );
}

// Symmetric, 2 × 2.
typedef struct Spread
{
    float xx, xy, yy;
} Spread;

static RfVec3 half_vector( RfVec3 a, RfVec3 b ) { return rf_normalize( rf_add( a, b ) ); }

// How the half vector for light from wi differs from the normal.
static RfVec3 deviation( RfVertexLanes* v, int i, RfVec3 wi )
{
    return rf_sub( half_vector( RF_GET3( v->wo, i ), wi ), RF_GET3( v->n, i ) );
}

// The covariance of the deviation in the pixel of lane i, by some hits on the material in this pixel and those around it.
static Spread find_spread( RfVertexLanes* v, const Block* block, int i, RfVec3 wi, RfVec3 t, RfVec3 b )
{
    Spread sum = { 0 };
    RfVec3 own = deviation( v, i, wi );
    int slot = v->slot[i], pixel = slot % pixels_of( block ), copy = slot / pixels_of( block );
    float count = 0.0f;
    for ( int k = 0; k < 9 * SOME; ++k )
    {
        int dx = k % 3 - 1, dy = k / 3 % 3 - 1;
        int j = lane_at( block, pixel % block->width + dx, pixel / block->width + dy, ( copy + k / 9 ) % block->copies );
        if ( j < 0 || j == i || v->material[j] != v->material[i] )
            continue;
        RfVec3 d = rf_sub( deviation( v, j, wi ), own );
        float dt = rf_dot( d, t ), db = rf_dot( d, b ), scale = 1.0f / ( (float)( dx * dx + dy * dy ) + 1.0f / 3.0f );
        sum.xx += dt * dt * scale;
        sum.xy += dt * db * scale;
        sum.yy += db * db * scale;
        count += 1.0f;
    }
    float scale = count > 0.0f ? PIXEL_SPREAD / count : 0.0f, least = count > 0.0f ? LEAST_SPREAD : LONE_SPREAD;
    return ( Spread ){ sum.xx * scale + least, sum.xy * scale, sum.yy * scale + least };
}

static float gaussian( Spread c, float x, float y )
{
    float det = rf_maxf( c.xx * c.yy - c.xy * c.xy, 1e-16f );
    float e = ( c.yy * x * x - 2.0f * c.xy * x * y + c.xx * y * y ) / det;
    return expf( -0.5f * rf_minf( e, 80.0f ) ) * ( 0.5f * RF_INV_PI ) / sqrtf( det );
}

// What one light sample at hit i, `k` among the sharp ones, brings to its pixel.
static void add_light( RfVertexLanes* v, const Block* block, int i, const RfLightLanes* light, int k, RfVec3 lobe, float* sum )
{
    RfVec3 wi = RF_GET3( (float( * )[RF_LANES])light->wi, k ), wo = RF_GET3( v->wo, i ), n = RF_GET3( v->n, i );
    float cos_lobe = rf_dot( lobe, wi ), pdf = light->pdf_solid_angle[k];
    float radiance = mean_of( RF_GET3( (float( * )[RF_LANES])light->radiance_cos, k ) );
    if ( !( radiance > 0.0f ) || !( pdf > 0.0f ) || !( cos_lobe > 0.0f ) )
        return;
    radiance /= cos_lobe;
    float alpha = alpha_of( v, i ), all = radiance / pdf, cos_o = rf_maxf( rf_dot( n, wo ), LEAST_COSINE );
    RfVec3 t, b;
    rf_basis( n, &t, &b );
    Spread spread = find_spread( v, block, i, wi, t, b );
    spread.xx += 0.5f * alpha * alpha;
    spread.yy += 0.5f * alpha * alpha;
    RfVec3 d = deviation( v, i, wi );
    float grazing = 1.0f - rf_dot( half_vector( wo, wi ), wo ),
          f0 = rf_maxf( mean_of( RF_GET3( v->param + RF_PARAM_SPECULAR, i ) ), LEAST_FRESNEL );
    float fresnel = f0 + ( 1.0f - f0 ) * grazing * grazing * grazing * grazing * grazing;
    float reflected = fresnel * all / ( 4.0f * cos_o );
    float mean = reflected * gaussian( spread, rf_dot( d, t ), rf_dot( d, b ) );
    // a lobe mirrors no more than the radiance of the lamp, nor a lamp without size more than the lobe's peak
    bool point = pdf > 0x1p40f;
    float peak = alpha > 0.0f ? reflected * RF_INV_PI / ( alpha * alpha ) : point ? 0.0f : INFINITY;
    peak = point ? peak : rf_minf( peak, fresnel * radiance );
    float share = 1.0f / COPIES;
    sum[0] += share * mean;
    sum[1] += share * mean * peak;
    sum[2] += share * BASE_REFLECTANCE * all * rf_maxf( rf_dot( n, wi ), 0.0f );
}

// The hits with sharp lobes, with the lobe's direction in place of the normal, by which light samples are drawn.
static int gather_sharp( RfVertexLanes* v, int32_t* of, RfVertexLanes* out )
{
    int count = 0;
    for ( int i = v->first[RF_BSDF_FIRST_GLOSSY]; i < v->count; ++i )
    {
        if ( !( alpha_of( v, i ) < RF_SHARP_ALPHA ) )
            continue;
        rf_copy_vertices( v, i, 1, 0, out, count );
        RfVec3 wo = RF_GET3( v->wo, i ), n = RF_GET3( v->n, i ), lobe = rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo );
        RF_PUT3( out->n, count, lobe );
        of[count++] = i;
    }
    out->count = count;
    return count;
}

// Mean and mean square of the emission around each pixel.
static void add_emission( RfVertexLanes* v, const Block* block, const RfEye* eye, float* sums )
{
    bool any = false;
    for ( int i = 0; i < v->count; ++i )
        any = any || v->emission[0][i] + v->emission[1][i] + v->emission[2][i] > 0.0f;
    for ( int p = 0; p < pixels_of( block ) && any; ++p )
    {
        float mean = 0.0f, square = 0.0f, count = 0.0f;
        for ( int k = 0; k < 9; ++k )
        {
            int j = lane_at( block, p % block->width + k % 3 - 1, p / block->width + k / 3 - 1, 0 );
            float e = j >= 0 ? mean_of( RF_GET3( v->emission, j ) ) : 0.0f;
            mean += e;
            square += e * e;
            count += j >= 0 ? 1.0f : 0.0f;
        }
        float* sum = sums + 4 * film_pixel( block, eye, p );
        sum[0] += count > 0.0f ? mean / count : 0.0f;
        sum[1] += count > 0.0f ? square / count : 0.0f;
    }
}

// First hits of `copies` rays for each pixel, with random numbers of the passes from `pass` on.
static Block trace_block( const RfHarvest* at, int x0, int y0, int side, int copies, int pass, RfHarvestScratch* scratch,
                          RfRayCounts* rays )
{
    const RfEye* eye = at->eyes;
    RfWavefront* wavefront = &scratch->wavefront;
    wavefront->lattice.vertex = 0;
    Block b = { .x0 = x0, .y0 = y0, .copies = copies };
    b.width = eye->width - x0 < side ? eye->width - x0 : side;
    b.height = eye->height - y0 < side ? eye->height - y0 : side;
    int count = pixels_of( &b ) * copies;
    for ( int slot = 0; slot < count; ++slot )
    {
        scratch->pixel[slot] = (int32_t)film_pixel( &b, eye, slot );
        RfRandomKey key = rf_pixel_key( rf_harvest_key( at, 0, pass + slot / pixels_of( &b ) ), (uint32_t)scratch->pixel[slot] );
        wavefront->key_a[slot] = key.a;
        wavefront->key_b[slot] = key.b;
    }
    rf_make_camera_rays( NULL, eye, count, scratch->pixel, wavefront, &scratch->camera_rays );
    rf_find_vertices( &at->path, &scratch->camera_rays, true, &scratch->first, &wavefront->scratch );
    rays->primary += (uint64_t)count;
    for ( int slot = 0; slot < count; ++slot )
        b.lane[slot] = -1;
    for ( int i = 0; i < scratch->first.count; ++i )
        b.lane[scratch->first.slot[i]] = (int16_t)i;
    return b;
}

// Whether what a hit mirrors may differ much within its pixel: its surface is curved there, or ends.
static bool is_thin_or_curved( RfVertexLanes* v, const Block* block, int i )
{
    int pixel = v->slot[i], x = pixel % block->width, y = pixel / block->width;
    for ( int k = 0; k < 9; ++k )
    {
        int nx = x + k % 3 - 1, ny = y + k / 3 - 1, j = lane_at( block, nx, ny, 0 );
        if ( is_inside( block, nx, ny ) && ( j < 0 || v->material[j] != v->material[i] ) )
            return true;
    }
    RfVec3 t, b, n = RF_GET3( v->n, i );
    rf_basis( n, &t, &b );
    Spread spread = find_spread( v, block, i, n, t, b );
    return spread.xx + spread.yy > CURVED;
}

// The parts of a block in which such hits with sharp lobes are.
static void find_parts( RfVertexLanes* v, const Block* block, bool* parts )
{
    for ( int i = v->first[RF_BSDF_FIRST_GLOSSY]; i < v->count; ++i )
    {
        int x = v->slot[i] % block->width, y = v->slot[i] / block->width;
        bool* part = parts + y / PART * ( RF_GLINT_BLOCK / PART ) + x / PART;
        *part = *part || ( alpha_of( v, i ) < RF_SHARP_ALPHA && is_thin_or_curved( v, block, i ) );
    }
}

// One light sample for each hit of a part.
static void add_part( const RfHarvest* at, int x0, int y0, float* sums, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfVertexLanes *v = &scratch->first, *sharp = &scratch->wavefront.vertices;
    Block block = trace_block( at, x0, y0, PART, COPIES, 1, scratch, rays );
    int32_t of[RF_LANES];
    int found = gather_sharp( v, of, sharp );
    if ( found == 0 )
        return;
    rays->shadow += (uint64_t)rf_sample_lights( &at->path, &scratch->wavefront, sharp,
                                                ( RfLightSample ){ .dimension = RF_DIMENSION_FIRST_VERTEX }, scratch->direct,
                                                &scratch->wavefront.scratch );
    for ( int k = 0; k < found; ++k )
    {
        float* sum = sums + 4 * film_pixel( &block, at->eyes, v->slot[of[k]] );
        add_light( v, &block, of[k], scratch->direct, k, RF_GET3( sharp->n, k ), sum );
        sum[3] += 1.0f / COPIES;
    }
}

void rf_add_glints( const RfHarvest* given, int job, float* sums, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfHarvest at = rf_harvest_at( given, 0, rf_draw_lens( given, ( RfTraceJob ){ .job = job } ), scratch );
    int across = ( at.eyes->width + RF_GLINT_BLOCK - 1 ) / RF_GLINT_BLOCK;
    int x0 = job % across * RF_GLINT_BLOCK, y0 = job / across * RF_GLINT_BLOCK;
    Block block = trace_block( &at, x0, y0, RF_GLINT_BLOCK, 1, 0, scratch, rays );
    add_emission( &scratch->first, &block, at.eyes, sums );
    enum
    {
        PARTS = RF_GLINT_BLOCK / PART
    };
    bool parts[PARTS * PARTS] = { false };
    find_parts( &scratch->first, &block, parts );
    for ( int k = 0; k < PARTS * PARTS; ++k )
    {
        if ( parts[k] )
            add_part( &at, x0 + k % PARTS * PART, y0 + k / PARTS * PART, sums, scratch, rays );
    }
}
