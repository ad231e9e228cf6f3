#include "support/unbiased.h"

#include "support/reference_tracer.h"
#include "support/statistics.h"

#include <math.h>
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define REFERENCE_SEED 1000003 // far from the seeds of the renders

static float* alloc_image( const RfEye* eye )
{
    float* rgb = malloc( 3 * (size_t)eye->width * (size_t)eye->height * sizeof( float ) );
    if ( rgb == NULL )
        abort();
    return rgb;
}

static Images reference_of( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings,
                            bool panes_are_vertices )
{
    Images images = { .width = eyes->width, .height = eyes->height, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
        images.rgb[k] = alloc_image( eyes );
#pragma omp parallel for schedule( dynamic, 1 )
    for ( int k = 0; k < SEEDS; ++k )
    {
        ReferenceSettings plain = {
            .spp = spp,
            .max_depth = settings->max_depth,
            .light_samples = settings->light_samples,
            .seed = (uint64_t)( REFERENCE_SEED + k ),
            .frame = frame,
            .light_sampling = settings->light_sampling,
            .panes_are_vertices = panes_are_vertices,
        };
        reference_image( tracer, eyes + frame, &plain, images.rgb[k] );
    }
    return images;
}

Images reference_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings )
{
    return reference_of( tracer, eyes, frame, spp, settings, false );
}

Images pane_vertex_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings )
{
    return reference_of( tracer, eyes, frame, spp, settings, true );
}

Images rendered_images( const RfTracer* tracer, const RfEye* eyes, int eye_count, int frame, RfRenderSettings settings )
{
    Images images = { .width = eyes->width, .height = eyes->height, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = (uint64_t)( k + 1 );
        Rendered rendered = render_frames( tracer, eyes, eye_count, &frame, 1, &settings );
        images.rgb[k] = alloc_image( eyes );
        memcpy( images.rgb[k], rendered.rgb, 3 * rendered.pixels * sizeof( float ) );
        free_rendered( &rendered );
    }
    return images;
}

void free_images( Images* images )
{
    for ( int k = 0; k < images->count; ++k )
        free( images->rgb[k] );
    *images = ( Images ){ 0 };
}

static double block_mean( const Images* images, int k, int x0, int y0, int x1, int y1 )
{
    double sum = 0.0;
    for ( int y = y0; y < y1; ++y )
    {
        for ( int x = x0; x < x1; ++x )
        {
            const float* p = images->rgb[k] + 3 * ( (size_t)y * (size_t)images->width + (size_t)x );
            sum += 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
        }
    }
    return sum / ( ( x1 - x0 ) * ( y1 - y0 ) );
}

// Both samples are one number but for the rounding of film sums (n·2⁻²⁵ after n
// passes): sky, black. Nothing is left to a test, and its p would be no draw.
static bool are_constant( const double* a, int count_a, const double* b, int count_b )
{
    double low = a[0], high = a[0];
    for ( int k = 0; k < count_a + count_b; ++k )
    {
        double v = k < count_a ? a[k] : b[k - count_a];
        low = v < low ? v : low;
        high = v > high ? v : high;
    }
    return high - low <= 3e-5 * fabs( high );
}

// Of the means of a block. Where there is nothing to test their count is 0.
static void block_samples( const Images* a, const Images* b, int x0, int y0, int x1, int y1, Sample* of_a, Sample* of_b )
{
    double va[SEEDS] = { 0 }, vb[SEEDS] = { 0 };
    for ( int k = 0; k < a->count; ++k )
        va[k] = block_mean( a, k, x0, y0, x1, y1 );
    for ( int k = 0; k < b->count; ++k )
        vb[k] = block_mean( b, k, x0, y0, x1, y1 );
    *of_a = sample_of( va, a->count );
    *of_b = sample_of( vb, b->count );
    if ( are_constant( va, a->count, vb, b->count ) )
        of_a->count = of_b->count = 0;
}

static Verdict whole_verdict( const Images* a, const Images* b )
{
    Sample of_a, of_b;
    block_samples( a, b, 0, 0, a->width, a->height, &of_a, &of_b );
    return ( Verdict ){
        .whole_off = of_a.mean / of_b.mean - 1.0,
        .whole_error = sqrt( of_a.variance + of_b.variance ) / of_b.mean,
        .whole_p = of_a.count > 0 ? welch_of( of_a, of_b ) : -1.0,
    };
}

Verdict compare_images( const char* what, const Images* a, const Images* b, int block )
{
    int across = ( a->width + block - 1 ) / block, down = ( a->height + block - 1 ) / block, count = across * down;
    Sample *of_a = malloc( (size_t)count * sizeof *of_a ), *of_b = malloc( (size_t)count * sizeof *of_b );
    double* p = malloc( (size_t)count * sizeof *p );
    if ( p == NULL || of_a == NULL || of_b == NULL )
        abort();
    for ( int i = 0; i < count; ++i )
    {
        int x0 = i % across * block, y0 = i / across * block;
        int x1 = x0 + block < a->width ? x0 + block : a->width, y1 = y0 + block < a->height ? y0 + block : a->height;
        block_samples( a, b, x0, y0, x1, y1, of_a + i, of_b + i );
    }
    int tested = 0;
    double smallest = 1.0;
    for ( int i = 0; i < count; ++i )
    {
        if ( of_a[i].count == 0 )
            continue;
        double here = place_p( of_a, of_b, across, down, i );
        smallest = fmin( smallest, here );
        p[tested++] = welch_of( of_a[i], of_b[i] );
        if ( what != NULL && block > 1 && here < FIRST_LEVEL )
            printf( "%s block %d,%d is off by %.2f %%, p %.2g\n", what, i % across * block, i / across * block,
                    100.0 * ( of_a[i].mean / of_b[i].mean - 1.0 ), here );
    }
    if ( tested == 0 )
        abort(); // a test of nothing
    Verdict v = whole_verdict( a, b );
    v.uniform_p = uniform_p( p, tested );
    v.smallest_p = 1.0 - pow( 1.0 - smallest, tested );
    free( of_a );
    free( of_b );
    free( p );
    return v;
}

void assert_unbiased( const char* what, const Images* rendered, const Images* reference, int block )
{
    Verdict b = compare_images( what, rendered, reference, block ), p = compare_images( what, rendered, reference, 1 );
    printf( "%-34s whole %+.3f %% ± %.3f %%, p %.3g, per block smallest p %.3g, uniform p %.3g; per pixel smallest p %.3g\n",
            what, 100.0 * b.whole_off, 100.0 * b.whole_error, b.whole_p, b.smallest_p, b.uniform_p, p.smallest_p );
    assert_true( is_likely( b.whole_p ) );
    assert_true( is_likely( b.smallest_p ) );
    assert_true( is_likely( b.uniform_p ) );
    assert_true( is_likely( p.smallest_p ) );
}
