// GGX that is stretched, has a thin film, or both, and layers over it.
#include "differential/reference.h"

#include <math.h>

#define PI 3.14159265358979323846

// Heitz 2014: the anisotropic GGX distribution at polar angles, and the roughness that Λ sees at an azimuth.
typedef struct Stretched
{
    D3 n, t, b;
    double along, across; // roughness
} Stretched;

static double stretched_density( const Stretched* s, D3 h )
{
    double theta = d3_angle( s->n, h ), phi = atan2( d3_dot( h, s->b ), d3_dot( h, s->t ) ), c = cos( theta ), t = tan( theta );
    if ( c <= 0.0 )
        return 0.0;
    double x = cos( phi ) / s->along, y = sin( phi ) / s->across, sum = 1.0 + t * t * ( x * x + y * y );
    return 1.0 / ( PI * s->along * s->across * c * c * c * c * sum * sum );
}

static double stretched_lambda( const Stretched* s, D3 w )
{
    double phi = atan2( d3_dot( w, s->b ), d3_dot( w, s->t ) );
    return ggx_lambda( hypot( cos( phi ) * s->along, sin( phi ) * s->across ), d3_angle( s->n, w ) );
}

// The mean over the light that a channel sees of cos 2πσD: the fit of src/bsdf/thin_film.h.
static double film_wave( int channel, double difference )
{
    static const double s_mean[] = { 1.662381, 1.813970, 1.911180, 2.208079 },
                        s_deviation[] = { 0.079411, 0.104462, 0.161799, 0.103287 };
    static const double s_weight[4][3] = { { 1.714018, -0.267580, -0.005567 },
                                           { -0.058239, 0.947545, -0.157114 },
                                           { -0.844121, 0.486521, 0.045936 },
                                           { 0.188343, -0.166486, 1.116745 } };
    double sum = 0.0;
    for ( int k = 0; k < 4; ++k )
    {
        double spread = 2.0 * PI * s_deviation[k] * difference;
        sum += s_weight[k][channel] * exp( -0.5 * spread * spread ) * cos( 2.0 * PI * s_mean[k] * difference );
    }
    return sum;
}

// Belcour and Barla 2017, equations 8 to 11 as KHR_materials_iridescence takes them: Schlick's Fresnel, phases of 0 or π. Both F0
// and what is reflected within the film are less by a factor of 0.9999 (src/bsdf/thin_film.h).
static double film_reflectance( int channel, double f0, double cos_theta, const double* p )
{
    double ior = p[FILM_INDEX], nm = p[FILM_NM];
    double inside = cos( asin( sqrt( fmax( 1.0 - cos_theta * cos_theta, 0.0 ) ) / ior ) );
    double root = sqrt( 0.9999 * f0 ), base = ( 1.0 + root ) / ( 1.0 - root );
    double r12 = schlick( pow( ( ior - 1.0 ) / ( ior + 1.0 ), 2.0 ), 1.0, cos_theta );
    double r23 = schlick( pow( ( base - ior ) / ( base + ior ), 2.0 ), 1.0, inside );
    double phase = PI + ( base < ior ? PI : 0.0 ); // of the inner sides of both interfaces
    double r123 = 0.9999 * r12 * r23, t121 = 1.0 - r12, rs = t121 * t121 * r23 / ( 1.0 - r123 );
    double sum = r12 + rs + p[FILM_ROUNDING];
    for ( int m = 1; m <= 3; ++m )
        sum +=
            2.0 * ( rs - t121 ) * pow( sqrt( r123 ), m ) * cos( m * phase ) * film_wave( channel, m * 2e-3 * ior * nm * inside );
    return fmin( fmax( sum, 0.0 ), 1.0 );
}

// F of all channels; returns what the dielectric lets to the base.
static double facet_fresnel( const double* p, int has_film, double cos_theta, double f[3] )
{
    double bare = schlick( p[1], p[3], cos_theta ), lost = schlick( p[4], p[5], cos_theta ), brightest = 0.0;
    double strength = has_film ? p[FILM_STRENGTH] * fmin( p[FILM_NM], 1.0 ) : 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        f[c] = bare;
        if ( strength <= 0.0 )
            continue;
        f[c] += strength * ( film_reflectance( c, p[1], cos_theta, p ) - bare );
        brightest = fmax( brightest, film_reflectance( c, p[4], cos_theta, p ) );
    }
    return 1.0 - lost - strength * ( brightest - lost );
}

static void facets( const double* x, int is_stretched, int has_film, double f[3], double* pdf )
{
    D3 o, i;
    Stretched s;
    const double* p = x + X_PARAM;
    f[0] = f[1] = f[2] = *pdf = 0.0;
    if ( !directions( x, &s.n, &o, &i ) )
        return;
    d3_basis( s.n, &s.t, &s.b );
    if ( is_stretched )
    {
        s.t = d3_at( p + GRAIN );
        s.b = d3_cross( s.n, s.t );
    }
    s.across = p[2];
    s.along = is_stretched ? p[2] + ( 1.0 - p[2] ) * p[STRETCH] * p[STRETCH] : p[2];
    double mo = d3_dot( s.n, o ), mi = d3_dot( s.n, i ), at_o[3], at_i[3], at_h[3];
    double base = facet_fresnel( p, has_film, mo, at_o ), q = ( at_o[0] + at_o[1] + at_o[2] ) / 3.0;
    q = share( q, p[0] * base, 1.0, p[6] );
    base *= facet_fresnel( p, has_film, mi, at_i );
    facet_fresnel( p, has_film, cos_half( o, i ), at_h );
    double d = stretched_density( &s, d3_sum( o, 1.0, i ) ), lo = stretched_lambda( &s, o ), li = stretched_lambda( &s, i );
    for ( int c = 0; c < 3; ++c )
        f[c] = d / ( 1.0 + lo + li ) * at_h[c] / ( 4.0 * mo * mi ) + p[0] / PI * base;
    *pdf = q * d / ( 1.0 + lo ) / ( 4.0 * mo ) + ( 1.0 - q ) * mi / PI;
}

void reference_anisotropic( const double* x, double* y )
{
    double f[3], pdf;
    facets( x, 1, 0, f, &pdf );
    y[0] = f[0];
    y[1] = pdf;
}

void reference_iridescent( const double* x, double* y ) { facets( x, 0, 1, y, y + 3 ); }

void reference_layered( const double* x, double* y )
{
    facets( x, 1, 1, y, y + 3 );
    lay_sheen_over( x, y, 3, y + 3 );
    lay_coat_over( x, y, 3, y + 3 );
}
