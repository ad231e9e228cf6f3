// The lights of a group of frames: which part each is, that all frames select with the same chances, that these sum to one and are
// above 0 wherever light arrives in some frame, and that samples have the mean that every light on its own has in a still scene.
#include "base/random.h"
#include "light/changing.h"
#include "light/punctual.h"
#include "scene/movement.h"
#include "scene/placement.h"
#include "support/placed_scenes.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "trace/trace.h"
#include "support/select_light.h"

enum
{
    FRAMES = 5
};

// Lamps of the scene, by their numbers.
enum
{
    STILL,
    DIMMED,
    MOVED,
    SWITCHED, // elsewhere while it is off
    CONSTANT, // but marked as one that changes
    DARK,
    SUN, // travels
    COLOURED,
    ALIKE, // by the dimmer of DIMMED
    WEAK,
    FAINT, // this and the next ones are weaker still, each by a dimmer of its own, and this the weakest
    LAMPS = FAINT + 12
};

// Materials.
enum
{
    GREY,
    SHINES,
    DIMS,       // still triangles
    DIMS_MOVED, // some triangles move
    SETTLED,    // dims at other times
    MATERIALS
};

typedef enum SkyKind
{
    NO_SKY,
    SKY_TURNS,
    SKY_DIMS,
    SKY_STAYS,
} SkyKind;

// A scene as loaded, and as posed for every frame.
typedef struct World
{
    RfScene loaded;
    RfScene posed[FRAMES];
    RfVec3 emission[FRAMES][MATERIALS];
    RfLitFrame frame[FRAMES];
    RfLights still;
} World;

static float number( uint32_t stream, uint32_t i, uint32_t dimension )
{
    return rf_random( rf_pixel_key( rf_pass_key( 23, stream, 0, 0 ), i ), dimension );
}

static RfVec3 direction( uint32_t stream, uint32_t i )
{
    float z = 2.0f * number( stream, i, 0 ) - 1.0f, phi = 2.0f * RF_PI * number( stream, i, 1 );
    float r = sqrtf( rf_maxf( 1.0f - z * z, 0.0f ) );
    return rf_vec3( r * cosf( phi ), r * sinf( phi ), z );
}

static RfVec3 in_cube( uint32_t stream, uint32_t i, float half )
{
    return rf_vec3( half * ( 2.0f * number( stream, i, 2 ) - 1.0f ), half * ( 2.0f * number( stream, i, 3 ) - 1.0f ),
                    half * ( 2.0f * number( stream, i, 4 ) - 1.0f ) );
}

static void add_lamp( SceneBuilder* b, uint32_t material, uint32_t i )
{
    RfVec3 t, s, n = direction( 1, i ), p = in_cube( 1, i, 3.5f );
    float side = 0.05f + 0.5f * number( 1, i, 5 );
    rf_basis( n, &t, &s );
    t = rf_scale( t, side );
    s = rf_scale( s, side );
    add_quad( b, material, p, rf_add( p, t ), rf_add( rf_add( p, t ), s ), rf_add( p, s ) );
}

static void add_lamps( RfScene* scene )
{
    scene->punctual_count = LAMPS;
    scene->punctuals = calloc( LAMPS, sizeof *scene->punctuals );
    for ( uint32_t i = 0; i < LAMPS; ++i )
    {
        float strength = i == WEAK ? 0.1f : i >= FAINT ? 0.002f + 1e-4f * (float)( i - FAINT ) : 4.0f;
        scene->punctuals[i] = make_point_light( in_cube( 2, i, 3.0f ), strength );
        scene->punctuals[i].changes = i != STILL;
    }
    scene->punctuals[MOVED].kind = RF_PUNCTUAL_SPOT;
    scene->punctuals[MOVED].direction = rf_vec3( 0, -1, 0 );
    scene->punctuals[MOVED].cos_inner = 0.9f;
    scene->punctuals[MOVED].cos_outer = 0.7f;
    scene->punctuals[SUN].kind = RF_PUNCTUAL_DIRECTIONAL;
    scene->punctuals[SUN].direction = rf_vec3( 0, -1, 0 );
}

