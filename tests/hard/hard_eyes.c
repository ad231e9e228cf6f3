// Hard cases of eyes, films and paths.
#include "hard/hard.h"

#include <math.h>

#define PI 3.14159265358979323846

// A floor seen at this angle, through a lens so long that all of the film sees it at about that; eyes side by side.
static void grazing( HardScene* h, float angle )
{
    hard_stage( h, hard_glossy() );
    float distance = 1.2f, height = distance * angle;
    // between the block and the right border of the floor
    hard_eyes( h, rf_vec3( 1.3f, height, 1.8f ), rf_vec3( 0.02f * angle, 0, 0 ), rf_vec3( 0, -angle, -1 ), 60.0 * (double)angle );
}

static void grazing_2( HardScene* h ) { grazing( h, 1e-2f ); }
static void grazing_5( HardScene* h ) { grazing( h, 1e-5f ); }

// Eyes that see the same floor at 1e-5, 1e-4 … 1 rad: film densities of all magnitudes in one sum.
static void grazing_beside_steep( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    RfVec3 target = rf_vec3( 1.3f, 0, 0.4f );
    for ( int i = 0; i < 7; ++i )
    {
        float angle = powf( 10.0f, -5.0f + 5.0f * (float)( i == 3 ? 2 : i ) / 6.0f );
        RfVec3 o = rf_vec3( 1.3f, 1.2f * sinf( angle ), 0.4f + 1.2f * cosf( angle ) );
        h->eyes[i] = rf_make_eye( o, rf_sub( target, o ), rf_vec3( 0, 1, 0 ), 0.5, HARD_WIDTH, HARD_HEIGHT );
    }
}

// The stage in a closed room.
static void closed_stage( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    add_box( &b, 0, rf_vec3( -4, -1, -4 ), rf_vec3( 4, 5, 4 ), true );
    h->scene = finish_scene( &b );
}

// In a closed room: the biased weightings count what misses in its own frame alone.
static void coincident( HardScene* h )
{
    closed_stage( h );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = h->eyes[3];
}

// Five frames of one eye between two that move.
static void stands_still( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 1; i < 6; ++i )
        h->eyes[i] = h->eyes[3];
}

static void close_by( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i].origin.x = 1e-6f * (float)( i - 3 );
}

// A floor through the origin, where floats are densest, and a light.
static void empty_stage( HardScene* h )
{
    SceneBuilder b = { 0 };
    uint32_t floor = add_material( &b, hard_glossy() ), light = add_material( &b, make_light( 10.0f, false ) );
    add_quad( &b, floor, rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ), rf_vec3( -2, 0, -2 ) );
    add_quad( &b, light, rf_vec3( -0.6f, 2.5f, -0.6f ), rf_vec3( 0.6f, 2.5f, -0.6f ), rf_vec3( 0.6f, 2.5f, 0.6f ),
              rf_vec3( -0.6f, 2.5f, 0.6f ) );
    h->scene = finish_scene( &b );
}

// One eye is as good as on the floor and looks down at it, while the others see that place from afar.
static void on_surface( HardScene* h )
{
    empty_stage( h );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( rf_vec3( 0, i == 4 ? 1e-20f : 0.5f + 0.2f * (float)i, 0 ), rf_vec3( 0, -1, -1e-3f ),
                                  rf_vec3( 0, 1, 0 ), 0.9, HARD_WIDTH, HARD_HEIGHT );
}

// From 10^last m above the floor in the middle of the path to 1e-9 m at its ends.
static void above_the_floor( HardScene* h, float last )
{
    empty_stage( h );
    for ( int i = 0; i < 7; ++i )
    {
        float exponent = -9.0f + ( last + 9.0f ) * (float)( i < 3 ? i : 6 - i ) / 3.0f;
        h->eyes[i] = rf_make_eye( rf_vec3( 0, powf( 10.0f, exponent ), 0 ), rf_vec3( 0, -1, -1e-3f ), rf_vec3( 0, 1, 0 ), 0.9,
                                  HARD_WIDTH, HARD_HEIGHT );
    }
}

