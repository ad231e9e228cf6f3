// References in double precision, from the equations of the literature: in angles, where the code has products.
#ifndef REFRAME_TESTS_DIFFERENTIAL_REFERENCE_H
#define REFRAME_TESTS_DIFFERENTIAL_REFERENCE_H

// A unit vector or a point.
typedef struct D3
{
    double x, y, z;
} D3;

D3 d3_at( const double* x );       // three in a row
D3 d3_sum( D3 a, double s, D3 b ); // a + s b
D3 d3_unit( D3 a );
D3 d3_cross( D3 a, D3 b );
double d3_dot( D3 a, D3 b );
double d3_length( D3 a );
double d3_angle( D3 a, D3 b );       // between any two vectors, accurate near 0 and π
void d3_basis( D3 n, D3* t, D3* b ); // Duff et al. 2017

// The eye, lifted to the shading horizon as the conventions of src/bsdf/README.md say.
D3 lifted_eye( D3 n, D3 wo );

// GGX: density of microfacet normals at the angle θ to n (Walter et al. 2007), and Smith's Λ at the angle θ (Heitz 2014).
double ggx_density( double alpha, double theta );
double ggx_lambda( double alpha, double theta );
double schlick( double f0, double f90, double cos_theta );

// a / ( a + b ) with a rounding, `none` where both are 0.
double share( double a, double b, double none, double rounding );

// Fresnel's reflectance of a dielectric, unpolarised light: sines and tangents of the angles.
double fresnel( double theta, double ior );

// What uniform numbers (u, v) give the visible normal h of GGX seen from wo, by the cap of Dupuy and Benyoub (2023).
void invert_visible_normal( D3 n, D3 wo, D3 h, double alpha, double u[2] );

// The azimuth of d around n over 2π, in [0, 1).
double azimuth_of( D3 n, D3 d );

// Scattering models at x = n (3), wo (3), wi (3), parameters; y = f (of a grey surface) and density.
enum
{
    X_N = 0,
    X_WO = 3,
    X_WI = 6,
    X_PARAM = 9,
};
void reference_lambert( const double* x, double* y );     // diffuse
void reference_phong( const double* x, double* y );       // diffuse, specular, exponent, rounding
void reference_ggx( const double* x, double* y );         // diffuse, f0, alpha, f90, coat_f0, coat_f90, rounding
void reference_translucent( const double* x, double* y ); // those of GGX, through, side that was drawn

// With layers: the parameters of GGX, then these. Those without a film: y = f and density; with one: f per channel and density.
enum
{
    COAT = 7,
    COAT_ALPHA,
    COAT_NORMAL,
    SHEEN_COLOR = COAT_NORMAL + 3,
    SHEEN_SHAPE,
    SHEEN_ALBEDO_O, // directional, of white sheen
    SHEEN_ALBEDO_I,
    STRETCH,
    GRAIN, // unit vector
    FILM_STRENGTH = GRAIN + 3,
    FILM_INDEX,
    FILM_NM,
    FILM_ROUNDING, // of the reflectance, a sum of terms that may cancel
};
void reference_coated( const double* x, double* y );
void reference_sheen( const double* x, double* y );
void reference_anisotropic( const double* x, double* y );
void reference_iridescent( const double* x, double* y );
void reference_layered( const double* x, double* y );

// What the layers make of f (of so many channels) and density below them.
void lay_coat_over( const double* x, double* f, int channels, double* pdf );
void lay_sheen_over( const double* x, double* f, int channels, double* pdf );

// The unit normal, the eye lifted, and wi; false below the horizon. The directions keep their lengths, which floats know to a
// rounding only: where both are grazing, the difference of their lengths tilts the half vector.
int directions( const double* x, D3* n, D3* o, D3* i );
double cos_half( D3 o, D3 i );                      // wo·h for unit vectors
void reference_glass( const double* x, double* y ); // base, specular, alpha, metal, tint, ior, rounding

// The parts that sampling chooses between. `rounding` is that of a probability, the last of a model's parameters: sampling
// compares it with a number of 24 bits, so the model's own density has the probability as rounded.
double phong_diffuse_probability( const double* param );
double ggx_specular_probability( const double* param, double cos_o );
double coat_probability_of( const double* param, double cos_o );
double sheen_probability_of( const double* param );

// What 1 − u of directions drawn for sheen is raised to: 1 over the width of their spread.
double sheen_power( double alpha );

// Of glass at x = base, specular, alpha, metal, tint, ior, for the cosine at a facet or at the surface.
double glass_reflectance( const double* param, double cos_theta );
double glass_base_probability( const double* param, double cos_o );
double glass_reflection_probability( const double* param, double cos_h );

#endif
