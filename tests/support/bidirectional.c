#include "support/bidirectional.h"

#include "path/roulette.h"
#include "path/wavefront.h"
#include "support/statistics.h"

#include <math.h>
#include <stdlib.h>

#define ROULETTE_AFTER ( RF_ROULETTE_VERTEX - 1 ) // hits
#define DIMENSIONS 4u                             // random numbers of a hit

bool advance_walk( const RfTracer* tracer, Walk* w, Point* x )
{
    if ( !find_point( tracer, w->o, w->d, x, NULL ) )
        return false;
    RfVec3 way = rf_sub( x->p, w->o );
    float cosine = rf_dot( x->ng, x->wo );
    w->throughput = rf_mul( w->throughput, part_left_at( x, w->o ) );
    w->vcm *= rf_dot( way, way ) / cosine;
    w->vc /= cosine;
    ++w->hits;
    return cosine > 0.0f;
}

Point seen_from( const Point* x, RfVec3 wo )
{
    Point other = *x;
    other.wo = wo;
    return other;
}

RfVec3 carried_light( const Point* x, RfVec3 to_eye, float* pdf_reverse )
{
    Point seen = seen_from( x, to_eye );
    RfVec3 f = evaluate_point( &seen, x->wo, pdf_reverse );
    return rf_scale( f, fabsf( rf_dot( x->n, x->wo ) ) / rf_dot( x->ng, x->wo ) );
}

static void pass_delta( Walk* w, const Point* x, const Onward* onward )
{
    float in_n = fabsf( rf_dot( x->n, x->wo ) ), in_g = rf_dot( x->ng, x->wo );
    float out_n = fabsf( onward->cos_x ), out_g = fabsf( rf_dot( x->ng, onward->wi ) );
    float index2 = onward->side < 0.0f ? x->ior * x->ior : 1.0f; // far over near, squared
    w->throughput = rf_mul( w->throughput, onward->weight );
    if ( w->from_light ) // weights are those of radiance
        w->throughput = rf_scale( w->throughput, index2 * in_n * out_g / ( out_n * in_g ) );
    w->vcm = 0.0f;
    w->vc *= out_g * in_n / ( out_n * index2 );
}

static void pass_nonspecular( Walk* w, const Point* x, const Onward* onward )
{
    float reverse, out_g = rf_dot( x->ng, onward->wi );
    RfVec3 f = carried_light( x, onward->wi, &reverse ); // of light paths
    f = w->from_light ? rf_scale( f, out_g ) : rf_scale( onward->f, onward->cos_x );
    w->throughput = rf_scale( rf_mul( w->throughput, f ), 1.0f / onward->pdf );
    w->vc = out_g / onward->pdf * ( w->vc * reverse + w->vcm );
    w->vcm = 1.0f / onward->pdf;
}

bool scatter_walk( Walk* w, const Point* x )
{
    Onward onward = scatter_at( x, ( Numbers ){ .key = w->key }, w->dimension );
    uint32_t roulette = w->dimension + 3;
    w->dimension += DIMENSIONS;
    if ( onward.side == 0.0f || !( onward.pdf > 0.0f ) )
        return false;
    if ( is_native_point( x ) )
        pass_delta( w, x, &onward );
    else
        pass_nonspecular( w, x, &onward );
    float bright = rf_max_component( w->throughput ) / w->full;
    float q = w->hits < ROULETTE_AFTER ? 1.0f : rf_survival( bright, w->hits );
    if ( !( bright > 0.0f ) || rf_random( w->key, roulette ) >= q )
        return false;
    w->throughput = rf_scale( w->throughput, 1.0f / q );
    w->o = onward_start( x, &onward );
    w->d = onward.wi;
    return true;
}

// ---- bidirectional ----

#define MAX_VERTICES 32
#define LIGHT_SAMPLES 1000u // first dimension
#define LIGHT_PATH 2000u
#define FILM 3000u

typedef struct Vertex
{
    Point x;
    RfVec3 throughput;
    float vcm, vc;
    int hits; // up to here
} Vertex;

typedef struct Bidirectional
{
    const RfTracer* tracer;
    const RfEye* eye;
    const BidirectionalSettings* settings;
    double* film;
    float paths; // from lights in a pass
} Bidirectional;

