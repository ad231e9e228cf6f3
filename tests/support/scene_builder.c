#include "support/scene_builder.h"

#include "scene/light_groups.h"

#include <stdlib.h>
#include <string.h>

static RfMaterial blank( RfBsdfKind kind )
{
    return ( RfMaterial ){ .name = NULL, .kind = kind, .alpha = 1.0f, .double_sided = true };
}

RfMaterial make_lambert( float r, float g, float b )
{
    RfMaterial m = blank( RF_BSDF_LAMBERT );
    m.diffuse = rf_vec3( r, g, b );
    return m;
}

RfMaterial make_phong( float diffuse, float specular, float exponent )
{
    RfMaterial m = blank( RF_BSDF_PHONG );
    m.diffuse = rf_vec3( diffuse, diffuse, diffuse );
    m.specular = rf_vec3( specular, specular, specular );
    m.exponent = exponent;
    return m;
}

RfMaterial make_metal( float reflectance, float roughness )
{
    RfMaterial m = blank( RF_BSDF_GGX );
    m.specular = rf_vec3( reflectance, 0.9f * reflectance, 0.8f * reflectance );
    m.f90 = 1.0f;
    m.coat_f0 = 0.04f;
    m.coat_f90 = 1.0f;
    m.alpha = roughness * roughness;
    return m;
}

RfMaterial make_plastic( float diffuse, float roughness )
{
    RfMaterial m = make_metal( 0.04f, roughness );
    m.specular = rf_vec3( 0.04f, 0.04f, 0.04f );
    m.diffuse = rf_vec3( 0.5f * diffuse, diffuse, diffuse );
    return m;
}

RfMaterial make_light( float radiance, bool double_sided )
{
    RfMaterial m = make_lambert( 0, 0, 0 );
    m.emission = rf_vec3( radiance, radiance, 0.9f * radiance );
    m.double_sided = double_sided;
    return m;
}

static void* grow( void* memory, size_t bytes )
{
    void* grown = realloc( memory, bytes );
    if ( grown == NULL )
        abort();
    return grown;
}

uint32_t add_material( SceneBuilder* b, RfMaterial material )
{
    RfScene* s = &b->scene;
    s->materials = grow( s->materials, ( s->material_count + 1 ) * sizeof *s->materials );
    s->materials[s->material_count] = material;
    s->materials[s->material_count].name = strdup( "test" );
    return s->material_count++;
}

static uint32_t add_vertex( SceneBuilder* b, RfVec3 p, RfVec3 n )
{
    RfTriangles* t = &b->scene.triangles;
    if ( t->vertex_count == b->vertex_room )
    {
        b->vertex_room = 2 * b->vertex_room + 64;
        t->positions = grow( t->positions, (size_t)b->vertex_room * 3 * sizeof( float ) );
        t->normals = grow( t->normals, (size_t)b->vertex_room * 3 * sizeof( float ) );
    }
    memcpy( t->positions + 3 * (size_t)t->vertex_count, &p, sizeof p );
    memcpy( t->normals + 3 * (size_t)t->vertex_count, &n, sizeof n );
    return t->vertex_count++;
}

static void add_triangle( SceneBuilder* b, uint32_t material, uint32_t i, uint32_t j, uint32_t k )
{
    RfTriangles* t = &b->scene.triangles;
    if ( t->count == b->triangle_room )
    {
        b->triangle_room = 2 * b->triangle_room + 64;
        t->indices = grow( t->indices, (size_t)b->triangle_room * 3 * sizeof( uint32_t ) );
        t->material = grow( t->material, (size_t)b->triangle_room * sizeof( uint32_t ) );
    }
    uint32_t corners[3] = { i, j, k };
    memcpy( t->indices + 3 * (size_t)t->count, corners, sizeof corners );
    t->material[t->count++] = material;
}

void add_quad( SceneBuilder* b, uint32_t material, RfVec3 p, RfVec3 q, RfVec3 r, RfVec3 s )
{
    RfVec3 n = rf_normalize( rf_cross( rf_sub( q, p ), rf_sub( r, p ) ) );
    uint32_t i = add_vertex( b, p, n ), j = add_vertex( b, q, n ), k = add_vertex( b, r, n ), l = add_vertex( b, s, n );
    add_triangle( b, material, i, j, k );
    add_triangle( b, material, i, k, l );
}

