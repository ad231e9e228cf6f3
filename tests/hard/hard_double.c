#include "hard/hard_double.h"

#include "bsdf/models.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

typedef struct V
{
    double x, y, z;
} V;

static V v( double x, double y, double z ) { return ( V ){ x, y, z }; }
static V wide( RfVec3 a ) { return v( (double)a.x, (double)a.y, (double)a.z ); }
static V add( V a, V b ) { return v( a.x + b.x, a.y + b.y, a.z + b.z ); }
static V sub( V a, V b ) { return v( a.x - b.x, a.y - b.y, a.z - b.z ); }
static V times( V a, double s ) { return v( a.x * s, a.y * s, a.z * s ); }
static V mul( V a, V b ) { return v( a.x * b.x, a.y * b.y, a.z * b.z ); }
static double dot( V a, V b ) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static V cross( V a, V b ) { return v( a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x ); }
static double length( V a ) { return sqrt( dot( a, a ) ); }
static V unit( V a ) { return times( a, 1.0 / length( a ) ); }
static double mean( V a ) { return ( a.x + a.y + a.z ) / 3.0; }

// SplitMix64 (Steele, Lea, Flood, Fast splittable pseudorandom number generators, OOPSLA 2014).
typedef struct Random
{
    uint64_t state;
} Random;

static double draw( Random* r )
{
    uint64_t z = r->state += 0x9e3779b97f4a7c15u;
    z = ( z ^ z >> 30 ) * 0xbf58476d1ce4e5b9u;
    z = ( z ^ z >> 27 ) * 0x94d049bb133111ebu;
    return (double)( ( z ^ z >> 31 ) >> 11 ) * 0x1p-53;
}

typedef struct Triangle
{
    V p, e1, e2, n; // n: unit, of the front; 0 without area
    double area;
    const RfMaterial* material;
    bool emits;
} Triangle;

typedef struct World
{
    const RfScene* scene;
    int count;
    Triangle* triangles;
} World;

static V corner( const RfTriangles* t, uint32_t i, int k )
{
    const float* p = t->positions + 3 * (size_t)t->indices[3 * (size_t)i + (size_t)k];
    return v( (double)p[0], (double)p[1], (double)p[2] );
}

static World make_world( const RfScene* scene )
{
    const RfTriangles* t = &scene->triangles;
    World w = { .scene = scene, .count = (int)t->count };
    w.triangles = calloc( t->count + 1, sizeof *w.triangles );
    if ( w.triangles == NULL )
        abort();
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        Triangle* out = w.triangles + i;
        out->p = corner( t, i, 0 );
        out->e1 = sub( corner( t, i, 1 ), out->p );
        out->e2 = sub( corner( t, i, 2 ), out->p );
        V n = cross( out->e1, out->e2 );
        double twice = length( n );
        out->area = 0.5 * twice;
        out->n = twice > 0.0 ? times( n, 1.0 / twice ) : n;
        out->material = scene->materials + t->material[i];
        out->emits = mean( wide( out->material->emission ) ) * out->area > 0.0;
    }
    return w;
}

// Rays do not find what lies in the plane of the triangle that they leave: the other half of a quad, or a duplicate.
static bool is_coplanar( const Triangle* a, const Triangle* b )
{
    double reach = fmax( length( a->p ), length( b->p ) );
    return length( cross( a->n, b->n ) ) < 1e-13 && fabs( dot( b->n, sub( a->p, b->p ) ) ) <= 1e-15 * reach;
}

// The nearest triangle within `reach` lengths of d, apart from those in the plane of `skip`; −1: none.
static int nearest( const World* w, V o, V d, int skip, double reach, double* distance )
{
    int found = -1;
    double best = reach;
    for ( int i = 0; i < w->count; ++i )
    {
        const Triangle* t = w->triangles + i;
        V pv = cross( d, t->e2 );
        double det = dot( t->e1, pv );
        if ( det == 0.0 || ( skip >= 0 && is_coplanar( t, w->triangles + skip ) ) )
            continue;
        V tv = sub( o, t->p ), qv = cross( tv, t->e1 );
        double a = dot( tv, pv ) / det, b = dot( d, qv ) / det, s = dot( t->e2, qv ) / det;
        if ( a >= 0.0 && b >= 0.0 && a + b <= 1.0 && s > 0.0 && s < best )
        {
            best = s;
            found = i;
        }
    }
    *distance = best;
    return found;
}

// What a hit scatters: f of the models as src/bsdf/README.md defines them.
typedef struct Surface
{
    const RfMaterial* m;
    V n, wo;
    double cos_o;
} Surface;

