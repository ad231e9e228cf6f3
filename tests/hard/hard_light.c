// Hard cases of lights and of radiance.
#include "hard/hard.h"
#include "scene/twins.h"

#include <math.h>
#include <stdlib.h>

static void scale_radiance( HardScene* h, float scale )
{
    hard_stage( h, hard_glossy() );
    for ( uint32_t i = 0; i < h->scene.material_count; ++i )
        h->scene.materials[i].emission = rf_scale( h->scene.materials[i].emission, scale );
}

static void dim( HardScene* h ) { scale_radiance( h, 1e-31f ); }
static void bright( HardScene* h ) { scale_radiance( h, 1e29f ); }

// A light of 1e-12 m² as strong as the one above, and a faint one of 1e6 m².
static void tiny_beside_huge( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    uint32_t tiny = add_material( &b, make_light( 3e12f, true ) ), huge = add_material( &b, make_light( 0.2f, true ) );
    add_quad( &b, tiny, rf_vec3( 1.0f, 1.0f, 0.5f ), rf_vec3( 1.0f + 1e-6f, 1.0f, 0.5f ),
              rf_vec3( 1.0f + 1e-6f, 1.0f + 1e-6f, 0.5f ), rf_vec3( 1.0f, 1.0f + 1e-6f, 0.5f ) );
    add_quad( &b, huge, rf_vec3( -500, 20, -500 ), rf_vec3( 500, 20, -500 ), rf_vec3( 500, 20, 500 ), rf_vec3( -500, 20, 500 ) );
    h->scene = finish_scene( &b );
}

// A small lamp whose coordinates are far below those of what it lights.
static void lamp_at_origin( HardScene* h )
{
    hard_stage( h, hard_grey() );
    SceneBuilder b = hard_reopen( &h->scene );
    uint32_t light = add_material( &b, make_light( 3e3f, false ) );
    add_box( &b, light, rf_vec3( 1.18f, 1.98f, 1.18f ), rf_vec3( 1.22f, 2.02f, 1.22f ), false );
    h->scene = finish_scene( &b );
    hard_move( h, 1.0f, rf_vec3( -1.2f, -2.0f, -1.2f ) );
}

// Emissive triangles that are a point or a line, beside one that is not.
static void without_area( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    uint32_t light = add_material( &b, make_light( 5.0f, true ) );
    for ( int i = 0; i < 20; ++i )
    {
        RfVec3 p = rf_vec3( -1.0f + 0.1f * (float)i, 1.5f, 0.2f ), q = rf_madd( p, rf_vec3( 0, 1, 0 ), i % 2 == 0 ? 0.0f : 0.3f );
        add_quad( &b, light, p, q, p, q );
    }
    h->scene = finish_scene( &b );
}

// A lamp 1e-12 m above the floor, and one in it.
static void lamp_on_surface( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    h->scene.punctuals = calloc( 2, sizeof *h->scene.punctuals );
    h->scene.punctual_count = 2;
    h->scene.punctuals[0] = make_point_light( rf_vec3( 1.3f, 1e-12f, 0.7f ), 1e22f );
    h->scene.punctuals[1] = make_point_light( rf_vec3( -1.0f, 0.0f, 1.0f ), 1e22f );
}

// Two lamps over the floor of a scene of micrometres: W/sr over m² beyond floats.
static void lamps_in_a_tiny_scene( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    h->scene.punctuals = calloc( 2, sizeof *h->scene.punctuals );
    h->scene.punctual_count = 2;
    h->scene.punctuals[0] = make_point_light( rf_vec3( 1.3f, 1.0f, 0.7f ), 3.0f );
    h->scene.punctuals[1] = make_point_light( rf_vec3( -1.0f, 1.5f, 1.0f ), 3.0f );
    hard_move( h, 1e-6f, rf_vec3( 0, 0, 0 ) );
    for ( int i = 0; i < 2; ++i ) // as bright as a star
        h->scene.punctuals[i].intensity = rf_scale( h->scene.punctuals[i].intensity, 1e18f );
    for ( uint32_t i = 0; i < h->scene.material_count; ++i )
        h->scene.materials[i].emission = rf_scale( h->scene.materials[i].emission, 1e18f );
}