static RfScene load( SkyKind sky )
{
    SceneBuilder b = { 0 }, of_mesh = { 0 };
    add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    for ( int i = SHINES; i < MATERIALS; ++i )
    {
        RfMaterial m = make_light( 3.0f, i == DIMS );
        m.dims = i != SHINES;
        add_material( &b, m );
    }
    add_box( &b, GREY, rf_vec3( -4, -4, -4 ), rf_vec3( 4, 4, 4 ), true );
    for ( uint32_t i = 0; i < 24; ++i )
        add_lamp( &b, SHINES + i % 4, i );
    for ( uint32_t i = 0; i < 3; ++i )
        add_lamp( &of_mesh, i == 0 ? DIMS_MOVED : SHINES, 100 + i );
    RfScene scene = finish_scene( &b ), mesh = finish_scene( &of_mesh );
    add_lamps( &scene );
    scene.meshes = calloc( 1, sizeof *scene.meshes );
    scene.mesh_count = 1;
    scene.meshes[0] = ( RfMesh ){ .triangles = mesh.triangles, .bounds_min = mesh.bounds_min, .bounds_max = mesh.bounds_max };
    mesh.triangles = ( RfTriangles ){ 0 };
    rf_destroy_scene( &mesh );
    for ( int i = 0; i < 3; ++i )
        add_placement( &scene, 0, rf_mat4_identity() );
    assert_int_equal( rf_finish_placements( &scene, NULL ), RF_OK );
    scene.still_placement_count = 0;
    scene.movement = calloc( 1, sizeof *scene.movement );
    if ( sky == NO_SKY )
        return scene;
    scene.environment =
        ( RfEnvironment ){ .radiance = rf_vec3( 0.2f, 0.3f, 0.4f ), .width = 8, .height = 4, .changes = sky != SKY_STAYS };
    scene.environment.map = malloc( 3 * 8 * 4 * sizeof( float ) );
    for ( int i = 0; i < 3 * 8 * 4; ++i )
        scene.environment.map[i] = i == 30 ? 20.0f : 0.1f;
    return scene;
}

// Placement 1 mirrors, 2 is hidden in some frames.
static RfMat4 matrix_of( int placement, float time )
{
    RfMat4 m = placing_matrix( placement == 1 ? PLACED_MIRRORED : PLACED_TURNED, (int)( 10.0f * time ) + 7 * placement );
    for ( int c = 12; c < 15; ++c )
        m.m[c] *= 0.2;
    return m;
}

static void pose_lamps( RfScene* posed, int frame, float time )
{
    const float dimmer[FRAMES] = { 0.2f, 1.0f, 0.5f, 0.7f, 0.0f };
    RfPunctual* p = posed->punctuals;
    p[DIMMED].intensity = rf_scale( p[DIMMED].intensity, dimmer[frame] );
    p[ALIKE].intensity = rf_scale( rf_vec3( 0.3f, 0.0f, 1.7f ), dimmer[frame] );
    p[MOVED].position = rf_vec3( 3.0f * time - 1.5f, 2.0f, 0.5f );
    p[MOVED].direction = rf_normalize( rf_vec3( time - 0.5f, -1, 0.2f ) );
    p[SWITCHED].intensity = frame < 2 ? rf_vec3( 0, 0, 0 ) : p[SWITCHED].intensity;
    p[SWITCHED].position.x += frame < 2 ? time : 0.0f;
    p[DARK].intensity = rf_vec3( 0, 0, 0 );
    p[SUN].direction = rf_normalize( rf_vec3( time - 0.5f, -1, 0.3f ) );
    p[COLOURED].intensity = rf_vec3( 2.0f, 1.0f + time, 3.0f - 2.0f * time );
    p[WEAK].intensity = rf_scale( p[WEAK].intensity, 1.0f - 0.5f * time );
    for ( int i = FAINT; i < LAMPS; ++i )
        p[i].intensity = rf_scale( p[i].intensity, 1.0f / ( 1.0f + time * (float)( i - FAINT + 2 ) ) );
}

