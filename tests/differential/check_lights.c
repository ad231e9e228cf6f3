// Densities of light samples, importances of the light tree, absorption.
#include "differential/differential.h"
#include "differential/reference.h"

#include "path/wavefront.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/select_light.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LIGHTS 64

static float largest_of( RfVec3 p ) { return rf_maxf( fabsf( p.x ), rf_maxf( fabsf( p.y ), fabsf( p.z ) ) ); }

// ---- Area lights --------------------------------------------------------------

// x = the point that is lit, direction to the light, p0, p1, p2, probability; y = density per solid angle of the direction.
static void reference_area( const double* x, double* y )
{
    D3 from = d3_at( x ), wi = d3_unit( d3_at( x + 3 ) ), p0 = d3_at( x + 6 );
    D3 normal = d3_cross( d3_sum( d3_at( x + 9 ), -1.0, p0 ), d3_sum( d3_at( x + 12 ), -1.0, p0 ) );
    double area = 0.5 * d3_length( normal ), cosine = d3_dot( d3_unit( normal ), wi );
    double distance = d3_dot( d3_sum( p0, -1.0, from ), d3_unit( normal ) ) / cosine;
    y[0] = x[15] * distance * distance / ( area * fabs( cosine ) );
}

static void describe_area( const double* x, char* text, size_t size )
{
    D3 p0 = d3_at( x + 6 ), e1 = d3_sum( d3_at( x + 9 ), -1.0, p0 ), e2 = d3_sum( d3_at( x + 12 ), -1.0, p0 ),
       n = d3_cross( e1, e2 );
    snprintf( text, size, "area %.2g m², distance %.2g m, %.6g° to its normal", 0.5 * d3_length( n ),
              d3_length( d3_sum( p0, -1.0, d3_at( x ) ) ), 57.29577951308232 * d3_angle( n, d3_at( x + 3 ) ) );
}

// Lights of one size, from 1e-12 to 1e6 m², near the origin, or those that floats can tell apart there at 1e3 m.
static RfScene make_lights( uint32_t stream )
{
    SceneBuilder b = { 0 };
    uint32_t material = add_material( &b, make_light( 1.0f, true ) );
    float size = (float)random_wide( 1e-6, 1e3, stream, 0, 0 ), away = stream % 3 == 0 && size > 0.1f ? 1e3f : 0.0f;
    for ( int k = 0; k < LIGHTS / 2; ++k )
    {
        RfVec3 a = rf_scale( random_direction( stream, k, 3 ), away ), u = rf_scale( random_direction( stream, k, 6 ), size );
        RfVec3 v = rf_scale( random_direction( stream, k, 9 ), size ); // at a random angle to u
        add_quad( &b, material, a, rf_add( a, u ), rf_add( rf_add( a, u ), v ), rf_add( a, v ) );
    }
    return finish_scene( &b );
}

static void fill_points( RfVertexLanes* v, RfWavefront* keys, const RfLights* lights, uint32_t stream, long first )
{
    v->count = 1000;
    for ( int i = 0; i < v->count; ++i )
    {
        const RfLight* light = lights->light + (int)( random_number( stream, first + i, 40 ) * lights->triangle_count );
        RfVec3 p = rf_madd( light->p0, random_direction( stream, first + i, 41 ),
                            (float)random_wide( 1e-6, 1e4, stream, first + i, 44 ) );
        RfVec3 n = random_direction( stream, first + i, 45 );
        const float at[3] = { p.x, p.y, p.z }, normal[3] = { n.x, n.y, n.z };
        for ( int c = 0; c < 3; ++c )
        {
            v->p[c][i] = at[c];
            v->n[c][i] = v->ng[c][i] = normal[c];
        }
        v->offset[i] = 0.0f;
        v->slot[i] = i;
        keys->key_a[i] = (uint32_t)( first + i );
        keys->key_b[i] = stream;
    }
}

