#include "differential/reference.h"

#include <math.h>

#define PI 3.14159265358979323846

D3 d3_at( const double* x ) { return ( D3 ){ x[0], x[1], x[2] }; }

D3 d3_sum( D3 a, double s, D3 b ) { return ( D3 ){ a.x + s * b.x, a.y + s * b.y, a.z + s * b.z }; }

double d3_dot( D3 a, D3 b ) { return a.x * b.x + a.y * b.y + a.z * b.z; }

double d3_length( D3 a ) { return sqrt( d3_dot( a, a ) ); }

D3 d3_cross( D3 a, D3 b ) { return ( D3 ){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x }; }

D3 d3_unit( D3 a )
{
    double l = d3_length( a );
    return ( D3 ){ a.x / l, a.y / l, a.z / l };
}

double d3_angle( D3 a, D3 b ) { return atan2( d3_length( d3_cross( a, b ) ), d3_dot( a, b ) ); }

void d3_basis( D3 n, D3* t, D3* b )
{
    double sign = copysign( 1.0, n.z ), a = -1.0 / ( sign + n.z ), c = n.x * n.y * a;
    *t = ( D3 ){ 1.0 + sign * n.x * n.x * a, sign * c, -sign * n.x };
    *b = ( D3 ){ c, sign + n.y * n.y * a, -n.y };
}

D3 lifted_eye( D3 n, D3 wo )
{
    double missing = 1e-3f - d3_dot( n, wo ), length = d3_length( wo );
    D3 zero = { 0, 0, 0 };
    return missing > 0.0 ? d3_sum( zero, length, d3_unit( d3_sum( wo, missing, n ) ) ) : wo;
}

double ggx_density( double alpha, double theta )
{
    double c = cos( theta ), t = tan( theta ) / alpha;
    if ( c <= 0.0 )
        return 0.0;
    return 1.0 / ( PI * alpha * alpha * c * c * c * c * ( 1.0 + t * t ) * ( 1.0 + t * t ) );
}

double ggx_lambda( double alpha, double theta )
{
    double t = alpha * tan( theta );
    return 0.5 * ( sqrt( 1.0 + t * t ) - 1.0 );
}

double schlick( double f0, double f90, double cos_theta ) { return f0 + ( f90 - f0 ) * pow( fmax( 1.0 - cos_theta, 0.0 ), 5.0 ); }

double fresnel( double theta, double ior )
{
    double sine = sin( theta ) / ior;
    if ( sine >= 1.0 )
        return 1.0;
    double t = asin( sine ), f0 = ( ior - 1.0 ) / ( ior + 1.0 );
    if ( theta < 1e-4 ) // flat there: the next term is of fourth order
        return f0 * f0;
    double s = sin( theta - t ) / sin( theta + t ), p = tan( theta - t ) / tan( theta + t );
    return 0.5 * ( s * s + p * p );
}

void invert_visible_normal( D3 n, D3 wo, D3 h, double alpha, double u[2] )
{
    D3 t, b;
    d3_basis( n, &t, &b );
    D3 v = d3_unit( ( D3 ){ alpha * d3_dot( wo, t ), alpha * d3_dot( wo, b ), d3_dot( wo, n ) } );
    D3 m = d3_unit( ( D3 ){ d3_dot( h, t ) / alpha, d3_dot( h, b ) / alpha, d3_dot( h, n ) } );
    // the point of the cap that reflects v at m
    double along = 2.0 * d3_dot( v, m );
    D3 c = { along * m.x - v.x, along * m.y - v.y, along * m.z - v.z };
    u[0] = ( 1.0 - c.z ) / ( 1.0 + v.z );
    double turn = atan2( c.y, c.x ) / ( 2.0 * PI );
    u[1] = turn < 0.0 ? turn + 1.0 : turn;
}

double azimuth_of( D3 n, D3 d )
{
    D3 t, b;
    d3_basis( n, &t, &b );
    double turn = atan2( d3_dot( d, b ), d3_dot( d, t ) ) / ( 2.0 * PI );
    return turn < 0.0 ? turn + 1.0 : turn;
}

int directions( const double* x, D3* n, D3* o, D3* i )
{
    *n = d3_unit( d3_at( x + X_N ) );
    *o = lifted_eye( *n, d3_at( x + X_WO ) );
    *i = d3_at( x + X_WI );
    return d3_dot( *n, *i ) > 0.0;
}

