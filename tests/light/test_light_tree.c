// The light tree: probabilities that sum to one, samples that follow them, and
// probabilities above 0 wherever light could arrive.
#include "base/random.h"
#include "light/extent.h"
#include "light/light.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/select_light.h"

static float number( uint32_t stream, uint32_t i, uint32_t dimension )
{
    return rf_random( rf_pixel_key( rf_pass_key( 11, stream, 0, 0 ), i ), dimension );
}

static RfVec3 direction( uint32_t stream, uint32_t i, uint32_t dimension )
{
    float z = 2.0f * number( stream, i, dimension ) - 1.0f, phi = 2.0f * RF_PI * number( stream, i, dimension + 1 );
    float r = sqrtf( rf_maxf( 1.0f - z * z, 0.0f ) );
    return rf_vec3( r * cosf( phi ), r * sinf( phi ), z );
}

static RfVec3 in_cube( uint32_t stream, uint32_t i, uint32_t dimension, float half )
{
    float c[3];
    for ( uint32_t k = 0; k < 3; ++k )
        c[k] = half * ( 2.0f * number( stream, i, dimension + k ) - 1.0f );
    return rf_vec3( c[0], c[1], c[2] );
}

// What a scene of lights is made of.
typedef struct Mix
{
    const char* name;
    int quads;
    float least, most; // sides, spread evenly over their logarithm
    bool two_sided;    // every second one
    bool flat;         // all of them in one plane, facing down
    bool together;     // all at one place
    int points, spots, suns;
    bool sky, map;
} Mix;

static const Mix s_mixes[] = {
    { .name = "one lamp and a sky", .quads = 1, .least = 1, .most = 1, .sky = true },
    { .name = "one point", .points = 1, .sky = true, .suns = 1 },
    { .name = "ceiling", .quads = 200, .least = 0.2f, .most = 0.2f, .flat = true },
    { .name = "huge and tiny", .quads = 100, .least = 1e-5f, .most = 30.0f },
    { .name = "two-sided", .quads = 60, .least = 0.1f, .most = 1.0f, .two_sided = true },
    { .name = "together", .quads = 40, .least = 0.5f, .most = 0.5f, .together = true },
    { .name = "points together", .points = 300, .together = true },
    { .name = "narrow spots", .spots = 300 },
    { .name = "of all kinds",
      .quads = 50,
      .least = 1e-3f,
      .most = 5.0f,
      .two_sided = true,
      .points = 30,
      .spots = 30,
      .suns = 3,
      .sky = true,
      .map = true },
};
enum
{
    MIXES = sizeof s_mixes / sizeof s_mixes[0]
};

static void add_lamp( SceneBuilder* b, const Mix* mix, uint32_t i, const uint32_t material[2] )
{
    float side = mix->least * powf( mix->most / mix->least, number( 1, i, 0 ) );
    RfVec3 t, s, n = mix->flat ? rf_vec3( 0, -1, 0 ) : direction( 1, i, 1 ), p = in_cube( 1, i, 3, 10.0f );
    p = mix->together ? rf_vec3( 1, 2, 3 ) : p;
    p.y = mix->flat ? 3.0f : p.y;
    rf_basis( n, &t, &s );
    t = rf_scale( t, side );
    s = rf_scale( s, side );
    add_quad( b, material[mix->two_sided ? i % 2 : 0], p, rf_add( p, t ), rf_add( rf_add( p, t ), s ), rf_add( p, s ) );
}

static RfPunctual make_spot( uint32_t i )
{
    RfPunctual spot = make_point_light( in_cube( 2, i, 0, 10.0f ), 1.0f + 20.0f * number( 2, i, 3 ) );
    float outer = 0.002f + 1.55f * powf( number( 2, i, 4 ), 4.0f );
    spot.kind = RF_PUNCTUAL_SPOT;
    spot.direction = direction( 2, i, 5 );
    spot.cos_outer = rf_maxf( cosf( outer ), 0.0f );
    spot.cos_inner = i % 3 == 0 ? spot.cos_outer : cosf( outer * number( 2, i, 7 ) );
    spot.radius = i % 4 == 1 ? number( 2, i, 8 ) : 0.0f;
    return spot;
}