// 20 lamps whose powers go from 1e-6 to 1e6; the strong ones are hidden behind the wall from all that is seen.
static void ratios_of_power( HardScene* h )
{
    hard_stage( h, hard_grey() );
    SceneBuilder b = hard_reopen( &h->scene );
    for ( int i = 0; i < 20; ++i )
    {
        float power = powf( 10.0f, -6.0f + 12.0f * (float)i / 19.0f );
        bool hidden = i >= 10;
        uint32_t light = add_material( &b, make_light( 2e2f * power, true ) );
        RfVec3 p =
            rf_vec3( -1.5f + 0.15f * (float)i, hidden ? 1.0f : 2.0f, hidden ? -2.5f - 0.02f * (float)i : 0.03f * (float)i );
        add_quad( &b, light, p, rf_madd( p, rf_vec3( 0.03f, 0, 0 ), 1.0f ), rf_add( p, rf_vec3( 0.03f, 0.03f, 0 ) ),
                  rf_madd( p, rf_vec3( 0, 0.03f, 0 ), 1.0f ) );
    }
    h->scene = finish_scene( &b );
}

// A sky that is black but for one texel of 64 × 32: its neighbours shine by interpolation.
static void bright_texel( HardScene* h )
{
    SceneBuilder b = { 0 };
    uint32_t floor = add_material( &b, make_lambert( 0.8f, 0.8f, 0.8f ) );
    add_quad( &b, floor, rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ), rf_vec3( -2, 0, -2 ) );
    h->scene = finish_scene( &b );
    RfEnvironment* e = &h->scene.environment;
    *e = ( RfEnvironment ){ .radiance = { 1, 1, 1 }, .width = 64, .height = 32 };
    e->map = calloc( (size_t)( 3 * e->width * e->height ), sizeof *e->map );
    if ( e->map == NULL )
        abort();
    const int x = 63, y = 3;
    for ( int c = 0; c < 3; ++c )
        e->map[3 * ( y * e->width + x ) + c] = 1e4f;
    // ∫ of the tent around the texel times the cosine to +y, by rows
    const double pi = 3.14159265358979323846;
    double irradiance = 0.0;
    for ( int k = 0; k < 20000; ++k )
    {
        double at = ( k + 0.5 ) / 10000.0 - 1.0, polar = ( y + 0.5 + at ) / e->height * pi;
        irradiance += ( 1.0 - fabs( at ) ) * cos( polar ) * sin( polar ) / 10000.0;
    }
    irradiance *= 1e4 * ( pi / e->height ) * ( 2.0 * pi / e->width );
    h->value = (double)0.8f * irradiance / pi;
    h->within = 2e-4;
    hard_eyes( h, rf_vec3( 0, 1.3f, 0.5f ), rf_vec3( 0.05f, 0, 0 ), rf_vec3( 0, -1, -0.1f ), 40.0 );
}

static void no_lights( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( uint32_t i = 0; i < h->scene.material_count; ++i )
        h->scene.materials[i].emission = rf_vec3( 0, 0, 0 );
    h->scene.punctuals = calloc( 1, sizeof *h->scene.punctuals );
    h->scene.punctual_count = 1;
    h->scene.punctuals[0] = make_point_light( rf_vec3( 0.5f, 1.5f, 1.0f ), 0.0f );
}

// A lit room and a dark one that share a wall of no thickness; the eyes are in the dark one.
static void dark_room( HardScene* h, float scale )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, hard_glossy() ), light = add_material( &b, make_light( 1e6f, true ) );
    add_box( &b, grey, rf_vec3( -1, 0, -1 ), rf_vec3( 1, 1.7f, 1 ), true );
    add_box( &b, grey, rf_vec3( 1, 0, -1 ), rf_vec3( 3, 1.7f, 1 ), true );
    add_box( &b, grey, rf_vec3( -1, 1.7f, -1 ), rf_vec3( 1, 3, 1 ), true );
    add_quad( &b, light, rf_vec3( 1.2f, 1.6f, -0.8f ), rf_vec3( 2.8f, 1.6f, -0.8f ), rf_vec3( 2.8f, 1.6f, 0.8f ),
              rf_vec3( 1.2f, 1.6f, 0.8f ) );
    add_quad( &b, light, rf_vec3( -0.9f, 2.9f, -0.9f ), rf_vec3( 0.9f, 2.9f, -0.9f ), rf_vec3( 0.9f, 2.9f, 0.9f ),
              rf_vec3( -0.9f, 2.9f, 0.9f ) );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0, 0.9f, 0.3f ), rf_vec3( 0.4f, 0, 0 ), rf_vec3( 0.6f, -0.1f, -1 ),
               90.0 ); // the last two in the lit room
    hard_move( h, scale, rf_vec3( 0, 0, 0 ) );
}

static void dark_room_1( HardScene* h ) { dark_room( h, 1.0f ); }
static void dark_room_small( HardScene* h ) { dark_room( h, 1e-6f ); }
static void dark_room_large( HardScene* h ) { dark_room( h, 1e6f ); }

