// Shadow rays with occluders that are learned on the way, and segments from a common origin in full packets: both find just
// what segments traced in the order they come do, with masked and blended surfaces, panes and what moves as well.
#include "base/random.h"
#include "render/worlds.h"
#include "support/moving_rooms.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"
#include "trace/occluders.h"

#define MOST 1024
#define CALLS 60

static float draw_number( uint32_t dimension, int call, int i )
{
    return rf_random( rf_pixel_key( rf_pass_key( 31, 0, (uint32_t)call, 0 ), (uint32_t)i ), dimension );
}

typedef struct Segments
{
    int count;
    float o[3][MOST], d[3][MOST];
} Segments;

static RfVec3 draw_point( RfVec3 low, RfVec3 high, uint32_t dimension, int call, int i )
{
    return rf_vec3( low.x + ( high.x - low.x ) * draw_number( dimension, call, i ),
                    low.y + ( high.y - low.y ) * draw_number( dimension + 1, call, i ),
                    low.z + ( high.z - low.z ) * draw_number( dimension + 2, call, i ) );
}

static void set_segment( Segments* s, int i, RfVec3 from, RfVec3 way )
{
    const float o[3] = { from.x, from.y, from.z }, d[3] = { way.x, way.y, way.z };
    for ( int c = 0; c < 3; ++c )
    {
        s->o[c][i] = o[c];
        s->d[c][i] = d[c];
    }
}

// From within a room: within it, out of it, and far out, in turn.
static void draw_segments( const RfScene* scene, int call, Segments* s )
{
    RfVec3 low = scene->bounds_min, high = scene->bounds_max;
    s->count = call % 3 == 0 ? MOST : 1 + (int)( draw_number( 0, call, 0 ) * ( MOST - 1 ) );
    for ( int i = 0; i < s->count; ++i )
    {
        RfVec3 from = draw_point( low, high, 1, call, i ), to = draw_point( low, high, 4, call, i );
        float stretch = i % 3 == 0 ? 1.0f : i % 3 == 1 ? 3.0f : 400.0f;
        set_segment( s, i, from, rf_scale( rf_sub( to, from ), stretch ) );
    }
}

typedef struct Seen
{
    float visible[MOST], probability[MOST], weight[3][MOST];
} Seen;

static RfPaneLanes lanes_of( Seen* s )
{
    return ( RfPaneLanes ){ .probability = s->probability, .weight = { s->weight[0], s->weight[1], s->weight[2] } };
}

static void assert_same( const Seen* a, const Seen* b, int count, bool panes )
{
    for ( int i = 0; i < count; ++i )
    {
        assert_true( a->visible[i] == b->visible[i] );
        for ( int c = 0; c < 3 && panes && a->visible[i] > 0.0f; ++c )
            assert_true( a->probability[i] == b->probability[i] && a->weight[c][i] == b->weight[c][i] );
    }
}

static void trace_plainly( const RfTracer* tracer, const Segments* s, bool panes, Seen* out )
{
    const float *o[3] = { s->o[0], s->o[1], s->o[2] }, *d[3] = { s->d[0], s->d[1], s->d[2] };
    RfPaneLanes lanes = lanes_of( out );
    if ( panes )
        rf_trace_segments_past_panes( tracer, s->count, o, d, out->visible, &lanes );
    else
        rf_trace_segments( tracer, s->count, o, d, out->visible );
}

// Traces the segments both ways. Returns how many the occluders left.
static int compare( const RfTracer* tracer, RfOccluders* occluders, const Segments* s, bool panes )
{
    static Seen plain, learned;
    static int32_t open[MOST];
    const float *o[3] = { s->o[0], s->o[1], s->o[2] }, *d[3] = { s->d[0], s->d[1], s->d[2] };
    RfPaneLanes lanes = lanes_of( &learned );
    trace_plainly( tracer, s, panes, &plain );
    int left = rf_list_open_segments( occluders, s->count, o, d, open );
    rf_trace_shadow_rays( tracer, occluders, s->count, o, d, learned.visible, panes ? &lanes : NULL );
    assert_same( &plain, &learned, s->count, panes );
    return left;
}

