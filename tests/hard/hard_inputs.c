// Hard cases that are no pictures: projections, rays by the million, sums, halves, rounding, linear systems.
#include "base/random.h"
#include "bsdf/bsdf.h"
#include "film/film.h"
#include "hard/hard.h"
#include "image/half.h"
#include "math/fastmath.h"
#include "reframe/reconstruct.h"
#include "scene/projection.h"
#include "trace/trace.h"

#include <fenv.h>
#include <math.h>
#include <pmmintrin.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#ifdef REFRAME_SANITIZED
#define MANY 20000
#else
#define MANY 400000
#endif

#define PASS( ... )                                                                                                              \
    do                                                                                                                           \
    {                                                                                                                            \
        snprintf( out.text, sizeof out.text, __VA_ARGS__ );                                                                      \
        return out;                                                                                                              \
    } while ( 0 )

static float even( uint32_t i, uint32_t k ) { return rf_random( rf_pixel_key( rf_pass_key( 77, 0, 0, 0 ), i ), k ); }

// Points on the film's border and on corners of pixels, on their rays: their projection must be where the ray started, but for
// rounding, never outside the film, nor a pixel beside it that the place does not touch.
static HardInput film_corners( void )
{
    HardInput out = { 0 };
    static const int sizes[][2] = { { 16384, 1 }, { 640, 480 }, { 1, 1 }, { 4096, 2160 } };
    static const double angles[] = { 1.0, 50.0, 170.0 };
    double worst = 0.0;
    long lost = 0, all = 0;
    for ( int s = 0; s < 12; ++s )
    {
        int w = sizes[s / 3][0], hgt = sizes[s / 3][1];
        RfVec3 forward = rf_vec3( 0.3f, -0.4f, -1.0f );
        RfEye eye = rf_make_eye( rf_vec3( 1.5f, 0.7f, -2.0f ), forward, rf_vec3( 0, 1, 0 ),
                                 angles[s % 3] * 3.14159265358979 / 180.0, w, hgt );
        const float inverse[2] = { 1.0f / eye.focal_x, 1.0f / eye.focal };
        for ( uint32_t i = 0; i < MANY; ++i, ++all )
        {
            int x = (int)( even( i, 0 ) * (float)w ), y = (int)( even( i, 1 ) * (float)hgt );
            x = i % 8 == 0 ? 0 : i % 8 == 1 ? w - 1 : x;
            y = i % 8 == 2 ? 0 : i % 8 == 3 ? hgt - 1 : y;
            float u = i % 3 == 0   ? 0.0f
                      : i % 3 == 1 ? 0x1.fffffep-1f
                                   : even( i, 2 ),
                  v = i % 5 == 0   ? 0.0f
                      : i % 5 == 1 ? 0x1.fffffep-1f
                                   : 0.5f;
            RfVec3 d = rf_pinhole_ray( &eye, inverse, x, y, u, v ), p = rf_madd( eye.origin, d, 3.0f );
            RfProjection at = rf_project( &eye, p, rf_scale( d, -1.0f ) );
            lost += !at.seen;
            if ( !at.seen )
                continue;
            double off = fmax( fabs( (double)at.x + (double)at.u - (double)x - (double)u ) / w,
                               fabs( (double)at.y + (double)at.v - (double)y - (double)v ) / hgt );
            off /= 1.0 + (double)( eye.width > eye.height ? eye.width : eye.height ) /
                             (double)eye.focal; // steep rays turn rounding into more
            worst = fmax( worst, off );
            if ( at.x < 0 || at.x >= w || at.y < 0 || at.y >= hgt ||
                 !( at.u >= 0.0f && at.u <= 1.0f && at.v >= 0.0f && at.v <= 1.0f ) ||
                 !( at.density >= RF_MIN_DENSITY && at.density <= RF_MAX_DENSITY ) )
                PASS( "ray %u of film %dx%d lands outside", i, w, hgt );
        }
    }
    out.holds = worst < 1e-5 && lost < all / 2;
    PASS( "%.1f million hits: off by %.2g of the film at most, %ld rounded out of it at its border", (double)all / 1e6, worst,
          lost );
}

