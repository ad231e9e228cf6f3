// View transforms: Blender's three by fits of our own, or those of an OpenColorIO configuration.
#include "cli/view/view.h"

#include "base/try.h"
#include "cli/view/view_ocio.h"
#include "image/decode.h"
#include "output/frame_file.h"

#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static void read_text( const char* path, RfKey key, char text[RF_VIEW_NAME_SIZE] )
{
    RfError none;
    if ( rf_read_exr_string( path, rf_key_name( key ), text, RF_VIEW_NAME_SIZE, &none ) != RF_OK )
        text[0] = '\0';
}

// What no scene may ask for (scene/shared_json.h) is not taken from a header either.
static double read_number( const char* path, RfKey key, double least, double most, double otherwise )
{
    double number = rf_read_exr_number( path, rf_key_name( key ) );
    return isfinite( number ) && number >= least && number <= most ? number : otherwise;
}

static RfViewText choose_view( const RfViewOptions* options, const char* path )
{
    RfViewText text = { .exposure = read_number( path, RF_KEY_EXPOSURE, -32.0, 32.0, 0.0 ),
                        .gamma = read_number( path, RF_KEY_GAMMA, 0.01, 100.0, 1.0 ) };
    read_text( path, RF_KEY_VIEW, text.transform );
    read_text( path, RF_KEY_LOOK, text.look );
    if ( options->view != NULL )
    {
        snprintf( text.transform, sizeof text.transform, "%s", options->view );
        text.look[0] = '\0';
    }
    if ( options->look != NULL )
        snprintf( text.look, sizeof text.look, "%s", options->look );
    if ( options->exposure_given )
        text.exposure = options->exposure;
    return text;
}

RfResult rf_open_chosen_view( const RfViewOptions* options, const char* path, RfLog* log, RfView** view, RfViewText* chosen,
                              RfError* error )
{
    RfError why;
    *chosen = choose_view( options, path );
    RfResult result = rf_open_view( chosen, view, &why );
    if ( result == RF_OK )
        return RF_OK;
    if ( result == RF_ERROR_MEMORY || options->view != NULL || options->look != NULL )
        return rf_fail( error, result, "--view: %.500s", why.text );
    rf_warn( log, "%s: shown by the sRGB curve: %.500s", path, why.text );
    chosen->transform[0] = chosen->look[0] = '\0';
    return rf_open_view( chosen, view, error );
}

static void add_light( const RfImage* image, double* sum, double* count )
{
    for ( size_t i = 0; i < (size_t)image->width * (size_t)image->height; ++i )
    {
        const float* rgb = image->rgb + 3 * i;
        double luminance = 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
        if ( !( luminance > 1e-9 && luminance < 1e30 ) )
            continue;
        *sum += log2( luminance );
        *count += 1.0;
    }
}

RfResult rf_find_exposure( const char* const* paths, int count, double* stops, RfError* error )
{
    double sum = 0.0, pixels = 0.0;
    for ( int i = 0; i < count; ++i )
    {
        RfImage image = { 0 };
        RF_TRY( rf_read_exr( paths[i], &image, error ) );
        add_light( &image, &sum, &pixels );
        rf_destroy_image( &image );
    }
    *stops = pixels > 0.0 ? log2( 0.18 ) - sum / pixels : 0.0;
    return RF_OK;
}

#define KNOTS 17

// By Catmull and Rom's spline through values at equal distances over 0 to 1.
static float interpolate( const float* values, float at )
{
    float place = fminf( fmaxf( at, 0.0f ), 1.0f ) * ( KNOTS - 1 );
    int i = (int)fminf( place, KNOTS - 2 );
    float t = place - (float)i, b = values[i], c = values[i + 1];
    float a = i > 0 ? values[i - 1] : 2.0f * b - c, d = i < KNOTS - 2 ? values[i + 2] : 2.0f * c - b;
    return b + 0.5f * t * ( c - a + t * ( 2.0f * a - 5.0f * b + 4.0f * c - d + t * ( 3.0f * ( b - c ) + d - a ) ) );
}

