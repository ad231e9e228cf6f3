// Hard cases of scenes: very small, very large and distant ones have the same radiance;
// odd triangles and extreme materials give finite pictures.
#include "support/render_support.h"
#include "support/statistics.h"
#include "support/test.h"

#define EYES 5
#define WIDTH 24
#define HEIGHT 18
#define SEED_COUNT 8

static void seed_means( RfScene scene, int group, float scale, RfVec3 shift, double means[SEED_COUNT] )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    move_scene( &scene, scale, shift );
    for ( int i = 0; i < EYES; ++i )
        eyes[i].origin = rf_madd( shift, eyes[i].origin, scale );
    AUTO_TRACER tracer = make_tracer( &scene );
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        RfRenderSettings settings = small_settings( group, 10 );
        settings.seed = (uint64_t)k + 1;
        means[k] = check_sane_settings( "scaled", tracer, eyes, EYES, &settings );
    }
    rf_destroy_scene( &scene );
}

// The numbers of a seed are those of the unscaled scene, so what differs is
// little; the noise is what another seed would make of it.
static void check_scale( float scale, RfVec3 shift )
{
    for ( int group = 0; group <= 2; group += 2 )
    {
        static double kept[3][SEED_COUNT]; // of the unscaled scene, by group
        double scaled[SEED_COUNT], difference[SEED_COUNT], error, paired;
        double* plain = kept[group];
        if ( plain[0] == 0.0 )
            seed_means( make_room( ROOM_GGX ), group, 1.0f, rf_vec3( 0, 0, 0 ), plain );
        seed_means( make_room( ROOM_GGX ), group, scale, shift, scaled );
        for ( int k = 0; k < SEED_COUNT; ++k )
            difference[k] = scaled[k] - plain[k];
        double mean = mean_of( plain, SEED_COUNT, &error ), off = mean_of( difference, SEED_COUNT, &paired );
        printf( "scale %g shift (%g %g %g) group %d: mean off by %.3f%% (noise %.3f%%, of the difference %.3f%%)\n",
                (double)scale, (double)shift.x, (double)shift.y, (double)shift.z, group, 100.0 * off / mean, 100.0 * error / mean,
                100.0 * paired / mean );
        assert_true( fabs( off ) < 4.0 * error );
    }
}

TEST( test_scale_invariance )
{
    check_scale( 1e-3f, rf_vec3( 0, 0, 0 ) );
    check_scale( 1e3f, rf_vec3( 0, 0, 0 ) );
    check_scale( 1e5f, rf_vec3( 0, 0, 0 ) );
    check_scale( 1e12f, rf_vec3( 0, 0, 0 ) );
    check_scale( 1e3f, rf_vec3( 1e4f, -1e4f, 1e4f ) );
}

// Lamps without size in a scene of some tenths of a millimetre: the same radiance.
TEST( test_lamps_in_tiny_scenes )
{
    double plain[SEED_COUNT], small[SEED_COUNT], difference[SEED_COUNT], error, paired;
    seed_means( make_open_scene( LIT_BY_LAMPS ), 0, 1.0f, rf_vec3( 0, 0, 0 ), plain );
    seed_means( make_open_scene( LIT_BY_LAMPS ), 0, 1e-4f, rf_vec3( 0, 0, 0 ), small );
    for ( int k = 0; k < SEED_COUNT; ++k )
        difference[k] = small[k] - plain[k];
    double mean = mean_of( plain, SEED_COUNT, &error ), off = mean_of( difference, SEED_COUNT, &paired );
    printf( "lamps, scale 1e-4: mean off by %.3f%% (noise %.3f%%, of the difference %.3f%%)\n", 100.0 * off / mean,
            100.0 * error / mean, 100.0 * paired / mean );
    assert_true( fabs( off ) < 4.0 * error );
}

TEST( test_far_from_the_origin )
{
    check_scale( 1.0f, rf_vec3( 100, 0, -100 ) );
    check_scale( 1.0f, rf_vec3( 1e4f, 0, 0 ) );
}

TEST( test_very_small_scenes )
{
    check_scale( 1e-5f, rf_vec3( 0, 0, 0 ) );
    check_scale( 1e-9f, rf_vec3( 0, 0, 0 ) );
    check_scale( 1e-12f, rf_vec3( 0, 0, 0 ) );
}

// Something tiny, far away and out of sight stretches the bounds of the scene;
// offsets that grew with them would let eyes see around edges.
TEST( test_a_far_thing_changes_nothing )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 20.0f, WIDTH, HEIGHT );
    for ( int group = 0; group <= 2; group += 2 )
    {
        RfRenderSettings settings = small_settings( group, 20 );
        double mean[2] = { 0.0, 0.0 }, difference = 0.0;
        Rendered rendered[2];
        for ( int far = 0; far < 2; ++far )
        {
            RfScene scene = make_room( ROOM_DIFFUSE );
            SceneBuilder b = { .scene = scene,
                               .vertex_room = scene.triangles.vertex_count,
                               .triangle_room = scene.triangles.count };
            if ( far )
                add_quad( &b, 0, rf_vec3( 3000, 0, 0 ), rf_vec3( 3000.1f, 0, 0 ), rf_vec3( 3000.1f, 0.1f, 0 ),
                          rf_vec3( 3000, 0.1f, 0 ) );
            free( b.scene.path );
            scene = finish_scene( &b );
            AUTO_TRACER tracer = make_tracer( &scene );
            rendered[far] = render_all( tracer, eyes, EYES, &settings );
            for ( size_t i = 0; i < 3 * rendered[far].pixels * EYES; ++i )
                mean[far] += (double)rendered[far].rgb[i];
            rf_destroy_scene( &scene );
        }
        for ( size_t i = 0; i < 3 * rendered[0].pixels * EYES; ++i )
            difference += fabs( (double)rendered[0].rgb[i] - (double)rendered[1].rgb[i] );
        printf( "a thing at 3000, group %d: mean differs by %.2g, pixels by %.2g of the mean\n", group, mean[1] / mean[0] - 1.0,
                difference / mean[0] );
        // the paths are the same but for rounding in the other tree
        assert_true( mean[0] > 0.0 && fabs( mean[1] / mean[0] - 1.0 ) < 1e-3 );
        assert_true( difference / mean[0] < 1e-2 );
        free_rendered( rendered );
        free_rendered( rendered + 1 );
    }
}