static void touching( HardScene* h ) { above_the_floor( h, -12.0f ); }

// Film densities beyond floats, which are cut off at 1e30 px²/m².
static void beyond_floats( HardScene* h ) { above_the_floor( h, -24.0f ); }

// Along a floor that is tilted, from 6e-6 m above it, 250 m from the origin: some hits lie above the eye by rounding.
static void grazing_tilted( HardScene* h )
{
    SceneBuilder b = { 0 };
    uint32_t floor = add_material( &b, hard_glossy() ), light = add_material( &b, make_light( 10.0f, true ) );
    RfVec3 x = rf_normalize( rf_vec3( 0.8f, -0.3f, 0.1f ) ), z = rf_normalize( rf_vec3( -0.1f, 0.1f, 0.9f ) );
    RfVec3 n = rf_normalize( rf_cross( z, x ) ), at = rf_vec3( 130.0f, -70.0f, 210.0f );
    RfVec3 p = rf_madd( rf_madd( at, x, -2 ), z, 2 ), q = rf_madd( rf_madd( at, x, 2 ), z, 2 );
    RfVec3 r = rf_madd( rf_madd( at, x, 2 ), z, -2 ), s = rf_madd( rf_madd( at, x, -2 ), z, -2 ), up = rf_scale( n, 2.0f );
    add_quad( &b, floor, p, q, r, s );
    add_quad( &b, light, rf_add( p, up ), rf_add( q, up ), rf_add( r, up ), rf_add( s, up ) );
    h->scene = finish_scene( &b );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( rf_madd( rf_madd( at, n, 6e-6f ), x, 0.01f * (float)i ),
                                  rf_madd( rf_scale( z, -1.0f ), n, -6e-6f ), n, 8e-6, HARD_WIDTH, HARD_HEIGHT );
}

// Exactly in the plane of the floor, along which all eyes but two look.
static void in_plane( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( rf_vec3( 1.3f, i % 3 == 0 ? 0.3f : 0.0f, 1.9f ), rf_vec3( -0.4f, -0.05f, -1 ),
                                  rf_vec3( 0, 1, 0 ), 0.8, HARD_WIDTH, HARD_HEIGHT );
}

// In the block, where no light gets: black; the frames around are lit.
static void inside( HardScene* h )
{
    hard_stage( h, hard_grey() );
    h->eyes[3] =
        rf_make_eye( rf_vec3( 0.1f, 0.3f, 0 ), rf_vec3( 0.3f, 0.1f, -1 ), rf_vec3( 0, 1, 0 ), 1.2, HARD_WIDTH, HARD_HEIGHT );
}

// Behind the back wall: half of the eyes see one side of it, half the other.
static void behind( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 1; i < 7; i += 2 )
        h->eyes[i] = rf_make_eye( rf_vec3( 0.1f * (float)i, 1.5f, -3.0f ), rf_vec3( 0, 0, 1 ), rf_vec3( 0, 1, 0 ), 1.2,
                                  HARD_WIDTH, HARD_HEIGHT );
    h->eyes[3] = h->eyes[2];
}

static void angle_1( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    hard_eyes( h, rf_vec3( 0.2f, 1.3f, 2.1f ), rf_vec3( 1e-3f, 0, 0 ), rf_vec3( -0.1f, -0.55f, -1.0f ), 1.0 );
}

// What is at the border of one film is in the middle of others.
static void angle_170( HardScene* h )
{
    closed_stage( h );
    h->spp = 42; // few pixels hold the light: with 7, five seeds do not know the noise
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( rf_vec3( 0.2f + 0.1f * (float)( i - 3 ), 1.3f, 1.6f ),
                                  rf_vec3( -0.1f + 0.5f * (float)( i - 3 ), -0.45f, -1.0f ), rf_vec3( 0, 1, 0 ),
                                  170.0 * PI / 180.0, HARD_WIDTH, HARD_HEIGHT );
}

