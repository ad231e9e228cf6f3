// Textures alone and in pictures: look-ups against numbers worked out by hand, rendered
// values against closed forms, cut-outs for every kind of ray, and `--group 0` against the
// plain path tracer to the bit.
#include "scene/texture.h"
#include "support/reference_tracer.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

static const RfFactors s_paint = { .base = { 1, 1, 1, 1 }, .roughness = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5 };

static void assert_close( float got, double want, double tolerance )
{
    if ( !( fabs( (double)got - want ) <= tolerance ) )
        fail_msg( "got %.7g, want %.7g", (double)got, want );
}

static RfTextureRef ref_of( RfWrap wrap, bool nearest )
{
    return ( RfTextureRef ){ .wrap = { wrap, wrap }, .nearest = nearest, .transform = { 1, 0, 0, 0, 1, 0 } };
}

static float red_at( const RfTexture* t, const RfTextureRef* ref, float u, float v )
{
    float at[2] = { u, v }, rgba[4];
    rf_look_up( t, ref, at, 0.0f, rgba );
    return rgba[0];
}

// Four grey texels in a row: 0, 51, 102, 255 of 255.
TEST( test_wrap_modes_by_hand )
{
    static const uint8_t bytes[] = { 0, 51, 102, 255 };
    static const struct
    {
        RfWrap wrap;
        float u;
        double nearest, linear;
    } cases[] = {
        { RF_WRAP_REPEAT, 0.375f, 0.2, 0.2 }, { RF_WRAP_REPEAT, 0.5f, 0.4, 0.3 },    { RF_WRAP_REPEAT, 0.0f, 0.0, 0.5 },
        { RF_WRAP_REPEAT, 1.375f, 0.2, 0.2 }, { RF_WRAP_REPEAT, -0.625f, 0.2, 0.2 }, { RF_WRAP_REPEAT, 7.875f, 1.0, 1.0 },
        { RF_WRAP_MIRROR, 1.125f, 1.0, 1.0 }, { RF_WRAP_MIRROR, 1.375f, 0.4, 0.4 },  { RF_WRAP_MIRROR, -0.375f, 0.2, 0.2 },
        { RF_WRAP_MIRROR, 0.0f, 0.0, 0.0 },   { RF_WRAP_MIRROR, 2.375f, 0.2, 0.2 },  { RF_WRAP_CLAMP, -3.0f, 0.0, 0.0 },
        { RF_WRAP_CLAMP, 1.0f, 1.0, 1.0 },    { RF_WRAP_CLAMP, 9.0f, 1.0, 1.0 },     { RF_WRAP_CLAMP, 0.75f, 1.0, 0.7 },
    };
    RfTexture t = make_texture( 4, 1, 1, bytes, false );
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        RfTextureRef nearest = ref_of( cases[i].wrap, true ), linear = ref_of( cases[i].wrap, false );
        assert_close( red_at( &t, &nearest, cases[i].u, 0.5f ), cases[i].nearest, 1e-6 );
        assert_close( red_at( &t, &linear, cases[i].u, 0.5f ), cases[i].linear, 1e-6 );
    }
    // whatever comes, a value comes out
    RfTextureRef ref = ref_of( RF_WRAP_REPEAT, false );
    static const float wild[] = { 1e30f, -1e30f, INFINITY, NAN, 1e9f };
    for ( int i = 0; i < 5; ++i )
        assert_true( red_at( &t, &ref, wild[i], -wild[i] ) >= 0.0f );
    free( t.bytes );
}

