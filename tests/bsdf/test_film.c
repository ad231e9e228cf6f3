// Thin films: the integrals of waves over light of D65 against sums over wavelengths, and the reflectance of one wavelength against
// Airy's closed form.
#include "support/test.h"
#include "bsdf/thin_film.h"

#include <complex.h>

static const double s_pi = 3.14159265358979323846;

// D65 from 380 to 780 nm in steps of 10 nm (CIE).
static const double s_d65[] = { 49.98,  54.65,  82.75,  91.49,  93.43,  86.68,  104.86, 117.01, 117.81, 114.86, 115.92,
                                108.81, 109.35, 107.80, 104.79, 107.69, 104.41, 104.05, 100.00, 96.33,  95.79,  88.69,
                                90.01,  89.60,  87.70,  83.29,  83.70,  80.03,  80.21,  82.28,  78.28,  69.72,  71.61,
                                74.35,  61.60,  69.89,  75.09,  63.59,  46.42,  66.81,  63.38 };

static double bell( double x, double mean, double below, double above )
{
    double t = ( x - mean ) / ( x < mean ? below : above );
    return exp( -0.5 * t * t );
}

// Colour matching functions in linear Rec. 709 (Wyman, Sloan, Shirley 2013).
static void match( double nm, double rgb[3] )
{
    double x =
        1.056 * bell( nm, 599.8, 37.9, 31.0 ) + 0.362 * bell( nm, 442.0, 16.0, 26.7 ) - 0.065 * bell( nm, 501.1, 20.4, 26.2 );
    double y = 0.821 * bell( nm, 568.8, 46.9, 40.5 ) + 0.286 * bell( nm, 530.9, 16.3, 31.1 );
    double z = 1.217 * bell( nm, 437.0, 11.8, 36.0 ) + 0.681 * bell( nm, 459.0, 26.0, 13.8 );
    rgb[0] = 3.2404542 * x - 1.5371385 * y - 0.4985314 * z;
    rgb[1] = -0.9692660 * x + 1.8760108 * y + 0.0415560 * z;
    rgb[2] = 0.0556434 * x - 0.2040259 * y + 1.0572252 * z;
}

// The mean of cos 2πσD per channel, D in µm.
static void wave_of( double difference, double out[3] )
{
    double sum[3] = { 0 }, all[3] = { 0 };
    for ( int nm = 380; nm <= 780; ++nm )
    {
        int k = ( nm - 380 ) / 10;
        double t = ( nm - 380 ) / 10.0 - k, light = s_d65[k] + ( k < 40 ? t * ( s_d65[k + 1] - s_d65[k] ) : 0.0 ), rgb[3];
        match( nm, rgb );
        for ( int c = 0; c < 3; ++c )
        {
            sum[c] += light * rgb[c] * cos( 2.0 * s_pi * difference * 1000.0 / nm );
            all[c] += light * rgb[c];
        }
    }
    for ( int c = 0; c < 3; ++c )
        out[c] = sum[c] / all[c];
}

TEST( test_waves )
{
    const double limit[3] = { 0.017, 0.005, 0.003 }; // as thin_film.h has it
    double worst[3] = { 0 };
    for ( int i = 0; i <= 300; ++i )
    {
        float d = 0.01f * (float)i;
        RfFilmWaves w = rf_film_waves( d ), twice = rf_film_waves( 2.0f * d ), thrice = rf_film_waves( 3.0f * d );
        const float once[3] = { w.once.x, w.once.y, w.once.z };
        double wanted[3];
        wave_of( (double)d, wanted );
        for ( int c = 0; c < 3; ++c )
            worst[c] = fmax( worst[c], fabs( (double)once[c] - wanted[c] ) );
        assert_true( fabsf( w.twice.x - twice.once.x ) < 2e-4f && fabsf( w.twice.z - twice.once.z ) < 2e-4f );
        assert_true( fabsf( w.thrice.y - thrice.once.y ) < 2e-4f && fabsf( w.thrice.z - thrice.once.z ) < 2e-4f );
    }
    print_message( "waves: %.4f %.4f %.4f off at most\n", worst[0], worst[1], worst[2] );
    for ( int c = 0; c < 3; ++c )
        assert_true( worst[c] < limit[c] );
}

// One wavelength, by amplitudes. The sum in the film has three terms of interference: what is left out is of the fourth power.
TEST( test_one_wavelength )
{
    const float indices[] = { 1.0f, 1.33f, 1.8f, 2.5f }, f0s[] = { 0.0f, 0.04f, 0.17f, 0.5f, 1.0f };
    for ( int i = 0; i < 4 * 5 * 20; ++i )
    {
        float ior = indices[i % 4], f0 = f0s[i / 4 % 5], root = ( ior - 1.0f ) / ( ior + 1.0f ),
              phase = 0.33f * (float)( i / 20 );
        RfFilmLayer layer = { ior, root * root, 0.0f };
        double s = sqrt( 0.9999 * (double)f0 ), index = ( 1.0 + s ) / ( 1.0 - s ), r12 = -(double)root;
        double r23 = ( (double)ior - index ) / ( (double)ior + index ), both = fabs( r12 * r23 );
        double complex turned = r23 * cexp( I * (double)phase ), r = ( r12 + turned ) / ( 1.0 + r12 * turned );
        double wanted = creal( r * conj( r ) ), left = 4.0 * pow( both, 4.0 ) + 1e-3;
        float got = rf_film_channel( layer, f0, cosf( phase ), cosf( 2.0f * phase ), cosf( 3.0f * phase ) );
        if ( !( fabs( (double)got - wanted ) < left ) )
            fail_msg( "index %g, F0 %g, phase %g: %g instead of %g", (double)ior, (double)f0, (double)phase, (double)got,
                      wanted );
    }
}

// Whatever a file has is a reflectance; what has no thickness, or the index of the air, is no film.
TEST( test_extremes )
{
    const float indices[] = { 1.0f, 1.3f, 100.0f }, thicknesses[] = { 0.0f, 0.5f, 400.0f, 1e5f }, f0s[] = { 0.0f, 0.04f, 1.0f };
    for ( int i = 0; i < 3 * 4 * 3 * 11; ++i )
    {
        float f0 = f0s[i / 12 % 3], cosine = 0.1f * (float)( i / 36 );
        RfVec3 f = rf_film_fresnel( rf_vec3( f0, f0, f0 ), cosine, indices[i % 3], thicknesses[i / 3 % 4] );
        assert_true( f.x >= 0.0f && f.y >= 0.0f && f.z >= 0.0f && rf_max_component( f ) <= 1.0f );
    }
    RfVec3 air = rf_film_fresnel( rf_vec3( 0.04f, 0.2f, 0.9f ), 1.0f, 1.0f, 400.0f );
    assert_true( fabsf( air.x - 0.04f ) < 1e-4f && fabsf( air.y - 0.2f ) < 1e-4f && fabsf( air.z - 0.9f ) < 1e-3f );
    assert_true( rf_film_strength( 1.0f, 0.0f ) == 0.0f && rf_film_strength( 0.5f, 1e5f ) == 0.5f );
}