static RfPunctual make_plane( RfPunctual plane, uint32_t i )
{
    RfVec3 t;
    plane.kind = RF_PUNCTUAL_PLANE;
    plane.direction = direction( 3, i, 4 );
    rf_basis( plane.direction, &plane.across, &t );
    plane.half[0] = 0.01f + number( 3, i, 6 );
    plane.half[1] = 0.01f + number( 3, i, 7 );
    plane.tan_spread = i % 2 == 0 ? 3.0f * number( 3, i, 8 ) : 0.0f;
    plane.spread_scale = 1.0f;
    return plane;
}

static RfScene make_scene( const Mix* mix )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    uint32_t lamps[2] = { add_material( &b, make_light( 5.0f, false ) ), add_material( &b, make_light( 3.0f, true ) ) };
    add_box( &b, grey, rf_vec3( -12, -12, -12 ), rf_vec3( 12, 12, 12 ), true );
    for ( int i = 0; i < mix->quads; ++i )
        add_lamp( &b, mix, (uint32_t)i, lamps );
    RfScene scene = finish_scene( &b );
    int count = mix->points + mix->spots + mix->suns;
    scene.punctuals = calloc( (size_t)count + 1, sizeof *scene.punctuals );
    for ( int i = 0; i < mix->points; ++i )
    {
        RfPunctual point =
            make_point_light( mix->together ? rf_vec3( 1, 1, 1 ) : in_cube( 3, (uint32_t)i, 0, 11.0f ), 1.0f + (float)i );
        scene.punctuals[scene.punctual_count++] = i % 3 == 1 ? make_plane( point, (uint32_t)i ) : point;
        scene.punctuals[i].radius = i % 3 == 2 ? 2.0f * number( 3, (uint32_t)i, 9 ) : 0.0f;
    }
    for ( int i = 0; i < mix->spots; ++i )
        scene.punctuals[scene.punctual_count++] = make_spot( (uint32_t)i );
    for ( int i = 0; i < mix->suns; ++i )
    {
        RfPunctual sun = make_point_light( rf_vec3( 0, 0, 0 ), 3.0f );
        sun.kind = RF_PUNCTUAL_DIRECTIONAL;
        sun.direction = direction( 4, (uint32_t)i, 0 );
        sun.versine = i == 1 ? 0.3f : 0.0f;
        scene.punctuals[scene.punctual_count++] = sun;
    }
    if ( mix->sky )
        scene.environment.radiance = rf_vec3( 0.2f, 0.3f, 0.4f );
    if ( mix->map )
    {
        scene.environment.width = 8;
        scene.environment.height = 4;
        scene.environment.map = malloc( 3 * 8 * 4 * sizeof( float ) );
        for ( int i = 0; i < 3 * 8 * 4; ++i )
            scene.environment.map[i] = i == 30 ? 50.0f : 0.01f;
    }
    return scene;
}

static RfLights collect( const RfScene* scene )
{
    RfLights lights;
    RfError error;
    assert_int_equal( rf_collect_lights( scene, &lights, &error ), RF_OK );
    return lights;
}

// Where nothing is found at the bottom of the tree: the chance of that, by
// going all the ways.
static double dead_ends( const RfLights* lights, uint32_t number_of, RfVec3 x, RfVec3 n, double chance, double extra )
{
    const RfLightNode* node = lights->tree.nodes + number_of;
    float weight[RF_LIGHT_CHILDREN];
    rf_light_importance( node, rf_scale( rf_sub( x, lights->center ), lights->inverse_radius ), n, weight );
    double sum = extra, lost = 0.0;
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
        sum += (double)weight[k];
    if ( sum == 0.0 )
        return chance;
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
    {
        if ( weight[k] > 0.0f && !( node->child[k] & RF_LIGHT_LEAF ) )
            lost += dead_ends( lights, node->child[k], x, n, chance * (double)weight[k] / sum, 0.0 );
    }
    return lost;
}

static RfVec3 some_place( const RfLights* lights, uint32_t i )
{
    // every fourth one right at a light
    if ( i % 4 == 0 && lights->triangle_count > 0 )
    {
        const RfLight* light = lights->light + ( i / 4 ) % lights->triangle_count;
        return rf_madd( rf_madd( light->p0, light->e1, number( 5, i, 3 ) ), direction( 5, i, 6 ), 1e-4f * number( 5, i, 4 ) );
    }
    return in_cube( 5, i, 0, 12.0f );
}