// Frames of eyes whose up vector is as good as parallel to the view: unit vectors at right angles.
static HardInput eye_frames( void )
{
    HardInput out = { 0 };
    double worst = 0.0;
    for ( uint32_t i = 0; i < MANY; ++i )
    {
        float off = powf( 10.0f, -1.0f - 5.5f * even( i, 0 ) ), sign = i % 2 == 0 ? 1.0f : -1.0f;
        RfVec3 f = rf_vec3( even( i, 1 ) - 0.5f, even( i, 2 ) - 0.5f, 0.1f + even( i, 3 ) );
        RfVec3 up = rf_vec3( sign * f.x + off, sign * f.y - off * even( i, 4 ), sign * f.z );
        RfEye e = rf_make_eye( rf_vec3( 0, 0, 0 ), f, up, 1.0, 4, 4 );
        const RfVec3 axes[3] = { e.right, e.up, e.forward };
        for ( int k = 0; k < 9; ++k )
            worst = fmax( worst, fabs( (double)rf_dot( axes[k / 3], axes[k % 3] ) - ( k / 3 == k % 3 ? 1.0 : 0.0 ) ) );
    }
    out.holds = worst < 1e-6;
    PASS( "%.1f million eyes with up vectors 0.1 to 3e-7 off the view: axes at right angles within %.2g", MANY / 1e6, worst );
}

// Whatever point and normal: the density is a number in its range, and the pixel is on the film.
static HardInput projections( void )
{
    HardInput out = { .holds = true };
    long seen = 0;
    for ( uint32_t i = 0; i < 4 * MANY; ++i )
    {
        float scale = powf( 10.0f, 76.0f * even( i, 0 ) - 38.0f ), far = powf( 10.0f, 76.0f * even( i, 1 ) - 38.0f );
        RfVec3 o = rf_vec3( scale * even( i, 2 ), scale * even( i, 3 ), -scale * even( i, 4 ) );
        RfEye eye = rf_make_eye( o, rf_vec3( even( i, 5 ) - 0.5f, even( i, 6 ) - 0.5f, even( i, 7 ) - 0.501f ),
                                 rf_vec3( 0, 1, 0 ), (double)( 1e-4f + 3.1f * even( i, 8 ) ), 16, 12 );
        RfVec3 way =
            rf_madd( rf_madd( rf_scale( eye.forward, far ), eye.right, 0.1f * far * even( i, 10 ) ), eye.up, far * 1e-3f );
        RfVec3 x = rf_add( o, way ),
               n = rf_normalize( rf_vec3( even( i, 11 ) - 0.5f, even( i, 12 ) - 0.5f, even( i, 13 ) - 0.5f ) );
        RfProjection at = rf_project( &eye, x, n );
        bool fits = at.density >= RF_MIN_DENSITY && at.density <= RF_MAX_DENSITY;
        if ( !fits || at.x < 0 || at.x >= 16 || at.y < 0 || at.y >= 12 )
        {
            out.holds = false;
            PASS( "density %g of point %u, distance %g", (double)at.density, i, (double)far );
        }
        seen += at.seen;
    }
    out.holds = seen > MANY / 100;
    PASS( "%.1f million points at 1e-38 to 1e38 m: all densities within [1e-24, 1e30]", 4.0 * MANY / 1e6 );
}

static bool reaches( const RfTracer* tracer, RfVec3 from, RfVec3 to )
{
    RfVec3 way = rf_sub( to, from );
    const float *o[3] = { &from.x, &from.y, &from.z }, *d[3] = { &way.x, &way.y, &way.z };
    float visible;
    rf_trace_segments( tracer, 1, o, d, &visible );
    return visible > 0.0f;
}

