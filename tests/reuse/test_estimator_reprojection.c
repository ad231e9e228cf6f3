// Reprojected hits follow the film density J (src/reuse/estimators.md, notation): two cameras see
// one plane, their films are related by a homography, so the expected number of hits of
// one in a block of the other is an area.
#include "base/random.h"
#include "support/render_support.h"
#include "scene/pinhole.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 48
#define HEIGHT 36
#define BLOCK 6
#define ACROSS ( WIDTH / BLOCK )
#define BLOCKS ( ACROSS * ( HEIGHT / BLOCK ) )
#define SEED_COUNT 16
#define MOST_CORNERS 16

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef struct Point
{
    double x, y;
} Point;

typedef struct Polygon
{
    int count;
    Point corner[MOST_CORNERS];
} Polygon;

static double dot( RfVec3 a, double x, double y, double z ) { return (double)a.x * x + (double)a.y * y + (double)a.z * z; }

// From a film through the plane z = 0 to another film, in double precision.
static Point through_plane( const RfEye* from, const RfEye* to, Point at )
{
    double fx = ( at.x - 0.5 * from->width ) / (double)from->focal, fy = ( 0.5 * from->height - at.y ) / (double)from->focal;
    double dx = (double)from->forward.x + (double)from->right.x * fx + (double)from->up.x * fy;
    double dy = (double)from->forward.y + (double)from->right.y * fx + (double)from->up.y * fy;
    double dz = (double)from->forward.z + (double)from->right.z * fx + (double)from->up.z * fy;
    double t = -(double)from->origin.z / dz;
    assert_true( t > 0.0 );
    double vx = (double)from->origin.x + t * dx - (double)to->origin.x;
    double vy = (double)from->origin.y + t * dy - (double)to->origin.y;
    double vz = -(double)to->origin.z;
    double depth = dot( to->forward, vx, vy, vz );
    assert_true( depth > 0.0 );
    return ( Point ){ 0.5 * to->width + dot( to->right, vx, vy, vz ) * (double)to->focal / depth,
                      0.5 * to->height - dot( to->up, vx, vy, vz ) * (double)to->focal / depth };
}

// Sutherland and Hodgman: what of the polygon is where a x + b y ≤ c.
static Polygon clip_side( const Polygon* p, double a, double b, double c )
{
    Polygon out = { 0 };
    for ( int i = 0; i < p->count; ++i )
    {
        Point s = p->corner[i], e = p->corner[( i + 1 ) % p->count];
        double ds = a * s.x + b * s.y - c, de = a * e.x + b * e.y - c;
        if ( ds <= 0.0 )
            out.corner[out.count++] = s;
        if ( ( ds < 0.0 && de > 0.0 ) || ( ds > 0.0 && de < 0.0 ) )
        {
            double t = ds / ( ds - de );
            out.corner[out.count++] = ( Point ){ s.x + t * ( e.x - s.x ), s.y + t * ( e.y - s.y ) };
        }
        assert_true( out.count < MOST_CORNERS );
    }
    return out;
}

static double clipped_area( Polygon p )
{
    p = clip_side( &p, -1, 0, 0 );
    p = clip_side( &p, 1, 0, WIDTH );
    p = clip_side( &p, 0, -1, 0 );
    p = clip_side( &p, 0, 1, HEIGHT );
    double sum = 0.0;
    for ( int i = 0; i < p.count; ++i )
    {
        Point a = p.corner[i], b = p.corner[( i + 1 ) % p.count];
        sum += 0.5 * ( a.x * b.y - a.y * b.x );
    }
    return fabs( sum );
}

// Area on the film `to` of a rectangle of the film `from`, as far as inside.
static double mapped_area( const RfEye* from, const RfEye* to, double x0, double y0, double x1, double y1 )
{
    Point corner[4] = { { x0, y0 }, { x1, y0 }, { x1, y1 }, { x0, y1 } };
    Polygon p = { .count = 4 };
    for ( int i = 0; i < 4; ++i )
        p.corner[i] = through_plane( from, to, corner[i] );
    return clipped_area( p );
}

// A hit of eye k through a film point, as the harvest makes it.
typedef struct Hit
{
    RfVec3 p, ng;
} Hit;