// Rows run down: v = 0 is the top. Channels, alpha, the curve of sRGB.
TEST( test_channels_by_hand )
{
    static const uint8_t bytes[] = { 255, 128, 0, 64, 10, 20, 30, 255 };
    float rgba[4], top[2] = { 0.5f, 0.25f }, bottom[2] = { 0.5f, 0.75f };
    RfTextureRef ref = ref_of( RF_WRAP_CLAMP, true );
    RfTexture t = make_texture( 1, 2, 4, bytes, true );
    rf_look_up( &t, &ref, top, 0.0f, rgba );
    assert_close( rgba[0], 1.0, 1e-6 );
    assert_close( rgba[1], 0.2158605, 1e-6 );
    assert_close( rgba[2], 0.0, 0.0 );
    assert_close( rgba[3], 64.0 / 255.0, 1e-6 );
    rf_look_up( &t, &ref, bottom, 0.0f, rgba );
    assert_close( rgba[3], 1.0, 0.0 );
    free( t.bytes );
    t = make_texture( 2, 2, 2, bytes, false );
    rf_look_up( &t, &ref, top, 0.0f, rgba ); // u = 0.5: the right column
    assert_close( rgba[0], 0.0, 0.0 );
    assert_close( rgba[2], 0.0, 0.0 );
    assert_close( rgba[3], 64.0 / 255.0, 1e-6 );
    free( t.bytes );
}

TEST( test_bounds_hold_every_texel )
{
    uint8_t bytes[64 * 64] = { 0 };
    bytes[10 * 64 + 20] = 255;
    RfTexture t = make_texture( 64, 64, 1, bytes, false );
    RfTextureRef ref = ref_of( RF_WRAP_REPEAT, false );
    float far_low[2] = { 0.5f, 0.5f }, far_high[2] = { 0.6f, 0.6f };
    assert_true( rf_texture_bound( &t, &ref, far_low, far_high ) == 0.0f );
    float low[2] = { 2.3f, -0.85f }, high[2] = { 2.33f, -0.8f };
    assert_true( rf_texture_bound( &t, &ref, low, high ) == 1.0f );
    float all_low[2] = { -9.0f, -9.0f }, all_high[2] = { 9.0f, 9.0f };
    assert_true( rf_texture_bound( &t, &ref, all_low, all_high ) == 1.0f );
    free( t.bytes );
}

// A picture of height 2 around the origin that faces +z, seen by an eye that
// sees all of it and no more; u to the right, v down, both 0 to 1.
typedef struct Square
{
    RfScene scene;
    RfEye eye;
} Square;

