// What moves while a shutter is open, between the moments at which it is posed: rays against the same triangles in doubles, the
// records of what they hit, swept geometry, and what is shown at some of the moments alone.
#include "base/random.h"
#include "render/worlds.h"
#include "support/cli_run.h"
#include "support/moving_rooms.h"
#include "support/render_support.h"
#include "support/scene_files.h"
#include "support/test.h"
#include "trace/trace.h"

#define RAYS 800
#define TIMES 12

static float draw_number( uint32_t dimension, int i )
{
    return rf_random( rf_pixel_key( rf_pass_key( 23, 0, 0, 0 ), (uint32_t)i ), dimension );
}

typedef struct Point
{
    double x[3];
} Point;

// All triangles of a frame at a moment, by poses of their own.
typedef struct Truth
{
    uint32_t count, moving; // of them the first that moves
    Point* corners;         // 3 × count
    bool* shown;
} Truth;

static Point corner_of( const RfScene* scene, const RfTriangleAt* at, int corner )
{
    Point p;
    RfVec3 v = rf_corner( at->triangles, at->index, corner );
    const double local[3] = { (double)v.x, (double)v.y, (double)v.z };
    RfMat4 matrix = at->placement != NULL ? at->placement->matrix : rf_mat4_identity();
    (void)scene;
    rf_mat4_apply( &matrix, local, 1.0, p.x );
    return p;
}

static Truth find_truth( const RfScene* scene, const RfEye* eye, double moment )
{
    double scaled = moment * (double)eye->blur_steps, first = fmin( floor( scaled ), (double)( eye->blur_steps - 1 ) );
    double part = scaled - first;
    AUTO_POSE a = gltf_pose_at( scene, rf_moment_time( eye, (int)first ) ),
              b = gltf_pose_at( scene, rf_moment_time( eye, (int)first + 1 ) );
    Truth truth = { .count = rf_triangle_count( scene ), .moving = scene->placements[scene->still_placement_count].first };
    truth.corners = calloc( 3 * (size_t)truth.count, sizeof *truth.corners );
    truth.shown = calloc( truth.count, sizeof *truth.shown );
    for ( uint32_t i = 0; i < truth.count; ++i )
    {
        RfTriangleAt from = rf_locate_triangle( &a.scene, i ), to = rf_locate_triangle( &b.scene, i );
        truth.shown[i] = from.placement == NULL || from.placement->shown;
        for ( int k = 0; k < 3 && truth.shown[i]; ++k )
        {
            Point p = corner_of( &a.scene, &from, k ), q = corner_of( &b.scene, &to, k );
            for ( int c = 0; c < 3; ++c )
                truth.corners[3 * i + (uint32_t)k].x[c] = p.x[c] + part * ( q.x[c] - p.x[c] );
        }
    }
    return truth;
}

static void free_truth( Truth* truth )
{
    free( truth->corners );
    free( truth->shown );
}

static void minus( const Point* a, const Point* b, double out[3] )
{
    for ( int c = 0; c < 3; ++c )
        out[c] = a->x[c] - b->x[c];
}

static double dot( const double a[3], const double b[3] ) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Distance along a ray, in lengths of d; infinity: it misses.
static double meet( const Point* corners, const Point* o, const double d[3] )
{
    double e1[3], e2[3], s[3], p[3], q[3];
    minus( corners + 1, corners, e1 );
    minus( corners + 2, corners, e2 );
    minus( o, corners, s );
    rf_cross3( d, e2, p );
    rf_cross3( s, e1, q );
    double det = dot( e1, p ), u = dot( s, p ) / det, v = dot( d, q ) / det, t = dot( e2, q ) / det;
    return det != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 ? t : (double)INFINITY;
}

static uint32_t nearest( const Truth* truth, uint32_t first, RfVec3 from, RfVec3 way, double* distance )
{
    uint32_t found = RF_MISS;
    Point o = { { (double)from.x, (double)from.y, (double)from.z } };
    const double d[3] = { (double)way.x, (double)way.y, (double)way.z };
    *distance = (double)INFINITY;
    for ( uint32_t i = first; i < truth->count; ++i )
    {
        double t = truth->shown[i] ? meet( truth->corners + 3 * (size_t)i, &o, d ) : (double)INFINITY;
        found = t < *distance ? i : found;
        *distance = fmin( *distance, t );
    }
    return found;
}