// A dark ball of triangles with smooth normals in a lit room: directions above the normal, but below the triangle.
static void dark_ball( HardScene* h )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, hard_grey() ), light = add_material( &b, make_light( 1e6f, true ) );
    add_sphere( &b, grey, rf_vec3( 0, 0, 0 ), 1.0f, 4 );
    add_box( &b, light, rf_vec3( -2, -2, -2 ), rf_vec3( 2, 2, 2 ), true );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0, 0.1f, 0.2f ), rf_vec3( 0.03f, 0, 0 ), rf_vec3( 0.3f, 0.1f, -1 ), 100.0 );
}

static void nothing_there( HardScene* h )
{
    hard_stage( h, hard_grey() );
    rf_destroy_scene( &h->scene );
}

// Inside of a box that is bright on both sides: the mean of its three channels.
static void in_an_emitter( HardScene* h )
{
    SceneBuilder b = { 0 };
    add_box( &b, add_material( &b, make_light( 2.0f, true ) ), rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), false );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0, 0, 0 ), rf_vec3( 0.02f, 0, 0 ), rf_vec3( 0, 0, -1 ), 50.0 );
    h->value = 2.0 * 2.9 / 3.0;
    h->within = 1e-5;
}

// The light above a second time, in another colour, by the same triangles in another order and from other corners.
static void one_place( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    RfMaterial second = make_light( 10.0f, false );
    second.emission = rf_vec3( 1, 2, 10 );
    add_quad( &b, add_material( &b, second ), rf_vec3( 0.6f, 2.5f, 0.6f ), rf_vec3( -0.6f, 2.5f, 0.6f ),
              rf_vec3( -0.6f, 2.5f, -0.6f ), rf_vec3( 0.6f, 2.5f, -0.6f ) );
    h->scene = finish_scene( &b );
    if ( rf_take_out_twins( &h->scene, NULL, NULL ) != RF_OK )
        abort();
}

const HardCase g_hard_light[] = {
    { "radiance-1e-30", "light of 1e-30 W/(m2 sr)", "products and squares below floats", HARD_DOUBLE, 1.5, dim, NULL },
    { "radiance-1e30", "light of 1e30 W/(m2 sr)", "products and squares beyond floats", HARD_DOUBLE, 1.5, bright, NULL },
    { "lights-1e-12-1e6", "a light of 1e-12 m2 beside one of 1e6 m2", "densities per area of 1e12, sums of powers", HARD_DOUBLE,
      1.5, tiny_beside_huge, NULL },
    { "lamp-at-origin", "a lamp of 4 cm around the origin", "rounding of where its shadow rays begin", HARD_DOUBLE, 2.0,
      lamp_at_origin, NULL },
    { "lights-without-area", "emissive points and lines", "1/area", HARD_DOUBLE, 1.5, without_area, NULL },
    { "lamp-on-surface", "lamps as bright as stars on a floor and 1e-12 m above it", "1/d2 beyond floats", HARD_FINITE, 0,
      lamp_on_surface, NULL },
    { "lamps-1e-6", "lamps as bright as stars in a room of micrometres", "intensity over d2 times the density of a delta",
      HARD_DOUBLE, 1.5, lamps_in_a_tiny_scene, NULL },
    { "powers-1e12", "20 lamps whose powers differ by 1e12, the strong ones hidden", "sums of importances in floats", HARD_DOUBLE,
      2.0, ratios_of_power, NULL },
    { "sky-one-texel", "a black sky with one bright texel", "interpolation beyond the texel, densities of 0", HARD_VALUE, 1.5,
      bright_texel, NULL },
    { "no-light", "a scene whose lights are black", "sums of powers of 0", HARD_BLACK, 0, no_lights, NULL },
    { "nothing-there", "a scene without triangles", "bounds, BVH and lists of nothing", HARD_BLACK, 0, nothing_there, NULL },
    { "lights-in-one-place", "two lights of the same corners", "light samples find both of them, rays one", HARD_DOUBLE, 1.5,
      one_place, NULL },
    { "in-an-emitter", "eyes inside of a light", "lights seen from behind", HARD_VALUE, 0, in_an_emitter, NULL },
    { "dark-room", "a dark room beside and below a lit one", "rays that start beyond walls of no thickness", HARD_BLACK, 0,
      dark_room_1, NULL },
    { "dark-room-1e-6", "the same, 1e-6 as large", "offsets", HARD_BLACK, 0, dark_room_small, NULL },
    { "dark-room-1e6", "the same, 1e6 as large", "offsets", HARD_BLACK, 0, dark_room_large, NULL },
    { "dark-ball", "a closed ball with smooth normals, seen from inside", "directions below the triangle", HARD_BLACK, 0,
      dark_ball, NULL },
    { 0 },
};