// Returns the share that occluders block in the second half of the calls.
static double compare_room( const RfTracer* tracer, const RfScene* scene, bool panes )
{
    static Segments s;
    RfOccluders occluders = { .of = NULL };
    double all = 0.0, left = 0.0;
    for ( int call = 0; call < CALLS; ++call )
    {
        draw_segments( scene, call, &s );
        int open = compare( tracer, &occluders, &s, panes );
        all += call < CALLS / 2 ? 0.0 : (double)s.count;
        left += call < CALLS / 2 ? 0.0 : (double)open;
    }
    return 1.0 - left / all;
}

static double compare_scene( RfScene scene, bool panes )
{
    AUTO_TRACER tracer = make_tracer( &scene );
    double blocked = compare_room( tracer, &scene, panes );
    rf_destroy_scene( &scene );
    return blocked;
}

TEST( test_occluders_change_no_shadow_ray )
{
    assert_true( compare_scene( make_room( ROOM_DIFFUSE ), false ) > 0.3 );
    assert_true( compare_scene( make_pane_room( PANES_AND_LAMP ), false ) > 0.3 );
    assert_true( compare_scene( make_pane_room( PANES_AND_LAMP ), true ) > 0.3 );
    assert_true( compare_scene( make_curtain_room( CURTAIN ), false ) > 0.3 );
    assert_true( compare_scene( make_blended_room(), false ) > 0.3 );
    assert_true( compare_scene( make_textured_room(), false ) > 0.3 );
}

// Plates at all angles, some of them slivers, and segments that end in their planes, and pass their edges, by as little as nothing.
static RfScene make_plates( void )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    for ( int i = 0; i < 40; ++i )
    {
        RfVec3 p = draw_point( rf_vec3( -4, -4, -4 ), rf_vec3( 4, 4, 4 ), 1, 1000, i );
        RfVec3 e1 = draw_point( rf_vec3( -3, -3, -3 ), rf_vec3( 3, 3, 3 ), 4, 1000, i );
        RfVec3 e2 = rf_scale( draw_point( rf_vec3( -3, -3, -3 ), rf_vec3( 3, 3, 3 ), 7, 1000, i ), i % 8 == 0 ? 1e-3f : 1.0f );
        RfVec3 far = i % 2 == 0 ? rf_add( rf_add( p, e1 ), e2 ) : rf_add( p, e2 ); // a parallelogram, a triangle
        add_quad( &b, grey, p, rf_add( p, e1 ), far, rf_add( p, e2 ) );
    }
    return finish_scene( &b );
}

// A segment that meets the plane of a triangle near its edges, and starts or ends near it.
static void draw_narrow( const RfScene* scene, int call, int i, Segments* s )
{
    uint32_t triangle = (uint32_t)( draw_number( 20, call, i ) * (float)scene->triangles.count );
    int k = i % 3;
    RfVec3 p = rf_triangle_corner( scene, triangle, k ), q = rf_triangle_corner( scene, triangle, ( k + 1 ) % 3 ),
           r = rf_triangle_corner( scene, triangle, ( k + 2 ) % 3 );
    float along = draw_number( 21, call, i ),
          off = powf( 10.0f, -7.0f * draw_number( 22, call, i ) ) * ( i % 2 == 0 ? 1.0f : -1.0f );
    RfVec3 at = rf_add( p, rf_add( rf_scale( rf_sub( q, p ), along ), rf_scale( rf_sub( r, p ), off ) ) );
    RfVec3 from = draw_point( rf_vec3( -5, -5, -5 ), rf_vec3( 5, 5, 5 ), 24, call, i );
    float way = i % 5 == 0 ? 1.0f + off : i % 5 == 1 ? 500.0f : 2.0f; // ends near the plane, far behind it, behind it
    if ( i % 5 == 2 )
        from = rf_add( at, rf_scale( rf_sub( from, at ), fabsf( off ) ) ); // starts near it
    set_segment( s, i, from, rf_scale( rf_sub( at, from ), way ) );
}

TEST( test_occluders_leave_what_is_near_their_edges )
{
    static Segments s;
    AUTO_SCENE scene = make_plates();
    AUTO_TRACER tracer = make_tracer( &scene );
    RfOccluders occluders = { .of = NULL };
    int all = 0, left = 0;
    for ( int call = 0; call < 2 * CALLS; ++call )
    {
        s.count = MOST;
        for ( int i = 0; i < MOST; ++i )
            draw_narrow( &scene, call, i, &s );
        left += compare( tracer, &occluders, &s, false );
        all += s.count;
    }
    assert_true( left < all - all / 20 );
}