// Rays onto the faces of a turned box, from inside: what leaves a hit must see the middle (acne if not), and
// nothing outside (a leak if it does). At scales of 1e-12 to 1e12, and far from the origin.
static HardInput acne_and_leaks( void )
{
    HardInput out = { 0 };
    long acne = 0, leaks = 0, hits = 0;
    for ( int s = -12; s <= 12; s += 4 )
    {
        for ( int moved = 0; moved < 2; ++moved )
        {
            HardScene h = { 0 };
            SceneBuilder b = { 0 };
            uint32_t grey = add_material( &b, hard_grey() );
            add_box( &b, grey, rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), true );
            for ( uint32_t i = 0; i < b.scene.triangles.vertex_count; ++i ) // turned about two axes
            {
                float *p = b.scene.triangles.positions + 3 * (size_t)i, x = p[0], y = p[1];
                p[0] = 0.8f * x - 0.6f * y;
                p[1] = 0.6f * x + 0.8f * y;
                y = p[1];
                p[1] = 0.28f * y - 0.96f * p[2];
                p[2] = 0.96f * y + 0.28f * p[2];
            }
            h.scene = finish_scene( &b );
            float scale = powf( 10.0f, (float)s );
            RfVec3 shift = rf_scale( rf_vec3( 300, -100, 200 ), moved ? scale : 0.0f );
            hard_move( &h, scale, shift );
            RfTracer* tracer = make_tracer( &h.scene );
            for ( uint32_t i = 0; i < MANY / 40; ++i )
            {
                RfVec3 d = rf_normalize( rf_vec3( even( i, 0 ) - 0.5f, even( i, 1 ) - 0.5f, even( i, 2 ) - 0.5f ) );
                RfVec3 from = rf_add( shift, rf_scale( rf_vec3( 0.3f * even( i, 3 ), 0.3f * even( i, 4 ), 0 ), scale ) );
                const float *o[3] = { &from.x, &from.y, &from.z }, *way[3] = { &d.x, &d.y, &d.z };
                uint32_t triangle;
                float u, v;
                rf_trace_nearest( tracer, 1, o, way, false, &triangle, &u, &v );
                if ( triangle == RF_MISS )
                {
                    leaks += 1;
                    continue;
                }
                const RfTriangleRecord* t = rf_tracer_triangles( tracer ) + triangle;
                RfHitPoint hit = rf_hit_point( t, u, v, from, d );
                RfVec3 start = rf_madd( hit.p, t->ng, hit.offset );
                hits += 1;
                acne += !reaches( tracer, start, shift ) || !reaches( tracer, shift, start );
                leaks += reaches( tracer, start, rf_madd( shift, d, 4.0f * scale ) );
            }
            rf_destroy_tracer( tracer );
            rf_destroy_scene( &h.scene );
        }
    }
    out.holds = acne == 0 && leaks == 0 && hits > MANY / 8;
    PASS( "%ld hits at scales of 1e-12 to 1e12: %ld with acne, %ld leaks", hits, acne, leaks );
}

// The sum of 2^20 samples of a constant by a film, as renders add them up.
static HardInput long_sums( void )
{
    HardInput out = { 0 };
    double worst = 0.0;
    static const float values[] = { 0.1f, 1.0f / 3.0f, 1e-30f, 1e30f };
    for ( int v = 0; v < 4; ++v )
    {
        float half[2][4] = { { 0 } }, rgb[3], weight;
        double total[2][4] = { { 0 } };
        RfFilm film = { .width = 1, .height = 1, .half = { half[0], half[1] }, .total = { total[0], total[1] } };
        film.total_every = rf_film_total_every( 1 );
        for ( int pass = 0; pass < 1 << 20; ++pass )
        {
            for ( int c = 0; c < 4; ++c )
                film.half[pass & 1][c] += c < 3 ? values[v] : 1.0f;
            rf_end_film_pass( &film, pass & 1, 1.0 );
        }
        rf_combine_film( &film, RF_FILM_CROSSFIT, rgb, &weight );
        worst = fmax( worst, fabs( (double)rgb[0] / (double)values[v] - 1.0 ) );
        worst = fmax( worst, fabs( (double)weight - 1.0 ) );
    }
    out.holds = worst < 1e-5;
    PASS( "2^20 samples of a constant: off by %.2g", worst );
}

// All 16-bit floats there and back, and what lies beyond them.
static HardInput halves( void )
{
    HardInput out = { .holds = true };
    for ( uint32_t bits = 0; bits < 0x10000u; ++bits )
    {
        float value = rf_half_to_float( (uint16_t)bits );
        if ( !isnan( value ) && rf_float_to_half( value ) != bits )
            out.holds = false;
    }
    static const float beyond[] = { 65504.1f, 65519.9f, 65520.0f, 1e6f, 3.4e38f };
    for ( int i = 0; i < 5; ++i )
    {
        out.holds = out.holds && rf_half_to_float( rf_float_to_half( rf_clamp_half( beyond[i] ) ) ) == 65504.0f;
        out.holds = out.holds && rf_half_to_float( rf_float_to_half( rf_clamp_half( -beyond[i] ) ) ) == -65504.0f;
    }
    out.holds = out.holds && isinf( rf_clamp_half( INFINITY ) ) && isnan( rf_clamp_half( NAN ) );
    PASS( "65536 halves there and back; finite values beyond 65504 are 65504" );
}

static double mean_picture( const HardScene* h, int group )
{
    RfTracer* tracer = make_tracer( &h->scene );
    RfRenderSettings s = plain_settings();
    s.group = group;
    rf_parse_tile( group > 0 ? "3x3" : "1", &s.tile );
    s.spp = 7;
    s.max_depth = 4;
    s.threads = 1;
    Rendered r = render_all( tracer, h->eyes, h->eye_count, &s );
    double sum = 0.0;
    for ( size_t i = 0; i < 3 * r.pixels * (size_t)r.count; ++i )
        sum += (double)r.rgb[i];
    sum /= (double)( 3 * r.pixels * (size_t)r.count );
    free_rendered( &r );
    rf_destroy_tracer( tracer );
    return sum;
}