// A ray within the room.
static void draw( int i, RfVec3* from, RfVec3* way )
{
    float z = 2.0f * draw_number( 3, i ) - 1.0f, phi = 2.0f * RF_PI * draw_number( 4, i ), r = sqrtf( 1.0f - z * z );
    *from = rf_vec3( 3.6f * draw_number( 0, i ) - 1.8f, 2.6f * draw_number( 1, i ) + 0.2f, 3.6f * draw_number( 2, i ) - 1.8f );
    *way = rf_vec3( r * cosf( phi ), z, r * sinf( phi ) );
}

typedef struct Found
{
    int moving, other, hidden;
    double distance, point, normal; // the largest errors
} Found;

static float away( RfVec3 a, Point b )
{
    return rf_length(
        rf_vec3( (float)( (double)a.x - b.x[0] ), (float)( (double)a.y - b.x[1] ), (float)( (double)a.z - b.x[2] ) ) );
}

static void compare_record( const RfTriangleRecord* t, const Point* corners, Found* found )
{
    double e1[3], e2[3], n[3];
    minus( corners + 1, corners, e1 );
    minus( corners + 2, corners, e2 );
    rf_cross3( e1, e2, n );
    rf_unit3( n );
    found->point = fmax( found->point, (double)fmaxf( away( t->p0, corners[0] ), away( rf_add( t->p0, t->e2 ), corners[2] ) ) );
    double along = fabs( n[0] * (double)t->ng.x + n[1] * (double)t->ng.y + n[2] * (double)t->ng.z );
    found->normal = fmax( found->normal, 1.0 - along );
}

static void compare_ray( const RfTracer* tracer, const Truth* truth, int i, Found* found )
{
    RfVec3 from, way;
    draw( i, &from, &way );
    const float *o[3] = { &from.x, &from.y, &from.z }, *d[3] = { &way.x, &way.y, &way.z };
    uint32_t triangle;
    float u, v, visible;
    double distance;
    rf_trace_nearest( tracer, 1, o, d, false, &triangle, &u, &v );
    if ( triangle != nearest( truth, 0, from, way, &distance ) || triangle == RF_MISS )
    {
        found->other += triangle != RF_MISS || distance < (double)INFINITY;
        return;
    }
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, triangle, &place );
    RfHitPoint hit = rf_hit_point( t, u, v, from, way );
    RfVec3 to = rf_madd( from, way, (float)distance );
    found->distance = fmax( found->distance, (double)rf_length( rf_sub( hit.p, to ) ) );
    if ( !rf_is_moving( tracer, triangle ) )
        return;
    found->moving += 1;
    compare_record( t, truth->corners + 3 * (size_t)triangle, found );
    float side = rf_dot( t->ng, way ) < 0.0f ? 1.0f : -1.0f;
    RfVec3 off = rf_madd( hit.p, t->ng, side * hit.offset ), back = rf_sub( from, off );
    const float *p[3] = { &off.x, &off.y, &off.z }, *b[3] = { &back.x, &back.y, &back.z };
    rf_trace_segments( tracer, 1, p, b, &visible );
    found->hidden += visible < 1.0f;
}

// Frames with shutters of their own.
static void open_eyes( RfEye* eyes, int count, int steps )
{
    for ( int i = 0; i < count; ++i )
    {
        eyes[i].opens = 0.01 + 0.06 * i;
        eyes[i].closes = eyes[i].opens + 0.14 - 0.03 * i;
        eyes[i].time = 0.5 * ( eyes[i].opens + eyes[i].closes );
        eyes[i].blur_steps = steps;
    }
}

static bool meets_swept( const Truth* truths, int count, RfVec3 from, RfVec3 way )
{
    bool any = false;
    for ( int k = 0; k < count; ++k )
    {
        double distance;
        nearest( truths + k, truths[k].moving, from, way, &distance );
        any = any || distance < 1.0;
    }
    return any;
}

// Segments of 1 m.
static int count_other_swept( const RfTracer* tracer, const Truth* truths, int count )
{
    int other = 0;
    for ( int i = 0; i < RAYS; ++i )
    {
        RfVec3 from, way;
        draw( i, &from, &way );
        const float *o[3] = { &from.x, &from.y, &from.z }, *d[3] = { &way.x, &way.y, &way.z };
        uint8_t touched = 0;
        rf_find_swept( tracer, 1, o, d, 1.0f, &touched );
        other += ( touched != 0 ) != meets_swept( truths, count, from, way );
    }
    return other;
}

