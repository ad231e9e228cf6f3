#include "support/textured_room.h"

#include "image/decode.h"

#include <stdlib.h>
#include <string.h>

#define SIDE 8

static void* grab( size_t bytes )
{
    void* memory = calloc( 1, bytes );
    if ( memory == NULL )
        abort();
    return memory;
}

RfTextured* make_textured( const RfFactors* factors )
{
    RfTextured* t = grab( sizeof *t );
    t->factors = *factors;
    t->normal_scale = t->clearcoat_normal_scale = 1.0f;
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
        t->refs[i] = ( RfTextureRef ){ .texture = -1, .transform = { 1, 0, 0, 0, 1, 0 } };
    return t;
}

RfTexture make_texture( int width, int height, int channels, const uint8_t* bytes, bool srgb )
{
    size_t size = (size_t)width * (size_t)height * (size_t)channels;
    RfTexture t = { .width = width, .height = height, .channels = channels, .bytes = grab( size ), .largest = 1.0f };
    memcpy( t.bytes, bytes, size );
    for ( int i = 0; i < 256; ++i )
        t.table[i] = srgb ? rf_srgb_to_linear( (float)i / 255.0f ) : (float)i / 255.0f;
    return t;
}

// 0 colour and alpha, 1 roughness and metal, 2 bumps, 3 light
static void add_textures( RfScene* scene )
{
    uint8_t bytes[4][SIDE * SIDE * 4];
    uint32_t seed = 7;
    for ( int i = 0; i < SIDE * SIDE; ++i )
    {
        for ( int k = 0; k < 4; ++k )
        {
            for ( int c = 0; c < 4; ++c )
            {
                seed = seed * 1664525u + 1013904223u;
                bytes[k][4 * i + c] = (uint8_t)( seed >> 24 );
            }
        }
        for ( int c = 0; c < 2; ++c )
            bytes[2][4 * i + c] = (uint8_t)( 96 + bytes[2][4 * i + c] / 4 );
        bytes[2][4 * i + 2] = 255;
        if ( i % SIDE < 4 )
            memset( bytes[3] + 4 * i, 0, 4 );
    }
    scene->texture_count = 4;
    scene->textures = grab( 4 * sizeof *scene->textures );
    for ( int k = 0; k < 4; ++k )
        scene->textures[k] = make_texture( SIDE, SIDE, 4, bytes[k], k == 0 || k == 3 );
}

static void add_attributes( RfScene* scene )
{
    RfTriangles* t = &scene->triangles;
    t->uvs = grab( 2 * (size_t)t->vertex_count * sizeof( float ) );
    t->uvs1 = grab( 2 * (size_t)t->vertex_count * sizeof( float ) );
    t->colors = grab( 4 * (size_t)t->vertex_count * sizeof( float ) );
    for ( size_t i = 0; i < t->vertex_count; ++i )
    {
        const float* p = t->positions + 3 * i;
        t->uvs[2 * i] = 0.7f * p[0] + 0.37f * p[2];
        t->uvs[2 * i + 1] = 0.6f * p[1] + 0.45f * p[2];
        t->uvs1[2 * i] = t->uvs[2 * i + 1];
        t->uvs1[2 * i + 1] = t->uvs[2 * i];
        for ( int c = 0; c < 4; ++c )
            t->colors[4 * i + (size_t)c] = 0.5f + 0.5f * sinf( 3.0f * p[c % 3] + (float)c );
    }
}

void add_test_textures( RfScene* scene )
{
    add_textures( scene );
    add_attributes( scene );
}

RfTextured* texture_material( RfScene* scene, uint32_t material, RfFactors factors )
{
    RfMaterial* m = scene->materials + material;
    m->textured = make_textured( &factors );
    return m->textured;
}

void use_texture( RfTextured* t, RfTextureSlot slot, int number, int set )
{
    t->refs[slot].texture = number;
    t->refs[slot].uv_set = set;
    t->refs[slot].wrap[0] = set == 0 ? RF_WRAP_REPEAT : RF_WRAP_MIRROR;
}