void add_box( SceneBuilder* b, uint32_t material, RfVec3 l, RfVec3 h, bool inside )
{
    RfVec3 p[8];
    for ( int i = 0; i < 8; ++i )
        p[i] = rf_vec3( i & 1 ? h.x : l.x, i & 2 ? h.y : l.y, i & 4 ? h.z : l.z );
    static const int faces[6][4] = { { 0, 4, 6, 2 }, { 1, 3, 7, 5 }, { 0, 1, 5, 4 },
                                     { 2, 6, 7, 3 }, { 0, 2, 3, 1 }, { 4, 5, 7, 6 } };
    for ( int f = 0; f < 6; ++f )
    {
        const int* c = faces[f];
        if ( inside )
            add_quad( b, material, p[c[3]], p[c[2]], p[c[1]], p[c[0]] );
        else
            add_quad( b, material, p[c[0]], p[c[1]], p[c[2]], p[c[3]] );
    }
}

void add_sphere( SceneBuilder* b, uint32_t material, RfVec3 center, float radius, int n )
{
    uint32_t base = b->scene.triangles.vertex_count;
    for ( int i = 0; i <= n; ++i )
    {
        for ( int j = 0; j <= 2 * n; ++j )
        {
            float theta = RF_PI * (float)i / (float)n, phi = RF_PI * (float)( j % ( 2 * n ) ) / (float)n;
            RfVec3 d = rf_vec3( sinf( theta ) * cosf( phi ), cosf( theta ), -sinf( theta ) * sinf( phi ) );
            add_vertex( b, rf_madd( center, d, radius ), d );
        }
    }
    uint32_t row = (uint32_t)( 2 * n + 1 );
    for ( uint32_t i = 0; i < (uint32_t)n; ++i )
    {
        for ( uint32_t j = 0; j < row - 1; ++j )
        {
            uint32_t v = base + i * row + j;
            if ( i > 0 )
                add_triangle( b, material, v, v + row, v + 1 );
            if ( i + 1 < (uint32_t)n )
                add_triangle( b, material, v + 1, v + row, v + row + 1 );
        }
    }
}

RfScene finish_scene( SceneBuilder* b )
{
    RfScene scene = b->scene;
    const RfTriangles* t = &scene.triangles;
    scene.path = strdup( "test scene" );
    for ( uint32_t i = 0; i < t->vertex_count; ++i )
    {
        const float* p = t->positions + 3 * (size_t)i;
        RfVec3 v = rf_vec3( p[0], p[1], p[2] );
        RfVec3 low = scene.bounds_min, high = scene.bounds_max;
        scene.bounds_min = i == 0 ? v : rf_vec3( rf_minf( low.x, v.x ), rf_minf( low.y, v.y ), rf_minf( low.z, v.z ) );
        scene.bounds_max = i == 0 ? v : rf_vec3( rf_maxf( high.x, v.x ), rf_maxf( high.y, v.y ), rf_maxf( high.z, v.z ) );
    }
    *b = ( SceneBuilder ){ 0 };
    return scene;
}

RfScene make_room( RoomKind kind )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.6f, 0.55f, 0.5f ) );
    uint32_t red = add_material( &b, make_lambert( 0.6f, 0.2f, 0.15f ) );
    uint32_t light = add_material( &b, make_light( 10.0f, false ) );
    RfMaterial object[] = { make_lambert( 0.3f, 0.5f, 0.6f ), make_phong( 0.2f, 0.6f, 40.0f ), make_metal( 0.9f, 0.3f ) };
    RfMaterial block[] = { make_lambert( 0.5f, 0.5f, 0.2f ), make_phong( 0.4f, 0.3f, 10.0f ), make_plastic( 0.6f, 0.25f ) };
    uint32_t shiny = add_material( &b, object[kind] );
    uint32_t other = add_material( &b, block[kind] );
    add_box( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_quad( &b, light, rf_vec3( -0.5f, 2.95f, -0.5f ), rf_vec3( 0.5f, 2.95f, -0.5f ), rf_vec3( 0.5f, 2.95f, 0.5f ),
              rf_vec3( -0.5f, 2.95f, 0.5f ) );
    add_quad( &b, red, rf_vec3( -1.9f, 0.1f, -1.9f ), rf_vec3( -1.9f, 0.1f, 1.9f ), rf_vec3( -1.9f, 2.5f, 1.9f ),
              rf_vec3( -1.9f, 2.5f, -1.9f ) );
    add_sphere( &b, shiny, rf_vec3( 0, 1.0f, 0 ), 0.5f, 12 );
    add_box( &b, other, rf_vec3( -0.6f, 0.0f, -0.5f ), rf_vec3( 0.7f, 0.5f, 0.5f ), false );
    return finish_scene( &b );
}