static void pose( const RfScene* loaded, SkyKind sky, int frame, RfScene* posed )
{
    float time = (float)frame / FRAMES;
    *posed = *loaded;
    posed->materials = malloc( MATERIALS * sizeof *posed->materials );
    memcpy( posed->materials, loaded->materials, MATERIALS * sizeof *posed->materials );
    posed->materials[DIMS].emission = rf_vec3( 3.0f - (float)frame / 3.0f, 2.0f, (float)frame / 2.0f );
    posed->materials[DIMS_MOVED].emission = rf_vec3( 1.0f + (float)frame / 5.0f, 1.0f, 1.0f );
    posed->materials[SETTLED].emission = rf_vec3( 1.5f, 1.5f, 1.5f );
    posed->punctuals = malloc( LAMPS * sizeof *posed->punctuals );
    memcpy( posed->punctuals, loaded->punctuals, LAMPS * sizeof *posed->punctuals );
    pose_lamps( posed, frame, time );
    posed->placements = malloc( 3 * sizeof *posed->placements );
    memcpy( posed->placements, loaded->placements, 3 * sizeof *posed->placements );
    for ( int i = 0; i < 3; ++i )
        posed->placements[i].matrix = matrix_of( i, time );
    posed->placements[2].shown = frame < 3;
    posed->environment.rotation = sky == SKY_TURNS ? 2.0f * time : 0.0f;
    if ( sky == SKY_DIMS )
        posed->environment.radiance = rf_scale( loaded->environment.radiance, frame == 1 ? 0.0f : 0.3f + time );
}

static World* make_world( SkyKind sky )
{
    World* w = calloc( 1, sizeof *w );
    RfError error;
    w->loaded = load( sky );
    assert_int_equal( rf_collect_lights( &w->loaded, &w->still, &error ), RF_OK );
    for ( int i = 0; i < FRAMES; ++i )
    {
        pose( &w->loaded, sky, i, w->posed + i );
        rf_note_emission( &w->still, w->posed + i, w->emission[i] );
        w->frame[i] = ( RfLitFrame ){ w->posed + i, w->emission[i] };
    }
    return w;
}

static void free_world( World* w )
{
    for ( int i = 0; i < FRAMES; ++i )
    {
        free( w->posed[i].materials );
        free( w->posed[i].punctuals );
        free( w->posed[i].placements );
    }
    rf_destroy_lights( &w->still );
    rf_destroy_scene( &w->loaded );
    free( w );
}

static RfGroupLights* group_of( const World* w )
{
    RfGroupLights* group;
    RfError error;
    assert_int_equal( rf_create_group_lights( &w->still, &w->loaded, FRAMES, w->frame, &group, &error ), RF_OK );
    return group;
}

static RfGroupLights* parts_of( const World* w )
{
    RfGroupLights* group;
    RfError error;
    assert_int_equal( rf_create_group_parts( &w->still, &w->loaded, FRAMES, w->frame, &group, &error ), RF_OK );
    return group;
}

static uint32_t lamp_number( const RfLights* lights, int lamp ) { return lights->triangle_count + (uint32_t)lamp; }

static int part_of( const RfLights* lights, int lamp ) { return rf_light_part( lights, lamp_number( lights, lamp ) ); }

// ---- Parts

static bool is_dimmed( int part ) { return part > 0 && part <= RF_DIMMED_MOST; }

static void check_parts( const World* w, SkyKind sky, RfGroupLights* group )
{
    const RfLights* l = group->lights;
    assert_true( part_of( l, STILL ) == 0 && part_of( l, CONSTANT ) == 0 && part_of( l, DARK ) == 0 );
    assert_true( part_of( l, MOVED ) == RF_PART_OWN && part_of( l, SUN ) == RF_PART_OWN );
    assert_true( is_dimmed( part_of( l, DIMMED ) ) && part_of( l, ALIKE ) == part_of( l, DIMMED ) );
    assert_true( is_dimmed( part_of( l, SWITCHED ) ) && part_of( l, SWITCHED ) != part_of( l, DIMMED ) );
    assert_true( is_dimmed( part_of( l, COLOURED ) ) );
    assert_true( rf_material_part( l, DIMS_MOVED ) == RF_PART_OWN && rf_material_part( l, SETTLED ) == 0 );
    // 17 lamps or, with the sky, 18 are dimmed by dimmers of their own; the weakest are not parts
    assert_true( is_dimmed( rf_material_part( l, DIMS ) ) );
    assert_true( is_dimmed( part_of( l, FAINT + 1 ) ) == ( sky != SKY_DIMS ) && is_dimmed( part_of( l, WEAK ) ) );
    assert_true( part_of( l, FAINT ) == RF_PART_OWN && l->dimmed_count == RF_DIMMED_MOST && l->any_own && !l->all_own );
    assert_int_equal( l->frame_count, 0 );
    int of_sky[] = { [SKY_TURNS] = RF_PART_OWN, [SKY_STAYS] = 0 };
    if ( sky == SKY_DIMS )
        assert_true( is_dimmed( rf_light_part( l, rf_sky_number( l ) ) ) );
    else if ( sky != NO_SKY )
        assert_int_equal( rf_light_part( l, rf_sky_number( l ) ), of_sky[sky] );
    for ( uint32_t i = 0; i < l->triangle_count; ++i )
    {
        uint32_t material = rf_material_of( &w->loaded, l->light[i].triangle );
        bool moves = l->light[i].triangle >= w->loaded.placements[0].first;
        assert_int_equal( rf_light_part( l, i ), moves ? RF_PART_OWN : rf_material_part( l, (int32_t)material ) );
    }
    rf_destroy_group_lights( group );
}