static Surface surface_at( const Triangle* t, V d )
{
    Surface s = { t->material, t->n, times( d, -1.0 ), 0.0 };
    s.n = dot( s.n, s.wo ) < 0.0 ? times( s.n, -1.0 ) : s.n;
    s.cos_o = dot( s.n, s.wo );
    if ( s.m->kind != RF_BSDF_LAMBERT && s.cos_o < (double)1e-3f ) // lifted to the horizon
    {
        s.wo = unit( add( s.wo, times( s.n, (double)1e-3f - s.cos_o ) ) );
        s.cos_o = dot( s.n, s.wo );
    }
    return s;
}

static double weight5( double c ) { return pow( 1.0 - fmin( c, 1.0 ), 5.0 ); }

static double coat( const RfMaterial* m, double c )
{
    return 1.0 - ( (double)m->coat_f0 + ( (double)m->coat_f90 - (double)m->coat_f0 ) * weight5( c ) );
}

static double distribution( const Surface* s, double cos_h )
{
    double a2 = (double)s->m->alpha * (double)s->m->alpha, q = cos_h * cos_h * ( a2 - 1.0 ) + 1.0;
    return a2 / ( PI * q * q );
}

static V evaluate( const Surface* s, V wi )
{
    const RfMaterial* m = s->m;
    double cos_i = dot( s->n, wi );
    V diffuse = times( wide( m->diffuse ), 1.0 / PI ), specular = wide( m->specular );
    if ( cos_i <= 0.0 )
        return v( 0, 0, 0 );
    if ( m->kind == RF_BSDF_LAMBERT )
        return diffuse;
    if ( m->kind == RF_BSDF_PHONG )
    {
        V mirror = sub( times( s->n, 2.0 * s->cos_o ), s->wo );
        double c = dot( mirror, wi ), e = (double)m->exponent;
        return add( diffuse, times( specular, c > 0.0 ? ( e + 2.0 ) / ( 2.0 * PI ) * pow( c, e ) : 0.0 ) );
    }
    V h = unit( add( s->wo, wi ) );
    double a2 = (double)m->alpha * (double)m->alpha, w = weight5( dot( s->wo, h ) );
    double so = sqrt( a2 + ( 1.0 - a2 ) * s->cos_o * s->cos_o ), si = sqrt( a2 + ( 1.0 - a2 ) * cos_i * cos_i );
    double lobe = distribution( s, dot( s->n, h ) ) / ( 2.0 * ( s->cos_o * si + cos_i * so ) );
    V f = add( times( specular, 1.0 - w ), times( v( 1, 1, 1 ), w * (double)m->f90 ) );
    return add( times( f, lobe ), times( diffuse, coat( m, s->cos_o ) * coat( m, cos_i ) ) );
}

static V around( V n, double cos_t, double phi )
{
    V t = unit( fabs( n.x ) < 0.5 ? cross( n, v( 1, 0, 0 ) ) : cross( n, v( 0, 1, 0 ) ) ), b = cross( n, t );
    double sin_t = sqrt( fmax( 1.0 - cos_t * cos_t, 0.0 ) );
    return add( times( n, cos_t ), add( times( t, sin_t * cos( phi ) ), times( b, sin_t * sin( phi ) ) ) );
}

// Half of the directions by the cosine, half by the lobe; returns f cos / density.
static V sample( const Surface* s, Random* r, V* wi )
{
    const RfMaterial* m = s->m;
    bool lobed = m->kind != RF_BSDF_LAMBERT;
    double u = draw( r ), phi = 2.0 * PI * draw( r ), a2 = (double)m->alpha * (double)m->alpha;
    V mirror = sub( times( s->n, 2.0 * s->cos_o ), s->wo );
    if ( !lobed || draw( r ) < 0.5 )
        *wi = around( s->n, sqrt( u ), phi );
    else if ( m->kind == RF_BSDF_PHONG )
        *wi = around( mirror, pow( u, 1.0 / ( (double)m->exponent + 1.0 ) ), phi );
    else
    {
        V h = around( s->n, sqrt( ( 1.0 - u ) / ( 1.0 + ( a2 - 1.0 ) * u ) ), phi );
        *wi = sub( times( h, 2.0 * dot( s->wo, h ) ), s->wo );
    }
    double cos_i = dot( s->n, *wi ), density = cos_i / PI;
    if ( cos_i <= 0.0 )
        return v( 0, 0, 0 );
    if ( m->kind == RF_BSDF_PHONG )
        density += ( (double)m->exponent + 1.0 ) / ( 2.0 * PI ) * pow( fmax( dot( mirror, *wi ), 0.0 ), (double)m->exponent );
    else if ( lobed )
    {
        V h = unit( add( s->wo, *wi ) );
        density += distribution( s, dot( s->n, h ) ) * dot( s->n, h ) / ( 4.0 * dot( s->wo, h ) );
    }
    return times( evaluate( s, *wi ), cos_i / ( lobed ? 0.5 * density : density ) );
}