const char* bidirectional_lacks( const RfTracer* tracer, const RfEye* eye )
{
    const RfLights* lights = rf_tracer_lights( tracer );
    const RfScene* scene = rf_tracer_scene( tracer );
    if ( lights->triangle_count == 0 || lights->count != lights->triangle_count )
        return "lights other than triangles";
    if ( rf_tracer_is_blended( tracer ) )
        return "blended surfaces";
    if ( eye->moves || eye->lens_radius > 0.0f || eye->projection != RF_PERSPECTIVE )
        return "another camera than a plain one";
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        const RfMaterial* m = scene->materials + i;
        bool based = m->ior > 0.0f && rf_max_component( m->diffuse ) > 0.0f;
        if ( m->kind == RF_BSDF_GLASS && ( m->thin || m->alpha > 0.0f || m->textured != NULL || based ) )
            return "glass that is thin, rough, textured or has a base";
    }
    return NULL;
}

// A point on a lamp.
typedef struct Lamp
{
    const RfLight* light;
    RfVec3 p, radiance;
    float pdf_area;  // of all points of all lamps
    float pdf_angle; // over the cosine, of a light path's direction
} Lamp;

static Lamp sample_lamp( const Bidirectional* b, RfRandomKey key, uint32_t dimension )
{
    const RfLights* lights = rf_tracer_lights( b->tracer );
    uint32_t number = rf_select_light_by_power( lights, rf_random_bits( key, dimension ), rf_random_bits( key, dimension + 1 ) );
    const RfLight* light = lights->light + number;
    float root = sqrtf( rf_random( key, dimension + 2 ) ), b1 = 1.0f - root, b2 = rf_random( key, dimension + 3 ) * root;
    return ( Lamp ){ .light = light,
                     .p = rf_add( light->p0, rf_add( rf_scale( light->e1, b1 ), rf_scale( light->e2, b2 ) ) ),
                     .radiance = rf_light_radiance( rf_tracer_scene( b->tracer ), light, b1, b2 ),
                     .pdf_area = lights->power_fraction[number] * light->pdf_area,
                     .pdf_angle = light->two_sided ? 0.5f * RF_INV_PI : RF_INV_PI };
}

static bool is_open( const Bidirectional* b, RfVec3 from, RfVec3 segment )
{
    const float* o[3] = { &from.x, &from.y, &from.z };
    const float* d[3] = { &segment.x, &segment.y, &segment.z };
    float visible;
    rf_trace_segments( b->tracer, 1, o, d, &visible );
    return visible > 0.0f;
}

static void add_to_film( const Bidirectional* b, int pixel, RfVec3 light )
{
    double* out = b->film + 3 * (size_t)pixel;
    out[0] += (double)light.x;
    out[1] += (double)light.y;
    out[2] += (double)light.z;
}

// Pixels of the film per solid angle at the eye.
static float film_density( const RfEye* eye, float cosine ) { return eye->focal_x * eye->focal / ( cosine * cosine * cosine ); }

// A light path's vertex, seen by the eye: to the pixel where it is.
static void splat( const Bidirectional* b, const Vertex* z )
{
    const RfEye* eye = b->eye;
    RfVec3 from = rf_madd( z->x.p, z->x.ng, z->x.offset ), way = rf_sub( eye->origin, from );
    float d2 = rf_dot( way, way ), along = -rf_dot( way, eye->forward );
    RfVec3 w = rf_scale( way, 1.0f / sqrtf( d2 ) );
    float cos_z = rf_dot( z->x.ng, w ), cosine = -rf_dot( w, eye->forward );
    if ( !( cos_z > 0.0f && along > 0.0f ) )
        return;
    float x = floorf( eye->axis_x - eye->focal_x * rf_dot( way, eye->right ) / along );
    float y = floorf( eye->axis_y + eye->focal * rf_dot( way, eye->up ) / along );
    if ( !( x >= 0.0f && y >= 0.0f && x < (float)eye->width && y < (float)eye->height ) || !is_open( b, from, way ) )
        return;
    float reverse, density = film_density( eye, cosine ) * cos_z / d2 / b->paths;
    RfVec3 light = rf_scale( rf_mul( z->throughput, carried_light( &z->x, w, &reverse ) ), density );
    float others = density * ( z->vcm + z->vc * reverse );
    add_to_film( b, (int)y * eye->width + (int)x, rf_scale( light, 1.0f / ( 1.0f + others ) ) );
}

