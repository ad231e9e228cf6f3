// Hard cases of cloth and curtains.
#include "hard/hard.h"
#include "scene/textured.h"

// White sheen of a roughness as files have it.
static RfMaterial cloth( double roughness )
{
    RfFactors factors = { .sheen_color = { 1, 1, 1 }, .sheen_roughness = roughness, .film_ior = 1.3 };
    RfMaterial m = make_lambert( 0.6f, 0.5f, 0.4f );
    m.alpha = 1.0f;
    rf_derive_layers( &factors, &m );
    m.kind = RF_BSDF_SHEEN;
    return m;
}

static RfMaterial curtain( float reflectance, float through )
{
    RfMaterial m = make_lambert( reflectance, reflectance, reflectance );
    m.kind = RF_BSDF_TRANSLUCENT;
    m.alpha = 1.0f;
    m.through = rf_vec3( through, through, through );
    return m;
}

// The eyes of a stage at 2e-3 rad over its floor.
static void look_along( HardScene* h )
{
    hard_eyes( h, rf_vec3( 1.3f, 2e-3f, 1.9f ), rf_vec3( 1e-3f, 1e-4f, 0 ), rf_vec3( 0, -2e-3f, -1 ), 1.0 );
}

static void sheen_0( HardScene* h ) { hard_stage( h, cloth( 0.0 ) ); }

static void sheen_0_along( HardScene* h )
{
    hard_stage( h, cloth( 0.0 ) );
    look_along( h );
}

static void sheen_1_along( HardScene* h )
{
    hard_stage( h, cloth( 1.0 ) );
    look_along( h );
}

// A lamp 1e-5 m behind a curtain that reflects nothing: it is as bright as the lamp, times what it lets through.
static void curtain_lamp( HardScene* h )
{
    SceneBuilder b = { 0 };
    uint32_t cloth_of = add_material( &b, curtain( 0.0f, 0.5f ) ), lamp = add_material( &b, make_light( 2.0f, false ) );
    b.scene.materials[lamp].emission = rf_vec3( 2, 2, 2 );
    add_quad( &b, cloth_of, rf_vec3( -1, -1, 0 ), rf_vec3( 1, -1, 0 ), rf_vec3( 1, 1, 0 ), rf_vec3( -1, 1, 0 ) );
    add_quad( &b, lamp, rf_vec3( -1, -1, -1e-5f ), rf_vec3( 1, -1, -1e-5f ), rf_vec3( 1, 1, -1e-5f ), rf_vec3( -1, 1, -1e-5f ) );
    h->scene = finish_scene( &b );
    hard_eyes( h, rf_vec3( 0.1f, 0.05f, 2.0f ), rf_vec3( 0.02f, 0, 0 ), rf_vec3( 0, 0, -1 ), 10.0 );
    h->value = 1.0;
    h->within = 1e-3;
}

// A white sheet, half of whose light passes, under a sky of radiance 1.
static void sheet_in_the_sky( HardScene* h, RfVec3 from, RfVec3 forward, float degrees )
{
    SceneBuilder b = { 0 };
    add_quad( &b, add_material( &b, curtain( 0.5f, 0.5f ) ), rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ),
              rf_vec3( -2, 0, -2 ) );
    h->scene = finish_scene( &b );
    h->scene.environment.radiance = rf_vec3( 1, 1, 1 );
    hard_eyes( h, from, rf_vec3( 3e-4f, 0, 0 ), forward, (double)degrees );
    h->value = 1.0;
    h->within = 1e-4;
}

static void curtain_edge_on( HardScene* h ) { sheet_in_the_sky( h, rf_vec3( 0, 1e-5f, 1 ), rf_vec3( 0, -1e-5f, -1 ), 0.02f ); }

static void curtain_flipped( HardScene* h )
{
    sheet_in_the_sky( h, rf_vec3( 0, -1, 0.3f ), rf_vec3( 0, 1, -0.3f ), 20.0f );
    for ( uint32_t i = 0; i < 3 * h->scene.triangles.vertex_count; ++i )
        h->scene.triangles.normals[i] = -h->scene.triangles.normals[i];
}

static void curtain_leaning( HardScene* h )
{
    hard_stage( h, curtain( 0.3f, 0.6f ) );
    for ( uint32_t i = 0; i < h->scene.triangles.vertex_count; ++i )
    {
        float* n = h->scene.triangles.normals + 3 * (size_t)i;
        RfVec3 lean = rf_normalize( rf_add( rf_vec3( n[0], n[1], n[2] ), rf_vec3( i % 2 == 0 ? 4.0f : -4.0f, 0.5f, 0 ) ) );
        n[0] = lean.x;
        n[1] = lean.y;
        n[2] = lean.z;
    }
}

// Light passes into the block and out again: nothing stays on a side.
static void curtain_box( HardScene* h ) { hard_stage( h, curtain( 0.0f, 0.9f ) ); }

const HardCase g_hard_surfaces[] = {
    { "sheen-0", "sheen of roughness 0", "1/0 as an exponent", HARD_PLAIN, 0, sheen_0, NULL },
    { "sheen-0-grazing", "sheen of roughness 0 at 2e-3 rad", "0 to the infinite", HARD_PLAIN, 0, sheen_0_along, NULL },
    { "sheen-1-grazing", "sheen of roughness 1 at 2e-3 rad", "1/cos, and more than all reflected", HARD_PLAIN, 0, sheen_1_along,
      NULL },
    { "curtain-lamp", "a lamp 1e-5 m behind a curtain", "rays that start on the wrong side", HARD_VALUE, 0, curtain_lamp, NULL },
    { "curtain-edge-on", "a curtain seen at 1e-5 rad", "hits of one side lit from the other", HARD_VALUE, 0, curtain_edge_on,
      NULL },
    { "curtain-flipped", "a curtain from below with flipped normals", "sides taken from the wrong normal", HARD_VALUE, 0,
      curtain_flipped, NULL },
    { "curtain-leaning", "translucent things with normals that lean", "sides of shading and triangle differ", HARD_PLAIN, 0,
      curtain_leaning, NULL },
    { "curtain-box", "a block that lets all through", "paths that never reflect", HARD_PLAIN, 0, curtain_box, NULL },
    { 0 },
};
