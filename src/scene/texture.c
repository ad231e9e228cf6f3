// Textures: their lookups and bounds; made of images, and of sequences of images.
#include "scene/texture.h"

#include "base/file.h"
#include "base/try.h"
#include "math/vec3.h"
#include "reframe/image.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EARLY 1e-2 // of the time of an image

static size_t value_count( const RfTexture* t ) { return (size_t)t->width * (size_t)t->height * (size_t)t->channels; }

static bool is_alpha( const RfTexture* t, size_t i )
{
    size_t channels = (size_t)t->channels;
    return channels % 2 == 0 && i % channels == channels - 1;
}

// Converts 16-bit pixels to floats.
static RfResult widen( const char* where, const RfPixels* pixels, bool srgb, RfTexture* out, RfError* error )
{
    size_t count = value_count( out );
    const uint16_t* from = pixels->data;
    out->floats = malloc( count * sizeof *out->floats );
    if ( out->floats == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory: close other programs", where );
    for ( size_t i = 0; i < count; ++i )
    {
        float value = (float)from[i] / 65535.0f;
        out->floats[i] = srgb && !is_alpha( out, i ) ? rf_srgb_to_linear( value ) : value;
    }
    return RF_OK;
}

static RfResult take_floats( const char* where, RfPixels* pixels, bool colour, RfTexture* out, RfError* error )
{
    size_t count = value_count( out ), channels = (size_t)out->channels, width = (size_t)out->width;
    out->floats = pixels->data;
    pixels->data = NULL;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( !isfinite( out->floats[i] ) )
            return rf_fail( error, RF_ERROR_SCENE, "%s: pixel (%zu, %zu) is not finite: repair the image", where,
                            i / channels % width, i / channels / width );
    }
    if ( colour && channels >= 3 )
        out->outside = rf_convert_light( &pixels->conversion, out->floats, count / channels, channels );
    for ( size_t i = 0; i < count; ++i )
        out->floats[i] = fmaxf( out->floats[i], 0.0f );
    return RF_OK;
}

static void find_largest( RfTexture* t )
{
    size_t count = value_count( t );
    for ( size_t i = 0; i < count; ++i )
    {
        if ( !is_alpha( t, i ) )
            t->largest = fmaxf( t->largest, t->bytes != NULL ? t->table[t->bytes[i]] : t->floats[i] );
    }
}

RfResult rf_make_texture( const char* where, RfPixels* pixels, bool srgb, RfTexture* out, RfError* error )
{
    *out = ( RfTexture ){ .width = pixels->width, .height = pixels->height, .channels = pixels->channels };
    for ( int i = 0; i < 256; ++i )
        out->table[i] = srgb ? rf_srgb_to_linear( (float)i / 255.0f ) : (float)i / 255.0f;
    RfResult result = RF_OK;
    if ( pixels->type == RF_PIXELS_U8 )
    {
        out->bytes = pixels->data;
        pixels->data = NULL;
    }
    else
        result = pixels->type == RF_PIXELS_U16 ? widen( where, pixels, srgb, out, error )
                                               : take_floats( where, pixels, srgb, out, error );
    if ( result == RF_OK )
        find_largest( out );
    return result;
}

void rf_destroy_texture( RfTexture* texture )
{
    free( texture->bytes );
    free( texture->floats );
    rf_drop_mip_levels( texture );
    *texture = ( RfTexture ){ 0 };
}

// Sequences.

int rf_sequence_number( const RfImageSequence* s, double time )
{
    double count = (double)s->last - (double)s->first + 1.0, shown = floor( ( time - s->start ) * s->fps + EARLY );
    if ( shown <= 0.0 )
        return s->first;
    shown = s->loops ? fmod( shown, count ) : fmin( shown, count - 1.0 );
    return s->first + (int)shown;
}

void rf_sequence_span( const RfImageSequence* s, double* start, double* end )
{
    *start = fmax( s->start, 0.0 );
    *end = fmax( s->start + ( (double)s->last - (double)s->first ) / s->fps, *start );
}

static RfResult read_image( const RfImageSequence* s, int number, char name[PATH_MAX], uint8_t** bytes, size_t* size,
                            RfError* error )
{
    RfResult result = rf_sequence_name( s->pattern, number, name, PATH_MAX, error );
    return result == RF_OK ? rf_read_file( name, RF_MAX_IMAGE_BYTES, bytes, size, error ) : result;
}

