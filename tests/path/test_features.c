// Albedo and normal for denoisers against closed forms: behind mirrors and panes, through bodies, in an even light; and that they
// have no noise where the picture chooses between reflection and transmission by chance.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 24
#define HEIGHT 16
#define PIXELS ( WIDTH * HEIGHT )
#define BOTH ( RF_AOV_BIT( RF_AOV_DENOISE_ALBEDO ) | RF_AOV_BIT( RF_AOV_DENOISE_NORMAL ) )

static RfRenderSettings settings_of( int spp )
{
    RfRenderSettings settings = small_settings( 0, spp );
    settings.aovs = BOTH | RF_AOV_BIT( RF_AOV_ALBEDO );
    return settings;
}

// The stage is to be closed.
static const RfFrameResult* render( Stage* stage, RfScene scene, RfEye eye, RfRenderSettings settings )
{
    open_stage_before( stage, scene, &eye, 1 );
    return render_one( stage, 0, &settings );
}

// Along −z.
static RfEye look( double field_of_view )
{
    return rf_make_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), field_of_view, WIDTH, HEIGHT );
}

// The quad x = at or z = at, 40 m wide, that faces both ways.
static void add_wall( SceneBuilder* b, RfMaterial material, bool is_x, float at )
{
    uint32_t m = add_material( b, material );
    RfVec3 along = is_x ? rf_vec3( 0, 0, 20 ) : rf_vec3( 20, 0, 0 ), up = rf_vec3( 0, 20, 0 );
    RfVec3 middle = is_x ? rf_vec3( at, 0, 0 ) : rf_vec3( 0, 0, at ), low = rf_sub( middle, up ), high = rf_add( middle, up );
    add_quad( b, m, rf_sub( low, along ), rf_add( low, along ), rf_add( high, along ), rf_sub( high, along ) );
}

static void assert_pixel( const float* got, double r, double g, double b, double tolerance )
{
    const double wanted[3] = { r, g, b };
    for ( int c = 0; c < 3; ++c )
    {
        if ( !( fabs( (double)got[c] - wanted[c] ) <= tolerance ) )
            fail_msg( "channel %d: %.6g instead of %.6g", c, (double)got[c], wanted[c] );
    }
}

// The unit direction through the middle of a pixel of a camera that looks along −z.
static RfVec3 direction_of( const RfEye* eye, int i )
{
    float x = ( (float)( i % WIDTH ) + 0.5f - 0.5f * WIDTH ) / eye->focal;
    float y = ( 0.5f * HEIGHT - (float)( i / WIDTH ) - 0.5f ) / eye->focal;
    return rf_normalize( rf_vec3( x, y, -1.0f ) );
}

// By a mirror and by a metal as smooth: its reflectance times the wall behind the camera, whose normal it shows; with panes before
// it, several frames and another filter it is the same.
TEST( test_mirrors_show_what_they_reflect )
{
    RfMaterial metal = make_metal( 0.9f, 0.05f );
    for ( int k = 0; k < 4; ++k )
    {
        SceneBuilder b = { 0 };
        add_wall( &b, k == 1 ? metal : make_mirror( 0.9f ), false, -2.0f );
        add_wall( &b, make_lambert( 0.2f, 0.4f, 0.6f ), false, 3.0f );
        RfRenderSettings settings = settings_of( 4 );
        settings.filter = k == 2 ? RF_FILTER_BLACKMAN_HARRIS : RF_FILTER_BOX;
        RfScene scene = finish_scene( &b );
        if ( k == 3 ) // where no chains are followed
            assert_int_equal( rf_choose_effects( &scene, 0, RF_EFFECT_BIT( RF_EFFECT_CHAINS ), NULL ), RF_OK );
        Stage stage;
        const RfFrameResult* picture = render( &stage, scene, look( 0.5 ), settings );
        for ( int i = 0; i < PIXELS; ++i )
        {
            const double f0[3] = { 0.9, k == 1 ? 0.81 : 0.9, k == 1 ? 0.72 : 0.81 };
            assert_pixel( picture->aovs[RF_AOV_DENOISE_ALBEDO] + 3 * i, f0[0] * 0.2, f0[1] * 0.4, f0[2] * 0.6, 2e-3 );
            assert_pixel( picture->aovs[RF_AOV_DENOISE_NORMAL] + 3 * i, 0, 0, -1, 1e-5 );
            assert_pixel( picture->aovs[RF_AOV_ALBEDO] + 3 * i, f0[0], f0[1], f0[2], 2e-3 ); // its own
        }
        close_stage( &stage );
    }
}