static Hit trace_hit( const RfTracer* tracer, const RfEye* eye, float film_x, float film_y )
{
    float fx = ( film_x - 0.5f * WIDTH ) / eye->focal, fy = ( 0.5f * HEIGHT - film_y ) / eye->focal;
    RfVec3 d = rf_normalize( rf_madd( rf_madd( eye->forward, eye->right, fx ), eye->up, fy ) );
    const float* o_in[3] = { &eye->origin.x, &eye->origin.y, &eye->origin.z };
    const float* d_in[3] = { &d.x, &d.y, &d.z };
    uint32_t triangle;
    float u, v;
    rf_trace_nearest( tracer, 1, o_in, d_in, true, &triangle, &u, &v );
    assert_true( triangle != RF_MISS );
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, triangle, &place );
    RfVec3 p = rf_add( t->p0, rf_add( rf_scale( t->e1, u ), rf_scale( t->e2, v ) ) );
    return ( Hit ){ p, rf_dot( t->ng, d ) < 0.0f ? t->ng : rf_scale( t->ng, -1.0f ) };
}

// Hits of one seed: counts per block of film t, and Σ J_t / J_k. One hit per
// pixel and pass as the renderer draws them, or anywhere on the film.
static double drop_hits( const RfTracer* tracer, const RfEye* k, const RfEye* t, int seed, int passes, bool stratified,
                         double* counts )
{
    double sum = 0.0;
    for ( int pass = 0; pass < passes; ++pass )
    {
        uint64_t key = rf_pass_key( (uint64_t)seed + suite_seed(), 0, 0, (uint32_t)pass );
        for ( uint32_t i = 0; i < WIDTH * HEIGHT; ++i )
        {
            RfRandomKey pixel = rf_pixel_key( key, i );
            float u = rf_random( pixel, 0 ), v = rf_random( pixel, 1 );
            float x = stratified ? (float)( i % WIDTH ) + u : WIDTH * u, y = stratified ? (float)( i / WIDTH ) + v : HEIGHT * v;
            Hit hit = trace_hit( tracer, k, x, y );
            RfProjection own = rf_project( k, hit.p, hit.ng ), other = rf_project( t, hit.p, hit.ng );
            if ( !other.seen )
                continue;
            assert_true( other.x >= 0 && other.x < WIDTH && other.y >= 0 && other.y < HEIGHT );
            counts[other.y / BLOCK * ACROSS + other.x / BLOCK] += 1.0;
            sum += (double)other.density / (double)own.density;
        }
    }
    return sum / passes;
}

// χ² over the blocks that expect enough, and what falls beside all of them.
static double block_chi_square( const RfEye* k, const RfEye* t, const double* counts, int passes, int* df )
{
    double chi_square = 0.0;
    *df = 0;
    for ( int b = 0; b < BLOCKS; ++b )
    {
        double x = b % ACROSS * BLOCK, y = b / ACROSS * BLOCK;
        double expected = passes * mapped_area( t, k, x, y, x + BLOCK, y + BLOCK );
        if ( expected < 1e-9 )
            assert_true( counts[b] == 0.0 );
        if ( expected < 10.0 )
            continue;
        // a share of all hits: binomial, less noisy than its mean where it is large
        double share = expected / ( (double)passes * WIDTH * HEIGHT );
        chi_square += ( counts[b] - expected ) * ( counts[b] - expected ) / ( expected * ( 1.0 - share ) );
        *df += 1;
    }
    return chi_square;
}