RfMaterial make_glass( float ior, float roughness, bool thin )
{
    RfMaterial m = blank( RF_BSDF_GLASS );
    m.alpha = roughness * roughness;
    m.ior = ior;
    m.thin = thin;
    m.tint = rf_vec3( 1, 1, 1 );
    return m;
}

RfMaterial make_mirror( float reflectance )
{
    RfMaterial m = blank( RF_BSDF_GLASS );
    m.alpha = 0.0f;
    m.specular = rf_vec3( reflectance, reflectance, 0.9f * reflectance );
    return m;
}

RfPunctual make_point_light( RfVec3 position, float intensity )
{
    return ( RfPunctual ){
        .kind = RF_PUNCTUAL_POINT,
        .position = position,
        .direction = rf_vec3( 0, -1, 0 ),
        .intensity = rf_vec3( intensity, intensity, 0.8f * intensity ),
        .cos_inner = 1.0f,
        .cos_outer = -1.0f,
        .range = INFINITY,
    };
}

RfPunctual make_beam( RfVec3 position, RfVec3 direction, float intensity )
{
    RfPunctual lamp = make_point_light( position, intensity );
    double vertical[] = { 0.0, 20.0, 45.0, 80.0 }, horizontal[] = { 0.0, 90.0, 180.0, 270.0, 360.0 };
    double value[] = { 1.0, 0.9, 0.5, 0.0, 1.0, 1.0, 1.5, 0.0, 1.0, 0.9, 0.5, 0.0, 1.0, 0.6, 0.0, 0.0, 1.0, 0.9, 0.5, 0.0 };
    RfVec3 other;
    lamp.direction = rf_normalize( direction );
    lamp.turned = true;
    rf_basis( lamp.direction, &lamp.across, &other );
    RfProfileTable table = { 4, 5, vertical, horizontal, value };
    if ( rf_make_profile( "beam", &table, &lamp.profile, NULL ) != RF_OK )
        abort();
    return lamp;
}

static void add_lamps( RfScene* scene )
{
    scene->punctuals = grow( NULL, 3 * sizeof *scene->punctuals );
    scene->punctual_count = 3;
    scene->punctuals[0] = make_point_light( rf_vec3( -0.8f, 1.6f, 0.6f ), 2.0f );
    RfPunctual spot = make_point_light( rf_vec3( 0.9f, 2.2f, 0.3f ), 9.0f );
    spot.kind = RF_PUNCTUAL_SPOT;
    spot.direction = rf_normalize( rf_vec3( -0.9f, -2.0f, -0.3f ) );
    spot.cos_inner = 0.98f;
    spot.cos_outer = 0.9f;
    spot.range = 4.0f;
    scene->punctuals[1] = spot;
    RfPunctual sun = make_point_light( rf_vec3( 0, 0, 0 ), 1.5f );
    sun.kind = RF_PUNCTUAL_DIRECTIONAL;
    sun.direction = rf_normalize( rf_vec3( 0.4f, -1.0f, -0.3f ) );
    scene->punctuals[2] = sun;
}

#define MAP_WIDTH 16
#define MAP_HEIGHT 8

