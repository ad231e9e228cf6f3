// Matrices between sets of primaries (SMPTE RP 177; Lindbloom, "Chromatic adaptation", for Bradford).
#include "image/colour.h"

#include <math.h>
#include <string.h>

#define SAME 1e-4 // of chromaticities: they are rounded to four digits

const char* const rf_colour_space_words[] = { [RF_REC709] = "rec709", [RF_ACESCG] = "acescg", NULL };

// ITU-R BT.709; Academy S-2014-004 (ACEScg: primaries AP1, white of ACES).
static const RfChromaticities s_spaces[] = {
    [RF_REC709] = { { { 0.64f, 0.33f }, { 0.30f, 0.60f }, { 0.15f, 0.06f }, { 0.3127f, 0.3290f } } },
    [RF_ACESCG] = { { { 0.713f, 0.293f }, { 0.165f, 0.830f }, { 0.128f, 0.044f }, { 0.32168f, 0.33767f } } },
};

const RfChromaticities* rf_chromaticities_of( RfColourSpace space ) { return s_spaces + space; }

typedef double Matrix[3][3];

static void multiply( Matrix a, Matrix b, Matrix out )
{
    for ( int i = 0; i < 3; ++i )
    {
        for ( int k = 0; k < 3; ++k )
            out[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k] + a[i][2] * b[2][k];
    }
}

static void apply( Matrix m, const double v[3], double out[3] )
{
    for ( int i = 0; i < 3; ++i )
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

static bool invert( Matrix m, Matrix out )
{
    for ( int i = 0; i < 3; ++i )
    {
        for ( int k = 0; k < 3; ++k )
        {
            int a = ( i + 1 ) % 3, b = ( i + 2 ) % 3, c = ( k + 1 ) % 3, d = ( k + 2 ) % 3;
            out[k][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    }
    double determinant = m[0][0] * out[0][0] + m[0][1] * out[1][0] + m[0][2] * out[2][0];
    if ( !( fabs( determinant ) > 1e-6 ) ) // NaN too
        return false;
    for ( int i = 0; i < 9; ++i )
        out[i / 3][i % 3] /= determinant;
    return true;
}

static void xyz_of( const float xy[2], double xyz[3] )
{
    xyz[0] = (double)xy[0];
    xyz[1] = (double)xy[1];
    xyz[2] = 1.0 - xyz[0] - xyz[1];
}

// RGB to XYZ, with white at luminance 1. False: no colour space.
static bool to_xyz( const RfChromaticities* c, Matrix out, double white[3] )
{
    Matrix primaries, inverse;
    double scale[3];
    for ( int i = 0; i < 3; ++i )
    {
        double xyz[3];
        xyz_of( c->xy[i], xyz );
        for ( int k = 0; k < 3; ++k )
            primaries[k][i] = xyz[k];
    }
    if ( !( c->xy[3][1] > 0.0f ) || !invert( primaries, inverse ) )
        return false;
    xyz_of( c->xy[3], white );
    for ( int i = 0; i < 3; ++i )
        white[i] /= (double)c->xy[3][1];
    apply( inverse, white, scale );
    for ( int i = 0; i < 9; ++i )
        out[i / 3][i % 3] = primaries[i / 3][i % 3] * scale[i % 3];
    return scale[0] > 0.0 && scale[1] > 0.0 && scale[2] > 0.0;
}

static void adapt( const double from[3], const double to[3], Matrix out )
{
    static Matrix bradford = { { 0.8951, 0.2664, -0.1614 }, { -0.7502, 1.7135, 0.0367 }, { 0.0389, -0.0685, 1.0296 } };
    Matrix inverse, scaled;
    double cones[2][3];
    invert( bradford, inverse );
    apply( bradford, from, cones[0] );
    apply( bradford, to, cones[1] );
    for ( int i = 0; i < 9; ++i )
        scaled[i / 3][i % 3] = bradford[i / 3][i % 3] * cones[1][i / 3] / cones[0][i / 3];
    multiply( inverse, scaled, out );
}

bool rf_convert_between( const RfChromaticities* from, const RfChromaticities* to, RfColourConversion* conversion )
{
    Matrix sides[2], adaptation, adapted, back, all;
    double whites[2][3];
    *conversion = ( RfColourConversion ){ .needed = false };
    for ( int i = 0; i < 8; ++i )
        conversion->needed |= !( fabs( (double)from->xy[i / 2][i % 2] - (double)to->xy[i / 2][i % 2] ) <= SAME );
    if ( !conversion->needed )
        return true;
    if ( !to_xyz( from, sides[0], whites[0] ) || !to_xyz( to, sides[1], whites[1] ) )
        return false;
    adapt( whites[0], whites[1], adaptation );
    multiply( adaptation, sides[0], adapted );
    bool good = invert( sides[1], back );
    multiply( back, adapted, all );
    for ( int i = 0; i < 9; ++i )
    {
        conversion->matrix[i / 3][i % 3] = (float)all[i / 3][i % 3];
        good = good && fabs( all[i / 3][i % 3] ) < 1e6;
    }
    return good;
}

float rf_convert_component( const RfColourConversion* conversion, RfColourKind kind, int to, const float rgb[3] )
{
    const float* row = conversion->matrix[to];
    if ( kind != RF_COLOUR_VARIANCE )
        return row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2];
    float deviation = 0.0f;
    for ( int c = 0; c < 3; ++c )
        deviation += row[c] * sqrtf( fmaxf( rgb[c], 0.0f ) );
    return deviation * deviation;
}

void rf_convert_colours( const RfColourConversion* conversion, RfColourKind kind, float* rgb, size_t count, size_t stride )
{
    for ( size_t i = 0; i < count && conversion->needed && kind != RF_COLOUR_NONE; ++i, rgb += stride )
    {
        float out[3];
        for ( int c = 0; c < 3; ++c )
            out[c] = rf_convert_component( conversion, kind, c, rgb );
        memcpy( rgb, out, sizeof out );
    }
}

double rf_convert_light( const RfColourConversion* conversion, float* rgb, size_t count, size_t stride )
{
    double light = 0.0, outside = 0.0;
    rf_convert_colours( conversion, RF_COLOUR_LIGHT, rgb, count, stride );
    for ( size_t i = 0; i < count && conversion->needed; ++i, rgb += stride )
    {
        for ( int c = 0; c < 3; ++c )
        {
            light += (double)fabsf( rgb[c] );
            outside -= fmin( (double)rgb[c], 0.0 );
            rgb[c] = fmaxf( rgb[c], 0.0f );
        }
    }
    return light > 0.0 ? outside / light : 0.0;
}