size_t rf_texture_bytes( const RfPixels* pixels )
{
    return rf_pixels_bytes( pixels ) * ( pixels->type == RF_PIXELS_U16 ? sizeof( float ) / sizeof( uint16_t ) : 1 );
}

RfResult rf_measure_sequence( RfImageSequence* s, uint64_t* hash, RfError* error )
{
    char name[PATH_MAX];
    for ( int number = s->first; number <= s->last; ++number )
    {
        uint8_t* bytes;
        size_t size;
        RfPixels header = { 0 };
        RfResult result = read_image( s, number, name, &bytes, &size, error );
        if ( result != RF_OK )
            return result;
        result = rf_measure_image( bytes, size, name, &header, error );
        *hash = rf_hash_bytes( *hash, bytes, size );
        free( bytes );
        if ( result != RF_OK )
            return result;
        size_t texture = rf_texture_bytes( &header ), scratch = size + rf_pixels_bytes( &header ) + texture;
        s->bytes = texture > s->bytes ? texture : s->bytes;
        s->scratch = scratch > s->scratch ? scratch : s->scratch;
    }
    return RF_OK;
}

RfResult rf_load_sequence_image( const RfImageSequence* s, int number, RfTexture* out, RfError* error )
{
    char name[PATH_MAX];
    uint8_t* bytes;
    size_t size;
    RfPixels pixels = { 0 };
    *out = ( RfTexture ){ 0 };
    RF_TRY( read_image( s, number, name, &bytes, &size, error ) );
    RfResult result = rf_decode_image( bytes, size, name, &pixels, error );
    free( bytes );
    if ( result == RF_OK )
        result = rf_make_texture( name, &pixels, s->srgb, out, error );
    rf_destroy_pixels( &pixels );
    if ( result == RF_OK && (double)out->largest > s->most )
        result = rf_fail( error, RF_ERROR_SCENE, "%s: has a value of %g, at most %g can be rendered: darken it", name,
                          (double)out->largest, s->most );
    if ( result != RF_OK )
        rf_destroy_texture( out );
    return result;
}

RfResult rf_place_sequence_image( const RfImageSequence* s, int number, void* memory, RfTexture* out, RfError* error )
{
    RfTexture read;
    char name[PATH_MAX];
    RfResult result = rf_load_sequence_image( s, number, &read, error );
    if ( result != RF_OK )
        return result;
    *out = read;
    const void* from = read.bytes != NULL ? (const void*)read.bytes : (const void*)read.floats;
    size_t bytes = value_count( &read ) * ( read.bytes != NULL ? 1 : sizeof( float ) );
    if ( bytes > s->bytes && rf_sequence_name( s->pattern, number, name, sizeof name, error ) == RF_OK )
        result = rf_fail( error, RF_ERROR_IO, "%s: has grown since the scene was read: render again", name );
    else
        memcpy( memory, from, bytes );
    out->bytes = read.bytes != NULL ? memory : NULL;
    out->floats = read.bytes != NULL ? NULL : memory;
    rf_destroy_texture( &read );
    return result;
}

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

// The pixels of a level.
typedef struct Level
{
    int width, height;
    const uint8_t* bytes; // or NULL; then
    const float* floats;
} Level;

static inline Level level_0( const RfTexture* t ) { return ( Level ){ t->width, t->height, t->bytes, t->floats }; }

static inline int half_of( int size ) { return size > 1 ? size / 2 : 1; }

static Level find_level( const RfTexture* t, int number )
{
    Level l = level_0( t );
    size_t at = 0;
    for ( int i = 0; i < number; ++i )
    {
        at += i > 0 ? (size_t)l.width * (size_t)l.height * (size_t)t->channels : 0;
        l.width = half_of( l.width );
        l.height = half_of( l.height );
    }
    if ( number > 0 )
    {
        l.bytes = t->bytes != NULL ? (const uint8_t*)t->levels + at : NULL;
        l.floats = t->bytes != NULL ? NULL : (const float*)t->levels + at;
    }
    return l;
}

static inline void fetch( const RfTexture* t, const Level* l, int x, int y, float rgba[4] )
{
    size_t at = ( (size_t)y * (size_t)l->width + (size_t)x ) * (size_t)t->channels;
    int colours = t->channels < 3 ? 1 : 3;
    bool alpha = t->channels == 2 || t->channels == 4;
    for ( int c = 0; c < 3; ++c )
    {
        size_t k = at + (size_t)( colours == 3 ? c : 0 );
        rgba[c] = l->bytes != NULL ? t->table[l->bytes[k]] : l->floats[k];
    }
    size_t k = at + (size_t)colours;
    rgba[3] = !alpha ? 1.0f : l->bytes != NULL ? (float)l->bytes[k] * ( 1.0f / 255.0f ) : l->floats[k];
}