// Traces a path from a lamp, which the eye sees; returns the vertices that can be connected.
static int trace_light_path( const Bidirectional* b, RfRandomKey key, Vertex* path )
{
    Lamp lamp = sample_lamp( b, key, LIGHT_PATH );
    float u = rf_random( key, LIGHT_PATH + 4 ), side = 1.0f;
    if ( lamp.light->two_sided && rf_random( key, LIGHT_PATH + 6 ) < 0.5f )
        side = -1.0f;
    RfVec3 n = rf_scale( lamp.light->normal, side );
    float cosine = sqrtf( 1.0f - u );
    float angle = 6.28318531f * rf_random( key, LIGHT_PATH + 5 );
    RfVec3 right, up;
    rf_basis( n, &right, &up );
    RfVec3 azimuth = rf_madd( rf_scale( right, cosf( angle ) ), up, sinf( angle ) );
    Walk w = { .o = rf_madd( lamp.p, n, lamp.light->offset ),
               .d = rf_madd( rf_scale( azimuth, sqrtf( u ) ), n, cosine ),
               .throughput = rf_scale( lamp.radiance, 1.0f / ( lamp.pdf_area * lamp.pdf_angle ) ),
               .vcm = 1.0f / ( lamp.pdf_angle * cosine ),
               .vc = 1.0f / ( lamp.pdf_area * lamp.pdf_angle ),
               .from_light = true,
               .key = key,
               .dimension = LIGHT_PATH + 8 };
    w.full = rf_max_component( w.throughput );
    int count = 0;
    Point x;
    while ( w.full > 0.0f && cosine > 0.0f && w.hits + 1 < b->settings->max_depth && advance_walk( b->tracer, &w, &x ) )
    {
        if ( !is_native_point( &x ) )
        {
            path[count] = ( Vertex ){ x, w.throughput, w.vcm, w.vc, w.hits };
            splat( b, path + count++ );
        }
        if ( !scatter_walk( &w, &x ) )
            break;
    }
    return count;
}

// A light sample at an eye vertex.
static RfVec3 sampled_light( const Bidirectional* b, const Vertex* y, RfRandomKey key )
{
    RfVec3 black = rf_vec3( 0, 0, 0 );
    Lamp lamp = sample_lamp( b, key, LIGHT_SAMPLES + 4 * (uint32_t)y->hits );
    RfVec3 from = rf_madd( y->x.p, y->x.ng, y->x.offset ), way = rf_sub( lamp.p, from );
    float d2 = rf_dot( way, way );
    RfVec3 w = rf_scale( way, 1.0f / sqrtf( d2 ) );
    float facing = -rf_dot( lamp.light->normal, w ), cos_lamp = lamp.light->two_sided ? fabsf( facing ) : facing;
    float cos_g = rf_dot( y->x.ng, w ), cos_n = rf_dot( y->x.n, w ), pdf, reverse;
    if ( !( cos_lamp > 0.0f && cos_g > 0.0f && cos_n > 0.0f ) )
        return black;
    RfVec3 to = rf_madd( lamp.p, lamp.light->normal, facing < 0.0f ? -lamp.light->offset : lamp.light->offset );
    if ( !is_open( b, from, rf_sub( to, from ) ) )
        return black;
    RfVec3 f = evaluate_point( &y->x, w, &pdf );
    Point seen = seen_from( &y->x, w );
    evaluate_point( &seen, y->x.wo, &reverse );
    float density = lamp.pdf_area * d2 / cos_lamp;
    float others = pdf / density + lamp.pdf_angle * cos_g * cos_lamp / d2 * ( y->vcm + y->vc * reverse );
    return rf_scale( rf_mul( rf_mul( y->throughput, f ), lamp.radiance ), cos_n / ( density * ( 1.0f + others ) ) );
}

// The light from a light path's vertex z to an eye vertex y.
static RfVec3 connected( const Bidirectional* b, const Vertex* y, const Vertex* z )
{
    RfVec3 black = rf_vec3( 0, 0, 0 );
    RfVec3 from = rf_madd( y->x.p, y->x.ng, y->x.offset );
    RfVec3 way = rf_sub( rf_madd( z->x.p, z->x.ng, z->x.offset ), from );
    float d2 = rf_dot( way, way );
    RfVec3 w = rf_scale( way, 1.0f / sqrtf( d2 ) ), back = rf_scale( w, -1.0f );
    float cos_y = rf_dot( y->x.ng, w ), cos_z = rf_dot( z->x.ng, back ), cos_n = rf_dot( y->x.n, w );
    if ( !( cos_y > 0.0f && cos_z > 0.0f && cos_n > 0.0f ) || !is_open( b, from, way ) )
        return black;
    float pdf_y, pdf_z, reverse_y, reverse_z;
    RfVec3 f_y = evaluate_point( &y->x, w, &pdf_y ), f_z = carried_light( &z->x, back, &reverse_z );
    Point seen = seen_from( &y->x, w );
    evaluate_point( &seen, y->x.wo, &reverse_y );
    evaluate_point( &z->x, back, &pdf_z );
    float others = pdf_y * cos_z / d2 * ( z->vcm + z->vc * reverse_z ) + pdf_z * cos_y / d2 * ( y->vcm + y->vc * reverse_y );
    RfVec3 light = rf_mul( rf_mul( y->throughput, f_y ), rf_mul( z->throughput, f_z ) );
    return rf_scale( light, cos_n * cos_z / ( d2 * ( 1.0f + others ) ) );
}

