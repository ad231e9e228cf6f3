// Input cases of eyes: projections, frames of eyes, eyes that cannot be used.
#include "base/float_traps.h"
#include "hard/hard_inputs.h"
#include "scene/projection.h"

#include <math.h>

// Points on the film's border and on corners of pixels, on their rays: their projection must be where the ray started, but for
// rounding, never outside the film, nor a pixel beside it that the place does not touch.
static HardInput film_corners( void )
{
    HardInput out = { 0 };
    static const int sizes[][2] = { { 16384, 1 }, { 640, 480 }, { 1, 1 }, { 4096, 2160 } };
    static const double angles[] = { 1.0, 50.0, 170.0 };
    double worst = 0.0;
    long lost = 0, all = 0;
    for ( int s = 0; s < 12; ++s )
    {
        int w = sizes[s / 3][0], hgt = sizes[s / 3][1];
        RfVec3 forward = rf_vec3( 0.3f, -0.4f, -1.0f );
        RfEye eye = rf_make_eye( rf_vec3( 1.5f, 0.7f, -2.0f ), forward, rf_vec3( 0, 1, 0 ),
                                 angles[s % 3] * 3.14159265358979 / 180.0, w, hgt );
        const float inverse[2] = { 1.0f / eye.focal_x, 1.0f / eye.focal };
        for ( uint32_t i = 0; i < HARD_MANY; ++i, ++all )
        {
            int x = (int)( hard_even( i, 0 ) * (float)w ), y = (int)( hard_even( i, 1 ) * (float)hgt );
            x = i % 8 == 0 ? 0 : i % 8 == 1 ? w - 1 : x;
            y = i % 8 == 2 ? 0 : i % 8 == 3 ? hgt - 1 : y;
            float u = i % 3 == 0   ? 0.0f
                      : i % 3 == 1 ? 0x1.fffffep-1f
                                   : hard_even( i, 2 ),
                  v = i % 5 == 0   ? 0.0f
                      : i % 5 == 1 ? 0x1.fffffep-1f
                                   : 0.5f;
            RfVec3 d = rf_pinhole_ray( &eye, inverse, x, y, u, v ), p = rf_madd( eye.origin, d, 3.0f );
            RfProjection at = rf_project( &eye, p, rf_scale( d, -1.0f ) );
            lost += !at.seen;
            if ( !at.seen )
                continue;
            double off = fmax( fabs( (double)at.x + (double)at.u - (double)x - (double)u ) / w,
                               fabs( (double)at.y + (double)at.v - (double)y - (double)v ) / hgt );
            off /= 1.0 + (double)( eye.width > eye.height ? eye.width : eye.height ) /
                             (double)eye.focal; // steep rays turn rounding into more
            worst = fmax( worst, off );
            if ( at.x < 0 || at.x >= w || at.y < 0 || at.y >= hgt ||
                 !( at.u >= 0.0f && at.u <= 1.0f && at.v >= 0.0f && at.v <= 1.0f ) ||
                 !( at.density >= RF_MIN_DENSITY && at.density <= RF_MAX_DENSITY ) )
                HARD_TELL( "ray %u of film %dx%d lands outside", i, w, hgt );
        }
    }
    out.holds = worst < 1e-5 && lost < all / 2;
    HARD_TELL( "%.1f million hits: off by %.2g of the film at most, %ld rounded out of it at its border", (double)all / 1e6,
               worst, lost );
}

// Frames of eyes whose up vector is as good as parallel to the view: unit vectors at right angles.
static HardInput eye_frames( void )
{
    HardInput out = { 0 };
    double worst = 0.0;
    for ( uint32_t i = 0; i < HARD_MANY; ++i )
    {
        float off = powf( 10.0f, -1.0f - 5.5f * hard_even( i, 0 ) ), sign = i % 2 == 0 ? 1.0f : -1.0f;
        RfVec3 f = rf_vec3( hard_even( i, 1 ) - 0.5f, hard_even( i, 2 ) - 0.5f, 0.1f + hard_even( i, 3 ) );
        RfVec3 up = rf_vec3( sign * f.x + off, sign * f.y - off * hard_even( i, 4 ), sign * f.z );
        RfEye e = rf_make_eye( rf_vec3( 0, 0, 0 ), f, up, 1.0, 4, 4 );
        const RfVec3 axes[3] = { e.right, e.up, e.forward };
        for ( int k = 0; k < 9; ++k )
            worst = fmax( worst, fabs( (double)rf_dot( axes[k / 3], axes[k % 3] ) - ( k / 3 == k % 3 ? 1.0 : 0.0 ) ) );
    }
    out.holds = worst < 1e-6;
    HARD_TELL( "%.1f million eyes with up vectors 0.1 to 3e-7 off the view: axes at right angles within %.2g", HARD_MANY / 1e6,
               worst );
}