static void check_sums( const Mix* mix )
{
    AUTO_SCENE scene = make_scene( mix );
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    assert_true( lights.tree.node_count > 0 );
    double most_lost = 0.0;
    for ( uint32_t i = 0; i < 400; ++i )
    {
        RfVec3 x = some_place( &lights, i ), n = direction( 6, i, 0 );
        float sky = rf_has_sky( &lights ) ? rf_sky_irradiance_estimate( &lights.sky, n ) * lights.sky_scale : 0.0f;
        double sum = 0.0, lost = dead_ends( &lights, 0, x, n, 1.0, (double)sky );
        for ( uint32_t k = 0; k < lights.count; ++k )
        {
            float chance = rf_light_probability( &lights, RF_LIGHTS_BY_TREE, k, x, n );
            assert_true( chance >= 0.0f && chance <= 1.0f );
            sum += (double)chance;
        }
        most_lost = lost > most_lost && lost < 1.0 ? lost : most_lost;
        if ( !( fabs( sum + lost - 1.0 ) < 1e-6 ) )
            fail_msg( "%s: at %g %g %g the chances sum up to %.9f, and %.3g is lost", mix->name, (double)x.x, (double)x.y,
                      (double)x.z, sum, lost );
    }
    printf( "%-20s %5u lights, at most %.2g lost\n", mix->name, lights.count, most_lost );
}

TEST( test_chances_sum_up )
{
    for ( int k = 0; k < MIXES; ++k )
        check_sums( s_mixes + k );
}

// Picks against chances, at one place: χ² over the lights that are expected
// often enough, and each pick's own chance is the one told.
static double check_picks( const RfLights* lights, RfVec3 x, RfVec3 n, uint32_t stream )
{
    enum
    {
        PICKS = 100000
    };
    AUTO_FREE double* count = calloc( (size_t)lights->count + 1, sizeof *count );
    assert_non_null( count );
    for ( uint32_t i = 0; i < PICKS; ++i )
    {
        RfRandomKey key = rf_pixel_key( rf_pass_key( 17, stream, 0, 0 ), i );
        uint32_t bits[2] = { rf_random_bits( key, 0 ), rf_random_bits( key, 1 ) };
        RfLightSelection pick = select_light( lights, RF_LIGHTS_BY_TREE, x, n, bits );
        assert_true( pick.light < lights->count || pick.light == RF_NO_LIGHT );
        count[pick.light == RF_NO_LIGHT ? lights->count : pick.light] += 1.0;
        if ( i < 100 && pick.light != RF_NO_LIGHT )
        {
            double chance = (double)rf_light_probability( lights, RF_LIGHTS_BY_TREE, pick.light, x, n );
            assert_true( chance > 0.0 && fabs( chance / (double)pick.probability - 1.0 ) < 1e-6 );
        }
    }
    double chi_square = 0.0, rest = PICKS, rest_count = PICKS, terms = 0.0;
    for ( uint32_t k = 0; k < lights->count; ++k )
    {
        double expected = PICKS * (double)rf_light_probability( lights, RF_LIGHTS_BY_TREE, k, x, n );
        if ( expected == 0.0 )
            assert_true( count[k] == 0.0 );
        if ( expected < 10.0 )
            continue;
        chi_square += ( count[k] - expected ) * ( count[k] - expected ) / expected;
        rest -= expected;
        rest_count -= count[k];
        terms += 1.0;
    }
    if ( rest > 10.0 )
    {
        chi_square += ( rest_count - rest ) * ( rest_count - rest ) / rest;
        terms += 1.0;
    }
    return terms > 1.0 ? chi_square_p( chi_square, terms - 1.0 ) : -1.0;
}

TEST( test_picks_keep_to_chances )
{
    enum
    {
        PLACES = 8
    };
    double p[MIXES * PLACES];
    int count = 0;
    for ( int k = 0; k < MIXES; ++k )
    {
        AUTO_SCENE scene = make_scene( s_mixes + k );
        AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
        for ( uint32_t i = 0; i < PLACES; ++i )
        {
            double one = check_picks( &lights, some_place( &lights, i ), direction( 7, i, 0 ), (uint32_t)k * PLACES + i );
            if ( one >= 0.0 )
                p[count++] = one;
        }
    }
    double least = 1.0;
    for ( int i = 0; i < count; ++i )
        least = fmin( least, p[i] );
    double uniform = uniform_p( p, count );
    printf( "%d places: least p %.3g, all of them uniform p %.3g\n", count, least, uniform );
    assert_true( count > MIXES && least > 1e-5 && uniform > 1e-3 );
}

