#include "image/exr_verify.h"

#include "image/half.h"

#include <string.h>

// Rounding to half has an error of up to half a unit in the last place: 2^-11 of the value, or
// 2^-25 in the subnormal range.
static bool is_half_of( float half, float value )
{
    value = rf_clamp_half( value );
    if ( isnan( value ) || isinf( value ) )
        return isnan( value ) ? isnan( half ) : half == value;
    float bound = fmaxf( 0x1p-11f * fabsf( value ), 0x1p-25f );
    return fabsf( half - value ) <= bound;
}

// The result of reading back.
typedef struct Check
{
    const RfExrChannel* channels;
    int width;
    bool same;
    size_t values; // number compared
} Check;

static void compare_line( void* user, int c, int x, int y, const float* values, int count )
{
    Check* check = user;
    const RfExrChannel* channel = check->channels + c;
    const float* source = channel->values + (size_t)channel->stride * ( (size_t)y * (size_t)check->width + (size_t)x );
    for ( int i = 0; i < count && check->same; ++i )
    {
        const float* value = source + (size_t)channel->stride * (size_t)i;
        // bits, so that NaN equals itself: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
        check->same = channel->half ? is_half_of( values[i], *value ) : memcmp( values + i, value, sizeof *value ) == 0;
    }
    check->values += (size_t)count;
}

RfResult rf_verify_exr( const RfExrStream* written, const RfExrChannel* channels, int count, const RfImage* size, RfError* error )
{
    RfExrStream stream = { .path = written->path, .fd = written->fd };
    RfExrPart part;
    RfResult result = rf_open_exr_part( &stream, 0, &part, error );
    if ( result != RF_OK )
        return result;
    const char* names[RF_EXR_MAX_CHANNELS];
    for ( int c = 0; c < count; ++c )
        names[c] = channels[c].name;
    Check check = { channels, size->width, part.width == size->width && part.height == size->height, 0 };
    if ( check.same )
        result = rf_read_exr_lines( &part, names, count, compare_line, &check, error );
    rf_close_exr_part( &part );
    if ( result != RF_OK )
        return result;
    size_t all = (size_t)size->width * (size_t)size->height * (size_t)count;
    if ( !check.same || check.values != all )
        return rf_fail( error, RF_ERROR_IO, "%s: cannot be written: what was read back differs", stream.path );
    return RF_OK;
}