// A pane at 60 degrees between a dark wall that it reflects and a bright one behind it: both, blended by Fresnel's equations, in
// every pass alike. The picture's own choice would have a standard deviation of 0.2 per sample.
TEST( test_panes_blend_what_they_show )
{
    RfMaterial tinted = make_glass( 1.5f, 0.0f, true );
    tinted.tint = rf_vec3( 1.0f, 0.5f, 0.25f );
    RfVec3 n = rf_vec3( 0.8660254f, 0, 0.5f ), along = rf_vec3( -0.5f, 0, 0.8660254f ), up = rf_vec3( 0, 9, 0 );
    SceneBuilder b = { 0 };
    uint32_t pane = add_material( &b, tinted );
    RfVec3 middle = rf_vec3( 0, 0, -3 ), left = rf_madd( middle, along, -9 ), right = rf_madd( middle, along, 9 );
    add_quad( &b, pane, rf_sub( left, up ), rf_sub( right, up ), rf_add( right, up ), rf_add( left, up ) );
    add_wall( &b, make_lambert( 0.2f, 0.2f, 0.2f ), true, 8.0f );
    add_wall( &b, make_lambert( 0.8f, 0.8f, 0.8f ), false, -12.0f );
    Stage stage;
    RfEye eye = look( 0.1 );
    RfRenderSettings settings = settings_of( 16 );
    settings.seed = 1;
    const RfFrameResult* picture = render( &stage, finish_scene( &b ), eye, settings );
    settings.seed = 2;
    const float* other = render_one( &stage, 0, &settings )->aovs[RF_AOV_DENOISE_ALBEDO];
    double square = 0.0;
    for ( int i = 0; i < PIXELS; ++i )
    {
        double f = fresnel( -(double)rf_dot( direction_of( &eye, i ), n ), 1.5 ), t = 1.0 - f;
        const float* albedo = picture->aovs[RF_AOV_DENOISE_ALBEDO] + 3 * i;
        assert_pixel( albedo, 0.2 * f + 0.8 * t, 0.2 * f + 0.4 * t, 0.2 * f + 0.2 * t, 4e-3 );
        double through = t * ( 1.0 + 0.5 + 0.25 ) / 3.0, share = f / ( f + through ); // of the normal
        assert_pixel( picture->aovs[RF_AOV_DENOISE_NORMAL] + 3 * i, -share, 0, 1.0 - share, 4e-3 );
        double d = (double)( albedo[0] - other[3 * i] );
        square += d * d / 2.0 / PIXELS;
    }
    print_message( "deviation of the albedo behind a pane at 16 spp: %.5f\n", sqrt( square ) );
    assert_true( sqrt( square ) < 1e-3 );
    close_stage( &stage );
}

// Bodies of glass, mirrors and panes that lose nothing show an even sky as it is.
TEST( test_an_even_sky_is_one )
{
    SceneBuilder b = { 0 };
    uint32_t glass = add_material( &b, make_glass( 1.5f, 0.0f, false ) ),
             pane = add_material( &b, make_glass( 1.4f, 0.0f, true ) );
    RfMaterial mirror = make_mirror( 1.0f );
    mirror.specular = rf_vec3( 1, 1, 1 );
    uint32_t perfect = add_material( &b, mirror );
    add_sphere( &b, glass, rf_vec3( 0, 0, -5 ), 1.0f, 16 );
    add_box( &b, glass, rf_vec3( -3, -1, -6 ), rf_vec3( -1.2f, 1, -5 ), false );
    add_sphere( &b, perfect, rf_vec3( 2.2f, 0, -5 ), 1.0f, 16 );
    add_quad( &b, pane, rf_vec3( -2, -2, -3 ), rf_vec3( 1, -2, -3 ), rf_vec3( 1, 2, -3 ), rf_vec3( -2, 2, -3 ) );
    RfScene scene = finish_scene( &b );
    scene.environment.radiance = rf_vec3( 1, 1, 1 );
    Stage stage;
    const RfFrameResult* picture = render( &stage, scene, look( 0.5 ), settings_of( 4 ) );
    for ( int i = 0; i < PIXELS; ++i )
        assert_pixel( picture->aovs[RF_AOV_DENOISE_ALBEDO] + 3 * i, 1, 1, 1, 1e-5 );
    close_stage( &stage );
}