RfScene make_textured_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    add_test_textures( &scene );
    RfFactors paint = { .base = { 0.8, 0.8, 0.7, 1 }, .roughness = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5 };
    use_texture( texture_material( &scene, 0, paint ), RF_TEXTURE_BASE, 0, 0 );
    RfTextured* cut = texture_material( &scene, 1, paint );
    use_texture( cut, RF_TEXTURE_BASE, 0, 1 );
    cut->masked = true;
    cut->alpha_cutoff = 0.5f;
    use_texture( texture_material( &scene, 2, paint ), RF_TEXTURE_EMISSIVE, 3, 0 );
    RfFactors coated = paint;
    coated.specular = 1;
    coated.roughness = 0.6;
    RfTextured* sphere = texture_material( &scene, ROOM_OBJECT_MATERIAL, coated );
    sphere->vertex_colors = true;
    sphere->normal_scale = 0.8f;
    use_texture( sphere, RF_TEXTURE_NORMAL, 2, 0 );
    RfFactors metal = coated;
    metal.metallic = 1;
    metal.roughness = 0.9;
    RfTextured* block = texture_material( &scene, 4, metal );
    use_texture( block, RF_TEXTURE_METALLIC_ROUGHNESS, 1, 1 );
    use_texture( block, RF_TEXTURE_SPECULAR, 0, 0 );
    return scene;
}

static RfTextured* blend( RfScene* scene, uint32_t material, RfFactors factors, double alpha )
{
    factors.base[3] = alpha;
    RfTextured* t = texture_material( scene, material, factors );
    t->blended = true;
    return t;
}

RfScene make_blended_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    add_test_textures( &scene );
    RfFactors paint = { .base = { 0.8, 0.5, 0.3, 1 }, .roughness = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5 };
    use_texture( blend( &scene, 1, paint, 0.9 ), RF_TEXTURE_BASE, 0, 1 );
    blend( &scene, 2, paint, 0.7 );
    RfFactors coated = paint;
    coated.specular = 1;
    coated.roughness = 0.5;
    blend( &scene, ROOM_OBJECT_MATERIAL, coated, 0.4 ); // not the block, whose bottom is in the floor
    return scene;
}

RfScene make_varied_room( void )
{
    RfScene scene = make_room( ROOM_GGX );
    add_test_textures( &scene );
    RfFactors factors = {
        .base = { 0.8, 0.7, 0.6, 1 }, .metallic = 0.8, .roughness = 0.6, .specular = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5
    };
    RfMaterial* ball = scene.materials + ROOM_OBJECT_MATERIAL;
    ball->kind = RF_BSDF_GLASS;
    ball->ior = 1.5f;
    ball->absorption = rf_vec3( 0.3f, 0.1f, 0.9f );
    RfTextured* glass = texture_material( &scene, ROOM_OBJECT_MATERIAL, factors );
    glass->model = RF_TEXTURED_GLASS;
    glass->transmission = 0.9;
    use_texture( glass, RF_TEXTURE_TRANSMISSION, 0, 1 );
    use_texture( glass, RF_TEXTURE_METALLIC_ROUGHNESS, 1, 0 );
    factors.metallic = 0;
    scene.materials[4].kind = RF_BSDF_COATED;
    RfTextured* coat = texture_material( &scene, 4, factors );
    coat->clearcoat = 0.9;
    coat->clearcoat_roughness = 0.7;
    coat->clearcoat_normal_scale = 0.7f;
    use_texture( coat, RF_TEXTURE_CLEARCOAT, 0, 0 );
    use_texture( coat, RF_TEXTURE_CLEARCOAT_ROUGHNESS, 1, 1 );
    use_texture( coat, RF_TEXTURE_CLEARCOAT_NORMAL, 2, 1 );
    use_texture( coat, RF_TEXTURE_NORMAL, 2, 0 );
    // white paint with a coat that keeps the face's normal over bumps
    scene.materials[1].kind = RF_BSDF_COATED;
    factors.base[0] = factors.base[1] = factors.base[2] = 0.9;
    RfTextured* lacquer = texture_material( &scene, 1, factors );
    lacquer->clearcoat = 1.0;
    lacquer->clearcoat_roughness = 0.4;
    use_texture( lacquer, RF_TEXTURE_NORMAL, 2, 1 );
    return scene;
}
