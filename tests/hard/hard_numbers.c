// Input cases of numbers: long sums, 16-bit floats, rounding modes, subnormals.
#include "base/float_mode.h"
#include "base/float_traps.h"
#include "hard/hard_inputs.h"
#include "bsdf/bsdf.h"
#include "film/film.h"
#include "image/half.h"
#include "math/fastmath.h"
#include "scene/projection.h"

#include <fenv.h>
#include <math.h>

// The sum of 2^20 samples of a constant by a film, as renders add them up.
static HardInput long_sums( void )
{
    HardInput out = { 0 };
    double worst = 0.0;
    static const float values[] = { 0.1f, 1.0f / 3.0f, 1e-30f, 1e30f };
    for ( int v = 0; v < 4; ++v )
    {
        float half[2][4] = { { 0 } }, rgb[3], weight;
        uint64_t mean = 0;
        RfFilm film = { .width = 1, .height = 1, .half = { half[0], half[1] }, .mean = &mean, .block = rf_film_block( 1 ) };
        for ( int pass = 0; pass < 1 << 20; ++pass )
        {
            for ( int c = 0; c < 4; ++c )
                film.half[pass & 1][c] += c < 3 ? values[v] : 1.0f;
            rf_end_film_pass( &film, pass & 1, 1.0 );
        }
        rf_combine_film( &film, RF_NORMALIZE_CROSSFIT, rgb, &weight );
        worst = fmax( worst, fabs( (double)rgb[0] / (double)values[v] - 1.0 ) );
        worst = fmax( worst, fabs( (double)weight - 1.0 ) );
    }
    out.holds = worst < 1e-5;
    HARD_TELL( "2^20 samples of a constant: off by %.2g", worst );
}

// All 16-bit floats there and back, and what lies beyond them.
static HardInput halves( void )
{
    HardInput out = { .holds = true };
    int traps = rf_pause_float_traps(); // NaN are compared
    for ( uint32_t bits = 0; bits < 0x10000u; ++bits )
    {
        float value = rf_half_to_float( (uint16_t)bits );
        if ( !isnan( value ) && rf_float_to_half( value ) != bits )
            out.holds = false;
    }
    static const float beyond[] = { 65504.1f, 65519.9f, 65520.0f, 1e6f, 3.4e38f };
    for ( int i = 0; i < 5; ++i )
    {
        out.holds = out.holds && rf_half_to_float( rf_float_to_half( rf_clamp_half( beyond[i] ) ) ) == 65504.0f;
        out.holds = out.holds && rf_half_to_float( rf_float_to_half( rf_clamp_half( -beyond[i] ) ) ) == -65504.0f;
    }
    out.holds = out.holds && isinf( rf_clamp_half( INFINITY ) ) && isnan( rf_clamp_half( NAN ) );
    rf_resume_float_traps( traps );
    HARD_TELL( "65536 halves there and back; finite values beyond 65504 are 65504" );
}

static double mean_picture( const RfTracer* tracer, const HardScene* h, int group )
{
    RfRenderSettings s = plain_settings();
    s.group = group;
    rf_parse_tile( group > 0 ? "3x3" : "1", &s.tile );
    s.spp = 7;
    s.max_depth = 4;
    s.threads = 1;
    AUTO_BY( free_rendered ) Rendered r = render_all( tracer, h->eyes, h->eye_count, &s );
    double sum = 0.0;
    for ( size_t i = 0; i < 3 * r.pixels * (size_t)r.count; ++i )
        sum += (double)r.rgb[i];
    sum /= (double)( 3 * r.pixels * (size_t)r.count );
    return sum;
}

// The same picture in whatever rounding mode the caller is: the numbers of a seed are the same. (A scene that is made in
// another mode has other zeros, negative ones, and so other noise.)
static HardInput rounding_modes( void )
{
    static const int modes[] = { FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO };
    HardInput out = { 0 };
    HardScene h = { .eye_count = 7 };
    hard_stage( &h, make_phong( 0.3f, 0.5f, 200.0f ) );
    AUTO_TRACER tracer = make_tracer( &h.scene );
    double means[2][4], worst = 0.0;
    for ( int m = 0; m < 8; ++m )
    {
        double* mean = means[m % 2];
        fesetround( modes[m / 2] );
        mean[m / 2] = mean_picture( tracer, &h, 3 * ( m % 2 ) );
        fesetround( FE_TONEAREST );
        worst = isfinite( mean[m / 2] ) ? fmax( worst, fabs( mean[m / 2] / mean[0] - 1.0 ) ) : INFINITY;
    }
    rf_destroy_scene( &h.scene );
    out.holds = worst < 1e-5;
    HARD_TELL( "means of pictures under four rounding modes: within %.2g", worst );
}