TEST( test_parts )
{
    for ( SkyKind sky = NO_SKY; sky <= SKY_STAYS; ++sky )
    {
        World* w = make_world( sky );
        check_parts( w, sky, group_of( w ) );
        check_parts( w, sky, parts_of( w ) );
        free_world( w );
    }
}

static void assert_near( RfVec3 a, RfVec3 b )
{
    RfVec3 d = rf_sub( a, b );
    assert_true( rf_length( d ) <= 1e-6f * ( rf_length( a ) + rf_length( b ) ) );
}

// The reference times the scale is the lamp as it is, and no scale is above 1; frames alone have it as it is.
TEST( test_references_and_scales )
{
    World* w = make_world( SKY_DIMS );
    RfGroupLights* group = group_of( w );
    for ( int f = 0; f < FRAMES; ++f )
    {
        const RfLights* l = group->lights + f;
        const RfScene* posed = w->posed + f;
        for ( int p = 1; p <= l->dimmed_count; ++p )
            assert_true( rf_max_component( rf_part_scale( l, p ) ) <= 1.0f );
        for ( int k = 0; k < LAMPS; ++k )
        {
            RfVec3 scale = rf_part_scale( l, part_of( l, k ) );
            assert_near( rf_mul( scale, rf_punctual_light( l, lamp_number( l, k ) )->intensity ), posed->punctuals[k].intensity );
        }
        for ( uint32_t i = 0; i < w->still.changing->still_triangles; ++i )
        {
            int32_t material = (int32_t)rf_material_of( posed, l->light[i].triangle );
            RfVec3 scale = rf_part_scale( l, rf_light_part( l, i ) ), own = posed->materials[material].emission;
            assert_near( l->light[i].radiance, own ); // what hits look up
            for ( uint32_t k = 0; k < w->still.changing->dim_count; ++k )
                own = w->still.changing->dim[k] == (uint32_t)material ? w->emission[f][k] : own;
            assert_near( rf_mul( scale, l->light[i].radiance ), own );
        }
        RfVec3 sky = rf_part_scale( l, rf_light_part( l, rf_sky_number( l ) ) );
        assert_near( rf_mul( sky, l->sky.environment->radiance ), posed->environment.radiance );
    }
    rf_destroy_group_lights( group );
    for ( int f = 0; f < FRAMES; ++f )
    {
        RfError error;
        const RfScene* posed = w->posed + f;
        assert_int_equal( rf_create_group_lights( &w->still, &w->loaded, 1, w->frame + f, &group, &error ), RF_OK );
        const RfLights* l = group->lights;
        assert_true( l->part == NULL && l->dimmed_count == 0 );
        for ( int k = 0; k < LAMPS; ++k )
            assert_near( rf_punctual_light( l, lamp_number( l, k ) )->intensity, posed->punctuals[k].intensity );
        assert_near( posed->materials[DIMS].emission, rf_vec3( 3.0f - (float)f / 3.0f, 2.0f, (float)f / 2.0f ) );
        assert_int_equal( rf_has_sky( l ), f != 1 );
        rf_destroy_group_lights( group );
    }
    free_world( w );
}

// ---- Chances

static RfVec3 some_place( const RfLights* lights, uint32_t i )
{
    if ( i % 4 != 0 )
        return in_cube( 5, i, 4.0f );
    const RfLight* light = lights->light + ( i / 4 ) % lights->triangle_count;
    return rf_madd( rf_madd( light->p0, light->e1, number( 5, i, 3 ) ), direction( 5, i ), 1e-3f * number( 5, i, 4 ) );
}

