// Hard cases of materials.
#include "hard/hard.h"
#include "scene/textured.h"

#include <math.h>

static void lambert_white( HardScene* h ) { hard_stage( h, make_lambert( 1, 1, 1 ) ); }
static void black( HardScene* h ) { hard_stage( h, make_phong( 0, 0, 100.0f ) ); }
static void phong_0( HardScene* h ) { hard_stage( h, make_phong( 0.0f, 0.9f, 0.0f ) ); }
static void phong_100( HardScene* h ) { hard_stage( h, make_phong( 0.2f, 0.6f, 100.0f ) ); }
static void ggx_1( HardScene* h ) { hard_stage( h, make_metal( 0.9f, 1.0f ) ); }

// A floor of this material under a sky of radiance 1, seen by eyes in directions a few 1e-4 rad apart.
static void floor_under_sky( HardScene* h, RfMaterial m, RfVec3 forward, double value, double within )
{
    SceneBuilder b = { 0 };
    add_quad( &b, add_material( &b, m ), rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ), rf_vec3( -2, 0, -2 ) );
    h->scene = finish_scene( &b );
    h->scene.environment.radiance = rf_vec3( 1, 1, 1 );
    RfVec3 f = rf_normalize( forward );
    hard_eyes( h, rf_scale( f, -1.0f ), rf_vec3( 3e-4f, 0, 0 ), f, 0.02 / ( 1.0 + (double)fabsf( f.z / f.y ) ) );
    h->value = value;
    h->within = within;
}

// Seen straight from above a Phong lobe of reflectance ks reflects ks, whatever its exponent.
static void phong_1e4( HardScene* h )
{
    floor_under_sky( h, make_phong( 0.0f, 0.9f, 1e4f ), rf_vec3( 0, -1, 1e-3f ), (double)0.9f, 5e-4 );
}
static void phong_1e7( HardScene* h )
{
    floor_under_sky( h, make_phong( 0.0f, 0.9f, 1e7f ), rf_vec3( 0, -1, 1e-3f ), (double)0.9f, 5e-4 );
}

// White metal of roughness 0, as files have it, reflects all, but for what Smith's shadowing takes.
static RfMaterial white_metal( void )
{
    RfFactors factors = { .base = { 1, 1, 1, 1 }, .metallic = 1, .roughness = 0, .specular = 1, .ior = 1.5 };
    RfMaterial m = make_metal( 1.0f, 1.0f );
    rf_derive_lobes( &factors, &m );
    return m;
}

static void ggx_0( HardScene* h ) { floor_under_sky( h, white_metal(), rf_vec3( 0, -1, -0.3f ), 1.0, 1e-3 ); }

// Sharp metal beside rough things, lit by a lamp.
static void ggx_sharp_stage( HardScene* h ) { hard_stage( h, white_metal() ); }

static RfMaterial perfect_mirror( void )
{
    RfMaterial m = make_mirror( 1.0f );
    m.specular = rf_vec3( 1, 1, 1 );
    return m;
}

static void mirror( HardScene* h ) { floor_under_sky( h, perfect_mirror(), rf_vec3( 0, -1, -0.3f ), 1.0, 1e-6 ); }
static void mirror_grazing( HardScene* h ) { floor_under_sky( h, perfect_mirror(), rf_vec3( 0, -1e-3f, -1 ), 1.0, 1e-4 ); }
static void mirror_edge_on( HardScene* h ) { floor_under_sky( h, perfect_mirror(), rf_vec3( 0, -1e-5f, -1 ), 1.0, 1e-4 ); }

// The stage with a sheet of mirror before the eyes, looked at along it: chains, and images of eyes.
static void mirror_stage( HardScene* h )
{
    hard_stage( h, hard_glossy() );
    SceneBuilder b = hard_reopen( &h->scene );
    uint32_t m = add_material( &b, make_mirror( 0.9f ) );
    add_quad( &b, m, rf_vec3( -0.2f, 0.7f, 2.0f ), rf_vec3( 0.6f, 0.7f, 2.0f ), rf_vec3( 0.6f, 0.7f, 1.4f ),
              rf_vec3( -0.2f, 0.7f, 1.4f ) );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0.2f, 0.703f, 2.2f ), rf_vec3( 0.01f, 2e-4f, 0 ), rf_vec3( 0, 0, -1 ), 20.0 );
}

// A box of glass in the sky: whatever it refracts and reflects, it is as bright as the sky.
static void glass_in_the_sky( HardScene* h, RfMaterial m )
{
    SceneBuilder b = { 0 };
    add_box( &b, add_material( &b, m ), rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), false );
    h->scene = finish_scene( &b );
    h->scene.environment.radiance = rf_vec3( 1, 1, 1 );
    hard_eyes( h, rf_vec3( 0.2f, 0.5f, 3.0f ), rf_vec3( 0.1f, 0, 0 ), rf_vec3( -0.1f, -0.1f, -1 ), 30.0 );
    h->max_depth = 60;
    h->value = 1.0;
    h->within = 1e-4;
}