// The same picture under every rounding mode: the numbers of a seed are the same, so what differs is rounding.
static HardInput rounding_modes( void )
{
    static const int modes[] = { FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO };
    HardInput out = { 0 };
    double means[2][4], worst = 0.0;
    for ( int m = 0; m < 4; ++m )
    {
        for ( int group = 0; group < 2; ++group )
        {
            HardScene h = { .eye_count = 7 };
            hard_stage( &h, hard_glossy() );
            fesetround( modes[m] );
            means[group][m] = mean_picture( &h, 3 * group );
            fesetround( FE_TONEAREST );
            worst = fmax( worst, fabs( means[group][m] / means[group][0] - 1.0 ) );
            worst = isfinite( means[group][m] ) ? worst : INFINITY;
            rf_destroy_scene( &h.scene );
        }
    }
    out.holds = worst < 2e-3;
    PASS( "means of pictures under four rounding modes: within %.2g", worst );
}

#define FLUSH 0x8040u // to zero, and denormals are zeros

// Scattering models and densities with subnormal inputs, with and without flush to zero. What is flushed is below 1.2e-38, and
// exponents of 1e7 multiply it: differences below 1e-30 do not count.
static HardInput subnormals( void )
{
    HardInput out = { .holds = true };
    unsigned mode = _mm_getcsr();
    double worst = 0.0;
    for ( uint32_t i = 0; i < MANY; ++i )
    {
        _mm_setcsr( mode & ~FLUSH );                              // renders leave it on
        float tiny = powf( 10.0f, -36.0f - 9.0f * even( i, 0 ) ); // down to 1e-45
        float value[2][4];
        RfVec3 n = rf_vec3( tiny, 1.0f, -tiny ), wi = rf_normalize( rf_vec3( even( i, 1 ) - 0.5f, even( i, 2 ), tiny ) );
        RfVec3 wo = rf_normalize( rf_vec3( tiny, even( i, 3 ), even( i, 4 ) - 0.5f ) );
        float shape = i % 2 == 0 ? 1e7f * even( i, 5 ) : RF_MIN_ALPHA, diffuse = tiny, specular = even( i, 6 ), one = 1.0f,
              coat = 0.04f;
        RfBsdfLanes lanes = { .n = { &n.x, &n.y, &n.z } };
        for ( int p = 0; p < 3; ++p )
        {
            lanes.param[RF_PARAM_DIFFUSE + p] = &diffuse;
            lanes.param[RF_PARAM_SPECULAR + p] = &specular;
        }
        lanes.param[RF_PARAM_SHAPE] = &shape;
        lanes.param[RF_PARAM_F90] = lanes.param[RF_PARAM_COAT_F90] = &one;
        lanes.param[RF_PARAM_COAT_F0] = &coat;
        const float *o[3] = { &wo.x, &wo.y, &wo.z }, *d[3] = { &wi.x, &wi.y, &wi.z };
        for ( int flush = 0; flush < 2; ++flush )
        {
            _mm_setcsr( flush ? mode | FLUSH : mode & ~FLUSH );
            float f[3], *to[3] = { f, f + 1, f + 2 };
            rf_bsdf_evaluate( i % 2 == 0 ? RF_BSDF_PHONG : RF_BSDF_GGX, 1, &lanes, o, d, to, &value[flush][0] );
            value[flush][1] = f[0];
            RfEye eye = { .forward = { 0, 0, -1 },
                          .right = { 1, 0, 0 },
                          .up = { 0, 1, 0 },
                          .focal = 10,
                          .focal_x = 10,
                          .axis_x = 8,
                          .axis_y = 6,
                          .width = 16,
                          .height = 12 };
            value[flush][2] = rf_project( &eye, rf_vec3( tiny, 0, -tiny ), rf_vec3( 0, 0, 1 ) ).density;
            value[flush][3] = rf_pow_one_minus( tiny, shape );
        }
        _mm_setcsr( mode );
        for ( int k = 0; k < 4; ++k )
        {
            double a = (double)value[0][k], b = (double)value[1][k];
            out.holds = out.holds && isfinite( a ) && isfinite( b ) && a >= 0.0 && b >= 0.0;
            worst = fmax( worst, fabs( a - b ) / fmax( fmax( fabs( a ), fabs( b ) ), 1e-24 ) );
        }
    }
    out.holds = out.holds && worst < 1e-6;
    PASS( "%.1f million evaluations with subnormals: with and without flush to zero within %.2g", MANY / 1e6, worst );
}