double cos_half( D3 o, D3 i ) { return cos( 0.5 * d3_angle( o, i ) ); }

void reference_lambert( const double* x, double* y )
{
    D3 n, o, i;
    y[0] = y[1] = 0.0;
    if ( !directions( x, &n, &o, &i ) )
        return;
    y[0] = x[X_PARAM] / PI;
    y[1] = d3_dot( n, i ) / PI;
}

double share( double a, double b, double none, double rounding )
{
    return fmin( fmax( ( a + b > 0.0 ? a / ( a + b ) : none ) + rounding, 0.0 ), 1.0 );
}

double phong_diffuse_probability( const double* param ) { return share( param[0], param[1], 1.0, param[3] ); }

void reference_phong( const double* x, double* y )
{
    D3 n, o, i;
    y[0] = y[1] = 0.0;
    if ( !directions( x, &n, &o, &i ) )
        return;
    double diffuse = x[X_PARAM], specular = x[X_PARAM + 1], exponent = x[X_PARAM + 2];
    double angle = d3_angle( d3_sum( ( D3 ){ -o.x, -o.y, -o.z }, 2.0 * d3_dot( n, o ), n ), i );
    double half = sin( 0.5 * angle );
    double power = angle < 0.5 * PI ? exp( exponent * log1p( -2.0 * half * half ) ) : 0.0,
           p = phong_diffuse_probability( x + X_PARAM );
    y[0] = diffuse / PI + specular * ( exponent + 2.0 ) / ( 2.0 * PI ) * power;
    y[1] = p * d3_dot( n, i ) / PI + ( 1.0 - p ) * ( exponent + 1.0 ) / ( 2.0 * PI ) * power;
}

double ggx_specular_probability( const double* param, double cos_o )
{
    double specular = schlick( param[1], param[3], cos_o ), base = param[0] * ( 1.0 - schlick( param[4], param[5], cos_o ) );
    return share( specular, base, 1.0, param[6] );
}

void reference_ggx( const double* x, double* y )
{
    D3 n, o, i;
    const double* p = x + X_PARAM;
    y[0] = y[1] = 0.0;
    if ( !directions( x, &n, &o, &i ) )
        return;
    double alpha = p[2], mo = d3_dot( n, o ), mi = d3_dot( n, i );
    D3 h = d3_unit( d3_sum( o, 1.0, i ) );
    double d = ggx_density( alpha, d3_angle( n, h ) ), lo = ggx_lambda( alpha, d3_angle( n, o ) ),
           li = ggx_lambda( alpha, d3_angle( n, i ) );
    double base = ( 1.0 - schlick( p[4], p[5], mo ) ) * ( 1.0 - schlick( p[4], p[5], mi ) );
    double q = ggx_specular_probability( p, mo );
    y[0] = d / ( 1.0 + lo + li ) * schlick( p[1], p[3], cos_half( o, i ) ) / ( 4.0 * mo * mi ) + p[0] / PI * base;
    y[1] = q * d / ( 1.0 + lo ) / ( 4.0 * mo ) + ( 1.0 - q ) * mi / PI;
}

double coat_probability_of( const double* param, double cos_o )
{
    double coat = param[COAT] * schlick( 0.04, 1.0, cos_o ), below = ( 1.0 - coat ) * fmax( param[0] + param[1], 0.05 );
    return share( coat, below, 0.0, param[6] );
}