static void judge_light( Check* check, const RfLights* lights, const RfVertexLanes* v, const RfWavefront* keys,
                         const RfLightLanes* got, int i )
{
    RfVec3 from = rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] ), n = rf_vec3( v->n[0][i], v->n[1][i], v->n[2][i] );
    RfVec3 wi = rf_vec3( got->wi[0][i], got->wi[1][i], got->wi[2][i] );
    if ( wi.x == n.x && wi.y == n.y && wi.z == n.z )
        return; // below a horizon
    RfRandomKey key = { keys->key_a[i], keys->key_b[i] };
    uint32_t bits[2] = { rf_random_bits( key, 0 ), rf_random_bits( key, RF_DIMENSION_TWIN ) };
    RfLightSelection chosen = select_light( lights, RF_LIGHTS_BY_POWER, from, n, bits );
    const RfLight* light = lights->light + chosen.light;
    RfVec3 p1 = rf_add( light->p0, light->e1 ), p2 = rf_add( light->p0, light->e2 );
    float largest =
        rf_maxf( rf_maxf( largest_of( from ), largest_of( light->p0 ) ), rf_maxf( largest_of( p1 ), largest_of( p2 ) ) );
    Inputs in = { 0 };
    add_point( &in, from, largest );
    add_direction( &in, wi );
    add_point( &in, light->p0, largest );
    add_point( &in, p1, largest );
    add_point( &in, p2, largest );
    add_number( &in, (double)chosen.probability );
    // corners whose sums are exact: floats relative to the first
    in.x[9] = (double)light->p0.x + (double)light->e1.x;
    in.x[10] = (double)light->p0.y + (double)light->e1.y;
    in.x[11] = (double)light->p0.z + (double)light->e1.z;
    in.x[12] = (double)light->p0.x + (double)light->e2.x;
    in.x[13] = (double)light->p0.y + (double)light->e2.y;
    in.x[14] = (double)light->p0.z + (double)light->e2.z;
    for ( int k = 9; k < 15; ++k )
        in.step[k] = UNIT_ROUNDOFF * (double)largest_of( k < 12 ? light->e1 : light->e2 );
    double value = (double)got->pdf_solid_angle[i];
    judge( check, in.x, in.step, &value );
}

static int check_area_lights( long count )
{
    static Check s_check = { 16, 1, reference_area, describe_area, { { "area light: density", .limit = 16 } } };
    AUTO_FREE RfVertexLanes* v = aligned_alloc( 64, ( sizeof *v + 63 ) / 64 * 64 );
    AUTO_FREE RfWavefront* keys = aligned_alloc( 64, ( sizeof *keys + 63 ) / 64 * 64 );
    AUTO_FREE RfLightLanes* got = aligned_alloc( 64, ( sizeof *got + 63 ) / 64 * 64 );
    for ( long first = 0, tracers = 0; first < count; ++tracers )
    {
        AUTO_SCENE scene = make_lights( 1000 + (uint32_t)tracers );
        AUTO_TRACER tracer = make_tracer( &scene );
        RfPathSettings settings = { .tracer = tracer, .max_depth = 2, .light_samples = 1, .light_sampling = RF_LIGHTS_BY_POWER };
        for ( long end = first + 2000; first < end; first += 1000 )
        {
            fill_points( v, keys, rf_tracer_lights( tracer ), 49, first );
            TRAPPED( rf_sample_lights( &settings, keys, v, ( RfLightSample ){ 0 }, got, &keys->scratch ) );
            for ( int i = 0; i < v->count; ++i )
                judge_light( &s_check, rf_tracer_lights( tracer ), v, keys, got, i );
        }
    }
    return print_check( &s_check );
}

// ---- The light tree -----------------------------------------------------------

// x = point, its normal, centre, radius, axis, turn, full, intensity, two-sided; y = importance, by angles.
static void reference_importance( const double* x, double* y )
{
    D3 way = d3_sum( d3_at( x + 6 ), -1.0, d3_at( x ) ), n = d3_unit( d3_at( x + 3 ) ), axis = d3_unit( d3_at( x + 10 ) );
    D3 back = { -way.x, -way.y, -way.z };
    double distance = d3_length( way ), sine = fmin( x[9] / distance, 1.0 ), theta = d3_angle( back, axis );
    theta = x[16] > 0.0 && theta > 1.5707963267948966 ? 3.14159265358979323846 - theta : theta;
    double cos_light = theta < x[14] ? 1.0 : cos( theta - x[13] ), cos_x = cos( d3_angle( way, n ) ),
           spread = 0.2f * sine + 1e-3f;
    double nearest = fmax( distance, x[9] );
    double reach = fmin( cos_light, cos_x ) + sine + 1e-3f;
    y[0] = reach > 0.0 && x[15] > 0.0
               ? fmax( x[15] * ( fmax( cos_light, 0.0 ) + spread ) * ( fmax( cos_x, 0.0 ) + spread ) / ( nearest * nearest ),
                       1e-37f )
               : 0.0;
}

