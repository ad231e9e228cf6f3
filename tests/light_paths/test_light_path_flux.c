// The power that light paths carry to where they land, in closed form: also where light starts within a body of glass and ends
// outside, so that flux and radiance scale differently.
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"

#define RADIANCE 15.0f
#define MOST_SIGMAS 4.5

static double power_of( const RfTracer* tracer, uint32_t lamp )
{
    const RfScene* scene = rf_tracer_scene( tracer );
    const RfTriangleRecord* t = rf_tracer_records( tracer )->records;
    double area = 0.0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
        area += t[i].material == lamp ? 0.5 * (double)rf_length( rf_cross( t[i].e1, t[i].e2 ) ) : 0.0;
    return (double)RF_PI * (double)RADIANCE * area;
}

// `expected`: the part of the lamp's power that goes out without a reflection. `tint`: of thin bulbs around the glass and within it.
static void check_flux( const char* name, float inner, float outer, float tint, double expected )
{
    static LightPathSet set;
    SceneBuilder b = { 0 };
    RfVec3 center = rf_vec3( 0, 1.5f, 0 );
    uint32_t wall = add_material( &b, make_lambert( 0.8f, 0.75f, 0.7f ) ),
             lamp = add_material( &b, make_light( RADIANCE, false ) );
    uint32_t glass = add_material( &b, make_glass( 1.5f, 0.0f, false ) );
    add_box( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_sphere( &b, lamp, center, 0.02f, 32 );
    add_sphere( &b, glass, center, outer, 64 );
    if ( inner > 0.0f )
        add_sphere( &b, glass, center, -inner, 64 ); // facing in
    RfMaterial pane = make_glass( 1.5f, 0.0f, true );
    pane.tint = rf_vec3( 0.9f, tint, 0.2f );
    for ( int k = 0; k < 2 && tint > 0.0f; ++k )
        add_sphere( &b, add_material( &b, pane ), center, k == 0 ? 0.3f : 0.8f, 64 );
    AUTO_SCENE scene = finish_scene( &b );
    draw_light_path_set( &scene, 1024, 512, &set );
    int surfaces = inner > 0.0f ? 2 : 1;
    double power = power_of( set.tracer, lamp ), sum = 0.0, squares = 0.0, n = (double)set.paths->emitted;
    for ( uint32_t i = 0; i < set.paths->count; ++i )
    {
        const RfLightPath* path = set.paths->path + i;
        bool straight = path->length == surfaces && path->events == ( 1u << surfaces ) - 1u;
        double flux = straight ? (double)path->flux.y / power : 0.0;
        sum += flux;
        squares += flux * flux;
    }
    double mean = sum / n, sigma = sqrt( ( squares / n - mean * mean ) / n );
    printf( "%s: %.4f ± %.4f of the lamp's power, expected %.4f\n", name, mean, sigma, expected );
    assert_true( sigma < 0.01 );
    assert_true( fabs( mean - expected ) <= MOST_SIGMAS * sigma );
    free_light_path_set( &set );
}

TEST( test_flux_is_conserved )
{
    check_flux( "lamp in solid glass", 0.0f, 0.5f, 0.0f, 0.96 );
    check_flux( "lamp in a shell of glass", 0.4f, 0.5f, 0.0f, 0.96 * 0.96 );
    check_flux( "the same between bulbs", 0.4f, 0.5f, 0.6f, 0.96 * 0.96 * ( 0.96 * 0.6 ) * ( 0.96 * 0.6 ) );
}
