// Light paths and connections: the same bits for any number of threads and with all records held, memory in the budget's account,
// and no difference where there is nothing to follow.
#include "light/small_emitters.h"
#include "light_paths/light_paths.h"
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/test.h"

#define EYES 3
#define WIDTH 20
#define HEIGHT 14
#define LIGHT_PATHS 512 // of a film of 64 x 64, and a film twice as large has as many more

static RfRenderSettings connected( int group )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = 2;
    settings.max_depth = 5;
    settings.memory = (size_t)128 << 20;
    settings.light_paths = RF_LIGHT_PATHS_ON;
    assert_true( rf_parse_tile( group == 0 ? "1" : "2x2", &settings.tile ) );
    return settings;
}

static Rendered render( RfScene* scene, RfRenderSettings settings )
{
    AUTO_TRACER tracer = make_tracer( scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    Rendered rendered = render_all( tracer, eyes, EYES, &settings );
    return rendered;
}

static bool same( const Rendered* a, const Rendered* b )
{
    return memcmp( a->rgb, b->rgb, 3 * a->pixels * (size_t)a->count * sizeof( float ) ) == 0;
}

TEST( test_threads_change_no_bit )
{
    AUTO_SCENE scene = make_mirror_room( GLASS_BALL );
    for ( int group = 0; group < 2; ++group )
    {
        RfRenderSettings settings = connected( group );
        settings.threads = 1;
        AUTO_BY( free_rendered ) Rendered one = render( &scene, settings );
        settings.threads = 3;
        AUTO_BY( free_rendered ) Rendered three = render( &scene, settings );
        settings.light_paths = RF_LIGHT_PATHS_OFF;
        AUTO_BY( free_rendered ) Rendered off = render( &scene, settings );
        assert_true( same( &one, &three ) );
        assert_false( same( &one, &off ) );
    }
}

// Smooth metals serve lamps without size alone, of which there are none.
TEST( test_without_mirrors_and_glass_nothing_changes )
{
    for ( int k = 0; k < 2; ++k )
    {
        AUTO_SCENE scene = k == 0 ? make_room( ROOM_GGX ) : make_mirror_room( SHARP_METAL );
        RfRenderSettings settings = connected( 1 );
        AUTO_BY( free_rendered ) Rendered on = render( &scene, settings );
        settings.light_paths = RF_LIGHT_PATHS_OFF;
        AUTO_BY( free_rendered ) Rendered off = render( &scene, settings );
        assert_true( same( &on, &off ) );
    }
}

// As seen in its ball, the room's lamp is large.
TEST( test_large_emitters_are_left_to_chance )
{
    AUTO_SCENE scene = make_mirror_room( GLASS_BALL );
    assert_int_equal( rf_count_small_emitters( &scene ), 0 );
}

// Of a film of one camera: at first the tables and the batches traced ahead.
static size_t bytes_of( int width, int height )
{
    RfRenderSettings settings = connected( 0 );
    AUTO_SCENE scene = make_mirror_room( MIRROR_BALL );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, width, height );
    settings.spp = 1;
    AUTO_BY( free_rendered ) Rendered rendered = render_all( tracer, eyes, 1, &settings );
    size_t bytes = 0;
    for ( int i = 0; i < rendered.stats.entry_count; ++i )
        bytes += strcmp( rendered.stats.entries[i].name, "light paths" ) == 0 ? rendered.stats.entries[i].peak : 0;
    return bytes;
}

TEST( test_memory_of_light_paths_is_counted )
{
    size_t few = bytes_of( 64, 64 ), many = bytes_of( 128, 64 ), each = ( many - few ) / ( LIGHT_PATHS );
    printf( "%zu bytes for each light path\n", each );
    assert_true( many > few );
    assert_true( each >= sizeof( RfLightPath ) );
    assert_true( each <= 496 );
}