static void describe_importance( const double* x, char* text, size_t size )
{
    D3 way = d3_sum( d3_at( x + 6 ), -1.0, d3_at( x ) );
    snprintf( text, size, "radius %.2g at distance %.2g, %.6g° to the normal, %.6g° to the axis, intensity %.2g", x[9],
              d3_length( way ), 57.29577951308232 * d3_angle( way, d3_at( x + 3 ) ),
              57.29577951308232 * d3_angle( way, d3_at( x + 10 ) ), x[15] );
}

static int check_importance( long count )
{
    static Check s_check = { 17, 1, reference_importance, describe_importance, { { "light tree: importance", .limit = 16 } } };
    for ( long i = 0; i < count; i += RF_LIGHT_CHILDREN )
    {
        RfLightNode node = { 0 };
        double turn[RF_LIGHT_CHILDREN], full[RF_LIGHT_CHILDREN];
        RfVec3 at = rf_scale( random_direction( 52, i, 0 ), (float)random_wide( 1e-6, 1.0, 52, i, 3 ) ),
               n = random_direction( 52, i, 4 );
        float importance[RF_LIGHT_CHILDREN];
        for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
        {
            RfVec3 centre = rf_madd( at, random_direction( 52, i + k, 10 ), (float)random_wide( 1e-6, 10.0, 52, i + k, 13 ) );
            RfVec3 axis = random_direction( 52, i + k, 14 );
            turn[k] = random_between( 0.0, 1.5, 52, i + k, 17 );
            full[k] = turn[k];
            node.center[0][k] = centre.x;
            node.center[1][k] = centre.y;
            node.center[2][k] = centre.z;
            node.radius[k] = (float)random_wide( 1e-7, 1.0, 52, i + k, 18 );
            node.inverse_radius[k] = 1.0f / node.radius[k];
            node.axis[0][k] = axis.x;
            node.axis[1][k] = axis.y;
            node.axis[2][k] = axis.z;
            node.flip[k] = random_number( 52, i + k, 19 ) < 0.5 ? -1.0f : 1.0f;
            node.cos_turn[k] = (float)cos( turn[k] );
            node.sin_turn[k] = (float)sin( turn[k] );
            node.full[k] = (float)cos( full[k] );
            node.intensity[k] = (float)random_wide( 1e-20, 1.0, 52, i + k, 20 );
        }
        TRAPPED( rf_light_importance( &node, at, n, importance ) );
        for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
        {
            RfVec3 centre = rf_vec3( node.center[0][k], node.center[1][k], node.center[2][k] );
            float largest = rf_maxf( largest_of( centre ), largest_of( at ) );
            Inputs in = { 0 };
            add_point( &in, at, largest );
            add_direction( &in, n );
            add_point( &in, centre, largest );
            add_number( &in, (double)node.radius[k] );
            add_direction( &in, rf_vec3( node.axis[0][k], node.axis[1][k], node.axis[2][k] ) );
            in.x[in.count] = turn[k]; // known by its sine and cosine
            in.step[in.count++] = UNIT_ROUNDOFF;
            in.x[in.count] = full[k];
            in.step[in.count++] = UNIT_ROUNDOFF / fmax( sin( full[k] ), 1e-3 );
            add_number( &in, (double)node.intensity[k] );
            in.x[in.count++] = node.flip[k] < 0.0f;
            double got = (double)importance[k];
            judge( &s_check, in.x, in.step, &got );
        }
    }
    return print_check( &s_check );
}

// ---- Absorption ---------------------------------------------------------------

// x = absorption coefficient, distance; y = transmittance.
static void reference_absorption( const double* x, double* y ) { y[0] = exp( -x[0] * x[1] ); }

static void describe_absorption( const double* x, char* text, size_t size )
{
    snprintf( text, size, "%.3g per m over %.3g m", x[0], x[1] );
}

static int check_absorption( long count )
{
    static Check s_check = { 2, 1, reference_absorption, describe_absorption, { { "absorption", .limit = 8 } } };
    for ( long i = 0; i < count; ++i )
    {
        float a = (float)random_wide( 1e-9, 1e9, 53, i, 0 ), d = (float)random_wide( 1e-9, 1e6, 53, i, 1 );
        if ( random_number( 53, i, 2 ) < 0.5 ) // where it matters
            d = (float)random_wide( 1e-4, 30.0, 53, i, 3 ) / a;
        Inputs in = { 0 };
        add_number( &in, (double)a );
        add_number( &in, (double)d );
        double got;
        TRAPPED( got = (double)rf_transmittance( rf_vec3( a, a, a ), d ).x );
        judge( &s_check, in.x, in.step, &got );
    }
    return print_check( &s_check );
}

int check_lights( long count ) { return check_area_lights( count ) + check_importance( count ) + check_absorption( count ); }