// The light of a lamp that an eye path meets.
static RfVec3 met_light( const Bidirectional* b, const Vertex* y )
{
    if ( rf_max_component( y->x.emission ) == 0.0f )
        return rf_vec3( 0, 0, 0 );
    const RfLights* lights = rf_tracer_lights( b->tracer );
    const RfLight* light = lights->light + y->x.light;
    float pdf_area = lights->power_fraction[y->x.light] * light->pdf_area;
    float angle = ( light->two_sided ? 0.5f : 1.0f ) * RF_INV_PI * rf_dot( y->x.ng, y->x.wo );
    float others = y->hits == 1 ? 0.0f : pdf_area * ( y->vcm + angle * y->vc );
    return rf_scale( rf_mul( y->throughput, y->x.emission ), 1.0f / ( 1.0f + others ) );
}

static Walk start_at_eye( const Bidirectional* b, RfRandomKey key, int pixel )
{
    const RfEye* eye = b->eye;
    float right = ( (float)( pixel % eye->width ) + rf_random( key, FILM ) - eye->axis_x ) / eye->focal_x;
    float up = ( eye->axis_y - (float)( pixel / eye->width ) - rf_random( key, FILM + 1 ) ) / eye->focal;
    RfVec3 d = rf_normalize( rf_madd( rf_madd( eye->forward, eye->right, right ), eye->up, up ) );
    return ( Walk ){ .o = eye->origin,
                     .d = d,
                     .throughput = rf_vec3( 1, 1, 1 ),
                     .vcm = b->paths / film_density( eye, rf_dot( d, eye->forward ) ),
                     .full = 1.0f,
                     .key = key };
}

static RfVec3 traced( const Bidirectional* b, RfRandomKey key, int pixel )
{
    Vertex path[MAX_VERTICES], y;
    int depth = b->settings->max_depth, count = trace_light_path( b, key, path );
    RfVec3 sum = rf_vec3( 0, 0, 0 );
    Walk w = start_at_eye( b, key, pixel );
    while ( w.hits < depth && advance_walk( b->tracer, &w, &y.x ) )
    {
        y.throughput = w.throughput;
        y.vcm = w.vcm;
        y.vc = w.vc;
        y.hits = w.hits;
        sum = rf_add( sum, met_light( b, &y ) );
        if ( !is_native_point( &y.x ) && w.hits < depth )
        {
            sum = rf_add( sum, sampled_light( b, &y, key ) );
            for ( int i = 0; i < count && w.hits + path[i].hits < depth; ++i )
                sum = rf_add( sum, connected( b, &y, path + i ) );
        }
        if ( w.hits == depth || !scatter_walk( &w, &y.x ) )
            break;
    }
    return sum;
}

void bidirectional_image( const RfTracer* tracer, const RfEye* eye, const BidirectionalSettings* settings, float* rgb )
{
    int pixels = eye->width * eye->height;
    Bidirectional b = { tracer, eye, settings, calloc( 3 * (size_t)pixels, sizeof( double ) ), (float)pixels };
    if ( b.film == NULL || settings->max_depth > MAX_VERTICES )
        abort();
    int spp = settings->spp * suite_samples();
    for ( int pass = 0; pass < spp; ++pass )
    {
        uint64_t key = rf_pass_key( settings->seed + suite_seed(), 0, 0, (uint32_t)pass );
        for ( int i = 0; i < pixels; ++i )
            add_to_film( &b, i, traced( &b, rf_pixel_key( key, (uint32_t)i ), i ) );
    }
    for ( int i = 0; i < 3 * pixels; ++i )
        rgb[i] = (float)( b.film[i] / spp );
    free( b.film );
}