// From 1e5 m, by a lens of 2e-5 rad: the rounding of the eyes' coordinates is as large as what they see.
static void far_away( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    RfVec3 back = rf_vec3( 1e4f, 2e4f, 1e5f );
    hard_eyes( h, rf_vec3( back.x, back.y, back.z ), rf_vec3( 200.0f, 0, 0 ), rf_scale( back, -1.0f ), 1e-3 );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( h->eyes[i].origin, rf_scale( h->eyes[i].origin, -1.0f ), rf_vec3( 0, 1, 0 ), 2e-5, HARD_WIDTH,
                                  HARD_HEIGHT );
}

static void one_pixel( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    hard_film( h, 1, 1 );
    h->spp = 140;
}

static void one_sample( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 0; i < 7; ++i ) // no frame sees what another does
        h->eyes[i] = rf_make_eye( rf_vec3( 0.2f, 1.3f, 1.6f ), rf_vec3( sinf( 0.9f * (float)i ), -0.3f, cosf( 0.9f * (float)i ) ),
                                  rf_vec3( 0, 1, 0 ), 0.3, HARD_WIDTH, HARD_HEIGHT );
    h->spp = 1;
}

static void wide_film( HardScene* h )
{
    hard_stage( h, hard_grey() );
    h->eye_count = 3;
    h->group = 1;
    h->spp = 3;
    h->max_depth = 2;
    hard_eyes( h, rf_vec3( 0.2f, 1.3f, 2.1f ), rf_vec3( 0.1f, 0, 0 ), rf_vec3( -0.1f, -0.45f, -1.0f ), 0.004 );
    hard_film( h, 16384, 1 );
}

// Every frame looks the other way, so that what is behind an eye would be seen upside down.
static void turns( HardScene* h )
{
    closed_stage( h );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( rf_vec3( 0.2f, 1.3f, 1.4f ), rf_scale( rf_vec3( 0.1f, -0.3f, -1 ), i % 2 == 1 ? 1.0f : -1.0f ),
                                  rf_vec3( 0, i == 5 ? -1.0f : 1.0f, 0 ), 1.2, HARD_WIDTH, HARD_HEIGHT );
}

// The up vector is opposite to the view, but for 3e-8.
static void gimbal( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i] = rf_make_eye( rf_vec3( 0.1f + 0.02f * (float)i, 2.2f, 0.9f ), rf_vec3( 0.37f, -0.95f, -0.44f ),
                                  rf_vec3( -0.37f + 3e-8f * (float)( 1 + i % 3 ), 0.95f, 0.44f ), 0.9, HARD_WIDTH, HARD_HEIGHT );
}

static void jumps( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    for ( int i = 0; i < 7; ++i )
        h->eyes[i].origin =
            rf_madd( h->eyes[i].origin, rf_vec3( 0.3f, 0.2f, 0.5f ), i % 2 == 0 ? powf( 10.0f, (float)( i - 2 ) ) : 0.0f );
}

// A frame twice, then once more at the end.
static void repeats( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    h->eyes[4] = h->eyes[3];
    h->eyes[6] = h->eyes[3];
}

// From behind the back wall through it, one eye exactly in it; the tested one is just beyond.
static void through_a_wall( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    hard_eyes( h, rf_vec3( 0.3f, 1.2f, -1.9f ), rf_vec3( 0, 0, 0.1f ), rf_vec3( 0.4f, -0.5f, 1 ), 70.0 );
}

static void beyond_the_path( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    h->eye_count = 2;
    h->group = RF_MAX_GROUP;
    h->spp = 6;
}