static void check_room( const char* name, int steps )
{
    enum
    {
        FRAMES = 2
    };
    MovingRoom room = load_moving_room( name, 16, 16 );
    AUTO_TRACER tracer = make_tracer( &room.scene );
    AUTO_BY( rf_destroy_worlds ) RfWorlds worlds;
    RfError error;
    Found found = { 0 };
    int swept = 0;
    AUTO_FREE void* memory = aligned_alloc( 64, rf_tracer_at_bytes( 0 ) );
    open_eyes( room.eyes, FRAMES, steps );
    assert_int_equal( rf_create_worlds( &( RfShot ){ tracer, room.eyes, FRAMES, NULL, 0 }, FRAMES, false, &worlds, &error ),
                      RF_OK );
    const RfTracer* const* tracers = rf_open_worlds( &worlds, 0, FRAMES );
    assert_non_null( tracers );
    for ( int i = 0; i < TIMES; ++i )
    {
        Truth truths[FRAMES];
        float moment = i == 0 ? 0.0f : draw_number( 9, i );
        for ( int k = 0; k < FRAMES; ++k )
            truths[k] = find_truth( &room.scene, room.eyes + k, (double)moment );
        const RfTracer* at = rf_tracer_at( tracers[i % FRAMES], moment, memory );
        for ( int r = 0; r < RAYS; ++r )
            compare_ray( at, truths + i % FRAMES, r, &found );
        swept += count_other_swept( at, truths, FRAMES );
        for ( int k = 0; k < FRAMES; ++k )
            free_truth( truths + k );
    }
    printf( "%s, %d steps: %d of %d hits move, %d differ; hits by %.2g, corners by %.2g, normals by %.2g; %d swept differ\n",
            name, steps, found.moving, RAYS * TIMES, found.other, found.distance, found.point, found.normal, swept );
    assert_true( found.moving > RAYS * TIMES / 40 );
    assert_true( found.other <= RAYS * TIMES / 1000 );
    assert_true( swept <= RAYS * TIMES / 1000 );
    assert_int_equal( found.hidden, 0 );
    assert_true( found.distance < 2e-5 );
    assert_true( found.point < 2e-6 );
    assert_true( found.normal < 1e-6 );
    rf_destroy_scene( &room.scene );
}

TEST( test_hits_between_moments )
{
    static const char* const rooms[] = { "sweep", "door", "mirrors", "figure", "sky" };
    for ( size_t i = 0; i < sizeof rooms / sizeof *rooms; ++i )
    {
        check_room( rooms[i], 1 );
        check_room( rooms[i], 5 );
    }
}

typedef struct OpenWorld
{
    MovingRoom room;
    RfTracer* tracer;
    RfWorlds worlds;
    const RfTracer* posed;
    void* memory;
} OpenWorld;

// Its first frame, with a shutter.
static void open_world( OpenWorld* w, const char* name, double opens, double closes, int steps )
{
    RfError error;
    w->room = load_moving_room( name, 16, 16 );
    RfEye* eye = w->room.eyes;
    eye->opens = opens;
    eye->closes = closes;
    eye->time = 0.5 * ( opens + closes );
    eye->blur_steps = steps;
    w->tracer = make_tracer( &w->room.scene );
    assert_int_equal( rf_create_worlds( &( RfShot ){ w->tracer, eye, 1, NULL, 0 }, 1, false, &w->worlds, &error ), RF_OK );
    const RfTracer* const* tracers = rf_open_worlds( &w->worlds, 0, 1 );
    assert_non_null( tracers );
    w->posed = tracers[0];
    w->memory = aligned_alloc( 64, rf_tracer_at_bytes( 0 ) );
}

static void close_world( OpenWorld* w )
{
    rf_destroy_worlds( &w->worlds );
    rf_destroy_tracer( w->tracer );
    rf_destroy_scene( &w->room.scene );
    free( w->memory );
}

static void check_shown( double opens, double closes, int steps, double decides )
{
    OpenWorld w;
    open_world( &w, "shown", opens, closes, steps );
    RfEye still = { .opens = decides, .closes = decides, .blur_steps = 1 };
    Truth truth = find_truth( &w.room.scene, &still, 0.0 );
    int moving = 0, other = 0;
    for ( int i = 0; i < 3; ++i )
    {
        const RfTracer* at = rf_tracer_at( w.posed, 0.49f * (float)i, w.memory );
        for ( int r = 0; r < RAYS; ++r )
        {
            RfVec3 from, way;
            double distance;
            uint32_t triangle;
            float u, v;
            draw( r, &from, &way );
            rf_trace_nearest( at, 1, ( const float* const[3] ){ &from.x, &from.y, &from.z },
                              ( const float* const[3] ){ &way.x, &way.y, &way.z }, false, &triangle, &u, &v );
            other += triangle != nearest( &truth, 0, from, way, &distance );
            moving += rf_is_moving( at, triangle );
        }
    }
    assert_true( moving > 0 && other <= RAYS / 100 );
    free_truth( &truth );
    close_world( &w );
}