void lay_coat_over( const double* x, double* f, int channels, double* pdf )
{
    const double* p = x + X_PARAM;
    D3 surface = d3_unit( d3_at( x + X_N ) ), n = d3_unit( d3_at( p + COAT_NORMAL ) ), i = d3_at( x + X_WI );
    D3 o = lifted_eye( n, d3_at( x + X_WO ) ), sum = d3_sum( o, 1.0, i );
    double mo = d3_dot( n, o ), mi = d3_dot( n, i ), alpha = p[COAT_ALPHA], cos_surface = d3_dot( surface, i ), lobe = 0.0,
           drawn = 0.0;
    double to = 1.0 - p[COAT] * schlick( 0.04, 1.0, mo ), ti = 1.0 - p[COAT] * schlick( 0.04, 1.0, fmax( mi, 0.0 ) );
    if ( cos_surface > 0.0 && mo + mi > 0.0 )
    {
        double d = ggx_density( alpha, d3_angle( n, sum ) ), lo = ggx_lambda( alpha, d3_angle( n, o ) );
        drawn = d / ( 1.0 + lo ) / ( 4.0 * mo );
        if ( mi > 0.0 ) // μi of the lobe and μi of the factor that turns it to the surface cancel
            lobe = p[COAT] * d / ( 1.0 + lo + ggx_lambda( alpha, d3_angle( n, i ) ) ) * schlick( 0.04, 1.0, cos_half( o, i ) ) /
                   ( 4.0 * mo * cos_surface );
    }
    double q = coat_probability_of( p, mo );
    for ( int c = 0; c < channels; ++c )
        f[c] = f[c] * to * ti + lobe;
    *pdf = ( 1.0 - q ) * *pdf + q * drawn;
}

void reference_coated( const double* x, double* y )
{
    reference_ggx( x, y );
    lay_coat_over( x, y, 1, y + 1 );
}

double sheen_probability_of( const double* param )
{
    double sheen = param[SHEEN_COLOR] * param[SHEEN_ALBEDO_O], below = ( 1.0 - sheen ) * fmax( param[0] + param[1], 0.05 );
    return fmin( share( sheen, below, 0.0, param[6] ), 0.99 );
}

double sheen_power( double alpha )
{
    double r = sqrt( alpha );
    return 1.0 / ( r * ( 2.0 - r ) );
}

// The logarithm of Λ at a cosine up to 1/2 (Estevez and Kulla 2017, table 1, between its rows).
static double sheen_fit( double x, double alpha )
{
    static const double s_rough[] = { 21.5473, 3.82987, 0.19823, -1.97760, -4.32054 },
                        s_fine[] = { 25.3245, 3.32435, 0.16801, -1.27393, -4.85967 };
    double t = ( 1.0 - alpha ) * ( 1.0 - alpha ), p[5];
    for ( int i = 0; i < 5; ++i )
        p[i] = ( 1.0 - t ) * s_rough[i] + t * s_fine[i];
    return p[0] / ( 1.0 + p[1] * pow( x, p[2] ) ) + p[3] * x + p[4];
}

static double sheen_lambda( double mu, double alpha )
{
    return mu < 0.5 ? exp( sheen_fit( mu, alpha ) )
                    : exp( 2.0 * sheen_fit( 0.5, alpha ) - sheen_fit( fmax( 1.0 - mu, 0.0 ), alpha ) );
}

// What keeps the lobe's albedo below 1 at grazing angles (src/bsdf/layered.c).
static double sheen_limit( double mu, double alpha )
{
    double r = sqrt( alpha ), q = fmin( r, 0.5 );
    return fmin( 1.0, 5.07 * q - 5.08 * q * q + 4.145 * mu + 10.47 * mu * mu / r );
}

void lay_sheen_over( const double* x, double* f, int channels, double* pdf )
{
    D3 n, o, i;
    const double* p = x + X_PARAM;
    if ( !directions( x, &n, &o, &i ) )
        return;
    double mo = d3_dot( n, o ), mi = d3_dot( n, i ), alpha = p[SHEEN_SHAPE], power = sheen_power( alpha );
    double d = ( 2.0 + 1.0 / alpha ) * pow( sin( d3_angle( n, d3_sum( o, 1.0, i ) ) ), 1.0 / alpha ) / ( 2.0 * PI );
    double limit = fmin( sheen_limit( mo, alpha ), sheen_limit( mi, alpha ) );
    double lobe = limit * d / ( 4.0 * mo * mi * ( 1.0 + sheen_lambda( mo, alpha ) + sheen_lambda( mi, alpha ) ) );
    double q = sheen_probability_of( p );
    for ( int c = 0; c < channels; ++c )
        f[c] = p[SHEEN_COLOR] * lobe + f[c] * ( 1.0 - p[SHEEN_COLOR] * fmax( p[SHEEN_ALBEDO_O], p[SHEEN_ALBEDO_I] ) );
    *pdf = ( 1.0 - q ) * *pdf + q * power * pow( fmax( 1.0 - mi, 0.0 ), power - 1.0 ) / ( 2.0 * PI );
}