// Does light leave a random point of the light towards x, and arrive above the horizon?
static bool can_send( const RfLights* lights, uint32_t k, RfVec3 x, RfVec3 n, uint32_t i )
{
    if ( k < lights->triangle_count )
    {
        const RfLight* light = lights->light + k;
        float root = sqrtf( number( 9, i, 0 ) ), b2 = number( 9, i, 1 ) * root;
        RfVec3 z = rf_madd( rf_madd( light->p0, light->e1, 1.0f - root ), light->e2, b2 ), way = rf_sub( z, x );
        float facing = -rf_dot( light->normal, way );
        return rf_max_component( light->radiance ) > 0.0f && rf_dot( n, way ) > 0.0f &&
               ( light->two_sided ? facing != 0.0f : facing > 0.0f );
    }
    if ( rf_has_sky( lights ) && k == rf_sky_number( lights ) )
        return true;
    const RfPunctual* p = rf_punctual_light( lights, k );
    RfVec3 way = p->kind == RF_PUNCTUAL_DIRECTIONAL ? rf_scale( p->direction, -1.0f ) : rf_sub( p->position, x );
    if ( p->kind == RF_PUNCTUAL_SPOT && !( -rf_dot( p->direction, rf_normalize( way ) ) > p->cos_outer ) )
        return false;
    return rf_max_component( p->intensity ) > 0.0f && rf_dot( n, way ) > 0.0f;
}

enum
{
    DRAWS = 400
};

static void check_chances( const RfGroupLights* group, RfLightSampling sampling, uint32_t i )
{
    const RfLights* first = group->lights;
    RfVec3 x = some_place( group->lights + i % FRAMES, i ), n = direction( 6, i );
    double sum = 0.0;
    for ( uint32_t k = 0; k < first->count; ++k )
    {
        float chance = rf_light_probability( first, sampling, k, x, n );
        sum += (double)chance;
        for ( int f = 0; f < FRAMES; ++f )
        {
            const RfLights* l = group->lights + f;
            assert_true( rf_light_probability( l, sampling, k, x, n ) == chance );
            if ( !( chance > 0.0f ) && can_send( l, k, x, n, i * 331 + k ) )
                fail_msg( "light %u can send light to %g %g %g in frame %d, and is never picked there", k, (double)x.x,
                          (double)x.y, (double)x.z, f );
        }
    }
    assert_true( rf_light_probability( first, sampling, lamp_number( first, DARK ), x, n ) == 0.0f );
    double lost = 0.0; // in descents that end without a light
    for ( uint32_t k = 0; k < DRAWS; ++k )
    {
        uint32_t bits[2] = { rf_random_bits( rf_pixel_key( 3, i ), k ), rf_random_bits( rf_pixel_key( 4, i ), k ) };
        RfLightSelection pick = select_light( first, sampling, x, n, bits );
        for ( int f = 1; f < FRAMES && k < 10; ++f )
        {
            RfLightSelection other = select_light( group->lights + f, sampling, x, n, bits );
            assert_true( other.light == pick.light && other.probability == pick.probability );
        }
        lost += pick.light == RF_NO_LIGHT;
        if ( pick.light != RF_NO_LIGHT )
        {
            double told = (double)rf_light_probability( first, sampling, pick.light, x, n );
            assert_true( fabs( told / (double)pick.probability - 1.0 ) < 1e-5 );
        }
    }
    lost /= DRAWS;
    assert_true( sum < 1.0 + 1e-5 && fabs( 1.0 - sum - lost ) < 6.0 * sqrt( fabs( 1.0 - sum ) / DRAWS ) + 10.0 / DRAWS );
    assert_true( sampling == RF_LIGHTS_BY_TREE || fabs( sum - 1.0 ) < 1e-5 );
}

TEST( test_frames_share_chances )
{
    for ( SkyKind sky = NO_SKY; sky <= SKY_STAYS; ++sky )
    {
        World* w = make_world( sky );
        RfGroupLights* group = group_of( w );
        for ( uint32_t i = 0; i < 400; ++i )
        {
            check_chances( group, RF_LIGHTS_BY_TREE, i );
            check_chances( group, RF_LIGHTS_BY_POWER, i );
        }
        rf_destroy_group_lights( group );
        free_world( w );
    }
}

// ---- Samples

