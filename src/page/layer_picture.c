#include "page/layer_picture.h"

#include <math.h>

#define LEVELS 1024
#define NOWHERE 1e9f // depths from here on are of nothing

int rf_look_channels( RfLook look )
{
    return look == RF_LOOK_DEPTH || look == RF_LOOK_SHARE ? 1 : look == RF_LOOK_MOTION ? 2 : 3;
}

static void include( RfLookRange* range, float value )
{
    range->low = fminf( range->low, value );
    range->high = fmaxf( range->high, value );
}

RfLookRange rf_look_range( RfLook look, const float* values, size_t stride, size_t pixels )
{
    RfLookRange range = { INFINITY, look == RF_LOOK_DEPTH ? 0.0f : 1e-6f };
    for ( size_t i = 0; i < pixels; ++i )
    {
        const float* v = values + stride * i;
        if ( look == RF_LOOK_DEPTH && v[0] > 0.0f && v[0] < NOWHERE )
            include( &range, v[0] );
        else if ( look == RF_LOOK_MOTION && isfinite( v[0] ) && isfinite( v[1] ) )
            include( &range, fmaxf( fabsf( v[0] ), fabsf( v[1] ) ) );
        else if ( look == RF_LOOK_SHARE && isfinite( v[0] ) )
            include( &range, v[0] );
    }
    if ( !( range.low < range.high ) )
        range.low = 0.5f * range.high;
    return range;
}

// Light that the sRGB curve turns into each display level.
static void fill_light( float light[LEVELS + 1] )
{
    for ( int i = 0; i <= LEVELS; ++i )
    {
        float level = (float)i / LEVELS;
        light[i] = level <= 0.04045f ? level / 12.92f : powf( ( level + 0.055f ) / 1.055f, 2.4f );
    }
}

// NaN is kept, so that it shows.
static float display( const float light[LEVELS + 1], float level )
{
    return isnan( level ) ? level : light[(int)( LEVELS * fminf( fmaxf( level, 0.0f ), 1.0f ) + 0.5f )];
}

static void draw_pixel( RfLook look, RfLookRange range, const float* v, const float* light, float out[3] )
{
    float level = 0.0f, scale = 0.5f / range.high;
    switch ( look )
    {
        case RF_LOOK_LIGHT:
        case RF_LOOK_DEVIATION:
            for ( int c = 0; c < 3; ++c )
                out[c] = look == RF_LOOK_LIGHT ? v[c] : sqrtf( fmaxf( v[c], 0.0f ) );
            return;
        case RF_LOOK_NORMAL:
        {
            float offset = v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f ? 0.0f : 0.5f;
            for ( int c = 0; c < 3; ++c )
                out[c] = display( light, offset + 0.5f * v[c] );
            return;
        }
        case RF_LOOK_MOTION:
            out[0] = display( light, 0.5f + scale * v[0] );
            out[1] = display( light, 0.5f + scale * v[1] );
            out[2] = display( light, 0.5f );
            return;
        case RF_LOOK_DEPTH:
            if ( v[0] > 0.0f && v[0] < NOWHERE )
                level = 0.1f + 0.9f * ( 1.0f - logf( v[0] / range.low ) / logf( range.high / range.low ) );
            break;
        case RF_LOOK_SHARE: level = v[0] / range.high; break;
    }
    out[0] = out[1] = out[2] = display( light, level );
}

void rf_draw_look( RfLook look, RfLookRange range, const float* values, size_t stride, size_t pixels, float* rgb )
{
    float light[LEVELS + 1];
    fill_light( light );
    for ( size_t i = 0; i < pixels; ++i )
        draw_pixel( look, range, values + stride * i, light, rgb + 3 * i );
}