static float to_pixels( float u, int size )
{
    float x = u * (float)size;
    return fabsf( x ) <= MAX_PIXEL ? x : 0.0f; // also false for NaN
}

static void look_up_level( const RfTexture* t, const RfTextureRef* ref, const Level* l, const float at[2], float rgba[4] )
{
    float x = to_pixels( at[0], l->width ), y = to_pixels( at[1], l->height );
    if ( ref->nearest )
    {
        fetch( t, l, wrap_index( ref->wrap[0], (int)floorf( x ), l->width ),
               wrap_index( ref->wrap[1], (int)floorf( y ), l->height ), rgba );
        return;
    }
    float fx = floorf( x - 0.5f ), fy = floorf( y - 0.5f );
    float sx = x - 0.5f - fx, sy = y - 0.5f - fy;
    int x0 = wrap_index( ref->wrap[0], (int)fx, l->width ), x1 = wrap_index( ref->wrap[0], (int)fx + 1, l->width );
    int y0 = wrap_index( ref->wrap[1], (int)fy, l->height ), y1 = wrap_index( ref->wrap[1], (int)fy + 1, l->height );
    float a[4], b[4], c[4], d[4];
    fetch( t, l, x0, y0, a );
    fetch( t, l, x1, y0, b );
    fetch( t, l, x0, y1, c );
    fetch( t, l, x1, y1, d );
    for ( int i = 0; i < 4; ++i )
    {
        float top = a[i] * ( 1.0f - sx ) + b[i] * sx, bottom = c[i] * ( 1.0f - sx ) + d[i] * sx;
        rgba[i] = top * ( 1.0f - sy ) + bottom * sy;
    }
}

void rf_look_up( const RfTexture* t, const RfTextureRef* ref, const float at[2], float level, float rgba[4] )
{
    if ( !( level > 0.0f ) || ref->nearest || t->levels == NULL )
    {
        Level image = level_0( t );
        look_up_level( t, ref, &image, at, rgba );
        return;
    }
    int below = level < (float)( t->level_count - 1 ) ? (int)level : t->level_count - 1;
    int above = below + 1 < t->level_count ? below + 1 : below;
    Level fine = find_level( t, below ), coarse = find_level( t, above );
    float far[4], share = above > below ? level - (float)below : 0.0f;
    look_up_level( t, ref, &fine, at, rgba );
    look_up_level( t, ref, &coarse, at, far );
    for ( int i = 0; i < 4; ++i )
        rgba[i] += share * ( far[i] - rgba[i] );
}

float rf_mip_level( const RfTexture* t, double area )
{
    double pixels = area * (double)t->width * (double)t->height;
    return pixels > 1.0 ? 0.5f * (float)log2( pixels ) : 0.0f;
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
    Level image = level_0( t );
    float largest = 0.0f;
    for ( int j = 0; j < count[1]; ++j )
    {
        int y = wrap_index( ref->wrap[1], first[1] + j, size[1] );
        for ( int i = 0; i < count[0]; ++i )
        {
            float rgba[4];
            fetch( t, &image, wrap_index( ref->wrap[0], first[0] + i, size[0] ), y, rgba );
            largest = fmaxf( largest, fmaxf( rgba[0], fmaxf( rgba[1], rgba[2] ) ) );
        }
    }
    return largest;
}

// Mip levels.

// Along one axis, pixel `to` of a level covers those of the one before from `first` on, by weights that add up to 1.
typedef struct Cover
{
    int first, count; // 1 to 3, and 4 at most by rounding
    float weight[4];
} Cover;

static Cover cover( int from, int to, int i )
{
    double scale = (double)from / (double)to, low = (double)i * scale, high = low + scale;
    Cover c = { .first = (int)low };
    for ( int k = 0; k < 4 && c.first + k < from; ++k )
    {
        double at = (double)( c.first + k ), begin = at > low ? at : low, end = at + 1.0 < high ? at + 1.0 : high;
        if ( end - begin <= 1e-9 )
            break;
        c.weight[c.count++] = (float)( ( end - begin ) / scale );
    }
    return c;
}

// Turns values into bytes: where the search in a texture's ascending table begins, by the value.
#define GUESSES 4096
typedef struct Encoder
{
    const float* table;
    uint8_t guess[GUESSES + 1]; // the first byte of at least a value of i / GUESSES
} Encoder;