// A sample's irradiance from a light of this number, over its density given the light; without shadows.
static RfVec3 sample_light( const RfLights* lights, const RfScene* scene, uint32_t k, RfVec3 x, RfVec3 n, const float u[2],
                            const uint32_t bits[2] )
{
    if ( k < lights->triangle_count )
    {
        const RfLight* light = lights->light + k;
        float root = sqrtf( u[0] );
        RfVec3 z = rf_madd( rf_madd( light->p0, light->e1, 1.0f - root ), light->e2, u[1] * root ), way = rf_sub( z, x );
        float d2 = rf_dot( way, way );
        way = rf_normalize( way );
        float facing = -rf_dot( light->normal, way );
        facing = light->two_sided ? fabsf( facing ) : rf_maxf( facing, 0.0f );
        return rf_scale( rf_light_radiance( scene, light, 1.0f - root, u[1] * root ),
                         facing * rf_maxf( rf_dot( n, way ), 0.0f ) / ( d2 * light->pdf_area ) );
    }
    if ( rf_has_sky( lights ) && k == rf_sky_number( lights ) )
    {
        RfSkySample s = sample_sky_direction_at( &lights->sky, n, bits, u );
        return s.pdf_solid_angle > 0.0f
                   ? rf_scale( rf_sky_radiance( &lights->sky, s.wi ), rf_maxf( rf_dot( n, s.wi ), 0.0f ) / s.pdf_solid_angle )
                   : rf_vec3( 0, 0, 0 );
    }
    const RfPunctual* p = rf_punctual_light( lights, k );
    if ( p->kind == RF_PUNCTUAL_DIRECTIONAL )
        return rf_scale( p->intensity, rf_maxf( -rf_dot( n, p->direction ), 0.0f ) );
    RfVec3 way = rf_sub( p->position, x );
    float d2 = rf_dot( way, way );
    way = rf_normalize( way );
    return rf_scale( p->intensity, rf_spot_falloff( p, -rf_dot( p->direction, way ) ) * rf_maxf( rf_dot( n, way ), 0.0f ) / d2 );
}

static double channel_of( RfVec3 v, int c ) { return (double)( c == 0 ? v.x : c == 1 ? v.y : v.z ); }

enum
{
    SAMPLES = 4000
};

// The scene of a frame that knows of no movement.
static RfScene still_scene( const World* w, int at )
{
    RfScene scene = w->posed[at];
    SceneBuilder b = { 0 };
    for ( uint32_t i = 0; i < rf_triangle_count( &scene ); ++i )
    {
        RfTriangleAt on = rf_locate_triangle( &scene, i );
        bool mirrors = on.placement != NULL && rf_mat4_det3( &on.placement->matrix ) < 0.0;
        RfVec3 p[3];
        for ( int k = 0; k < 3; ++k )
            p[k] = rf_triangle_corner( &scene, i, k );
        if ( on.placement == NULL || on.placement->shown )
            add_quad( &b, rf_material_of( &scene, i ), p[0], p[mirrors ? 2 : 1], p[mirrors ? 1 : 2], p[mirrors ? 1 : 2] );
    }
    RfScene out = finish_scene( &b );
    for ( uint32_t m = 0; m < MATERIALS; ++m )
        scene.materials[m].dims = false;
    out.materials = scene.materials;
    out.material_count = MATERIALS;
    out.punctuals = scene.punctuals;
    out.punctual_count = LAMPS;
    out.environment = scene.environment;
    out.environment.changes = false;
    return out;
}

// Every light on its own, in the still scene of a frame.
static Sample brute_force( const RfLights* lights, const RfScene* scene, RfVec3 x, RfVec3 n, int c, uint32_t stream )
{
    Sample all = { SAMPLES, 0.0, 0.0 };
    for ( uint32_t k = 0; k < lights->count; ++k )
    {
        double sum = 0.0, squares = 0.0;
        int count = SAMPLES / 10;
        for ( int i = 0; i < count; ++i )
        {
            RfRandomKey key = rf_pixel_key( rf_pass_key( 31, stream, k, 0 ), (uint32_t)i );
            float u[2] = { rf_random( key, 0 ), rf_random( key, 1 ) };
            uint32_t bits[2] = { rf_random_bits( key, 2 ), rf_random_bits( key, 3 ) };
            double v = channel_of( sample_light( lights, scene, k, x, n, u, bits ), c );
            sum += v;
            squares += v * v;
        }
        double mean = sum / count;
        all.mean += mean;
        all.variance += fmax( squares / count - mean * mean, 0.0 ) / ( count - 1 );
    }
    return all;
}