static void transform( const float m[3][3], float rgb[3] )
{
    float in[3] = { rgb[0], rgb[1], rgb[2] };
    for ( int i = 0; i < 3; ++i )
        rgb[i] = m[i][0] * in[0] + m[i][1] * in[1] + m[i][2] * in[2];
}

// Logarithm of light, 0 to 1 over `stops` from LEAST on.
#define LEAST ( -12.47393f )
#define STOPS 16.5f

static float to_log( float light, float stops ) { return ( log2f( fmaxf( light, 1.7e-4f ) ) - LEAST ) / stops; }

// Filmic: a curve for each channel, over 16.5 stops. Measured at each knot with Blender 3.4; between them and in other colours below
// a radiance of 16 it is within 0.5/255 of it.

typedef struct FilmicLook
{
    const char* name;
    float curve[KNOTS];
} FilmicLook;

// clang-format off
static const FilmicLook s_filmic[] = {
    { "Medium Contrast", { 0.00000f, 0.00448f, 0.01180f, 0.02368f, 0.04277f, 0.07296f, 0.11941f, 0.18803f, 0.28332f, 0.40471f,
                           0.54240f, 0.67869f, 0.79727f, 0.88742f, 0.94775f, 0.98303f, 1.00000f } },
    { "Very High Contrast", { 0.00000f, 0.00034f, 0.00111f, 0.00294f, 0.00724f, 0.01721f, 0.03996f, 0.08964f, 0.18872f, 0.35464f,
                              0.56526f, 0.75548f, 0.88129f, 0.94828f, 0.97987f, 0.99392f, 1.00000f } },
    { "High Contrast", { 0.00000f, 0.00104f, 0.00312f, 0.00734f, 0.01579f, 0.03253f, 0.06489f, 0.12464f, 0.22604f, 0.37563f,
                         0.55585f, 0.72616f, 0.85342f, 0.93183f, 0.97352f, 0.99286f, 1.00000f } },
    { "Medium High Contrast", { 0.00000f, 0.00217f, 0.00614f, 0.01335f, 0.02634f, 0.04939f, 0.08919f, 0.15477f, 0.25485f, 0.39088f,
                                0.54876f, 0.70114f, 0.82413f, 0.90877f, 0.95991f, 0.98737f, 1.00000f } },
    { "Medium Low Contrast", { 0.00000f, 0.00716f, 0.01801f, 0.03432f, 0.05857f, 0.09402f, 0.14452f, 0.21389f, 0.30443f, 0.41481f,
                               0.53743f, 0.65956f, 0.77101f, 0.86235f, 0.92972f, 0.97428f, 1.00000f } },
    { "Low Contrast", { 0.00000f, 0.01154f, 0.02754f, 0.04956f, 0.07956f, 0.11986f, 0.17292f, 0.24090f, 0.32493f, 0.42406f,
                        0.53258f, 0.64111f, 0.74552f, 0.83774f, 0.91201f, 0.96587f, 1.00000f } },
    { "Very Low Contrast", { 0.00000f, 0.01735f, 0.03936f, 0.06718f, 0.10211f, 0.14562f, 0.19922f, 0.26425f, 0.34159f, 0.43119f,
                             0.52804f, 0.62377f, 0.72105f, 0.81352f, 0.89437f, 0.95776f, 1.00000f } },
};
// clang-format on

#define FILMIC_COUNT ( sizeof s_filmic / sizeof s_filmic[0] )

static void apply_filmic( const float curve[KNOTS], float rgb[3] )
{
    for ( int c = 0; c < 3; ++c )
        rgb[c] = interpolate( curve, to_log( rgb[c], STOPS ) );
}

// AgX: colours are drawn towards grey, pass a curve over 16.5 stops, and are spread again. Fitted to Blender 4.3 by least squares over
// colours of 2^-10 to 2^4.5: the mean error is 0.25/255, 1 in 20 is above 1/255, saturated ones are up to 13/255 off.

static const float s_agx_in[3][3] = { { 0.47815f, 0.29495f, 0.08358f },
                                      { 0.11254f, 0.64380f, 0.10263f },
                                      { 0.08143f, 0.16232f, 0.61428f } };