// Whatever point and normal: the density is a number in its range, and the pixel is on the film.
static HardInput projections( void )
{
    HardInput out = { .holds = true };
    long seen = 0;
    for ( uint32_t i = 0; i < 4 * HARD_MANY; ++i )
    {
        float scale = powf( 10.0f, 76.0f * hard_even( i, 0 ) - 38.0f ), far = powf( 10.0f, 76.0f * hard_even( i, 1 ) - 38.0f );
        RfVec3 o = rf_vec3( scale * hard_even( i, 2 ), scale * hard_even( i, 3 ), -scale * hard_even( i, 4 ) );
        RfEye eye = rf_make_eye( o, rf_vec3( hard_even( i, 5 ) - 0.5f, hard_even( i, 6 ) - 0.5f, hard_even( i, 7 ) - 0.501f ),
                                 rf_vec3( 0, 1, 0 ), (double)( 1e-4f + 3.1f * hard_even( i, 8 ) ), 16, 12 );
        RfVec3 way =
            rf_madd( rf_madd( rf_scale( eye.forward, far ), eye.right, 0.1f * far * hard_even( i, 10 ) ), eye.up, far * 1e-3f );
        RfVec3 x = rf_add( o, way ),
               n = rf_normalize( rf_vec3( hard_even( i, 11 ) - 0.5f, hard_even( i, 12 ) - 0.5f, hard_even( i, 13 ) - 0.5f ) );
        RfProjection at = rf_project( &eye, x, n );
        bool fits = at.density >= RF_MIN_DENSITY && at.density <= RF_MAX_DENSITY;
        if ( !fits || at.x < 0 || at.x >= 16 || at.y < 0 || at.y >= 12 )
        {
            out.holds = false;
            HARD_TELL( "density %g of point %u, distance %g", (double)at.density, i, (double)far );
        }
        seen += at.seen;
    }
    out.holds = seen > HARD_MANY / 100;
    HARD_TELL( "%.1f million points at 1e-38 to 1e38 m: all densities within [1e-24, 1e30]", 4.0 * HARD_MANY / 1e6 );
}

// Points at 1e38 m have products that are no numbers, which the range of densities is for.
static HardInput projections_untrapped( void )
{
    int traps = rf_pause_float_traps();
    HardInput found = projections();
    rf_resume_float_traps( traps );
    return found;
}

// Eyes whose rays would not be numbers are refused; Embree ends the process where it is given such a ray.
static HardInput unusable_eyes( void )
{
    HardInput out = { .holds = true };
    HardScene h = { .eye_count = 7 };
    hard_stage( &h, hard_grey() );
    AUTO_TRACER tracer = make_tracer( &h.scene );
    RfRenderSettings s = plain_settings();
    s.spp = s.threads = 1;
    s.group = 0;
    int refused = 0;
    for ( int k = 0; k < 6; ++k )
    {
        RfEye eye = h.eyes[3];
        RfError error;
        eye.origin.x = k == 0 ? NAN : eye.origin.x;
        eye.up.y = k == 1 ? INFINITY : eye.up.y;
        eye.focal = k == 2 ? 0.0f : eye.focal;
        if ( k >= 3 )
            rf_set_lens( &eye, k == 5 ? INFINITY : 0.1, k == 3 ? 0.0 : k == 4 ? NAN : 1.0, 0, 0.0 );
        refused += rf_render( &( RfShot ){ tracer, &eye, 1, &( int ){ 0 }, 1 }, &s, NULL, NULL, &error ) == RF_ERROR_USAGE;
    }
    const RfVec3 o = h.eyes[3].origin, z = rf_vec3( 0, 0, -1 ), y = rf_vec3( 0, 1, 0 ), none = rf_vec3( 0, 0, 0 );
    const int width = h.eyes[3].width, height = h.eyes[3].height;
    RfEye made[] = { rf_make_eye( o, none, y, 1.0, width, height ),
                     rf_make_eye( o, z, none, 1.0, width, height ),
                     rf_make_eye( o, z, rf_vec3( 0, 0, 3 ), 1.0, width, height ),
                     rf_make_eye( o, rf_vec3( 0, NAN, 0 ), y, 1.0, width, height ),
                     rf_make_eye( o, z, y, 0.0, width, height ),
                     rf_make_eye( o, z, y, -1.0, width, height ),
                     rf_make_eye( o, z, y, 1.0, 0, height ),
                     rf_make_orthographic_eye( o, z, y, 0.0, width, height ),
                     rf_make_orthographic_eye( o, none, y, 1.0, width, height ),
                     rf_make_panoramic_eye( o, y, y, width, height ),
                     rf_make_eye( o, z, y, 1.0, width, height ),
                     rf_make_eye( o, z, y, 1.0, width, height ),
                     rf_make_eye( o, z, y, 1.0, width, height ) };
    const int count = (int)( sizeof made / sizeof made[0] );
    rf_shift_eye( made + count - 1, 0.0, 0.0, 0.0 );
    rf_set_shutter( made + count - 2, made, made + count - 3 );
    made[count - 3].projection = 7;
    for ( int k = 0; k < count; ++k )
    {
        RfError error;
        refused += rf_render( &( RfShot ){ tracer, made + k, 1, &( int ){ 0 }, 1 }, &s, NULL, NULL, &error ) == RF_ERROR_USAGE;
    }
    out.holds = refused == 6 + count;
    rf_destroy_scene( &h.scene );
    HARD_TELL( "a focus of 0, eyes that are not finite or degenerate: %d of %d refused by a message", refused, 6 + count );
}

const HardCase g_hard_projections[] = {
    { "film-corners", "hits on the border of the film and on corners of pixels, there and back", "places beyond the film",
      HARD_INPUT, 0, NULL, film_corners },
    { "eye-frames", "up vectors as good as parallel to the view", "a cross product that cancels", HARD_INPUT, 0, NULL,
      eye_frames },
    { "focus-0", "a lens focused at 0 m, eyes that are not finite or without a direction",
      "x/0 in the shear of the film; rays that are no numbers", HARD_INPUT, 0, NULL, unusable_eyes },
    { "density-range", "points at any distance, any normal", "products and quotients of densities beyond floats", HARD_INPUT, 0,
      NULL, projections_untrapped },
    { 0 },
};