static Sample by_selection( const RfLights* lights, const RfScene* scene, RfVec3 x, RfVec3 n, int c, uint32_t stream )
{
    double sum = 0.0, squares = 0.0;
    for ( int i = 0; i < SAMPLES; ++i )
    {
        RfRandomKey key = rf_pixel_key( rf_pass_key( 37, stream, 0, 0 ), (uint32_t)i );
        float u[2] = { rf_random( key, 0 ), rf_random( key, 1 ) };
        uint32_t bits[2] = { rf_random_bits( key, 2 ), rf_random_bits( key, 3 ) },
                 pick[2] = { rf_random_bits( key, 4 ), rf_random_bits( key, 5 ) };
        RfLightSelection s = select_light( lights, RF_LIGHTS_BY_TREE, x, n, pick );
        if ( s.light == RF_NO_LIGHT )
            continue;
        RfVec3 light = rf_mul( sample_light( lights, scene, s.light, x, n, u, bits ),
                               rf_part_scale( lights, rf_light_part( lights, s.light ) ) );
        double v = channel_of( light, c ) / (double)s.probability;
        sum += v;
        squares += v * v;
    }
    double mean = sum / SAMPLES;
    return ( Sample ){ SAMPLES, mean, ( squares / SAMPLES - mean * mean ) / ( SAMPLES - 1 ) };
}

TEST( test_samples_have_the_mean_of_still_scenes )
{
    enum
    {
        PLACES = 8
    };
    for ( SkyKind sky = NO_SKY; sky <= SKY_STAYS; ++sky )
    {
        World* w = make_world( sky );
        double least = 1.0;
        Sample truth[FRAMES][PLACES];
        for ( int f = 0; f < FRAMES; ++f )
        {
            AUTO_SCENE scene = still_scene( w, f );
            AUTO_BY( rf_destroy_lights ) RfLights lights;
            RfError error;
            assert_int_equal( rf_collect_lights( &scene, &lights, &error ), RF_OK );
            assert_null( lights.changing );
            for ( uint32_t i = 0; i < PLACES; ++i )
                truth[f][i] = brute_force( &lights, &scene, in_cube( 11, i, 2.0f ), direction( 12, i ), (int)( i % 3 ), i );
            scene.materials = NULL;
            scene.material_count = 0;
            scene.punctuals = NULL;
            scene.punctual_count = 0;
            scene.environment.map = NULL;
        }
        RfGroupLights* group = group_of( w );
        for ( int f = 0; f < FRAMES; ++f )
        {
            for ( uint32_t i = 0; i < PLACES; ++i )
            {
                Sample s = by_selection( group->lights + f, w->posed + f, in_cube( 11, i, 2.0f ), direction( 12, i ),
                                         (int)( i % 3 ), i );
                double p = welch_of( s, truth[f][i] );
                least = fmin( least, p );
                assert_true( is_likely( p ) && s.variance < 0.01 * s.mean * s.mean );
            }
        }
        printf( "sky %d: least p %.3g of %d\n", (int)sky, least, FRAMES * PLACES );
        rf_destroy_group_lights( group );
        free_world( w );
    }
}

// ---- Few lights, and none