static const float s_agx_out[3][3] = { { 1.81552f, -0.71998f, -0.14541f },
                                       { -0.25098f, 1.24929f, -0.04919f },
                                       { -0.17663f, -0.25729f, 1.38385f } };
static const float s_agx_curve[KNOTS] = { 0.01409f, 0.01676f, 0.02897f, 0.04764f, 0.07237f, 0.10539f,
                                          0.15066f, 0.21415f, 0.30379f, 0.42803f, 0.57683f, 0.70757f,
                                          0.81005f, 0.88817f, 0.94740f, 0.99293f, 1.02819f };

static void apply_agx( float rgb[3] )
{
    transform( s_agx_in, rgb );
    for ( int c = 0; c < 3; ++c )
        rgb[c] = powf( fmaxf( interpolate( s_agx_curve, to_log( rgb[c], STOPS ) ), 0.0f ), 2.4f );
    transform( s_agx_out, rgb );
    for ( int c = 0; c < 3; ++c )
        rgb[c] = rf_linear_to_srgb( rgb[c] );
}

// The looks of AgX work on the logarithm of Rec. 2020 drawn towards grey, over 25 stops, in which middle grey is at PIVOT.

#define LOOK_STOPS 25.0f
#define PIVOT 0.4f

typedef struct AgxLook
{
    const char* name;
    float contrast, saturation;
    bool grey, punchy;
} AgxLook;

static const AgxLook s_agx_looks[] = {
    { "Base Contrast", 1.0f, 1.0f, false, false },
    { "Very High Contrast", 1.57f, 0.9f, false, false },
    { "High Contrast", 1.4f, 0.95f, false, false },
    { "Medium High Contrast", 1.2f, 1.0f, false, false },
    { "Medium Low Contrast", 0.9f, 1.05f, false, false },
    { "Low Contrast", 0.8f, 1.1f, false, false },
    { "Very Low Contrast", 0.7f, 1.15f, false, false },
    { "Punchy", 1.0f, 1.0f, false, true },
    { "Greyscale", 1.0f, 1.0f, true, false },
};

#define AGX_LOOK_COUNT ( sizeof s_agx_looks / sizeof s_agx_looks[0] )

static const float s_look_in[3][3] = { { 0.54481f, 0.37379f, 0.08140f },
                                       { 0.14042f, 0.75414f, 0.10545f },
                                       { 0.08881f, 0.17887f, 0.73232f } };
static const float s_look_out[3][3] = { { 2.11450f, -1.02740f, -0.08710f },
                                        { -0.37052f, 1.55293f, -0.18243f },
                                        { -0.16593f, -0.25471f, 1.42064f } };

// Deeper shadows, and a power of 1.0912, by the logarithm.
static const float s_punchy[KNOTS] = { 0.07489f, 0.07874f, 0.08355f, 0.10284f, 0.16217f, 0.26094f, 0.34136f, 0.40573f, 0.46937f,
                                       0.53374f, 0.59878f, 0.66440f, 0.73058f, 0.79726f, 0.86441f, 0.93200f, 1.00000f };

static void apply_agx_look( const AgxLook* look, float rgb[3] )
{
    transform( s_look_in, rgb );
    for ( int c = 0; c < 3; ++c )
    {
        float place = to_log( rgb[c], LOOK_STOPS );
        rgb[c] = ( ( look->punchy ? interpolate( s_punchy, place ) : place ) - PIVOT ) * look->contrast + PIVOT;
    }
    float mean = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
    for ( int c = 0; c < 3; ++c )
        rgb[c] = exp2f( ( mean + look->saturation * ( rgb[c] - mean ) ) * LOOK_STOPS + LEAST );
    if ( look->grey )
        rgb[0] = rgb[1] = rgb[2] = 0.26582f * rgb[0] + 0.59847f * rgb[1] + 0.13571f * rgb[2];
    transform( s_look_out, rgb );
}

typedef enum ViewKind
{
    VIEW_STANDARD,
    VIEW_FILMIC,
    VIEW_AGX,
    VIEW_CONFIGURED,
} ViewKind;