// Solves a Poisson system of equal data and returns how far the result is from it.
static double solve_equal( int width, int height, RfReconstructMethod method, float weight, float value )
{
    size_t count = (size_t)width * (size_t)height;
    float *primal = malloc( 3 * count * sizeof( float ) ), *zero = calloc( 3 * count, sizeof( float ) );
    float *weights = malloc( count * sizeof( float ) ), *rgb = calloc( 3 * count, sizeof( float ) );
    if ( primal == NULL || zero == NULL || weights == NULL || rgb == NULL )
        abort();
    for ( size_t i = 0; i < 3 * count; ++i )
        primal[i] = value;
    for ( size_t i = 0; i < count; ++i )
        weights[i] = weight;
    RfGradientImages in = { width, height, primal, zero, zero };
    RfGradientWeights w = { weights, weights, weights };
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfError error;
    options.method = method;
    RfResult result = rf_reconstruct( &in, method == RF_RECONSTRUCT_WEIGHTED ? &w : NULL, &options, rgb, NULL, &error );
    double worst = 0.0;
    for ( size_t i = 0; i < 3 * count; ++i )
        worst = fmax( worst, isfinite( rgb[i] ) ? fabs( (double)rgb[i] / (double)value - 1.0 ) : INFINITY );
    free( primal );
    free( zero );
    free( weights );
    free( rgb );
    if ( weight == 0.0f ) // must be refused
        return result == RF_ERROR_USAGE ? 0.0 : INFINITY;
    return result == RF_OK ? worst : INFINITY;
}

static HardInput poisson( void )
{
    HardInput out = { 0 };
    static const int sizes[][2] = { { 1, 1 }, { 1, 37 }, { 37, 1 }, { 1, 4096 }, { 2, 1 }, { 3, 3 }, { 16, 12 } };
    static const float values[] = { 1.0f, 1e-30f, 1e30f, 1e-40f };
    double worst = 0.0;
    for ( int s = 0; s < 7; ++s )
    {
        for ( int v = 0; v < 3; ++v )
        {
            for ( int m = RF_RECONSTRUCT_L2; m <= RF_RECONSTRUCT_L1; ++m )
            {
                worst = fmax( worst, solve_equal( sizes[s][0], sizes[s][1], (RfReconstructMethod)m, 1.0f, values[v] ) );
                if ( m == RF_RECONSTRUCT_WEIGHTED )
                    worst =
                        fmax( worst, fmax( solve_equal( sizes[s][0], sizes[s][1], RF_RECONSTRUCT_WEIGHTED, 1e-38f, values[v] ),
                                           solve_equal( sizes[s][0], sizes[s][1], RF_RECONSTRUCT_WEIGHTED, 1e38f, values[v] ) ) );
            }
        }
    }
    out.holds = worst < 1e-5;
    PASS( "1x1, 1xn, equal data, weights of 1e-38 to 1e38: off by %.2g", worst );
}

// Random data times 1e-30 and 1e30: the solution is that of the data, times as much.
static HardInput poisson_scaled( void )
{
    enum
    {
        W = 9,
        H = 7
    };
    HardInput out = { 0 };
    static const double scales[] = { 1.0, 1e-30, 1e30 };
    float data[3][3 * W * H], rgb[3][3 * W * H], weights[W * H];
    double worst = 0.0;
    for ( int m = RF_RECONSTRUCT_L2; m <= RF_RECONSTRUCT_L1; ++m )
    {
        for ( int s = 0; s < 3; ++s )
        {
            for ( uint32_t i = 0; i < 3 * W * H; ++i )
            {
                for ( uint32_t k = 0; k < 3; ++k )
                    data[k][i] = (float)( scales[s] * (double)( even( i, k ) - ( k > 0 ? 0.5f : 0.0f ) ) );
                weights[i / 3] = 0.1f + even( i, 3 );
            }
            RfGradientImages in = { W, H, data[0], data[1], data[2] };
            RfGradientWeights w = { weights, weights, weights };
            RfReconstructOptions options = rf_default_reconstruct_options();
            RfError error;
            options.method = (RfReconstructMethod)m;
            RfResult result = rf_reconstruct( &in, m == RF_RECONSTRUCT_WEIGHTED ? &w : NULL, &options, rgb[s], NULL, &error );
            for ( int i = 0; i < 3 * W * H; ++i )
            {
                double off = fabs( (double)rgb[s][i] / scales[s] - (double)rgb[0][i] );
                worst = result == RF_OK && off <= 1e30 ? fmax( worst, off ) : INFINITY;
            }
        }
    }
    out.holds = worst < 1e-3;
    PASS( "random data times 1e-30 and 1e30: off by %.2g at most", worst );
}