const HardCase g_hard_eyes[] = {
    { "grazing-1e-2", "a floor seen at 0.01 rad", "J near 0: quotients of densities", HARD_DOUBLE, 1.5, grazing_2, NULL },
    { "grazing-1e-5", "a floor seen at 1e-5 rad", "J near 0, cosines below the horizon of the models", HARD_DOUBLE, 1.5,
      grazing_5, NULL },
    { "grazing-beside-steep", "eyes that see one floor at 1e-5 to 1 rad", "densities of all magnitudes in one sum", HARD_DOUBLE,
      1.5, grazing_beside_steep, NULL },
    { "eyes-coincide", "seven frames of one eye", "all weights are 1/7", HARD_DOUBLE, 0.5, coincident, NULL },
    { "eyes-1e-6-apart", "eyes 1e-6 m apart", "differences near the rounding of coordinates", HARD_DOUBLE, 0.5, close_by, NULL },
    { "eye-on-surface", "an eye 1e-20 m above the floor that others see", "J = inf", HARD_DOUBLE, 1.5, on_surface, NULL },
    { "eyes-touch-surface", "eyes 1e-9 to 1e-12 m from the floor", "J up to 1e26 px2/m2; hits 1e-12 m away", HARD_DOUBLE, 1.5,
      touching, NULL },
    { "density-beyond-floats", "eyes down to 1e-24 m from the floor", "J beyond floats: inf/inf", HARD_FINITE, 0, beyond_floats,
      NULL },
    { "grazing-tilted", "a tilted floor seen along it from 6e-6 m above", "J below 0 by rounding", HARD_FINITE, 0, grazing_tilted,
      NULL },
    { "eyes-in-plane", "eyes exactly in the plane of what others see", "J = 0: 0/0", HARD_DOUBLE, 1.5, in_plane, NULL },
    { "eye-inside", "an eye in a closed block that others see", "leaks by reprojection", HARD_BLACK, 0, inside, NULL },
    { "eyes-behind", "eyes on both sides of a wall", "hits seen from behind", HARD_DOUBLE, 1.5, behind, NULL },
    { "angle-1", "an angle of view of 1 degree", "pixels of 1e-3 rad", HARD_DOUBLE, 1.5, angle_1, NULL },
    { "angle-170", "an angle of view of 170 degrees", "the cubed cosine of J at the border", HARD_DOUBLE, 1.5, angle_170, NULL },
    { "eyes-far-away", "eyes 1e5 m away", "their rounding is 0.01 m", HARD_DOUBLE, 0.6, far_away, NULL },
    { "one-pixel", "a film of 1 x 1", "tiles and patches beyond the film", HARD_DOUBLE, 3.0, one_pixel, NULL },
    { "one-sample", "one sample, frames that share nothing", "an empty half of the film: 0/0", HARD_FINITE, 0, one_sample, NULL },
    { "film-16384x1", "a film of 16384 x 1", "hits on the borders of pixels; 1e-3 px of rounding", HARD_DOUBLE, 1.5, wide_film,
      NULL },
    { "path-turns", "every frame looks the other way", "what is behind an eye projects into its film as well", HARD_DOUBLE, 1.5,
      turns, NULL },
    { "path-gimbal", "views along the up vector, 3e-8 rad off", "a frame from nearly parallel vectors", HARD_DOUBLE, 1.5, gimbal,
      NULL },
    { "path-jumps", "frames 1e4 m apart", "densities 1e10 apart", HARD_DOUBLE, 1.5, jumps, NULL },
    { "path-stands-still", "five frames of one eye between two that move", "as eyes-coincide, beside eyes that move", HARD_DOUBLE,
      0.5, stands_still, NULL },
    { "path-repeats", "a frame three times in the group", "pairs of equal densities", HARD_DOUBLE, 1.0, repeats, NULL },
    { "path-through-wall", "from behind a wall through it, one eye in it", "J = 0 and sides that change", HARD_DOUBLE, 1.5,
      through_a_wall, NULL },
    { "group-beyond-path", "a group of 2097153 in a path of 2 frames", "indices of frames, bits of visibility", HARD_DOUBLE, 1.5,
      beyond_the_path, NULL },
    { 0 },
};