struct RfView
{
    ViewKind kind;
    const float* curve; // of Filmic
    const AgxLook* look;
    RfOcioView* configured;
    float gain, inverse_gamma;
};

static const char* const s_own[] = { "Standard", "Filmic", "AgX" };

// "Punchy" or "AgX - Punchy".
static bool is_look( const char* name, const char* transform, const char* look )
{
    size_t length = strlen( transform );
    bool begins = strncasecmp( look, transform, length ) == 0 && strncmp( look + length, " - ", 3 ) == 0;
    return strcasecmp( begins ? look + length + 3 : look, name ) == 0;
}

static RfResult no_look( const RfViewText* text, const char* names, RfError* error )
{
    return rf_fail( error, RF_ERROR_USAGE, "unknown look '%.60s' of the view '%.60s', expected %.400s", text->look,
                    text->transform, names );
}

static RfResult find_own_look( const RfViewText* text, RfView* view, RfError* error )
{
    char names[300] = "none";
    size_t end = 0, count = view->kind == VIEW_FILMIC ? FILMIC_COUNT : view->kind == VIEW_AGX ? AGX_LOOK_COUNT : 0;
    view->curve = s_filmic[0].curve;
    if ( text->look[0] == '\0' )
        return RF_OK;
    for ( size_t i = 0; i < count; ++i )
    {
        const char* name = view->kind == VIEW_FILMIC ? s_filmic[i].name : s_agx_looks[i].name;
        end += (size_t)snprintf( names + end, sizeof names - end, "%s'%s'", i > 0 ? ", " : "", name );
        if ( !is_look( name, s_own[view->kind], text->look ) )
            continue;
        view->curve = view->kind == VIEW_FILMIC ? s_filmic[i].curve : NULL;
        view->look = view->kind == VIEW_AGX && i > 0 ? s_agx_looks + i : NULL;
        return RF_OK;
    }
    return no_look( text, names, error );
}

// `others`: the views of a configuration, "" where there is none.
static RfResult find_own( const RfViewText* text, const char* others, RfView* view, RfError* error )
{
    for ( int i = 0; i < 3; ++i )
    {
        if ( strcasecmp( text->transform, s_own[i] ) != 0 )
            continue;
        view->kind = (ViewKind)i;
        return find_own_look( text, view, error );
    }
    return rf_fail( error, RF_ERROR_USAGE, "unknown view '%.60s', expected Standard, Filmic, AgX%s%.400s", text->transform,
                    others[0] != '\0' ? "; in the configuration " : "", others );
}

#ifdef REFRAME_OCIO

// The configuration of $OCIO, none where that is empty, else of Debian's or another packaged Blender; the newest of several. False:
// there is none.
static bool find_config( char* path, size_t size )
{
    const char* given = getenv( "OCIO" );
    if ( given != NULL )
        return given[0] != '\0' && snprintf( path, size, "%s", given ) < (int)size;
    glob_t found = { 0 };
    glob( "/usr/share/blender/datafiles/colormanagement/config.ocio", 0, NULL, &found );
    glob( "/usr/share/blender/[0-9]*/datafiles/colormanagement/config.ocio", GLOB_APPEND, NULL, &found );
    bool fits = found.gl_pathc > 0 && snprintf( path, size, "%s", found.gl_pathv[found.gl_pathc - 1] ) < (int)size;
    globfree( &found );
    return fits;
}

static RfResult find_view( const RfViewText* text, RfView* view, RfError* error )
{
    char path[4096], message[400] = "";
    bool plain = strcasecmp( text->transform, s_own[VIEW_STANDARD] ) == 0 && text->look[0] == '\0';
    if ( plain || !find_config( path, sizeof path ) )
        return find_own( text, "", view, error );
    switch ( rf_ocio_open( path, text->transform, text->look, &view->configured, message, sizeof message ) )
    {
        case RF_OCIO_OK: view->kind = VIEW_CONFIGURED; return RF_OK;
        case RF_OCIO_NO_VIEW: return find_own( text, message, view, error );
        case RF_OCIO_NO_LOOK: return no_look( text, message, error );
        case RF_OCIO_FAILED: break;
    }
    return rf_fail( error, RF_ERROR_FORMAT, "%.200s: OpenColorIO cannot read it: %.300s", path, message );
}