static HardInput poisson_zero( void )
{
    HardInput out = { 0 };
    double worst = 0.0;
    static const int sizes[][2] = { { 1, 1 }, { 1, 37 }, { 16, 12 } };
    for ( int s = 0; s < 3; ++s )
        worst = fmax( worst, solve_equal( sizes[s][0], sizes[s][1], RF_RECONSTRUCT_WEIGHTED, 0.0f, 1.0f ) );
    out.holds = worst == 0.0;
    PASS( "all weights 0: refused by a message" );
}

// Only the first pixel of a row has a primal weight; half of the pairs have none.
static HardInput poisson_open( void )
{
    HardInput out = { .holds = true };
    enum
    {
        N = 33
    };
    float primal[3 * N], zero[3 * N] = { 0 }, a[N] = { 1.0f }, b[N], rgb[3 * N];
    for ( int i = 0; i < N; ++i )
        b[i] = i < N / 2 ? 1.0f : 0.0f;
    for ( int i = 0; i < 3 * N; ++i )
        primal[i] = i < 3 ? 5.0f : NAN;
    RfGradientImages in = { N, 1, primal, zero, zero };
    RfGradientWeights w = { a, b, b };
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfError error;
    options.method = RF_RECONSTRUCT_WEIGHTED;
    for ( int i = 3; i < 3 * N; ++i )
        primal[i] = 7.0f; // weight 0
    if ( rf_reconstruct( &in, &w, &options, rgb, NULL, &error ) != RF_OK )
        out.holds = false;
    for ( int i = 0; i < 3 * N; ++i )
        out.holds = out.holds && isfinite( rgb[i] ) && ( i > 3 * ( N / 2 ) || fabsf( rgb[i] - 5.0f ) < 1e-3f );
    PASS( "a row with the weight of one pixel, and pixels that nothing ties to it" );
}

// Eyes whose rays would not be numbers are refused; Embree ends the process where it is given such a ray.
static HardInput unusable_eyes( void )
{
    HardInput out = { .holds = true };
    HardScene h = { .eye_count = 7 };
    hard_stage( &h, hard_grey() );
    RfTracer* tracer = make_tracer( &h.scene );
    RfRenderSettings s = plain_settings();
    s.spp = s.threads = 1;
    s.group = 0;
    int refused = 0;
    for ( int k = 0; k < 6; ++k )
    {
        RfEye eye = h.eyes[3];
        RfError error;
        eye.origin.x = k == 0 ? NAN : eye.origin.x;
        eye.up.y = k == 1 ? INFINITY : eye.up.y;
        eye.focal = k == 2 ? 0.0f : eye.focal;
        if ( k >= 3 )
            rf_set_lens( &eye, k == 5 ? INFINITY : 0.1, k == 3 ? 0.0 : k == 4 ? NAN : 1.0, 0, 0.0 );
        refused += rf_render( tracer, &eye, 1, &( int ){ 0 }, 1, &s, NULL, NULL, &error ) == RF_ERROR_USAGE;
    }
    out.holds = refused == 6;
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &h.scene );
    PASS( "a focus of 0, eyes that are not finite: %d of 6 refused by a message", refused );
}