static void add_map( RfScene* scene )
{
    RfEnvironment* e = &scene->environment;
    e->width = MAP_WIDTH;
    e->height = MAP_HEIGHT;
    e->map = grow( NULL, 3 * MAP_WIDTH * MAP_HEIGHT * sizeof( float ) );
    e->rotation = 0.7f;
    for ( int i = 0; i < MAP_WIDTH * MAP_HEIGHT; ++i )
    {
        float up = 1.0f - (float)( i / MAP_WIDTH ) / MAP_HEIGHT;
        e->map[3 * i] = 0.3f * up;
        e->map[3 * i + 1] = 0.4f * up;
        e->map[3 * i + 2] = 0.6f * up;
    }
    for ( int c = 0; c < 3; ++c )
        e->map[3 * ( 2 * MAP_WIDTH + 5 ) + c] = 30.0f;
}

RfScene make_open_scene( OpenLight light )
{
    SceneBuilder b = { 0 };
    uint32_t floor = add_material( &b, make_lambert( 0.6f, 0.55f, 0.5f ) );
    uint32_t metal = add_material( &b, make_metal( 0.9f, 0.3f ) );
    RfMaterial block = make_plastic( 0.6f, 0.25f );
    if ( light == LIT_BY_MAP )
    {
        block.kind = RF_BSDF_COATED;
        block.clearcoat = 0.8f;
        block.clearcoat_alpha = 0.04f;
    }
    uint32_t plastic = add_material( &b, block );
    add_quad( &b, floor, rf_vec3( -3, 0, 3 ), rf_vec3( 3, 0, 3 ), rf_vec3( 3, 0, -3 ), rf_vec3( -3, 0, -3 ) );
    add_sphere( &b, metal, rf_vec3( 0, 1.0f, 0 ), 0.5f, 12 );
    add_box( &b, plastic, rf_vec3( -0.6f, 0.0f, -0.5f ), rf_vec3( 0.7f, 0.5f, 0.5f ), false );
    if ( light == LIT_BY_ALL )
    {
        uint32_t lamp = add_material( &b, make_light( 6.0f, true ) );
        add_quad( &b, lamp, rf_vec3( -1.2f, 1.2f, -1 ), rf_vec3( -0.8f, 1.2f, -1 ), rf_vec3( -0.8f, 1.6f, -1 ),
                  rf_vec3( -1.2f, 1.6f, -1 ) );
    }
    RfScene scene = finish_scene( &b );
    if ( light != LIT_BY_LAMPS )
        scene.environment.radiance = rf_vec3( 0.5f, 0.5f, 0.6f );
    if ( light == LIT_BY_MAP || light == LIT_BY_ALL )
        add_map( &scene );
    if ( light == LIT_BY_LAMPS || light == LIT_BY_ALL )
        add_lamps( &scene );
    scene.environment.hidden = light == LIT_BY_ALL;
    return scene;
}

RfScene make_glass_room( void )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.6f, 0.55f, 0.5f ) );
    uint32_t light = add_material( &b, make_light( 4.0f, false ) );
    uint32_t glass = add_material( &b, make_glass( 1.5f, 0.0f, false ) );
    b.scene.materials[glass].absorption = rf_vec3( 0.2f, 0.6f, 1.5f );
    uint32_t rough = add_material( &b, make_glass( 1.4f, 0.35f, false ) );
    b.scene.materials[rough].diffuse = rf_vec3( 0.1f, 0.3f, 0.2f );
    b.scene.materials[rough].tint = rf_vec3( 0.6f, 0.6f, 0.7f );
    uint32_t thin = add_material( &b, make_glass( 1.5f, 0.2f, true ) );
    b.scene.materials[thin].tint = rf_vec3( 0.9f, 0.5f, 0.4f );
    uint32_t mirror = add_material( &b, make_mirror( 0.9f ) );
    uint32_t plastic = add_material( &b, make_plastic( 0.6f, 0.25f ) );
    add_box( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_quad( &b, light, rf_vec3( -1.5f, 2.95f, -1.5f ), rf_vec3( 1.5f, 2.95f, -1.5f ), rf_vec3( 1.5f, 2.95f, 1.5f ),
              rf_vec3( -1.5f, 2.95f, 1.5f ) );
    add_sphere( &b, glass, rf_vec3( 0, 1.0f, 0 ), 0.4f, 12 );
    add_box( &b, plastic, rf_vec3( -0.6f, 0.0f, -0.5f ), rf_vec3( 0.7f, 0.5f, 0.5f ), false );
    add_box( &b, rough, rf_vec3( 0.6f, 0.6f, -0.4f ), rf_vec3( 0.9f, 1.1f, 0.3f ), false );
    add_quad( &b, thin, rf_vec3( -1.0f, 0.5f, 0.2f ), rf_vec3( -0.5f, 0.5f, 0.2f ), rf_vec3( -0.5f, 1.3f, 0.2f ),
              rf_vec3( -1.0f, 1.3f, 0.2f ) );
    add_quad( &b, mirror, rf_vec3( -1.9f, 0.3f, -1.8f ), rf_vec3( 1.9f, 0.3f, -1.8f ), rf_vec3( 1.9f, 2.0f, -1.8f ),
              rf_vec3( -1.9f, 2.0f, -1.8f ) );
    return finish_scene( &b );
}

