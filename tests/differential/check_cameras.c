// The film density J and the film position of every kind of eye. J is the Jacobian of the map from a surface to the film: here
// by derivatives of that map along two tangents of the surface, where the code has closed forms.
#include "differential/differential.h"
#include "differential/reference.h"

#include "scene/lens.h"
#include "scene/mirrors.h"
#include "scene/projection.h"
#include "scene/scene.h"

#include <stdio.h>

// The inputs of all references.
enum
{
    X_P,
    X_NG = 3,
    X_ORIGIN = 6,
    X_FORWARD = 9,
    X_RIGHT = 12,
    X_UP = 15,
    X_FOCAL = 18, // along x, along y
    X_AXIS = 20,
    X_LENS = 22, // the point of the lens, m
    X_FOCUS = 24,
    X_MIRROR = 25, // n, at; n = 0: none
    X_KIND = 29,
    X_SIZE = 30, // of the film, pixels
    INPUTS = 32
};

// A value and its derivatives along two directions.
typedef struct Dual
{
    double v, s, t;
} Dual;

static Dual dual_of( D3 p, D3 s, D3 t, D3 axis ) { return ( Dual ){ d3_dot( p, axis ), d3_dot( s, axis ), d3_dot( t, axis ) }; }

static Dual times( Dual a, double k ) { return ( Dual ){ a.v * k, a.s * k, a.t * k }; }

static Dual plus( Dual a, double k, Dual b ) { return ( Dual ){ a.v + k * b.v, a.s + k * b.s, a.t + k * b.t }; }

static Dual over( Dual a, Dual b )
{
    double v = a.v / b.v;
    return ( Dual ){ v, ( a.s - v * b.s ) / b.v, ( a.t - v * b.t ) / b.v };
}

static Dual angle( Dual y, Dual x )
{
    double r2 = x.v * x.v + y.v * y.v;
    return ( Dual ){ atan2( y.v, x.v ), ( x.v * y.s - y.v * x.s ) / r2, ( x.v * y.t - y.v * x.t ) / r2 };
}

static Dual hypotenuse( Dual x, Dual y )
{
    double r = sqrt( x.v * x.v + y.v * y.v );
    return ( Dual ){ r, ( x.v * x.s + y.v * y.s ) / r, ( x.v * x.t + y.v * y.t ) / r };
}

// The place on the film, in units of the focal lengths from where `forward` meets it, +y up, of a point with these
// coordinates to the right, up and ahead of the centre of the lens.
static void film_of( const double* x, Dual right, Dual up, Dual ahead, Dual at[2] )
{
    int kind = (int)x[X_KIND];
    if ( kind == RF_PANORAMIC )
    {
        at[0] = angle( right, ahead );
        at[1] = angle( up, hypotenuse( right, ahead ) );
        return;
    }
    // the ray through the point of the lens meets the plane in focus at q; all points of the lens see q in the same place
    double lens[2] = { x[X_LENS], x[X_LENS + 1] };
    Dual across[2] = { right, up };
    for ( int c = 0; c < 2; ++c )
    {
        Dual from_lens = across[c];
        from_lens.v -= lens[c];
        if ( kind == RF_PERSPECTIVE )
        {
            Dual q = times( over( from_lens, ahead ), x[X_FOCUS] );
            q.v += lens[c];
            at[c] = times( q, 1.0 / x[X_FOCUS] );
        }
        else // rays parallel to the one that meets the film's centre in focus
        {
            at[c] = plus( from_lens, lens[c] / x[X_FOCUS], ahead );
        }
    }
}

// y = J, film position x and y.
static void reference( const double* x, double* y )
{
    D3 p = d3_at( x + X_P ), ng = d3_unit( d3_at( x + X_NG ) ), mirror = d3_at( x + X_MIRROR ), s, t;
    double length = d3_length( mirror );
    if ( length > 0.0 ) // the hit in the mirror, before the eye itself
    {
        D3 m = d3_unit( mirror );
        p = d3_sum( p, -2.0 * ( d3_dot( mirror, p ) - x[X_MIRROR + 3] ), m );
        ng = d3_sum( ng, -2.0 * d3_dot( m, ng ), m );
    }
    D3 way = d3_sum( p, -1.0, d3_at( x + X_ORIGIN ) ), r = d3_at( x + X_RIGHT ), u = d3_at( x + X_UP ),
       f = d3_at( x + X_FORWARD );
    d3_basis( ng, &s, &t );
    Dual at[2];
    film_of( x, dual_of( way, s, t, r ), dual_of( way, s, t, u ), dual_of( way, s, t, f ), at );
    double area = fabs( at[0].s * at[1].t - at[0].t * at[1].s );
    y[0] = fmin( fmax( area * x[X_FOCAL] * x[X_FOCAL + 1], 1e-24 ), 1e30 );
    y[1] = x[X_AXIS] + at[0].v * x[X_FOCAL];
    y[2] = x[X_AXIS + 1] - at[1].v * x[X_FOCAL + 1];
}