// f of the sharpest lobes near their middle, as the formula in doubles has it for the same floats.
static HardInput sharp_lobes( void )
{
    HardInput out = { .holds = true };
    double worst[2] = { 0.0, 0.0 };
    int close = 0, drawn = 0;
    for ( uint32_t i = 0; i < MANY; ++i )
    {
        bool phong = i % 2 == 0;
        RfVec3 n = rf_normalize( rf_vec3( even( i, 0 ) - 0.5f, even( i, 1 ) + 0.2f, even( i, 2 ) - 0.5f ) ), t, b;
        rf_basis( n, &t, &b );
        RfVec3 wo = rf_normalize( rf_madd( rf_madd( n, t, 2.0f * even( i, 3 ) ), b, even( i, 4 ) ) );
        float exponent = 1e7f, alpha = RF_MIN_ALPHA, spread = phong ? 5e-4f : 2e-3f, zero = 0.0f, one = 1.0f;
        RfVec3 mirror = rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo ),
               jitter = rf_madd( rf_scale( t, even( i, 5 ) - 0.5f ), b, even( i, 6 ) - 0.5f );
        RfVec3 wi = rf_normalize( rf_madd( mirror, jitter, spread ) );
        RfBsdfLanes lanes = { .n = { &n.x, &n.y, &n.z } };
        for ( int p = 0; p < 3; ++p )
        {
            lanes.param[RF_PARAM_DIFFUSE + p] = &zero;
            lanes.param[RF_PARAM_SPECULAR + p] = &one;
        }
        lanes.param[RF_PARAM_SHAPE] = phong ? &exponent : &alpha;
        lanes.param[RF_PARAM_F90] = lanes.param[RF_PARAM_COAT_F90] = lanes.param[RF_PARAM_COAT_F0] = &one;
        const float *o[3] = { &wo.x, &wo.y, &wo.z }, *d[3] = { &wi.x, &wi.y, &wi.z };
        float f[3], pdf, *to[3] = { f, f + 1, f + 2 };
        rf_bsdf_evaluate( phong ? RF_BSDF_PHONG : RF_BSDF_GGX, 1, &lanes, o, d, to, &pdf );
        // |n x h|2 and what is along n, for h = wo + wi
        double N[3] = { (double)n.x, (double)n.y, (double)n.z }, O[3] = { (double)wo.x, (double)wo.y, (double)wo.z };
        double I[3] = { (double)wi.x, (double)wi.y, (double)wi.z }, C[3], across = 0.0, length2 = 0.0, cos_o = 0.0, cos_i = 0.0;
        for ( int k = 0; k < 3; ++k )
        {
            int k1 = ( k + 1 ) % 3, k2 = ( k + 2 ) % 3;
            C[k] = N[k1] * ( O[k2] + I[k2] ) - N[k2] * ( O[k1] + I[k1] );
            across += C[k] * C[k];
            length2 += ( O[k] + I[k] ) * ( O[k] + I[k] );
            cos_o += N[k] * O[k];
            cos_i += N[k] * I[k];
        }
        double exact, a2 = (double)alpha * (double)alpha;
        if ( phong )
            exact = 1e7 / ( 2.0 * 3.14159265358979324 ) *
                    exp( 1e7 * log1p( -0.5 * ( across + ( cos_i - cos_o ) * ( cos_i - cos_o ) ) ) );
        else
        {
            double q = length2 / ( a2 * ( cos_o + cos_i ) * ( cos_o + cos_i ) + across );
            double so = sqrt( a2 + ( 1.0 - a2 ) * cos_o * cos_o ), si = sqrt( a2 + ( 1.0 - a2 ) * cos_i * cos_i );
            exact = a2 * q * q / 3.14159265358979324 * 0.5 / ( cos_o * si + cos_i * so );
        }
        worst[phong] = fmax( worst[phong], fabs( (double)f[0] / exact - 1.0 ) );
        if ( !phong )
            continue;
        // 1 - cos of what is drawn around the normal: below 0.1 / n with probability 1 - exp(-0.1)
        float u0 = even( i, 7 ), u1 = even( i, 8 ), u2 = 0.5f;
        const float *u[3] = { &u0, &u1, &u2 }, *above[3] = { &n.x, &n.y, &n.z };
        RfVec3 in;
        float* to_wi[3] = { &in.x, &in.y, &in.z };
        rf_bsdf_sample( RF_BSDF_PHONG, 1, &lanes, above, u, to_wi );
        double c0 = N[1] * (double)in.z - N[2] * (double)in.y, c1 = N[2] * (double)in.x - N[0] * (double)in.z,
               c2 = N[0] * (double)in.y - N[1] * (double)in.x;
        close += 0.5 * ( c0 * c0 + c1 * c1 + c2 * c2 ) < 0.1 / 1e7;
        drawn += 1;
    }
    double share = (double)close / drawn, due = 1.0 - exp( -0.1 );
    bool drawn_well = fabs( share - due ) < 5.0 * sqrt( due * ( 1.0 - due ) / drawn );
    out.holds = worst[0] < 1e-3 && worst[1] < 1e-3 && drawn_well;
    PASS( "%.1f million directions: GGX of alpha 1e-3 within %.2g, Phong of exponent 1e7 within %.2g, drawn near its middle %.4f "
          "(%.4f)",
          MANY / 1e6, worst[0], worst[1], share, due );
}