static Square make_square( RfMaterial material, RfTextured* textured, const uint8_t* bytes, int width, int height, bool srgb )
{
    Square out;
    SceneBuilder b = { 0 };
    uint32_t m = add_material( &b, material );
    float x = (float)width / (float)height;
    add_quad( &b, m, rf_vec3( -x, -1, 0 ), rf_vec3( x, -1, 0 ), rf_vec3( x, 1, 0 ), rf_vec3( -x, 1, 0 ) );
    out.scene = finish_scene( &b );
    out.scene.materials[0].textured = textured;
    static const float uvs[] = { 0, 1, 1, 1, 1, 0, 0, 0 };
    out.scene.triangles.uvs = malloc( sizeof uvs );
    memcpy( out.scene.triangles.uvs, uvs, sizeof uvs );
    out.scene.texture_count = 1;
    out.scene.textures = malloc( sizeof *out.scene.textures );
    out.scene.textures[0] = make_texture( width, height, 4, bytes, srgb );
    out.eye = rf_make_eye( rf_vec3( 0, 0, 2 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 2.0 * atan( 0.5 ), width, height );
    return out;
}

static Rendered render_square( Square* s, int spp, int max_depth, RfTracer** tracer )
{
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = spp;
    settings.max_depth = max_depth;
    settings.memory = (size_t)256 << 20;
    *tracer = make_tracer( &s->scene );
    return render_all( *tracer, &s->eye, 1, &settings );
}

static const uint8_t s_picture[] = { 255, 0,  0,  255, 0,   255, 128, 255, 10, 20, 200, 255,
                                     90,  90, 90, 255, 255, 255, 255, 255, 0,  0,  0,   255 };

// A texel a pixel: the picture comes out as it went in.
TEST( test_emission_by_texel )
{
    RfTextured* t = make_textured( &s_paint );
    t->refs[RF_TEXTURE_EMISSIVE].texture = 0;
    t->refs[RF_TEXTURE_EMISSIVE].nearest = true;
    Square s = make_square( make_light( 10.0f, false ), t, s_picture, 3, 2, true );
    AUTO_TRACER tracer;
    AUTO_BY( free_rendered ) Rendered r = render_square( &s, 4, 1, &tracer );
    const RfTexture* texture = s.scene.textures;
    for ( int i = 0; i < 6; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            assert_close( frame_rgb( &r, 0 )[3 * i + c], ( c == 2 ? 9.0 : 10.0 ) * (double)texture->table[s_picture[4 * i + c]],
                          1e-4 );
    }
    rf_destroy_scene( &s.scene );
}

// Under a sky of radiance 1 a Lambert square shows its albedo.
TEST( test_albedo_by_texel )
{
    RfTextured* t = make_textured( &s_paint );
    t->refs[RF_TEXTURE_BASE].texture = 0;
    t->refs[RF_TEXTURE_BASE].nearest = true;
    t->factors.base[1] = 0.5;
    Square s = make_square( make_lambert( 0, 0, 0 ), t, s_picture, 3, 2, true );
    s.scene.environment.radiance = rf_vec3( 1, 1, 1 );
    AUTO_TRACER tracer;
    AUTO_BY( free_rendered ) Rendered r = render_square( &s, 4096, 4, &tracer );
    for ( int i = 0; i < 6; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            assert_close( frame_rgb( &r, 0 )[3 * i + c],
                          ( c == 1 ? 0.5 : 1.0 ) * (double)s.scene.textures->table[s_picture[4 * i + c]], 0.02 );
    }
    rf_destroy_scene( &s.scene );
}

// Normals: (1, 0, 1)/√2 of the texture leans to the right, (0, 1, 1)/√2 up.
TEST( test_normal_maps_lean_normals )
{
    static const uint8_t bytes[] = { 218, 128, 218, 255, 128, 218, 218, 255 };
    RfTextured* t = make_textured( &s_paint );
    t->refs[RF_TEXTURE_NORMAL].texture = 0;
    t->refs[RF_TEXTURE_NORMAL].nearest = true;
    Square s = make_square( make_lambert( 1, 1, 1 ), t, bytes, 2, 1, false );
    const RfMaterial* m = s.scene.materials;
    RfVec3 z = rf_vec3( 0, 0, 1 );
    // triangle 0 is p q r: (u, v) = (0, 1) + b1 (1, 0) + b2 (1, −1)
    RfVec3 left = rf_normal_at( &s.scene, m, 0, 0.2f, 0.1f, z, z ), right = rf_normal_at( &s.scene, m, 0, 0.6f, 0.3f, z, z );
    assert_close( left.x, sqrt( 0.5 ), 0.01 );
    assert_close( left.y, 0.0, 0.01 );
    assert_close( right.x, 0.0, 0.01 );
    assert_close( right.y, sqrt( 0.5 ), 0.01 );
    // tangents of the file go before those of the coordinates
    float tangents[16];
    for ( int i = 0; i < 4; ++i )
        memcpy( tangents + 4 * i, ( float[] ){ 0, 1, 0, -1 }, 4 * sizeof( float ) );
    s.scene.triangles.tangents = tangents;
    left = rf_normal_at( &s.scene, m, 0, 0.2f, 0.1f, z, z );
    right = rf_normal_at( &s.scene, m, 0, 0.6f, 0.3f, z, z );
    s.scene.triangles.tangents = NULL;
    assert_close( left.y, sqrt( 0.5 ), 0.01 );
    assert_close( right.x, sqrt( 0.5 ), 0.01 ); // −(z × y)
    // never below the surface
    RfVec3 low = rf_normal_at( &s.scene, m, 0, 0.2f, 0.1f, rf_normalize( rf_vec3( 1.0f, 0, 0.2f ) ), z );
    assert_true( rf_dot( low, z ) > 0.0f );
    assert_close( rf_length( low ), 1.0, 1e-5 );
    rf_destroy_scene( &s.scene );
}

static float is_free( const RfTracer* tracer, RfVec3 o, RfVec3 d )
{
    const float* ro[3] = { &o.x, &o.y, &o.z };
    const float* rd[3] = { &d.x, &d.y, &d.z };
    float visible;
    rf_trace_segments( tracer, 1, ro, rd, &visible );
    return visible;
}

static uint32_t nearest( const RfTracer* tracer, RfVec3 o, RfVec3 d )
{
    const float* ro[3] = { &o.x, &o.y, &o.z };
    const float* rd[3] = { &d.x, &d.y, &d.z };
    uint32_t triangle;
    float u, v;
    rf_trace_nearest( tracer, 1, ro, rd, true, &triangle, &u, &v );
    return triangle;
}

// A square whose left half is cut out, before a wall of two triangles that come
// first in the scene: all kinds of rays go through there, and triangles keep
// the scene's numbers.
TEST( test_cut_outs_let_every_ray_through )
{
    static const uint8_t bytes[] = { 255, 255, 255, 100, 255, 255, 255, 200 };
    for ( int order = 0; order < 2; ++order )
    {
        SceneBuilder b = { 0 };
        uint32_t wall = add_material( &b, make_lambert( 1, 1, 1 ) ), cut = add_material( &b, make_lambert( 1, 1, 1 ) );
        for ( int k = 0; k < 2; ++k )
        {
            float z = k == order ? -1.0f : 0.0f; // the wall lies behind
            add_quad( &b, k == order ? wall : cut, rf_vec3( -1, -1, z ), rf_vec3( 1, -1, z ), rf_vec3( 1, 1, z ),
                      rf_vec3( -1, 1, z ) );
        }
        AUTO_SCENE scene = finish_scene( &b );
        static const float uvs[] = { 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0 };
        scene.triangles.uvs = malloc( sizeof uvs );
        memcpy( scene.triangles.uvs, uvs, sizeof uvs );
        scene.textures = malloc( sizeof *scene.textures );
        scene.textures[0] = make_texture( 2, 1, 4, bytes, true );
        scene.texture_count = 1;
        RfTextured* t = scene.materials[cut].textured = make_textured( &s_paint );
        t->masked = true;
        t->alpha_cutoff = 0.5f;
        t->refs[RF_TEXTURE_BASE].texture = 0;
        t->refs[RF_TEXTURE_BASE].nearest = true;
        AUTO_TRACER tracer = make_tracer( &scene );
        RfVec3 forward = rf_vec3( 0, 0, -1 );
        uint32_t first_wall = order == 0 ? 0 : 2, first_cut = 2 - first_wall;
        assert_int_equal( nearest( tracer, rf_vec3( -0.5f, 0.7f, 1 ), forward ), first_wall + 1 );
        assert_int_equal( nearest( tracer, rf_vec3( 0.7f, -0.5f, 1 ), forward ), first_cut );
        assert_int_equal( nearest( tracer, rf_vec3( 0.5f, 0.7f, 1 ), forward ), first_cut + 1 );
        assert_int_equal( nearest( tracer, rf_vec3( 1.5f, 0.7f, 1 ), forward ), RF_MISS );
        assert_true( is_free( tracer, rf_vec3( -0.5f, 0.2f, 1 ), rf_scale( forward, 1.5f ) ) );
        assert_false( is_free( tracer, rf_vec3( -0.5f, 0.2f, 1 ), rf_scale( forward, 2.5f ) ) );
        assert_false( is_free( tracer, rf_vec3( 0.5f, 0.2f, 1 ), rf_scale( forward, 1.5f ) ) );
        float x[2] = { -0.4f, 0.4f }, y[2] = { 0, 0 }, z[2] = { -0.5f, -0.5f }, weight[2] = { 1, 1 };
        const float* points[3] = { x, y, z };
        assert_int_equal( rf_trace_from_origin( tracer, rf_vec3( 0, 0, 1 ), 2, points, weight ), 2 );
        assert_true( weight[0] == 1.0f && weight[1] == 0.0f );
    }
}

// A light whose texture is black but for one texel: it is picked, the triangle
// without the texel is no light, and sampling finds the radiance there.
TEST( test_one_bright_texel_is_sampled )
{
    uint8_t bytes[32 * 32 * 4] = { 0 };
    memset( bytes + 4 * ( 2 * 32 + 3 ), 255, 4 ); // near the upper left corner, in triangle 1
    RfTextured* t = make_textured( &s_paint );
    t->refs[RF_TEXTURE_EMISSIVE].texture = 0;
    t->refs[RF_TEXTURE_EMISSIVE].nearest = true;
    Square s = make_square( make_light( 10.0f, true ), t, bytes, 32, 32, true );
    AUTO_TRACER tracer = make_tracer( &s.scene );
    const RfLights* lights = rf_tracer_lights( tracer );
    assert_true( lights->count >= 1 );
    uint32_t k = lights->of_triangle[1];
    assert_true( k != RF_NO_LIGHT && lights->light[k].pdf_area > 0.0f );
    double sum = 0.0;
    int n = 400;
    for ( int i = 0; i < n; ++i )
    {
        for ( int j = 0; i + j < n; ++j )
        {
            float b1 = ( (float)i + 0.33f ) / (float)n, b2 = ( (float)j + 0.33f ) / (float)n;
            sum += (double)rf_light_radiance( &s.scene, lights->light + k, b1, b2 ).x;
        }
    }
    // one texel of 1024 on half the square: 2/1024 of radiance 10
    assert_close( (float)( sum / ( 0.5 * n * n ) ), 10.0 * 2.0 / 1024.0, 2e-3 );
    rf_destroy_scene( &s.scene );
}

static void check_plain( RfScene scene )
{
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[3];
    orbit_eyes( eyes, 3, 4.0f, 39, 34 );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = 5;
    settings.light_samples = 2;
    settings.memory = (size_t)256 << 20;
    AUTO_BY( free_rendered ) Rendered r = render_all( tracer, eyes, 3, &settings );
    AUTO_FREE float* reference = malloc( 3 * r.pixels * sizeof( float ) );
    for ( int k = 0; k < 3; ++k )
    {
        ReferenceSettings plain = reference_settings_of( &settings, k );
        reference_image( tracer, eyes + k, &plain, reference );
        assert_memory_equal( frame_rgb( &r, k ), reference, 3 * r.pixels * sizeof( float ) );
    }
    rf_destroy_scene( &scene );
}

TEST( test_group_0_is_a_plain_path_tracer )
{
    check_plain( make_textured_room() );
    check_plain( make_blended_room() );
    check_plain( make_varied_room() );
}

// Panes of alpha 0.5 and 0.25, one behind the other.
static RfScene make_panes( void )
{
    SceneBuilder b = { 0 };
    for ( int k = 0; k < 2; ++k )
    {
        RfMaterial m = make_lambert( 0, 0, 0 );
        RfFactors factors = {
            .base = { 0, 0, 0, k == 0 ? 0.5 : 0.25 }, .roughness = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5
        };
        m.textured = make_textured( &factors );
        m.textured->blended = true;
        uint32_t index = add_material( &b, m );
        float z = -(float)k;
        add_quad( &b, index, rf_vec3( -1, -1, z ), rf_vec3( 1, -1, z ), rf_vec3( 1, 1, z ), rf_vec3( -1, 1, z ) );
    }
    return finish_scene( &b );
}

TEST( test_blended_panes_by_closed_form )
{
    AUTO_SCENE scene = make_panes();
    scene.environment.radiance = rf_vec3( 2, 2, 2 );
    AUTO_TRACER tracer = make_tracer( &scene );
    assert_true( rf_tracer_is_blended( tracer ) );
    assert_close( is_free( tracer, rf_vec3( 0.1f, 0.2f, 1 ), rf_vec3( 0, 0, -1.5f ) ), 0.5, 1e-6 );
    assert_close( is_free( tracer, rf_vec3( 0.1f, 0.2f, 1 ), rf_vec3( 0, 0, -3 ) ), 0.375, 1e-6 );
    assert_close( is_free( tracer, rf_vec3( 3, 0.2f, 1 ), rf_vec3( 0, 0, -3 ) ), 1.0, 0 );
    RfVec3 origin = rf_vec3( 0, 0, 1 );
    float x[2] = { 0.1f, 0.1f }, y[2] = { 0, 0 }, z[2] = { -0.5f, -2 }, weight[2] = { 4, 8 };
    const float* points[3] = { x, y, z };
    assert_int_equal( rf_trace_from_origin( tracer, origin, 2, points, weight ), 2 );
    assert_close( weight[0], 2.0, 1e-6 );
    assert_close( weight[1], 3.0, 1e-6 );
    // black panes in front of the sky: 3/8 of it is seen
    RfEye eyes[3];
    for ( int i = 0; i < 3; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0.05f * (float)i, 0, 2 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.4, 24, 24 );
    for ( int group = 0; group <= 1; ++group )
    {
        RfRenderSettings settings = plain_settings();
        settings.group = group;
        settings.spp = 48;
        settings.memory = (size_t)256 << 20;
        AUTO_BY( free_rendered ) Rendered r = render_all( tracer, eyes, 3, &settings );
        double sum = 0.0, weights = 0.0, count = 3.0 * (double)r.pixels;
        for ( size_t i = 0; i < 3 * r.pixels; ++i )
        {
            sum += (double)r.rgb[3 * i] / count;
            weights += (double)r.weight[i] / count;
        }
        assert_close( (float)sum, 0.75, 0.02 ); // five standard errors and more: 2 √(15/64 / 83000)
        assert_close( (float)weights, 1.0, 0.01 );
    }
}

// Of colours, not of normals and the like; what Rec. 709 cannot hold is clipped.
TEST( test_primaries_of_an_image )
{
    for ( int colour = 0; colour < 2; ++colour )
    {
        RfPixels pixels = {
            .width = 1, .height = 1, .channels = 3, .type = RF_PIXELS_FLOAT, .data = malloc( 3 * sizeof( float ) )
        };
        memcpy( pixels.data, ( float[3] ){ 1.0f, 0.0f, 0.0f }, 3 * sizeof( float ) );
        assert_true(
            rf_convert_between( rf_chromaticities_of( RF_ACESCG ), rf_chromaticities_of( RF_REC709 ), &pixels.conversion ) );
        RfTexture t;
        assert_int_equal( rf_make_texture( "t", &pixels, colour == 1, &t, NULL ), RF_OK );
        assert_close( t.floats[0], colour == 1 ? 1.70505 : 1.0, 1e-4 );
        assert_true( t.floats[1] == 0.0f && t.floats[2] == 0.0f );
        assert_close( (float)t.outside, colour == 1 ? 0.15426 / ( 1.70505 + 0.15426 ) : 0.0, 1e-4 );
        rf_destroy_texture( &t );
    }
}

// By the area that each pixel covers, so that the last level is the mean of all, also of sizes that are no powers of two.
TEST( test_mip_levels_are_means )
{
    enum
    {
        WIDTH = 13,
        HEIGHT = 5
    };
    float* floats = malloc( 3 * WIDTH * HEIGHT * sizeof *floats );
    uint8_t bytes[4 * WIDTH * HEIGHT];
    double mean = 0.0, of_bytes = 0.0;
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            floats[3 * i + c] = (float)( ( i * 37 + c ) % 101 );
        for ( int c = 0; c < 4; ++c )
            bytes[4 * i + c] = (uint8_t)( ( i * 53 + 19 * c ) % 256 );
        mean += (double)floats[3 * i] / ( WIDTH * HEIGHT );
        of_bytes += (double)rf_srgb_to_linear( (float)bytes[4 * i] / 255.0f ) / ( WIDTH * HEIGHT );
    }
    RfTexture of[2] = { { .width = WIDTH, .height = HEIGHT, .channels = 3, .floats = floats },
                        make_texture( WIDTH, HEIGHT, 4, bytes, true ) };
    RfTextureRef linear = ref_of( RF_WRAP_REPEAT, false ), nearest = ref_of( RF_WRAP_REPEAT, true );
    float at[2] = { 0.3f, 0.7f }, rgba[4], low[4], high[4];
    for ( int k = 0; k < 2; ++k )
    {
        rf_look_up( of + k, &linear, at, 3.0f, low ); // without levels: the image
        rf_look_up( of + k, &linear, at, 0.0f, high );
        assert_true( low[0] == high[0] );
        rf_make_mip_levels( of + k );
        assert_int_equal( of[k].level_count, 4 ); // 13x5, 6x2, 3x1, 1x1
        rf_look_up( of + k, &linear, at, 9.0f, rgba );
        assert_close( rgba[0], k == 0 ? mean : of_bytes, k == 0 ? 1e-4 : 0.01 );
        rf_look_up( of + k, &linear, at, 1.0f, low );
        rf_look_up( of + k, &linear, at, 2.0f, high );
        rf_look_up( of + k, &linear, at, 1.25f, rgba );
        assert_close( rgba[1], 0.75 * (double)low[1] + 0.25 * (double)high[1], 1e-4 );
        rf_look_up( of + k, &nearest, at, 2.0f, rgba );
        rf_look_up( of + k, &nearest, at, 0.0f, low );
        assert_true( rgba[0] == low[0] );
    }
    static const uint8_t grey[4 * 2] = { 0, 255, 10, 20, 0, 0, 30, 40 };
    RfTexture even = make_texture( 4, 2, 1, grey, false );
    rf_make_mip_levels( &even );
    assert_int_equal( even.level_count, 3 );
    assert_true( even.table[( (uint8_t*)even.levels )[0]] == even.table[64] ); // 63.75
    assert_true( even.table[( (uint8_t*)even.levels )[1]] == even.table[25] );
    rf_destroy_texture( &even );
    assert_close( rf_mip_level( of, 16.0 / ( WIDTH * HEIGHT ) ), 2.0, 1e-6 );
    assert_true( rf_mip_level( of, 0.0 ) == 0.0f );
    rf_destroy_texture( of );
    rf_destroy_texture( of + 1 );
}