void add_punctual( RfScene* scene, RfPunctual lamp )
{
    scene->punctuals = realloc( scene->punctuals, ( (size_t)scene->punctual_count + 1 ) * sizeof lamp );
    if ( scene->punctuals == NULL )
        abort();
    scene->punctuals[scene->punctual_count++] = lamp;
}

void tag_lights( RfScene* scene, int tags )
{
    static const char* const names[] = { "key", "fill", "back", "lamp 4", "lamp 5", "lamp 6", "lamp 7", "lamp 8" };
    int n = 0;
    uint16_t tag_of[9] = { 0 };
    for ( int k = 0; k < tags; ++k )
    {
        if ( !rf_tag_light( scene, names[k], tag_of + k ) )
            abort();
    }
    for ( int i = 0; i < scene->punctual_count; ++i )
        scene->punctuals[i].light_group = tag_of[n++ % ( tags + 1 )];
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        RfMaterial* m = scene->materials + i;
        if ( rf_max_component( m->emission ) > 0.0f || m->dims )
            m->light_group = tag_of[n++ % ( tags + 1 )];
    }
    scene->environment.light_group = tag_of[n++ % ( tags + 1 )];
}

RfScene make_furnace( float albedo, float emission )
{
    SceneBuilder b = { 0 };
    RfMaterial m = make_lambert( albedo, albedo, albedo );
    m.emission = rf_vec3( emission, emission, emission );
    m.double_sided = true;
    add_box( &b, add_material( &b, m ), rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), true );
    return finish_scene( &b );
}

void orbit_eyes( RfEye* eyes, int count, float degrees, int width, int height )
{
    RfVec3 target = rf_vec3( 0, 0.9f, 0 );
    for ( int i = 0; i < count; ++i )
    {
        float a = degrees * RF_PI / 180.0f * ( (float)i - 0.5f * (float)( count - 1 ) );
        RfVec3 o = rf_vec3( 1.7f * sinf( a ), 1.4f, 1.7f * cosf( a ) );
        eyes[i] = rf_make_eye( o, rf_sub( target, o ), rf_vec3( 0, 1, 0 ), 0.9, width, height );
    }
}

void move_scene( RfScene* scene, float scale, RfVec3 shift )
{
    for ( uint32_t i = 0; i < scene->triangles.vertex_count; ++i )
    {
        float* p = scene->triangles.positions + 3 * (size_t)i;
        p[0] = p[0] * scale + shift.x;
        p[1] = p[1] * scale + shift.y;
        p[2] = p[2] * scale + shift.z;
    }
    for ( int i = 0; i < scene->punctual_count; ++i )
    {
        RfPunctual* lamp = scene->punctuals + i;
        if ( lamp->kind == RF_PUNCTUAL_DIRECTIONAL )
            continue;
        lamp->position = rf_madd( shift, lamp->position, scale );
        lamp->intensity = rf_scale( lamp->intensity, scale * scale );
        lamp->range *= scale;
    }
    scene->bounds_min = rf_madd( shift, scene->bounds_min, scale );
    scene->bounds_max = rf_madd( shift, scene->bounds_max, scale );
}