// One sample of every emissive triangle.
static V area_lights( const World* w, const Surface* s, V x, int skip, Random* r )
{
    V sum = v( 0, 0, 0 );
    for ( int i = 0; i < w->count; ++i )
    {
        const Triangle* t = w->triangles + i;
        if ( !t->emits || i == skip )
            continue;
        double root = sqrt( draw( r ) ), b = draw( r ) * root, distance;
        V z = add( t->p, add( times( t->e1, 1.0 - root ), times( t->e2, b ) ) ), way = sub( z, x ), wi = unit( way );
        double cos_light = -dot( t->n, wi ), cos_x = dot( s->n, wi );
        cos_light = t->material->double_sided ? fabs( cos_light ) : cos_light;
        if ( !( cos_light > 0.0 && cos_x > 0.0 ) )
            continue;
        int hit = nearest( w, x, way, skip, 1.0 + 1e-9, &distance );
        if ( hit >= 0 && hit != i && distance < 1.0 - 1e-9 )
            continue;
        double geometry = t->area * cos_x * cos_light / dot( way, way );
        sum = add( sum, times( mul( wide( t->material->emission ), evaluate( s, wi ) ), geometry ) );
    }
    return sum;
}

static V point_lights( const World* w, const Surface* s, V x, int skip )
{
    V sum = v( 0, 0, 0 );
    double distance;
    for ( int i = 0; i < w->scene->punctual_count; ++i )
    {
        const RfPunctual* p = w->scene->punctuals + i;
        V way = sub( wide( p->position ), x ), wi = unit( way );
        double cos_x = dot( s->n, wi );
        if ( cos_x <= 0.0 || nearest( w, x, way, skip, 1.0, &distance ) >= 0 )
            continue;
        sum = add( sum, times( mul( wide( p->intensity ), evaluate( s, wi ) ), cos_x / dot( way, way ) ) );
    }
    return sum;
}

static V radiance( const World* w, V o, V d, int max_depth, Random* r )
{
    V sum = v( 0, 0, 0 ), left = v( 1, 1, 1 );
    int skip = -1;
    for ( int vertex = 1; vertex <= max_depth; ++vertex )
    {
        double distance;
        int hit = nearest( w, o, d, skip, INFINITY, &distance );
        if ( hit < 0 )
            return add( sum, mul( left, wide( w->scene->environment.radiance ) ) );
        const Triangle* t = w->triangles + hit;
        if ( vertex == 1 && ( t->material->double_sided || dot( t->n, d ) < 0.0 ) )
            sum = add( sum, wide( t->material->emission ) );
        if ( vertex == max_depth )
            break;
        o = add( o, times( d, distance ) );
        Surface s = surface_at( t, d );
        skip = hit;
        V light = add( point_lights( w, &s, o, skip ), area_lights( w, &s, o, skip, r ) );
        sum = add( sum, mul( left, light ) );
        left = mul( left, sample( &s, r, &d ) );
        if ( !( mean( left ) > 0.0 ) )
            break;
    }
    return sum;
}

// Moves the ray to a point of the thin lens, through what is in focus on it. `d` has the length 1 along the view.
static void use_lens( const RfEye* eye, Random* r, V* o, V* d )
{
    double radius = (double)eye->lens_radius * sqrt( draw( r ) ), phi = 2.0 * PI * draw( r );
    V at = add( times( wide( eye->right ), radius * cos( phi ) ), times( wide( eye->up ), radius * sin( phi ) ) );
    *o = add( *o, at );
    *d = sub( *d, times( at, 1.0 / (double)eye->focus ) );
}

void hard_double_image( const RfScene* scene, const RfEye* eye, int spp, int max_depth, uint64_t seed, double* rgb )
{
    World w = make_world( scene );
    for ( int i = 0; i < eye->width * eye->height; ++i )
    {
        Random r = { ( seed << 32 ) + (uint64_t)i * 0x632be59bd9b4e019u };
        V sum = v( 0, 0, 0 );
        for ( int k = 0; k < spp; ++k )
        {
            double x = i % eye->width + draw( &r ) - (double)eye->axis_x, y = (double)eye->axis_y - i / eye->width - draw( &r );
            V d = add( wide( eye->forward ), add( times( wide( eye->right ), x / (double)eye->focal_x ),
                                                  times( wide( eye->up ), y / (double)eye->focal ) ) );
            V o = wide( eye->origin );
            if ( eye->lens_radius > 0.0f )
                use_lens( eye, &r, &o, &d );
            sum = add( sum, radiance( &w, o, unit( d ), max_depth, &r ) );
        }
        rgb[3 * i] = sum.x / spp;
        rgb[3 * i + 1] = sum.y / spp;
        rgb[3 * i + 2] = sum.z / spp;
    }
    free( w.triangles );
}