// Along a body of index 1 onto a black wall behind it. What it would reflect is a light.
static void ior_1( HardScene* h )
{
    SceneBuilder b = { 0 };
    uint32_t glass = add_material( &b, make_glass( 1.0f, 0.0f, false ) ), black = add_material( &b, make_lambert( 0, 0, 0 ) );
    uint32_t light = add_material( &b, make_light( 1e6f, true ) );
    add_box( &b, glass, rf_vec3( -1, -1, -1 ), rf_vec3( 1, 0, 1 ), false );
    add_quad( &b, black, rf_vec3( -9, -9, -2 ), rf_vec3( 9, -9, -2 ), rf_vec3( 9, 0, -2 ), rf_vec3( -9, 0, -2 ) );
    add_quad( &b, light, rf_vec3( -9, 1e-4f, -2 ), rf_vec3( 9, 1e-4f, -2 ), rf_vec3( 9, 9, -2 ), rf_vec3( -9, 9, -2 ) );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0, 5e-4f, 0.5f ), rf_vec3( 0.01f, 1e-5f, 0 ), rf_vec3( 0, -1e-3f, -1 ), 0.02 );
    h->max_depth = 8;
    h->sharp = true;
}
static void ior_1_black( HardScene* h )
{
    RfMaterial m = make_glass( 1.0f, 0.0f, true );
    m.tint = rf_vec3( 0, 0, 0 );
    glass_in_the_sky( h, m );
    h->max_depth = 4;
}

static void ior_almost_1( HardScene* h ) { glass_in_the_sky( h, make_glass( 1.0001f, 0.0f, false ) ); }

// Of an index of 10 a body reflects inside most of what it gets; a sheet of it does not.
static void ior_10( HardScene* h ) { glass_in_the_sky( h, make_glass( 10.0f, 0.0f, true ) ); }

static void ior_10_body( HardScene* h )
{
    glass_in_the_sky( h, make_glass( 10.0f, 0.0f, false ) );
    h->max_depth = 4;
}

static void absorption_small( HardScene* h )
{
    RfMaterial m = make_glass( 1.1f, 0.0f, false );
    m.absorption = rf_vec3( 1e-9f, 1e-9f, 1e-9f );
    glass_in_the_sky( h, m );
    h->within = 5e-3;
}

static void absorption_large( HardScene* h )
{
    RfMaterial m = make_glass( 1.5f, 0.0f, false );
    m.absorption = rf_vec3( 1e9f, 1e9f, 1e9f );
    glass_in_the_sky( h, m );
    h->max_depth = 4;
}

static void rough_glass( HardScene* h )
{
    glass_in_the_sky( h, make_glass( 1.5f, 1.0f, false ) );
    h->max_depth = 4;
}

static void rough_glass_grazing( HardScene* h )
{
    RfMaterial m = make_glass( 1.5f, 0.02f, false );
    m.diffuse = rf_vec3( 0.2f, 0.2f, 0.2f );
    glass_in_the_sky( h, m );
    hard_eyes( h, rf_vec3( 0, 1.0002f, 1.5f ), rf_vec3( 1e-3f, 1e-4f, 0 ), rf_vec3( 0, -2e-3f, -1 ), 0.5 );
    h->max_depth = 4;
}

static void clear_coat( HardScene* h )
{
    RfMaterial m = make_plastic( 0.6f, 0.5f );
    m.kind = RF_BSDF_COATED;
    m.clearcoat = 1.0f;
    m.clearcoat_alpha = RF_MIN_ALPHA;
    hard_stage( h, m );
    // normals that lean by 1e-2 rad: some eyes are below the horizon of the coat
    for ( uint32_t i = 0; i < h->scene.triangles.vertex_count; ++i )
    {
        float* n = h->scene.triangles.normals + 3 * (size_t)i;
        n[2] += n[1] > 0.5f ? ( i % 2 == 0 ? -0.01f : 0.005f ) : 0.0f;
    }
    hard_eyes( h, rf_vec3( 1.3f, 2e-3f, 1.9f ), rf_vec3( 1e-3f, 1e-4f, 0 ), rf_vec3( 0, -2e-3f, -1 ), 1.0 );
}