static void make_encoder( const RfTexture* t, Encoder* out )
{
    out->table = t->table;
    int byte = 0;
    for ( int i = 0; i <= GUESSES; ++i )
    {
        while ( byte < 255 && t->table[byte] < (float)i / GUESSES )
            ++byte;
        out->guess[i] = (uint8_t)byte;
    }
}

// The byte whose value is nearest.
static inline uint8_t encode( const Encoder* e, float value )
{
    int high = e->guess[(int)( rf_clampf( value, 0.0f, 1.0f ) * GUESSES )];
    while ( high < 255 && e->table[high] < value )
        ++high;
    return (uint8_t)( high > 0 && value - e->table[high - 1] < e->table[high] - value ? high - 1 : high );
}

static void make_pixel( const RfTexture* t, const Level* from, const Cover* across, const Cover* down, float sum[4] )
{
    memset( sum, 0, 4 * sizeof *sum );
    for ( int j = 0; j < down->count; ++j )
    {
        for ( int i = 0; i < across->count; ++i )
        {
            float rgba[4], weight = down->weight[j] * across->weight[i];
            fetch( t, from, across->first + i, down->first + j, rgba );
            for ( int c = 0; c < 4; ++c )
                sum[c] += weight * rgba[c];
        }
    }
}

static void store_pixel( const RfTexture* t, const Encoder* e, const float rgba[4], size_t at )
{
    int colours = t->channels < 3 ? 1 : 3;
    for ( int c = 0; c < t->channels; ++c )
    {
        float value = c < colours ? rgba[c] : rgba[3];
        if ( t->bytes == NULL )
            ( (float*)t->levels )[at + (size_t)c] = value;
        else
            ( (uint8_t*)t->levels )[at + (size_t)c] = c < colours ? encode( e, value ) : (uint8_t)( value * 255.0f + 0.5f );
    }
}

void rf_drop_mip_levels( RfTexture* t )
{
    free( t->levels );
    t->levels = NULL;
    t->level_count = 0;
}

// A level of bytes whose pixels cover 2×2 of the one before, without alpha: what most are, and large ones alone take time.
static void halve_colours( const RfTexture* t, const Encoder* e, const Level* from, int width, int height, uint8_t* out )
{
    size_t channels = (size_t)t->channels, row = (size_t)from->width * channels;
    for ( int y = 0; y < height; ++y )
    {
        const uint8_t *above = from->bytes + 2 * (size_t)y * row, *below = above + row;
        for ( size_t x = 0; x < (size_t)width; ++x, above += 2 * channels, below += 2 * channels )
        {
            for ( size_t c = 0; c < channels; ++c )
                *out++ = encode( e, 0.25f * ( t->table[above[c]] + t->table[above[c + channels]] + t->table[below[c]] +
                                              t->table[below[c + channels]] ) );
        }
    }
}

// A level from the one before.
static void make_level( const RfTexture* t, const Encoder* e, const Level* from, int width, int height, size_t at )
{
    if ( t->bytes != NULL && t->channels % 2 == 1 && from->width == 2 * width && from->height == 2 * height )
    {
        halve_colours( t, e, from, width, height, (uint8_t*)t->levels + at );
        return;
    }
    for ( int y = 0; y < height; ++y )
    {
        Cover down = cover( from->height, height, y );
        for ( int x = 0; x < width; ++x, at += (size_t)t->channels )
        {
            Cover across = cover( from->width, width, x );
            float rgba[4];
            make_pixel( t, from, &across, &down, rgba );
            store_pixel( t, e, rgba, at );
        }
    }
}

bool rf_make_mip_levels( RfTexture* t )
{
    size_t values = 0;
    int count = 1;
    for ( int w = t->width, h = t->height; w > 1 || h > 1; ++count )
    {
        w = half_of( w );
        h = half_of( h );
        values += (size_t)w * (size_t)h * (size_t)t->channels;
    }
    if ( count == 1 )
        return true;
    t->levels = malloc( values * ( t->bytes != NULL ? 1 : sizeof( float ) ) );
    if ( t->levels == NULL )
        return false;
    t->level_count = count;
    Encoder encoder;
    make_encoder( t, &encoder );
    size_t at = 0;
    for ( int number = 1; number < count; ++number )
    {
        Level from = find_level( t, number - 1 );
        int width = half_of( from.width ), height = half_of( from.height );
        make_level( t, &encoder, &from, width, height, at );
        at += (size_t)width * (size_t)height * (size_t)t->channels;
    }
    return true;
}