// A screen and a lid take turns at 1/24 s.
TEST( test_what_is_shown_at_times )
{
    check_shown( 0.6 / 24, 1.2 / 24, 4, 0.9 / 24 );
    check_shown( 0.8 / 24, 1.4 / 24, 4, 1.1 / 24 );
    check_shown( 0.8 / 24, 1.3 / 24, 1, 1.05 / 24 );
    check_shown( 0.8 / 24, 1.1 / 24, 3, 0.95 / 24 );
}

// Scales of 0, joints without an inverse, and triangles that deformation turns over or takes out, on the way.
TEST( test_what_flattens )
{
    static const char* const rooms[] = { "flat", "singular" };
    for ( int i = 0; i < 8; ++i )
    {
        OpenWorld w;
        open_world( &w, rooms[i % 2], 0.0, 0.01 + 0.06 * ( i / 2 ), 1 + i );
        int moving = 0;
        for ( int r = 0; r < 4 * RAYS; ++r )
        {
            const RfTracer* at = rf_tracer_at( w.posed, draw_number( 9, r ), w.memory );
            RfVec3 from, way;
            uint32_t triangle;
            float u, v;
            draw( r, &from, &way );
            rf_trace_nearest( at, 1, ( const float* const[3] ){ &from.x, &from.y, &from.z },
                              ( const float* const[3] ){ &way.x, &way.y, &way.z }, false, &triangle, &u, &v );
            if ( !rf_is_moving( at, triangle ) )
                continue;
            RfTriangleRecord place;
            const RfTriangleRecord* t = rf_triangle_record( at, triangle, &place );
            RfHitPoint hit = rf_hit_point( t, u, v, from, way );
            RfVec3 off = rf_sub( hit.p, from );
            moving += 1;
            assert_true( fabsf( rf_length( t->ng ) - 1.0f ) < 1e-5f );
            assert_true( rf_length( rf_cross( off, way ) ) < 1e-4f );
        }
        assert_true( moving > 0 );
        close_world( &w );
    }
}

// ---- Paths ----------------------------------------------------------------------

static RfCameraPath path_of( const RfScene* scene, const char* text, int steps )
{
    RfLens lens = { .has_shutter = true, .shutter = { -0.5, 0.5 }, .blur_steps = steps };
    RfCameraPath path;
    RfError error;
    write_text( "path.json", text );
    if ( rf_create_camera_path( scene,
                                &( RfPathOptions ){ .camera = cli_path( "path.json" ), .lens = &lens, .width = 8, .height = 8 },
                                &path, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return path;
}

#define KEY( frame, cut ) "{\"frame\":" frame cut ",\"position\":[0,1,1],\"target\":[0,1,0]}"

// Frames 1 to 12 at 24 frames/s, of which what moves fills the first 7.
TEST( test_moments_of_a_path )
{
    MovingRoom room = load_moving_room( "sweep", 8, 8 );
    RfCameraPath path =
        path_of( &room.scene,
                 "{\"kind\":\"keyed\",\"keys\":[" KEY( "1", "" ) "," KEY( "4", ",\"cut\":true" ) "," KEY( "12", "" ) "]}", 3 );
    assert_int_equal( path.count, 12 );
    for ( int i = 0; i < 7; ++i )
    {
        double cut = 3.0 / 24, opens = ( i - 0.5 ) / 24, closes = ( i + 0.5 ) / 24;
        const RfEye* e = path.eyes + i;
        assert_int_equal( e->blur_steps, 3 );
        assert_true( fabs( e->opens - ( i == 3 ? cut : opens ) ) < 1e-4 &&
                     fabs( e->closes - ( i == 2 ? fmin( closes, cut ) : closes ) ) < 1e-4 );
        assert_true( i < 3 ? e->closes < cut : e->opens > cut - 1e-12 );
        assert_true( fabs( e->time - ( i == 3 ? 0.5 * ( cut + closes ) : i / 24.0 ) ) < 1e-4 );
        assert_int_equal( path.run_of_frame[i], i );
    }
    for ( int i = 7; i < 12; ++i ) // nothing moves any more
    {
        assert_int_equal( path.eyes[i].blur_steps, 0 );
        assert_int_equal( path.run_of_frame[i], 7 );
    }
    uint64_t hash = path.hash;
    rf_destroy_camera_path( &path );
    path = path_of( &room.scene,
                    "{\"kind\":\"keyed\",\"keys\":[" KEY( "1", "" ) "," KEY( "4", ",\"cut\":true" ) "," KEY( "12", "" ) "]}", 2 );
    assert_int_not_equal( hash, path.hash );
    rf_destroy_camera_path( &path );
    rf_destroy_scene( &room.scene );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