// Scattering models and densities with subnormal inputs, with and without flush to zero. What is flushed is below 1.2e-38, and
// exponents of 1e7 multiply it: differences below 1e-30 do not count.
static HardInput subnormals( void )
{
    HardInput out = { .holds = true };
    bool flushed = rf_flush_subnormals( false );
    double worst = 0.0;
    for ( uint32_t i = 0; i < HARD_MANY; ++i )
    {
        rf_flush_subnormals( false );                                            // renders leave it on
        volatile float drawn = powf( 10.0f, -36.0f - 9.0f * hard_even( i, 0 ) ); // down to 1e-45; read anew in each mode
        float value[2][4], tiny = drawn;
        RfVec3 n = rf_vec3( tiny, 1.0f, -tiny ),
               wi = rf_normalize( rf_vec3( hard_even( i, 1 ) - 0.5f, hard_even( i, 2 ), tiny ) );
        RfVec3 wo = rf_normalize( rf_vec3( tiny, hard_even( i, 3 ), hard_even( i, 4 ) - 0.5f ) );
        float shape = i % 2 == 0 ? 1e7f * hard_even( i, 5 ) : RF_MIN_ALPHA, diffuse = tiny, specular = hard_even( i, 6 ),
              one = 1.0f, coat = 0.04f;
        RfBsdfLanes lanes = { .n = { &n.x, &n.y, &n.z } };
        for ( int p = 0; p < 3; ++p )
        {
            lanes.param[RF_PARAM_DIFFUSE + p] = &diffuse;
            lanes.param[RF_PARAM_SPECULAR + p] = &specular;
        }
        lanes.param[RF_PARAM_SHAPE] = &shape;
        lanes.param[RF_PARAM_F90] = lanes.param[RF_PARAM_COAT_F90] = &one;
        lanes.param[RF_PARAM_COAT_F0] = &coat;
        const float *o[3] = { &wo.x, &wo.y, &wo.z }, *d[3] = { &wi.x, &wi.y, &wi.z };
        for ( int flush = 0; flush < 2; ++flush )
        {
            rf_flush_subnormals( flush == 1 );
            tiny = drawn;
            float f[3], *to[3] = { f, f + 1, f + 2 };
            rf_bsdf_evaluate( i % 2 == 0 ? RF_BSDF_PHONG : RF_BSDF_GGX, 1, &lanes, o, d, to, &value[flush][0] );
            value[flush][1] = f[0];
            RfEye eye = { .forward = { 0, 0, -1 },
                          .right = { 1, 0, 0 },
                          .up = { 0, 1, 0 },
                          .focal = 10,
                          .focal_x = 10,
                          .axis_x = 8,
                          .axis_y = 6,
                          .width = 16,
                          .height = 12 };
            value[flush][2] = rf_project( &eye, rf_vec3( tiny, 0, -tiny ), rf_vec3( 0, 0, 1 ) ).density;
            value[flush][3] = rf_pow_one_minus( tiny, shape );
        }
        rf_flush_subnormals( flushed );
        for ( int k = 0; k < 2; ++k ) // of what is flushed an eye cannot tell how near it is: a density in its range
            out.holds = out.holds && value[k][2] >= RF_MIN_DENSITY && value[k][2] <= RF_MAX_DENSITY;
        for ( int k = 0; k < 4; k += k == 1 ? 2 : 1 )
        {
            double a = (double)value[0][k], b = (double)value[1][k];
            out.holds = out.holds && isfinite( a ) && isfinite( b ) && a >= 0.0 && b >= 0.0;
            worst = fmax( worst, fabs( a - b ) / fmax( fmax( fabs( a ), fabs( b ) ), 1e-24 ) );
        }
    }
    out.holds = out.holds && worst < 1e-6;
    HARD_TELL( "%.1f million evaluations with subnormals: with and without flush to zero within %.2g", HARD_MANY / 1e6, worst );
}

const HardCase g_hard_numbers[] = {
    { "long-sums", "sums of 2^20 samples of a constant", "a float that grows by less than its spacing", HARD_INPUT, 0, NULL,
      long_sums },
    { "halves-beyond-65504", "16-bit floats of values beyond 65504", "infinities in files", HARD_INPUT, 0, NULL, halves },
    { "rounding-modes", "renders under the other three rounding modes", "tricks that need rounding to nearest", HARD_INPUT, 0,
      NULL, rounding_modes },
    { "subnormals", "subnormal inputs, with and without flush to zero", "quotients of what is flushed", HARD_INPUT, 0, NULL,
      subnormals },
    { 0 },
};