static void describe( const double* x, char* text, size_t size )
{
    D3 way = d3_sum( d3_at( x + X_P ), -1.0, d3_at( x + X_ORIGIN ) ), back = { -way.x, -way.y, -way.z };
    snprintf( text, size, "distance %.3g m at %.3g m from the origin, %.6g° to the normal, %.4g° off axis, focal length %.4g px",
              d3_length( way ), d3_length( d3_at( x + X_P ) ), 57.29577951308232 * d3_angle( back, d3_at( x + X_NG ) ),
              57.29577951308232 * d3_angle( way, d3_at( x + X_FORWARD ) ), x[X_FOCAL + 1] );
}

static RfEye random_eye( RfProjectionKind kind, uint32_t stream, long i )
{
    RfVec3 forward = random_direction( stream, i, 1 ), up = random_direction( stream, i, 4 );
    float reach = (float)random_wide( 1e-6, 1e6, stream, i, 7 );
    RfVec3 origin = rf_scale( random_direction( stream, i, 8 ), random_number( stream, i, 10 ) < 0.2 ? 0.0f : reach );
    int width = (int)random_wide( 1.0, 16384.0, stream, i, 11 ), height = (int)random_wide( 1.0, 16384.0, stream, i, 12 );
    if ( fabsf( rf_dot( forward, up ) ) > 0.99f )
        up = fabsf( forward.x ) < 0.7f ? rf_vec3( 1, 0, 0 ) : rf_vec3( 0, 1, 0 );
    double degree = 0.017453292519943295;
    RfEye eye = kind == RF_PANORAMIC ? rf_make_panoramic_eye( origin, forward, up, width, height )
                : kind == RF_ORTHOGRAPHIC
                    ? rf_make_orthographic_eye( origin, forward, up, random_wide( 1e-6, 1e6, stream, i, 13 ), width, height )
                    : rf_make_eye( origin, forward, up, random_wide( degree, 170.0 * degree, stream, i, 13 ), width, height );
    if ( kind != RF_PANORAMIC && random_number( stream, i, 14 ) < 0.3 )
        rf_shift_eye( &eye, random_wide( 0.5, 2.0, stream, i, 15 ), random_between( -0.5, 0.5, stream, i, 16 ),
                      random_between( -0.5, 0.5, stream, i, 17 ) );
    return eye;
}

// A hit in a random pixel, at any distance, seen at any angle: from below 1e-5 rad of grazing to head on.
static void random_hit( const RfEye* eye, uint32_t stream, long i, RfVec3* p, RfVec3* ng )
{
    float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    RfVec3 o, d;
    rf_eye_ray( eye, inverse, (int)( random_number( stream, i, 20 ) * eye->width ),
                (int)( random_number( stream, i, 21 ) * eye->height ), (float)random_number( stream, i, 22 ),
                (float)random_number( stream, i, 23 ), &o, &d );
    *p = rf_madd( o, d, (float)random_wide( 1e-6, 1e6, stream, i, 24 ) );
    *ng = random_around( rf_scale( d, -1.0f ), stream, i, 25 );
    if ( rf_dot( *ng, d ) > 0.0f )
        *ng = rf_scale( *ng, -1.0f );
}

// `start` is where rays start: a point of the lens is a float in the world, too.
static void fill_inputs( Inputs* in, const RfEye* eye, RfVec3 start, const double lens[3], const RfMirror* mirror, RfVec3 p,
                         RfVec3 ng )
{
    float largest = rf_maxf( rf_largest_coordinate( p ), rf_largest_coordinate( eye->origin ) );
    *in = ( Inputs ){ 0 };
    add_point( in, p, largest );
    add_direction( in, ng );
    add_point( in, eye->origin, rf_maxf( largest, rf_largest_coordinate( start ) ) );
    add_direction( in, eye->forward );
    add_direction( in, eye->right );
    add_direction( in, eye->up );
    add_number( in, (double)eye->focal_x );
    add_number( in, (double)eye->focal );
    add_number( in, (double)eye->axis_x );
    add_number( in, (double)eye->axis_y );
    for ( int k = 0; k < 3; ++k )
        add_number( in, lens[k] );
    if ( mirror != NULL )
    {
        add_direction( in, mirror->n );
        add_number( in, (double)mirror->at );
    }
    else
    {
        for ( int k = 0; k < 4; ++k )
            add_number( in, 0.0 );
    }
    in->x[in->count++] = eye->projection;
    in->x[in->count++] = eye->width;
    in->x[in->count++] = eye->height;
}

// Pixels from the film's border, negative outside.
static double inside( const Inputs* in, const double* y )
{
    return fmin( fmin( y[1], in->x[X_SIZE] - y[1] ), fmin( y[2], in->x[X_SIZE + 1] - y[2] ) );
}

