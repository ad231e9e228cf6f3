// Scenes of meshes that are placed give the pictures that they give in world space, at the same seed: all but a few pixels, whose
// paths part where a rounding decides.
#include "support/placed_scenes.h"
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include "film/aov.h"
#include "scene/placement.h"

#include <math.h>
#include <stdio.h>

#define EYES 5
#define WIDTH 40
#define HEIGHT 30
#define PIXELS ( WIDTH * HEIGHT )

typedef RfScene MakeRoom( void );

static RfScene make_panes( void ) { return make_pane_room( PANES_AND_ALL ); }
static RfScene make_lamp_in_glass( void ) { return make_mirror_room( LAMP_IN_GLASS ); }
static RfScene make_sign( void ) { return make_mirror_room( MIRROR_BY_SIGN ); }
static RfScene make_holes( void ) { return make_mirror_room( MASKED_MIRROR ); }
static RfScene make_sharp_metal( void ) { return make_mirror_room( SHARP_METAL ); }
static RfScene make_open( void ) { return make_open_scene( LIT_BY_ALL ); }

typedef struct Case
{
    const char* name;
    MakeRoom* make;
    PlacedKind kind;
    bool mirrors;  // flat ones are placed too: pictures are the same where nothing uses them
    double others; // values that may differ; 1: rays are hashed, so all may
} Case;

static const Case s_cases[] = {
    { "textured", make_textured_room, PLACED_STRETCHED, true, 0.005 },
    { "textured, mirrored", make_textured_room, PLACED_MIRRORED, true, 0.005 },
    { "blended", make_blended_room, PLACED_MIRRORED, true, 1.0 },
    { "varied", make_varied_room, PLACED_STRETCHED, true, 0.005 },
    { "panes", make_panes, PLACED_TURNED, true, 1.0 },
    { "lamp in glass", make_lamp_in_glass, PLACED_SCALED, false, 0.005 },
    { "mirror", make_sign, PLACED_STRETCHED, false, 0.005 },
    { "mirror with holes", make_holes, PLACED_STRETCHED, true, 0.005 },
    { "sharp metal", make_sharp_metal, PLACED_MIRRORED, false, 0.005 },
    { "open", make_open, PLACED_STRETCHED, true, 0.005 },
};

// By a rotation about all axes: where a normal has a coordinate of 0, its sign, a rounding, turns directions that are drawn.
static void turn_vector( RfVec3* v )
{
    double q[4] = { 0.2, 0.3, -0.4, sqrt( 1.0 - 0.29 ) }, none[3] = { 0, 0, 0 }, one[3] = { 1, 1, 1 };
    RfMat4 turn = rf_mat4_from_trs( none, q, one );
    *v = rf_place_point( &turn, *v );
}

static void turn_scene( RfScene* scene )
{
    RfTriangles* t = &scene->triangles;
    for ( size_t i = 0; i < t->vertex_count; ++i )
    {
        turn_vector( (RfVec3*)(void*)( t->positions + 3 * i ) );
        turn_vector( (RfVec3*)(void*)( t->normals + 3 * i ) );
    }
    for ( int i = 0; i < scene->punctual_count; ++i )
    {
        turn_vector( &scene->punctuals[i].position );
        turn_vector( &scene->punctuals[i].direction );
    }
}

static void turn_eye( RfEye* eye )
{
    turn_vector( &eye->origin );
    turn_vector( &eye->forward );
    turn_vector( &eye->right );
    turn_vector( &eye->up );
}

static void check_case( const Case* c, const char* mode, const RfRenderSettings* settings )
{
    Stage stages[2];
    const RfFrameResult* pictures[2];
    for ( int k = 0; k < 2; ++k )
    {
        Stage* stage = stages + k;
        open_stage( stage, c->make(), EYES, 3.0f, WIDTH, HEIGHT );
        for ( int i = 0; i < EYES; ++i )
            turn_eye( stage->eyes + i );
        turn_scene( &stage->scene );
        place_scene( &stage->scene, c->kind, 4, c->mirrors );
        if ( k == 1 )
            flatten_scene( &stage->scene );
        pictures[k] = render_one( stage, EYES / 2, settings );
    }
    double others = share_of_others( pictures[0]->rgb, pictures[1]->rgb, 3 * PIXELS );
    double a = mean_value( pictures[0]->rgb, 3 * PIXELS ), b = mean_value( pictures[1]->rgb, 3 * PIXELS );
    printf( "%s, %s: %.2f %% of the values differ, the mean by %.2g\n", c->name, mode, 100.0 * others, fabs( a / b - 1.0 ) );
    assert_true( b > 0.0 );
    assert_true( others <= c->others );
    assert_true( fabs( a / b - 1.0 ) < ( c->others < 1.0 ? 0.001 : 0.03 ) );
    expect_like_aovs( c->name, pictures[0], pictures[1], 0.02 );
    close_stage( stages );
    close_stage( stages + 1 );
}

static RfRenderSettings settings_of( int group, const char* tile )
{
    RfRenderSettings settings = tiled_settings( group, 7, tile );
    settings.adaptive = RF_ADAPTIVE_OFF;
    return settings;
}

static void check_all( const char* mode, RfRenderSettings settings, int first, int step )
{
    int count = (int)( sizeof s_cases / sizeof s_cases[0] );
    for ( int i = first; i < count; i += step )
        check_case( s_cases + i, mode, &settings );
}

TEST( test_path_tracing )
{
    RfRenderSettings settings = settings_of( 0, "1" );
    settings.aovs = RF_AOV_BIT( RF_AOV_ALBEDO ) | RF_AOV_BIT( RF_AOV_NORMAL ) | RF_AOV_BIT( RF_AOV_DEPTH ) |
                    RF_AOV_BIT( RF_AOV_MOTION ) | RF_AOV_BIT( RF_AOV_SAMPLES );
    check_all( "paths", settings, 0, 1 );
}

TEST( test_groups_and_tiles )
{
    check_all( "groups", settings_of( 2, "1" ), 0, 2 );
    check_all( "tiles", settings_of( 0, "3x3" ), 1, 2 );
    check_all( "groups and tiles", settings_of( 2, "3x3" ), 0, 1 );
}

TEST( test_light_paths )
{
    RfRenderSettings settings = settings_of( 0, "1" );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    check_case( s_cases + 5, "light paths", &settings );
    settings = settings_of( 2, "3x3" );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    check_case( s_cases + 5, "light paths in groups", &settings );
}

TEST( test_gradients )
{
    RfRenderSettings settings = settings_of( 0, "1" );
    settings.estimator = rf_find_estimator( "gradient" );
    check_all( "gradients", settings, 0, 3 );
}