void reference_sheen( const double* x, double* y )
{
    reference_ggx( x, y );
    lay_sheen_over( x, y, 1, y + 1 );
}

void reference_translucent( const double* x, double* y )
{
    D3 n, o, i;
    const double* p = x + X_PARAM;
    double through = p[7], here = p[0] + p[1] + ( p[3] - p[1] ) / 21.0;
    double chance = share( through, here, 0.0, p[6] ), drawn = p[8] < 0.0 ? chance : 1.0 - chance;
    y[0] = y[1] = NAN; // a side that is never drawn
    if ( drawn <= 0.0 )
        return;
    if ( p[8] > 0.0 )
    {
        reference_ggx( x, y );
        y[0] /= drawn;
        return;
    }
    n = d3_unit( d3_at( x + X_N ) );
    D3 eye = d3_at( x + X_WO ), mirrored = d3_sum( eye, -2.0 * d3_dot( n, eye ), n );
    o = lifted_eye( n, mirrored );
    i = d3_at( x + X_WI );
    double mi = fmax( d3_dot( n, i ), 0.0 ), passed = 1.0 - schlick( p[4], p[5], d3_dot( n, o ) );
    if ( passed <= 0.0 ) // black, and drawn in any way
        return;
    y[0] = mi > 0.0 ? through / drawn / PI * passed * ( 1.0 - schlick( p[4], p[5], mi ) ) : 0.0;
    y[1] = mi / PI;
}

// Parameters of glass.
enum
{
    BASE,
    SPECULAR,
    ALPHA,
    METAL,
    TINT,
    IOR,
    ROUNDING
};

double glass_reflectance( const double* p, double cos_theta )
{
    double w = pow( 1.0 - fmin( cos_theta, 1.0 ), 5.0 );
    if ( p[IOR] == 0.0 )
        return p[SPECULAR] * ( 1.0 - w ) + w * ( 1.0 - p[BASE] );
    double f = fresnel( acos( fmin( cos_theta, 1.0 ) ), fabs( p[IOR] ) );
    return ( 1.0 - p[METAL] ) * f + p[METAL] * w + p[SPECULAR] * ( 1.0 - w );
}

// From outside, whichever side the eye is on.
static double base_transmission( const double* p, double cos_theta )
{
    double ior = fabs( p[IOR] );
    if ( p[IOR] > 0.0 && p[IOR] < 1.0 ) // seen from inside, the base has no coat
        return 1.0;
    return ior > 0.0 ? 1.0 - fresnel( acos( fmin( cos_theta, 1.0 ) ), ior ) : 0.0;
}

double glass_base_probability( const double* p, double cos_o )
{
    double base = p[BASE] * base_transmission( p, cos_o ), f = glass_reflectance( p, cos_o );
    return base > 0.0 ? share( base, f + ( 1.0 - f ) * p[TINT], 0.0, p[ROUNDING] ) : 0.0;
}

double glass_reflection_probability( const double* p, double cos_h )
{
    double f = glass_reflectance( p, cos_h ), t = ( 1.0 - f ) * p[TINT];
    return share( f, t, 1.0, p[ROUNDING] );
}

void reference_glass( const double* x, double* y )
{
    D3 n, o, i;
    const double* p = x + X_PARAM;
    y[0] = y[1] = 0.0;
    if ( !directions( x, &n, &o, &i ) )
        return;
    double mo = d3_dot( n, o ), mi = d3_dot( n, i ), q = glass_base_probability( p, mo );
    if ( q > 0.0 )
    {
        y[0] = p[BASE] / PI * base_transmission( p, mo ) * base_transmission( p, mi );
        y[1] = q * mi / PI;
    }
    if ( p[ALPHA] == 0.0 )
        return;
    D3 h = d3_unit( d3_sum( o, 1.0, i ) );
    double d = ggx_density( p[ALPHA], d3_angle( n, h ) ), lo = ggx_lambda( p[ALPHA], d3_angle( n, o ) ), oh = cos_half( o, i );
    y[0] += d / ( 1.0 + lo + ggx_lambda( p[ALPHA], d3_angle( n, i ) ) ) * glass_reflectance( p, oh ) / ( 4.0 * mo * mi );
    y[1] += ( 1.0 - q ) * glass_reflection_probability( p, oh ) * d / ( 1.0 + lo ) / ( 4.0 * mo );
}