#else

static RfResult find_view( const RfViewText* text, RfView* view, RfError* error ) { return find_own( text, "", view, error ); }

#endif

RfResult rf_open_view( const RfViewText* text, RfView** view, RfError* error )
{
    RfViewText named = *text;
    *view = NULL;
    if ( named.transform[0] == '\0' )
        snprintf( named.transform, sizeof named.transform, "Standard" );
    if ( named.gamma == 0.0 )
        named.gamma = 1.0;
    if ( strcasecmp( named.look, "None" ) == 0 )
        named.look[0] = '\0';
    float gain = (float)exp2( named.exposure ), inverse = (float)( 1.0 / named.gamma );
    if ( !( gain > 0.0f && gain < INFINITY ) || !( inverse > 0.0f && inverse < 1e6f ) )
        return rf_fail( error, RF_ERROR_USAGE, "a view of %g stops and a gamma of %g is not possible", named.exposure,
                        named.gamma );
    RfView* opened = calloc( 1, sizeof *opened );
    if ( opened == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a view" );
    opened->gain = gain;
    opened->inverse_gamma = inverse;
    RfResult result = find_view( &named, opened, error );
    if ( result == RF_OK )
        *view = opened;
    else
        free( opened );
    return result;
}

void rf_close_view( RfView* view )
{
#ifdef REFRAME_OCIO
    if ( view != NULL )
        rf_ocio_close( view->configured );
#endif
    free( view );
}

static void apply_own( const RfView* view, float rgb[3] )
{
    switch ( view->kind )
    {
        case VIEW_FILMIC: apply_filmic( view->curve, rgb ); break;
        case VIEW_AGX:
            if ( view->look != NULL )
                apply_agx_look( view->look, rgb );
            apply_agx( rgb );
            break;
        case VIEW_STANDARD:
            for ( int c = 0; c < 3; ++c )
                rgb[c] = rf_linear_to_srgb( rgb[c] );
            break;
        case VIEW_CONFIGURED: break;
    }
}

void rf_apply_view( const RfView* view, float* rgb, int count )
{
    for ( int i = 0; i < 3 * count; ++i )
        rgb[i] = fminf( fmaxf( rgb[i] * view->gain, -1e6f ), 1e6f ); // sums of infinities are no numbers
#ifdef REFRAME_OCIO
    if ( view->configured != NULL )
        rf_ocio_apply( view->configured, rgb, count );
#endif
    for ( int i = 0; i < count; ++i )
        apply_own( view, rgb + 3 * i );
    for ( int i = 0; i < 3 * count; ++i )
    {
        float value = fminf( fmaxf( rgb[i], 0.0f ), 1.0f );
        rgb[i] = view->inverse_gamma != 1.0f ? powf( value, view->inverse_gamma ) : value;
    }
}

void rf_fill_view_cube( const RfView* view, unsigned char* bytes )
{
    float light[RF_VIEW_CUBE_SIZE];
    for ( int i = 0; i < RF_VIEW_CUBE_SIZE; ++i )
        light[i] = exp2f( -9.0f + 15.0f * (float)i / ( RF_VIEW_CUBE_SIZE - 1 ) ) - 1.0f / 512.0f;
    for ( int i = 0; i < RF_VIEW_CUBE_BYTES / 3; ++i )
    {
        float rgb[3] = { light[i % RF_VIEW_CUBE_SIZE], light[i / RF_VIEW_CUBE_SIZE % RF_VIEW_CUBE_SIZE],
                         light[i / ( RF_VIEW_CUBE_SIZE * RF_VIEW_CUBE_SIZE )] };
        rf_apply_view( view, rgb, 1 );
        for ( int c = 0; c < 3; ++c )
            bytes[3 * i + c] = (unsigned char)( 255.0f * rgb[c] + 0.5f );
    }
}