// The root mean square error of the pixels of a frame whose true values are means of texels.
static double error_of_means( const Square* s, const Rendered* r, int across )
{
    const RfTexture* t = s->scene.textures;
    int texels = t->width / across;
    double sum = 0.0;
    for ( int p = 0; p < across * across; ++p )
    {
        double mean = 0.0;
        for ( int i = 0; i < texels * texels; ++i )
        {
            int x = p % across * texels + i % texels, y = p / across * texels + i / texels;
            mean += (double)t->table[t->bytes[4 * ( y * t->width + x )]] / ( texels * texels );
        }
        double off = (double)frame_rgb( r, 0 )[3 * p] - mean;
        sum += off * off / ( across * across );
    }
    return sqrt( sum );
}

// Pixels of 16 texels across show their mean, with less noise by mip levels; in groups with cameras nearer and further away too.
TEST( test_far_colours_by_mip_levels )
{
    static uint8_t bytes[4 * 64 * 64];
    uint32_t word = 1;
    for ( int i = 0; i < 64 * 64; ++i )
    {
        word = word * 1664525u + 1013904223u;
        memset( bytes + 4 * i, ( word >> 30 & 1 ) != 0 ? 255 : 0, 3 );
        bytes[4 * i + 3] = 255;
    }
    for ( int group = 0; group <= 1; ++group )
    {
        double error[2];
        for ( int levels = 0; levels < 2; ++levels )
        {
            RfTextured* t = make_textured( &s_paint );
            t->refs[RF_TEXTURE_EMISSIVE].texture = 0;
            Square s = make_square( make_light( 1.0f, false ), t, bytes, 64, 64, true );
            if ( levels == 1 )
                rf_make_mip_levels( s.scene.textures );
            static const float distances[] = { 2.0f, 1.0f, 4.0f };
            RfEye eyes[3];
            for ( int i = 0; i < 3; ++i )
                eyes[i] = rf_make_eye( rf_vec3( 0, 0, distances[i] ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 2.0 * atan( 0.5 ),
                                       4, 4 );
            RfRenderSettings settings = plain_settings();
            settings.group = group;
            settings.spp = 64;
            settings.memory = (size_t)256 << 20;
            AUTO_TRACER tracer = make_tracer( &s.scene );
            AUTO_BY( free_rendered ) Rendered r = render_all( tracer, eyes, group == 0 ? 1 : 3, &settings );
            error[levels] = error_of_means( &s, &r, 4 );
            rf_destroy_scene( &s.scene );
        }
        assert_true( error[0] > 0.02 && error[0] < 0.1 ); // 1/2 √64: nothing but noise
        if ( !( error[1] < 0.5 * error[0] ) )
            fail_msg( "an error of %.4g, without mip levels %.4g", error[1], error[0] );
    }
}
