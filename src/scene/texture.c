// Texture lookup (bilinear or nearest) with wrap modes, and bounds of a texture over a range of coordinates.
#include "scene/texture.h"

#include <math.h>
#include <stddef.h>

// Beyond this pixel coordinate a float has no fraction left.
#define MAX_PIXEL 1e9f

// rf_texture_bound examines up to this many texels individually.
#define MAX_SCANNED 4096

void rf_set_uv_transform( const double by[5], float transform[6] )
{
    const double *offset = by, *scale = by + 3, rotation = by[2];
    const double t[6] = { cos( rotation ) * scale[0],  sin( rotation ) * scale[1], offset[0],
                          -sin( rotation ) * scale[0], cos( rotation ) * scale[1], offset[1] };
    for ( int i = 0; i < 6; ++i )
        transform[i] = (float)t[i];
}

void rf_transform_uv( const RfTextureRef* ref, const float uv[2], float out[2] )
{
    const float* t = ref->transform;
    out[0] = t[0] * uv[0] + t[1] * uv[1] + t[2];
    out[1] = t[3] * uv[0] + t[4] * uv[1] + t[5];
}

static int wrap_index( RfWrap wrap, int i, int size )
{
    if ( i >= 0 && i < size )
        return i;
    if ( wrap == RF_WRAP_CLAMP )
        return i < 0 ? 0 : size - 1;
    int period = wrap == RF_WRAP_MIRROR ? 2 * size : size;
    i %= period;
    i = i < 0 ? i + period : i;
    return i < size ? i : period - 1 - i;
}

static void fetch( const RfTexture* t, int x, int y, float rgba[4] )
{
    size_t at = ( (size_t)y * (size_t)t->width + (size_t)x ) * (size_t)t->channels;
    int colours = t->channels < 3 ? 1 : 3;
    bool alpha = t->channels == 2 || t->channels == 4;
    for ( int c = 0; c < 3; ++c )
    {
        size_t k = at + (size_t)( colours == 3 ? c : 0 );
        rgba[c] = t->bytes != NULL ? t->table[t->bytes[k]] : t->floats[k];
    }
    size_t k = at + (size_t)colours;
    rgba[3] = !alpha ? 1.0f : t->bytes != NULL ? (float)t->bytes[k] * ( 1.0f / 255.0f ) : t->floats[k];
}

static float to_pixels( float u, int size )
{
    float x = u * (float)size;
    return fabsf( x ) <= MAX_PIXEL ? x : 0.0f; // also false for NaN
}

void rf_look_up( const RfTexture* t, const RfTextureRef* ref, const float at[2], float rgba[4] )
{
    float x = to_pixels( at[0], t->width ), y = to_pixels( at[1], t->height );
    if ( ref->nearest )
    {
        fetch( t, wrap_index( ref->wrap[0], (int)floorf( x ), t->width ), wrap_index( ref->wrap[1], (int)floorf( y ), t->height ),
               rgba );
        return;
    }
    float fx = floorf( x - 0.5f ), fy = floorf( y - 0.5f );
    float sx = x - 0.5f - fx, sy = y - 0.5f - fy;
    int x0 = wrap_index( ref->wrap[0], (int)fx, t->width ), x1 = wrap_index( ref->wrap[0], (int)fx + 1, t->width );
    int y0 = wrap_index( ref->wrap[1], (int)fy, t->height ), y1 = wrap_index( ref->wrap[1], (int)fy + 1, t->height );
    float a[4], b[4], c[4], d[4];
    fetch( t, x0, y0, a );
    fetch( t, x1, y0, b );
    fetch( t, x0, y1, c );
    fetch( t, x1, y1, d );
    for ( int i = 0; i < 4; ++i )
    {
        float top = a[i] * ( 1.0f - sx ) + b[i] * sx, bottom = c[i] * ( 1.0f - sx ) + d[i] * sx;
        rgba[i] = top * ( 1.0f - sy ) + bottom * sy;
    }
}

void rf_prefetch_texels( const RfTexture* t, const RfTextureRef* ref, const float at[2] )
{
    float shift = ref->nearest ? 0.0f : 0.5f;
    int x = wrap_index( ref->wrap[0], (int)floorf( to_pixels( at[0], t->width ) - shift ), t->width );
    int y = (int)floorf( to_pixels( at[1], t->height ) - shift );
    for ( int row = 0; row < ( ref->nearest ? 1 : 2 ); ++row )
    {
        size_t texel = (size_t)wrap_index( ref->wrap[1], y + row, t->height ) * (size_t)t->width + (size_t)x;
        size_t k = texel * (size_t)t->channels;
        __builtin_prefetch( t->bytes != NULL ? (const void*)( t->bytes + k ) : (const void*)( t->floats + k ) );
    }
}

float rf_texture_bound( const RfTexture* t, const RfTextureRef* ref, const float low[2], const float high[2] )
{
    int size[2] = { t->width, t->height }, first[2], count[2];
    for ( int k = 0; k < 2; ++k )
    {
        float a = low[k] * (float)size[k], b = high[k] * (float)size[k];
        if ( t->plays || !( a >= -MAX_PIXEL && b <= MAX_PIXEL && b - a < (float)MAX_SCANNED ) )
            return t->largest;
        // the 2×2 footprint of bilinear filtering, plus one texel for rounding
        first[k] = (int)floorf( a ) - 2;
        count[k] = (int)floorf( b ) + 2 - first[k] + 1;
    }
    if ( (int64_t)count[0] * count[1] > MAX_SCANNED )
        return t->largest;
    float largest = 0.0f;
    for ( int j = 0; j < count[1]; ++j )
    {
        int y = wrap_index( ref->wrap[1], first[1] + j, size[1] );
        for ( int i = 0; i < count[0]; ++i )
        {
            float rgba[4];
            fetch( t, wrap_index( ref->wrap[0], first[0] + i, size[0] ), y, rgba );
            largest = fmaxf( largest, fmaxf( rgba[0], fmaxf( rgba[1], rgba[2] ) ) );
        }
    }
    return largest;
}