// A coated sheet that lets light through, in the stage, between the eyes of a group, who see it at 1e-3 rad and more. Its normals lean:
// some eyes are below its horizon.
static void sheet_between_eyes( HardScene* h )
{
    RfMaterial m = make_plastic( 0.3f, 0.2f );
    m.kind = RF_BSDF_TRANSLUCENT;
    m.through = rf_vec3( 0.5f, 0.6f, 0.3f );
    hard_stage( h, hard_grey() );
    SceneBuilder b = hard_reopen( &h->scene );
    uint32_t first = b.scene.triangles.vertex_count;
    add_quad( &b, add_material( &b, m ), rf_vec3( -1.5f, 0.2f, 1.2f ), rf_vec3( 1.5f, 0.2f, 1.2f ), rf_vec3( 1.5f, 2.0f, 1.2f ),
              rf_vec3( -1.5f, 2.0f, 1.2f ) );
    h->scene = finish_scene( &b );
    for ( uint32_t i = first; i < h->scene.triangles.vertex_count; ++i )
        h->scene.triangles.normals[3 * (size_t)i] += i % 2 == 0 ? 0.01f : -0.01f;
    hard_eyes( h, rf_vec3( 1.4f, 1.0f, 1.2005f ), rf_vec3( 0, 0, 1e-3f ), rf_vec3( -1.0f, -0.1f, 0.0f ), 50.0 );
}

const HardCase g_hard_materials[] = {
    { "lambert-1", "a floor and a block of albedo 1", "roulette of paths that lose nothing", HARD_DOUBLE, 1.5, lambert_white,
      NULL },
    { "black", "a floor and a block that reflect nothing", "0/0 in the choice of lobes", HARD_DOUBLE, 1.5, black, NULL },
    { "phong-0", "a Phong lobe of exponent 0", "pow(0, 0); a lobe as wide as the hemisphere", HARD_DOUBLE, 1.5, phong_0, NULL },
    { "phong-100", "a Phong lobe of exponent 100", "the usual", HARD_DOUBLE, 2.0, phong_100, NULL },
    { "phong-1e4", "a Phong lobe of exponent 1e4 under a sky", "cos to the n near 1", HARD_VALUE, 0, phong_1e4, NULL },
    { "phong-1e7", "a Phong lobe of exponent 1e7 under a sky", "cos to the n: 1/n is the spacing of floats at 1", HARD_VALUE, 0,
      phong_1e7, NULL },
    { "ggx-0", "white metal of roughness 0 under a sky", "sines of 1e-5 as differences from 1", HARD_VALUE, 0, ggx_0, NULL },
    { "ggx-0-stage", "a stage of metal of roughness 0", "densities of 3e5 per sr", HARD_PLAIN, 0, ggx_sharp_stage, NULL },
    { "ggx-1", "metal of roughness 1", "the widest lobe", HARD_DOUBLE, 1.5, ggx_1, NULL },
    { "mirror", "the limit of roughness 0, a mirror, under a sky", "infinite densities", HARD_VALUE, 0, mirror, NULL },
    { "mirror-grazing", "a mirror seen at 1e-3 rad", "images of eyes near its plane", HARD_VALUE, 0, mirror_grazing, NULL },
    { "mirror-edge-on", "a mirror seen at 1e-5 rad", "eyes below the horizon of the models", HARD_VALUE, 0, mirror_edge_on,
      NULL },
    { "mirror-stage", "a sheet of mirror seen at 1e-3 to 1e-2 rad", "chains at grazing angles", HARD_PLAIN, 2.0, mirror_stage,
      NULL },
    { "ior-1", "glass of index 1 seen at 1e-3 rad", "no reflection at all; 1 - sin2 keeps two digits of cos2", HARD_BLACK, 0,
      ior_1, NULL },
    { "ior-1-black", "sheets of index 1 that let nothing through", "0/0 in the choice of lobes", HARD_PLAIN, 1.5, ior_1_black,
      NULL },
    { "ior-1.0001", "glass of index 1.0001", "total reflection at the last 0.8 degrees", HARD_VALUE, 0, ior_almost_1, NULL },
    { "ior-10", "sheets of index 10", "nearly mirrors", HARD_VALUE, 0, ior_10, NULL },
    { "ior-10-body", "a body of index 10", "radiance scaled by 1/100 and back", HARD_PLAIN, 1.5, ior_10_body, NULL },
    { "absorption-1e-9", "glass that absorbs 1e-9 per m", "exp(0)", HARD_VALUE, 0, absorption_small, NULL },
    { "absorption-1e9", "glass that absorbs 1e9 per m", "exp(-1e9): throughput 0, roulette by 0", HARD_PLAIN, 1.5,
      absorption_large, NULL },
    { "rough-glass", "glass of roughness 1", "refraction below horizons", HARD_PLAIN, 1.5, rough_glass, NULL },
    { "rough-glass-grazing", "sharp rough glass at 1e-3 rad", "1/cos of the model", HARD_PLAIN, 0, rough_glass_grazing, NULL },
    { "clear-coat-grazing", "the smoothest coat at 1e-3 rad, above and below its horizon", "1/cos of the coat", HARD_PLAIN, 0,
      clear_coat, NULL },
    { "sheet-between-eyes", "a sheet that light comes through, between the eyes of a group, seen at 1e-3 rad and more",
      "sides that are drawn; eyes below the horizon on either side", HARD_PLAIN, 0, sheet_between_eyes, NULL },
    { 0 },
};