TEST( test_batches_equal_single_picks )
{
    enum
    {
        COUNT = 1000
    };
    static float x[3][COUNT], n[3][COUNT];
    static uint32_t bits[2][COUNT];
    static RfLightSelection pick[COUNT];
    AUTO_SCENE scene = make_scene( s_mixes + MIXES - 1 );
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    for ( uint32_t i = 0; i < COUNT; ++i )
    {
        RfVec3 p = some_place( &lights, i ), d = direction( 8, i, 0 );
        float a[3] = { p.x, p.y, p.z }, b[3] = { d.x, d.y, d.z };
        for ( int c = 0; c < 3; ++c )
        {
            x[c][i] = a[c];
            n[c][i] = b[c];
        }
        bits[0][i] = rf_random_bits( rf_pixel_key( 3, i ), 0 );
        bits[1][i] = rf_random_bits( rf_pixel_key( 3, i ), 1 );
    }
    bits[0][5] = bits[1][5] = UINT32_MAX;
    bits[0][6] = bits[1][6] = 0;
    for ( int way = 0; way < 2; ++way )
    {
        RfLightSampling picking = way == 0 ? RF_LIGHTS_BY_TREE : RF_LIGHTS_BY_POWER;
        const float *xs[3] = { x[0], x[1], x[2] }, *ns[3] = { n[0], n[1], n[2] };
        const uint32_t* words[2] = { bits[0], bits[1] };
        rf_select_lights( &lights, picking, COUNT, xs, ns, words, pick );
        for ( int i = 0; i < COUNT; ++i )
        {
            uint32_t own[2] = { bits[0][i], bits[1][i] };
            RfLightSelection one =
                select_light( &lights, picking, rf_vec3( x[0][i], x[1][i], x[2][i] ), rf_vec3( n[0][i], n[1][i], n[2][i] ), own );
            assert_true( one.light == pick[i].light && one.probability == pick[i].probability );
        }
    }
}

// Does light leave a random point of the light towards x, and arrive above the horizon?
static bool can_send( const RfLights* lights, uint32_t k, RfVec3 x, RfVec3 n, uint32_t i )
{
    if ( k < lights->triangle_count )
    {
        const RfLight* light = lights->light + k;
        float root = sqrtf( number( 9, i, 0 ) ), b2 = number( 9, i, 1 ) * root;
        RfVec3 z = rf_add( light->p0, rf_add( rf_scale( light->e1, 1.0f - root ), rf_scale( light->e2, b2 ) ) ),
               way = rf_sub( z, x );
        float facing = -rf_dot( light->normal, way );
        return rf_dot( n, way ) > 0.0f && ( light->two_sided ? facing != 0.0f : facing > 0.0f );
    }
    if ( (int)( k - lights->triangle_count ) == lights->punctual_count )
        return true;
    const RfPunctual* p = lights->punctual + ( k - lights->triangle_count );
    float u[2] = { number( 9, i, 0 ), number( 9, i, 1 ) };
    if ( p->kind == RF_PUNCTUAL_PLANE || p->radius > 0.0f || p->versine > 0.0f )
    {
        RfExtentSample s = p->kind == RF_PUNCTUAL_PLANE         ? rf_sample_plane( p, x, u )
                           : p->kind == RF_PUNCTUAL_DIRECTIONAL ? rf_sample_sun( p, u )
                                                                : rf_sample_ball( p, x, u );
        bool shines = p->kind != RF_PUNCTUAL_SPOT || -rf_dot( p->direction, s.wi ) > p->cos_outer;
        return s.weight > 0.0f && shines && rf_dot( n, s.wi ) > 0.0f;
    }
    RfVec3 way = p->kind == RF_PUNCTUAL_DIRECTIONAL ? rf_scale( p->direction, -1.0f ) : rf_sub( p->position, x );
    if ( p->kind == RF_PUNCTUAL_SPOT && !( -rf_dot( p->direction, rf_normalize( way ) ) > p->cos_outer ) )
        return false;
    return rf_dot( n, way ) > 0.0f;
}