// The sky is at most 1, whatever it shines with, and 0 where alpha leaves it out of the picture; behind glass it stays, and what
// glass absorbs it does.
TEST( test_the_sky_and_what_absorbs_it )
{
    for ( int k = 0; k < 3; ++k )
    {
        SceneBuilder b = { 0 };
        RfMaterial body = make_glass( 1.5f, 0.0f, false );
        body.absorption = rf_vec3( 0.0f, 0.5f, 2.0f );
        uint32_t glass = add_material( &b, body );
        if ( k != 0 )
            add_box( &b, glass, rf_vec3( -9, -9, -3 ), rf_vec3( 9, 9, -2 ), false );
        else
            add_box( &b, glass, rf_vec3( -9, -9, 3 ), rf_vec3( 9, 9, 4 ), false ); // behind the camera
        RfScene scene = finish_scene( &b );
        scene.environment.radiance = k == 2 ? rf_vec3( 0.5f, 0.5f, 0.5f ) : rf_vec3( 9, 9, 9 );
        RfRenderSettings settings = settings_of( 4 );
        settings.aovs |= k == 2 ? RF_AOV_BIT( RF_AOV_ALPHA ) : 0;
        RfEye eye = look( 0.5 );
        Stage stage;
        const RfFrameResult* picture = render( &stage, scene, eye, settings );
        for ( int i = 0; i < PIXELS; ++i )
        {
            // from the outside: what goes through twice is counted once, so the second surface loses nothing
            double cos_o = -(double)direction_of( &eye, i ).z, way = 1.0 / sqrt( 1.0 - ( 1.0 - cos_o * cos_o ) / 2.25 );
            double f = fresnel( cos_o, 1.5 ), t = ( 1.0 - f );
            const float* albedo = picture->aovs[RF_AOV_DENOISE_ALBEDO] + 3 * i;
            if ( k == 2 )
                assert_pixel( albedo, 0.5, 0.5 * ( f + t * exp( -0.5 * way ) ), 0.5 * ( f + t * exp( -2.0 * way ) ), 2e-3 );
            else
                assert_pixel( albedo, 1, 1, 1, 1e-6 );
            assert_pixel( picture->aovs[RF_AOV_DENOISE_NORMAL] + 3 * i, 0, 0, 0, 1e-6 );
        }
        close_stage( &stage );
    }
    // without glass, with alpha: nothing
    SceneBuilder b = { 0 };
    add_wall( &b, make_lambert( 0.5f, 0.5f, 0.5f ), false, 3.0f );
    RfScene scene = finish_scene( &b );
    scene.environment.radiance = rf_vec3( 1, 1, 1 );
    RfRenderSettings settings = settings_of( 2 );
    settings.aovs |= RF_AOV_BIT( RF_AOV_ALPHA );
    Stage stage;
    const RfFrameResult* picture = render( &stage, scene, look( 0.5 ), settings );
    for ( int i = 0; i < PIXELS; ++i )
        assert_pixel( picture->aovs[RF_AOV_DENOISE_ALBEDO] + 3 * i, 0, 0, 0, 0 );
    close_stage( &stage );
}

// What is no mirror has its own: rough glass, coats over a base; and lamps what they emit besides.
TEST( test_other_surfaces_have_their_own )
{
    RfMaterial lamp = make_lambert( 0.5f, 0.5f, 0.5f ), coat = make_plastic( 0.6f, 0.05f );
    lamp.emission = rf_vec3( 0.25f, 0.5f, 4.0f );
    lamp.double_sided = true;
    RfMaterial materials[] = { make_glass( 1.5f, 0.3f, false ), coat, make_metal( 0.7f, 0.3f ), lamp };
    for ( int k = 0; k < 4; ++k )
    {
        SceneBuilder b = { 0 };
        add_wall( &b, materials[k], false, -2.0f );
        add_wall( &b, make_lambert( 0, 0, 0 ), false, 3.0f );
        Stage stage;
        const RfFrameResult* picture = render( &stage, finish_scene( &b ), look( 0.5 ), settings_of( 2 ) );
        for ( int i = 0; i < PIXELS; ++i )
        {
            const float* own = picture->aovs[RF_AOV_ALBEDO] + 3 * i;
            double more[3] = { k == 3 ? 0.25 : 0.0, k == 3 ? 0.5 : 0.0, k == 3 ? 0.5 : 0.0 };
            assert_pixel( picture->aovs[RF_AOV_DENOISE_ALBEDO] + 3 * i, (double)own[0] + more[0], (double)own[1] + more[1],
                          (double)own[2] + more[2], 1e-6 );
            assert_pixel( picture->aovs[RF_AOV_DENOISE_NORMAL] + 3 * i, 0, 0, 1, 1e-6 );
        }
        close_stage( &stage );
    }
}

// Two mirrors that face each other have no end, and yet a value.
TEST( test_mirrors_without_end )
{
    SceneBuilder b = { 0 };
    RfMaterial mirror = make_mirror( 1.0f );
    add_wall( &b, mirror, false, -2.0f );
    add_wall( &b, mirror, false, 3.0f );
    Stage stage;
    const RfFrameResult* picture = render( &stage, finish_scene( &b ), look( 0.5 ), settings_of( 2 ) );
    int middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
    const float* albedo = picture->aovs[RF_AOV_DENOISE_ALBEDO] + 3 * middle;
    assert_true( albedo[0] == 1.0f && albedo[2] > 0.0f && albedo[2] < 0.5f );
    assert_true( fabsf( fabsf( picture->aovs[RF_AOV_DENOISE_NORMAL][3 * middle + 2] ) - 1.0f ) < 1e-5f );
    close_stage( &stage );
}