static void check_pair( const char* name, const RfTracer* tracer, const RfEye* k, const RfEye* t )
{
    int passes = ( is_long() ? 200 : 20 ) * suite_samples();
    for ( int stratified = 0; stratified < 2; ++stratified )
    {
        double ratio[SEED_COUNT], all[BLOCKS] = { 0 }, smallest = 1.0;
        int df;
        for ( int seed = 0; seed < SEED_COUNT; ++seed )
        {
            double counts[BLOCKS] = { 0 };
            ratio[seed] = drop_hits( tracer, k, t, seed, passes, stratified != 0, counts );
            double chi_square = block_chi_square( k, t, counts, passes, &df );
            smallest = fmin( smallest, chi_square_p( chi_square, df ) );
            for ( int b = 0; b < BLOCKS; ++b )
                all[b] += counts[b];
        }
        double p = chi_square_p( block_chi_square( k, t, all, SEED_COUNT * passes, &df ), df );
        double error, mean = mean_of( ratio, SEED_COUNT, &error );
        double pixels = mapped_area( k, t, 0, 0, WIDTH, HEIGHT ); // of film t that eye k sees as well
        error = fmax( error, 1e-6 * pixels );
        printf( "%-10s %s: %d blocks, p %.3g (smallest of %d: %.3g); sum of J_t/J_k %.3f of %.3f, %.2f SE (SE %.2g)\n", name,
                stratified ? "stratified" : "uniform   ", df, p, SEED_COUNT, smallest, mean, pixels, ( mean - pixels ) / error,
                error );
        assert_true( df > 12 );
        assert_true( is_likely( p ) && is_likely( 1.0 - pow( 1.0 - smallest, SEED_COUNT ) ) );
        if ( !stratified )
            assert_true( p < 1.0 - 1e-4 ); // nor too good
        assert_false( is_far_off( ( mean - pixels ) / error, SEED_COUNT - 1 ) );
    }
}

static RfEye look( RfVec3 origin, RfVec3 at, double yfov )
{
    return rf_make_eye( origin, rf_sub( at, origin ), rf_vec3( 0.1f, 1, 0.05f ), yfov, WIDTH, HEIGHT );
}

TEST( test_hits_fall_as_their_density_says )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    add_quad( &b, grey, rf_vec3( -50, -50, 0 ), rf_vec3( 50, -50, 0 ), rf_vec3( 50, 50, 0 ), rf_vec3( -50, 50, 0 ) );
    RfScene scene = finish_scene( &b );
    RfTracer* tracer = make_tracer( &scene );
    RfEye front = look( rf_vec3( 0, 0, 3 ), rf_vec3( 0, 0, 0 ), 0.9 );
    RfEye near_inside = look( rf_vec3( 0.2f, 0.1f, 1.8f ), rf_vec3( 0.1f, 0.0f, 0 ), 0.7 );
    RfEye tilted = look( rf_vec3( 2.5f, 0.5f, 2.0f ), rf_vec3( 0.3f, 0.1f, 0 ), 0.8 );
    RfEye grazing = look( rf_vec3( -2.0f, -3.0f, 0.6f ), rf_vec3( 0.2f, 0.2f, 0 ), 0.15 );
    RfEye behind = look( rf_vec3( 0.3f, -1.0f, -2.5f ), rf_vec3( 0, 0, 0 ), 0.9 );
    check_pair( "inside", tracer, &front, &near_inside );
    check_pair( "zoomed out", tracer, &near_inside, &front );
    check_pair( "tilted", tracer, &front, &tilted );
    check_pair( "from tilt", tracer, &tilted, &front );
    check_pair( "grazing", tracer, &front, &grazing );
    check_pair( "itself", tracer, &tilted, &tilted );
    double counts[BLOCKS] = { 0 };
    assert_true( drop_hits( tracer, &front, &behind, 1, 1, true, counts ) == 0.0 ); // the other side of the sheet
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// J is what it says: the area on the film of a small patch over its own.
TEST( test_density_is_an_area_ratio )
{
    RfEye eye = look( rf_vec3( 0.4f, -0.7f, 2.1f ), rf_vec3( 0.1f, 0.2f, 0 ), 0.8 );
    RfEye window = rf_make_eye( rf_vec3( 0, 0, 1 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.9, WIDTH, HEIGHT );
    for ( int i = 0; i < 64; ++i )
    {
        // a square of the window's film is one of the plane, 1 / focal² as large
        double x = 18.0 + i % 8, y = 12.0 + i / 8, h = 0.01, unit = (double)window.focal;
        double patch = 4.0 * h * h / ( unit * unit );
        float px = (float)( ( x - 0.5 * WIDTH ) / unit ), py = (float)( ( 0.5 * HEIGHT - y ) / unit );
        RfProjection at = rf_project( &eye, rf_vec3( px, py, 0 ), rf_vec3( 0, 0, 1 ) );
        double image = mapped_area( &window, &eye, x - h, y - h, x + h, y + h );
        assert_true( at.seen );
        assert_true( fabs( (double)at.density / ( image / patch ) - 1.0 ) < 1e-4 );
    }
}

STATISTICAL_TESTS