// What is on the film by more than roundings is seen, what is off it is not.
static int is_wrongly_seen( const Check* check, const Inputs* in, RfProjection at, const double* y )
{
    double spread[3], to_border = inside( in, y );
    if ( at.seen == ( to_border > 0.0 ) )
        return 0;
    find_spread( check, in->x, in->step, y, spread );
    double margin = 8.0 * ( spread[1] + spread[2] + UNIT_ROUNDOFF * ( in->x[X_SIZE] + in->x[X_SIZE + 1] ) );
    D3 way = d3_sum( d3_at( in->x + X_P ), -1.0, d3_at( in->x + X_ORIGIN ) );
    bool is_ahead = in->x[X_KIND] == RF_PANORAMIC || d3_length( d3_at( in->x + X_MIRROR ) ) > 0.0 ||
                    d3_dot( way, d3_at( in->x + X_FORWARD ) ) > 32.0 * in->step[X_ORIGIN];
    return is_ahead && fabs( to_border ) > margin &&
           spread[0] < 0.05 * y[0]; // and which way the surface faces is no matter of rounding
}

typedef struct Kind
{
    RfProjectionKind projection;
    bool lens, mirror;
} Kind;

// A plane that the eye is before, and the hit as well once it is mirrored.
static RfMirror random_mirror( const RfEye* eye, uint32_t stream, long i )
{
    RfMirror mirror = { .n = random_direction( stream, i, 40 ) };
    mirror.at = rf_dot( mirror.n, eye->origin ) - (float)random_wide( 1e-3, 1e3, stream, i, 42 );
    return mirror;
}

static int check_kind( Check* check, Kind kind, uint32_t stream, long count )
{
    long wrong = 0;
    for ( long i = 0; i < count; ++i )
    {
        RfEye eye = random_eye( kind.projection, stream, i ), through;
        double lens[3] = { 0.0, 0.0, 1.0 };
        RfLensSample sample = { (float)random_number( stream, i, 30 ), (float)random_number( stream, i, 31 ), 0.5f };
        if ( kind.lens )
        {
            float point[2];
            rf_set_lens( &eye, random_wide( 1e-6, 1e3, stream, i, 32 ), random_wide( 1e-3, 1e6, stream, i, 33 ), 0, 0.0 );
            rf_lens_point( &eye, sample.u, sample.v, point );
            lens[0] = (double)( eye.lens_radius * point[0] );
            lens[1] = (double)( eye.lens_radius * point[1] );
            lens[2] = (double)eye.focus;
        }
        TRAPPED( through = rf_sample_eye( &eye, sample ) );
        RfMirror mirror = random_mirror( &eye, stream, i );
        if ( kind.mirror )
            TRAPPED( through = rf_mirrored_eye( &eye, &mirror ) );
        RfVec3 p, ng;
        random_hit( &through, stream, i, &p, &ng );
        RfProjection at;
        TRAPPED( at = rf_project_any( &through, p, ng ) );
        Inputs in;
        fill_inputs( &in, &eye, kind.lens ? through.origin : eye.origin, lens, kind.mirror ? &mirror : NULL, p, ng );
        double y[3], got[3] = { (double)at.density, (double)at.x + (double)at.u, (double)at.y + (double)at.v };
        reference( in.x, y );
        for ( int o = 0; o < 3; ++o )
            check->row[o].scale = o > 0 ? (double)( o == 1 ? eye.width : eye.height ) : 0.0;
        wrong += is_wrongly_seen( check, &in, at, y );
        // nothing tells where a point is seen whose depth is a matter of rounding
        if ( !at.seen ||
             ( kind.projection == RF_PERSPECTIVE && (double)rf_pinhole_depth( &through, p ) < 256.0 * in.step[X_ORIGIN] ) )
            continue;
        if ( kind.projection == RF_PANORAMIC ) // the shorter way round
            got[1] -= eye.width * floor( ( got[1] - y[1] ) / eye.width + 0.5 );
        judge( check, in.x, in.step, got );
    }
    if ( wrong > 0 )
        fprintf( stderr, "%s: %ld hits on the wrong side of the film's border\n", check->row[0].name, wrong );
    return print_check( check ) + ( wrong > 0 );
}

#define ROWS( name )                                                                                                             \
    {                                                                                                                            \
        { name ": J", .limit = 8 }, { name ": column", .limit = 4 }, { name ": row", .limit = 4 }                                \
    }

int check_cameras( long count )
{
    static Check s_checks[] = {
        { INPUTS, 3, reference, describe, ROWS( "perspective" ) },
        { INPUTS, 3, reference, describe, ROWS( "perspective, lens" ) },
        { INPUTS, 3, reference, describe, ROWS( "perspective, mirrored" ) },
        { INPUTS, 3, reference, describe, ROWS( "orthographic" ) },
        { INPUTS, 3, reference, describe, ROWS( "orthographic, lens" ) },
        { INPUTS, 3, reference, describe, ROWS( "panoramic" ) },
        { INPUTS, 3, reference, describe, ROWS( "panoramic, mirrored" ) },
    };
    static const Kind s_kinds[] = {
        { RF_PERSPECTIVE, false, false },  { RF_PERSPECTIVE, true, false },  { RF_PERSPECTIVE, false, true },
        { RF_ORTHOGRAPHIC, false, false }, { RF_ORTHOGRAPHIC, true, false }, { RF_PANORAMIC, false, false },
        { RF_PANORAMIC, false, true },
    };
    int bad = 0;
    for ( int k = 0; k < 7; ++k )
        bad += check_kind( s_checks + k, s_kinds[k], 30 + (uint32_t)k, count );
    return bad;
}