// The interval of random numbers that leads to each light must be as long as its probability says.
static HardInput light_intervals( void )
{
    HardInput out = { .holds = true };
    HardScene h = { .eye_count = 7 };
    hard_stage( &h, hard_grey() );
    SceneBuilder b = hard_reopen( &h.scene );
    for ( int i = 0; i < 40; ++i )
    {
        uint32_t light = add_material( &b, make_light( powf( 10.0f, -6.0f + 12.0f * (float)i / 39.0f ), true ) );
        RfVec3 p = rf_vec3( -1.5f + 0.08f * (float)( i * 7 % 40 ), 2.0f, 0.03f * (float)i );
        add_quad( &b, light, p, rf_add( p, rf_vec3( 0.03f, 0, 0 ) ), rf_add( p, rf_vec3( 0.03f, 0.03f, 0 ) ),
                  rf_add( p, rf_vec3( 0, 0.03f, 0 ) ) );
    }
    h.scene = finish_scene( &b );
    RfTracer* tracer = make_tracer( &h.scene );
    const RfLights* lights = rf_tracer_lights( tracer );
    RfVec3 x = rf_vec3( 0.3f, 0.01f, 0.2f ), n = rf_vec3( 0, 1, 0 );
    double worst = 0.0;
    uint64_t u = 0, end = (uint64_t)1 << 53;
    int found = 0, due = 0;
    for ( ; u < end && found < 1000; ++found )
    {
        uint64_t low = u, high = end;
        uint32_t here =
            rf_select_light( lights, RF_LIGHTS_BY_TREE, x, n, ( uint32_t[2] ){ (uint32_t)( u >> 21 ), (uint32_t)( u << 11 ) } )
                .light;
        while ( high - low > 1 ) // the last number that leads here, plus 1
        {
            uint64_t middle = low + ( high - low ) / 2;
            uint32_t there = rf_select_light( lights, RF_LIGHTS_BY_TREE, x, n,
                                              ( uint32_t[2] ){ (uint32_t)( middle >> 21 ), (uint32_t)( middle << 11 ) } )
                                 .light;
            low = there == here ? middle : low;
            high = there == here ? high : middle;
        }
        double length = (double)( high - u ) * 0x1p-53,
               told = (double)rf_light_probability( lights, RF_LIGHTS_BY_TREE, here, x, n );
        worst = fmax( worst, fabs( length - told ) / fmax( told, 1e-9 ) );
        u = high;
    }
    for ( uint32_t k = 0; k < lights->count; ++k )
        due += rf_light_probability( lights, RF_LIGHTS_BY_TREE, k, x, n ) > 1e-13f;
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &h.scene );
    out.holds = worst < 1e-5 && found >= due && found < 1000;
    PASS( "%d lights of powers 1e12 apart: intervals as long as probabilities, within %.2g", found, worst );
}

const HardCase g_hard_inputs[] = {
    { "film-corners", "hits on the border of the film and on corners of pixels, there and back", "places beyond the film",
      HARD_INPUT, 0, NULL, film_corners },
    { "eye-frames", "up vectors as good as parallel to the view", "a cross product that cancels", HARD_INPUT, 0, NULL,
      eye_frames },
    { "focus-0", "a lens focused at 0 m, eyes that are not finite", "x/0 in the shear of the film; rays that are no numbers",
      HARD_INPUT, 0, NULL, unusable_eyes },
    { "density-range", "points at any distance, any normal", "products and quotients of densities beyond floats", HARD_INPUT, 0,
      NULL, projections },
    { "acne-and-leaks", "rays that leave hits, at any scale", "offsets too small or too large", HARD_INPUT, 0, NULL,
      acne_and_leaks },
    { "sharp-lobes", "f of the sharpest lobes next to their middle", "sines of 1e-4 as differences of cosines", HARD_INPUT, 0,
      NULL, sharp_lobes },
    { "light-intervals", "a light tree whose powers differ by 1e12", "sums of importances in floats", HARD_INPUT, 0, NULL,
      light_intervals },
    { "long-sums", "sums of 2^20 samples of a constant", "a float that grows by less than its spacing", HARD_INPUT, 0, NULL,
      long_sums },
    { "halves-beyond-65504", "16-bit floats of values beyond 65504", "infinities in files", HARD_INPUT, 0, NULL, halves },
    { "rounding-modes", "renders under the other three rounding modes", "tricks that need rounding to nearest", HARD_INPUT, 0,
      NULL, rounding_modes },
    { "subnormals", "subnormal inputs, with and without flush to zero", "quotients of what is flushed", HARD_INPUT, 0, NULL,
      subnormals },
    { "poisson-equal", "Poisson systems of 1x1, 1xn and of equal data", "no neighbours, no gradient", HARD_INPUT, 0, NULL,
      poisson },
    { "poisson-scaled", "Poisson systems of radiance 1e-30 and 1e30", "squares of distances", HARD_INPUT, 0, NULL,
      poisson_scaled },
    { "poisson-zero-weights", "Poisson systems whose weights are all 0", "1/diagonal", HARD_INPUT, 0, NULL, poisson_zero },
    { "poisson-open", "parts of a system that nothing ties to data", "a singular matrix", HARD_INPUT, 0, NULL, poisson_open },
    { 0 },
};