TEST( test_few_lights )
{
    SceneBuilder b = { 0 };
    add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    add_box( &b, 0, rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), true );
    AUTO_SCENE scene = finish_scene( &b );
    scene.punctual_count = 2;
    scene.punctuals = calloc( 2, sizeof *scene.punctuals );
    scene.punctuals[0] = make_point_light( rf_vec3( 0, 0, 0 ), 0.0f ); // dark in the first frame
    scene.punctuals[1] = make_point_light( rf_vec3( 0, 0.5f, 0 ), 0.0f );
    scene.punctuals[0].changes = scene.punctuals[1].changes = true;
    scene.movement = calloc( 1, sizeof *scene.movement );
    AUTO_BY( rf_destroy_lights ) RfLights still;
    RfGroupLights* group;
    RfError error;
    assert_int_equal( rf_collect_lights( &scene, &still, &error ), RF_OK );
    assert_int_equal( still.count, 2 ); // it has lights, at some time
    RfPunctual own[2][2];
    RfScene posed[2] = { scene, scene };
    RfLitFrame frame[2];
    for ( int f = 0; f < 2; ++f )
    {
        memcpy( own[f], scene.punctuals, sizeof own[f] );
        own[f][0].intensity = rf_vec3( (float)f, (float)f, (float)f );
        posed[f].punctuals = own[f];
        frame[f] = ( RfLitFrame ){ posed + f, NULL };
    }
    RfVec3 x = rf_vec3( 0, -0.5f, 0 ), n = rf_vec3( 0, 1, 0 );
    assert_int_equal( rf_create_group_lights( &still, &scene, 2, frame, &group, &error ), RF_OK );
    for ( int f = 0; f < 2; ++f )
    {
        const RfLights* l = group->lights + f;
        assert_true( rf_light_probability( l, RF_LIGHTS_BY_TREE, 0, x, n ) == 1.0f );
        assert_true( rf_light_part( l, 0 ) == 1 && rf_light_part( l, 1 ) == 0 && l->part_scale[1].x == (float)f );
        assert_true( !l->any_own && !l->all_own );
    }
    rf_destroy_group_lights( group );
    own[0][0].position.y = -0.1f;
    own[0][0].intensity = rf_vec3( 1, 2, 3 );
    assert_int_equal( rf_create_group_lights( &still, &scene, 2, frame, &group, &error ), RF_OK );
    assert_true( rf_light_part( group->lights, 0 ) == RF_PART_OWN && group->lights->any_own && group->lights->all_own );
    for ( int f = 0; f < 2; ++f ) // nothing else moves
    {
        const RfLights* l = group->lights + f;
        assert_true( l->frame_count == 2 && l->dimmed_count == 0 );
        assert_true( l->part_scale[1].x == ( f == 0 ? 1.0f : 0.0f ) && l->part_scale[2].y == ( f == 1 ? 1.0f : 0.0f ) );
    }
    rf_destroy_group_lights( group );
    scene.placement_count += 1; // something does
    assert_int_equal( rf_create_group_lights( &still, &scene, 2, frame, &group, &error ), RF_OK );
    assert_true( group->lights->frame_count == 0 && group->lights->all_own );
    scene.placement_count -= 1;
    rf_destroy_group_lights( group );
    own[0][0] = scene.punctuals[0];
    assert_int_equal( rf_create_group_lights( &still, &scene, 1, frame, &group, &error ), RF_OK );
    assert_int_equal( group->lights->count, 0 ); // in the dark
    assert_true( rf_light_probability( group->lights, RF_LIGHTS_BY_TREE, 0, x, n ) == 0.0f );
    rf_destroy_group_lights( group );
}

// ---- Tracers

TEST( test_triangles_that_move_are_lights_of_tracers )
{
    World* w = make_world( NO_SKY );
    RfTracer *still = make_tracer( &w->loaded ), *tracer[FRAMES];
    RfGroupLights* group = group_of( w );
    RfError error;
    uint32_t lights = 0;
    for ( int f = 0; f < FRAMES; ++f )
    {
        assert_int_equal( rf_create_posed_tracer( still, w->posed + f, tracer + f, &error ), RF_OK );
        rf_set_lights( tracer[f], group->lights + f );
        const RfLights* l = rf_tracer_lights( tracer[f] );
        for ( uint32_t i = 0; i < rf_triangle_count( &w->loaded ); ++i )
        {
            uint32_t number = rf_triangle_light( tracer[f], i );
            RfTriangleRecord place;
            assert_int_equal( rf_triangle_record( tracer[f], i, &place )->light, number );
            if ( number == RF_NO_LIGHT )
                continue;
            const RfLight* light = l->light + number;
            const RfTriangleRecord* t = rf_triangle_record( tracer[f], i, &place );
            bool hidden = i >= w->loaded.placements[2].first && f >= 3;
            assert_int_equal( light->triangle, i );
            assert_true( hidden == ( rf_max_component( light->radiance ) == 0.0f ) );
            lights += !hidden;
            if ( hidden )
                continue;
            assert_true( t->p0.x == light->p0.x && t->e1.y == light->e1.y && t->offset == light->offset );
            assert_true( rf_dot( t->ng, light->normal ) > 0.9999f );
        }
    }
    assert_int_equal( lights, FRAMES * ( 48 + 12 ) + 3 * 6 );
    for ( int f = 0; f < FRAMES; ++f )
        rf_destroy_tracer( tracer[f] );
    rf_destroy_group_lights( group );
    rf_destroy_tracer( still );
    free_world( w );
}

int main( void )
{
    rf_set_float_mode();
    return run_listed_tests();
}