TEST( test_occluders_change_no_shadow_ray_where_something_moves )
{
    static const char* const rooms[] = { "sweep", "door", "figure" };
    for ( size_t k = 0; k < sizeof rooms / sizeof *rooms; ++k )
    {
        MovingRoom room = load_moving_room( rooms[k], 16, 16 );
        AUTO_TRACER tracer = make_tracer( &room.scene );
        AUTO_BY( rf_destroy_worlds ) RfWorlds worlds;
        RfError error;
        AUTO_FREE void* memory = aligned_alloc( 64, rf_tracer_at_bytes( 0 ) );
        for ( int i = 0; i < 2; ++i )
        {
            room.eyes[i].opens = 0.01 + 0.06 * i;
            room.eyes[i].closes = room.eyes[i].opens + 0.14;
            room.eyes[i].time = 0.5 * ( room.eyes[i].opens + room.eyes[i].closes );
            room.eyes[i].blur_steps = 3;
        }
        assert_int_equal( rf_create_worlds( &( RfShot ){ tracer, room.eyes, 2, NULL, 0 }, 2, false, &worlds, &error ), RF_OK );
        const RfTracer* const* tracers = rf_open_worlds( &worlds, 0, 2 );
        assert_non_null( tracers );
        static Segments s;
        RfOccluders occluders = { .of = NULL };
        for ( int call = 0; call < CALLS; ++call )
        {
            // what was learned in one frame and at one moment serves all
            const RfTracer* at = rf_tracer_at( tracers[call % 2], draw_number( 9, call, 0 ), memory );
            draw_segments( &room.scene, call, &s );
            compare( at, &occluders, &s, false );
        }
        rf_destroy_scene( &room.scene );
    }
}

// Segments from one origin to points of which some have no weight, against the same segments one after the other.
static void compare_origin( const RfTracer* tracer, const RfScene* scene, bool panes )
{
    static Segments s;
    static Seen plain, packed;
    static float point[3][MOST];
    RfPaneLanes lanes = lanes_of( &packed );
    for ( int call = 0; call < CALLS / 4; ++call )
    {
        draw_segments( scene, call, &s );
        RfVec3 origin = rf_vec3( s.o[0][0], s.o[1][0], s.o[2][0] );
        const float o[3] = { origin.x, origin.y, origin.z }, *points[3] = { point[0], point[1], point[2] };
        int weighted = 0;
        for ( int i = 0; i < s.count; ++i )
        {
            for ( int c = 0; c < 3; ++c )
            {
                point[c][i] = s.o[c][i];
                s.o[c][i] = o[c];
                s.d[c][i] = point[c][i] - o[c];
            }
            packed.visible[i] = i == 0 || draw_number( 30, call, i ) < 0.3f ? 0.0f : 1.0f;
            weighted += packed.visible[i] > 0.0f;
        }
        trace_plainly( tracer, &s, panes, &plain );
        for ( int i = 0; i < s.count; ++i )
            plain.visible[i] *= packed.visible[i];
        int traced = panes ? rf_trace_from_origin_past_panes( tracer, origin, s.count, points, packed.visible, &lanes )
                           : rf_trace_from_origin( tracer, origin, s.count, points, packed.visible );
        assert_int_equal( traced, weighted );
        assert_same( &plain, &packed, s.count, panes );
    }
}

TEST( test_packets_from_an_origin_find_the_same )
{
    RfScene scenes[] = { make_room( ROOM_DIFFUSE ), make_pane_room( PANES_AND_LAMP ), make_curtain_room( CURTAIN ),
                         make_blended_room(), make_textured_room() };
    for ( size_t k = 0; k < sizeof scenes / sizeof *scenes; ++k )
    {
        AUTO_TRACER tracer = make_tracer( scenes + k );
        compare_origin( tracer, scenes + k, false );
        compare_origin( tracer, scenes + k, true );
        rf_destroy_scene( scenes + k );
    }
}

int main( void )
{
    rf_set_float_mode();
    return run_listed_tests();
}