// A floor and a light over it, with something between.
typedef void AddThing( SceneBuilder* b, uint32_t grey, uint32_t light );

static void check_thing( const char* what, AddThing* add )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_plastic( 0.5f, 0.3f ) ), light = add_material( &b, make_light( 4.0f, true ) );
    add_quad( &b, grey, rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ), rf_vec3( -2, 0, -2 ) );
    add( &b, grey, light );
    AUTO_SCENE scene = finish_scene( &b );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    check_sane( what, &scene, eyes, EYES );
}

static void add_duplicates( SceneBuilder* b, uint32_t grey, uint32_t light )
{
    for ( int k = 0; k < 3; ++k )
    {
        add_box( b, grey, rf_vec3( -0.5f, 0, -0.5f ), rf_vec3( 0.5f, 1, 0.5f ), k == 1 );
        add_quad( b, light, rf_vec3( -1, 2, -1 ), rf_vec3( 1, 2, -1 ), rf_vec3( 1, 2, 1 ), rf_vec3( -1, 2, 1 ) );
    }
}

static void add_needles( SceneBuilder* b, uint32_t grey, uint32_t light )
{
    for ( int k = 0; k < 20; ++k )
    {
        float x = -1.0f + 0.1f * (float)k, thin = powf( 10.0f, -0.5f * (float)k ); // down to nothing
        uint32_t m = k % 2 == 0 ? grey : light;
        add_quad( b, m, rf_vec3( x, 0, 0 ), rf_vec3( x + thin, 0, 0 ), rf_vec3( x + thin, 2, 0.1f ), rf_vec3( x, 2, 0.1f ) );
        add_quad( b, m, rf_vec3( x, 1, 0 ), rf_vec3( x, 1, 0 ), rf_vec3( x, 1, 0 ), rf_vec3( x, 1, 0 ) );
        add_quad( b, m, rf_vec3( x, 0, 1 ), rf_vec3( x, 1, 1 ), rf_vec3( x, 2, 1 ), rf_vec3( x, 3, 1 ) ); // in a line
    }
}

static void add_touching_light( SceneBuilder* b, uint32_t grey, uint32_t light )
{
    // the light lies in the floor, and touches a wall along an edge
    add_quad( b, light, rf_vec3( -1, 0, 1 ), rf_vec3( 1, 0, 1 ), rf_vec3( 1, 0, -1 ), rf_vec3( -1, 0, -1 ) );
    add_quad( b, grey, rf_vec3( -1, 0, -1 ), rf_vec3( 1, 0, -1 ), rf_vec3( 1, 2, -1 ), rf_vec3( -1, 2, -1 ) );
    add_quad( b, light, rf_vec3( -1, 1, -1 ), rf_vec3( 1, 1, -1 ), rf_vec3( 1, 2, 0 ), rf_vec3( -1, 2, 0 ) );
}

TEST( test_odd_triangles_stay_finite )
{
    check_thing( "duplicates", add_duplicates );
    check_thing( "needles", add_needles );
    check_thing( "touching", add_touching_light );
}

static void set_material( RfScene* scene, uint32_t index, RfMaterial material )
{
    material.name = scene->materials[index].name;
    scene->materials[index] = material;
}

static void check_material( const char* what, RfMaterial material, float radiance )
{
    AUTO_SCENE scene = make_room( ROOM_GGX );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, 12, 9 );
    set_material( &scene, ROOM_OBJECT_MATERIAL, material );
    set_material( &scene, 0, material ); // the walls too
    scene.materials[2].emission = rf_vec3( radiance, radiance, radiance );
    check_sane( what, &scene, eyes, EYES );
}

TEST( test_extreme_materials )
{
    check_material( "exponent 1e6", make_phong( 0.1f, 0.9f, 1e6f ), 10.0f );
    check_material( "exponent 0", make_phong( 0.0f, 1.0f, 0.0f ), 10.0f );
    RfMaterial mirror = make_metal( 1.0f, 1.0f );
    mirror.alpha = RF_MIN_ALPHA;
    check_material( "smallest alpha", mirror, 10.0f );
    RfMaterial glaze = make_plastic( 0.8f, 1.0f );
    glaze.alpha = RF_MIN_ALPHA;
    check_material( "glaze", glaze, 10.0f );
    check_material( "white", make_lambert( 1, 1, 1 ), 10.0f );
    check_material( "black", make_lambert( 0, 0, 0 ), 10.0f );
    check_material( "black Phong", make_phong( 0, 0, 100.0f ), 10.0f );
    check_material( "bright", make_plastic( 0.8f, 0.3f ), 1e9f );
    check_material( "dim", make_plastic( 0.8f, 0.3f ), 1e-9f );
}