static void check_reach( const Mix* mix )
{
    AUTO_SCENE scene = make_scene( mix );
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    long sends = 0, idle = 0;
    for ( uint32_t i = 0; i < 3000; ++i )
    {
        RfVec3 x = some_place( &lights, i ), n = direction( 10, i, 0 );
        for ( uint32_t k = 0; k < lights.count; ++k )
        {
            bool sent = can_send( &lights, k, x, n, i * 331 + k );
            float chance = rf_light_probability( &lights, RF_LIGHTS_BY_TREE, k, x, n );
            if ( sent && !( chance > 0.0f ) )
                fail_msg( "%s: light %u can send light to %g %g %g and is never picked there", mix->name, k, (double)x.x,
                          (double)x.y, (double)x.z );
            sends += sent;
            idle += !sent && chance == 0.0f;
        }
    }
    printf( "%-20s %8ld times above 0, %8ld times 0\n", mix->name, sends, idle );
    assert_true( sends > 100 && ( lights.count < 10 || idle > 100 ) );
}

TEST( test_all_that_can_send_are_picked )
{
    for ( int k = 0; k < MIXES; ++k )
        check_reach( s_mixes + k );
}

// Each light once, on a way from the root that the places tell; the depth grows
// with the logarithm.
TEST( test_each_light_once_at_logarithmic_depth )
{
    for ( int quads = 2; quads <= 20000; quads *= 10 )
    {
        Mix mix = { .name = "shape", .quads = quads, .least = 1e-4f, .most = 3.0f };
        AUTO_SCENE scene = make_scene( &mix );
        AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
        const RfLightTree* tree = &lights.tree;
        double depth = 0.0, most = 0.0;
        for ( uint32_t i = 0; i < lights.count; ++i )
        {
            uint32_t place = tree->leaf_slot[i], child = RF_LIGHT_LEAF | i;
            double levels = 1.0;
            for ( ;; levels += 1.0 )
            {
                uint32_t node = place / RF_LIGHT_CHILDREN;
                assert_true( node < tree->node_count && tree->nodes[node].child[place % RF_LIGHT_CHILDREN] == child );
                assert_true( tree->nodes[node].intensity[place % RF_LIGHT_CHILDREN] > 0.0f );
                if ( node == 0 )
                    break;
                child = node;
                place = tree->parent_slot[node];
            }
            depth += levels / lights.count;
            most = fmax( most, levels );
        }
        printf( "%5u lights: depth %.2f, at most %.0f\n", lights.count, depth, most );
        assert_true( depth < 1.5 + 1.5 * log( (double)lights.count ) / log( 8.0 ) && most < 16.0 );
    }
}

// Light of the middle of a lamp, were it small.
static double middle_light( const RfLight* light, RfVec3 x, RfVec3 n )
{
    RfVec3 way = rf_sub( rf_madd( light->p0, rf_add( light->e1, light->e2 ), 1.0f / 3.0f ), x );
    double d2 = (double)rf_dot( way, way ), cos_x = (double)rf_dot( n, way ), cos_light = -(double)rf_dot( light->normal, way );
    if ( !( cos_x > 0.0 && cos_light > 0.0 ) )
        return 0.0;
    return (double)( light->area * rf_luminance( light->radiance ) ) * cos_x * cos_light / ( d2 * d2 );
}

// The relative variance of one pick's light / chance, below a ceiling of lamps:
// by the tree a small part of what it is by power.
TEST( test_picks_make_little_noise )
{
    Mix mix = { .quads = 200, .least = 0.2f, .most = 0.2f, .flat = true };
    AUTO_SCENE scene = make_scene( &mix );
    AUTO_BY( rf_destroy_lights ) RfLights lights = collect( &scene );
    double variance[2] = { 0.0 };
    for ( uint32_t i = 0; i < 300; ++i )
    {
        RfVec3 x = in_cube( 12, i, 0, 9.0f ), n = direction( 13, i, 0 );
        x.y = 2.8f - 4.0f * number( 12, i, 5 );
        n.y = fabsf( n.y );
        double sum = 0.0, squares[2] = { 0.0 };
        for ( uint32_t k = 0; k < lights.count; ++k )
        {
            double light = middle_light( lights.light + k, x, n );
            sum += light;
            if ( light == 0.0 )
                continue;
            squares[0] += light * light / (double)rf_light_probability( &lights, RF_LIGHTS_BY_TREE, k, x, n );
            squares[1] += light * light / (double)rf_light_probability( &lights, RF_LIGHTS_BY_POWER, k, x, n );
        }
        for ( int way = 0; way < 2; ++way )
            variance[way] += ( squares[way] / ( sum * sum ) - 1.0 ) / 300.0;
    }
    printf( "relative variance of a pick: %.3f by the tree, %.3f by power\n", variance[0], variance[1] );
    assert_true( variance[0] < 0.6 && variance[0] < 0.15 * variance[1] );
}
